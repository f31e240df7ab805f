#include "tests/simulator/injected_hand_faults.h"

#include <array>
#include <map>
#include <ostream>
#include <regex>
#include <set>
#include <string>

#include <gtest/gtest.h>

#include "collab/simulated/hands/hands_simulator.h"
#include "collab/simulated/network/light_scene.h"
#include "tests/simulator/violation_sorts.h"

namespace tandem {
namespace {

using testing::NameOfTest;
using testing::SortOf;
using testing::SortsIn;

constexpr double kSession = 20;           // s
constexpr std::uint64_t kMostSeeds = 40;  // seeds that are looked at for a fault

/// A fault and a sort of violation that sessions with it are to show.
struct Expected {
  HandFault fault;
  const char* sort;
};

void PrintTo(const Expected& expected, std::ostream* out) {
  *out << expected.sort;
}

constexpr std::array kExpected{
    Expected{HandFault::kAnswerTwice, "a request has two answers"},
    Expected{HandFault::kNoAnswer, "a request has no answer"},
    Expected{HandFault::kAnswerUnasked, "an answer to what nobody asked"},
    Expected{HandFault::kStopUnheard, "a part is in hand during an emergency stop"},
    Expected{HandFault::kTakenWhileStopped, "something is taken during an emergency stop"},
    Expected{HandFault::kSilenceUnnoticed, "a hand holds on though its host is gone"},
    Expected{HandFault::kSilenceUnnoticed, "the goal of a silent host is not held"},
    Expected{HandFault::kHoldForgotten, "the goal of a silent host is not held"},
    Expected{HandFault::kForeignGoals, "a hand follows a host that does not have it"},
    Expected{HandFault::kForeignRequests, "a host takes the hand that another has"},
    Expected{HandFault::kGoalWanders, "a goal moves without a word of its host"},
    Expected{HandFault::kGoalsLost, "the goal of the host that has the hand is not gone to"},
    Expected{HandFault::kHugeGoal, "a goal that is no place is gone to"},
    Expected{HandFault::kNoLead, "a goal leads its part by more than the force limit"},
    Expected{HandFault::kNoSpeed, "a part is faster than its goal makes it"},
    Expected{HandFault::kTurnsAhead, "a goal is turned too far ahead of its part"},
    Expected{HandFault::kHandPushes, "a hand pulls with more than its limit"},
    Expected{HandFault::kWayToNowhere, "a way back ends elsewhere than it began"},
    Expected{HandFault::kSlipsWhenLetGo, "a body that was let go of moves"},
    Expected{HandFault::kSlipsWhenLetGo, "a body moves though all is quiet"},
    Expected{HandFault::kNoSnapshots, "a host sees no snapshot"},
    Expected{HandFault::kSnapshotStands, "a snapshot is of long ago"},
    Expected{HandFault::kBodyElsewhere, "a snapshot has a body elsewhere"},
    Expected{HandFault::kBodyMissing, "a snapshot lacks a body"},
    Expected{HandFault::kSnapshotNoNumber, "a snapshot is not finite"},
    Expected{HandFault::kHolderMissing, "a snapshot has the wrong holders"},
    Expected{HandFault::kMotorTenfold, "a motor's force is beyond the clamp"},
    Expected{HandFault::kMotorJumps, "a motor's force jumps"},
    Expected{HandFault::kMotorNoNumber, "what a motor gets is not finite"},
    Expected{HandFault::kMotorKeeps, "a motor has force that nobody stands for"},
    Expected{HandFault::kMotorPushesOn, "a motor has more than damping of a late order"},
    Expected{HandFault::kMotorAfterStop, "a motor has force during a stop"},
    Expected{HandFault::kMotorAfterFault, "a motor has force in spite of a fault"},
    Expected{HandFault::kMotorAtOnce, "a motor has force before anybody began"},
    Expected{HandFault::kMotorAtOnce, "a motor's force comes back by itself"},
    Expected{HandFault::kMotorAtOnce, "a motor's force comes back faster than its ramp"},
    Expected{HandFault::kMotorTooFast, "a motor has force though the handle is too fast"}};

std::set<std::string> BrokenBy(HandFault fault, std::uint64_t seed) {
  static const std::shared_ptr<const WorldModel> model = MakeLightScene();
  static std::map<std::pair<HandFault, std::uint64_t>, std::set<std::string>> known;
  const auto [it, added] = known.try_emplace({fault, seed});
  if (!added) return it->second;
  injected_hand_fault = fault;
  for (const std::string& broken : SimulateHands(seed, kSession, model).broken) {
    it->second.insert(SortOf(broken));
  }
  injected_hand_fault = HandFault::kNone;
  return it->second;
}

class InjectedHandFault : public ::testing::TestWithParam<Expected> {};

// Tests the checkers: with the fault in it a session breaks what the fault is about, which the same
// seed does not break without.
TEST_P(InjectedHandFault, BreaksItsInvariant) {
  const Expected& expected = GetParam();
  std::set<std::string> others;
  for (std::uint64_t seed = 1; seed <= kMostSeeds; ++seed) {
    const std::set<std::string> broken = BrokenBy(expected.fault, seed);
    if (broken.contains(expected.sort)) {
      EXPECT_FALSE(BrokenBy(HandFault::kNone, seed).contains(expected.sort)) << seed;
      return RecordProperty("seed", std::to_string(seed));
    }
    others.insert(broken.begin(), broken.end());
  }
  ADD_FAILURE() << "no seed breaks \"" << expected.sort
                << "\"; others: " << ::testing::PrintToString(others);
}

std::string NameOf(const ::testing::TestParamInfo<Expected>& tested) {
  return NameOfTest(static_cast<int>(tested.param.fault), tested.param.sort);
}

INSTANTIATE_TEST_SUITE_P(Faults, InjectedHandFault, ::testing::ValuesIn(kExpected), NameOf);

TEST(InjectedHandFaults, AreAllExpectedToBreakSomething) {
  std::set<HandFault> expected;
  for (const Expected& row : kExpected) expected.insert(row.fault);
  EXPECT_EQ(expected.size() + 1, static_cast<std::size_t>(HandFault::kCount));
}

// A check that finds no fault may as well be blind. The sorts are the sentences in the checkers'
// source.
TEST(InjectedHandFaults, CoverEveryInvariant) {
  const std::regex sentence(R"re("((?:a|an|the|what|something) [a-z' ]+)")re");
  const std::set<std::string> known =
      SortsIn(TANDEM_SIMULATED_HANDS, sentence, [](const auto& file) {
        const bool looks = file.stem().string().find("checker") != std::string::npos ||
                           file.filename() == "hands_simulator.cpp";
        return looks && file.extension() == ".cpp";
      });
  std::set<std::string> found;
  for (const Expected& row : kExpected) found.insert(row.sort);
  EXPECT_EQ(known, found);
}

}  // namespace
}  // namespace tandem
