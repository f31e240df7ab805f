// Tests the refined contact model against exact geometry: planes, edges and convex bodies whose gap
// is known in closed form.
#include <array>

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include "engine/contact/features/edge_contact.h"
#include "tests/engine/contact/refined.h"

namespace tandem {
namespace {

using testing::Box;
using testing::kS;
using testing::LowestAlong;
using testing::Plate;
using testing::RandomDirection;
using testing::RandomRotation;
using testing::Refined;
using testing::Sphere;
using testing::Uniform;

constexpr double kRadToDeg = 57.29577951308232;

/// Returns bodies that come down on planes.
std::array<TriangleMesh, 2> Falling() {
  return {Sphere(10 * kS, 4), Box(kS * Vec3(24, 18, 14))};
}

TEST(RefinedContact, ForceBeginsBeforeExactSurfacesMeetAndWithinAVoxel) {
  std::mt19937_64 random(1);
  for (int tilt = 0; tilt < 12; ++tilt) {
    const TriangleMesh body = Falling()[static_cast<std::size_t>(tilt % 2)];
    const Quat q = RandomRotation(random);
    const Vec3 n = q * Vec3::UnitZ();
    Refined refined(Plate(q, Vec3::Zero()), body, RandomRotation(random));
    for (int approach = 0; approach < 10; ++approach) {
      const Quat q_WB = RandomRotation(random);
      const Vec3 along = kS * (q * Vec3(Uniform(random, -30, 30), Uniform(random, -30, 30), 0));
      double gap = 2.0;  // voxels
      while (gap > -1.0 &&
             refined.ForceAt({q_WB, along + (gap * kS - LowestAlong(body, q_WB, n)) * n}).dot(n) <=
                 0) {
        gap -= 0.02;
      }
      EXPECT_GT(gap, 0.0);
      EXPECT_LE(gap, 1.0);
    }
  }
}

TEST(RefinedContact, ForceStandsOnThePlaneAndDoesNotRippleAsTheBodySlides) {
  std::mt19937_64 random(2);
  for (int tilt = 0; tilt < 12; ++tilt) {
    const TriangleMesh body = Falling()[static_cast<std::size_t>(tilt % 2)];
    const Quat q = RandomRotation(random);
    const Vec3 n = q * Vec3::UnitZ();
    Refined refined(Plate(q, Vec3::Zero()), body, RandomRotation(random));
    const Quat q_WB = RandomRotation(random);
    const double height = -0.1 * kS - LowestAlong(body, q_WB, n);
    double sum = 0;
    double squares = 0;
    constexpr int kSamples = 200;
    for (int i = 0; i < kSamples; ++i) {
      const Vec3 along = kS * (0.25 * i - 25) * (q * Vec3(0.8, 0.6, 0));
      const Vec3 force = refined.ForceAt({q_WB, along + height * n});
      EXPECT_LE(std::atan2(force.cross(n).norm(), force.dot(n)) * kRadToDeg, 1.0);
      sum += force.norm();
      squares += force.squaredNorm();
    }
    const double mean = sum / kSamples;
    EXPECT_GT(mean, 0.0);
    EXPECT_LE(std::sqrt(std::max(0.0, squares / kSamples - mean * mean)), 0.05 * mean);
  }
}

TEST(RefinedContact, WrenchesAreEqualAndOpposite) {
  std::mt19937_64 random(3);
  Refined refined(Box(kS * Vec3(60, 40, 30)), Sphere(12 * kS, 3), RandomRotation(random));
  int loaded = 0;
  for (int trial = 0; trial < 100; ++trial) {
    const Pose X_W{RandomRotation(random), RandomDirection(random)};
    const Pose X{RandomRotation(random), kS * Uniform(random, 25, 45) * RandomDirection(random)};
    const BodyMotion shell{X_W * X, {RandomDirection(random), 0.01 * RandomDirection(random)}};
    const BodyMotion map{X_W, {RandomDirection(random), 0.01 * RandomDirection(random)}};
    LinearizedForce on_shell;
    LinearizedForce on_map;
    loaded += refined.pair.Collide(shell, map, on_shell, on_map).pushing_points;
    const Wrench a = AsWrench(on_shell.force);
    const Wrench b = AsWrench(on_map.force);
    EXPECT_NEAR((a.f + b.f).norm(), 0.0, 1e-9 * (1.0 + a.f.norm()));
    const Vec3 moment = a.tau + shell.X_WB.p.cross(a.f) + b.tau + map.X_WB.p.cross(b.f);
    EXPECT_NEAR(moment.norm(), 0.0, 1e-9 * (1.0 + a.f.norm()));
  }
  EXPECT_GT(loaded, 100);
}

// A box that lies on a plane, moved along the normal.
TEST(RefinedContact, StiffnessIsTheDerivativeOfForceOnAPlane) {
  std::mt19937_64 random(4);
  for (int trial = 0; trial < 10; ++trial) {
    const Quat q = RandomRotation(random);
    const Vec3 n = q * Vec3::UnitZ();
    const TriangleMesh body = Box(kS * Vec3(24, 18, 14));
    Refined refined(Plate(q, Vec3::Zero()), body, RandomRotation(random));
    const auto at = [&](double gap) {
      return Pose{q, (gap * kS + 7 * kS) * n};
    };
    const LinearizedForce load = refined.LoadAt(at(0.1));
    constexpr double kStep = 1e-4;  // voxels
    const double slope =
        (refined.ForceAt(at(0.1 - kStep)) - refined.ForceAt(at(0.1 + kStep))).dot(n) /
        (2 * kStep * kS);
    const double stiffness = n.dot(load.stiffness.bottomRightCorner<3, 3>() * n);
    EXPECT_GT(stiffness, 0.0);
    EXPECT_NEAR(slope, stiffness, 0.01 * stiffness);
    const Eigen::SelfAdjointEigenSolver<Mat6> solver(load.stiffness);
    EXPECT_GE(solver.eigenvalues().minCoeff(), -1e-9 * solver.eigenvalues().maxCoeff());
  }
}

// A corner of a turned box slides over a plate and beyond its edge, then along a floor into a wall.
// Steps of a fiftieth of a voxel: the force may not jump by more than a tenth of a voxel's.
TEST(RefinedContact, ForceDoesNotJumpOverAnEdgeNorIntoACorner) {
  std::mt19937_64 random(5);
  const Quat corner_down = Quat::FromTwoVectors(Vec3(1, 1, 1), Vec3(0, 0, -1));
  const TriangleMesh body = Box(kS * Vec3(12, 12, 12));
  for (int trial = 0; trial < 40; ++trial) {
    const Quat q = RandomRotation(random);
    const auto slide = [&](const TriangleMesh& fixed_Q, double from, double to, double gap) {
      Refined refined(Transformed(fixed_Q, {q, Vec3::Zero()}), body, RandomRotation(random));
      const Quat q_WB = q * corner_down;
      const double lowest = LowestAlong(body, q_WB, q * Vec3::UnitZ());
      Vec3 last = Vec3::Zero();
      double largest = 0;
      bool pushed = false;
      for (double x = from; x <= to; x += 0.02) {
        const Vec3 force = refined.ForceAt({q_WB, q * Vec3(x * kS, 0.3 * kS, gap * kS - lowest)});
        if (x > from) largest = std::max(largest, (force - last).norm());
        pushed = pushed || force.norm() > 0;
        last = force;
      }
      EXPECT_TRUE(pushed);
      return largest;
    };
    // the plate ends at x = 0
    const TriangleMesh plate =
        Transformed(Box(kS * Vec3(40, 40, 14)), {Quat::Identity(), kS * Vec3(-20, 0, -7)});
    EXPECT_LE(slide(plate, -6, 3, 0.2), 0.1);
    TriangleMesh corner =
        Transformed(Box(kS * Vec3(60, 40, 14)), {Quat::Identity(), kS * Vec3(0, 0, -7)});
    Append(corner,
           Transformed(Box(kS * Vec3(20, 40, 40)), {Quat::Identity(), kS * Vec3(20, 0, 10)}));
    EXPECT_LE(slide(corner, -10, 0, 0.2), 0.1);
  }
}

constexpr double kBarSide = 16;  // voxels
constexpr double kBarsHeight = kBarSide * 1.4142135623730951;

/// Returns two square bars of 60 voxels on their edges, seen in a frame that stands at `q`: one
/// along x below, and the moving one along y, which touches it from kBarsHeight voxels above.
Refined CrossedBars(const Quat& q, const Quat& made_at, double spacing = 1) {
  const Quat about_x = RotationBy(Vec3(0.7853981633974483, 0, 0));
  const Quat about_y = RotationBy(Vec3(0, 0.7853981633974483, 0));
  return {Transformed(Box(kS * Vec3(60, kBarSide, kBarSide)), {q * about_x, Vec3::Zero()}),
          Transformed(Box(kS * Vec3(kBarSide, 60, kBarSide)), {about_y, Vec3::Zero()}), made_at,
          spacing};
}

TEST(RefinedContact, TwoCrossingEdgesMakeOneContactAlongTheirCommonNormal) {
  std::mt19937_64 random(6);
  for (int trial = 0; trial < 10; ++trial) {
    const Quat q = RandomRotation(random);
    Refined refined = CrossedBars(q, RandomRotation(random));
    const auto at = [&](double gap) {
      return Pose{q, q * Vec3(Uniform(random, -10, 10) * kS, Uniform(random, -10, 10) * kS,
                              (kBarsHeight + gap) * kS)};
    };
    EXPECT_EQ(refined.ForceAt(at(0.6)).norm(), 0.0);
    const Vec3 force = refined.ForceAt(at(0.2));
    // parts of an edge share what lies where they meet
    ASSERT_GE(refined.pair.contacts().size(), 1U);
    ASSERT_LE(refined.pair.contacts().size(), 4U);
    double depth = 0;
    for (const Contact& contact : refined.pair.contacts()) depth += contact.share * contact.depth;
    EXPECT_NEAR((force.normalized() - q * Vec3::UnitZ()).norm(), 0.0, 0.01);
    EXPECT_NEAR(depth, (kRefinedClearance - 0.2) * kS, 0.04 * kS);
  }
}

// Two square bars on their edges, crossing near an end of each, where voxels hold the corner and
// parts of three edges. Half a voxel from both corners and farther the contact is that of mid-edge;
// nearer it may be softer.
TEST(RefinedContact, CrossingEdgesMakeContactNearTheirCorners) {
  std::mt19937_64 random(16);
  for (int trial = 0; trial < 60; ++trial) {
    const Quat q = RandomRotation(random);
    const double spacing = trial < 40 ? 1 : trial < 50 ? 0.4 : 0.2;
    Refined refined = CrossedBars(q, RandomRotation(random), spacing);
    for (const double from_end : {0.1, 0.3, 0.6, 0.9, 1.4, 2.1}) {
      const auto force_at = [&](double gap) {
        const Vec3 p(30 - from_end, 30 - from_end, kBarsHeight + gap);
        return refined.SettledForceAt({q, q * (kS * p)}).dot(q * Vec3::UnitZ());
      };
      if (from_end > 0.5) {
        EXPECT_GE(force_at(0.2), 0.9 * (kRefinedClearance - 0.2))
            << from_end << " voxels from the ends, trial " << trial;
      }
      EXPECT_GE(force_at(-1.0), 0.2) << from_end << " voxels from the ends, trial " << trial;
    }
  }
}

// Two cubes lie on one another, turned about the upright. No corner of one is over the other, so
// their edges bear them alone, eight of which cross.
TEST(RefinedContact, RotatedFacesAreSupportedByTheirEdges) {
  std::mt19937_64 random(17);
  for (int trial = 0; trial < 6; ++trial) {
    const Quat q = RandomRotation(random);
    const TriangleMesh cube = Box(kS * Vec3(20, 20, 20));
    Refined refined(Transformed(cube, {q, Vec3::Zero()}), cube, RandomRotation(random));
    for (const double degrees : {12, 25, 38, 45, 52, 66, 78}) {
      const Quat turned = q * RotationBy(Vec3(0, 0, degrees / kRadToDeg));
      for (const double gap : {0.2, -0.2, -0.6}) {
        const Vec3 beside(Uniform(random, -0.5, 0.5), Uniform(random, -0.5, 0.5), 20 + gap);
        refined.SettledForceAt({turned, q * (kS * beside)});
        double depth = 0;
        for (const Contact& contact : refined.pair.contacts()) {
          depth += contact.share * contact.depth / kS * contact.nhat_V.dot(q * Vec3::UnitZ());
        }
        EXPECT_GT(depth, 0.75 * 8 * (kRefinedClearance - gap)) << degrees << ", gap " << gap;
      }
    }
  }
}

// The number of parts of an edge changes little of what a body's corner, edge and face press with.
// A part counts by its length and by the depth at its middle.
TEST(RefinedContact, FinerPartsPushAsVoxelSizedOnes) {
  std::mt19937_64 random(32);
  int pushed = 0;
  // depths, not forces: these grow faster than the depth that two pieces of an edge share
  const auto depth_at = [](Refined& refined, const Pose& X_WB) {
    refined.ForceAt(X_WB);
    Vec3 depth = Vec3::Zero();
    for (const Contact& contact : refined.pair.contacts()) {
      depth += contact.share * contact.depth / kS * contact.nhat_V;
    }
    return depth;
  };
  for (int trial = 0; trial < 12; ++trial) {
    const Quat q = RandomRotation(random);
    const Quat made_at = RandomRotation(random);
    const double spacing = trial % 4 == 0 ? 0.15 : 0.4;
    // a corner of the box on the plate; the slab's face under a corner of the box; edge across edge
    const TriangleMesh box = Box(kS * Vec3(24, 18, 14));
    const TriangleMesh plate = Plate(q, Vec3::Zero());
    const Quat q_WB = RandomRotation(random);
    const Vec3 n = q * Vec3::UnitZ();
    const TriangleMesh turned = Transformed(box, {q_WB, Vec3::Zero()});
    const TriangleMesh slab =
        Transformed(Box(kS * Vec3(40, 40, 14)), {q, q * (kS * Vec3(0, 0, -7))});
    const Vec3 under = Vec3(-LowestAlong(box, q_WB, n) * n);
    Refined over_one(plate, box, made_at);
    Refined over_finer(plate, box, made_at, spacing);
    Refined under_one(turned, slab, made_at);
    Refined under_finer(turned, slab, made_at, spacing);
    Refined across_one = CrossedBars(q, made_at);
    Refined across_finer = CrossedBars(q, made_at, spacing);
    EXPECT_GT(over_finer.shell.features.point_count(), 2 * over_one.shell.features.point_count());
    for (const double gap : {0.5, 0.4, 0.2, -0.2}) {
      const Pose over{q_WB, under + gap * kS * n};
      const Pose below{Quat::Identity(), -(under + gap * kS * n)};
      const Pose across{q, q * (kS * Vec3(1.3, -0.7, kBarsHeight + gap))};
      const std::array<Vec3, 6> depths{
          depth_at(over_one, over),     depth_at(over_finer, over),
          depth_at(under_one, below),   depth_at(under_finer, below),
          depth_at(across_one, across), depth_at(across_finer, across)};
      for (std::size_t i = 0; i < depths.size(); i += 2) {
        // the three edges of a corner that presses end within a part: an eighth of a voxel each;
        // so do those that cross, in the seam that their parts share
        const double seam = i == 4 ? std::max(0.05, 0.16 * (kRefinedClearance - gap)) : 0.25;
        EXPECT_LE((depths[i] - depths[i + 1]).norm(), seam)
            << "case " << i / 2 << ", gap " << gap << ", trial " << trial;
        pushed += depths[i].norm() > 0 ? 1 : 0;
      }
    }
  }
  EXPECT_GT(pushed, 70);
}

// A corner stands on a face right up to the face's edge and corner, whichever of the two bodies has
// the points. There the face's own voxels are those of its edges.
TEST(RefinedContact, CornerIsSupportedUpToTheFacesEdge) {
  std::mt19937_64 random(17);
  const TriangleMesh body = Box(kS * Vec3(20, 20, 20));
  const TriangleMesh slab =
      Transformed(Box(kS * Vec3(20, 20, 20)), {Quat::Identity(), kS * Vec3(0, 0, -10)});
  const Quat corner_down = Quat::FromTwoVectors(Vec3(1, 1, 1), Vec3(0, 0, -1));
  for (int trial = 0; trial < 60; ++trial) {
    // turned as the lattice, as parts of a scene often stand, and anyhow
    const Quat q = trial < 5 ? Quat::Identity() : RandomRotation(random);
    const Quat about = RotationBy(Vec3(0, 0, Uniform(random, 0, 6)));
    const Quat tilt =
        trial % 2 == 0 ? corner_down : Quat(RotationBy(Vec3(0.6, 0.1, 0)) * corner_down);
    double lowest = 0;
    Vec3 corner = Vec3::Zero();  // lowest one of the body in tilt is lowest
    for (const Vec3& v : body.vertices) {
      const Vec3 at = about * (tilt * v) / kS;
      if (at.z() < lowest) corner = at;
      lowest = std::min(lowest, at.z());
    }
    const Quat made_at = trial < 5 ? q : RandomRotation(random);
    Refined on_slab(Transformed(slab, {q, Vec3::Zero()}), body, made_at);
    Refined under_slab(Transformed(body, {q * about * tilt, Vec3::Zero()}), slab, made_at);
    for (const double x : {0.05, 0.15, 0.3, 0.6, 1.0, 1.6}) {
      for (const double y : {0.05, 0.15, 0.3, 0.6, 1.0, 1.6, 5.0}) {
        for (const double gap : {0.3, -0.1, -0.6}) {
          if (gap < 0 && std::min(x, y) < 0.2 - gap) continue;  // nearer to a face at the side
          const Vec3 place(10 - x, 10 - y, gap);                // the corner's, above the slab
          const Vec3 up = q * Vec3::UnitZ();
          const double force =
              on_slab.FirstForceAt({q * about * tilt, q * (kS * (place - corner))}).dot(up);
          const double other = -under_slab.FirstForceAt({q, q * (kS * (corner - place))}).dot(up);
          const double wanted = 0.2 * (kRefinedClearance - gap);  // no hole
          EXPECT_GE(force, wanted) << x << " " << y << " gap " << gap << " trial " << trial;
          EXPECT_GE(other, wanted) << x << " " << y << " gap " << gap << " under, trial " << trial;
        }
      }
    }
  }
}

TEST(RefinedContact, DropsContactsOfSeparatedBodies) {
  Refined made(Plate(Quat::Identity(), Vec3::Zero()), Box(kS * Vec3(12, 12, 12)), Quat::Identity());
  EXPECT_GT(made.ForceAt({Quat::Identity(), kS * Vec3(0, 0, 6)}).z(), 0.0);
  EXPECT_FALSE(made.pair.contacts().empty());
  made.ForceAt({Quat::Identity(), kS * Vec3(0, 0, 400)});
  EXPECT_TRUE(made.pair.contacts().empty());
}

TEST(RefinedContact, ThinSheetPushesFromBothSides) {
  std::mt19937_64 random(7);
  const TriangleMesh body = Box(kS * Vec3(12, 10, 8));
  for (int trial = 0; trial < 5; ++trial) {
    const Quat q = RandomRotation(random);
    const Vec3 n = q * Vec3::UnitZ();
    const double half = 0.15;  // voxels: both faces lie in one voxel
    Refined refined(Transformed(Box(kS * Vec3(60, 60, 2 * half)), {q, Vec3::Zero()}), body,
                    RandomRotation(random));
    for (const double side : {-1.0, 1.0}) {
      const Vec3 force = refined.ForceAt({q, side * (4 + half + 0.2) * kS * n});
      EXPECT_GT(side * force.dot(n), 0.0) << "side " << side;
      EXPECT_LE(force.cross(n).norm(), 0.05 * force.norm());
    }
  }
}

}  // namespace
}  // namespace tandem
