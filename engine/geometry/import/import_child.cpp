#include "engine/geometry/import/import_child.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string_view>
#include <vector>

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/timerfd.h>
#include <sys/wait.h>
#include <unistd.h>

#include "engine/base/check.h"
#include "engine/base/sanitized.h"

namespace tandem {
namespace {

constexpr std::string_view kHelperName = "import-helper";
constexpr int kAnswerFd = 3;      // in the reading process
constexpr double kLongest = 1e6;  // s

// Tells whether main() can answer as a reading process; else starting one would start the program
// itself.
std::atomic<bool> main_asks_for_import_job{false};

class Fd {
 public:
  explicit Fd(int fd) : fd_(fd) {}
  ~Fd() { Close(); }
  Fd(const Fd&) = delete;
  Fd& operator=(const Fd&) = delete;
  void Close() {
    if (fd_ >= 0) close(fd_);
    fd_ = -1;
  }
  int get() const { return fd_; }

 private:
  int fd_;
};

/// Returns a timer that can be polled, and that becomes readable once when `seconds` are over.
int StartTimer(double seconds) {
  const int fd = timerfd_create(CLOCK_MONOTONIC, TFD_CLOEXEC);
  if (fd < 0) return fd;
  itimerspec when{};
  when.it_value.tv_sec = static_cast<time_t>(seconds);
  when.it_value.tv_nsec = std::max(1L, static_cast<long>((seconds - std::floor(seconds)) * 1e9));
  timerfd_settime(fd, 0, &when, nullptr);
  return fd;
}

/// Waits until `fd` has something to read or has ended; false: the timer was faster.
bool WaitFor(int fd, int timer) {
  std::array<pollfd, 2> fds{{{fd, POLLIN, 0}, {timer, POLLIN, 0}}};
  while (poll(fds.data(), fds.size(), -1) < 0 && errno == EINTR) {
  }
  return fds[1].revents == 0;
}

/// Returns the environment that a reading process needs: where its libraries are, and a sanitizer's
/// options. It has nothing that puts other code into the process.
std::vector<std::string> KeptOfTheEnvironment() {
  constexpr std::array<std::string_view, 5> kKept{
      "LD_LIBRARY_PATH=", "ASAN_OPTIONS=", "UBSAN_OPTIONS=", "TSAN_OPTIONS=", "LSAN_OPTIONS="};
  std::vector<std::string> kept;
  for (char** variable = environ; variable != nullptr && *variable != nullptr; ++variable) {
    const std::string_view text = *variable;
    const auto begins = [text](std::string_view name) {
      return text.starts_with(name);
    };
    if (std::ranges::any_of(kKept, begins)) kept.emplace_back(text);
  }
  return kept;
}

/// Starts the process with posix_spawn, because a program with threads may do almost nothing
/// between fork and exec.
int Spawn(const std::filesystem::path& file, std::string part, const ImportLimits& limits,
          int answer_fd, pid_t* pid) {
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  for (const int fd : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    posix_spawn_file_actions_addopen(&files, fd, "/dev/null", O_RDWR, 0);
  }
  posix_spawn_file_actions_adddup2(&files, answer_fd, kAnswerFd);
  posix_spawn_file_actions_addclosefrom_np(&files, kAnswerFd + 1);

  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
  sigset_t none;
  sigemptyset(&none);
  posix_spawnattr_setsigmask(&attributes, &none);
  sigset_t ours;
  sigemptyset(&ours);
  for (const int signal : {SIGPIPE, SIGINT, SIGTERM, SIGHUP, SIGCHLD, SIGXCPU, SIGSEGV, SIGABRT}) {
    sigaddset(&ours, signal);
  }
  posix_spawnattr_setsigdefault(&attributes, &ours);

  // whole numbers, because a locale may write a comma
  std::string milliseconds = std::to_string(std::llround(std::ceil(limits.seconds * 1e3)));
  std::string bytes = std::to_string(limits.memory_bytes);
  std::string path = file.native();
  std::string name = "tandem-import";
  std::string helper(kHelperName);
  const std::array<char*, 7> argv{name.data(),  helper.data(), milliseconds.data(),
                                  bytes.data(), path.data(),   part.data(),
                                  nullptr};
  std::vector<std::string> kept = KeptOfTheEnvironment();
  std::vector<char*> environment;
  for (std::string& variable : kept) environment.push_back(variable.data());
  environment.push_back(nullptr);
  const int error =
      posix_spawn(pid, "/proc/self/exe", &files, &attributes, argv.data(), environment.data());
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&files);
  return error;
}

/// Ends the process if it still runs, and reaps it. Returns its wait status, 0 if another thread
/// reaped it.
int Reap(pid_t pid, bool kill_first) {
  if (kill_first) kill(pid, SIGKILL);
  int status = 0;
  pid_t reaped = 0;
  do {
    reaped = waitpid(pid, &status, 0);
  } while (reaped < 0 && errno == EINTR);
  return reaped == pid ? status : 0;
}

}  // namespace

ImportChildRun RunImportChild(const std::filesystem::path& file, const std::string& part,
                              const ImportLimits& limits) {
  using End = ImportChildRun::End;
  TANDEM_CHECK(main_asks_for_import_job);
  TANDEM_CHECK(limits.seconds > 0 && limits.memory_bytes > 0);
  const ImportLimits within{std::min(limits.seconds, kLongest), limits.memory_bytes};

  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) return {End::kNotStarted, errno, {}};
  const Fd read_end(ends[0]);
  Fd write_end(ends[1]);
  const Fd timer(StartTimer(within.seconds));
  if (timer.get() < 0) return {End::kNotStarted, errno, {}};
  pid_t pid = -1;
  if (const int error = Spawn(file, part, within, write_end.get(), &pid); error != 0) {
    return {End::kNotStarted, error, {}};
  }
  write_end.Close();

  std::string answer;
  std::size_t used = 0;
  while (true) {
    if (!WaitFor(read_end.get(), timer.get())) {
      Reap(pid, true);
      return {End::kTooLate, 0, {}};
    }
    if (used == answer.size()) answer.resize(std::max<std::size_t>(1 << 16, 2 * used));
    const ssize_t size = read(read_end.get(), answer.data() + used, answer.size() - used);
    if (size < 0 && errno == EINTR) continue;
    if (size <= 0) break;
    used += static_cast<std::size_t>(size);
    if (used > within.memory_bytes) {
      Reap(pid, true);
      return {End::kTooMuchSaid, 0, {}};
    }
  }
  answer.resize(used);

  // The answer is complete; only the way it ends is missing. Where pidfds are forbidden there is no
  // wait for it.
  const Fd process(static_cast<int>(syscall(SYS_pidfd_open, pid, 0)));
  const bool ended = process.get() >= 0 && WaitFor(process.get(), timer.get());
  const int status = Reap(pid, !ended);
  if (ended && WIFSIGNALED(status)) {
    return {End::kKilledBySignal, WTERMSIG(status), std::move(answer)};
  }
  return {End::kExited, ended && WIFEXITED(status) ? WEXITSTATUS(status) : 0, std::move(answer)};
}

std::optional<ImportJob> ImportJobOf(int argc, char** argv) {
  main_asks_for_import_job = true;
  if (argc != 6 || argv[1] != kHelperName) return std::nullopt;
  // a person who types this has no pipe
  struct stat pipe {};
  if (fstat(kAnswerFd, &pipe) != 0 || !S_ISFIFO(pipe.st_mode)) return std::nullopt;
  fcntl(kAnswerFd, F_SETFD, FD_CLOEXEC);
  ImportJob job;
  job.limits.seconds = 1e-3 * static_cast<double>(std::strtoull(argv[2], nullptr, 10));
  job.limits.memory_bytes = std::strtoull(argv[3], nullptr, 10);
  job.file = argv[4];
  job.part = argv[5];
  job.answer_fd = kAnswerFd;
  return job;
}

void ConfineTo(const ImportLimits& limits) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  const auto limit = [](auto resource, rlim_t soft, rlim_t hard) {
    const rlimit both{soft, hard};
    setrlimit(resource, &both);
  };
  const auto seconds = static_cast<rlim_t>(std::ceil(limits.seconds));
  limit(RLIMIT_CPU, seconds, seconds + 1);
  limit(RLIMIT_CORE, 0, 0);
  rlim_t memory = limits.memory_bytes;
  if (kIsSanitized) {
    unsigned long long pages = 0;
    if (std::FILE* statm = std::fopen("/proc/self/statm", "re")) {
      if (std::fscanf(statm, "%llu", &pages) != 1) pages = 0;
      std::fclose(statm);
    }
    memory += pages * static_cast<rlim_t>(sysconf(_SC_PAGESIZE));
  } else {
    prctl(PR_SET_DUMPABLE, 0);  // no core dump either where dumps go into a program
  }
  limit(RLIMIT_AS, memory, memory);
}

}  // namespace tandem
