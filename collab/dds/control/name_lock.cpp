#include "collab/dds/control/name_lock.h"

#include <system_error>
#include <utility>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "collab/dds/control/control_folder.h"

namespace tandem {

NameLock::NameLock(NameLock&& other) noexcept
    : file_(std::exchange(other.file_, -1)), path_(std::move(other.path_)) {}

NameLock::~NameLock() {
  if (file_ < 0) return;
  std::error_code ignored;
  const std::string name = path_.stem().string();
  std::filesystem::remove(path_.parent_path() / SocketOf(name), ignored);
  std::filesystem::remove_all(path_.parent_path() / ScenesFolderOf(name), ignored);
  // while the file is locked, so that nobody takes it meanwhile
  std::filesystem::remove(path_, ignored);
  close(file_);
}

Result<NameLock> NameLock::Take(const std::filesystem::path& folder, const std::string& name) {
  const std::filesystem::path path = folder / (name + ".lock");
  for (;;) {
    NameLock lock(open(path.c_str(), O_CREAT | O_RDWR | O_CLOEXEC | O_NOFOLLOW, 0600), path);
    if (lock.file_ < 0) return Error{path.string() + ": cannot be written"};
    if (flock(lock.file_, LOCK_EX | LOCK_NB) != 0) {
      close(std::exchange(lock.file_, -1));
      return Error{"a controller '" + name + "' already runs on this machine: --control with " +
                   "another name, or attach to that one"};
    }
    // its owner may have removed the file between open and lock
    struct stat ours {};
    struct stat there {};
    if (fstat(lock.file_, &ours) == 0 && stat(path.c_str(), &there) == 0 &&
        ours.st_ino == there.st_ino) {
      return lock;
    }
    close(std::exchange(lock.file_, -1));
  }
}

void NameLock::Sweep(const std::filesystem::path& folder) {
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator(folder, ignored)) {
    if (entry.path().extension() != ".lock") continue;
    // whoever has the lock owns the files of its controller; they are removed with the lock
    static_cast<void>(Take(folder, entry.path().stem().string()));
  }
}

}  // namespace tandem
