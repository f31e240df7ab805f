#include "collab/dds/security/openssl.h"

#include <array>
#include <cerrno>
#include <cstring>

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "engine/realtime/private_process.h"

namespace tandem {
namespace {

constexpr std::array kPrograms{"/usr/bin/openssl", "/usr/local/bin/openssl", "/bin/openssl"};

std::string ReadAll(int descriptor) {
  std::string all;
  std::array<char, 4096> buffer;
  ssize_t size = 0;
  while ((size = read(descriptor, buffer.data(), buffer.size())) > 0) {
    all.append(buffer.data(), static_cast<std::size_t>(size));
  }
  return all;
}

}  // namespace

Result<std::string> Openssl(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "openssl");
  std::vector<char*> argv;
  for (std::string& word : arguments) argv.push_back(word.data());
  argv.push_back(nullptr);

  // the caller's settings, engines and libraries do not apply where keys are made, only the
  // system's
  std::string path = "PATH=/usr/bin:/bin";
  std::string language = "LC_ALL=C";
  const std::array<char*, 3> environment{path.data(), language.data(), nullptr};
  std::array<int, 2> out{};
  if (pipe2(out.data(), O_CLOEXEC) != 0) return Error{std::strerror(errno)};
  const pid_t child = fork();
  if (child < 0) return Error{std::string("openssl cannot be started: ") + std::strerror(errno)};
  if (child == 0) {
    // only calls that are safe between fork and exec
    const int nothing = open("/dev/null", O_RDONLY | O_CLOEXEC);
    dup2(nothing, STDIN_FILENO);
    dup2(out[1], STDOUT_FILENO);
    dup2(out[1], STDERR_FILENO);
    CloseOthersOnExec();
    for (const char* program : kPrograms) execve(program, argv.data(), environment.data());
    _exit(127);
  }
  close(out[1]);
  std::string output = ReadAll(out[0]);
  close(out[0]);
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return output;
  if (WIFEXITED(status) && WEXITSTATUS(status) == 127) {
    return Error{"the program openssl is missing: as root, apt-get install openssl"};
  }
  while (!output.empty() && output.back() == '\n') output.pop_back();
  return Error{"openssl " + arguments[1] + ": " + output.substr(output.rfind('\n') + 1)};
}

Result<std::string> PublicKeyOf(const std::filesystem::path& certificate) {
  return Openssl({"x509", "-in", certificate.string(), "-noout", "-pubkey"});
}

}  // namespace tandem
