#include "app/bench/measure/test_prices.h"

#include <algorithm>
#include <numeric>
#include <vector>

#include "app/bench/measure/bench_scene.h"
#include "engine/contact/schedule/block_drift.h"

namespace tandem {

namespace {

constexpr int kPasses = 31;

template <class Work>
double MedianNs(const Work& work) {
  std::vector<double> times;
  for (int pass = 0; pass < kPasses; ++pass) times.push_back(CpuNs(work));
  return Median(times);
}

}  // namespace

TestPrices MeasureTestPrices(const ContactPair& pair) {
  constexpr std::uint32_t kAhead = 12;  // blocks, as in the schedule
  const PointBlocks& blocks = pair.blocks();
  const Schedule& schedule = pair.schedule();
  const auto count = static_cast<std::uint32_t>(blocks.size());
  std::vector<std::uint32_t> all(blocks.size());
  std::iota(all.begin(), all.end(), 0U);
  std::vector<BlockReading> readings(blocks.size());
  const auto points = static_cast<double>(
      std::accumulate(blocks.counts(), blocks.counts() + blocks.size(), std::size_t{0}));
  TestPrices prices;
  prices.looked_up_ns = MedianNs([&] {
                          TestBlocks(blocks, schedule.transform(), pair.voxmap(),
                                     2 + schedule.force_layer(), all, readings.data());
                        }) /
                        points;
  BlockDrift drift(blocks);
  drift.Begin(schedule.transform());
  for (const std::uint32_t b : all) drift.LookedUp(b, readings[b].nearest);
  float farthest = 0;
  prices.drifted_ns = MedianNs([&] {
                        drift.Begin(schedule.transform());
                        for (const std::uint32_t b : all) {
                          if (b + kAhead < count) drift.Fetch(b + kAhead);
                          farthest = std::max(farthest, drift.DriftSinceLookup(b));
                        }
                      }) /
                      points;
  volatile float kept = farthest;  // keeps the compiler from leaving the loop out
  static_cast<void>(kept);
  return prices;
}

}  // namespace tandem
