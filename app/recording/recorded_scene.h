#pragma once

#include <memory>
#include <string>

#include "collab/recording/recording.h"
#include "engine/base/result.h"
#include "engine/world/world_model.h"

namespace tandem {

/// The options by which a recording's scene is sought.
struct RecordedSceneOptions {
  std::string recording;  // the recording's file, for messages
  std::string scene;  // present place of the scene; empty: the recorded file, or where it is found
  bool adopt_any = false;  // take the recorded voxels, however far from the scene file's
};

/// Loads the recorded scene as it was, with the recorded voxels. Errors: no file with the recorded
/// content is found, it cannot be read, or its voxels differ from the recorded ones by more than a
/// factor of 4 without `adopt_any`.
Result<std::shared_ptr<const WorldModel>> LoadRecorded(const RecordingHeader& header,
                                                       const RecordedSceneOptions& options);

}  // namespace tandem
