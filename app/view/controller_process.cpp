#include "app/view/controller_process.h"

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <thread>

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "app/program_folders.h"
#include "app/stop_signal.h"

namespace tandem {

namespace {

constexpr std::chrono::milliseconds kEndStep{10};
constexpr std::chrono::milliseconds kEndPatience{3000};   // for each signal
constexpr std::chrono::milliseconds kQuitPatience{5000};  // without one

/// The last line of a file, without what the program calls itself.
std::string LastLineOf(const std::filesystem::path& file) {
  std::ifstream stream(file);
  std::string last;
  for (std::string line; std::getline(stream, line);) {
    if (!line.empty()) last = line;
  }
  constexpr std::string_view kProgram = "tandem: ";
  return last.rfind(kProgram, 0) == 0 ? last.substr(kProgram.size()) : last;
}

class StartedPeer : public ControllerProcess {
 public:
  StartedPeer(pid_t pid, std::filesystem::path log) : pid_(pid), log_(std::move(log)) {}

  ~StartedPeer() override {
    for (const int signal : {SIGTERM, SIGKILL}) {
      if (!Gone()) kill(pid_, signal);
      WaitFor(kEndPatience);
    }
    std::error_code ignored;
    std::filesystem::remove(log_, ignored);
  }

  void AwaitEnd() override { WaitFor(kQuitPatience); }

  std::optional<std::string> Ended() override {
    if (!Gone()) return std::nullopt;
    if (WIFSIGNALED(status_)) {
      return "the controller was ended by signal " + std::to_string(WTERMSIG(status_)) +
             ": open the scene again";
    }
    const std::string line = LastLine();
    const std::string code =
        "the controller ended with code " + std::to_string(WEXITSTATUS(status_));
    return line.empty() ? code : code + ": " + line;
  }

  std::string LastLine() override { return LastLineOf(log_); }

 private:
  void WaitFor(std::chrono::milliseconds patience) {
    for (auto waited = std::chrono::milliseconds(0); waited < patience && !Gone();
         waited += kEndStep) {
      StillEnding();
      std::this_thread::sleep_for(kEndStep);
    }
  }
  bool Gone() {
    if (!ended_) ended_ = waitpid(pid_, &status_, WNOHANG) == pid_;
    return ended_;
  }

  pid_t pid_;
  std::filesystem::path log_;
  bool ended_ = false;
  int status_ = 0;
};

}  // namespace

Result<std::unique_ptr<ControllerProcess>> LaunchController(const HandRequest& request) {
  std::vector<std::string> words{(ProgramFolder() / "tandem").string()};
  for (const std::string& word : PeerWords(request)) words.push_back(word);
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  std::string log = (std::filesystem::temp_directory_path() / "tandem-controller-XXXXXX").string();
  const int output = mkostemp(log.data(), O_CLOEXEC);
  if (output < 0) return Error{log + ": " + std::strerror(errno)};
  const int nothing = open("/dev/null", O_RDONLY | O_CLOEXEC);
  const pid_t pid = fork();
  if (pid == 0) {
    // only what is safe between fork and exec
    setsid();
    dup2(nothing, STDIN_FILENO);
    dup2(output, STDOUT_FILENO);
    dup2(output, STDERR_FILENO);
    execv(argv[0], argv.data());
    _exit(127);
  }
  const int fault = errno;
  close(output);
  close(nothing);
  if (pid < 0) return Error{words[0] + ": cannot be started: " + std::strerror(fault)};
  return std::unique_ptr<ControllerProcess>(std::make_unique<StartedPeer>(pid, log));
}

}  // namespace tandem
