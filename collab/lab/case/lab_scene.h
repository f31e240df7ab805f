#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>

#include "collab/lab/case/lab_case.h"
#include "engine/world/world_model.h"

namespace tandem {

/// A scene of the lab, loaded once and shared by all threads.
struct LabScene {
  std::shared_ptr<const WorldModel> model;
  std::uint32_t object = 0;  // the shared body

  /// Returns the shared body's inertia.
  const Inertia& inertia() const {
    return model->bodies[static_cast<std::size_t>(model->body_index[object])].inertia;
  }
};

/// Loads the scene that a case names: a scene file, or one of the lab's own from that folder. The
/// own scenes are free, wall, slot, ball and off_centre, which is free with a grasp 54 mm from the
/// centre. Errors name the file and the fault of the body.
Result<LabScene> LoadLabScene(const LabCase& test, const std::filesystem::path& folder);

}  // namespace tandem
