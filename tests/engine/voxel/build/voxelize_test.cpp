#include "engine/voxel/build/voxelize.h"

#include <fstream>
#include <set>
#include <string>
#include <tuple>

#include <gtest/gtest.h>
#include <malloc.h>
#include <tbb/global_control.h>

#include "engine/voxel/points/surface_voxels.h"
#include "tests/support/shapes.h"

namespace tandem {
namespace {

using testing::Box;
using testing::RandomDirection;
using testing::RandomRotation;
using testing::Sheet;
using testing::Sphere;
using testing::Uniform;

/// The oracle: clips the triangle to the closed cell in long double and asks whether anything is
/// left. Independent of separating axes; undecided within 1e-5 of a voxel, the snapping included.
enum class Meets { kNo, kYes, kUndecided };

using Point = std::array<long double, 3>;

bool ClipsTo(std::vector<Point> polygon, const Point& low, const Point& high) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const long double side : {-1.0L, 1.0L}) {
      const long double limit = side < 0 ? low[axis] : high[axis];
      std::vector<Point> kept;
      for (std::size_t i = 0; i < polygon.size(); ++i) {
        const Point& a = polygon[i];
        const Point& b = polygon[(i + 1) % polygon.size()];
        const long double da = side * (limit - a[axis]);
        const long double db = side * (limit - b[axis]);
        if (da >= 0) kept.push_back(a);
        if ((da >= 0) != (db >= 0)) {
          Point cut{};
          for (std::size_t k = 0; k < 3; ++k) cut[k] = a[k] + da / (da - db) * (b[k] - a[k]);
          kept.push_back(cut);
        }
      }
      polygon = kept;
    }
  }
  return !polygon.empty();
}

Meets OracleMeets(const TriangleMesh& mesh, std::size_t t, double s, const GridIndex& cell) {
  std::vector<Point> polygon;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3& v = mesh.corner(t, k);
    polygon.push_back({static_cast<long double>(v.x()) / s, static_cast<long double>(v.y()) / s,
                       static_cast<long double>(v.z()) / s});
  }
  const long double e = 1e-5L;
  const Point low{static_cast<long double>(cell.x), static_cast<long double>(cell.y),
                  static_cast<long double>(cell.z)};
  const auto grown = [&](long double by) {
    Point a = low;
    Point b = low;
    for (std::size_t k = 0; k < 3; ++k) {
      a[k] -= by;
      b[k] += 1 + by;
    }
    return ClipsTo(polygon, a, b);
  };
  if (grown(-e)) return Meets::kYes;
  return grown(e) ? Meets::kUndecided : Meets::kNo;
}

bool IsSurface(const SurfaceVoxels& surface, const GridIndex& voxel) {
  const SurfaceVoxels::Bits* bits = surface.BitsAt(voxel >> 3);
  if (bits == nullptr) return false;
  const std::size_t cell = CellInBlock(voxel);
  return ((*bits)[cell >> 6] >> (cell & 63) & 1) != 0;
}

TEST(SurfaceVoxels, AgreeWithClippingForRandomTriangles) {
  std::mt19937_64 random(1);
  const double s = 0.5;
  long decided = 0;
  for (int trial = 0; trial < 300; ++trial) {
    TriangleMesh mesh;
    const double reach = trial % 3 == 0 ? 0.3 : 5.0;  // slivers and small ones too
    const Vec3 at = 20.0 * RandomDirection(random);
    for (int k = 0; k < 3; ++k) {
      mesh.vertices.push_back(at + Uniform(random, 0, reach) * RandomDirection(random));
    }
    mesh.triangles = {{0, 1, 2}};
    const SurfaceVoxels surface = FindSurfaceVoxels(SnapTriangles(mesh, s), s);
    const Bounds box = BoundsOf(mesh);
    for (auto z = static_cast<int>(box.min.z() / s) - 2; z <= box.max.z() / s + 2; ++z) {
      for (auto y = static_cast<int>(box.min.y() / s) - 2; y <= box.max.y() / s + 2; ++y) {
        for (auto x = static_cast<int>(box.min.x() / s) - 2; x <= box.max.x() / s + 2; ++x) {
          const Meets meets = OracleMeets(mesh, 0, s, {x, y, z});
          if (meets == Meets::kUndecided) continue;
          ++decided;
          ASSERT_EQ(IsSurface(surface, {x, y, z}), meets == Meets::kYes)
              << "trial " << trial << " voxel " << x << " " << y << " " << z;
        }
      }
    }
  }
  EXPECT_GT(decided, 100000);
}

// A box whose faces lie on grid planes: the half-open rule gives each face to the voxels above it.
TEST(SurfaceVoxels, FacesOnGridPlanesBelongToTheUpperVoxels) {
  const double s = 0.1;  // 0.3 / 0.1 is not 3 in double
  TriangleMesh mesh = Box(Vec3(0.6, 0.6, 0.6));
  const SurfaceVoxels surface = FindSurfaceVoxels(SnapTriangles(mesh, s), s);
  std::size_t count = 0;
  for (int z = -6; z <= 6; ++z) {
    for (int y = -6; y <= 6; ++y) {
      for (int x = -6; x <= 6; ++x) {
        const auto in = [](int i) {
          return i >= -3 && i <= 3;
        };
        const auto on = [](int i) {
          return i == -3 || i == 3;
        };
        const bool expected = in(x) && in(y) && in(z) && (on(x) || on(y) || on(z));
        EXPECT_EQ(IsSurface(surface, {x, y, z}), expected) << x << " " << y << " " << z;
        count += expected;
      }
    }
  }
  EXPECT_EQ(count, 7U * 7 * 7 - 5U * 5 * 5);
}

Voxmap MustVoxelize(const TriangleMesh& mesh, double s, int range = kDefaultRange) {
  Result<Voxmap> made = Voxelize(mesh, {.voxel_size = s, .range = range, .bits = BitsFor(range)});
  EXPECT_TRUE(made) << (made ? "" : made.error().what);
  return std::move(*made);
}

// Brute force over all surface voxels in a box round the shape, for several ranges.
TEST(DistanceField, IsTheChessBoardDistanceToTheNearestSurfaceVoxel) {
  std::mt19937_64 random(2);
  for (const int range : {1, 8, 13, 16, 30, 70, 150}) {
    TriangleMesh mesh = Box(Vec3(0.9, 1.3, 0.4));
    const Quat q = RandomRotation(random);
    for (Vec3& v : mesh.vertices) v = q * v + Vec3(7.77, -3.3, 0.123);
    const double s = 0.1;
    const Voxmap voxmap = MustVoxelize(mesh, s, range);
    const SurfaceVoxels surface = FindSurfaceVoxels(SnapTriangles(mesh, s), s);
    std::vector<GridIndex> sources;
    for (const auto& chunk : surface.chunks) {
      for (std::size_t cell = 0; cell < kVoxelsPerChunk; ++cell) {
        const GridIndex i = chunk.place * kChunkSide + BlockCell(cell);
        if (IsSurface(surface, i)) sources.push_back(i);
      }
    }
    ASSERT_FALSE(sources.empty());
    const int reach = range + 7;
    for (int trial = 0; trial < 4000; ++trial) {
      const GridIndex near = sources[random() % sources.size()];
      const auto offset = [&] {
        return static_cast<std::int32_t>(random() % (2U * static_cast<unsigned>(reach) + 1)) -
               reach;
      };
      const GridIndex i = near + GridIndex{offset(), offset(), offset()};
      int distance = 1000;
      for (const GridIndex& source : sources) {
        const GridIndex d = source - i;
        distance = std::min(distance, std::max({std::abs(d.x), std::abs(d.y), std::abs(d.z)}));
      }
      const int value = voxmap.Value(Field::kSurface, i - voxmap.origin());
      if (value == kInteriorMark) continue;  // judged by Interior.*
      EXPECT_EQ(value, distance <= range ? 2 + distance : range + 3);
    }
  }
}

TEST(Voxelize, GivesTheSameBitsForAnyNumberOfThreads) {
  std::set<std::uint64_t> digests;
  for (const std::size_t threads : {1U, 2U, 4U}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    digests.insert(MustVoxelize(Sphere(1.0, 4), 0.02).Digest());
  }
  EXPECT_EQ(digests.size(), 1U);
}

// All three fields, against brute force over the sources that exact tests give; and each chunk's
// place in the chunk-level field against all chunks that hold a mark.
TEST(DistanceField, HoldsTheDistanceToTheNearestFeatureUpToItsRange) {
  std::mt19937_64 random(4);
  TriangleMesh mesh = Box(Vec3(1.9, 1.3, 0.4));
  const Quat q = RandomRotation(random);
  for (Vec3& v : mesh.vertices) v = q * v + Vec3(3.1, -0.3, 0.123);
  const double s = 0.05;
  for (const int range : {4, 8, 13, 40}) {
    const int reach = range + 7;
    const Voxmap voxmap = MustVoxelize(mesh, s, range);
    const FeatureVoxels voxels = FindFeatureVoxels(mesh, FindFeatures(mesh, 0.5 * s), s);
    for (const Field field : kAllFields) {
      std::vector<GridIndex> sources;
      for (const auto& chunk : voxels[field].chunks) {
        for (std::size_t cell = 0; cell < kVoxelsPerChunk; ++cell) {
          const GridIndex i = chunk.place * kChunkSide + BlockCell(cell);
          if (IsSurface(voxels[field], i)) sources.push_back(i);
        }
      }
      ASSERT_FALSE(sources.empty());
      for (int trial = 0; trial < 600; ++trial) {
        const auto offset = [&] {
          return static_cast<std::int32_t>(random() % (2U * static_cast<unsigned>(reach) + 1)) -
                 reach;
        };
        const GridIndex i =
            sources[random() % sources.size()] + GridIndex{offset(), offset(), offset()};
        int distance = 1000;
        for (const GridIndex& source : sources) {
          const GridIndex d = source - i;
          distance = std::min(distance, std::max({std::abs(d.x), std::abs(d.y), std::abs(d.z)}));
        }
        const int value = voxmap.Value(field, i - voxmap.origin());
        if (value == kInteriorMark) continue;
        ASSERT_EQ(value, distance <= range ? 2 + distance : range + 3);
        ASSERT_LE(voxmap.Value(Field::kSurface, i - voxmap.origin()), value);
      }
    }
    const auto& size = voxmap.header().size;
    const GridIndex chunks{static_cast<std::int32_t>(size[0] * 8),
                           static_cast<std::int32_t>(size[1] * 8),
                           static_cast<std::int32_t>(size[2] * 8)};
    std::vector<GridIndex> bearing;
    std::vector<GridIndex> all;
    for (std::int32_t z = 0; z < chunks.z; ++z) {
      for (std::int32_t y = 0; y < chunks.y; ++y) {
        for (std::int32_t x = 0; x < chunks.x; ++x) {
          all.push_back({x, y, z});
          for (const Field field : kAllFields) {
            if (voxmap.PlaneOf(field, all.back()) == kPlaneBeyond) continue;
            bearing.push_back(all.back());
            break;
          }
        }
      }
    }
    for (int trial = 0; trial < 500; ++trial) {
      const GridIndex i = all[random() % all.size()];
      int distance = 1000;
      for (const GridIndex& other : bearing) {
        const GridIndex d = other - i;
        distance = std::min(distance, std::max({std::abs(d.x), std::abs(d.y), std::abs(d.z)}));
      }
      ASSERT_EQ(voxmap.ChunkValue(i),
                distance <= Voxmap::kChunkRange ? 2 + distance : Voxmap::kChunkBeyond);
    }
  }
}

// The same marks, however many bits they have.
TEST(Voxelize, MarksOfAllWidthsAgree) {
  const TriangleMesh mesh = Sphere(0.5, 3);
  const auto made = [&](int range, int bits) {
    Result<Voxmap> map = Voxelize(mesh, {.voxel_size = 0.03, .range = range, .bits = bits});
    EXPECT_TRUE(map);
    return std::move(*map);
  };
  for (const auto& [range, bits] : {std::pair{1, 2}, std::pair{8, 8}, std::pair{13, 8}}) {
    const Voxmap one = made(range, 4);
    const Voxmap other = made(range, bits);
    ASSERT_EQ(one.origin(), other.origin());
    for (std::int32_t z = 40; z < 150; ++z) {
      for (std::int32_t y = 40; y < 150; ++y) {
        for (std::int32_t x = 40; x < 150; x += 3) {
          for (const Field field : kAllFields) {
            ASSERT_EQ(one.Value(field, {x, y, z}), other.Value(field, {x, y, z}));
          }
        }
      }
    }
  }
  EXPECT_FALSE(Voxelize(mesh, {.voxel_size = 0.03, .range = 2, .bits = 2}));
  EXPECT_FALSE(Voxelize(mesh, {.voxel_size = 0.03, .range = 14}));
  EXPECT_FALSE(Voxelize(mesh, {.voxel_size = 0.03, .range = 253, .bits = 8}));
  EXPECT_FALSE(Voxelize(mesh, {.voxel_size = 0.03, .range = 8, .bits = 3}));
}

TEST(Voxelize, ReportsProgressAndCanBeCancelled) {
  const TriangleMesh mesh = Sphere(1.0, 3);
  std::vector<double> shares;
  VoxelizeOptions options{.voxel_size = 0.01};
  options.progress = [&](double share) {
    shares.push_back(share);
  };
  ASSERT_TRUE(Voxelize(mesh, options));
  ASSERT_GT(shares.size(), 10U);
  EXPECT_EQ(shares.front(), 0.0);
  EXPECT_DOUBLE_EQ(shares.back(), 1.0);
  EXPECT_TRUE(std::is_sorted(shares.begin(), shares.end()));

  std::stop_source source;
  options.stop = source.get_token();
  options.progress = [&](double share) {
    if (share > 0.6) source.request_stop();
  };
  const Result<Voxmap> stopped = Voxelize(mesh, options);
  ASSERT_FALSE(stopped);
  EXPECT_NE(stopped.error().what.find("stopped"), std::string::npos);
}

TEST(Voxelize, RefusesOversizedMapsAndSuggestsAVoxelSize) {
  const TriangleMesh box = Box(Vec3(1, 1, 1));
  const Result<Voxmap> refused =
      Voxelize(box, {.voxel_size = 1e-5, .range = 8, .max_memory_bytes = 1ULL << 30U});
  ASSERT_FALSE(refused);
  double fits = 0;
  const std::string& text = refused.error().what;
  const std::size_t at = text.find("; ");
  ASSERT_NE(at, std::string::npos) << text;
  ASSERT_EQ(std::sscanf(text.c_str() + at, "; %lf m would fit", &fits), 1) << text;
  EXPECT_LE(EstimateVoxelizeBytes(box, {.voxel_size = fits}), 1ULL << 30U);
  EXPECT_GT(EstimateVoxelizeBytes(box, {.voxel_size = 0.8 * fits}), 1ULL << 30U);
  EXPECT_FALSE(Voxelize(box, {.voxel_size = 0.0}));
  EXPECT_FALSE(Voxelize(TriangleMesh{}, {.voxel_size = 0.1}));
}

/// Returns a figure of /proc/self/status, bytes.
double StatusBytes(const std::string& name) {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.rfind(name, 0) == 0) return 1024.0 * std::stod(line.substr(name.size() + 1));
  }
  return 0;
}

// The kernel's own account of the most memory held at once.
TEST(Voxelize, MemoryEstimateIsATightUpperBound) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "a sanitizer keeps what was given back";
#endif
  struct Case {
    TriangleMesh mesh;
    double voxel_size;
    int range = kDefaultRange;
  };
  const std::array<Case, 5> cases{Case{Sphere(0.5, 6), 0.002}, Case{Sphere(0.5, 4), 0.001},
                                  Case{Box(Vec3(1, 0.5, 0.2)), 0.001}, Case{Sheet(1.0), 0.001},
                                  Case{Sphere(0.5, 4), 0.005, 100}};
  for (const Case& c : cases) {
    malloc_trim(0);  // memory that the last case gave back would not be counted
    std::ofstream("/proc/self/clear_refs") << "5";  // the peak begins anew
    const double before = StatusBytes("VmRSS:");
    if (StatusBytes("VmHWM:") > before + 1e6) GTEST_SKIP() << "the peak cannot be set back";
    const VoxelizeOptions options{
        .voxel_size = c.voxel_size, .range = c.range, .bits = BitsFor(c.range)};
    const Result<Voxmap> map = Voxelize(c.mesh, options);
    ASSERT_TRUE(map);
    const double taken = StatusBytes("VmHWM:") - before;
    const auto estimated = static_cast<double>(EstimateVoxelizeBytes(c.mesh, options));
    EXPECT_LT(taken, estimated);
    // 1.3 to 3.5 times what spheres take, 4.2 what the sheet does, 6.1 the box: the estimate knows
    // the area of a mesh, not that flat faces along the grid need few chunks
    EXPECT_GT(8 * taken, estimated) << taken << " of " << estimated;
  }
}

// Layer thickness s |n|_1 along the normal (docs/decisions/0003-exact-voxels.md): 1.5 A / s^2 on
// average over directions.
TEST(Voxelize, SphereHasOneAndAHalfSurfaceVoxelsPerSquare) {
  const double s = 0.01;
  const VoxelCounts counts = MustVoxelize(Sphere(0.5, 5), s).Count();
  const double expected = 1.5 * 4 * M_PI * 0.25 / (s * s);
  EXPECT_NEAR(static_cast<double>(counts.surface) / expected, 1.0, 0.01);
}

}  // namespace
}  // namespace tandem
