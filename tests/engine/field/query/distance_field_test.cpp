// The oracle is brute force over all triangles, in double precision, without tree or grid.
#include "engine/field/query/distance_field.h"

#include <functional>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "engine/field/build/field_builder.h"
#include "tests/engine/field/brute_distance.h"
#include "tests/support/shapes.h"

namespace tandem {
namespace {

using testing::At;
using testing::Box;
using testing::BruteDistance;
using testing::HollowBlock;
using testing::Raised;
using testing::RandomRotation;
using testing::Sheet;
using testing::Sphere;
using testing::Uniform;

constexpr double kVoxel = 0.001;

DistanceField FieldOf(const TriangleMesh& mesh) {
  Result<DistanceField> field = BuildField(mesh, {.voxel_size = kVoxel});
  EXPECT_TRUE(field) << (field ? "" : field.error().what);
  return std::move(*field);
}

/// Returns a place in voxels of V.
Vec3 PlaceIn(const DistanceField& field, const Vec3& p_W) {
  return (p_W - field.p_WVo()) / kVoxel;
}

FieldGradient GradientAt(const DistanceField& field, const Vec3& place) {
  FieldGradient reported;
  field.WithGradients({&place, 1}, &reported);
  return reported;
}

/// Returns an L whose concave edge has 90 degrees; its inner corner comes first.
TriangleMesh Angle() {
  return Raised({{4, 4}, {4, 14}, {0, 14}, {0, 0}, {14, 0}, {14, 4}}, 9, kVoxel);
}
/// Returns the same solid as two boxes that lie in one another where the legs meet.
TriangleMesh AngleOfTwo() {
  TriangleMesh both = Raised({{0, 0}, {14, 0}, {14, 4}, {0, 4}}, 9, kVoxel);
  Append(both, Raised({{0, 0}, {4, 0}, {4, 14}, {0, 14}}, 9, kVoxel));
  return both;
}
/// Returns a wedge of 20 degrees.
TriangleMesh Wedge() {
  return Raised({{0, 0}, {15, -2.645}, {15, 2.645}}, 8, kVoxel);
}

struct Shape {
  std::string name;
  TriangleMesh mesh;   // the field is made of it
  TriangleMesh exact;  // the same solid, without anything inside
};

std::vector<Shape> Shapes() {
  std::mt19937_64 random(7);
  std::vector<Shape> shapes;
  const auto add = [&](const std::string& name, const TriangleMesh& mesh,
                       const TriangleMesh& exact) {
    const Quat turn = RandomRotation(random);
    const Vec3 p(0.0031, -0.0202, 0.0107);
    shapes.push_back({name, At(mesh, p), At(exact, p)});
    shapes.push_back({name + ", turned", At(mesh, p, turn), At(exact, p, turn)});
  };
  const auto alike = [&](const std::string& name, const TriangleMesh& mesh) {
    add(name, mesh, mesh);
  };
  alike("box", Box(kVoxel * Vec3(11, 7.3, 9)));
  alike("ball", Sphere(12 * kVoxel, 4));
  alike("coarse ball", Sphere(9 * kVoxel, 1));
  alike("hollow block", HollowBlock(26 * kVoxel, 9 * kVoxel));
  alike("plate of a third of a voxel", Box(kVoxel * Vec3(12, 10, 0.3)));
  alike("plate of a voxel", Box(kVoxel * Vec3(12, 10, 1)));
  alike("notch", Angle());
  alike("wedge", Wedge());
  add("two boxes in one another", AngleOfTwo(), Angle());
  return shapes;
}

/// Calls `visit(place, exact)` for places at most `reach` from the shape's surface, both in voxels.
void VisitPlaces(const Shape& shape, const DistanceField& field, double reach, int count,
                 const std::function<void(const Vec3&, double)>& visit) {
  std::mt19937_64 random(11);
  const BruteDistance exact(shape.exact);
  for (int i = 0; i < count; ++i) {
    const Vec3 p_W = exact.PlaceNear(reach * kVoxel, random);
    visit(PlaceIn(field, p_W), exact.Signed(p_W) / kVoxel);
  }
}

TEST(DistanceField, IsWithinItsErrorBoundInItsBand) {
  for (const Shape& shape : Shapes()) {
    const DistanceField field = FieldOf(shape.mesh);
    EXPECT_LE(field.error_bound(), 0.02) << shape.name;
    VisitPlaces(shape, field, 1.0, 1500, [&](const Vec3& place, double exact) {
      const FieldReading reading = field.At(place);
      if (std::abs(exact) >= field.band()) return;
      ASSERT_TRUE(reading.near) << shape.name;
      ASSERT_NEAR(reading.value, exact, field.error_bound())
          << shape.name << " at " << place.transpose();
    });
  }
}

TEST(DistanceField, HasTheRightSignAndNoBoundAboveTheDistance) {
  for (const Shape& shape : Shapes()) {
    const DistanceField field = FieldOf(shape.mesh);
    VisitPlaces(shape, field, 40, 1000, [&](const Vec3& place, double exact) {
      const FieldReading reading = field.At(place);
      // nearer than the bound an error may change the sign
      if (std::abs(exact) > field.error_bound() && reading.value != 0) {
        ASSERT_EQ(reading.value > 0, exact > 0) << shape.name << " at " << place.transpose();
      }
      const double slack =
          reading.near ? std::max(field.error_bound(), field.outer_error_bound()) : 1e-6;
      ASSERT_LE(std::abs(reading.value), std::abs(exact) + slack)
          << shape.name << " at " << place.transpose();
    });
  }
}

// one by one in double precision, and many at once in single
TEST(DistanceField, BatchedValuesEqualSingleValues) {
  for (const Shape& shape : Shapes()) {
    const DistanceField field = FieldOf(shape.mesh);
    std::vector<Vec3> places;
    for (const double reach : {1.5, 40.0, 400.0}) {
      VisitPlaces(shape, field, reach, 480, [&](const Vec3& place, double) {
        places.push_back(place);
      });
    }
    const GridIndex base{100, 90, 80};
    std::array<std::vector<float>, 3> lanes;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (const Vec3& place : places) {
        const double from = axis == 0 ? base.x : (axis == 1 ? base.y : base.z);
        lanes[axis].push_back(static_cast<float>(place[static_cast<Eigen::Index>(axis)] - from));
      }
    }
    std::vector<float> values(places.size());
    std::vector<std::int32_t> kinds(places.size());
    field.Values(base, {lanes[0].data(), lanes[1].data(), lanes[2].data()}, places.size(),
                 values.data(), kinds.data());
    std::size_t compared = 0;
    for (std::size_t i = 0; i < places.size(); ++i) {
      const FieldReading one = field.At(places[i]);
      ASSERT_TRUE(one.near || kinds[i] != DistanceField::kListed) << shape.name;
      if (kinds[i] == DistanceField::kListed) continue;
      // at a border either side is right; far outside a bound may be a little lower
      const Vec3 lane_V =
          Vec3(lanes[0][i], lanes[1][i], lanes[2][i]) + Vec3(base.x, base.y, base.z);
      const auto agrees = [&](const FieldReading& reading) {
        const double lower = reading.near ? 0.002 : 0.02 + 0.002 * std::abs(reading.value);
        const double more = std::abs(values[i]) - std::abs(reading.value);
        return (values[i] < 0) == (reading.value < 0 && values[i] != 0) && more < 0.002 &&
               more > -lower;
      };
      ASSERT_TRUE(agrees(one) || agrees(field.At(lane_V)) || std::abs(one.value) < 0.002)
          << shape.name << ": " << values[i] << " and " << one.value;
      ++compared;
    }
    EXPECT_GT(compared, places.size() / 2);
  }
}

// far places are known to be far, or the schedule would look at them in every frame
TEST(DistanceField, BoundsBeyondTheBandAreAtLeastAThirdOfTheDistance) {
  const Shape shape{"ball", Sphere(12 * kVoxel, 4), Sphere(12 * kVoxel, 4)};
  const DistanceField field = FieldOf(shape.mesh);
  VisitPlaces(shape, field, 100, 2000, [&](const Vec3& place, double exact) {
    // twice a brick's half diagonal may be lost of its distance
    EXPECT_GE(std::abs(field.At(place).value), std::abs(exact) / 3 - 7) << place.transpose();
  });
}

TEST(DistanceField, IsTheSameForAnyNumberOfThreads) {
  TriangleMesh mesh = AngleOfTwo();
  Append(mesh, At(Sphere(30 * kVoxel, 4), kVoxel * Vec3(70, 0, 3)));
  std::vector<std::uint64_t> digests;
  for (const std::size_t threads : {1, 2, 4}) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    digests.push_back(FieldOf(mesh).Digest());
  }
  EXPECT_EQ(digests[1], digests[0]);
  EXPECT_EQ(digests[2], digests[0]);
}

// A node of a border is in two bricks, rounded in each to half a step, 1 / 1,024 voxel at the most.
TEST(DistanceField, ValueIsContinuousAcrossCellsAndBricks) {
  for (const Shape& shape : Shapes()) {
    const DistanceField field = FieldOf(shape.mesh);
    std::mt19937_64 random(3);
    VisitPlaces(shape, field, 0.5, 800, [&](const Vec3& place, double) {
      Vec3 border = place;
      const auto axis = static_cast<Eigen::Index>(random() % 3);
      border[axis] = std::floor(place[axis]) + 0.5;  // nodes are centres of voxels
      const Vec3 step = 1e-7 * Vec3::Unit(axis);
      const FieldReading before = field.At(border - step);
      const FieldReading after = field.At(border + step);
      if (std::abs(before.value) > field.band()) return;
      ASSERT_NEAR(before.value, after.value, 0.006) << shape.name << " at " << place.transpose();
    });
  }
}

TEST(DistanceField, GradientIsContinuousAcrossCellsAndBricks) {
  // faces that turn by 1.3 degrees: no cell has a list; a coarser ball is as good to find places
  const Shape ball{"ball", Sphere(40 * kVoxel, 6), Sphere(40 * kVoxel, 4)};
  const DistanceField field = FieldOf(ball.mesh);
  EXPECT_EQ(field.Count().listed_cells, 0U);
  std::mt19937_64 random(3);
  VisitPlaces(ball, field, 0.5, 4000, [&](const Vec3& place, double) {
    Vec3 border = place;
    const auto axis = static_cast<Eigen::Index>(random() % 3);
    // the middles between nodes too
    border[axis] = 0.5 * std::floor(2 * place[axis]);
    const Vec3 step = 1e-7 * Vec3::Unit(axis);
    const Vec3 before = GradientAt(field, border - step).gradient;
    const Vec3 after = GradientAt(field, border + step).gradient;
    // a slope is between nodes that are each rounded to half a step
    ASSERT_LT((after - before).norm(), std::sqrt(3.0) / 1024) << place.transpose();
    // a facet's edge turns the exact direction by up to half of its 5 degrees
    ASSERT_GT(before.normalized().dot((border - PlaceIn(field, Vec3::Zero())).normalized()),
              std::cos(0.06));
  });
}

TEST(DistanceField, GradientOfAPlaneIsItsNormal) {
  std::mt19937_64 random(5);
  const Quat turn = RandomRotation(random);
  const DistanceField field = FieldOf(At(Box(kVoxel * Vec3(60, 60, 20)), Vec3::Zero(), turn));
  const Vec3 nhat = turn * Vec3::UnitZ();
  for (int i = 0; i < 2000; ++i) {
    const Vec3 in_box(Uniform(random, -24, 24), Uniform(random, -24, 24),
                      Uniform(random, 9.5, 10.5));
    const FieldGradient look = GradientAt(field, PlaceIn(field, kVoxel * (turn * in_box)));
    EXPECT_NEAR(look.reading.value, in_box.z() - 10, 1.0 / 1024);
    // 0.1 degrees
    EXPECT_GT(look.gradient.normalized().dot(nhat), std::cos(0.1 / 57.3));
  }
}

// The field gives the exact distance where interpolation errs by up to 0.4 voxel: outside a sharp
// edge, in a concave edge and in a wall that no node lies in.
TEST(DistanceField, FaceListsCoverEdgesNotchesAndThinWalls) {
  const DistanceField notch = FieldOf(Angle());
  const DistanceField wedge = FieldOf(Wedge());
  const DistanceField plate = FieldOf(Box(kVoxel * Vec3(12, 10, 0.3)));
  for (double z = 2; z < 6; z += 0.07) {
    // on the middle plane of the concave edge, 0.4 from either face
    const FieldReading in_notch = notch.At(PlaceIn(notch, kVoxel * Vec3(4.4, 4.4, z)));
    EXPECT_NEAR(in_notch.value, 0.4, notch.error_bound());
    // before the wedge's edge, whose two faces are both behind
    const FieldGradient edge = GradientAt(wedge, PlaceIn(wedge, kVoxel * Vec3(-0.3, 0, z)));
    EXPECT_NEAR(edge.reading.value, 0.3, wedge.error_bound());
    EXPECT_GT(edge.gradient.normalized().dot(-Vec3::UnitX()), 0.999);
    for (const double side : {-1.0, 1.0}) {
      const Vec3 before = kVoxel * Vec3(z - 4, 1, side * 0.35);
      const FieldGradient look = GradientAt(plate, PlaceIn(plate, before));
      EXPECT_NEAR(look.reading.value, 0.2, plate.error_bound());
      EXPECT_GT(look.gradient.normalized().z() * side, 0.999);
      const Vec3 within = kVoxel * Vec3(z - 4, 1, side * 0.05);
      EXPECT_NEAR(plate.At(PlaceIn(plate, within)).value, -0.1, plate.error_bound());
    }
  }
}

TEST(DistanceField, OpenSheetIsFreeOnBothSides) {
  std::mt19937_64 random(9);
  const Quat turn = RandomRotation(random);
  const TriangleMesh mesh = At(Sheet(14 * kVoxel), Vec3::Zero(), turn);
  const DistanceField field = FieldOf(mesh);
  const BruteDistance exact(mesh);
  for (int i = 0; i < 4000; ++i) {
    const Vec3 p_W = exact.PlaceNear((i % 2 == 0 ? 1.0 : 30.0) * kVoxel, random);
    const double distance = exact.Unsigned(p_W) / kVoxel;
    const FieldReading reading = field.At(PlaceIn(field, p_W));
    ASSERT_GE(reading.value, -field.error_bound()) << i;
    if (distance < field.band()) {
      ASSERT_NEAR(reading.value, distance, field.error_bound()) << i;
    } else if (!reading.near) {
      ASSERT_LE(reading.value, distance + 1e-6) << i;
    }
  }
}

// The field looks at a cell if its centre is nearer than a reading goes, and half its diagonal
// more. The face here is just as far from a row of centres, to the last bit of a float or some bits
// off.
TEST(DistanceField, IsBuiltAsFarAsQueriesReach) {
  constexpr float kFar = 2.6162F;
  for (int bits = -8; bits <= 8; ++bits) {
    const double face = 16 - (static_cast<double>(kFar) + bits * 0x1p-22);
    TriangleMesh box = Box(Vec3(1, 1, 1));
    for (Vec3& v : box.vertices) {
      v = {v.x() > 0 ? face : 2.0, v.y() > 0 ? 20.0 : 11.0, v.z() > 0 ? 20.0 : 11.0};
    }
    const Result<DistanceField> field = BuildField(box, {.voxel_size = 1});
    ASSERT_TRUE(field);
    const FieldReading reading = field->At(Vec3(16, 11.6, 15) - field->p_WVo());
    EXPECT_FALSE(reading.near);
    EXPECT_LE(reading.value, 16 - face);
    EXPECT_GT(reading.value, 1.5);
  }
}

TEST(DistanceField, NonFinitePositionsReadAsOutside) {
  const DistanceField field = FieldOf(Box(kVoxel * Vec3(11, 7, 9)));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(field.At(Vec3(nan, 0, 0)).near);
  EXPECT_FALSE(field.At(Vec3(1e30, -1e30, 0)).near);
}

TEST(DistanceField, MeshThatCannotBeVoxelizedHasNoField) {
  EXPECT_FALSE(BuildField({}, {.voxel_size = kVoxel}));
  EXPECT_FALSE(BuildField(Box(kVoxel * Vec3(11, 7, 9)), {.voxel_size = 0}));
  EXPECT_FALSE(
      BuildField(Box(Vec3(11, 7, 9)), {.voxel_size = kVoxel, .max_memory_bytes = 1 << 20}));
}

}  // namespace
}  // namespace tandem
