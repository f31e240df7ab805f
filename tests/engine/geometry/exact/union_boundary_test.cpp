#include "engine/geometry/exact/union_boundary.h"

#include <atomic>

#include <gtest/gtest.h>

#include "tests/support/shapes.h"

namespace tandem {
namespace {

using testing::At;
using testing::Box;

/// The pieces of a mesh, and how often the union was asked for.
struct Found {
  std::vector<Facet> facets;
  int requested = 0;
};
Found Find(const TriangleMesh& mesh, bool by_patches) {
  const MeshSides sides(mesh);
  const WindingNumber winding(mesh);
  std::atomic<int> requested = 0;
  Found found;
  found.facets = UnionBoundaryAndSheets(mesh, by_patches ? &sides : nullptr, [&](const Vec3& p) {
    ++requested;
    return winding.At(p) >= 0.5;
  });
  found.requested = requested;
  return found;
}

/// Most times that one place is asked for: in front of a piece and behind it.
constexpr int kTimesAPiece = 2;

void ExpectSamePieces(const TriangleMesh& mesh, const std::string& what) {
  const Found by_patches = Find(mesh, true);
  const Found one_by_one = Find(mesh, false);
  ASSERT_EQ(by_patches.facets.size(), one_by_one.facets.size()) << what;
  for (std::size_t i = 0; i < one_by_one.facets.size(); ++i) {
    const Facet& a = by_patches.facets[i];
    const Facet& b = one_by_one.facets[i];
    ASSERT_EQ(a.a, b.a) << what << ", piece " << i;
    ASSERT_EQ(a.b, b.b) << what << ", piece " << i;
    ASSERT_EQ(a.c, b.c) << what << ", piece " << i;
    ASSERT_EQ(a.nhat, b.nhat) << what << ", piece " << i;
    ASSERT_EQ(a.sheet, b.sheet) << what << ", piece " << i;
    ASSERT_EQ(a.triangle, b.triangle) << what << ", piece " << i;
    ASSERT_EQ(a.whole, b.whole) << what << ", piece " << i;
  }
}

TEST(UnionBoundary, QueriesADisjointBodyOnce) {
  TriangleMesh mesh = testing::Sphere(1, 3);
  Append(mesh, At(testing::Sphere(1, 3), {5, 0, 0}));
  const Found found = Find(mesh, true);
  EXPECT_EQ(found.facets.size(), mesh.triangles.size());
  EXPECT_EQ(found.requested, 2 * kTimesAPiece);
}

// boxes on a coarse grid stand on one another, share edges and corners, pass through one another's
// edges, lie in one another and are one another's equal
TEST(UnionBoundary, MatchesPerTriangleQueries) {
  std::mt19937_64 random(1);
  std::uniform_int_distribution<int> place(0, 3);
  std::uniform_int_distribution<int> side(1, 3);
  for (int i = 0; i < 200; ++i) {
    TriangleMesh mesh;
    for (int body = 0; body < 4; ++body) {
      const Vec3 size(2 * side(random), 2 * side(random), 2 * side(random));
      const Vec3 lowest(2 * place(random), 2 * place(random), 2 * place(random));
      Append(mesh, At(Box(size), lowest + 0.5 * size));
    }
    const Quat q = i % 2 == 0 ? Quat::Identity() : testing::RandomRotation(random);
    ExpectSamePieces(At(mesh, Vec3::Zero(), q), "boxes " + std::to_string(i));
    if (HasFatalFailure()) return;
  }
}

TEST(UnionBoundary, FindsTheSamePiecesOfRoundBodiesThatCross) {
  std::mt19937_64 random(2);
  for (int i = 0; i < 10; ++i) {
    TriangleMesh mesh = testing::HollowBlock(3, 1);
    for (int body = 0; body < 3; ++body) {
      const Vec3 p = testing::Uniform(random, 0, 2) * testing::RandomDirection(random);
      Append(mesh, At(testing::Sphere(0.8, 2), p, testing::RandomRotation(random)));
    }
    ExpectSamePieces(mesh, "spheres " + std::to_string(i));
    if (HasFatalFailure()) return;
  }
}

}  // namespace
}  // namespace tandem
