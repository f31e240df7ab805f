#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "collab/transfer/scene_fetch.h"
#include "collab/transfer/scene_list.h"
#include "engine/base/files/sha256.h"
#include "engine/base/result.h"

namespace tandem {

/// A scene fetched from a session, or a part of one.
struct FetchedScene {
  std::filesystem::path folder;
  std::uint64_t bytes = 0;
  std::filesystem::file_time_type used;  // time of the last use
  bool whole = true;                     // false: the rest of a run that ended early
};

/// The folder of all fetched scenes. Every name in it is made here, from digests: no name from the
/// network becomes a path. A folder or file that is not the user's own, that others may write to,
/// or that is a link is not used.
///
/// The scenes of plain sessions, and those of each authority, have a folder each: what a stranger
/// sent never serves a secured session. In it a scene is in the folder of its content's digest, as
/// `scene.json` and files named after their digests. It is written in a folder beside it, named
/// after its list of files and locked by one program at a time. So the next program goes on where a
/// killed one stopped.
class SceneStore {
 public:
  static constexpr const char* kSceneFile = "scene.json";

  /// `authority`: digest of the authorities whose members send the scenes; nullopt: anybody does,
  /// in plain sessions.
  explicit SceneStore(std::filesystem::path folder, const std::optional<Sha256>& authority = {});

  /// The folder of all scenes.
  const std::filesystem::path& folder() const noexcept { return folder_; }
  /// The folder of these senders' scenes.
  std::filesystem::path group() const { return folder_ / group_; }
  const std::string& group_name() const noexcept { return group_; }
  /// Returns the path of the scene file of that content, even if it is not there.
  std::filesystem::path SceneFileOf(const Sha256& content) const;
  /// Returns all scenes in the folder, whoever sent them, the last used first.
  std::vector<FetchedScene> Scenes() const;
  /// Removes all scenes, whoever sent them, except those being written; returns how many.
  std::size_t Clear() const;
  /// Notes that the scene is in use.
  void Touch(const Sha256& content) const;

 private:
  std::filesystem::path folder_;
  std::string group_;  // name of a folder in folder_
};

/// The files of a scene on their way into a store.
class UnfinishedScene final : public PieceStore {
 public:
  struct Limits {
    std::uint64_t most_bytes = 0;  // sum of the store's scenes: the least recently used go first
    std::uint64_t spare_bytes = 256U << 20U;  // free space to leave on the disk
  };

  /// Makes its folder, or takes over that of a program which ended. The error is a line: another
  /// program has it (`busy`), the disk is too full, or others can write to the folder.
  static Result<UnfinishedScene> Open(const SceneStore& store, const SceneList& list,
                                      const Sha256& digest, const Limits& limits, bool& busy);
  UnfinishedScene(UnfinishedScene&& other) noexcept;
  UnfinishedScene& operator=(UnfinishedScene&&) = delete;
  /// Leaves the files for the next run.
  ~UnfinishedScene() override;

  bool Read(const PiecePlace& place, std::span<char> piece) override;
  bool Write(const PiecePlace& place, std::span<const char> piece) override;

  /// Checks the digests of all files, and writes the scene file with the names that they have here.
  /// Returns its path, in the unfinished folder: only now may it be read.
  Result<std::filesystem::path> WriteScene();
  /// Waits until the disk has all files, and moves the scene to its place. Returns the scene file's
  /// path.
  Result<std::filesystem::path> Commit(const Sha256& content);
  /// Removes all files and the folder.
  void Remove();

 private:
  UnfinishedScene(std::filesystem::path root, SceneList list, std::string name, int root_folder,
                  int folder)
      : root_(std::move(root)),
        list_(std::move(list)),
        name_(std::move(name)),
        root_folder_(root_folder),
        folder_(folder) {}
  std::optional<Error> OpenFiles();

  std::filesystem::path root_;
  SceneList list_;
  std::string name_;      // name of the folder, below root_
  int root_folder_ = -1;  // descriptor
  int folder_ = -1;       // descriptor of the folder, with the lock
  std::vector<int> files_;
  std::vector<std::string> names_;
};

}  // namespace tandem
