#include "app/output_file.h"

#include <cerrno>
#include <cstdlib>
#include <cstring>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace tandem {
namespace {

// What went wrong, as errno has it; 0: nothing.
int WriteTo(int fd, std::string_view text) {
  while (!text.empty()) {
    const ssize_t wrote = write(fd, text.data(), text.size());
    if (wrote < 0 && errno == EINTR) continue;
    if (wrote < 0) return errno;
    text.remove_prefix(static_cast<std::size_t>(wrote));
  }
  return 0;
}

// The name goes by the umask, as that of any new file, and not by mkstemp's.
mode_t ModeOfNewFiles() {
  const mode_t mask = umask(0);
  umask(mask);
  return 0666 & ~mask;
}

int ReplaceBy(const std::filesystem::path& file, std::string_view text) {
  std::string unfinished = file.string() + ".XXXXXX";
  const int fd = mkostemp(unfinished.data(), O_CLOEXEC);
  if (fd < 0) return errno;
  struct stat before {};
  const mode_t mode = stat(file.c_str(), &before) == 0 ? before.st_mode & 07777 : ModeOfNewFiles();
  int fault = WriteTo(fd, text);
  if (fault == 0 && fchmod(fd, mode) != 0) fault = errno;
  if (fault == 0 && fsync(fd) != 0) fault = errno;
  close(fd);
  if (fault == 0 && rename(unfinished.c_str(), file.c_str()) != 0) fault = errno;
  if (fault != 0) unlink(unfinished.c_str());
  return fault;
}

int WriteStraight(const std::filesystem::path& file, std::string_view text) {
  const int fd = open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (fd < 0) return errno;
  const int fault = WriteTo(fd, text);
  close(fd);
  return fault;
}

}  // namespace

std::string WhyNotWritable(const std::filesystem::path& file) {
  std::error_code not_there;
  int fault = 0;
  if (std::filesystem::is_directory(file, not_there)) {
    fault = EISDIR;
  } else if (std::filesystem::exists(file, not_there)) {
    fault = access(file.c_str(), W_OK) == 0 ? 0 : errno;
  } else {
    const int made = open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    fault = made >= 0 ? 0 : errno;
    if (made >= 0) {
      close(made);
      unlink(file.c_str());
    }
  }
  if (fault == 0) return {};
  return file.string() + ": cannot be written: " + std::strerror(fault);
}

Result<bool> WriteWhole(const std::filesystem::path& file, std::string_view text) {
  std::error_code not_there;
  // a link keeps its place: what it leads to is replaced
  std::filesystem::path target = std::filesystem::weakly_canonical(file, not_there);
  if (not_there || target.empty()) target = file;
  const bool regular = std::filesystem::is_regular_file(target, not_there) ||
                       !std::filesystem::exists(target, not_there);
  int fault = regular ? ReplaceBy(target, text) : WriteStraight(file, text);
  // a folder that takes no new file, with a file in it that may be written
  if (fault == EACCES || fault == EPERM || fault == EROFS) fault = WriteStraight(file, text);
  if (fault == 0) return true;
  return Error{file.string() + ": cannot be written: " + std::strerror(fault)};
}

}  // namespace tandem
