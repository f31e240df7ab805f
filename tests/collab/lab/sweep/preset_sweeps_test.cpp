#include <map>
#include <set>
#include <string>
#include <tuple>

#include <gtest/gtest.h>

#include "collab/coupling/coupling_law.h"
#include "collab/lab/case/case_file.h"
#include "collab/lab/sweep/sweep_file.h"

namespace tandem {
namespace {

Sweep Preset(const std::string& name) {
  Result<Sweep> sweep = LoadSweep(std::string(TANDEM_PRESETS "/") + name,
                                  [](const std::string& text, const std::string& file) {
                                    const Result<LabCase> test = ParseCase(text, file);
                                    return test ? std::nullopt : std::optional<Error>(test.error());
                                  });
  EXPECT_TRUE(sweep) << sweep.error().what;
  return sweep ? *std::move(sweep) : Sweep{};
}

LabCase CaseOf(const SweepCell& cell) {
  return *ParseCase(cell.case_json, "cell");
}

TEST(AcceptanceSweep, HasTheCellsThatTheTableAsksFor) {
  const Sweep sweep = Preset("acceptance.json");
  EXPECT_GE(sweep.cells.size(), 500U);
  std::map<std::string, int> of_scene;
  std::set<double> delays;
  std::set<std::size_t> users;
  std::set<double> rates;
  std::set<std::tuple<std::string, std::string, std::string, double>> default_law;
  int controls = 0;
  for (const SweepCell& cell : sweep.cells) {
    const LabCase test = CaseOf(cell);
    ++of_scene[test.scene];
    delays.insert(test.delay_s);
    users.insert(test.users);
    rates.insert(test.publish_hz);
    controls += cell.expect == Expectation::kUnstable ? 1 : 0;
    EXPECT_TRUE(test.seconds == 0 || test.seconds >= test.DefaultDuration()) << cell.case_json;
    if (test.law.name == DefaultLaw()->name() && test.law.ratio == 1 && test.users == 2) {
      default_law.emplace(test.scene, test.hands[0].name, test.network.name, test.delay_s);
    }
  }
  EXPECT_EQ(delays, (std::set<double>{0.02, 0.1, 0.3, 1}));
  EXPECT_EQ(users, (std::set<std::size_t>{2, 3, 4, 8}));
  EXPECT_EQ(rates, (std::set<double>{100, 250, 1000}));
  EXPECT_EQ(controls, 4);
  for (const char* const scene : {"free", "wall", "slot", "ball", "off_centre"}) {
    EXPECT_GE(of_scene[scene], 60) << scene;
    for (const char* const hand : {"off", "relaxed", "heavy", "firm"}) {
      for (const char* const network : {"clean", "lossy", "asymmetric"}) {
        for (const double delay_s : delays) {
          EXPECT_TRUE(default_law.contains({scene, hand, network, delay_s}))
              << scene << " " << hand << " " << network << " " << delay_s;
        }
      }
    }
  }
}

// The sweep has the default law alone, with every hand from 20 ms to 1 s on a good and on a bad
// line.
TEST(DefaultSweep, ContainsOnlyTheDefaultLaw) {
  const Sweep sweep = Preset("default.json");
  std::set<std::tuple<std::string, std::string, double>> seen;
  for (const SweepCell& cell : sweep.cells) {
    const LabCase test = CaseOf(cell);
    EXPECT_EQ(test.law.name, DefaultLaw()->name());
    EXPECT_EQ(test.law.ratio, 1);
    EXPECT_EQ(cell.expect, Expectation::kStable);
    seen.emplace(test.hands[0].name, test.network.name, test.delay_s);
  }
  EXPECT_EQ(sweep.cells.size(), 80U);
  EXPECT_EQ(seen.size(), 4U * 2U * 8U);
}

TEST(Presets, SingleCasesAreRead) {
  for (const char* name : {"knock.json", "live.json", "adversarial.json"}) {
    const Result<LabCase> test = LoadCase(std::string(TANDEM_PRESETS "/") + name);
    EXPECT_TRUE(test) << test.error().what;
  }
}

TEST(Presets, CaseGivenAsASweepIsReported) {
  const std::string file = TANDEM_PRESETS "/knock.json";
  const Result<Sweep> sweep = LoadSweep(file, [](const std::string&, const std::string&) {
    return std::nullopt;
  });
  ASSERT_FALSE(sweep);
  EXPECT_EQ(sweep.error().what,
            file + ": there are no blocks: a single case is run by 'tandem stability run'");
}

TEST(MapSweep, IsADelayStiffnessGridOnTwoNetworks) {
  const Sweep sweep = Preset("map.json");
  std::map<std::string, std::set<std::pair<double, double>>> points;
  for (const SweepCell& cell : sweep.cells) {
    const LabCase test = CaseOf(cell);
    EXPECT_EQ(test.law.name, "constant");
    EXPECT_FALSE(test.law.gate);
    points[test.network.name].emplace(test.delay_s, test.law.limits.constant_stiffness);
  }
  EXPECT_EQ(points["clean"].size(), 15U * 18U);
  EXPECT_EQ(points["clean"], points["lossy"]);
}

}  // namespace
}  // namespace tandem
