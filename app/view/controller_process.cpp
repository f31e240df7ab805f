#include "app/view/controller_process.h"

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <thread>
#include <utility>

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "app/common/describe_signal.h"
#include "app/common/program_folders.h"
#include "app/common/stop_signal.h"
#include "app/view/model/hand/controller_log.h"
#include "engine/realtime/private_process.h"

namespace tandem {

namespace {

constexpr std::chrono::milliseconds kEndStep{10};
constexpr std::chrono::milliseconds kEndPatience{3000};   // for each signal
constexpr std::chrono::milliseconds kQuitPatience{5000};  // without a signal
// while a signal ends this program, which must not take longer than a second
constexpr std::chrono::milliseconds kHastyPatience{500};

bool IsEndedBySignal() {
  return StopRequestedWithin(std::chrono::nanoseconds(0));
}

class StartedPeer : public ControllerProcess {
 public:
  StartedPeer(pid_t pid, ControllerLog log) : pid_(pid), log_(std::move(log)) {}

  ~StartedPeer() override {
    if (!Gone()) kill(pid_, SIGTERM);
    WaitFor(kEndPatience, kHastyPatience);
    // in haste a running controller is left to end by itself, and only a stopped one is killed
    if (!Gone() && (!IsEndedBySignal() || IsStopped())) {
      kill(pid_, SIGKILL);
      WaitFor(kEndPatience, kHastyPatience);
    }
  }

  void AwaitEnd() override { WaitFor(kQuitPatience, std::chrono::milliseconds(0)); }

  std::optional<std::string> Ended() override {
    log_.Bound();
    if (!Gone()) return std::nullopt;
    if (WIFSIGNALED(status_)) {
      return "the program behind your hand " + DescribeSignal(WTERMSIG(status_)) +
             ": your hand has let go";
    }
    const std::string line = LastLine();
    return "the program behind your hand has ended: " +
           (line.empty()
                ? "it gives no reason (exit code " + std::to_string(WEXITSTATUS(status_)) + ")"
                : line);
  }

  std::string LastLine() override { return log_.LastLine(); }
  void MarkOutput() override { log_.Mark(); }
  std::vector<std::string> LinesSinceMark() override { return log_.LinesSinceMark(); }

 private:
  /// Waits for the process to end. `hasty`: the patience while a signal ends this program.
  void WaitFor(std::chrono::milliseconds patience, std::chrono::milliseconds hasty) {
    const auto begun = std::chrono::steady_clock::now();
    while (!Gone()) {
      const auto waited = std::chrono::steady_clock::now() - begun;
      if (waited >= (IsEndedBySignal() ? hasty : patience)) return;
      SayStillEnding();
      std::this_thread::sleep_for(kEndStep);
    }
  }
  /// Returns whether the process is stopped, as by SIGSTOP. Then only SIGKILL reaches it.
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
  ControllerLog log_;
  bool ended_ = false;
  int status_ = 0;
};

}  // namespace

Result<std::unique_ptr<ControllerProcess>> LaunchController(const HandRequest& request) {
  std::vector<std::string> words{(ProgramFolder() / "tandem").string()};
  for (const std::string& word : ControllerCommandLine(request)) words.push_back(word);
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  Result<ControllerLog> output = ControllerLog::Open();
  if (!output) return output.error();
  const int nothing = open("/dev/null", O_RDONLY | O_CLOEXEC);
  const pid_t pid = fork();
  if (pid == 0) {
    // only calls that are safe between fork and exec
    setsid();
    dup2(nothing, STDIN_FILENO);
    dup2(output->descriptor(), STDOUT_FILENO);
    dup2(output->descriptor(), STDERR_FILENO);
    CloseOthersOnExec();
    execv(argv[0], argv.data());
    _exit(127);
  }
  const int fault = errno;
  close(nothing);
  if (pid < 0) return Error{words[0] + ": cannot be started: " + std::strerror(fault)};
  return std::unique_ptr<ControllerProcess>(std::make_unique<StartedPeer>(pid, *std::move(output)));
}

}  // namespace tandem
