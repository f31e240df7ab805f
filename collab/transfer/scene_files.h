#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "collab/transfer/scene_list.h"
#include "engine/base/regular_file.h"
#include "engine/base/result.h"
#include "engine/world/scene.h"

namespace tandem {

/// The scene file as it travels: its meshes are called "file:1", "file:2", … in the order of
/// `meshes`, and its hands, which are this machine's, are left out. The same whatever the files are
/// called here. `file_of_body`: for each body, which file it is.
Result<std::string> TravellingScene(const std::string& scene_file,
                                    const std::vector<std::size_t>& file_of_body);

/// A scene file that travelled, for this machine: "file:N" becomes `names[N]`. Refuses whatever
/// else stands for a mesh, and all that names another file.
Result<std::string> ArrivedScene(const std::string& travelled,
                                 const std::vector<std::string>& names);

/// Whether a scene's files can travel: in a line why not; empty: they can.
std::string WhyNotToTravel(const Scene& scene);

/// The files of a scene on this machine, in the order of its list.
class SceneFiles {
 public:
  /// Opens them and makes their list, which takes some seconds for a gigabyte. An error is a line:
  /// they are not the scene of that content any more, or cannot travel. `stop`: gives up.
  static Result<SceneFiles> Open(const std::filesystem::path& scene_file,
                                 std::uint64_t content_hash, const std::atomic<bool>& stop);

  const SceneList& list() const noexcept { return list_; }
  /// Reads a piece, which is counted through all files. False: the file is not what it was.
  bool Read(std::uint32_t number, std::vector<char>& piece) const;

 private:
  SceneFiles() = default;
  SceneList list_;
  std::string scene_;  // as it travels
  std::vector<RegularFile> meshes_;
};

}  // namespace tandem
