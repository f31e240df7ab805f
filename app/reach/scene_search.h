#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <stop_token>
#include <vector>

#include "collab/messages.h"
#include "collab/transfer/scene_store.h"

namespace tandem {

/// What is known of a scene whose file is to be found on this machine.
struct WantedScene {
  std::uint64_t content_hash = 0;
  std::filesystem::path file;  // where it was on the machine that tells of it
  std::size_t bodies = 0;      // their number; 0: not known
  bool open_told = true;       // whether that path may be opened; else its name alone counts
};

/// Of a session, where any stranger may name any path: it is not opened.
WantedScene WantedFrom(const SceneManifest& manifest);

/// Returns the folders in which scenes are looked for: the current one, those of scenes that were
/// named or opened last, and the folder of the scenes that come with this program.
std::vector<std::filesystem::path> FoldersWithScenes();

/// Whether a file may be opened as a scene though a stranger named it: a regular one that ends in
/// .json, of 4 MB at the most.
bool MayBeSceneFile(const std::filesystem::path& file);

/// The scenes that were fetched from sessions, in `fetched` of the cache. Nothing: there is no
/// cache.
std::optional<SceneStore> FetchedScenes();

/// Returns the scene file with the wanted content: the one told of, if it is here and may be
/// opened, else one that was fetched, else one in the folders, first those of the same file name.
/// Nothing: there is none. Reads the mesh files of scenes that may be it. `stop`: asks it to give
/// up, between two files.
std::optional<std::filesystem::path> FindScene(const WantedScene& wanted,
                                               const std::vector<std::filesystem::path>& folders,
                                               const std::stop_token& stop = {});

/// Keeps the folder of a scene that a person named or opened, for later searches, in
/// `tandem/scene_folders` of $XDG_STATE_HOME (~/.local/state). Does nothing where it cannot.
void RememberSceneFolder(const std::filesystem::path& scene);

}  // namespace tandem
