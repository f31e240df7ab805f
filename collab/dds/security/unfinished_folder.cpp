#include "collab/dds/security/unfinished_folder.h"

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

namespace fs = std::filesystem;

std::string Reason(int fault) {
  return std::generic_category().message(fault);
}

}  // namespace

int SyncToDisk(const fs::path& path, bool is_folder) {
  const int kind = is_folder ? O_DIRECTORY : 0;
  const int descriptor = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | kind);
  if (descriptor < 0) return errno;
  const int fault = fsync(descriptor) == 0 || errno == EINVAL ? 0 : errno;
  close(descriptor);
  return fault;
}

UnfinishedFolder::UnfinishedFolder(fs::path folder, fs::path beside, int lock)
    : folder_(std::move(folder)), beside_(std::move(beside)), lock_(lock) {}

UnfinishedFolder::UnfinishedFolder(UnfinishedFolder&& other) noexcept
    : folder_(std::move(other.folder_)),
      beside_(std::exchange(other.beside_, {})),
      lock_(std::exchange(other.lock_, -1)) {}

UnfinishedFolder::~UnfinishedFolder() {
  std::error_code ignored;
  if (!beside_.empty()) fs::remove_all(beside_, ignored);
  if (lock_ >= 0) close(lock_);
}

Result<UnfinishedFolder> UnfinishedFolder::Make(const fs::path& folder) {
  std::error_code failed;
  fs::path place = fs::absolute(folder).lexically_normal();
  if (!place.has_filename()) place = place.parent_path();  // FOLDER/
  RemoveRemainders(place);
  if (fs::exists(folder, failed) && !fs::is_empty(folder, failed)) {
    return Error{folder.string() + " exists already: keys are never overwritten"};
  }
  fs::create_directories(place.parent_path(), failed);
  if (failed) return Error{folder.string() + ": " + failed.message()};
  constexpr int kTries = 100;
  int fault = EEXIST;
  for (int i = 0; i < kTries && fault == EEXIST; ++i) {
    const fs::path beside = UnfinishedName(place);
    fault = mkdir(beside.c_str(), 0700) == 0 ? 0 : errno;
    if (fault != 0) continue;
    const int lock = open(beside.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_DIRECTORY);
    if (lock >= 0 && HoldUnfinished(lock)) return UnfinishedFolder(place, beside, lock);
    fault = lock < 0 && errno != ENOENT ? errno : EEXIST;
    if (lock >= 0) close(lock);
    if (fault != EEXIST) rmdir(beside.c_str());
  }
  return Error{folder.string() + ": cannot be made: " + Reason(fault)};
}

Result<bool> UnfinishedFolder::Commit() {
  int fault = 0;
  std::error_code failed;
  for (const fs::directory_entry& entry : fs::directory_iterator(beside_, failed)) {
    if (fault == 0) fault = SyncToDisk(entry.path(), false);
  }
  if (failed) fault = failed.value();
  if (fault == 0) fault = SyncToDisk(beside_, true);
  // rename replaces an empty folder, but not one with files in it
  if (fault == 0 && rename(beside_.c_str(), folder_.c_str()) != 0) fault = errno;
  if (fault != 0) return Error{folder_.string() + ": cannot be written: " + Reason(fault)};
  beside_.clear();
  static_cast<void>(SyncToDisk(folder_.parent_path(), true));
  return true;
}

}  // namespace tandem
