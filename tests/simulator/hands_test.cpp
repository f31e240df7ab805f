#include <cmath>
#include <cstdlib>

#include <gtest/gtest.h>

#include "collab/simulated/hands/hands_simulator.h"
#include "collab/simulated/network/light_scene.h"

namespace tandem {
namespace {

TEST(HandsSimulator, IsDeterministicPerSeedOnAnyNumberOfThreads) {
  const auto model = MakeLightScene();
  const auto one = SimulateHandSeeds(20, 2, 1, 10, model);
  const auto two = SimulateHandSeeds(20, 2, 2, 10, model);
  for (std::size_t i = 0; i < one.size(); ++i) {
    EXPECT_EQ(one[i].digest, two[i].digest);
    EXPECT_EQ(one[i].tally, two[i].tally);
  }
  EXPECT_NE(one[0].digest, one[1].digest);
}

// 60 s of virtual time; TANDEM_HANDS_SECONDS=3600 for the long run, which `tandem simulate --hands`
// does too.
TEST(HandsSimulator, NoSeedBreaksAnInvariant) {
  constexpr double kSession = 30;       // s; longest session
  constexpr double kLeastSession = 24;  // s; shortest session: it ends when all have come to rest
  const char* const requested = std::getenv("TANDEM_HANDS_SECONDS");
  const double seconds = requested != nullptr ? std::strtod(requested, nullptr) : 60;
  const auto count = static_cast<std::uint64_t>(std::ceil(seconds / kLeastSession));
  Tally tally;
  double simulated = 0;
  for (const SeedResult& result : SimulateHandSeeds(1, count, 2, kSession, MakeLightScene())) {
    simulated += result.seconds;
    for (const auto& [what, times] : result.tally) tally[what] += times;
    for (const std::string& what : result.broken) {
      ADD_FAILURE() << "seed " << result.seed << " " << what;
    }
  }
  EXPECT_GE(simulated, seconds);
  for (const char* const what : {"grabs", "drags", "ways back", "requests done", "requests refused",
                                 "host pauses", "controller pauses"}) {
    EXPECT_GE(tally[what], 3U) << what;
  }
}

}  // namespace
}  // namespace tandem
