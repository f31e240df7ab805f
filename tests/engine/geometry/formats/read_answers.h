#pragma once

#include <string>
#include <string_view>

#include <gmock/gmock.h>

#include "engine/geometry/formats/raw_mesh.h"

namespace tandem::testing {

inline constexpr double kTetra = 1.0 / 6;  // volume of a tetrahedron on the axes

/// Returns the volume of an answer's triangles by the divergence theorem, in the file's units.
inline double VolumeOf(const ReadAnswer& answer) {
  double six = 0;
  const auto at = [&](std::uint32_t i) {
    const FilePoint& p = answer.mesh.points[i];
    return Vec3(p[0], p[1], p[2]);
  };
  for (const TriangleMesh::Triangle& t : answer.mesh.triangles) {
    six += at(t[0]).dot(at(t[1]).cross(at(t[2])));
  }
  return six / 6;
}

/// Expects a mesh of that volume, of which nothing is told.
inline void ExpectRead(double volume, const ReadAnswer& answer) {
  ASSERT_EQ(answer.kind, ReadAnswer::Kind::kMesh) << answer.words;
  EXPECT_NEAR(VolumeOf(answer), volume, 1e-6 * volume);
  EXPECT_THAT(answer.remarks, ::testing::IsEmpty());
}

/// Expects a mesh of that volume, with one remark that contains these words.
inline void ExpectReadWith(double volume, const std::string& remark, const ReadAnswer& answer) {
  ASSERT_EQ(answer.kind, ReadAnswer::Kind::kMesh) << answer.words;
  EXPECT_NEAR(VolumeOf(answer), volume, 1e-6 * volume);
  EXPECT_THAT(answer.remarks, ::testing::ElementsAre(::testing::HasSubstr(remark)));
}

inline void ExpectNot(const std::string& why, const ReadAnswer& answer) {
  ASSERT_EQ(answer.kind, ReadAnswer::Kind::kRefused);
  EXPECT_THAT(answer.words, ::testing::HasSubstr(why));
}

}  // namespace tandem::testing
