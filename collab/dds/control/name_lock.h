#pragma once

#include <filesystem>
#include <string>

#include "engine/base/result.h"

namespace tandem {

/// The name of a running controller: a locked file, which the kernel unlocks when the process ends
/// for any reason. The controller's socket and its scenes go with the lock.
class NameLock {
 public:
  /// Locks the name in a ControlFolder(). Error: a controller of that name runs.
  static Result<NameLock> Take(const std::filesystem::path& folder, const std::string& name);
  /// Removes what killed controllers left in the folder.
  static void Sweep(const std::filesystem::path& folder);

  NameLock(NameLock&& other) noexcept;
  NameLock& operator=(NameLock&&) = delete;
  ~NameLock();

 private:
  NameLock(int file, std::filesystem::path path) : file_(file), path_(std::move(path)) {}

  int file_;
  std::filesystem::path path_;
};

}  // namespace tandem
