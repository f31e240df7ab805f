#pragma once

#include <memory>

#include "engine/paging/voxel_arena.h"
#include "engine/world/world_model.h"
#include "tests/support/delayed_pages.h"
#include "tests/support/shapes.h"
#include "tests/support/test_world.h"

namespace tandem::testing {

/// Returns a box on a plate with bars across, a hundred hyperchunks long, along which a hand may
/// drag it.
inline std::shared_ptr<const WorldModel> Washboard() {
  const double length = 6000 * kVoxel;
  TriangleMesh plate = At(Box(Vec3(length, 0.1, 0.01)), Vec3(0.5 * length, 0, -0.005));
  for (int k = 1; k < 40; ++k) {
    Append(plate, At(Box(Vec3(0.004, 0.09, 0.004)), Vec3(0.025 * length * k, 0, 0.0021)));
  }
  return MakeWorldModel({{plate, true}, {At(Box(Vec3(0.03, 0.02, 0.012)), Vec3(0.06, 0, 0.012))}},
                        kVoxel, ContactModel::kPlain);
}

/// Returns the same model with a megabyte for its fixture's pages.
inline std::shared_ptr<WorldModel> PagedModel(const WorldModel& whole,
                                              const std::shared_ptr<DelayedPages>& pages) {
  auto paged = std::make_shared<WorldModel>(whole);
  paged->fixture = {};
  paged->fixture_pages = pages;
  paged->voxel_memory_bytes = VoxelArena::FixedBytes(pages->outline()) + (1U << 20U);
  return paged;
}

}  // namespace tandem::testing
