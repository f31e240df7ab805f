#include "app/view/controller_process.h"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <sstream>
#include <thread>

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "app/program_folders.h"
#include "app/stop_signal.h"

namespace tandem {

namespace {

constexpr std::chrono::milliseconds kEndStep{10};
constexpr std::chrono::milliseconds kEndPatience{3000};   // for each signal
constexpr std::chrono::milliseconds kQuitPatience{5000};  // without one
// where a signal ends this program, which must not take longer than a second
constexpr std::chrono::milliseconds kHastyPatience{500};

bool IsEndedBySignal() {
  return StopAskedWithin(std::chrono::nanoseconds(0));
}

/// Returns the last line of a file, without what the program calls itself. The child that writes
/// the file shares its position, which stays where it is.
std::string LastLineOf(int file) {
  constexpr off_t kMost = 4096;  // bytes at the end, more than any line of ours has
  struct stat of_file {};
  if (fstat(file, &of_file) != 0) return {};
  std::string end(static_cast<std::size_t>(std::min(of_file.st_size, kMost)), '\0');
  const off_t begin = of_file.st_size - static_cast<off_t>(end.size());
  const ssize_t read = pread(file, end.data(), end.size(), begin);
  end.resize(static_cast<std::size_t>(std::max<ssize_t>(read, 0)));
  std::istringstream stream(end);
  std::string last;
  for (std::string line; std::getline(stream, line);) {
    if (!line.empty()) last = line;
  }
  constexpr std::string_view kProgram = "tandem: ";
  return last.rfind(kProgram, 0) == 0 ? last.substr(kProgram.size()) : last;
}

class StartedPeer : public ControllerProcess {
 public:
  /// `log` is closed with this.
  StartedPeer(pid_t pid, int log) : pid_(pid), log_(log) {}

  ~StartedPeer() override {
    if (!Gone()) kill(pid_, SIGTERM);
    WaitFor(kEndPatience, kHastyPatience);
    // in haste one that runs is left to its own end, which is as near; one that is stopped has none
    if (!Gone() && (!IsEndedBySignal() || IsStopped())) {
      kill(pid_, SIGKILL);
      WaitFor(kEndPatience, kHastyPatience);
    }
    close(log_);
  }

  void AwaitEnd() override { WaitFor(kQuitPatience, std::chrono::milliseconds(0)); }

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
  /// Waits for its end. `hasty`: the patience where a signal ends this program.
  void WaitFor(std::chrono::milliseconds patience, std::chrono::milliseconds hasty) {
    const auto begun = std::chrono::steady_clock::now();
    while (!Gone()) {
      const auto waited = std::chrono::steady_clock::now() - begun;
      if (waited >= (IsEndedBySignal() ? hasty : patience)) return;
      StillEnding();
      std::this_thread::sleep_for(kEndStep);
    }
  }
  /// Whether somebody has stopped it, as by SIGSTOP: it hears no signal then but SIGKILL.
  bool IsStopped() {
    siginfo_t facts{};
    return waitid(P_PID, static_cast<id_t>(pid_), &facts, WSTOPPED | WNOHANG | WNOWAIT) == 0 &&
           facts.si_pid == pid_;
  }
  bool Gone() {
    if (!ended_) ended_ = waitpid(pid_, &status_, WNOHANG) == pid_;
    return ended_;
  }

  pid_t pid_;
  int log_;
  bool ended_ = false;
  int status_ = 0;
};

/// Opens a file without a name, of which nothing is left however the programs end that have it
/// open.
Result<int> OpenNameless() {
  std::error_code failed;
  const std::filesystem::path folder = std::filesystem::temp_directory_path(failed);
  if (failed) {
    return Error{"no temporary file can be made: " + failed.message() +
                 ": let TMPDIR name a folder that you may write to"};
  }
  std::string name = (folder / "tandem-controller-XXXXXX").string();
  const int file = mkostemp(name.data(), O_CLOEXEC | O_APPEND);
  if (file < 0) {
    return Error{name + ": " + std::strerror(errno) +
                 ": let TMPDIR name a folder that you may write to"};
  }
  unlink(name.c_str());
  return file;
}

}  // namespace

Result<std::unique_ptr<ControllerProcess>> LaunchController(const HandRequest& request) {
  std::vector<std::string> words{(ProgramFolder() / "tandem").string()};
  for (const std::string& word : PeerWords(request)) words.push_back(word);
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  const Result<int> output = OpenNameless();
  if (!output) return output.error();
  const int nothing = open("/dev/null", O_RDONLY | O_CLOEXEC);
  const pid_t pid = fork();
  if (pid == 0) {
    // only what is safe between fork and exec
    setsid();
    dup2(nothing, STDIN_FILENO);
    dup2(output.value(), STDOUT_FILENO);
    dup2(output.value(), STDERR_FILENO);
    execv(argv[0], argv.data());
    _exit(127);
  }
  const int fault = errno;
  close(nothing);
  if (pid < 0) {
    close(output.value());
    return Error{words[0] + ": cannot be started: " + std::strerror(fault)};
  }
  return std::unique_ptr<ControllerProcess>(std::make_unique<StartedPeer>(pid, output.value()));
}

}  // namespace tandem
