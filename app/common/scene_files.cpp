#include "app/common/scene_files.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "app/common/console.h"
#include "app/common/program_folders.h"

namespace tandem {

std::filesystem::path SceneFile(const std::string& name_or_path) {
  const std::filesystem::path path = name_or_path;
  std::error_code unknown;
  if (std::filesystem::exists(path, unknown) || path.has_parent_path() || path.has_extension())
    return path;
  return SceneFolder() / (name_or_path + ".json");
}

Result<Scene> LoadNamedScene(const std::string& name_or_path) {
  const std::filesystem::path file = SceneFile(name_or_path);
  std::error_code unknown;
  if (file == name_or_path || std::filesystem::exists(file, unknown)) return LoadScene(file);
  for (const char* large : {"clutter", "landing_gear"}) {
    if (name_or_path != large) continue;
    return Error{file.string() + ": does not exist; `cmake --build --preset release --target " +
                 name_or_path + "` makes it"};
  }
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(file.parent_path(), unknown)) {
    // the file of a hand begins with its scene's name
    if (entry.path().extension() == ".json") names.push_back(entry.path().stem().string());
  }
  std::ranges::sort(names);
  std::string scenes;
  std::string last;
  for (const std::string& name : names) {
    if (!last.empty() && name.rfind(last + "_", 0) == 0) continue;
    scenes += (scenes.empty() ? "" : ", ") + name;
    last = name;
  }
  return Error{"there is no scene '" + name_or_path + "': name a file, or one of " + scenes + " (" +
               file.parent_path().string() + ")"};
}

Result<TriangleMesh> ImportAndTell(const std::filesystem::path& file, const ImportOptions& options,
                                   std::vector<std::string>* remarks) {
  std::vector<std::string> told;
  Result<TriangleMesh> mesh = ImportMesh(file, options, &told);
  for (const std::string& remark : told) Say(file.native() + ": " + remark);
  if (remarks != nullptr) *remarks = std::move(told);
  return mesh;
}

}  // namespace tandem
