#include <cstdlib>

#include <gtest/gtest.h>

#include "collab/planted_faults.h"
#include "collab/simulated/light_scene.h"
#include "collab/simulated/simulator.h"

namespace tandem {
namespace {

std::uint64_t MostSeeds() {
  const char* const asked = std::getenv("TANDEM_PLANTED_SEEDS");
  return asked != nullptr ? std::strtoull(asked, nullptr, 10) : 40;
}

class Planted : public ::testing::TestWithParam<int> {
 protected:
  ~Planted() override { planted_fault = Fault::kNone; }
};

// The test of the tests: a session with the fault in it breaks an invariant that none breaks
// without. TANDEM_PLANTED_SEEDS=1000 looks further.
TEST_P(Planted, IsFound) {
  const auto model = MakeLightScene();
  for (std::uint64_t seed = 1; seed <= MostSeeds(); ++seed) {
    planted_fault = Fault::kNone;
    const std::size_t before = SimulateSeed(seed, model).broken.size();
    planted_fault = static_cast<Fault>(GetParam());
    const SeedResult result = SimulateSeed(seed, model);
    if (result.broken.size() <= before) continue;
    std::printf("fault %d is found by seed %d: %s\n", GetParam(), static_cast<int>(seed),
                result.broken.front().c_str());
    return;
  }
  ADD_FAILURE() << "fault " << GetParam() << " is not found within " << MostSeeds() << " seeds";
}

INSTANTIATE_TEST_SUITE_P(Faults, Planted, ::testing::Range(1, static_cast<int>(Fault::kCount)));

}  // namespace
}  // namespace tandem
