#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "collab/transfer/scene_list.h"
#include "engine/base/files/regular_file.h"
#include "engine/base/result.h"
#include "engine/scene/scene.h"

namespace tandem {

/// Returns the scene file as it travels. Its meshes are called "file:1", "file:2", … in the order
/// of the list, and its hands, which belong to this machine, are left out. It does not depend on
/// the files' names here. `file_of_body`: index of each body's file.
Result<std::string> TravellingScene(const std::string& scene_file,
                                    const std::vector<std::size_t>& file_of_body);

/// Returns a travelled scene file for this machine: "file:N" becomes `names[N]`. Refuses any other
/// mesh, and every reference to another file.
Result<std::string> ArrivedScene(const std::string& travelled,
                                 const std::vector<std::string>& names);

/// Returns in a line why a scene's files cannot travel; empty: they can.
std::string WhyNotToTravel(const Scene& scene);

/// The files of a scene on this machine, in the order of its list.
class SceneFiles {
 public:
  /// Opens the files and makes their list, which takes some seconds for a gigabyte. An error is a
  /// line: they are not the scene of that content any more, or cannot travel. `stop`: gives up when
  /// true.
  static Result<SceneFiles> Open(const std::filesystem::path& scene_file, const Sha256& content,
                                 const std::atomic<bool>& stop);

  const SceneList& list() const noexcept { return list_; }
  /// Reads a piece by its number over all files. Returns false if the file has changed.
  bool Read(std::uint32_t number, std::vector<char>& piece) const;

 private:
  SceneFiles() = default;
  SceneList list_;
  std::string scene_;  // scene file as it travels
  std::vector<RegularFile> meshes_;
};

}  // namespace tandem
