#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/result.h"
#include "engine/world/scene.h"

namespace tandem {

/// A body that a scene gets in addition.
struct AddedBody {
  std::string name;  // empty: the file's
  std::filesystem::path mesh;
  bool fixed = false;
  bool shared = true;
  double mass_kg = 1;
};

/// Writes a scene file: that of `scene`, with each body where `displaced` has it (X_W of each body
/// of the scene: p_W now = X_W * p_W of the file), all files by absolute names. Errors: the scene
/// cannot be read again, the file exists already unless `overwrite`, or cannot be written.
Result<bool> WriteSceneAsItStands(const Scene& scene, const std::vector<Pose>& displaced,
                                  const std::optional<AddedBody>& added,
                                  const std::filesystem::path& file, bool overwrite);

}  // namespace tandem
