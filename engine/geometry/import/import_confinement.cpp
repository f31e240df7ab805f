#include "engine/geometry/import/import_confinement.h"

#include <array>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <vector>

#include <fcntl.h>
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "engine/base/sanitized.h"

#if defined(__x86_64__)
#define TANDEM_ARCHITECTURE AUDIT_ARCH_X86_64
#elif defined(__aarch64__)
#define TANDEM_ARCHITECTURE AUDIT_ARCH_AARCH64
#endif

namespace tandem {

namespace {

// ---- Landlock (Linux 5.13): restricts files. Declared here, because older headers lack it. ----

struct LandlockRules {
  std::uint64_t handled_access_fs = 0;
};
struct [[gnu::packed]] LandlockPath {
  std::uint64_t allowed_access = 0;
  std::int32_t parent_fd = -1;
};
constexpr long kCreateRuleset = 444;
constexpr long kAddRule = 445;
constexpr long kRestrictSelf = 446;
constexpr int kRulePathBeneath = 1;
constexpr std::uint64_t kReadFile = 1U << 2U;
constexpr std::uint64_t kReadFolder = 1U << 3U;
constexpr std::uint64_t kAllOfFirstVersion = (1U << 13U) - 1;

void Allow(int rules, const std::filesystem::path& path, std::uint64_t access) {
  const int descriptor = open(path.c_str(), O_PATH | O_CLOEXEC);
  if (descriptor < 0) return;
  const LandlockPath beneath{access, descriptor};
  syscall(kAddRule, rules, kRulePathBeneath, &beneath, 0);
  close(descriptor);
}

void ConfineFiles(const std::filesystem::path& file) {
  const LandlockRules handled{kAllOfFirstVersion};
  const auto rules = static_cast<int>(syscall(kCreateRuleset, &handled, sizeof handled, 0));
  if (rules < 0) return;
  const std::filesystem::path folder = file.parent_path();
  Allow(rules, folder.empty() ? std::filesystem::path(".") : folder, kReadFile | kReadFolder);
  Allow(rules, file, kReadFile);  // the target of a link may lie elsewhere
  syscall(kRestrictSelf, rules, 0);
  close(rules);
}

// ---- seccomp: restricts system calls. ----

#ifdef TANDEM_ARCHITECTURE

constexpr std::array kHarmless{
    SYS_read,
    SYS_readv,
    SYS_pread64,
    SYS_write,
    SYS_writev,
    SYS_close,
    SYS_fstat,
    SYS_newfstatat,
    SYS_statx,
    SYS_lseek,
    SYS_munmap,
    SYS_mremap,
    SYS_brk,
    SYS_madvise,
    SYS_rt_sigaction,
    SYS_rt_sigprocmask,
    SYS_rt_sigreturn,
    SYS_sigaltstack,
    SYS_exit,
    SYS_exit_group,
    SYS_futex,
    SYS_clock_gettime,
    SYS_clock_nanosleep,
    SYS_gettimeofday,
    SYS_getpid,
    SYS_gettid,
    SYS_getrandom,
    SYS_faccessat,
    SYS_readlinkat,
    SYS_getcwd,
    SYS_uname,
    SYS_sysinfo,
    SYS_sched_yield,
    SYS_sched_getaffinity,
    SYS_getdents64,
    SYS_getuid,
    SYS_geteuid,
#ifdef SYS_faccessat2
    SYS_faccessat2,
#endif
#ifdef __x86_64__
    SYS_stat,
    SYS_lstat,
    SYS_access,
    SYS_readlink,
    SYS_time,
#endif
};

constexpr std::uint32_t LowHalf(int argument) {  // little-endian
  return static_cast<std::uint32_t>(offsetof(seccomp_data, args)) +
         8U * static_cast<std::uint32_t>(argument);
}

/// A filter, instruction by instruction.
class Filter {
 public:
  void Load(std::uint32_t offset) { Add(BPF_LD | BPF_W | BPF_ABS, 0, 0, offset); }
  void Answer(std::uint32_t answer) { Add(BPF_RET | BPF_K, 0, 0, answer); }
  void AllowCall(long call) { AllowValue(static_cast<std::uint32_t>(call)); }
  /// Allows the call if none of these bits is in that argument.
  void AllowWithout(long call, int argument, std::uint32_t bits) {
    Add(BPF_JMP | BPF_JEQ | BPF_K, 0, 4, static_cast<std::uint32_t>(call));
    Load(LowHalf(argument));
    Add(BPF_JMP | BPF_JSET | BPF_K, 1, 0, bits);
    Answer(SECCOMP_RET_ALLOW);
    Answer(SECCOMP_RET_ERRNO | EPERM);
  }
  /// Allows the call if that argument is one of these.
  void AllowWhere(long call, int argument, std::initializer_list<std::uint32_t> values) {
    const int rest = static_cast<int>(2 + 2 * values.size());
    Add(BPF_JMP | BPF_JEQ | BPF_K, 0, rest, static_cast<std::uint32_t>(call));
    Load(LowHalf(argument));
    for (const std::uint32_t value : values) AllowValue(value);
    Answer(SECCOMP_RET_ERRNO | EPERM);
  }
  void RefuseOtherArchitectures() {
    Load(offsetof(seccomp_data, arch));
    Add(BPF_JMP | BPF_JEQ | BPF_K, 1, 0, TANDEM_ARCHITECTURE);
    Answer(SECCOMP_RET_KILL_PROCESS);
  }
  bool Install() {
    const sock_fprog program{static_cast<unsigned short>(code_.size()), code_.data()};
    return prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program) == 0;
  }

 private:
  /// Allows the call if the loaded value is this.
  void AllowValue(std::uint32_t value) {
    Add(BPF_JMP | BPF_JEQ | BPF_K, 0, 1, value);
    Answer(SECCOMP_RET_ALLOW);
  }
  void Add(int code, int if_true, int if_false, std::uint32_t value) {
    code_.push_back({static_cast<std::uint16_t>(code), static_cast<std::uint8_t>(if_true),
                     static_cast<std::uint8_t>(if_false), value});
  }
  std::vector<sock_filter> code_;
};

bool ConfineCalls() {
  constexpr std::uint32_t kWrites = O_WRONLY | O_RDWR | O_CREAT | O_TRUNC | O_APPEND;
  Filter filter;
  filter.RefuseOtherArchitectures();
  filter.Load(offsetof(seccomp_data, nr));
  for (const long call : kHarmless) filter.AllowCall(call);
  // each of these ends the filter if its number fits, so that the number is still loaded
  filter.AllowWithout(SYS_openat, 2, kWrites);
#ifdef SYS_open
  filter.AllowWithout(SYS_open, 1, kWrites);
#endif
  filter.AllowWithout(SYS_mmap, 2, PROT_EXEC);
  filter.AllowWithout(SYS_mprotect, 2, PROT_EXEC);
  // flags of a descriptor; its owner, signal, lease and locks reach other processes
  filter.AllowWhere(SYS_fcntl, 1, {F_GETFL, F_GETFD, F_SETFD});
  filter.AllowWhere(SYS_tgkill, 0, {static_cast<std::uint32_t>(getpid())});  // abort()
  filter.Answer(SECCOMP_RET_ERRNO | EPERM);
  return filter.Install();
}

#else

bool ConfineCalls() {
  return false;
}

#endif

}  // namespace

void ConfineToFile(const std::filesystem::path& file) {
  if (kIsSanitized) return;
  if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0) return;
  ConfineFiles(file);
  // without the filter at least no network, where the kernel permits it
  if (!ConfineCalls()) unshare(CLONE_NEWUSER | CLONE_NEWNET);
}

}  // namespace tandem
