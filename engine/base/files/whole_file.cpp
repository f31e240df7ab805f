#include "engine/base/files/whole_file.h"

#include <cerrno>
#include <cstdio>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "engine/base/files/unfinished.h"

namespace tandem {

namespace {

constexpr std::size_t kWriteBlock = 1 << 16;

Error NotWritten(const std::filesystem::path& file, int fault) {
  return {file.string() + ": cannot be written: " + std::generic_category().message(fault)};
}

}  // namespace

Result<WholeFile> WholeFile::Create(const std::filesystem::path& file, unsigned mode) {
  WholeFile made;
  made.file_ = file;
  struct stat status {};
  const bool there = stat(file.c_str(), &status) == 0;
  if (there && S_ISDIR(status.st_mode)) return NotWritten(file, EISDIR);
  if (there && !S_ISREG(status.st_mode)) {
    made.descriptor_ = open(file.c_str(), O_WRONLY | O_CLOEXEC | O_NOCTTY);
    if (made.descriptor_ < 0) return NotWritten(file, errno);
    return made;
  }
  // a file that must not be written is not replaced either; a link's target is replaced, not the
  // link
  if (there && access(file.c_str(), W_OK) != 0) return NotWritten(file, errno);
  std::error_code failed;
  const std::filesystem::path end = std::filesystem::canonical(file, failed);
  if (there && !failed) made.file_ = end;
  RemoveRemainders(made.file_);
  constexpr int kTries = 100;
  for (int i = 0; i < kTries && made.descriptor_ < 0; ++i) {
    made.beside_ = UnfinishedName(made.file_);
    made.descriptor_ =
        open(made.beside_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW,
             there ? status.st_mode & 0777U : mode);
    if (made.descriptor_ < 0 && errno != EEXIST) break;
    if (made.descriptor_ >= 0 && !HoldUnfinished(made.descriptor_)) {
      close(std::exchange(made.descriptor_, -1));
      errno = EEXIST;
    }
  }
  if (made.descriptor_ < 0) {
    const int fault = errno;
    made.beside_.clear();
    return NotWritten(file, fault);
  }
  return made;
}

WholeFile::WholeFile(WholeFile&& other) noexcept {
  *this = std::move(other);
}

WholeFile& WholeFile::operator=(WholeFile&& other) noexcept {
  std::swap(file_, other.file_);
  std::swap(beside_, other.beside_);
  std::swap(descriptor_, other.descriptor_);
  std::swap(fault_, other.fault_);
  std::swap(written_, other.written_);
  std::swap(waiting_, other.waiting_);
  return *this;
}

WholeFile::~WholeFile() {
  if (descriptor_ >= 0) close(descriptor_);
  if (!beside_.empty()) unlink(beside_.c_str());
}

bool WholeFile::Write(std::string_view bytes) {
  waiting_.append(bytes);
  written_ += bytes.size();
  return waiting_.size() < kWriteBlock ? fault_ == 0 : Flush();
}

bool WholeFile::Flush() {
  std::string_view rest = waiting_;
  while (fault_ == 0 && !rest.empty()) {
    const ssize_t size = write(descriptor_, rest.data(), rest.size());
    if (size < 0 && errno == EINTR) continue;
    if (size <= 0) fault_ = size < 0 ? errno : ENOSPC;
    if (size > 0) rest.remove_prefix(static_cast<std::size_t>(size));
  }
  waiting_.clear();
  return fault_ == 0;
}

std::optional<Error> WholeFile::Commit() {
  Flush();
  // a pipe cannot be synchronized, and need not be
  if (fault_ == 0 && !beside_.empty() && fsync(descriptor_) != 0) fault_ = errno;
  // holds the lock until the file is in its place
  const int held = fcntl(descriptor_, F_DUPFD_CLOEXEC, 0);
  if (close(std::exchange(descriptor_, -1)) != 0 && fault_ == 0) fault_ = errno;
  if (fault_ == 0 && !beside_.empty() && rename(beside_.c_str(), file_.c_str()) != 0) {
    fault_ = errno;
  }
  if (held >= 0) close(held);
  if (fault_ != 0) return NotWritten(file_, fault_);
  beside_.clear();
  return std::nullopt;
}

std::optional<Error> WriteWholeFile(const std::filesystem::path& file, std::string_view text,
                                    unsigned mode) {
  Result<WholeFile> made = WholeFile::Create(file, mode);
  if (!made) return made.error();
  made->Write(text);
  return made->Commit();
}

}  // namespace tandem
