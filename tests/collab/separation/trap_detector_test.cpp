#include "collab/separation/trap_detector.h"

#include <gtest/gtest.h>

#include "engine/base/units.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/shapes.h"
#include "tests/support/test_world.h"

namespace tandem {
namespace {

using testing::At;
using testing::Box;

constexpr PeerId kPartner = 7;

/// Returns a shared cube of 20 mm, which stands at the origin, and a fixture.
std::shared_ptr<const WorldModel> CubeAnd(const TriangleMesh& fixture, double voxel = 0.001,
                                          ContactModel contact = ContactModel::kRefined) {
  auto model = std::make_shared<WorldModel>(
      *testing::MakeWorldModel({{fixture, true}, {Box(Vec3(0.02, 0.02, 0.02))}}, voxel, contact));
  model->scene.bodies[1].shared = true;
  return model;
}

/// Returns a wall of that thickness in the plane x = 0, 200 mm wide, turned.
TriangleMesh Wall(double thickness, const Quat& q = Quat::Identity()) {
  return At(Box(Vec3(thickness, 0.2, 0.2)), Vec3::Zero(), q);
}

Pose Place(const Vec3& p, const Quat& q = Quat::Identity()) {
  return {q, p};
}

/// Looks for so long at two instances that move as `path` says, by the time in s. Returns when the
/// other was found to be trapped, or -1.
template <typename Path>
double FoundAfter(TrapDetector& detector, double seconds, const Path& path) {
  const auto frames = static_cast<int>(1000 * seconds);
  for (int i = 1; i <= frames; ++i) {
    const auto [ours, theirs] = path(1e-3 * i);
    const InstanceView other{kPartner, theirs};
    detector.Update(i * kMs, ours, &other, 1);
    if (detector.trapped(kPartner)) return 1e-3 * i;
  }
  return -1;
}

template <typename Path>
double FoundAfter(const std::shared_ptr<const WorldModel>& model, double seconds,
                  const Path& path) {
  TrapDetector detector(*model);
  detector.Begin(0);
  return FoundAfter(detector, seconds, path);
}

auto Standing(const Vec3& ours, const Vec3& theirs) {
  return [=](double) {
    return std::pair(Place(ours), Place(theirs));
  };
}

TEST(TrapDetector, FindsAWallBetweenRestingInstances) {
  for (const double thickness : {0.002, 0.005, 0.02}) {
    for (const double apart : {0.03, 0.15}) {
      const double found = FoundAfter(CubeAnd(Wall(thickness)), 1.0,
                                      Standing(Vec3(apart, 0, 0), Vec3(-apart, 0.01, 0)));
      EXPECT_GE(found, 0.6) << thickness << " " << apart;
      EXPECT_LT(found, 0.65) << thickness << " " << apart;
    }
  }
}

TEST(TrapDetector, FindsAWallAcrossTheGrid) {
  const Quat q = RotationBy(Vec3(0.3, 0.5, 0.4));
  const auto model = CubeAnd(Wall(0.003, q));
  EXPECT_GT(FoundAfter(model, 1.0, Standing(q * Vec3(0.03, 0, 0), q * Vec3(-0.03, 0, 0))), 0.5);
}

// One model looks by voxels, which any wall fills, the other by distances, which pass no wall
// however thin it is.
TEST(TrapDetector, FindsAThinWallAndASheetInBothContactModels) {
  const Quat q = RotationBy(Vec3(0.3, 0.5, 0.4));
  const Quat upright = RotationBy(Vec3(0, M_PI / 2, 0));
  const Vec3 off(0.03, 0.004, 0.002);
  for (const ContactModel contact : {ContactModel::kPlain, ContactModel::kRefined}) {
    for (const TriangleMesh& wall :
         {Wall(0.0001, q), At(testing::Sheet(0.2), Vec3::Zero(), q * upright)}) {
      const auto model = CubeAnd(wall, 0.001, contact);
      EXPECT_GT(FoundAfter(model, 1.0, Standing(q * off, q * -off)), 0.5);
      EXPECT_LT(FoundAfter(model, 1.0, Standing(q * off, q * (off + Vec3(0.01, 0.03, 0)))), 0);
    }
  }
}

TEST(TrapDetector, IgnoresAFreePath) {
  const auto model = CubeAnd(Wall(0.005));
  EXPECT_LT(FoundAfter(model, 2.0, Standing(Vec3(0.02, 0.05, 0), Vec3(0.02, -0.05, 0))), 0);
  EXPECT_LT(FoundAfter(model, 2.0, Standing(Vec3(0.1, 0.15, 0), Vec3(-0.1, 0.15, 0))), 0);
}

// Both lie on the same slope, which goes across the grid, 60 mm from one another. Lines that
// touched its voxels along the way would see a wall.
TEST(TrapDetector, IgnoresAWallThatBothInstancesTouch) {
  const Quat q = RotationBy(Vec3(0.0, 0.2, 0.13));
  const auto model = CubeAnd(Wall(0.01, q));
  for (const double gap : {0.0, 0.001}) {
    const double off = 0.005 + 0.01 + gap;
    const auto path = [&](double) {
      return std::pair(Place(q * Vec3(off, 0.03, 0.0), q), Place(q * Vec3(off, -0.03, 0.01), q));
    };
    EXPECT_LT(FoundAfter(model, 2.0, path), 0) << gap;
  }
}

// The line crosses the wall for a while as it goes round the wall's edge, but the two come nearer
// all the time.
TEST(TrapDetector, IgnoresApproachingInstances) {
  const auto model = CubeAnd(Wall(0.005));
  const auto path = [](double t) {
    return std::pair(Place(Vec3(0.05, 0.06 + 0.03 * t, 0)), Place(Vec3(-0.05 + 0.02 * t, 0.02, 0)));
  };
  const auto nearer = [](double t) {
    return std::pair(Place(Vec3(0.08 - 0.02 * t, 0, 0)), Place(Vec3(-0.05, 0, 0)));
  };
  EXPECT_LT(FoundAfter(model, 2.0, nearer), 0);
  EXPECT_GT(FoundAfter(model, 2.0, path), 0);  // these only go past one another
}

TEST(TrapDetector, IgnoresSmallDistances) {
  const auto model = CubeAnd(Wall(0.001), 0.0005);
  // two points that a wall of 1 mm parts; bodies overlap it, only their centres are seen
  EXPECT_LT(FoundAfter(model, 2.0, Standing(Vec3(0.0035, 0, 0), Vec3(-0.0035, 0, 0))), 0);
}

// ReturnPath seeks the way back in what was seen within 50 ms.
TEST(TrapDetector, FindsAWallWithinFiftyFrames) {
  const auto model = CubeAnd(Wall(0.001), 0.0005);
  for (std::size_t count = 1; count <= kMaxLinks; ++count) {
    TrapDetector detector(*model);
    detector.Begin(0);
    std::array<InstanceView, kMaxLinks> others;
    for (std::size_t i = 0; i < count; ++i) others[i] = {10 + i, Place(Vec3(0.0035, 0, 0))};
    for (int i = 1; i <= 100; ++i) detector.Update(i * kMs, others[0].X_WB, others.data(), count);
    // all go through the wall
    for (int i = 101; i <= 150; ++i) {
      detector.Update(i * kMs, Place(Vec3(-0.0035, 0, 0)), others.data(), count);
    }
    for (std::size_t i = 0; i < count; ++i) EXPECT_TRUE(detector.blocked(10 + i)) << count;
    for (int i = 151; i <= 200; ++i) detector.Update(i * kMs, others[0].X_WB, others.data(), count);
    for (std::size_t i = 0; i < count; ++i) EXPECT_FALSE(detector.blocked(10 + i)) << count;
  }
}

// A ring on its peg has its centre in the peg: along it is no wall, off it is.
TEST(TrapDetector, RingOnAPegIsFreeAlongIt) {
  TriangleMesh ring = At(Box(Vec3(0.06, 0.01, 0.01)), Vec3(0, 0.025, 0));
  Append(ring, At(Box(Vec3(0.06, 0.01, 0.01)), Vec3(0, -0.025, 0)));
  Append(ring, At(Box(Vec3(0.01, 0.04, 0.01)), Vec3(0.025, 0, 0)));
  Append(ring, At(Box(Vec3(0.01, 0.04, 0.01)), Vec3(-0.025, 0, 0)));
  auto model = std::make_shared<WorldModel>(
      *testing::MakeWorldModel({{Box(Vec3(0.02, 0.02, 0.3)), true}, {ring}}, 0.001));
  model->scene.bodies[1].shared = true;
  const Vec3 c = model->bodies[0].X_WB0.p;
  EXPECT_LT(FoundAfter(model, 2.0, Standing(c, c + Vec3(0, 0, 0.06))), 0);
  EXPECT_GT(FoundAfter(model, 2.0, Standing(c, c + Vec3(0.1, 0, 0))), 0);
}

TEST(TrapDetector, EndsWhenThePathIsFree) {
  const auto model = CubeAnd(Wall(0.005));
  TrapDetector detector(*model);
  detector.Begin(0);
  ASSERT_GT(FoundAfter(detector, 1.0, Standing(Vec3(0.03, 0, 0), Vec3(-0.03, 0, 0))), 0);
  const InstanceView other{kPartner, Place(Vec3(0.04, 0, 0))};
  for (int i = 0; i < 20; ++i) {
    detector.Update(2000 * kMs + i * kMs, Place(Vec3(0.03, 0, 0)), &other, 1);
  }
  EXPECT_FALSE(detector.trapped(kPartner));
  EXPECT_FALSE(detector.blocked(kPartner));
}

// Seven others, every second one behind the wall; a frame reads few voxels and allocates nothing.
TEST(TrapDetector, ChecksSevenCoupledPeersInTurn) {
  const auto model = CubeAnd(Wall(0.005));
  TrapDetector detector(*model);
  detector.Begin(0);
  std::array<InstanceView, 7> others;
  for (std::size_t i = 0; i < others.size(); ++i) {
    const double side = i % 2 == 0 ? -1.0 : 1.0;
    others[i] = {10 + i, Place(Vec3(0.05 * side, 0.01 * static_cast<double>(i), 0))};
  }
  const testing::AllocationCounter allocations;
  for (int i = 1; i <= 800; ++i) {
    detector.Update(i * kMs, Place(Vec3(0.05, 0, 0)), others.data(), others.size());
  }
  EXPECT_EQ(allocations.count(), 0);
  for (std::size_t i = 0; i < others.size(); ++i) {
    EXPECT_EQ(detector.trapped(10 + i), i % 2 == 0) << i;
  }
}

}  // namespace
}  // namespace tandem
