#pragma once

#include <filesystem>

#include "engine/base/result.h"

namespace tandem {

/// Waits until the disk has a file, or with `is_folder` a folder's list of files. Returns 0, else
/// errno.
int SyncToDisk(const std::filesystem::path& path, bool is_folder);

/// A folder that is there whole or not at all. It is filled beside its place, as
/// NAME.unfinished-PID-N, for its owner alone, and Commit() puts it there. Remainders of killed
/// programs beside NAME are removed when NAME is made the next time. Without Commit() it is a place
/// for files that go elsewhere as a whole.
class UnfinishedFolder {
 public:
  /// Errors: the folder has files already, or it cannot be made.
  static Result<UnfinishedFolder> Make(const std::filesystem::path& folder);
  UnfinishedFolder(UnfinishedFolder&& other) noexcept;
  UnfinishedFolder& operator=(UnfinishedFolder&&) = delete;
  /// Removes a folder that was not committed.
  ~UnfinishedFolder();

  /// Returns where to put the files.
  const std::filesystem::path& path() const noexcept { return beside_; }
  /// Waits until the disk has the files, then puts the folder into its place.
  Result<bool> Commit();

 private:
  UnfinishedFolder(std::filesystem::path folder, std::filesystem::path beside, int lock);
  std::filesystem::path folder_;
  std::filesystem::path beside_;  // empty: there is nothing to remove
  int lock_ = -1;                 // descriptor of beside_
};

}  // namespace tandem
