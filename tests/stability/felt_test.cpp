#include <gtest/gtest.h>

#include "tests/stability/type2_run.h"

namespace tandem {
namespace {

using testing::RunType2;
using testing::Type2Case;
using testing::Type2Run;
using testing::UserOf;

enum class What { kNothing, kJoin, kLeave, kKill, kHalt };

/// Two hold against one another with 3 N on the link; 6 s in something happens to a third one, who
/// comes, or to the second one, who goes.
Type2Case ThreeNewtons(double tau, What what) {
  const double k = DefaultLaw()->Link(LawInputsAt(2 * tau + 0.002, 2, 1.5)).stiffness;
  const double side = 1.0 / (1.0 / 300 + 1.0 / 800);  // the hand and its coupling
  const double way = 3.0 * (1.0 / k + 2.0 / side);
  Type2Case test{.conditions = {.delay_ms = 1e3 * tau}, .seconds = 10};
  test.ways = {{{0, Vec3::Zero(), Quat::Identity()}, {1, Vec3(way, 0, 0), Quat::Identity()}}};
  test.before = [what, test](SimulatedSession& session, int frame) {
    if (frame == 8000 && what == What::kHalt) session.Halt(1, false);
    if (frame != 6000) return;
    if (what == What::kJoin) session.Add(UserOf(test, 2), 3);
    if (what == What::kLeave) session.Leave(1);
    if (what == What::kKill) session.Kill(1);
    if (what == What::kHalt) session.Halt(1, true);
  };
  return test;
}

/// The largest change of a force within `frames`, event or not; from 5.5 s on.
double LargestChange(const std::vector<double>& force, std::size_t frames) {
  double largest = 0;
  for (std::size_t i = 5500; i + frames < force.size(); ++i) {
    largest = std::max(largest, std::abs(force[i + frames] - force[i]));
  }
  return largest;
}

TEST(Felt, WhoComesOrGoesChangesNoForceByMoreThanOneNewton) {
  for (const double tau : {0.001, 0.02, 0.1}) {
    const Type2Run calm = RunType2(ThreeNewtons(tau, What::kNothing));
    ASSERT_NEAR(calm.link_force[5900], 3.0, 0.15) << tau;
    for (const What what : {What::kJoin, What::kLeave, What::kKill, What::kHalt}) {
      const Type2Run run = RunType2(ThreeNewtons(tau, what));
      if (what == What::kLeave || what == What::kKill) {
        EXPECT_NEAR(run.link_force.back(), 0, 1e-9);
      }
      for (const std::size_t frames : {1U, 100U}) {
        const double hand = LargestChange(run.hand_force, frames);
        const double link = LargestChange(run.link_force, frames);
        EXPECT_LE(hand - LargestChange(calm.hand_force, frames), 1.0)
            << "hand, tau " << tau << ", event " << static_cast<int>(what) << ", " << frames;
        EXPECT_LE(link - LargestChange(calm.link_force, frames), 1.0)
            << "link, tau " << tau << ", event " << static_cast<int>(what) << ", " << frames;
        RecordProperty("hand_" + std::to_string(static_cast<int>(1000 * tau)) + "ms_" +
                           std::to_string(static_cast<int>(what)) + "_" + std::to_string(frames),
                       std::to_string(hand));
        RecordProperty("link_" + std::to_string(static_cast<int>(1000 * tau)) + "ms_" +
                           std::to_string(static_cast<int>(what)) + "_" + std::to_string(frames),
                       std::to_string(link));
      }
    }
  }
}

}  // namespace
}  // namespace tandem
