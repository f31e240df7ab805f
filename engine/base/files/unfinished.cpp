#include "engine/base/files/unfinished.h"

#include <atomic>
#include <cerrno>
#include <charconv>
#include <csignal>
#include <optional>
#include <string_view>
#include <system_error>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

namespace tandem {

namespace {

namespace fs = std::filesystem;

constexpr const char* kMark = ".unfinished-";
constexpr int kMostEntries = 10'000;  // greatest number of entries of a folder that are examined

/// Returns the process of a name, PID or PID-N; nothing: it is no such name.
std::optional<pid_t> ProcessOf(std::string_view words) {
  pid_t pid = 0;
  const char* const end = words.data() + words.size();
  const auto [stop, fault] = std::from_chars(words.data(), end, pid);
  if (fault != std::errc() || pid <= 0) return std::nullopt;
  if (stop == end) return pid;
  unsigned count = 0;
  const auto [last, no_count] = std::from_chars(stop + 1, end, count);
  const bool sound = *stop == '-' && no_count == std::errc() && last == end;
  return sound ? std::optional(pid) : std::nullopt;
}

bool IsGone(pid_t pid) {
  // an earlier process may have had the same number
  return pid == getpid() || (kill(pid, 0) != 0 && errno == ESRCH);
}

void RemoveIfLeft(const fs::path& path) {
  const int descriptor =
      open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC | O_NOFOLLOW | O_NOCTTY);
  if (descriptor < 0) return;
  struct stat status {};
  const bool ours = fstat(descriptor, &status) == 0 && status.st_uid == geteuid() &&
                    (S_ISREG(status.st_mode) || S_ISDIR(status.st_mode));
  std::error_code ignored;
  if (ours && flock(descriptor, LOCK_EX | LOCK_NB) == 0) fs::remove_all(path, ignored);
  close(descriptor);
}

}  // namespace

fs::path UnfinishedName(const fs::path& place) {
  static std::atomic<unsigned> count{0};
  fs::path name = place;
  return name += kMark + std::to_string(getpid()) + "-" + std::to_string(count++);
}

bool HoldUnfinished(int descriptor) {
  // a program that removes remainders has the lock for a moment; a disk may have no locks
  while (flock(descriptor, LOCK_EX) != 0 && errno == EINTR) {
  }
  struct stat status {};
  return fstat(descriptor, &status) != 0 || status.st_nlink > 0;
}

void RemoveRemainders(const fs::path& place) {
  const fs::path folder = place.has_parent_path() ? place.parent_path() : fs::path(".");
  const std::string begin = place.filename().native() + kMark;
  std::error_code failed;
  int entries = 0;
  for (fs::directory_iterator entry(folder, failed), end; !failed && entry != end;
       entry.increment(failed)) {
    if (++entries > kMostEntries) return;
    const std::string name = entry->path().filename().native();
    if (!name.starts_with(begin)) continue;
    const auto pid = ProcessOf(std::string_view(name).substr(begin.size()));
    if (pid && IsGone(*pid)) RemoveIfLeft(entry->path());
  }
}

}  // namespace tandem
