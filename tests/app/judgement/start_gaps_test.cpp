#include "app/judgement/start_gaps.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/key_scene.h"

namespace tandem {
namespace {

using testing::BoxBetween;
using testing::BoxOfHalf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr double kMm = 1e-3;

SceneBody FixedBody(const std::string& name) {
  SceneBody body;
  body.name = name;
  body.fixed = true;
  return body;
}

SceneBody MovingBody(const std::string& name) {
  SceneBody body;
  body.name = name;
  body.mass = 0.1;
  return body;
}

Scene SceneOfBodies(double voxel_size, const std::vector<SceneBody>& bodies) {
  Scene scene;
  scene.voxel_size = voxel_size;
  scene.bodies = bodies;
  return scene;
}

/// Returns all pairs that contact pushes at the start.
std::vector<StartGap> GapsOf(const Scene& scene, const std::vector<TriangleMesh>& meshes_W) {
  StartGaps found = FindStartGaps(scene, meshes_W);
  EXPECT_EQ(found.unseen, 0U);
  std::erase_if(found.gaps, [](const StartGap& gap) {
    return gap.distance >= 0.99 * gap.needed;
  });
  return found.gaps;
}

/// Returns a key in its hole, with this play on each side.
std::vector<TriangleMesh> KeyInHole(double play) {
  return {testing::KeyholeMesh(play), testing::KeyMesh()};
}

const std::vector<SceneBody> kKey{FixedBody("hole"), MovingBody("key")};

TEST(StartGaps, NameTheRequiredPlayAndAVoxelSizeThatFits) {
  const std::vector<TriangleMesh> meshes_W = KeyInHole(0.09 * kMm);
  for (const double voxel : {4 * kMm, 2 * kMm}) {
    const std::vector<StartGap> gaps = GapsOf(SceneOfBodies(voxel, kKey), meshes_W);
    ASSERT_THAT(gaps, SizeIs(1));
    EXPECT_EQ(gaps[0].moving, "key");
    EXPECT_EQ(gaps[0].other, "hole");
    EXPECT_NEAR(gaps[0].distance, 0.09 * kMm, 1e-8);
    EXPECT_FALSE(gaps[0].overlap);
    // decision 0053: in a narrow fit force begins 0.02 voxels away, to within 0.02
    EXPECT_DOUBLE_EQ(gaps[0].needed, 0.05 * voxel);
    EXPECT_NEAR(gaps[0].voxel_fits, 1.8 * kMm, 1e-9);  // 0.09 / 0.05
  }
  const std::vector<StartGap> gaps = GapsOf(SceneOfBodies(4 * kMm, kKey), meshes_W);
  EXPECT_THAT(
      Describe(gaps[0]),
      HasSubstr("key-hole: 0.09 mm apart, contact needs a gap of 0.2 mm: a voxel_m of 0.0018 "
                "or less fits"));
}

TEST(StartGaps, NamedVoxelSizeGivesNoWarning) {
  for (const double play : {0.013 * kMm, 0.09 * kMm, 0.258 * kMm, 0.4 * kMm}) {
    const std::vector<TriangleMesh> meshes_W = KeyInHole(play);
    const double voxel = play / 0.03;
    const std::vector<StartGap> gaps = GapsOf(SceneOfBodies(voxel, kKey), meshes_W);
    ASSERT_THAT(gaps, SizeIs(1)) << play;
    EXPECT_GT(gaps[0].voxel_fits, 0.9 * play / 0.05);
    EXPECT_THAT(GapsOf(SceneOfBodies(0.999 * gaps[0].voxel_fits, kKey), meshes_W), IsEmpty());
  }
  EXPECT_THAT(GapsOf(SceneOfBodies(1 * kMm, kKey), KeyInHole(0.051 * kMm)), IsEmpty());
}

// Play of 0.07 mm at voxels of 0.5 mm: contact does not push, but a hand presses the part in deeper
// than its play, so that nobody can tell whether it fits.
TEST(StartGaps, NameTheVoxelSizeThatDecidesWhetherAPressedPartFits) {
  const std::vector<TriangleMesh> meshes_W = KeyInHole(0.07 * kMm);
  const Scene scene = SceneOfBodies(0.5 * kMm, kKey);
  EXPECT_THAT(GapsOf(scene, meshes_W), IsEmpty());
  const std::vector<StartGap> pressed = FindStartGaps(scene, meshes_W).gaps;
  ASSERT_THAT(pressed, SizeIs(1));
  EXPECT_NEAR(pressed[0].pressed, 0.104 * kMm, 0.001 * kMm);
  EXPECT_NEAR(pressed[0].voxel_decides, 0.165 * kMm, 0.01 * kMm);
  EXPECT_THAT(Describe(pressed[0]), HasSubstr("key-hole: 0.07 mm apart, and a hand may press them "
                                              "up to 0.104 mm into one another"));
  EXPECT_THAT(Describe(pressed[0]), HasSubstr("a voxel_m of 0.00016 or less decides"));
  EXPECT_THAT(FindStartGaps(SceneOfBodies(0.33 * kMm, kKey), meshes_W).gaps, IsEmpty());
  Scene plain = scene;
  plain.contact = ContactModel::kPlain;
  plain.force_layer = 2;
  // plain contact begins more than a voxel away, where nobody presses surfaces together
  EXPECT_EQ(YieldOf(plain, 0).PressedDepth(), 0);
}

TEST(StartGaps, PlainModelHasALargerOnset) {
  Scene scene = SceneOfBodies(1 * kMm, kKey);
  scene.contact = ContactModel::kPlain;
  scene.force_layer = 2;
  // decision 0010 measured 5.04 voxels at the most
  EXPECT_GT(ContactBegins(scene, 0), 5.04 * kMm);
  EXPECT_LT(ContactBegins(scene, 0), 5.5 * kMm);
  EXPECT_THAT(GapsOf(scene, KeyInHole(4 * kMm)), SizeIs(1));
}

TEST(StartGaps, OverlapIsReportedWithItsDepth) {
  // 2 mm into a plate whose other side is far
  const std::vector<TriangleMesh> meshes_W{
      BoxBetween({-50 * kMm, -50 * kMm, -30 * kMm}, {50 * kMm, 50 * kMm, 0}),
      BoxBetween({-5 * kMm, -5 * kMm, -2 * kMm}, {5 * kMm, 5 * kMm, 20 * kMm})};
  const std::vector<StartGap> gaps =
      GapsOf(SceneOfBodies(1 * kMm, {FixedBody("plate"), MovingBody("part")}), meshes_W);
  ASSERT_THAT(gaps, SizeIs(1));
  EXPECT_TRUE(gaps[0].overlap);
  EXPECT_NEAR(gaps[0].depth, 2 * kMm, 1e-6);
  EXPECT_THAT(Describe(gaps[0]), HasSubstr("part-plate: they overlap by 2 mm at the start"));
}

TEST(StartGaps, ContainedBodyOverlaps) {
  const std::vector<TriangleMesh> meshes_W{BoxOfHalf(Vec3::Constant(30 * kMm)),
                                           BoxOfHalf(Vec3::Constant(5 * kMm))};
  const std::vector<StartGap> gaps =
      GapsOf(SceneOfBodies(1 * kMm, {FixedBody("block"), MovingBody("part")}), meshes_W);
  ASSERT_THAT(gaps, SizeIs(1));
  EXPECT_TRUE(gaps[0].overlap);
  // every point of its surface is 30 - 5 mm from a face of the block
  EXPECT_NEAR(gaps[0].depth, 25 * kMm, 1e-6);
}

TEST(StartGaps, TouchingBodiesDoNotOverlap) {
  const std::vector<TriangleMesh> meshes_W{
      BoxBetween({-50 * kMm, -50 * kMm, -30 * kMm}, {50 * kMm, 50 * kMm, 0}),
      BoxBetween({-5 * kMm, -5 * kMm, 0}, {5 * kMm, 5 * kMm, 20 * kMm})};
  const std::vector<StartGap> gaps =
      GapsOf(SceneOfBodies(1 * kMm, {FixedBody("plate"), MovingBody("part")}), meshes_W);
  ASSERT_THAT(gaps, SizeIs(1));
  EXPECT_FALSE(gaps[0].overlap);
  EXPECT_EQ(gaps[0].distance, 0);
  EXPECT_THAT(Describe(gaps[0]), HasSubstr("they touch at the start"));
}

TEST(StartGaps, PartSeatedByItsInwardShiftIsNotReported) {
  const std::vector<TriangleMesh> meshes_W{
      BoxBetween({-50 * kMm, -50 * kMm, -30 * kMm}, {50 * kMm, 50 * kMm, 0}),
      BoxBetween({-5 * kMm, -5 * kMm, 0}, {5 * kMm, 5 * kMm, 20 * kMm})};
  Scene scene = SceneOfBodies(1 * kMm, {FixedBody("plate"), MovingBody("part")});
  scene.bodies[1].inward_shift_voxels = 0.5;
  EXPECT_THAT(GapsOf(scene, meshes_W), IsEmpty());
  // a part that is shifted outwards needs what a narrow fit needs, which is more than nothing
  scene.bodies[1].inward_shift_voxels = -0.5;
  const std::vector<StartGap> gaps = GapsOf(scene, meshes_W);
  ASSERT_THAT(gaps, SizeIs(1));
  EXPECT_DOUBLE_EQ(gaps[0].needed, 0.05 * kMm);
  EXPECT_DOUBLE_EQ(ContactBegins(scene, -0.5), 0.95 * kMm);
}

// If both bodies move, the smaller one has the points and its shift counts.
TEST(StartGaps, PartSeatedInAMovingBodyIsNotReported) {
  const std::vector<TriangleMesh> meshes_W{
      BoxBetween({-50 * kMm, -50 * kMm, -30 * kMm}, {50 * kMm, 50 * kMm, 0}),
      BoxBetween({-5 * kMm, -5 * kMm, 0}, {5 * kMm, 5 * kMm, 20 * kMm})};
  Scene scene = SceneOfBodies(1 * kMm, {MovingBody("socket"), MovingBody("ball")});
  EXPECT_THAT(GapsOf(scene, meshes_W), SizeIs(1));
  scene.bodies[1].inward_shift_voxels = 0.5;
  EXPECT_THAT(GapsOf(scene, meshes_W), IsEmpty());
}

// The gaps choose the pointshell as the simulation does: `pairs` goes before the number of points.
TEST(StartGaps, ShiftIsThatOfTheScenesPointshell) {
  const std::vector<TriangleMesh> meshes_W{
      BoxBetween({-50 * kMm, -50 * kMm, -30 * kMm}, {50 * kMm, 50 * kMm, 0}),
      BoxBetween({-5 * kMm, -5 * kMm, 0}, {5 * kMm, 5 * kMm, 20 * kMm})};
  Scene scene = SceneOfBodies(1 * kMm, {MovingBody("socket"), MovingBody("ball")});
  scene.bodies[1].inward_shift_voxels = 0.5;
  EXPECT_THAT(GapsOf(scene, meshes_W), IsEmpty());
  scene.pairs = {{.pointshell = "socket", .voxmap = "ball"}};
  EXPECT_THAT(GapsOf(scene, meshes_W), SizeIs(1)) << "the socket's points are not shifted";
  scene.pairs = {{.pointshell = "ball", .voxmap = "socket"}};
  EXPECT_THAT(GapsOf(scene, meshes_W), IsEmpty());
  // finer points are more points: the ball becomes the voxmap
  scene.pairs = {};
  scene.bodies[1].point_spacing_voxels = 0.1;
  EXPECT_THAT(GapsOf(scene, meshes_W), SizeIs(1));
}

TEST(StartGaps, UncheckedPairsAreCounted) {
  const Scene scene = SceneOfBodies(
      1 * kMm, {FixedBody("plate"), MovingBody("a"), MovingBody("b"), MovingBody("far")});
  const std::vector<TriangleMesh> meshes_W{
      BoxBetween({-50 * kMm, -50 * kMm, -30 * kMm}, {50 * kMm, 50 * kMm, 0}),
      BoxBetween({-5 * kMm, -5 * kMm, 0.03 * kMm}, {0, 5 * kMm, 20 * kMm}),
      BoxBetween({0.03 * kMm, -5 * kMm, 0.03 * kMm}, {5 * kMm, 5 * kMm, 20 * kMm}),
      BoxBetween({-5 * kMm, -5 * kMm, 100 * kMm}, {5 * kMm, 5 * kMm, 120 * kMm})};
  const std::vector<double> points(4, 1.0);
  int requested = 0;
  const StartGaps some = FindStartGaps(scene, meshes_W, points, [&requested] {
    return ++requested > 1;
  });
  EXPECT_THAT(some.gaps, SizeIs(1));
  EXPECT_EQ(some.unseen, 2U) << "a-b and b-plate; the far one needs no time";
  const StartGaps all = FindStartGaps(scene, meshes_W, points, [] {
    return false;
  });
  EXPECT_THAT(all.gaps, SizeIs(3));
  EXPECT_EQ(all.unseen, 0U);
}

TEST(StartGaps, MovingPairsAreReportedOnceAndMergedPartsNever) {
  Scene scene =
      SceneOfBodies(1 * kMm, {MovingBody("shaft"), MovingBody("gear"), MovingBody("ring")});
  scene.bodies[1].mass = 0;
  scene.bodies[1].merge_with = "shaft";
  // gear touches its shaft; the ring stands 0.03 mm beside the gear
  const std::vector<TriangleMesh> meshes_W{
      BoxBetween({0, 0, 0}, {5 * kMm, 5 * kMm, 5 * kMm}),
      BoxBetween({5 * kMm, 0, 0}, {10 * kMm, 5 * kMm, 5 * kMm}),
      BoxBetween({10.03 * kMm, 0, 0}, {15 * kMm, 5 * kMm, 5 * kMm})};
  const std::vector<StartGap> gaps = GapsOf(scene, meshes_W);
  ASSERT_THAT(gaps, SizeIs(1));
  EXPECT_EQ(gaps[0].moving, "shaft");
  EXPECT_EQ(gaps[0].other, "ring");
  EXPECT_NEAR(gaps[0].distance, 0.03 * kMm, 1e-8);
}

}  // namespace
}  // namespace tandem
