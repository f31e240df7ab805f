#include "collab/lab/sweep/random_cells.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <string_view>

#include <nlohmann/json.hpp>

#include "engine/base/hash.h"
#include "engine/base/text/hex.h"

namespace tandem {

namespace {

using Json = nlohmann::ordered_json;

constexpr std::array<std::string_view, 5> kScenes{"free", "off_centre", "wall", "slot", "ball"};
constexpr std::array<std::string_view, 7> kDrawnMotions{"still", "kick",  "move",    "hold",
                                                        "swing", "press", "pull_off"};
constexpr std::array<int, 10> kUserCounts{2, 2, 2, 2, 3, 3, 4, 5, 6, 8};
constexpr double kMostOffset = 0.1;         // m
constexpr double kLongestDrawnDelay = 1.2;  // s, one way
constexpr double kMostLost = 0.5;           // share of all samples, lost in bursts
constexpr double kMostJitter_ms = 60;
constexpr double kMostLoss = 0.2;  // share, lost outside bursts

/// Draws from the generator's bits alone, because distributions differ between standard libraries.
class Draw {
 public:
  explicit Draw(std::uint64_t seed) : random_(seed) {}

  double Share() { return static_cast<double>(random_() >> 11U) * 0x1p-53; }
  bool Chance(double share) { return Share() < share; }
  double Even(double least, double most) { return least + (most - least) * Share(); }
  /// Draws evenly by the logarithm.
  double Scale(double least, double most) { return least * std::pow(most / least, Share()); }
  template <class Array>
  auto OneOf(const Array& values) {
    return values[static_cast<std::size_t>(Share() * static_cast<double>(values.size()))];
  }

 private:
  std::mt19937_64 random_;
};

/// Rounds to four figures, so that people can read a case.
double Rounded(double value) {
  if (value == 0) return 0;
  const double unit = std::pow(10.0, std::floor(std::log10(std::abs(value))) - 3.0);
  return unit < 1 ? std::round(value / unit) / std::round(1.0 / unit)
                  : std::round(value / unit) * unit;
}

Json Hand(Draw& draw, bool beside) {
  Json hand{{"mass_kg", Rounded(draw.Scale(0.1, 5))},
            {"damping_Ns_m", Rounded(draw.Scale(0.3, 20))},
            {"stiffness_N_m", draw.Chance(0.5) ? 0.0 : Rounded(draw.Scale(10, 3000))}};
  if (beside) {
    const double length = draw.Even(0, kMostOffset);
    const double height = draw.Even(-1, 1);
    const double turn = draw.Even(0, 2.0 * M_PI);
    const double flat = std::sqrt(1.0 - height * height);
    hand["grasp_m"] = {Rounded(length * flat * std::cos(turn)),
                       Rounded(length * flat * std::sin(turn)), Rounded(length * height)};
  }
  return hand;
}

Json Network(Draw& draw) {
  Json network{{"name", "drawn"}};
  if (draw.Chance(0.6)) network["jitter_ms"] = Rounded(draw.Even(0, kMostJitter_ms));
  if (draw.Chance(0.3)) network["loss"] = Rounded(draw.Even(0, kMostLoss));
  if (draw.Chance(0.6)) {
    const double lost = draw.Even(0.02, kMostLost);  // share of all samples
    const double loss = draw.Even(std::max(0.6, lost), 1);
    const double within = lost / loss;  // share of all samples that are in a burst
    const double leave = 1.0 / draw.Scale(2, 40);
    network["burst_enter"] = Rounded(std::min(1.0, leave * within / std::max(1e-9, 1.0 - within)));
    network["burst_leave"] = Rounded(leave);
    network["burst_loss"] = Rounded(loss);
  }
  if (draw.Chance(0.2)) network["skew"] = Rounded(draw.Even(0, 0.9));
  return network;
}

}  // namespace

std::string RandomCase(std::uint64_t seed) {
  Draw draw(seed);
  const int users = draw.OneOf(kUserCounts);
  const bool alike = draw.Chance(0.5);
  const bool beside = draw.Chance(0.5);
  Json hands = Json::array();
  for (int user = 0; user < (alike ? 1 : users); ++user) hands.push_back(Hand(draw, beside));
  Json test{{"name", "random " + std::to_string(seed)},
            {"scene", draw.OneOf(kScenes)},
            {"users", users},
            {"hands", std::move(hands)},
            {"motion", draw.OneOf(kDrawnMotions)},
            {"delay_s", Rounded(draw.Chance(0.5) ? draw.Even(0, kLongestDrawnDelay)
                                                 : draw.Scale(1e-3, kLongestDrawnDelay))},
            {"publish_hz", Rounded(draw.Scale(10, 1000))}};
  test["network"] = draw.Chance(0.15) ? Json("clean") : Network(draw);
  test["seed"] = seed % 1'000'000'000;
  return test.dump();
}

std::vector<SweepCell> RandomCells(std::uint64_t first, std::size_t count) {
  std::vector<SweepCell> cells(count);
  for (std::size_t i = 0; i < count; ++i) {
    SweepCell& cell = cells[i];
    cell.number = i;
    cell.case_json = RandomCase(first + i);
    Hash64 hash;
    for (const char c : cell.case_json)
      hash.Add(static_cast<std::uint64_t>(static_cast<unsigned char>(c)));
    cell.key = Hex(hash.value());
    cell.expect = Expectation::kStable;
    const Json test = Json::parse(cell.case_json);
    const auto users = test["users"].get<double>();
    cell.cost = users * users * (12.0 + 40.0 * test["delay_s"].get<double>());
  }
  return cells;
}

}  // namespace tandem
