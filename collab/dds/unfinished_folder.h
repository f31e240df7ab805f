#pragma once

#include <filesystem>

#include "engine/base/result.h"

namespace tandem {

/// Waits until the disk has a file, or with `is_folder` a folder's list of files. Returns 0, else
/// errno.
int SyncToDisk(const std::filesystem::path& path, bool is_folder);

/// A folder that is there whole or not at all: it is filled beside its place, as
/// NAME.unfinished-PID-N, for its owner alone, and put there by Commit(). What a program that was
/// killed left beside NAME goes when NAME is made the next time. Without Commit() it is a place for
/// files that go elsewhere as a whole.
class UnfinishedFolder {
 public:
  /// Errors: something is in the folder already, or it cannot be made.
  static Result<UnfinishedFolder> Make(const std::filesystem::path& folder);
  UnfinishedFolder(UnfinishedFolder&& other) noexcept;
  UnfinishedFolder& operator=(UnfinishedFolder&&) = delete;
  /// Removes what was not committed.
  ~UnfinishedFolder();

  /// Where to put the files.
  const std::filesystem::path& path() const noexcept { return beside_; }
  /// Waits until the disk has them, and puts the folder into its place.
  Result<bool> Commit();

 private:
  UnfinishedFolder(std::filesystem::path folder, std::filesystem::path beside, int lock);
  std::filesystem::path folder_;
  std::filesystem::path beside_;  // empty: there is nothing to remove
  int lock_ = -1;                 // descriptor of beside_
};

}  // namespace tandem
