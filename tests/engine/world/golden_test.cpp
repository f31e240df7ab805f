// Tests that the same inputs give the same bits, by each instruction set that the kernels are
// compiled for, on one, two and four threads.
#include <gtest/gtest.h>
#include <hwy/targets.h>

#include "engine/base/hash.h"
#include "engine/contact/schedule/voxmap_lookup.h"
#include "engine/realtime/worker_pool.h"
#include "tests/support/shapes.h"
#include "tests/support/test_world.h"

namespace tandem {
namespace {

using testing::At;
using testing::Box;
using testing::Sphere;

// GCC 12 makes these values, with glibc 2.36 on a processor with FMA: sines and cosines of glibc
// have other last bits without it. A change that means to alter what a frame does alters them, and
// says so.
constexpr std::uint64_t kRefined = 7071096442309765680U;
constexpr std::uint64_t kPlain = 2980911089493354738U;

std::shared_ptr<const WorldModel> BallAndBlockOnATable(ContactModel contact) {
  const double up = contact == ContactModel::kRefined ? 0.001 : 0.003;
  auto made = std::make_shared<WorldModel>(
      *testing::MakeWorldModel({{At(Box(Vec3(0.3, 0.2, 0.01)), Vec3(0, 0, -0.005)), true},
                                {At(Box(Vec3(0.04, 0.03, 0.02)), Vec3(-0.06, 0, 0.01 + up))},
                                {At(Sphere(0.012, 4), Vec3(0, 0.002, 0.012 + up))}},
                               testing::kVoxel, contact));
  made->scene.friction = 0.3;
  made->scene.gravity_W = Vec3(0, 0, -9.81);
  return made;
}

/// Lets a hand draw the block over the table, turn it, and push the ball before it.
std::uint64_t HashOfARun(ContactModel contact, int threads) {
  kHapticThread.Enter();
  const auto model = BallAndBlockOnATable(contact);
  EXPECT_EQ(model->bodies[1].surface.rounds.empty(), contact == ContactModel::kPlain);
  WorkerPool workers({.threads = threads, .priority = 0});
  ScheduleOptions schedule;
  schedule.workers = threads > 1 ? &workers : nullptr;
  schedule.shared_from = 40;
  World world(model, schedule);
  StepInputs inputs = testing::FreeInputs(*model);
  Hash64 hash;
  int pushed = 0;
  for (int frame = 0; frame < 1500; ++frame) {
    const double way = 1e-4 * std::min(frame, 1000);
    Pose goal = model->bodies[0].X_WB0;
    goal.p += Vec3(way, 0.02 * way, -0.002);
    goal.q = RotationBy(Vec3(0, 0, 3 * way));
    inputs.hand = testing::HandTo(*model, 0, goal);
    world.Step(inputs);
    pushed += world.Pushed(1) ? 1 : 0;
    for (std::size_t body = 0; body < 2; ++body) {
      const RigidState& state = world.state(body);
      for (const double x : state.X_WB.q.coeffs()) hash.Add(x);
      for (const Vec3* v : {&state.X_WB.p, &state.V_WB.v, &state.V_WB.w}) {
        for (const double x : *v) hash.Add(x);
      }
    }
  }
  EXPECT_GT(pushed, 50);
  return hash.value();
}

class Golden : public ::testing::Test {
 protected:
  void TearDown() override { hwy::SetSupportedTargetsForTest(0); }

  void SetUp() override {
    if (__builtin_cpu_supports("fma") == 0) GTEST_SKIP() << "a processor without FMA";
  }

  static void ExpectEverywhere(ContactModel contact, std::uint64_t expected) {
    int targets = 0;
    for (std::int64_t left = hwy::SupportedTargets(); left != 0; left &= left - 1) {
      const std::int64_t target = left & -left;
      hwy::SetSupportedTargetsForTest(target);
      if (std::string(KernelIsa()) == hwy::TargetName(target)) {  // it is compiled for that one
        ++targets;
        EXPECT_EQ(HashOfARun(contact, 1), expected) << hwy::TargetName(target);
      }
      hwy::SetSupportedTargetsForTest(0);
    }
    EXPECT_GE(targets, 2);
    for (const int threads : {2, 4}) EXPECT_EQ(HashOfARun(contact, threads), expected) << threads;
  }
};

TEST_F(Golden, RefinedFramesHaveTheSameBitsEverywhere) {
  ExpectEverywhere(ContactModel::kRefined, kRefined);
}

TEST_F(Golden, PlainFramesHaveTheSameBitsEverywhere) {
  ExpectEverywhere(ContactModel::kPlain, kPlain);
}

}  // namespace
}  // namespace tandem
