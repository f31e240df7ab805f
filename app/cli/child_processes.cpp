#include "app/cli/child_processes.h"

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <thread>
#include <utility>

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "engine/base/check.h"

namespace tandem {

namespace {
constexpr std::chrono::milliseconds kPollPeriod{5};
constexpr std::chrono::milliseconds kGrace{3000};  // between SIGTERM and SIGKILL
}  // namespace

Result<ChildProcess> ChildProcess::Start(const std::vector<std::string>& command, int keep) {
  std::vector<char*> argv;
  for (const std::string& word : command) argv.push_back(const_cast<char*>(word.c_str()));
  argv.push_back(nullptr);
  const pid_t parent = getpid();
  const pid_t pid = fork();
  if (pid < 0) return Error{command[0] + ": cannot be started: " + std::strerror(errno)};
  if (pid == 0) {
    // only what is safe between fork and exec
    prctl(PR_SET_PDEATHSIG, SIGTERM);
    if (getppid() != parent) _exit(127);
    dup2(STDERR_FILENO, STDOUT_FILENO);
    if (keep >= 0) fcntl(keep, F_SETFD, 0);
    execv(argv[0], argv.data());
    _exit(127);
  }
  return ChildProcess(pid);
}

ChildProcess::ChildProcess(ChildProcess&& other) noexcept
    : pid_(std::exchange(other.pid_, -1)), ended_(other.ended_) {}

ChildProcess::~ChildProcess() {
  if (pid_ < 0 || Poll()) return;
  Signal(SIGTERM);
  if (Wait(kGrace)) return;
  Signal(SIGKILL);
  waitpid(pid_, nullptr, 0);
}

std::optional<int> ChildProcess::Poll() {
  if (ended_) return ended_;
  int status = 0;
  if (waitpid(pid_, &status, WNOHANG) == pid_) {
    ended_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }
  return ended_;
}

std::optional<int> ChildProcess::Wait(std::chrono::milliseconds timeout) {
  for (auto waited = std::chrono::milliseconds(0); !Poll() && waited < timeout;
       waited += kPollPeriod) {
    std::this_thread::sleep_for(kPollPeriod);
  }
  return Poll();
}

void ChildProcess::Signal(int signal) const noexcept {
  if (pid_ > 0 && !ended_) kill(pid_, signal);
}

HalfOfTheCores::HalfOfTheCores(Half half) {
  sched_getaffinity(0, sizeof before_, &before_);
  const int count = CPU_COUNT(&before_);
  if (count < 4) return;
  cpu_set_t wanted;
  CPU_ZERO(&wanted);
  int seen = 0;
  for (int core = 0; core < CPU_SETSIZE; ++core) {
    if (!CPU_ISSET(core, &before_)) continue;
    if ((seen++ < count / 2) == (half == Half::kFirst)) CPU_SET(core, &wanted);
  }
  sched_setaffinity(0, sizeof wanted, &wanted);
}

HalfOfTheCores::~HalfOfTheCores() {
  sched_setaffinity(0, sizeof before_, &before_);
}

TemporaryFolder::TemporaryFolder() {
  std::string name = (std::filesystem::temp_directory_path() / "tandem-XXXXXX").string();
  TANDEM_CHECK(mkdtemp(name.data()) != nullptr);
  path_ = name;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;  // a folder left behind is no fault of the run
  std::filesystem::remove_all(path_, ignored);
}

}  // namespace tandem
