#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <stop_token>
#include <vector>

#include "collab/session/messages.h"
#include "collab/transfer/scene_store.h"

namespace tandem {

/// A scene whose file is sought on this machine.
struct WantedScene {
  std::optional<Sha256> digest;    // of its content; nullopt: an older recording has the hash alone
  std::uint64_t content_hash = 0;  // counts where there is no digest
  std::filesystem::path file;      // path on the machine that announced the scene
  std::size_t bodies = 0;          // number of bodies; 0: unknown
  bool open_told = true;           // true: that path may be opened; false: its name alone counts
  std::optional<SceneStore> fetched;  // fetched scenes that may serve; nullopt: none
};

/// Makes a WantedScene from a session's manifest. Any stranger can name any path there, so the path
/// is not opened. `keys`: folder of the session's keys, whose authorities sent the fetched scenes
/// that may serve; empty: a plain session.
WantedScene WantedFrom(const SceneManifest& manifest, const std::filesystem::path& keys);

/// Returns the folders to search for scenes: the current folder, those of scenes that a person
/// named or opened last, and that of the scenes that come with this program.
std::vector<std::filesystem::path> FoldersWithScenes();

/// Returns whether a file that a stranger named may be opened as a scene: a regular file of at most
/// 4 MB whose name ends in .json.
bool MayBeSceneFile(const std::filesystem::path& file);

/// Returns the store of scenes fetched from sessions with these keys, `fetched` in the cache;
/// empty: from plain sessions. Nothing: there is no cache, or the folder has no authorities.
std::optional<SceneStore> FetchedScenes(const std::filesystem::path& keys);

/// Returns the scene file with the wanted content. It tries the announced path, where that may be
/// opened, then fetched scenes, then the folders, files of the same name first. Nothing: there is
/// none. Reads the mesh files of candidates. `stop` ends the search between two files.
std::optional<std::filesystem::path> FindScene(const WantedScene& wanted,
                                               const std::vector<std::filesystem::path>& folders,
                                               const std::stop_token& stop = {});

/// Remembers the folder of a scene that a person named or opened, for later searches, in
/// `tandem/scene_folders` of $XDG_STATE_HOME (~/.local/state). Does nothing where it cannot write.
void RememberSceneFolder(const std::filesystem::path& scene);

}  // namespace tandem
