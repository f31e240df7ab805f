#include "engine/field/build/face_distance.h"

#include <random>

#include <gtest/gtest.h>

#include "tests/engine/field/brute_distance.h"
#include "tests/support/shapes.h"

namespace tandem {
namespace {

FieldFace FaceOf(const Vec3& a, const Vec3& b, const Vec3& c) {
  return {{a, b, c}, (b - a).cross(c - a).normalized()};
}

// single precision holds what is near, however large the face is and wherever the body lies
TEST(FaceDistance, IsExactToAHundredThousandthOfAVoxel) {
  std::mt19937_64 random(1);
  const PlaceLanes nodes = LatticeLanes(5, 0, 1);
  for (int i = 0; i < 2000; ++i) {
    const Vec3 origin(4000, -700, 12 * i);
    const double size = i % 2 == 0 ? 3.0 : 2000.0;
    const auto corner = [&] {
      return Vec3(origin +
                  size * testing::Uniform(random, 0, 1) * testing::RandomDirection(random));
    };
    const FieldFace face = FaceOf(corner(), corner(), corner());
    alignas(64) std::array<float, PlaceLanes::kMost> distances;
    alignas(64) std::array<float, PlaceLanes::kMost> heights;
    NearFace(face, origin).Measure(nodes, NearFace::kAllEdges, distances.data(), heights.data());
    for (std::size_t node = 0; node < 125; ++node) {
      const Vec3 place = origin + Vec3(nodes.x[node], nodes.y[node], nodes.z[node]);
      const double exact = testing::FromTriangle(face.corners_L, place);
      if (exact > 16) continue;
      ASSERT_NEAR(distances[node], exact, 1e-5) << i << " " << node;
      ASSERT_NEAR(heights[node], face.nhat.dot(place - face.corners_L[0]), 1e-5);
    }
  }
}

TEST(FaceDistance, MeasuresACubeAnalytically) {
  std::mt19937_64 random(2);
  for (int i = 0; i < 100; ++i) {
    const auto corner = [&] {
      return Vec3(testing::Uniform(random, 1, 6) * testing::RandomDirection(random));
    };
    const NearFace face(FaceOf(corner(), corner(), corner()), Vec3::Zero());
    PlaceLanes places = LatticeLanes(kCubeSide, 0, 1);
    const std::array<float, 3> lowest{-1.5F, 2, 0.25F};
    for (std::size_t k = 0; k < kCubePlaces; ++k) {
      places.x[k] += lowest[0];
      places.y[k] += lowest[1];
      places.z[k] += lowest[2];
    }
    std::array<float, kCubePlaces> one_by_one;
    std::array<float, kCubePlaces> cube;
    face.Measure(places, NearFace::kAllEdges, one_by_one.data(), nullptr);
    face.MeasureCube(lowest, cube.data());
    ASSERT_EQ(cube, one_by_one) << i;
    NearestLanes nearest;
    NearestLanes of_cube;
    face.MeasureInto(places, NearFace::kAllEdges, nearest);
    face.MeasureCubeInto(lowest, of_cube.distance.data(), of_cube.height.data());
    ASSERT_EQ(of_cube.distance, nearest.distance) << i;
    ASSERT_EQ(of_cube.height, nearest.height) << i;
  }
}

// The two faces of a sharp edge are equally near to a place before the edge, one of them from
// behind.
TEST(FaceDistance, FacingFaceGivesTheSign) {
  const Vec3 from(0, -5, 0);
  const Vec3 to(0, 5, 0);
  const FieldFace left = FaceOf(from, to, {-4, 0, -6});
  const FieldFace right = FaceOf(to, from, {4, 0, -6});
  for (const bool left_first : {true, false}) {
    NearestLanes nearest;
    const PlaceLanes places = LatticeLanes(2, -1, 2);
    for (const FieldFace& face : {left_first ? left : right, left_first ? right : left}) {
      NearFace(face, Vec3::Zero()).MeasureInto(places, NearFace::kAllEdges, nearest);
    }
    for (std::size_t i = 0; i < 8; ++i) {
      // (-1 or 1, -1 or 1, -1) lies outside, beside the steep flanks, and so does z = 1
      EXPECT_GT(nearest.Signed(i), 0) << i;
    }
  }
}

}  // namespace
}  // namespace tandem
