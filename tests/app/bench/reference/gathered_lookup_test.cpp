#include "app/bench/reference/gathered_lookup.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "tests/engine/contact/schedule/random_map.h"
#include "tests/support/shapes.h"

namespace tandem {
namespace {

using testing::RandomMap;
using testing::Uniform;

using GatheredLookup = testing::EveryTarget;

TEST_F(GatheredLookup, ScatteredLookupsMatchTheMapOnEveryInstructionSet) {
  std::mt19937_64 random(12);
  for (const int bits : {2, 4, 8}) {
    const Voxmap voxmap = RandomMap(bits, bits == 2 ? 1 : 8, random());
    // a count that is no whole number of groups; inside, across the border and far off
    std::array<std::vector<float>, 3> places;
    for (int i = 0; i < 5003; ++i) {
      for (std::vector<float>& axis : places) {
        const double far = i % 50 == 0 ? 1e9 : 1.0;
        axis.push_back(static_cast<float>(far * Uniform(random, -40, 360)));
      }
    }
    for (const Field field : kAllFields) {
      ForEachTarget([&] {
        std::vector<std::uint8_t> marks(places[0].size());
        TestScattered({places[0], places[1], places[2]}, voxmap, field, marks.data());
        std::size_t wrong = 0;
        for (std::size_t i = 0; i < marks.size(); ++i) {
          const std::array<float, 3> p{places[0][i], places[1][i], places[2][i]};
          const bool far = std::abs(p[0]) > 1e6F || std::abs(p[1]) > 1e6F || std::abs(p[2]) > 1e6F;
          wrong += marks[i] != (far ? voxmap.beyond() : voxmap.Value(field, VoxelAt(p)));
        }
        EXPECT_EQ(wrong, 0U) << "bits " << bits;
      });
    }
  }
}

}  // namespace
}  // namespace tandem
