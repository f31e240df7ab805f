#include "app/process/child_processes.h"

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <system_error>
#include <thread>
#include <utility>

#include <fcntl.h>
#include <spawn.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "app/common/console.h"
#include "app/common/exit_codes.h"
#include "engine/base/files/regular_file.h"
#include "engine/realtime/private_process.h"

namespace tandem {

namespace {
constexpr std::chrono::milliseconds kPollPeriod{5};
constexpr std::chrono::milliseconds kGrace{3000};  // from SIGTERM to SIGKILL
}  // namespace

Result<ChildProcess> ChildProcess::Start(const std::vector<std::string>& command, int keep) {
  std::vector<char*> argv;
  for (const std::string& word : command) argv.push_back(const_cast<char*>(word.c_str()));
  argv.push_back(nullptr);
  const pid_t parent = getpid();
  const pid_t pid = fork();
  if (pid < 0) return Error{command[0] + ": cannot be started: " + std::strerror(errno)};
  if (pid == 0) {
    // only calls that are safe between fork and exec
    prctl(PR_SET_PDEATHSIG, SIGTERM);
    if (getppid() != parent) _exit(127);
    dup2(STDERR_FILENO, STDOUT_FILENO);
    CloseOthersOnExec();
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
  std::error_code failed;
  const std::filesystem::path parent = std::filesystem::temp_directory_path(failed);
  std::string name = (parent / "tandem-XXXXXX").string();
  if (!failed && mkdtemp(name.data()) == nullptr) {
    failed = {errno, std::generic_category()};
  }
  if (failed) {
    const char* const given = std::getenv("TMPDIR");
    const std::string where = !parent.empty() ? parent.string() : given != nullptr ? given : "/tmp";
    // no caller can go on without the folder
    std::exit(Fail(kExitFile, PlainLine(where) +
                                  ": no temporary folder can be made there: " + failed.message() +
                                  ": let TMPDIR name a folder that you may write to"));
  }
  path_ = name;
  StartGuardian();
  removal_.emplace([path = path_] {
    std::error_code ignored;
    std::filesystem::remove_all(path, ignored);
  });
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;  // a folder left behind is no fault of the run
  std::filesystem::remove_all(path_, ignored);
  removal_.reset();
  if (lifeline_ >= 0) {
    // the line tells the guardian that all is done
    const ssize_t written = write(lifeline_, "\n", 1);
    static_cast<void>(written);
    close(lifeline_);
  }
  if (guardian_ > 0) waitpid(guardian_, nullptr, 0);
}

// Starts the guardian, a process in a session of its own, which Ctrl-C does not reach. It removes
// the folder twice, because programs that we started end within seconds of us and may write until
// then.
void TemporaryFolder::StartGuardian() {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) return;
  const char* const script =
      "trap '' HUP INT TERM; read -r line && exit 0; rm -rf -- \"$1\"; sleep 5; rm -rf -- \"$1\"";
  const std::string path = path_.string();
  std::array<char*, 6> argv{const_cast<char*>("sh"),         const_cast<char*>("-c"),
                            const_cast<char*>(script),       const_cast<char*>("sh"),
                            const_cast<char*>(path.c_str()), nullptr};
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_adddup2(&files, ends[0], STDIN_FILENO);
  for (const int fd : {STDOUT_FILENO, STDERR_FILENO}) {
    posix_spawn_file_actions_addopen(&files, fd, "/dev/null", O_WRONLY, 0);
  }
  // the guardian must not keep pipes of other programs open
  posix_spawn_file_actions_addclosefrom_np(&files, STDERR_FILENO + 1);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSID);
  if (posix_spawn(&guardian_, "/bin/sh", &files, &attributes, argv.data(), environ) != 0) {
    guardian_ = -1;
  }
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&files);
  close(ends[0]);
  lifeline_ = ends[1];
}

}  // namespace tandem
