#include <array>
#include <cstdint>
#include <cstdlib>
#include <map>
#include <set>
#include <string>

#include <gtest/gtest.h>

#include "collab/planted_faults.h"
#include "collab/simulated/light_scene.h"
#include "collab/simulated/simulator.h"

namespace tandem {
namespace {

/// A fault, what a session with it is to break, and a seed that does: looked at first, for time.
/// Where another build of the program has other bits and that seed finds nothing, all seeds are
/// looked at from 1 on.
struct Expected {
  Fault fault;
  const char* sort;  // the beginning of it
  std::uint64_t seed = 1;
};

constexpr const char* kEnergy = "a link gives more energy than its credit";
constexpr const char* kEcho = "an echo that was never sent";
constexpr const char* kSofter = "a link softer than the law";
constexpr const char* kStiffer = "a link stiffer than its loop allows";
constexpr const char* kNobody = "nobody answers for a body";
constexpr const char* kTwo = "two say where a body is";
constexpr const char* kCopies = "copies of ";
constexpr const char* kAgree = "peers do not agree who answers for a body";

constexpr std::array<Expected, 34> kExpected{
    {{Fault::kLinkSign, kEnergy},
     {Fault::kEchoOfArrival, kEcho},
     {Fault::kOwnStampForTheirs, kEcho},
     {Fault::kUsersInPlaceOfLinks, kSofter},
     {Fault::kEveryLinkWhole, "a link too stiff for the users", 34},
     {Fault::kHalfTheDelay, kStiffer, 2},
     {Fault::kNoLongestLoop, kStiffer, 29},
     {Fault::kLostGoodbye, kNobody, 2},
     {Fault::kLostLease, kNobody},
     {Fault::kLostReturn, kTwo, 3},
     {Fault::kOneDelayForAll, kStiffer, 2},
     {Fault::kStatesDropped, kSofter},
     {Fault::kLinksDropped, kSofter},
     {Fault::kDueNever, kCopies, 6},
     {Fault::kNotFinite, "not finite on the wire"},
     {Fault::kNegativeStiffness, "a stiffness below zero"},
     {Fault::kStaleState, kCopies},
     {Fault::kMirrorFrozen, kCopies},
     {Fault::kOthersName, "a peer writes as another"},
     {Fault::kClaimsForgotten, kAgree},
     {Fault::kFadeNever, "a hand is pulled though all is quiet"},
     {Fault::kLinkTurn, "a link turns instances apart"},
     {Fault::kGateForgets, kEnergy, 115},
     {Fault::kEchoForAnother, kStiffer, 7},
     {Fault::kStaleClaim, "a claim goes back"},
     {Fault::kGrantKept, kTwo, 3},
     {Fault::kHandsKept, kTwo, 6},
     {Fault::kLostRelease, kAgree, 7},
     {Fault::kAllSucceed, kTwo},
     {Fault::kNoListening, "one who was stopped speaks before it has listened", 5},
     {Fault::kNoGuard, "a hand's force jumps"},
     {Fault::kNoParkedPose, kCopies, 11},
     {Fault::kMirrorNotTurned, kCopies},
     {Fault::kViewerWrites, "a viewer writes"}}};
static_assert(kExpected.size() + 1 == static_cast<std::size_t>(Fault::kCount));

std::uint64_t MostSeeds() {
  const char* const asked = std::getenv("TANDEM_PLANTED_SEEDS");
  return asked != nullptr ? std::strtoull(asked, nullptr, 10) : 200;
}

/// Of "at 3.217 s: a claim goes back: peer 101, left" the middle.
std::string SortOf(const std::string& broken) {
  const std::size_t first = broken.find("s: ") + 3;
  return broken.substr(first, broken.find(": peer", first) - first);
}

const std::shared_ptr<const WorldModel>& Model() {
  static const std::shared_ptr<const WorldModel> model = MakeLightScene();
  return model;
}

/// What a seed breaks without any fault planted.
const std::set<std::string>& BrokenAnyway(std::uint64_t seed) {
  static std::map<std::uint64_t, std::set<std::string>> known;
  const auto [it, added] = known.try_emplace(seed);
  if (!added) return it->second;
  planted_fault = Fault::kNone;
  for (const std::string& broken : SimulateSeed(seed, Model()).broken) {
    it->second.insert(SortOf(broken));
  }
  return it->second;
}

class Planted : public ::testing::TestWithParam<Expected> {
 protected:
  ~Planted() override { planted_fault = Fault::kNone; }
};

// The test of the tests: with the fault in it a session breaks what the fault is about, which the
// same seed does not break without.
TEST_P(Planted, BreaksWhatItIsAbout) {
  const Expected& expected = GetParam();
  std::set<std::string> others;  // that broke as well, or first
  for (std::uint64_t i = 0; i <= MostSeeds(); ++i) {
    const std::uint64_t seed = i == 0 ? expected.seed : i;
    if (i == expected.seed) continue;
    const std::set<std::string>& anyway = BrokenAnyway(seed);
    planted_fault = expected.fault;
    for (const std::string& broken : SimulateSeed(seed, Model()).broken) {
      if (anyway.contains(SortOf(broken))) continue;
      if (SortOf(broken).rfind(expected.sort, 0) == 0) {
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

INSTANTIATE_TEST_SUITE_P(Faults, Planted, ::testing::ValuesIn(kExpected), [](const auto& tested) {
  return "fault_" + std::to_string(static_cast<int>(tested.param.fault));
});

}  // namespace
}  // namespace tandem
