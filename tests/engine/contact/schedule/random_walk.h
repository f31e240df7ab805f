#pragma once

#include <cstdint>
#include <cstdlib>
#include <limits>
#include <memory>
#include <random>

#include "engine/contact/schedule/schedule.h"
#include "engine/voxel/build/voxelize.h"
#include "tests/support/shapes.h"
#include "tests/support/untested_points.h"

namespace tandem::testing {

inline constexpr double kVoxel = 0.01;

struct Bodies {
  Bodies(const TriangleMesh& map_mesh, const TriangleMesh& shell_mesh, double voxel = kVoxel,
         int range = kDefaultRange, double spacing = 1)
      : voxmap(std::move(
            *Voxelize(map_mesh, {.voxel_size = voxel, .range = range, .bits = BitsFor(range)}))),
        shell(std::move(*MakePointshell(shell_mesh, Pose{}, {.spacing = spacing * voxel}))),
        blocks(shell),
        map_radius(BoundsOf(map_mesh).size().norm() / 2) {}

  Voxmap voxmap;
  Pointshell shell;
  PointBlocks blocks;
  double map_radius;
  Pose X_MV() const { return {Quat::Identity(), voxmap.p_WVo()}; }
};

/// A body that moves at random: its speed changes at random, and something pulls it back.
struct RandomWalker {
  Pose X_WB;
  Vec3 velocity = Vec3::Zero();
  Vec3 spin = Vec3::Zero();

  void Push(std::mt19937_64& random, const Vec3& home) {
    velocity = 0.97 * velocity +
               0.03 * (Uniform(random, 0, 1) * RandomDirection(random) + 2.0 * (home - X_WB.p));
    spin = 0.97 * spin + 0.03 * Uniform(random, 0, 8) * RandomDirection(random);
  }
  /// Moves so that no surface point goes farther than `travel`, and returns the way that was made.
  double Move(double travel, double radius) {
    const double wanted = TravelOf(velocity, spin.norm(), radius);
    const double scale = wanted > travel ? travel / wanted : 1.0;
    velocity *= scale;
    spin *= scale;
    X_WB.p += velocity;
    X_WB.q = (RotationBy(spin) * X_WB.q).normalized();
    return TravelOf(velocity, spin.norm(), radius);
  }
};

struct Outcome {
  std::size_t missed = 0;
  double point_frames = 0;
  double squeezed = 0;  // share of frames with MaxTravel below its bound
  double contacts = 0;
  double tests = 0;    // points looked up a frame
  double drifted = 0;  // points put back a frame
  double over = 0;     // share of frames with more look-ups than a fifth above capacity
};

/// Two bodies move at random for some frames, held to MaxTravel; force layer and displacement
/// change.
inline Outcome RunRandomWalk(const Bodies& bodies, const ScheduleOptions& options, double capacity,
                             int frames, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const std::unique_ptr<Schedule> schedule = MakeSchedule(bodies.blocks, bodies.voxmap, 1, options);
  RandomWalker shell;
  RandomWalker map;
  shell.X_WB = {RandomRotation(random), 0.4 * RandomDirection(random)};
  double travel = std::numeric_limits<double>::infinity();
  Outcome outcome;
  for (int frame = 0; frame < frames; ++frame) {
    const Pose X_WV = map.X_WB * bodies.X_MV();
    if (frame % 500 == 250) {
      schedule->SetForceLayer(static_cast<int>(random() % 4));
    }
    if (frame % 300 == 150) schedule->SetDisplacement(Uniform(random, -1.0, 1.0) * kVoxel);
    schedule->Test(X_WV.Inverse() * shell.X_WB, travel);
    outcome.missed += UntestedPoints(bodies.blocks, bodies.voxmap, *schedule);
    outcome.point_frames += static_cast<double>(bodies.shell.size());
    outcome.tests += static_cast<double>(schedule->counts().looked_up);
    outcome.drifted += static_cast<double>(schedule->counts().drifted);
    outcome.contacts += static_cast<double>(schedule->contacts().size());
    outcome.over += static_cast<double>(schedule->counts().looked_up) > 1.2 * capacity;
    const TestDemand demand = schedule->Demand();
    const double most = MaxTravel(demand, capacity, 0, kVoxel);
    schedule->LimitTravel(most);
    outcome.squeezed += most < 0.999 * demand.bound;
    shell.Push(random, Vec3::Zero());
    map.Push(random, Vec3(0.1, 0, 0));
    const double reach = 3 * kVoxel;  // displacement
    travel = shell.Move(0.5 * most, bodies.shell.radius + reach);
    travel += map.Move(0.5 * most, bodies.map_radius + reach);
  }
  outcome.squeezed /= frames;
  outcome.contacts /= frames;
  outcome.tests /= frames;
  outcome.drifted /= frames;
  outcome.over /= frames;
  return outcome;
}

/// Returns the point-frames of a trial. TANDEM_POINT_FRAMES asks for the long run.
inline double PointFrames() {
  const char* requested = std::getenv("TANDEM_POINT_FRAMES");
  return requested != nullptr ? std::atof(requested) : 2e7;
}

/// Returns two rods. `spacing` is that of the points, voxels.
inline Bodies Rods(int range = kDefaultRange, double spacing = 1) {
  return {Box(Vec3(0.5, 0.3, 0.2)), Box(Vec3(0.45, 0.08, 0.06)), kVoxel, range, spacing};
}

}  // namespace tandem::testing
