#include "tests/simulator/injected_faults.h"

#include <array>
#include <cstdint>
#include <cstdlib>
#include <map>
#include <memory>
#include <ostream>
#include <regex>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "collab/simulated/network/fault_schedule.h"
#include "collab/simulated/network/light_scene.h"
#include "collab/simulated/simulator.h"
#include "tests/simulator/violation_sorts.h"

namespace tandem {
namespace {

using testing::NameOfTest;
using testing::SortOf;
using testing::SortsIn;

/// A fault, a sort of violation that a session with it is to show, and a seed that does, which is
/// looked at first, for time. Where another build of the program has other bits and that seed shows
/// nothing, all seeds are looked at from 1 on, or those of them that draw the law.
struct Expected {
  Fault fault;
  const char* sort;  // up to the first body's name
  std::uint64_t seed = 1;
  const char* law = "";  // the only law that shows the fault; empty: any
  bool hostile = false;
};

void PrintTo(const Expected& expected, std::ostream* out) {
  *out << expected.sort;
}

constexpr const char* kEnergy = "a link gives more energy than its credit";
constexpr const char* kEcho = "an echo that was never sent";
constexpr const char* kSofter = "a link softer than the law";
constexpr const char* kStiffer = "a link stiffer than its loop allows";
constexpr const char* kTooStiff = "a link too stiff for the users";
constexpr const char* kMissing = "a link is missing, or one too many";
constexpr const char* kNobody = "nobody answers for a body";
constexpr const char* kNobodyAtRest = "nobody answers for a body though all is quiet";
constexpr const char* kTwo = "two say where a body is";
constexpr const char* kTwoHands = "one body is in two hands";
constexpr const char* kCopies = "copies of ";
constexpr const char* kAgree = "peers do not agree who answers for a body";
constexpr const char* kPulled = "a hand is pulled though all is quiet";
constexpr const char* kNotListened = "one who was stopped speaks before it has listened";
constexpr const char* kJumps = "a hand's force jumps";

constexpr std::array kExpected{
    Expected{Fault::kLinkSign, kEnergy},
    Expected{Fault::kLinkSign, "a link pushes instances apart"},
    Expected{Fault::kEchoOfArrival, kEcho}, Expected{Fault::kOwnStampForTheirs, kEcho},
    Expected{Fault::kUsersInPlaceOfLinks, kSofter}, Expected{Fault::kEveryLinkWhole, kTooStiff, 34},
    Expected{Fault::kHalfTheDelay, kStiffer, 2}, Expected{Fault::kLostGoodbye, kNobody, 2},
    Expected{Fault::kLostGoodbye, "one who is gone is still here", 2},
    Expected{Fault::kLostLease, kNobody}, Expected{Fault::kLostReturn, kTwo, 3},
    Expected{Fault::kOneDelayForAll, kStiffer, 2}, Expected{Fault::kStatesDropped, kSofter},
    Expected{Fault::kLinksDropped, kSofter}, Expected{Fault::kDueNever, kCopies, 6},
    Expected{Fault::kNotFinite, "not finite on the wire"},
    Expected{Fault::kNegativeStiffness, "a stiffness below zero"},
    Expected{Fault::kStaleState, kCopies}, Expected{Fault::kMirrorFrozen, kCopies},
    Expected{Fault::kOthersName, "a peer writes as another"},
    Expected{Fault::kClaimsForgotten, kAgree}, Expected{Fault::kFadeNever, kPulled},
    Expected{Fault::kLinkTurn, "a link turns instances apart"},
    // other laws give gains that are passive by themselves
    Expected{Fault::kGateForgets, kEnergy, 115, "constant"},
    Expected{Fault::kEchoForAnother, kStiffer, 7},
    Expected{Fault::kStaleClaim, "a claim goes back", 3}, Expected{Fault::kGrantKept, kTwo, 4},
    Expected{Fault::kGrantKept, kTwoHands, 5}, Expected{Fault::kHandsKept, kTwo, 6},
    Expected{Fault::kLostRelease, kAgree, 7}, Expected{Fault::kAllSucceed, kTwo},
    Expected{Fault::kNoListening, kNotListened, 5}, Expected{Fault::kNoGuard, kJumps},
    Expected{Fault::kNoParkedPose, kCopies, 11}, Expected{Fault::kMirrorNotTurned, kCopies},
    Expected{Fault::kViewerWrites, "a viewer writes"},
    Expected{Fault::kTurnTooLong, "a rotation that is none"},
    Expected{Fault::kStampOfBefore, "stamps go back"},
    Expected{Fault::kEpochOfBefore, "an epoch goes back"},
    Expected{Fault::kBeatStands, "a beat goes back"},
    Expected{Fault::kEventNumberStands, "an event's number goes back"},
    Expected{Fault::kLinkToItself, "a link to nobody"},
    Expected{Fault::kBodyForObject, "a state of no body"},
    Expected{Fault::kHeldGranted, kTwoHands, 5}, Expected{Fault::kNoSuccession, kNobodyAtRest, 8},
    Expected{Fault::kBodyNotFinite, "a simulation is not finite"},
    Expected{Fault::kHeldSlips, "a body in hand jumps"},
    Expected{Fault::kHeldSlips, "hands do not come to rest", 5},
    Expected{Fault::kContactOff, "what the hand holds is in the plate"},
    Expected{Fault::kContactOff, "a body is in the one that the hand holds", 6},
    Expected{Fault::kMirrorTrembles, "a mirror pushes in by more than its share", 6},
    Expected{Fault::kNoNumberFelt, "a hand's force is not finite"},
    Expected{Fault::kFeltTenfold, "a hand's force is beyond the clamp", 3},
    Expected{Fault::kFeltTenfold, "a hand's moment is beyond the clamp", 28},
    Expected{Fault::kFeltTenfold, "a hand's moment jumps"},
    Expected{Fault::kReturnUnknown, "one who is here is missed"},
    Expected{Fault::kReturnUnknown, kMissing},
    Expected{Fault::kViewerKeepsLost, "the viewer misses one", 5},
    Expected{Fault::kNeverYields, "peers claim a body above one another"},
    // beside a member that keeps to no rule
    Expected{Fault::kSeizureBelieved, "a hand loses a body to a hostile member", 6, "", true},
    Expected{Fault::kGrantBelieved, "a hand loses what it holds", 9, "", true},
    Expected{Fault::kLeapBelieved, "an epoch runs away", 1, "", true}};

std::uint64_t MostSeeds() {
  const char* const requested = std::getenv("TANDEM_INJECTED_FAULT_SEEDS");
  return requested != nullptr ? std::strtoull(requested, nullptr, 10) : 200;
}

const std::shared_ptr<const WorldModel>& Model() {
  static const std::shared_ptr<const WorldModel> model = MakeLightScene();
  return model;
}

/// Returns what a seed breaks without any injected fault.
const std::set<std::string>& BrokenAnyway(std::uint64_t seed, bool hostile) {
  static std::map<std::pair<std::uint64_t, bool>, std::set<std::string>> known;
  const auto [it, added] = known.try_emplace({seed, hostile});
  if (!added) return it->second;
  injected_fault = Fault::kNone;
  for (const std::string& broken : SimulateSeed(seed, Model(), {}, hostile).broken) {
    it->second.insert(SortOf(broken));
  }
  return it->second;
}

/// Returns the seed that is known to show it, then all in turn.
std::vector<std::uint64_t> SeedsFor(const Expected& expected) {
  std::vector<std::uint64_t> seeds{expected.seed};
  const std::string_view law = expected.law;
  for (std::uint64_t seed = 1; seeds.size() <= MostSeeds(); ++seed) {
    const bool draws = law.empty() || DrawSchedule(seed).law == law;
    if (seed != expected.seed && draws) seeds.push_back(seed);
  }
  return seeds;
}

bool IsOf(const std::string& broken, std::string_view sort) {
  return sort == kCopies ? broken.starts_with(sort) : broken == sort;
}

class InjectedFault : public ::testing::TestWithParam<Expected> {
 protected:
  ~InjectedFault() override { injected_fault = Fault::kNone; }
};

// Tests the checkers: with the fault in it a session breaks what the fault is about, which the same
// seed does not break without.
TEST_P(InjectedFault, BreaksItsInvariant) {
  const Expected& expected = GetParam();
  std::set<std::string> others;  // sorts that broke as well, or first
  for (const std::uint64_t seed : SeedsFor(expected)) {
    const std::set<std::string>& anyway = BrokenAnyway(seed, expected.hostile);
    injected_fault = expected.fault;
    for (const std::string& broken : SimulateSeed(seed, Model(), {}, expected.hostile).broken) {
      if (anyway.contains(SortOf(broken))) continue;
      if (IsOf(SortOf(broken), expected.sort)) {
        RecordProperty("seed", std::to_string(seed));
        RecordProperty("broken", broken);
        return;
      }
      others.insert(SortOf(broken));
    }
  }
  ADD_FAILURE() << "no seed breaks \"" << expected.sort
                << "\"; others: " << ::testing::PrintToString(others);
}

std::string NameOf(const ::testing::TestParamInfo<Expected>& tested) {
  return NameOfTest(static_cast<int>(tested.param.fault), tested.param.sort);
}

INSTANTIATE_TEST_SUITE_P(Faults, InjectedFault, ::testing::ValuesIn(kExpected), NameOf);

TEST(InjectedFaults, AreAllExpectedToBreakSomething) {
  std::set<Fault> expected;
  for (const Expected& row : kExpected) expected.insert(row.fault);
  EXPECT_EQ(expected.size() + 1, static_cast<std::size_t>(Fault::kCount));
}

// A check that finds no fault may as well be blind.
TEST(InjectedFaults, CoverEveryInvariant) {
  // the words of each Add()
  const std::regex add(R"re(Add\(\s*(?:\w+ \? )?"([^"]+)"(?:\s*:\s*"([^"]+)")?)re");
  const std::set<std::string> known = SortsIn(TANDEM_SIMULATED, add, [](const auto& file) {
    return file.stem().string().find("checker") != std::string::npos;
  });
  std::set<std::string> found;
  for (const Expected& row : kExpected) found.insert(row.sort);
  EXPECT_EQ(known, found);
}

}  // namespace
}  // namespace tandem
