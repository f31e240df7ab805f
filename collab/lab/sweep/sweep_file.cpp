#include "collab/lab/sweep/sweep_file.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <set>
#include <string_view>
#include <tuple>
#include <utility>

#include <nlohmann/json.hpp>

#include "collab/coupling/coupling_law.h"
#include "collab/lab/case/lab_case.h"
#include "collab/trace/trace_models.h"
#include "engine/base/hash.h"
#include "engine/base/text/hex.h"
#include "engine/base/text/json_reader.h"

namespace tandem {

namespace {

using Json = nlohmann::json;  // its keys are in order

constexpr std::array<std::string_view, 13> kAxes{
    "scene", "users",          "hands",         "delay_s", "network", "publish_hz", "law",
    "ratio", "boundary_ratio", "stiffness_N_m", "motion",  "seconds", "seed"};

constexpr std::size_t kMostValues = 10'000;  // for one axis; each is tried alone

// makes 1.0 and 1 the same number, and so the same key
Json Plain(Json value) {
  constexpr double kExact = 9e15;
  if (value.is_number_float()) {
    const double number = value.get<double>();
    if (std::nearbyint(number) == number && std::abs(number) < kExact) {
      return static_cast<std::int64_t>(number);
    }
  }
  if (value.is_structured()) {
    for (Json& each : value) each = Plain(std::move(each));
  }
  return value;
}

Json DefaultCase() {
  return {{"scene", "free"},
          {"users", 2},
          {"hands", {"relaxed"}},
          {"motion", "kick"},
          {"law", {{"name", DefaultLaw()->name()}, {"ratio", 1}, {"gate", true}}},
          {"delay_s", Plain(LabCase{}.delay_s)},
          {"network", "clean"},
          {"publish_hz", 1000},
          {"seconds", 0}};
}

// puts a value of an axis into the case
void Put(std::string_view axis, const Json& value, Json& out) {
  Json& law = out["law"];
  if (axis == "law" && value.is_object()) {
    law.update(value, true);
  } else if (axis == "law") {
    law["name"] = value;
  } else if (axis == "ratio" || axis == "boundary_ratio") {
    law[std::string(axis)] = value;
  } else if (axis == "stiffness_N_m") {
    law["limits"]["constant_stiffness"] = value;
  } else if (axis == "hands" && !value.is_array()) {
    out["hands"] = Json::array({value});
  } else {
    out[std::string(axis)] = value;
  }
}

void AddText(const std::string& text, Hash64& hash) {
  hash.Add(static_cast<std::uint64_t>(text.size()));
  hash.AddBytes(text.data(), text.size());
}

// returns the measured cost of a user's frame, relative to one in free space
double SceneCost(const std::string& scene) {
  if (scene == "free" || scene == "off_centre") return 1;
  if (scene == "wall") return 3;
  return 25;
}

/// Returns whether a trace gives the case's network its own delays.
bool HasTrace(const Json& test) {
  const Json& network = test["network"];
  if (network.is_object()) return network.contains("trace") || network.contains("model");
  return std::ranges::find(TraceModels(), network.get<std::string>(), &TraceModel::name) !=
         TraceModels().end();
}

double CostOf(const Json& test) {
  LabCase length;
  length.delay_s = test["delay_s"].get<double>();
  const auto seconds = test["seconds"].get<double>();
  return (seconds > 0 ? seconds : length.DefaultDuration()) * test["users"].get<double>() *
         SceneCost(test["scene"].get<std::string>());
}

struct Axis {
  std::string_view name;
  std::vector<Json> values;
};

/// Expands the blocks in order.
class Expansion {
 public:
  Expansion(const JsonFile& file, std::string name, const CaseCheck& check, Sweep& sweep)
      : file_(file), name_(std::move(name)), check_(check), sweep_(sweep) {}

  /// Returns what is wrong with the cells; the file keeps its own faults.
  std::optional<Error> Go() {
    const std::vector<JsonNode> blocks = file_.root()["blocks"].Items();
    for (std::size_t b = 0; b < blocks.size(); ++b) {
      blocks[b].AllowKeys({"expect", "note", kAxes[0], kAxes[1], kAxes[2], kAxes[3], kAxes[4],
                           kAxes[5], kAxes[6], kAxes[7], kAxes[8], kAxes[9], kAxes[10], kAxes[11],
                           kAxes[12]});
      const std::string place = name_ + ": blocks[" + std::to_string(b) + "]";
      if (std::optional<Error> wrong = AddBlock(blocks[b], place)) return wrong;
    }
    return std::nullopt;
  }

 private:
  // tries each value alone, so that a fault names its place
  std::optional<Error> Read(const JsonNode& block, const std::string& place, Axis& axis) const {
    const JsonNode node = block[axis.name];
    const bool many = node.IsArray();
    const std::vector<JsonNode> items = many ? node.Items() : std::vector<JsonNode>{node};
    if (items.empty()) node.Fault("an empty array leaves no cell");
    if (items.size() > kMostValues) {
      node.Fault("more than " + std::to_string(kMostValues) + " values: divide the sweep");
      return std::nullopt;
    }
    for (std::size_t i = 0; i < items.size(); ++i) {
      axis.values.push_back(Plain(Json::parse(items[i].Compact())));
      Json alone = DefaultCase();
      // the law `constant` takes every axis; a law is tried under its own name
      if (axis.name != "law") alone["law"]["name"] = "constant";
      Put(axis.name, axis.values.back(), alone);
      std::string here = place;
      here.append(".").append(axis.name);
      if (many) here.append("[").append(std::to_string(i)).append("]");
      if (std::optional<Error> wrong = check_(alone.dump(), here)) return wrong;
    }
    return std::nullopt;
  }

  std::optional<Error> AddBlock(const JsonNode& block, const std::string& place) {
    const Expectation expect = ReadExpectation(block);
    std::vector<Axis> axes;
    for (const std::string_view name : kAxes) {
      if (!block.Has(name)) continue;
      axes.push_back({name, {}});
      if (std::optional<Error> wrong = Read(block, place, axes.back())) return wrong;
    }
    if (file_.fault()) return std::nullopt;
    std::size_t cells = 1;
    for (const Axis& axis : axes) cells = std::min(kMostCells + 1, cells * axis.values.size());
    if (cells > kMostCells - std::min(kMostCells, sweep_.cells.size())) {
      return Error{place + ": more than " + std::to_string(kMostCells) +
                   " cells in all: divide the sweep among several files"};
    }
    // the last axis turns fastest
    std::vector<std::size_t> at(axes.size(), 0);
    for (bool more = true; more;) {
      Json test = DefaultCase();
      for (std::size_t a = 0; a < axes.size(); ++a) Put(axes[a].name, axes[a].values[at[a]], test);
      if (!block.Has("delay_s") && HasTrace(test)) test["delay_s"] = 0;
      if (block.Has("stiffness_N_m") && test["law"]["name"] != "constant") {
        block["stiffness_N_m"].Fault("only the law \"constant\" has a stiffness of its own");
        return std::nullopt;
      }
      if (std::optional<Error> wrong = AddCell(std::move(test), expect, place)) return wrong;
      more = false;
      for (std::size_t a = axes.size(); a-- > 0 && !more;) {
        more = ++at[a] < axes[a].values.size();
        if (!more) at[a] = 0;
      }
    }
    return std::nullopt;
  }

  static Expectation ReadExpectation(const JsonNode& block) {
    if (!block.Has("expect")) return Expectation::kNothing;
    const std::string word = block["expect"].Text("\"stable\" or \"unstable\"");
    if (word == NameOf(Expectation::kStable)) return Expectation::kStable;
    if (word != NameOf(Expectation::kUnstable)) {
      block["expect"].Expected("\"stable\" or \"unstable\"");
    }
    return Expectation::kUnstable;
  }

  std::optional<Error> AddCell(Json test, Expectation expect, const std::string& place) {
    const std::string key = test.dump();
    if (!keys_.insert(key).second) return std::nullopt;
    SweepCell cell;
    cell.number = sweep_.cells.size();
    cell.expect = expect;
    Hash64 content;
    AddText(key, content);
    cell.key = Hex(content.value());
    Hash64 seed;
    seed.Add(sweep_.seed);
    AddText(key, seed);
    if (!test.contains("seed")) test["seed"] = 1 + seed.value() % kSeeds;
    test["name"] = sweep_.name + " " + std::to_string(cell.number);
    cell.case_json = test.dump();
    const std::string here = place + ", cell " + std::to_string(cell.number);
    if (std::optional<Error> wrong = check_(cell.case_json, here)) return wrong;
    cell.cost = CostOf(test);
    sweep_.cells.push_back(std::move(cell));
    return std::nullopt;
  }

  static constexpr std::uint64_t kSeeds = 1'000'000'000;

  const JsonFile& file_;
  std::string name_;
  const CaseCheck& check_;
  Sweep& sweep_;
  std::set<std::string> keys_;
};

void Rank(std::vector<SweepCell>& cells) {
  std::vector<SweepCell*> order;
  for (SweepCell& cell : cells) order.push_back(&cell);
  std::ranges::sort(order, [](const SweepCell* a, const SweepCell* b) {
    return std::tie(b->cost, a->key) < std::tie(a->cost, b->key);
  });
  for (std::size_t i = 0; i < order.size(); ++i) order[i]->rank = i;
}

}  // namespace

const char* NameOf(Expectation expectation) {
  switch (expectation) {
    case Expectation::kStable:
      return "stable";
    case Expectation::kUnstable:
      return "unstable";
    case Expectation::kNothing:
      break;
  }
  return "nothing";
}

Result<Sweep> LoadSweep(const std::filesystem::path& file, const CaseCheck& check) {
  const Result<JsonFile> json = JsonFile::Read(file);
  if (!json) return json.error();
  const JsonNode root = json->root();
  if (!root.Has("blocks")) {
    root.Fault("there are no blocks: a single case is run by 'tandem stability run'");
  }
  root.AllowKeys({"name", "note", "seed", "blocks"});
  Sweep sweep;
  sweep.name = root["name"].Text("a name");
  sweep.seed =
      root.Has("seed") ? static_cast<std::uint64_t>(root["seed"].WholeNumber(0, 1'000'000'000)) : 1;
  const std::optional<Error> wrong = Expansion(*json, file.string(), check, sweep).Go();
  if (json->fault()) return *json->fault();
  if (wrong) return *wrong;
  if (sweep.cells.empty()) return Error{file.string() + ": blocks: there is no cell"};
  Rank(sweep.cells);
  Hash64 hash;
  hash.Add(sweep.seed);
  for (const SweepCell& cell : sweep.cells) {
    AddText(cell.key, hash);
    hash.Add(cell.expect);
  }
  sweep.hash = Hex(hash.value());
  return sweep;
}

Result<Shard> ParseShard(const std::string& text) {
  Shard shard;
  const char* const end = text.data() + text.size();
  const auto [slash, first] = std::from_chars(text.data(), end, shard.index);
  if (first == std::errc{} && slash != end && *slash == '/') {
    const auto [rest, second] = std::from_chars(slash + 1, end, shard.of);
    if (second == std::errc{} && rest == end && shard.index >= 1 && shard.index <= shard.of) {
      return shard;
    }
  }
  return Error{"a shard is i/n with i from 1 to n, as 3/20: not '" + text + "'"};
}

}  // namespace tandem
