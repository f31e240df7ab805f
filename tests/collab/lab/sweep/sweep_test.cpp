#include <atomic>
#include <set>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "collab/lab/case/case_file.h"
#include "collab/lab/sweep/sweep_run.h"
#include "tests/collab/lab/sweep/fake_cells.h"

namespace tandem {
namespace {

using testing::SmallSweep;

const CaseCheck kAllIsWell = [](const std::string&, const std::string&) {
  return std::nullopt;
};

Result<Sweep> Load(const std::string& content, const CaseCheck& check = kAllIsWell) {
  const ScratchFolder folder;
  return LoadSweep(folder.Write("sweep.json", content), check);
}

std::string WhatIsWrong(const std::string& content, const CaseCheck& check = kAllIsWell) {
  const Result<Sweep> sweep = Load(content, check);
  if (sweep) return "nothing";
  // the message without the scratch folder
  const std::string& what = sweep.error().what;
  return what.substr(what.find("sweep.json"));
}

std::string Case(const SweepCell& cell, const char* key) {
  return nlohmann::json::parse(cell.case_json)[key].dump();
}

TEST(Sweep, IsTheProductOfItsAxesWithTheLastFastest) {
  const ScratchFolder folder;
  const Sweep sweep = SmallSweep(folder);
  ASSERT_EQ(sweep.cells.size(), 12U);
  for (std::size_t i = 0; i < 12; ++i) {
    const SweepCell& cell = sweep.cells[i];
    EXPECT_EQ(cell.number, i);
    EXPECT_EQ(Case(cell, "hands"), i < 6 ? R"(["off"])" : R"(["heavy"])");
    const char* const delays[] = {"0.02", "0.1", "1"};
    EXPECT_EQ(Case(cell, "delay_s"), delays[i / 2 % 3]);
    EXPECT_EQ(Case(cell, "network"), i % 2 == 0 ? R"("clean")" : R"("lossy")");
    EXPECT_EQ(Case(cell, "users"), "2");
    EXPECT_EQ(Case(cell, "name"), "\"small " + std::to_string(i) + "\"");
  }
}

TEST(Sweep, AssignsLawRatioAndStiffness) {
  const Result<Sweep> sweep = Load(
      R"({"name": "s", "blocks": [
          {"law": [{"name": "constant", "gate": false, "limits": {"constant_damping": 10}}],
           "stiffness_N_m": [40, 200.0]},
          {"ratio": 0.5}, {"law": "linear", "boundary_ratio": 2}]})");
  ASSERT_TRUE(sweep) << sweep.error().what;
  ASSERT_EQ(sweep->cells.size(), 4U);
  const auto law = [&](std::size_t i) {
    return nlohmann::json::parse(sweep->cells[i].case_json)["law"];
  };
  EXPECT_EQ(law(1)["name"], "constant");
  EXPECT_EQ(law(1)["gate"], false);
  EXPECT_EQ(law(1)["limits"]["constant_damping"], 10);
  EXPECT_EQ(law(1)["limits"]["constant_stiffness"], 200);
  EXPECT_EQ(law(2)["name"], DefaultLaw()->name());
  EXPECT_EQ(law(2)["ratio"], 0.5);
  EXPECT_EQ(law(3)["name"], "linear");
  EXPECT_EQ(law(3)["boundary_ratio"], 2);
}

TEST(Sweep, OmitsDuplicateCells) {
  const Result<Sweep> sweep = Load(
      R"({"name": "s", "blocks": [{"delay_s": [0.1, 1], "expect": "stable"},
                                  {"delay_s": [1.0, 0.3, 0.3], "users": 2}]})");
  ASSERT_TRUE(sweep) << sweep.error().what;
  ASSERT_EQ(sweep->cells.size(), 3U);
  EXPECT_EQ(Case(sweep->cells[1], "delay_s"), "1");
  EXPECT_EQ(sweep->cells[1].expect, Expectation::kStable);
  EXPECT_EQ(Case(sweep->cells[2], "delay_s"), "0.3");
  EXPECT_EQ(sweep->cells[2].expect, Expectation::kNothing);
}

TEST(Sweep, CellSeedDependsOnItsContentOnly) {
  const Result<Sweep> alone = Load(R"({"name": "s", "blocks": [{"delay_s": 0.3}]})");
  const Result<Sweep> among =
      Load(R"({"name": "t", "blocks": [{"delay_s": [0.1, 0.2]}, {"users": 3}, {"delay_s": 0.3}]})");
  const Result<Sweep> other = Load(R"({"name": "s", "seed": 2, "blocks": [{"delay_s": 0.3}]})");
  ASSERT_TRUE(alone && among && other);
  EXPECT_EQ(alone->cells[0].key, among->cells[3].key);
  EXPECT_EQ(Case(alone->cells[0], "seed"), Case(among->cells[3], "seed"));
  EXPECT_EQ(alone->cells[0].key, other->cells[0].key);
  EXPECT_NE(Case(alone->cells[0], "seed"), Case(other->cells[0], "seed"));
  std::set<std::string> hashes{alone->hash, among->hash, other->hash};
  EXPECT_EQ(hashes.size(), 3U);
  std::set<std::string> seeds;
  for (const SweepCell& cell : among->cells) seeds.insert(Case(cell, "seed"));
  EXPECT_EQ(seeds.size(), 4U);
}

// A cell with a seed of its own is another cell; without the axis keys are what they were.
TEST(Sweep, HasAnAxisOfSeeds) {
  const Result<Sweep> sweep =
      Load(R"({"name": "s", "blocks": [{"network": "lossy", "delay_s": [0.1, 0.3],
                                        "seed": [1, 2, 7]}, {"delay_s": 0.3}]})");
  const Result<Sweep> alone = Load(R"({"name": "s", "blocks": [{"delay_s": 0.3}]})");
  ASSERT_TRUE(sweep) << sweep.error().what;
  ASSERT_EQ(sweep->cells.size(), 7U);
  std::set<std::string> keys;
  for (std::size_t i = 0; i < 6; ++i) {
    const char* const seeds[] = {"1", "2", "7"};
    EXPECT_EQ(Case(sweep->cells[i], "seed"), seeds[i % 3]);
    keys.insert(sweep->cells[i].key);
  }
  EXPECT_EQ(keys.size(), 6U);
  EXPECT_EQ(sweep->cells[6].key, alone->cells[0].key);
  EXPECT_EQ(Case(sweep->cells[6], "seed"), Case(alone->cells[0], "seed"));
}

// The reader of cases refuses a limit that a law does not use: an axis of laws is tried with each
// law's own name.
TEST(Sweep, UsesEachLawsOwnLimits) {
  const CaseCheck check = [](const std::string& text, const std::string& name) {
    const Result<LabCase> test = ParseCase(text, name);
    return test ? std::nullopt : std::optional<Error>(test.error());
  };
  EXPECT_EQ(WhatIsWrong(R"({"name": "s", "blocks": [{"law": [{"limits": {"damping_budget": 6}},
              {"name": "constant", "limits": {"constant_damping": 6}}]}]})",
                        check),
            "nothing");
  EXPECT_EQ(WhatIsWrong(R"({"name": "s", "blocks": [{"law": [{"name": "p+d"},
              {"name": "linear", "limits": {"constant_damping": 6}}]}]})",
                        check),
            "sweep.json: blocks[0].law[1]: law.limits.constant_damping: the law 'linear' does not "
            "use it: it uses linear_stiffness, damping_budget and ratio");
}

TEST(Sweep, ReportsErrorsInOneLineWithTheirPosition) {
  EXPECT_EQ(WhatIsWrong("{\"name\": 3,}"),
            "sweep.json: line 1, column 12: syntax error while parsing object key - unexpected "
            "'}'; expected string literal");
  EXPECT_EQ(WhatIsWrong(R"({"blocks": []})"), "sweep.json: name: expected a name, got nothing");
  EXPECT_EQ(WhatIsWrong(R"({"name": "s"})"),
            "sweep.json: there are no blocks: a single case is run by 'tandem stability run'");
  EXPECT_EQ(WhatIsWrong(R"({"name": "s", "blocks": []})"), "sweep.json: blocks: there is no cell");
  EXPECT_EQ(WhatIsWrong(R"({"name": "s", "blocks": [{"hand": ["off"]}]})"),
            "sweep.json: blocks[0].hand: unknown key; did you mean hands?");
  EXPECT_EQ(WhatIsWrong(R"({"name": "s", "blocks": [{}, {"delay_s": []}]})"),
            "sweep.json: blocks[1].delay_s: an empty array leaves no cell");
  EXPECT_EQ(WhatIsWrong(R"({"name": "s", "blocks": [{"expect": "calm"}]})"),
            "sweep.json: blocks[0].expect: expected \"stable\" or \"unstable\", got \"calm\"");
  EXPECT_EQ(WhatIsWrong(R"({"name": "s", "blocks": [{"stiffness_N_m": 40}]})"),
            "sweep.json: blocks[0].stiffness_N_m: only the law \"constant\" has a stiffness of "
            "its own");
  EXPECT_EQ(
      WhatIsWrong(R"({"name": "s", "seed": -1, "blocks": [{}]})").rfind("sweep.json: seed: ", 0),
      0U);
}

TEST(Sweep, ValidatesEachValueAndCellAsACase) {
  const CaseCheck check = [](const std::string& test, const std::string& name) {
    const auto json = nlohmann::json::parse(test);
    std::optional<Error> wrong;
    if (json["hands"][0] == "hevy") wrong = Error{name + ": no such hand"};
    if (json["users"] == 3 && json["scene"] == "ball") wrong = Error{name + ": no room"};
    return wrong;
  };
  EXPECT_EQ(WhatIsWrong(R"({"name": "s", "blocks": [{}, {"hands": ["off", "hevy"]}]})", check),
            "sweep.json: blocks[1].hands[1]: no such hand");
  EXPECT_EQ(
      WhatIsWrong(R"({"name": "s", "blocks": [{"scene": ["free", "ball"], "users": [2, 3]}]})",
                  check),
      "sweep.json: blocks[0], cell 3: no room");
}

TEST(Sweep, ShardsPartitionTheCells) {
  const ScratchFolder folder;
  const Sweep sweep = SmallSweep(folder);
  for (const SweepCell& cell : sweep.cells) {
    int times = 0;
    for (std::size_t i = 1; i <= 5; ++i) times += Shard{i, 5}.Has(cell) ? 1 : 0;
    EXPECT_EQ(times, 1);
  }
  // the four of 40 s, the eight of 12 s: two and four in each half
  for (std::size_t i = 1; i <= 2; ++i) {
    double cost = 0;
    for (const SweepCell& cell : sweep.cells) cost += Shard{i, 2}.Has(cell) ? cell.cost : 0;
    EXPECT_DOUBLE_EQ(cost, 2 * (2 * 40 + 4 * 12));
  }
  EXPECT_EQ(ParseShard("3/20")->Name(), "3/20");
  for (const char* const wrong : {"", "3", "0/3", "4/3", "1/0", "a/3", "1/3x", "1/", "-1/3"}) {
    EXPECT_FALSE(ParseShard(wrong)) << wrong;
  }
}

TEST(RunCells, RunsEachOnceTheCostlyOnesFirst) {
  const ScratchFolder folder;
  const Sweep sweep = SmallSweep(folder);
  std::vector<std::size_t> order;
  RunCells(sweep.cells, 1, testing::FakeOutcome, [&](const SweepCell& cell, const CellOutcome&) {
    order.push_back(cell.number);
  });
  // 40 s at a delay of 1 s, 12 s at the others
  EXPECT_EQ(order, (std::vector<std::size_t>{4, 5, 10, 11, 0, 1, 2, 3, 6, 7, 8, 9}));
  for (const unsigned jobs : {0U, 3U, 40U}) {
    std::set<std::size_t> done;
    RunCells(sweep.cells, jobs, testing::FakeOutcome,
             [&](const SweepCell& cell, const CellOutcome&) {
               EXPECT_TRUE(done.insert(cell.number).second);
             });
    EXPECT_EQ(done.size(), 12U);
  }
}

// 900 x 900 x 900 values would fill all memory.
TEST(Sweep, GridSizeIsBounded) {
  std::string axis = "0.001";
  for (int i = 2; i <= 900; ++i) axis += "," + std::to_string(0.001 * i);
  std::string seeds = "1";
  for (int i = 2; i <= 900; ++i) seeds += "," + std::to_string(i);
  const Result<Sweep> sweep = Load(R"({"name": "s", "blocks": [{"delay_s": [)" + axis +
                                   R"(], "ratio": [)" + axis + R"(], "seed": [)" + seeds + "]}]}");
  ASSERT_FALSE(sweep);
  EXPECT_THAT(sweep.error().what,
              ::testing::HasSubstr("more than 250000 cells in all: divide the sweep"));
}

TEST(Sweep, UnterminatedBracketsAreRefused) {
  const Result<Sweep> sweep =
      Load(R"({"name": "s", "blocks": [{"network": )" + std::string(150'000, '['));
  ASSERT_FALSE(sweep);
  EXPECT_THAT(sweep.error().what, ::testing::HasSubstr("more than 64 brackets in one another"));
}

}  // namespace
}  // namespace tandem
