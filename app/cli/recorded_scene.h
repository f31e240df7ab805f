#pragma once

#include <memory>
#include <string>

#include "collab/recording/recording.h"
#include "engine/base/result.h"
#include "engine/world/world_model.h"

namespace tandem {

/// How the scene of a recording is looked for.
struct RecordedSceneOptions {
  std::string recording;   // the recording's file, for messages
  std::string scene;       // where the scene is now; empty: the recorded file, or where it is found
  bool adopt_any = false;  // the recorded voxels, however far from the scene file's
};

/// The recorded scene as it was, with the recorded voxels. Errors: no file with the recorded
/// content is found, it cannot be read, or its voxels differ from the recorded ones by more than a
/// factor of 4 without `adopt_any`.
Result<std::shared_ptr<const WorldModel>> LoadRecorded(const RecordingHeader& header,
                                                       const RecordedSceneOptions& options);

}  // namespace tandem
