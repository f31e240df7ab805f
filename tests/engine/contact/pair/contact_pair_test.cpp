#include "engine/contact/pair/contact_pair.h"

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include "engine/geometry/mesh/mass_properties.h"
#include "engine/voxel/build/voxelize.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/shapes.h"

namespace tandem {
namespace {

using testing::Box;
using testing::RandomDirection;
using testing::RandomRotation;
using testing::Sphere;
using testing::Uniform;

constexpr ContactGains kGains{1e4, 20.0};

/// A pair of meshes that stand about the origin.
struct Setting {
  Setting(const TriangleMesh& map_mesh, const TriangleMesh& shell_mesh, double s, int layer,
          ContactGains gains = kGains)
      : voxmap(std::move(*Voxelize(map_mesh, {.voxel_size = s}))),
        shell(std::move(*MakePointshell(shell_mesh, Pose{}, {.spacing = s}))),
        X_BV{Quat::Identity(), voxmap.p_WVo()},
        pair(shell, voxmap, X_BV, 2.0, {.force_layer = layer}, gains) {}

  Voxmap voxmap;
  Pointshell shell;
  Pose X_BV;
  ContactPair pair;
};

Pose RandomPose(std::mt19937_64& random, double reach) {
  return {RandomRotation(random), reach * RandomDirection(random)};
}

TEST(ContactPair, FindsTheContactsOfBruteForce) {
  std::mt19937_64 random(1);
  const double s = 0.02;
  for (const int layer : {0, 1, 2, 6}) {
    Setting setting(Box(Vec3(1.0, 0.6, 0.4)), Sphere(0.3, 3), s, layer);
    for (int trial = 0; trial < 40; ++trial) {
      const Pose X = RandomPose(random, Uniform(random, 0.2, 0.7));
      const Pose X_W = RandomPose(random, 2.0);
      const PoseReading reading = setting.pair.Read({X_W * X, {}}, {X_W, {}});
      int touching = 0;
      int contacts = 0;
      int undecided = 0;  // within float's reach of a voxel's border
      int nearest = 1000;
      for (std::size_t i = 0; i < setting.shell.size(); ++i) {
        const Vec3 v = (setting.X_BV.Inverse() * (X * setting.shell.point(i))) / s;
        const Vec3 cell = v.array().floor();
        const GridIndex voxel{static_cast<int>(cell.x()), static_cast<int>(cell.y()),
                              static_cast<int>(cell.z())};
        const int value = setting.voxmap.Value(Field::kSurface, voxel);
        const int own = setting.voxmap.Value(FieldReadBy(setting.shell.label(i)), voxel);
        const bool close = ((v - cell).array() < 1e-3).any() || ((v - cell).array() > 0.999).any();
        undecided += close ? 1 : 0;
        touching += value <= 2 + layer ? 1 : 0;
        contacts += own <= 2 + layer ? 1 : 0;
        if (value != setting.voxmap.beyond()) nearest = std::min(nearest, std::max(0, value - 2));
      }
      EXPECT_NEAR(reading.touching_points, touching, undecided);
      EXPECT_NEAR(reading.contact_points, contacts, undecided);
      if (nearest < 1000) {
        EXPECT_NEAR(reading.nearest_voxels, nearest, 1);
      }
    }
  }
}

TEST(ContactPair, GivesEqualAndOppositeWrenches) {
  std::mt19937_64 random(2);
  Setting setting(Box(Vec3(1.0, 0.6, 0.4)), Sphere(0.3, 3), 0.02, 2);
  int loaded = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const Pose X_W = RandomPose(random, 1.0);
    const Pose X = RandomPose(random, Uniform(random, 0.3, 0.7));
    const BodyMotion shell{X_W * X, {RandomDirection(random), RandomDirection(random)}};
    const BodyMotion map{X_W, {RandomDirection(random), RandomDirection(random)}};
    LinearizedForce on_shell;
    LinearizedForce on_map;
    loaded += setting.pair.Collide(shell, map, on_shell, on_map).pushing_points;
    const Wrench a = AsWrench(on_shell.force);
    const Wrench b = AsWrench(on_map.force);
    const double scale = 1.0 + a.f.norm();
    EXPECT_NEAR((a.f + b.f).norm(), 0.0, 1e-9 * scale);
    // moments about W's origin
    const Vec3 moment = a.tau + shell.X_WB.p.cross(a.f) + b.tau + map.X_WB.p.cross(b.f);
    EXPECT_NEAR(moment.norm(), 0.0, 1e-9 * scale);
  }
  EXPECT_GT(loaded, 1000);
}

/// Returns the voxels that the shell's points are in, with the shell's body at X.
std::vector<GridIndex> VoxelsOf(const Setting& setting, const Pose& X) {
  std::vector<GridIndex> voxels;
  for (std::size_t i = 0; i < setting.shell.size(); ++i) {
    const Vec3 v =
        (setting.X_BV.Inverse() * (X * setting.shell.point(i))) / setting.voxmap.voxel_size();
    const Vec3 cell = v.array().floor();
    voxels.push_back(
        {static_cast<int>(cell.x()), static_cast<int>(cell.y()), static_cast<int>(cell.z())});
  }
  return voxels;
}

// Where no point changes its voxel, stiffness is minus the change of force with motion, and damping
// with velocity.
TEST(ContactPair, ItsStiffnessAndDampingAreTheDerivativesOfItsForce) {
  std::mt19937_64 random(3);
  Setting setting(Box(Vec3(1.0, 0.6, 0.4)), Sphere(0.3, 3), 0.02, 2);
  int trials = 0;  // those with points that push
  int compared = 0;
  int changed = 0;  // those with a point that changes its voxel, or begins or ends to push
  for (int trial = 0; trial < 200; ++trial) {
    const Pose X = {RandomRotation(random), 0.52 * RandomDirection(random)};
    const Twist V{0.1 * RandomDirection(random), -0.2 * X.p.normalized()};
    LinearizedForce load;
    LinearizedForce unused;
    const PairReport report = setting.pair.Collide({X, V}, {}, load, unused);
    if (report.pushing_points < 10) continue;
    ++trials;
    const Eigen::SelfAdjointEigenSolver<Mat6> eigen(load.stiffness);
    ASSERT_GE(eigen.eigenvalues().minCoeff(), -1e-6 * eigen.eigenvalues().maxCoeff());
    ASSERT_NEAR((load.stiffness - load.stiffness.transpose()).norm(), 0.0, 1e-6);
    // velocity: linear while every loaded point goes on pushing
    for (int axis = 3; axis < 6; ++axis) {
      Twist faster = V;
      faster.v[axis - 3] += 1e-6;
      LinearizedForce moved;
      setting.pair.Collide({X, faster}, {}, moved, unused);
      const Vec6 change = (moved.force - load.force) / 1e-6;
      EXPECT_NEAR((change + load.damping.col(axis)).norm(), 0.0, 1e-4 * load.damping.norm());
    }
    // place: by 1e-7 voxels
    const std::vector<GridIndex> voxels = VoxelsOf(setting, X);
    for (int axis = 3; axis < 6; ++axis) {
      Pose shifted = X;
      constexpr double kStep = 2e-9;
      shifted.p[axis - 3] += kStep;
      LinearizedForce moved;
      const PairReport after = setting.pair.Collide({shifted, V}, {}, moved, unused);
      if (after.pushing_points != report.pushing_points || VoxelsOf(setting, shifted) != voxels) {
        ++changed;
        continue;
      }
      const Vec3 change = (moved.force - load.force).tail<3>() / kStep;
      const Vec3 expected = -load.stiffness.col(axis).tail<3>();
      EXPECT_NEAR((change - expected).norm(), 0.0, 1e-3 * load.stiffness.norm());
      ++compared;
    }
  }
  EXPECT_GE(trials, 30);
  EXPECT_EQ(compared + changed, 3 * trials);
  EXPECT_LT(changed, 0.1 * compared);
}

// Many points: their sum stands on the face, whatever its tilt. Small bodies are off by far more
// (`tandem bench fidelity`).
TEST(ContactPair, ForceOnAFlatCapIsNormalToItsFace) {
  std::mt19937_64 random(5);
  double angles = 0;
  double most = 0;
  constexpr int kTrials = 30;
  for (int trial = 0; trial < kTrials; ++trial) {
    const Quat tilt = RandomRotation(random);
    const TriangleMesh plate = Transformed(Box(Vec3(0.6, 0.6, 0.2)), {tilt, Vec3::Zero()});
    // an edgeless cap: a large sphere pressed in
    Setting setting(plate, Sphere(0.25, 5), 0.01, 2);
    LinearizedForce load;
    LinearizedForce unused;
    const Vec3 normal = tilt * Vec3::UnitZ();
    const Pose X{Quat::Identity(), (0.1 + 0.25 + 0.005) * normal};
    ASSERT_GT(setting.pair.Collide({X, {}}, {}, load, unused).pushing_points, 10);
    const double angle =
        std::acos(std::min(1.0, load.force.tail<3>().normalized().dot(normal))) * 180 / M_PI;
    angles += angle;
    most = std::max(most, angle);
  }
  RecordProperty("mean_degrees", std::to_string(angles / kTrials));
  RecordProperty("most_degrees", std::to_string(most));
  EXPECT_LT(angles / kTrials, 5.0);
  EXPECT_LT(most, 15.0);
}

// docs/decisions/0004-contact-and-step.md: a plane at random tilts, points with the plane's exact
// normal; height at first force in voxels. Sphere against a tilted face: the lowest point's normal
// is nearly the plane's.
TEST(ContactPair, FirstForceOccursWithinTheForceLayer) {
  std::mt19937_64 random(4);
  const double s = 0.01;
  struct Range {
    int layer;
    double least, mean_low, mean_high, most;
  };
  // exact gap at first force of a sphere: means 1.2, 2.7, 4.2; wide enough for 40
  // samples
  for (const Range& range : {Range{0, -0.2, 0.7, 1.8, 3.2}, Range{1, 0.8, 2.1, 3.3, 4.4},
                             Range{2, 1.6, 3.5, 4.8, 5.8}}) {
    double sum = 0;
    constexpr int kTrials = 40;
    for (int trial = 0; trial < kTrials; ++trial) {
      const Quat tilt = RandomRotation(random);
      const TriangleMesh plate = Transformed(Box(Vec3(0.6, 0.6, 0.2)), {tilt, Vec3::Zero()});
      const TriangleMesh ball = Sphere(0.1, 4);
      Setting setting(plate, ball, s, range.layer);
      const Vec3 normal = tilt * Vec3::UnitZ();
      const Vec3 across = tilt * Vec3(Uniform(random, -0.1, 0.1), Uniform(random, -0.1, 0.1), 0);
      const Quat turn = RandomRotation(random);
      double gap = 8 * s;
      for (; gap > -3 * s; gap -= 0.02 * s) {
        LinearizedForce load;
        LinearizedForce unused;
        const Pose X{turn, across + (0.1 + 0.1 + gap) * normal};
        if (setting.pair.Collide({X, {}}, {}, load, unused).pushing_points > 0) break;
      }
      EXPECT_GE(gap / s, range.least);
      EXPECT_LE(gap / s, range.most);
      sum += gap / s;
    }
    EXPECT_GE(sum / kTrials, range.mean_low) << "layer " << range.layer;
    EXPECT_LE(sum / kTrials, range.mean_high) << "layer " << range.layer;
  }
}

// Sinking straight into an axis-aligned face, depth grows as the point sinks, layer after layer,
// and inside.
TEST(TangentPlane, DepthIsContinuousAcrossLayersAndNeverZero) {
  const double s = 0.001;
  const Vec3 nhat(0, 0, 1);
  double last = -1;
  // marks from layer 3 down to the interior, a voxel each, the surface of the solid below z = 0
  for (int step = 0; step <= 5000; ++step) {
    const double z = 4 * s - step * 1e-6;
    const double cell = std::floor(z / s);
    const int value = std::max(1, static_cast<int>(cell) + 2);
    const double depth = TangentPlaneDepth({0, 0, z}, {0, 0, (cell + 0.5) * s}, nhat, value, 2, s);
    if (step > 0 && value > 1) {
      EXPECT_NEAR(depth - last, 1e-6, 1e-9) << "at " << z;
    }
    last = depth;
    if (value <= 3) {
      EXPECT_GT(depth, 0);
    }
  }
}

// docs/decisions/0003-exact-voxels.md: far poses read nothing at layer 0, exact surfaces that meet
// read some point at distance
// <= 1.
TEST(ContactPair, FarPosesNeverTouchAndOverlappingPosesAlwaysDo) {
  std::mt19937_64 random(6);
  const double s = 0.02;
  const double radius = 0.3;
  Setting far(Box(Vec3(1.0, 0.6, 0.4)), Sphere(radius, 4), s, 0);
  Setting meeting(Box(Vec3(1.0, 0.6, 0.4)), Sphere(radius, 4), s, 1);
  int touched = 0;
  for (int trial = 0; trial < 200; ++trial) {
    // distance of the sphere's centre from the box, exactly
    const Vec3 centre =
        1.2 * Vec3(Uniform(random, -1, 1), Uniform(random, -1, 1), Uniform(random, -1, 1));
    const Vec3 outside = (centre.cwiseAbs() - Vec3(0.5, 0.3, 0.2)).cwiseMax(0.0);
    const Pose X{RandomRotation(random), centre};
    const double gap = outside.norm() - radius;
    if (gap > 2.6 * s) {
      EXPECT_EQ(far.pair.Read({X, {}}, {}).touching_points, 0) << gap / s;
    } else if (gap < -0.01 * radius && outside.norm() > 0) {
      EXPECT_GT(meeting.pair.Read({X, {}}, {}).touching_points, 0) << gap / s;
      ++touched;
    }
  }
  EXPECT_GT(touched, 10);
}

// Travel is what the bodies come nearer: a body that is carried along owes no tests for it.
TEST(ContactPair, BodiesAtRelativeRestNeedNoTests) {
  std::mt19937_64 random(8);
  const double s = 0.01;
  Setting setting(Box(Vec3(0.5, 0.3, 0.2)), Sphere(0.12, 4), s, 1);
  const Pose X_MS{RandomRotation(random), Vec3(0, 0, 0.1 + 0.12 + 4 * s)};
  Pose X_WM = RandomPose(random, 1.0);
  const auto collide = [&] {
    LinearizedForce on_shell;
    LinearizedForce on_map;
    return setting.pair.Collide({X_WM * X_MS, {}}, {X_WM, {}}, on_shell, on_map).tests;
  };
  collide();
  const std::size_t at_rest = collide().looked_up;
  std::size_t carried = 0;
  std::size_t apart = 0;
  for (int frame = 0; frame < 50; ++frame) {
    X_WM = {(RotationBy(0.01 * RandomDirection(random)) * X_WM.q).normalized(),
            X_WM.p + 0.4 * s * RandomDirection(random)};
    const TestCounts tests = collide();
    carried = std::max(carried, tests.looked_up);
  }
  EXPECT_EQ(carried, at_rest);
  for (int frame = 0; frame < 50; ++frame) {
    X_WM.p += 0.4 * s * RandomDirection(random);
    LinearizedForce on_shell;
    LinearizedForce on_map;
    const Pose stays = X_WM * X_MS;
    const BodyMotion map{{X_WM.q, X_WM.p + 0.4 * s * RandomDirection(random)}, {}};
    const TestCounts tests = setting.pair.Collide({stays, {}}, map, on_shell, on_map).tests;
    apart = std::max(apart, tests.looked_up);
  }
  EXPECT_GT(apart, at_rest);
}

// Two square bars on their edges, one across the other: the plain model reads only how far the
// other edge is, on whichever side. It pushes them apart as they meet, and lets go once they are
// through.
TEST(ContactPair, CrossingEdgesPushWithinTheForceLayerOnly) {
  std::mt19937_64 random(16);
  const double s = 0.001;
  const Quat about_x = RotationBy(Vec3(0.7853981633974483, 0, 0));
  const Quat about_y = RotationBy(Vec3(0, 0.7853981633974483, 0));
  for (int trial = 0; trial < 10; ++trial) {
    const Quat q = RandomRotation(random);
    Setting setting(Transformed(Box(s * Vec3(60, 16, 16)), {q * about_x, Vec3::Zero()}),
                    Transformed(Box(s * Vec3(16, 60, 16)), {q * about_y, Vec3::Zero()}), s, 2);
    const auto read = [&](double gap) {
      const Vec3 p(0.3, 0.2, 16 * std::sqrt(2.0) + gap);
      return setting.pair.Read({{Quat::Identity(), q * (s * p)}, {}}, {});
    };
    for (const double gap : {0.5, 0.0, -0.5}) {
      EXPECT_GT((q.conjugate() * AsWrench(read(gap).on_shell.force).f).z(), 0.0)
          << "gap " << gap << ", trial " << trial;
    }
    // halfway to the next edges; as docs/decisions/0008-labels.md says of a beam through a beam: no
    // contact, though surfaces touch
    const PoseReading through = read(-4 * std::sqrt(2.0));
    EXPECT_EQ(through.contact_points, 0);
    EXPECT_GT(through.touching_points, 0);
  }
}

TEST(ContactPair, DistantBodiesReadNoVoxels) {
  Setting setting(Box(Vec3(1.0, 0.6, 0.4)), Sphere(0.3, 2), 0.02, 2);
  for (const double distance : {10.0, 1e6, 1e30}) {
    const PoseReading reading =
        setting.pair.Read({{Quat::Identity(), Vec3(distance, -distance, distance)}, {}}, {});
    EXPECT_EQ(reading.touching_points, 0);
    EXPECT_EQ(reading.nearest_voxels, std::numeric_limits<int>::max());
  }
}

TEST(ContactPair, CollidingAllocatesNothing) {
  Setting setting(Box(Vec3(1.0, 0.6, 0.4)), Sphere(0.3, 4), 0.02, 2);
  LinearizedForce load;
  LinearizedForce other;
  int loaded = 0;
  const testing::AllocationCounter counter;
  for (int i = 0; i < 100; ++i) {
    loaded +=
        setting.pair.Collide({{Quat::Identity(), Vec3(0, 0, 0.6 - 0.002 * i)}, {}}, {}, load, other)
            .pushing_points;
  }
  EXPECT_EQ(counter.count(), 0);
  EXPECT_GT(loaded, 0);
}

}  // namespace
}  // namespace tandem
