#include "collab/simulated/simulator.h"

#include <cstdlib>

#include <gtest/gtest.h>

#include "collab/simulated/light_scene.h"

namespace tandem {
namespace {

TEST(Simulator, ASeedGivesTheSameBitsEveryTime) {
  const auto model = MakeLightScene();
  for (const std::uint64_t seed : {3U, 4U}) {
    const SeedResult first = SimulateSeed(seed, model);
    EXPECT_EQ(SimulateSeed(seed, model).digest, first.digest);
    EXPECT_NE(SimulateSeed(seed + 100, model).digest, first.digest);
    EXPECT_GT(first.peer_seconds, 10.0);
  }
}

// TANDEM_SIMULATOR_SEEDS=1000 for the long run; `tandem simulate` does it on all processors.
TEST(Simulator, NoSeedBreaksAnInvariant) {
  const auto model = MakeLightScene();
  const char* const asked = std::getenv("TANDEM_SIMULATOR_SEEDS");
  const std::uint64_t seeds = asked != nullptr ? std::strtoull(asked, nullptr, 10) : 12;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    const SeedResult result = SimulateSeed(seed, model);
    for (const std::string& what : result.broken) ADD_FAILURE() << "seed " << seed << " " << what;
  }
}

}  // namespace
}  // namespace tandem
