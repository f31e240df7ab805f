#include "app/stability/report/maps.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <string>

#include <gtest/gtest.h>

#include "app/stability/report/cell_facts.h"
#include "collab/lab/theory/exact_boundary.h"
#include "tests/app/stability/report/made_results.h"

namespace tandem {
namespace {

using testing::MadeCell;
using testing::ReplaceInCase;
using testing::TwentyCells;

const Inertia kCube{0.3, 8e-5 * Mat3::Identity()};

std::optional<Inertia> Cube(const LabCase&) {
  return kCube;
}

const MapLine& LineOf(const StabilityMap& map, MapLineKind kind) {
  for (const MapLine& line : map.lines) {
    if (line.kind == kind) return line;
  }
  static const MapLine none;
  ADD_FAILURE() << "no such line";
  return none;
}

TEST(Maps, GroupCellsByAllButDelayAndStiffness) {
  Results results = TwentyCells();
  for (std::size_t i = 0; i < 8; ++i) {
    CellRecord record = MadeCell(20 + i, i < 4 ? 0.1 : 0.3, 20.0 + static_cast<double>(i), 60);
    ReplaceInCase(record, "heavy", "off");
    results.records.emplace(20 + i, record);
  }
  const std::vector<StabilityMap> maps = MapsOf(results, Cube);
  ASSERT_EQ(maps.size(), 2U);
  EXPECT_EQ(maps[0].cells.size(), 20U);
  EXPECT_EQ(maps[1].cells.size(), 8U);
  EXPECT_NE(maps[0].title.find("heavy"), std::string::npos);
  EXPECT_NE(maps[1].title.find("off"), std::string::npos);
  EXPECT_NE(maps[0].name, maps[1].name);
}

// Maps that differ only in their note would otherwise have one title.
TEST(Maps, HaveDistinctTitles) {
  Results results;
  std::size_t number = 0;
  const auto add = [&](const char* what, const std::string& with) {
    for (const double delay_s : {0.1, 0.3}) {
      for (const double stiffness : {20.0, 30.0, 40.0}) {
        CellRecord record = MadeCell(number, delay_s, stiffness, 60);
        ReplaceInCase(record, what, with);
        results.records.emplace(number++, record);
      }
    }
  };
  add("\"gate\":false", "\"gate\":false");
  add("\"gate\":false", "\"gate\":true");
  add("\"publish_hz\":1000", "\"publish_hz\":100");
  add("\"constant_damping\":10", "\"constant_damping\":5");
  add("\"clean\"", R"({"name":"mine","jitter_ms":5})");
  add("\"clean\"", R"({"name":"mine","jitter_ms":50})");
  std::set<std::string> titles;
  for (const StabilityMap& map : MapsOf(results, Cube)) {
    titles.insert(map.title);
    EXPECT_EQ(map.title.find(", map "), std::string::npos) << map.title;
  }
  EXPECT_EQ(titles.size(), 6U);
}

// The paper's law does not know of the grasp.
TEST(Maps, GroupCellsByAllButGraspAndStiffness) {
  Results results;
  std::size_t number = 0;
  for (const char* grasp : {"0", "0.05", "0.1"}) {
    for (const double stiffness : {20.0, 80.0, 320.0}) {
      CellRecord record = MadeCell(number, 0.1, stiffness, 60);
      ReplaceInCase(
          record, "\"heavy\"",
          std::string(R"({"mass_kg":3,"damping_Ns_m":0.7,"grasp_m":[0,)") + grasp + ",0]}");
      results.records.emplace(number++, record);
    }
  }
  const std::vector<StabilityMap> maps = MapsOf(results, Cube);
  ASSERT_EQ(maps.size(), 1U);
  const StabilityMap& map = maps[0];
  EXPECT_EQ(map.axis, MapAxis::kGrasp);
  EXPECT_EQ(map.cells.size(), 9U);
  EXPECT_NE(map.title.find("100 ms"), std::string::npos) << map.title;
  EXPECT_EQ(map.cells.back().x, 0.1);
  const MapLine& paper = LineOf(map, MapLineKind::kLinearFirm);
  EXPECT_EQ(paper.points.front().y, paper.points.back().y);
  const MapLine& exact = LineOf(map, MapLineKind::kBoundary);
  EXPECT_EQ(exact.points.front().x, 0);
  // held at the centre it is the boundary of one axis
  LumpedCoupling lumped;
  lumped.mass = kCube.mass + 3;
  lumped.damping = 0.7 + 10;
  lumped.delay_s = 0.1 + 0.0005 + 0.0005;
  EXPECT_NEAR(exact.points.front().y / CriticalStiffness(lumped), 1, 0.02);
  for (const PicturePoint& point : exact.points) EXPECT_GT(point.y, 0);
}

TEST(Maps, DescribeCustomNetworks) {
  CellRecord record = MadeCell(0, 0.1, 20, 60);
  ReplaceInCase(record, "\"clean\"", R"({"model":"leo","stretch":1.5,"mix":true})");
  EXPECT_EQ(FactsOf(record).network, "mix true, model leo, stretch 1.5");
}

TEST(Maps, NeedSeveralStiffnessValuesPerDelay) {
  Results results = TwentyCells();
  std::erase_if(results.records, [](const auto& record) {
    return record.first % 5 != 0;
  });
  EXPECT_TRUE(MapsOf(results, Cube).empty());
}

// heavy: 1 kg and 2 N s/m, beside the device's 0.2 kg and 0.3 N s/m, the body's 0.3 kg and the
// law's 10 N s/m. The applied sample is half a sample and half a frame old beside its delay
TEST(Maps, DrawTheClosedFormBoundaries) {
  const StabilityMap map = MapsOf(TwentyCells(), Cube).at(0);
  constexpr double kMass = 1.5;
  constexpr double kDamping = 12.3;
  for (const PicturePoint& point : LineOf(map, MapLineKind::kBoundary).points) {
    if (point.x < 0.08) continue;  // nothing is too stiff for long at the left end
    EXPECT_NEAR(point.y, CriticalStiffness(point.x + 1e-3, kDamping, kMass), 0.01 * point.y)
        << point.x;
  }
  for (const PicturePoint& point : LineOf(map, MapLineKind::kPassive).points) {
    EXPECT_NEAR(point.y, kDamping / (point.x + 1e-3), 0.01 * point.y) << point.x;
  }
  for (const PicturePoint& point : LineOf(map, MapLineKind::kAnyDelay).points) {
    EXPECT_NEAR(point.y, kDamping * kDamping / (2 * kMass), 1e-6) << point.x;
  }
  // k0 (1 - delay), at least 2 %
  for (const PicturePoint& point : LineOf(map, MapLineKind::kLinearFirm).points) {
    if (point.x > 0.9) continue;
    EXPECT_NEAR(point.y, 200 * (1 - point.x), 4) << point.x;
  }
}

TEST(Maps, ShowNoExactBoundaryInContact) {
  Results results = TwentyCells();
  for (auto& record : results.records) ReplaceInCase(record.second, "free", "wall");
  const std::vector<StabilityMap> maps = MapsOf(results, Cube);
  ASSERT_EQ(maps.size(), 1U);
  for (const MapLine& line : maps[0].lines) {
    EXPECT_NE(line.kind, MapLineKind::kBoundary);
    EXPECT_NE(line.kind, MapLineKind::kAnyDelay);
  }
  EXPECT_EQ(maps[0].lines.size(), 4U);
}

TEST(Maps, HaveNoLinesWithoutTheScene) {
  const std::vector<StabilityMap> maps = MapsOf(TwentyCells(), [](const LabCase&) {
    return std::nullopt;
  });
  ASSERT_EQ(maps.size(), 1U);
  EXPECT_EQ(maps[0].cells.size(), 20U);
  EXPECT_TRUE(maps[0].lines.empty());
}

TEST(Maps, ShowExplosionsAsTheFastestGrowth) {
  const StabilityMap map = MapsOf(TwentyCells(), Cube).at(0);
  std::size_t blown = 0;
  for (const MapCell& cell : map.cells) blown += std::isinf(cell.growth) ? 1 : 0;
  // 810 N/m above three times 150, 70 and 42; 270 above three times 70 and 42
  EXPECT_EQ(blown, 5U);
}

// The slope of a course that ended long ago means nothing: forces saturate, or all is at rest.
TEST(Maps, ShowOutOfBoundsAsGrowthAndRestAsDecay) {
  Results results = TwentyCells();
  Metrics& wild = results.records.at(9).outcome.result.metrics;  // 810 N/m at 100 ms
  wild.diverged = false;
  wild.growth = -0.01;
  wild.tail_rms = 1.5;
  Metrics& still = results.records.at(0).outcome.result.metrics;  // 10 N/m at 20 ms
  still.growth = 0;
  still.tail_rms = 1e-12;
  const StabilityMap map = MapsOf(results, Cube).at(0);
  const auto growth_at = [&](double delay_s, double stiffness) {
    return std::ranges::find_if(map.cells,
                                [&](const MapCell& cell) {
                                  return cell.x == delay_s && cell.stiffness == stiffness;
                                })
        ->growth;
  };
  EXPECT_EQ(growth_at(0.1, 810), std::numeric_limits<double>::infinity());
  EXPECT_EQ(growth_at(0.02, 10), -std::numeric_limits<double>::infinity());
}

// Otherwise an axis of seeds would put tiles of no height on one another.
TEST(Maps, ShowTheWorstOfSeveralSeeds) {
  Results results = TwentyCells();
  for (const std::size_t seed : {8U, 9U}) {
    CellRecord record = results.records.at(0);
    record.cell.number = 12 + seed;
    ReplaceInCase(record, "\"seed\":7", "\"seed\":" + std::to_string(seed));
    if (seed == 8) {
      record.outcome.result.verdict = Verdict::kUnstable;
      record.outcome.result.metrics.growth = 0.4;
    }
    results.records.emplace(record.cell.number, record);
  }
  const StabilityMap map = MapsOf(results, Cube).at(0);
  ASSERT_EQ(map.cells.size(), 20U);
  EXPECT_EQ(map.cells[0].verdict, Verdict::kUnstable);
  EXPECT_EQ(map.cells[0].growth, 0.4);
  EXPECT_NE(map.cells[0].hint.find("the worst of 3 seeds, 2 of them stable"), std::string::npos);
  EXPECT_NE(map.note.find("22 runs"), std::string::npos) << map.note;
  EXPECT_EQ(map.cells[1].hint.find("seeds"), std::string::npos);
}

TEST(Maps, NameTheLawOfTheirLine) {
  EXPECT_EQ(LineOf(MapsOf(TwentyCells(), Cube).at(0), MapLineKind::kLaw).name, "default law: p+dd");
  Results results = TwentyCells();
  for (auto& [number, record] : results.records) {
    std::string& text = record.cell.case_json;
    const std::size_t from = text.find("{\"name\":\"constant\"");
    text.replace(from, text.find("}}", from) + 2 - from,
                 R"({"name":"p+d","limits":{"damping_budget":6},"ratio":)" +
                     std::to_string(1 + static_cast<double>(number % 5)) + "}");
  }
  const StabilityMap map = MapsOf(results, Cube).at(0);
  const MapLine& line = LineOf(map, MapLineKind::kLaw);
  EXPECT_EQ(line.name, "law of these runs: p+d");
  // 0.8 (B/te + B^2/3m) with B = 6 N s/m, 1.5 kg and te = 1.1 x the age + 2.5 ms
  for (const PicturePoint& point : line.points) {
    const double te = 1.1 * (point.x + 1e-3) + 2.5e-3;
    EXPECT_NEAR(point.y, 0.8 * std::min(500.0, 6 / te + 36 / 4.5), 0.03 * point.y) << point.x;
  }
}

TEST(Maps, TitlesDistinguishCustomNetworks) {
  Results results = TwentyCells();
  const auto add = [&results](std::size_t from, const char* network) {
    for (std::size_t i = 0; i < 20; ++i) {
      CellRecord record = TwentyCells().records.at(i);
      record.cell.number = from + i;
      ReplaceInCase(record, "\"clean\"", network);
      results.records.emplace(from + i, record);
    }
  };
  add(20, R"({"jitter_ms":20,"loss":0.05})");
  add(40, R"({"jitter_ms":40})");
  add(60, R"({"name":"wifi","jitter_ms":40,"skew":0.5})");
  const std::vector<StabilityMap> maps = MapsOf(results, Cube);
  ASSERT_EQ(maps.size(), 4U);
  std::string titles;
  for (const StabilityMap& map : maps) titles += map.title + "; " + map.note + "\n";
  for (const char* part :
       {"network clean", "network jitter 20 ms, loss 5 %", "network jitter 40 ms", "network wifi",
        "network wifi (jitter 40 ms, skew 0.5)"}) {
    EXPECT_NE(titles.find(part), std::string::npos) << part << "\n" << titles;
  }
}

}  // namespace
}  // namespace tandem
