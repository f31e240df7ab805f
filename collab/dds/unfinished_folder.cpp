#include "collab/dds/unfinished_folder.h"

#include <cerrno>
#include <cstdio>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

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

UnfinishedFolder::UnfinishedFolder(fs::path folder, fs::path beside)
    : folder_(std::move(folder)), beside_(std::move(beside)) {}

UnfinishedFolder::UnfinishedFolder(UnfinishedFolder&& other) noexcept
    : folder_(std::move(other.folder_)), beside_(std::exchange(other.beside_, {})) {}

UnfinishedFolder::~UnfinishedFolder() {
  std::error_code ignored;
  if (!beside_.empty()) fs::remove_all(beside_, ignored);
}

Result<UnfinishedFolder> UnfinishedFolder::Make(const fs::path& folder) {
  std::error_code failed;
  if (fs::exists(folder, failed) && !fs::is_empty(folder, failed)) {
    return Error{folder.string() + " exists already: keys are never overwritten"};
  }
  fs::path place = fs::absolute(folder).lexically_normal();
  if (!place.has_filename()) place = place.parent_path();  // FOLDER/
  fs::create_directories(place.parent_path(), failed);
  if (failed) return Error{folder.string() + ": " + failed.message()};
  const fs::path beside = place.string() + ".unfinished-" + std::to_string(getpid());
  if (mkdir(beside.c_str(), 0700) != 0) {
    return Error{folder.string() + ": cannot be made: " + Reason(errno)};
  }
  return UnfinishedFolder(place, beside);
}

Result<bool> UnfinishedFolder::Commit() {
  int fault = 0;
  std::error_code failed;
  for (const fs::directory_entry& entry : fs::directory_iterator(beside_, failed)) {
    if (fault == 0) fault = SyncToDisk(entry.path(), false);
  }
  if (failed) fault = failed.value();
  if (fault == 0) fault = SyncToDisk(beside_, true);
  // an empty folder gives way, one with something in it does not
  if (fault == 0 && rename(beside_.c_str(), folder_.c_str()) != 0) fault = errno;
  if (fault != 0) return Error{folder_.string() + ": cannot be written: " + Reason(fault)};
  beside_.clear();
  static_cast<void>(SyncToDisk(folder_.parent_path(), true));
  return true;
}

}  // namespace tandem
