#include "app/recording/recorded_scene.h"

#include <filesystem>
#include <vector>

#include "app/common/console.h"
#include "app/common/program_cache.h"
#include "app/common/scene_files.h"
#include "app/connection/scene_search.h"
#include "collab/session/scene_agreement.h"
#include "engine/scene/scene_hash.h"

namespace tandem {

Result<std::shared_ptr<const WorldModel>> LoadRecorded(const RecordingHeader& header,
                                                       const RecordedSceneOptions& options) {
  std::string file = options.scene.empty() ? header.scene : SceneFile(options.scene).string();
  std::string what_to_do;
  if (options.scene.empty()) {
    // the scene may lie elsewhere on this machine
    const std::vector<std::filesystem::path> folders = FoldersWithScenes();
    const auto found = FindScene({.digest = header.scene_digest,
                                  .content_hash = header.scene_hash,
                                  .file = header.scene,
                                  .fetched = std::nullopt},
                                 folders);
    if (found && found->string() != header.scene) Say("scene found in " + found->string());
    if (found) file = found->string();
    std::string searched;
    for (const std::filesystem::path& folder : folders) {
      searched += (searched.empty() ? "" : ", ") + folder.string();
    }
    what_to_do = " (no file with its content is in " + searched + "; give its place with --scene)";
    // a stranger's recording may name any path
    if (!found && !MayBeSceneFile(file)) {
      return Error{file + ": is not a scene file (.json, at most 4 MB)" + what_to_do};
    }
  }
  Result<Scene> scene = LoadScene(file);
  if (!scene) return Error{scene.error().what + what_to_do};
  const ForceParameters own = ParametersOf(*scene);
  Adopt(header.parameters, *scene);
  const Result<SceneHash> hash = HashScene(*scene);
  if (!hash) return hash.error();
  // a recording from before digests has the hash alone, which finds accidents
  if (header.scene_digest ? hash->digest != *header.scene_digest
                          : hash->content != header.scene_hash) {
    return Error{file + ": is not the recorded scene, or has changed since" + what_to_do};
  }
  if (!options.adopt_any && !MayBeAdopted(header.parameters, own)) {
    return Error{options.recording + ": was recorded by " + Describe(header.parameters) +
                 ", its scene has " + Describe(own) +
                 ": they differ by more than a factor of 4, which needs much more memory or is "
                 "much coarser; --adopt-any takes the recorded voxel size"};
  }
  if (!options.scene.empty()) RememberSceneFolder(file);
  return LoadCached(*scene);
}

}  // namespace tandem
