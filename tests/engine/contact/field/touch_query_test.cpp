// Tests yes or no against the distance of the two meshes' triangles.
#include "engine/contact/field/touch_query.h"

#include <random>

#include <gtest/gtest.h>

#include "engine/geometry/exact/mesh_tree.h"
#include "tests/engine/contact/refined.h"

namespace tandem {
namespace {

using testing::At;
using testing::Box;
using testing::HollowBlock;
using testing::kS;
using testing::RandomDirection;
using testing::RandomRotation;
using testing::Sphere;
using testing::SurfaceOf;
using testing::Uniform;

/// Two bodies and the distance of their triangles, m: 0 where they cross.
struct Two {
  Two(const TriangleMesh& one, const TriangleMesh& other)
      : a(SurfaceOf(one, Quat::Identity())),
        b(SurfaceOf(other, Quat::Identity())),
        tree_a(one),
        tree_b(other),
        query(a, b) {}

  double Distance(const Pose& X_WB) const {
    return FindClosestPoints(tree_b, X_WB, tree_a, {}).distance;
  }

  BodySurface a, b;
  MeshTree tree_a, tree_b;
  TouchQuery query;
};

/// Tries poses at random about the origin. Bodies that cross must be found, and bodies whose
/// surfaces are a tenth of a voxel apart must not.
void ExpectRight(Two& two, double nearest, double farthest, unsigned seed, int poses = 2000) {
  std::mt19937_64 random(seed);
  int touching = 0;
  int apart = 0;
  for (int i = 0; i < poses; ++i) {
    const Pose X_WB{RandomRotation(random),
                    Uniform(random, nearest, farthest) * kS * RandomDirection(random)};
    const double distance = two.Distance(X_WB);
    const std::optional<Vec3> place = two.query.Find({}, X_WB);
    if (distance == 0) {
      ++touching;
      EXPECT_TRUE(place) << "pose " << i;
    } else if (distance > 0.1 * kS) {
      ++apart;
      EXPECT_FALSE(place) << "pose " << i << ", " << distance / kS << " voxels apart";
    }
  }
  EXPECT_GT(touching, poses / 10);
  EXPECT_GT(apart, poses / 10);
}

TEST(TouchQuery, FindsOnlyIntersectingBoxes) {
  Two two(Box(kS * Vec3(20, 14, 10)), Box(kS * Vec3(9, 7, 16)));
  ExpectRight(two, 6, 22, 1);
}

// Nothing of the plate lies in the rod, and the rod's ends are out of the plate: its edges go
// through.
TEST(TouchQuery, FindsARodThroughAPlateThinnerThanAVoxel) {
  Two two(Box(kS * Vec3(50, 50, 0.3)), Box(kS * Vec3(3, 3, 40)));
  EXPECT_TRUE(two.query.Find({}, {Quat::Identity(), kS * Vec3(1.2, 0.7, 0.4)}));
  EXPECT_FALSE(two.query.Find({}, {Quat::Identity(), kS * Vec3(0, 0, 20.4)}));
  ExpectRight(two, 0, 40, 2);
}

TEST(TouchQuery, FindsABallThatBarelyLeavesItsHollow) {
  Two two(HollowBlock(30 * kS, 10 * kS), Sphere(9 * kS, 3));
  EXPECT_FALSE(two.query.Find({}, {}));
  ExpectRight(two, 0.3, 1.6, 3, 100);
}

// The place was found once; moved on, it is still in the other.
TEST(TouchQuery, LastingTouchIsReportedAgain) {
  Two two(Box(kS * Vec3(20, 20, 20)), Box(kS * Vec3(8, 8, 8)));
  const auto first = two.query.Find({}, {Quat::Identity(), kS * Vec3(0, 0, 12)});
  ASSERT_TRUE(first);
  const auto next = two.query.Find({}, {Quat::Identity(), kS * Vec3(0.1, 0, 12)});
  ASSERT_TRUE(next);
  EXPECT_LT((*next - *first - kS * Vec3(0.1, 0, 0)).norm(), 1e-9);
  EXPECT_FALSE(two.query.Find({}, {Quat::Identity(), kS * Vec3(0, 0, 14.1)}));
}

}  // namespace
}  // namespace tandem
