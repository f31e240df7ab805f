#pragma once

#include <memory>
#include <vector>

#include "engine/world/world.h"

namespace tandem::testing {

inline constexpr double kVoxel = 0.001;  // m, in most worlds of the tests

/// A body of a world made in code, with no files: its mesh where it stands at first.
struct TestBody {
  TriangleMesh mesh_W;
  bool fixed = false;
  double mass = 0.3;  // kg
};

/// Returns what LoadWorld() makes of a scene, from meshes.
std::shared_ptr<const WorldModel> MakeWorldModel(const std::vector<TestBody>& bodies,
                                                 double voxel_size,
                                                 ContactModel contact = ContactModel::kRefined);

/// Returns inputs under which every moving body is simulated and no hand holds anything.
StepInputs FreeInputs(const WorldModel& model);

/// Returns the default hand, holding a body at its centre of mass and pulling it to a pose at rest.
StepInputs::Hand HandTo(const WorldModel& model, int body, const Pose& X_WG);

/// Steps a world by that many frames of the same inputs.
void RunFrames(World& world, const StepInputs& inputs, int frames);

/// Returns the corners of a moving body's mesh, in its frame.
std::vector<Vec3> CornersOf(const WorldModel& model, std::size_t body);

double KineticEnergy(const WorldModel& model, std::size_t body, const RigidState& state);

}  // namespace tandem::testing
