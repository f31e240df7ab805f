#include "engine/contact/kept/surface_file.h"

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <tbb/global_control.h>

#include "tests/engine/contact/kept/surface_file_fixture.h"

namespace tandem {
namespace {

using testing::Box;
using testing::HollowBlock;
using testing::Sheet;
using testing::Sphere;
using testing::SurfaceFile;

constexpr double kVoxel = SurfaceFile::kVoxel;

struct Shape {
  std::string name;
  TriangleMesh mesh_W;
};

std::vector<Shape> Shapes() {
  const Quat turn = Quat(0.9, 0.1, 0.3, -0.2).normalized();
  const Vec3 place(0.003, -0.02, 0.011);
  TriangleMesh crossed = Box(kVoxel * Vec3(14, 5, 5));
  Append(crossed, testing::At(Box(kVoxel * Vec3(5, 14, 5)), kVoxel * Vec3(1, 0, 1)));
  return {{"box", testing::At(Box(kVoxel * Vec3(11, 7.3, 9)), place, turn)},
          {"thin plate", testing::At(Box(kVoxel * Vec3(12, 10, 0.3)), place, turn)},
          {"ball without edges", Sphere(9 * kVoxel, 4)},
          {"coarse ball", Sphere(9 * kVoxel, 1)},
          {"hollow block", HollowBlock(26 * kVoxel, 9 * kVoxel)},
          {"sheet", testing::At(Sheet(12 * kVoxel), place, turn)},
          {"boxes that cross", crossed}};
}

bool AreTheSameBits(const std::vector<double>& a, const std::vector<double>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), 8 * a.size()) == 0;
}

TEST_F(SurfaceFile, IsReadBackBitForBit) {
  const Pose X_WB{Quat(0.8, -0.3, 0.2, 0.4).normalized(), Vec3(0.01, 0.02, -0.005)};
  for (const Shape& shape : Shapes()) {
    const BodySurface made = Made(shape.mesh_W, X_WB);
    ASSERT_FALSE(SaveSurface(made, shape.mesh_W, kOptions, file_));
    const Result<BodySurface> mapped = MapSurface(file_, shape.mesh_W, X_WB, kOptions);
    ASSERT_TRUE(mapped) << shape.name << ": " << mapped.error().what;
    EXPECT_EQ(mapped->field.Digest(), made.field.Digest()) << shape.name;
    EXPECT_TRUE(std::ranges::equal(mapped->field.bytes(), made.field.bytes())) << shape.name;
    EXPECT_TRUE(std::ranges::equal(mapped->features.bytes(), made.features.bytes())) << shape.name;
    EXPECT_EQ(mapped->features.point_count(), made.features.point_count()) << shape.name;
    EXPECT_EQ(mapped->radius, made.radius) << shape.name;
    EXPECT_EQ(mapped->X_BV.p, made.X_BV.p) << shape.name;
    EXPECT_EQ(mapped->X_BV.q.coeffs(), made.X_BV.q.coeffs()) << shape.name;
    EXPECT_TRUE(AreTheSameBits(Readings(*mapped, shape.mesh_W), Readings(made, shape.mesh_W)))
        << shape.name;
  }
}

// Bytes between arrays and in records are 0, whatever memory held before.
TEST_F(SurfaceFile, HasTheSameBytesForAnyNumberOfThreads) {
  const TriangleMesh mesh = HollowBlock(26 * kVoxel, 9 * kVoxel);
  Bytes one;
  for (const std::size_t threads : {1, 2, 5}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    const Bytes bytes = SavedBytes(mesh);
    if (one.empty()) one = bytes;
    EXPECT_EQ(bytes, one) << threads;
  }
}

TEST_F(SurfaceFile, WrongLengthIsRefused) {
  const Bytes whole = SavedBytes(box_);
  ASSERT_EQ(FaultOf(whole), "");
  EXPECT_EQ(FaultOf({}), "empty");
  EXPECT_EQ(FaultOf({whole.begin(), whole.begin() + sizeof(BlockFileHeader) - 1}),
            "too short for a surface");
  std::vector<std::size_t> lengths{
      sizeof(BlockFileHeader), sizeof(BlockFileHeader) + 1, 127, 128, 129, whole.size() - 1};
  for (std::size_t length = 64; length < whole.size(); length += 999) lengths.push_back(length);
  for (const std::size_t length : lengths) {
    if (length < sizeof(BlockFileHeader)) continue;
    Bytes cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(length));
    EXPECT_NE(FaultOf(cut).find("it was cut short"), std::string::npos) << length;
    // the header lies about its length and its sum
    Set(cut, offsetof(BlockFileHeader, bytes), std::uint64_t{length});
    EXPECT_NE(FaultOf(Signed(cut)), "") << length;
  }
  Bytes longer = whole;
  longer.resize(whole.size() + 64);
  EXPECT_NE(FaultOf(longer).find("it was cut short"), std::string::npos);
  Set(longer, offsetof(BlockFileHeader, bytes), std::uint64_t{longer.size()});
  EXPECT_NE(FaultOf(Signed(longer)), "");
}

TEST_F(SurfaceFile, OlderVersionMustBeRebuilt) {
  Bytes older = SavedBytes(box_);
  Set(older, offsetof(BlockFileHeader, version), kSurfaceFile.version - 1);
  EXPECT_EQ(FaultOf(Signed(older)),
            "a surface of version " + std::to_string(kSurfaceFile.version - 1) + ", not " +
                std::to_string(kSurfaceFile.version) + "; voxelize its mesh again");
}

TEST_F(SurfaceFile, FileOfAnotherMeshOrOptionsIsRefused) {
  const std::filesystem::path file = Saved(box_);
  ASSERT_TRUE(MapSurface(file, box_, Pose{}, kOptions));
  TriangleMesh moved = box_;
  moved.vertices[3].x() += 1e-12;
  TriangleMesh turned = box_;
  std::swap(turned.triangles[0][1], turned.triangles[0][2]);
  for (const TriangleMesh& mesh : {moved, turned}) {
    const Result<BodySurface> surface = MapSurface(file, mesh, Pose{}, kOptions);
    ASSERT_FALSE(surface);
    EXPECT_NE(surface.error().what.find("a surface of another mesh"), std::string::npos);
  }
  for (const SurfaceOptions& options :
       {SurfaceOptions{.voxel_size = 0.0011}, SurfaceOptions{.flatness_voxels = 0.5},
        SurfaceOptions{.spacing_voxels = 0.5}}) {
    EXPECT_FALSE(MapSurface(file, box_, Pose{}, options));
  }
}

TEST_F(SurfaceFile, ReplacesOnlyRegularFiles) {
  const std::filesystem::path pipe = folder_.path() / "pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  const std::optional<Error> fault = SaveSurface(Made(box_), box_, kOptions, pipe);
  ASSERT_TRUE(fault);
  EXPECT_EQ(fault->what, pipe.string() + ": is not a regular file: name another");
  EXPECT_FALSE(MapSurface(pipe, box_, Pose{}, kOptions));
}

}  // namespace
}  // namespace tandem
