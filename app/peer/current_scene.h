#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/result.h"
#include "engine/scene/scene.h"

namespace tandem {

/// A body that is added to a scene.
struct AddedBody {
  std::string name;  // name; empty: that of the file
  std::filesystem::path mesh;
  bool fixed = false;
  bool shared = true;
  double mass_kg = 1;
};

/// Writes the file of `scene` with each body where `displaced` has it. `displaced` has X_W for each
/// body of the scene: p_W at present = X_W * p_W of the file. All files get absolute names. Errors:
/// the scene cannot be read again, the file exists already without `overwrite`, or it cannot be
/// written.
Result<bool> WriteCurrentScene(const Scene& scene, const std::vector<Pose>& displaced,
                               const std::optional<AddedBody>& added,
                               const std::filesystem::path& file, bool overwrite);

}  // namespace tandem
