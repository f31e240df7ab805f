// Tests the contact of balls and cylinders by the places that face the other body, against that of
// their features.
#include "engine/contact/field/round_contacts.h"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/engine/contact/refined.h"
#include "tests/support/round_shapes.h"

namespace tandem {
namespace {

using testing::At;
using testing::Box;
using testing::Cylinder;
using testing::HollowBlock;
using testing::kGains;
using testing::kS;
using testing::RandomDirection;
using testing::RandomRotation;
using testing::Sphere;
using testing::SurfaceOf;
using testing::Uniform;

constexpr double kRoundRadius = 0.01;

BodySurface RoundSurfaceOf(const TriangleMesh& mesh) {
  BodySurface surface = SurfaceOf(mesh, Quat::Identity());
  surface.rounds = FindRoundFeatures(mesh, surface.field.p_WVo(), kS, surface.features);
  return surface;
}

/// A fixed solid and a round body above it, which rolls or not.
struct RoundPair {
  RoundPair(const TriangleMesh& fixed, const TriangleMesh& moving)
      : map(SurfaceOf(fixed, Quat::Identity())),
        shell(RoundSurfaceOf(moving)),
        pair(shell, map, {}, kGains) {}

  Vec6 LoadAt(const Pose& X_WB, bool rolls) {
    return pair.Read({X_WB, {}, rolls}, {}).on_shell.force;
  }
  double ForceAt(const Pose& X_WB, bool rolls) { return LoadAt(X_WB, rolls).tail<3>().norm(); }

  BodySurface map;
  BodySurface shell;
  FieldPair pair;
};

TriangleMesh RoundsPlate(double voxels) {
  return At(Box(Vec3(0.08, 0.08, voxels * kS)), Vec3(0, 0, -0.5 * voxels * kS));
}

/// Turns of a ball, and of a cylinder along y.
Quat AnyTurn(std::mt19937_64& random, bool ball) {
  if (ball) return RandomRotation(random);
  return RotationBy(Vec3(0, 0, Uniform(random, 0, 6))) *
         RotationBy(Vec3(0, Uniform(random, 0, 6), 0));
}

TEST(RoundFeatures, BallsAndCylindersHaveOneAndTheirFeaturesLieOnIt) {
  for (const TriangleMesh& mesh : {Sphere(kRoundRadius, 4), Cylinder(kRoundRadius, 0.02, 64)}) {
    const BodySurface surface = RoundSurfaceOf(mesh);
    ASSERT_EQ(surface.rounds.rounds.size(), 1U);
    const RoundFeatures::Round& round = surface.rounds.rounds[0];
    EXPECT_NEAR(round.surface.radius, kRoundRadius / kS, 1e-6);
    EXPECT_GT(round.cap, 2 * round.surface.sagitta);
    std::size_t on = 0;
    for (const std::uint8_t of_point : surface.rounds.of_point) on += of_point == 0 ? 1 : 0;
    EXPECT_GT(on, surface.features.point_count() / 2);
  }
}

// The wall of the hollow is a sphere, but it bends the other way.
TEST(RoundFeatures, AHollowHasNone) {
  EXPECT_TRUE(RoundSurfaceOf(HollowBlock(0.03, kRoundRadius)).rounds.empty());
}

// However it is turned, a ball or cylinder presses a plane at one depth, straight, and no moment
// turns it about its axis.
TEST(RoundContacts, PressAPlaneAlikeHoweverTheyAreTurned) {
  std::mt19937_64 random(5);
  for (const bool ball : {true, false}) {
    RoundPair scene(RoundsPlate(6),
                    ball ? Sphere(kRoundRadius, 4) : Cylinder(kRoundRadius, 0.02, 64));
    double least = 1e9;
    double most = 0;
    for (int trial = 0; trial < 50; ++trial) {
      const Quat q = AnyTurn(random, ball);
      const Vec3 p(Uniform(random, -0.01, 0.01), Uniform(random, -0.01, 0.01),
                   kRoundRadius + 0.25 * kS);
      const Vec6 load = scene.LoadAt({q, p}, true);
      const double force = load.tail<3>().norm();
      least = std::min(least, force);
      most = std::max(most, force);
      EXPECT_GT(load[5], 0.9999 * force);
      const Vec3 about = ball ? Vec3(load.head<3>().normalized()) : Vec3(q * Vec3::UnitY());
      EXPECT_LT(std::abs(load.head<3>().dot(about)), 2e-3 * kRoundRadius * force) << trial;
    }
    EXPECT_GT(least, 0.1);
    EXPECT_LT(most, 1.002 * least) << (ball ? "ball" : "cylinder");
  }
}

// From before contact to beyond the other side of thin plates and deep in thick ones: wherever
// features push, the body is pushed, the same way.
TEST(RoundContacts, NeverLoseThePushOfFeatures) {
  std::mt19937_64 random(6);
  for (const bool ball : {true, false}) {
    for (const double thick : {0.3, 1.0, 6.0}) {
      RoundPair scene(RoundsPlate(thick),
                      ball ? Sphere(kRoundRadius, 4) : Cylinder(kRoundRadius, 0.02, 64));
      for (int trial = 0; trial < 10; ++trial) {
        const Quat q = AnyTurn(random, ball);
        for (double deep = -0.1; deep < 2.5; deep += 0.02) {
          const Pose X_WB{q, Vec3(0, 0, kRoundRadius + (0.45 - deep) * kS)};
          const double by_features = scene.LoadAt(X_WB, false)[5];
          const double force = scene.LoadAt(X_WB, true)[5];
          if (!(by_features > 0)) continue;
          ASSERT_GT(force, 0) << thick << " voxels, " << deep << " deep";
          // at least a share of what one place bears, or the features if they bear less
          const double one = 1e-3 * 1000 * std::min(deep, 1.0) * 0.3;
          ASSERT_GT(force, std::min(by_features, one) * 0.3) << thick << " voxels, " << deep;
        }
      }
    }
  }
}

// Where force begins as far out as the field reaches, features cannot be looked up beyond it.
TEST(RoundContacts, LeaveFeaturesWhereTheFieldEnds) {
  RoundPair scene(RoundsPlate(6), Sphere(kRoundRadius, 4));
  scene.pair.SetClearance({10, 0});
  const double range = scene.map.field.range();
  std::mt19937_64 random(7);
  int pushed = 0;
  for (int trial = 0; trial < 100; ++trial) {
    const Pose X_WB{RandomRotation(random),
                    Vec3(0, 0, kRoundRadius + Uniform(random, range - 0.5, range + 0.05) * kS)};
    const double by_features = scene.ForceAt(X_WB, false);
    pushed += by_features > 0 ? 1 : 0;
    EXPECT_EQ(scene.ForceAt(X_WB, true), by_features);
  }
  EXPECT_GT(pushed, 20);
}

/// Returns the number of steps of the load above `jump` (N, and N for moments over the radius) that
/// are left on the way from one pose to another when steps are cut down to nothing.
int CountJumpsOf(RoundPair& scene, double jump, const auto& pose_at) {
  constexpr int kSteps = 64;
  const auto load = [&](double share) {
    Vec6 at = scene.LoadAt(pose_at(share), true);
    at.head<3>() /= kRoundRadius;
    return at;
  };
  int jumps = 0;
  Vec6 next = load(0);
  for (int step = 0; step < kSteps; ++step) {
    double low = step / static_cast<double>(kSteps);
    double high = low + 1.0 / kSteps;
    Vec6 below = next;
    Vec6 above = next = load(high);
    for (int cut = 0; cut < 20 && (above - below).norm() > jump; ++cut) {
      const double middle = 0.5 * (low + high);
      const Vec6 between = load(middle);
      const bool lower = (between - below).norm() > (above - between).norm();
      (lower ? high : low) = middle;
      (lower ? above : below) = between;
    }
    jumps += (above - below).norm() > jump ? 1 : 0;
  }
  return jumps;
}

// On a plane, in a groove, on another ball and in a hollow. A voxel of depth on one place is 1 N.
// On another ball the features of both jump by themselves. Wide hollows, in which features crowd,
// are not among the scenes: there the push is not continuous (decision 0067).
TEST(RoundContacts, ForceDoesNotJumpAsTheyTurnAndMove) {
  std::mt19937_64 random(8);
  const TriangleMesh groove =
      At(Box(Vec3(0.03, 0.03, 0.03)), Vec3::Zero(), RotationBy(Vec3(0, std::atan(1.0), 0)));
  TriangleMesh grooved = At(groove, Vec3(-0.0212, 0, 0));
  Append(grooved, At(groove, Vec3(0.0213, 0, 0)));
  struct Scene {
    TriangleMesh fixed;
    Vec3 p;
    double jump = 0.003;
  };
  const double touch = kRoundRadius + 0.2 * kS;
  const std::vector<Scene> scenes{
      {RoundsPlate(6), Vec3(0, 0, touch)},
      {grooved, Vec3(0, 0, std::sqrt(2.0) * touch)},
      {Sphere(0.02, 5), Vec3(0, 0, touch + 0.02), 0.06},
      {HollowBlock(0.04, kRoundRadius + 0.5 * kS), Vec3(0, 0, -0.2 * kS)}};
  for (std::size_t s = 0; s < scenes.size(); ++s) {
    for (const bool ball : {true, false}) {
      if (!ball && s > 2) continue;
      RoundPair scene(scenes[s].fixed,
                      ball ? Sphere(kRoundRadius, 4) : Cylinder(kRoundRadius, 0.02, 64));
      int jumps = 0;
      for (int way = 0; way < 6; ++way) {
        const bool along = s == 1;  // a cylinder lies along its groove
        const Quat q =
            ball || !along ? AnyTurn(random, ball) : RotationBy(Vec3(0, Uniform(random, 0, 6), 0));
        const Vec3 turn = ball ? Vec3(0.2 * RandomDirection(random)) : Vec3(q * Vec3(0, 0.2, 0));
        const Vec3 go = 0.3 * kS * RandomDirection(random);
        jumps += CountJumpsOf(scene, scenes[s].jump, [&](double share) {
          return Pose{RotationBy(share * turn) * q, scenes[s].p + share * go};
        });
      }
      EXPECT_EQ(jumps, 0) << "scene " << s << (ball ? ", ball" : ", cylinder");
    }
  }
}

}  // namespace
}  // namespace tandem
