#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>

#include "collab/lab/lab_case.h"
#include "engine/world/world_model.h"

namespace tandem {

/// A scene of the lab: made once, shared by all threads.
struct LabScene {
  std::shared_ptr<const WorldModel> model;
  std::uint32_t object = 0;  // the shared body

  /// Of the shared body.
  const Inertia& inertia() const {
    return model->bodies[static_cast<std::size_t>(model->body_index[object])].inertia;
  }
};

/// The scene that a case names: one of the lab's own (free, wall, slot, ball; off_centre is free
/// with a grasp 54 mm from the centre) from that folder, or a scene file. Errors name the file, and
/// what is wrong with the body.
Result<LabScene> LoadLabScene(const LabCase& test, const std::filesystem::path& folder);

}  // namespace tandem
