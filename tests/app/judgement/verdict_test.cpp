#include "app/judgement/verdict.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/key_scene.h"
#include "tests/support/test_world.h"

namespace tandem {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr double kVerdictVoxel = 0.0005;

/// Returns a key in a hole with a play of 0.09 mm.
std::shared_ptr<const WorldModel> Key() {
  static const std::shared_ptr<const WorldModel> model = testing::MakeWorldModel(
      {{testing::KeyholeMesh(0.00009), true}, {testing::KeyMesh()}}, kVerdictVoxel);
  return model;
}

/// Returns the bodies met in a run in which contact pushed the key, which has less play than
/// contact takes.
TouchedBodies Met(bool pushed) {
  TouchedBodies met(1);
  World world(Key());
  kHapticThread.Enter();
  world.Step(testing::FreeInputs(*Key()));
  EXPECT_TRUE(world.Touched(0));
  if (pushed) met.See(world, 0);
  return met;
}

/// Returns the verdict of a run through these displacements.
BodyVerdict VerdictOf(const std::vector<Vec3>& way, bool loaded, bool contact_off = false,
                      bool loaded_at_last = false, double peak_force = 0) {
  const Pose& X_WB0 = Key()->bodies[0].X_WB0;
  HeldPoses poses;
  for (const Vec3& p : way) {
    poses.Add({.body = 0, .X_WB = {X_WB0.q, X_WB0.p + p}});
  }
  const std::vector<BodyVerdict> verdicts =
      Judge(*Key(), poses, Met(loaded), {{{X_WB0.q, X_WB0.p + way.back()}, loaded_at_last}},
            contact_off, peak_force);
  EXPECT_THAT(verdicts, SizeIs(1));
  return verdicts.front();
}

TEST(Verdict, ReportsTheDepthOfAPenetration) {
  // 0.49 mm aside, of which 0.09 mm are play
  const BodyVerdict verdict =
      VerdictOf({Vec3::Zero(), Vec3(0.00049, 0, 0.005), Vec3(0, 0, 0.06)}, true);
  EXPECT_NEAR(verdict.moved, 0.06, 1e-12);
  EXPECT_EQ(verdict.out, true);
  ASSERT_TRUE(verdict.deepest);
  EXPECT_NEAR(*verdict.deepest, 0.0004, 1e-6);
  EXPECT_EQ(verdict.poses_judged, 3U);
  EXPECT_THAT(Describe(verdict),
              HasSubstr("stands 60.0 mm from its first place and is out; it "
                        "went 0.40 mm \u00b1 0.01 mm into fixed bodies (0.80 voxels"));
}

TEST(Verdict, TellsWhetherContactGivesWayByTheDepth) {
  // 0.03 mm deep: a hand may press surfaces 0.1 mm into one another at voxels of 0.5 mm
  const BodyVerdict pressed =
      VerdictOf({Vec3::Zero(), Vec3(0.00012, 0, 0.005), Vec3(0, 0, 0.06)}, true);
  const double voxel = Key()->scene.voxel_size;
  ASSERT_NEAR(voxel, 0.0005, 1e-12);
  ASSERT_TRUE(pressed.yield);
  EXPECT_NEAR(pressed.yield->PressedDepth(), 0.208 * voxel, 0.002 * voxel);
  EXPECT_THAT(Describe(pressed), HasSubstr("went 0.030 mm \u00b1 0.0"));
  EXPECT_THAT(
      Describe(pressed),
      HasSubstr("contact gives way by up to 0.1 mm where 10 N rest on one place, so this "
                "does not decide whether the part fits: a voxel_m of 7.2e-05 or less does"));
  EXPECT_NEAR(AsJson({pressed})[0].at("voxel_m_decides").get<double>(), 7.2e-5, 1e-12);
  // 0.4 mm is more than any hand presses
  const BodyVerdict deep =
      VerdictOf({Vec3::Zero(), Vec3(0.00049, 0, 0.005), Vec3(0, 0, 0.06)}, true);
  EXPECT_THAT(Describe(deep), HasSubstr("which is less: the surfaces cross"));
  EXPECT_TRUE(AsJson({deep})[0].at("voxel_m_decides").is_null());
}

// A hand may be set to pull by up to 30 N.
TEST(Verdict, TakesTheHandsGreatestForceForTheYield) {
  const std::vector<Vec3> way{Vec3::Zero(), Vec3(0.00026, 0, 0.005), Vec3(0, 0, 0.06)};
  const BodyVerdict usual = VerdictOf(way, true);
  EXPECT_THAT(Describe(usual), HasSubstr("the surfaces cross"));
  const BodyVerdict strong = VerdictOf(way, true, false, false, 30.0);
  EXPECT_THAT(Describe(strong), HasSubstr("where 30 N rest on one place, so this does not decide"));
  EXPECT_GT(strong.yield->PressedDepth(), usual.yield->PressedDepth());
}

TEST(Verdict, BoundsTheErrorOfADepth) {
  const BodyVerdict verdict =
      VerdictOf({Vec3::Zero(), Vec3(0.00049, 0, 0.005), Vec3(0, 0, 0.06)}, true);
  ASSERT_TRUE(verdict.deepest);
  EXPECT_LE(*verdict.deepest, 0.0004 + 1e-9);
  EXPECT_GE(*verdict.deepest + verdict.deepest_error, 0.0004 - 1e-9);
  EXPECT_LE(verdict.deepest_error, 0.01 * verdict.voxel_size);
  EXPECT_DOUBLE_EQ(AsJson({verdict})[0].at("deepest_tolerance_mm").get<double>(),
                   1e3 * verdict.deepest_error);
}

TEST(Verdict, ReportsAJammedPart) {
  const BodyVerdict verdict = VerdictOf({Vec3::Zero(), Vec3(0.00009, 0, 0.0087)}, true);
  EXPECT_EQ(verdict.out, false);
  EXPECT_THAT(Describe(verdict),
              HasSubstr("stands 8.7 mm from its first place and is NOT out; it never went into"));
}

TEST(Verdict, ReportsAPartThatWasPutBack) {
  const BodyVerdict verdict =
      VerdictOf({Vec3::Zero(), Vec3(0, 0, 0.06), Vec3(0, 0, 0.03), Vec3::Zero()}, true);
  EXPECT_EQ(verdict.out, false);
  EXPECT_TRUE(verdict.was_out);
  EXPECT_NEAR(verdict.farthest, 0.06, 1e-12);
  EXPECT_THAT(Describe(verdict),
              HasSubstr("was 60.0 mm from its first place at the farthest, and out; at the end it "
                        "is back, 0.0 mm from there; it never went into"));
  // the hole is 9 mm high
  const BodyVerdict never = VerdictOf({Vec3(0, 0, 0.0087), Vec3::Zero()}, true);
  EXPECT_FALSE(never.was_out);
  EXPECT_THAT(Describe(never), HasSubstr("stands 0.0 mm from its first place and is NOT out"));
}

// Another hand had moved the part before this one took it.
TEST(Verdict, ReportsTheRestingPoseOfAHeldPart) {
  const BodyVerdict verdict = VerdictOf({Vec3(0, 0, 0.06), Vec3(0, 0, 0.06)}, false);
  EXPECT_THAT(Describe(verdict), HasSubstr("stands 60.0 mm from its first place and is out"));
}

TEST(Verdict, SkipsTheSearchWithoutContact) {
  const std::vector<Vec3> through{Vec3::Zero(), Vec3(0.00049, 0, 0.005), Vec3(0, 0, 0.06)};
  const BodyVerdict free = VerdictOf(through, false);
  EXPECT_EQ(free.poses_judged, 0U);
  EXPECT_EQ(free.deepest, 0.0);
  EXPECT_THAT(Describe(free), HasSubstr("it touched nothing"));
  const BodyVerdict off = VerdictOf(through, false, true);
  EXPECT_NEAR(off.deepest.value_or(0), 0.0004, 1e-6);
  EXPECT_FALSE(off.yield) << "no contact that could give way";
  EXPECT_TRUE(AsJson({off})[0].at("pressed_mm").is_null());
}

/// Returns a plate, a block 0.2 mm above it, where contact pushes, and a block that hangs far from
/// both.
std::shared_ptr<const WorldModel> TwoBlocks() {
  const auto block = [](double x, double z) {
    return testing::BoxBetween({x, 0, z}, {x + 0.004, 0.004, z + 0.004});
  };
  return testing::MakeWorldModel(
      {{testing::BoxBetween({-0.02, -0.02, -0.004}, {0.02, 0.02, 0}), true},
       {block(-0.01, 0.0002)},
       {block(0.01, 0.01)}},
      kVerdictVoxel);
}

// Contact begins at 0.45 voxels, 0.225 mm.
TEST(Verdict, ContactOfOtherBodiesIsNotTheHeldBodys) {
  kHapticThread.Enter();
  const auto model = TwoBlocks();
  World world(model);
  world.Step(testing::FreeInputs(*model));
  TouchedBodies met(2);
  met.See(world, 1);
  EXPECT_FALSE(met[0]) << "not in the hand";
  EXPECT_FALSE(met[1]) << "touches nothing, though the other does";
  met.See(world, 0);
  EXPECT_TRUE(met[0]);
  // a single frame is enough
  world.Place(0, {Quat::Identity(), model->bodies[0].X_WB0.p + Vec3(0, 0, 0.01)});
  world.Step(testing::FreeInputs(*model));
  ASSERT_FALSE(world.Touched(0));
  met.See(world, 0);
  met.See(world, -1);
  EXPECT_TRUE(met[0]);
  EXPECT_FALSE(met[1]);
}

TEST(Verdict, ReportsTheDistanceOfABlockedPart) {
  // its foot stands 0.2 mm above the bars, which are 9 mm high, and 2 mm aside
  const std::vector<Vec3> way{Vec3(0, 0, 0.02), Vec3(0.002, 0, 0.0092)};
  const BodyVerdict held_off = VerdictOf(way, true, false, true);
  ASSERT_TRUE(held_off.held_from);
  EXPECT_NEAR(held_off.held_from->distance, 0.0002, 1e-9);
  EXPECT_THAT(Describe(held_off), HasSubstr("; contact holds it 0.2 mm from "));
  EXPECT_EQ(DescribeGap({.name = "hole", .distance = 0.00038}),
            "contact holds it 0.38 mm from hole; a smaller voxel_m lets it come nearer");
  // no contact there, or surfaces that meet
  EXPECT_FALSE(VerdictOf(way, true).held_from);
  EXPECT_FALSE(VerdictOf({Vec3(0.002, 0, 0.009)}, true, false, true).held_from);
}

TEST(Verdict, EmptyHandHasNoVerdict) {
  HeldPoses poses;
  poses.Add({});
  EXPECT_THAT(Judge(*Key(), poses, Met(false), {{Key()->bodies[0].X_WB0}}, false, 0), IsEmpty());
}

TEST(Verdict, SamplesLongRunsEvenly) {
  HeldPoses poses;
  const std::size_t count = 5 * HeldPoses::kMost;
  for (std::size_t i = 0; i < count; ++i) {
    poses.Add({.body = 0, .X_WB = {Quat::Identity(), Vec3(static_cast<double>(i), 0, 0)}});
  }
  const std::vector<HeldPose>& kept = poses.kept();
  ASSERT_GT(kept.size(), HeldPoses::kMost / 2);
  ASSERT_LE(kept.size(), HeldPoses::kMost);
  const double step = kept[1].X_WB.p.x() - kept[0].X_WB.p.x();
  for (std::size_t i = 1; i < kept.size(); ++i) {
    ASSERT_EQ(kept[i].X_WB.p.x() - kept[i - 1].X_WB.p.x(), step);
  }
  EXPECT_LT(static_cast<double>(count) - kept.back().X_WB.p.x(), 2 * step);
}

}  // namespace
}  // namespace tandem
