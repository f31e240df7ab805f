#include "collab/lab/case/case_file.h"

#include <algorithm>
#include <array>
#include <optional>
#include <string_view>
#include <utility>

#include "collab/coupling/coupling_limits.h"
#include "collab/trace/trace_models.h"
#include "engine/base/text/json_reader.h"

namespace tandem {

namespace {

constexpr std::array<std::pair<std::string_view, LabMotion>, 7> kMotions{
    {{"still", LabMotion::kStill},
     {"kick", LabMotion::kKick},
     {"move", LabMotion::kMove},
     {"hold", LabMotion::kHold},
     {"swing", LabMotion::kSwing},
     {"press", LabMotion::kPress},
     {"pull_off", LabMotion::kPullOff}}};

constexpr std::array<std::pair<std::string_view, double CouplingLimits::*>, 7> kLimits{
    {{"damping_budget", &CouplingLimits::damping_budget},
     {"stiffness", &CouplingLimits::stiffness},
     {"margin", &CouplingLimits::margin},
     {"linear_stiffness", &CouplingLimits::linear_stiffness},
     {"constant_stiffness", &CouplingLimits::constant_stiffness},
     {"constant_damping", &CouplingLimits::constant_damping},
     {"constant_link_damping", &CouplingLimits::constant_link_damping}}};

constexpr int kMostUsers = 8;
constexpr std::size_t kMostSteps = 10'000;  // in a schedule
constexpr double kLongestHand = 3600;       // s
constexpr double kLeastHandMass = 1e-6;     // kg
constexpr double kMostHandMass = 1e4;       // kg
constexpr double kMostGain = 1e7;           // N/m, N s/m
constexpr double kFarthestGrasp = 1;        // m
constexpr double kShortestSwing = 1e-3;     // s
constexpr double kLongestSwing = 1e6;       // s
constexpr double kLongestDelay = 1.2;       // s one way: beyond, links are cut whatever the law

double NumberWithin(const JsonNode& node, std::string_view key, double least, double most,
                    double otherwise) {
  if (!node.Has(key)) return otherwise;
  const double value = node[key].NumberFrom(least);
  if (value > most) {
    node[key].Expected("a number of at most " + std::to_string(most).substr(0, 6));
    return otherwise;
  }
  return value;
}

/// Reads a hand file in the case's folder.
LabHand ReadHandFile(const JsonNode& node, const std::filesystem::path& folder) {
  node.AllowKeys({"file"});
  const std::filesystem::path file = node["file"].Text("a hand file");
  const Result<HandScript> script = LoadHandScript(folder / file);
  if (!script) {
    node["file"].Fault(script.error().what);
    return {};
  }
  if (script->duration() > kLongestHand) {
    node["file"].Fault("moves for more than an hour: no case lasts longer");
    return {};
  }
  return {file.stem().string(), script->impedance, *script};
}

LabHand ReadHand(const JsonNode& node, const std::filesystem::path& folder) {
  const Inertia unfitted{1.0, Mat3::Identity()};
  if (!node.IsObject()) {
    const std::string name = node.Text("off, relaxed, heavy, firm or an object");
    const Result<LabHand> hand = HandNamed(name, unfitted);
    if (hand) return *hand;
    node.Fault(hand.error().what);
    return {};
  }
  if (node.Has("file")) return ReadHandFile(node, folder);
  node.AllowKeys({"mass_kg", "damping_Ns_m", "stiffness_N_m", "grasp_m"});
  LabHand hand{"own", {}};
  const auto gain = [&node](std::string_view key) {
    return node.Has(key) ? node[key].NumberBetween(0, kMostGain) : 0.0;
  };
  hand.impedance.mass = node["mass_kg"].NumberBetween(kLeastHandMass, kMostHandMass);
  hand.impedance.damping = gain("damping_Ns_m");
  hand.impedance.stiffness = gain("stiffness_N_m");
  if (node.Has("grasp_m")) {
    hand.grasp_B = node["grasp_m"].Vector();
    if (!(hand.grasp_B->norm() <= kFarthestGrasp)) {
      node["grasp_m"].Expected("a place at most 1 m from the centre of mass");
    }
  }
  return hand;
}

LabMotion ReadMotion(const JsonNode& node) {
  const std::string word = node.Text("the name of a motion");
  for (const auto& motion : kMotions) {
    if (motion.first == word) return motion.second;
  }
  node.Expected("still, kick, move, hold, swing, press or pull_off");
  return LabMotion::kStill;
}

LabLaw ReadLaw(const JsonNode& node) {
  node.AllowKeys({"name", "limits", "ratio", "boundary_ratio", "gate", "exchange_forces"});
  LabLaw law;
  if (node.Has("name")) law.name = node["name"].Text("the name of a law");
  if (node.Has("limits")) {
    const JsonNode limits = node["limits"];
    limits.AllowKeys({kLimits[0].first, kLimits[1].first, kLimits[2].first, kLimits[3].first,
                      kLimits[4].first, kLimits[5].first, kLimits[6].first});
    for (const auto& limit : kLimits) {
      if (!limits.Has(limit.first)) continue;
      law.limits.*limit.second = limits[limit.first].NumberBetween(0, kMostGain);
      if (const std::string why = WhyUnused(limit.first, law.name); !why.empty()) {
        limits[limit.first].Fault(why);
      }
    }
  }
  if (node.Has("ratio")) law.ratio = node["ratio"].NumberAbove(0);
  if (node.Has("boundary_ratio")) law.boundary_ratio = node["boundary_ratio"].NumberFrom(0);
  if (node.Has("gate")) law.gate = node["gate"].TrueOrFalse();
  if (node.Has("exchange_forces")) law.exchange_forces = node["exchange_forces"].TrueOrFalse();
  if (const auto made = MakeLaw(law.name, law.limits, true); !made) {
    node["name"].Fault(made.error().what);
  }
  if (law.boundary_ratio > 0 && law.name != "constant") {
    node["boundary_ratio"].Fault("only the law 'constant' takes a share of the boundary");
  }
  return law;
}

bool IsModel(const std::string& name) {
  return std::ranges::find(TraceModels(), name, &TraceModel::name) != TraceModels().end();
}

LinkConditions ReadWay(const JsonNode& node) {
  LinkConditions way;
  way.delay_ms = NumberWithin(node, "delay_ms", 0, 1000, way.delay_ms);
  way.jitter_ms = NumberWithin(node, "jitter_ms", 0, 1000, way.jitter_ms);
  way.swing_ms = NumberWithin(node, "swing_ms", 0, 1000, way.swing_ms);
  if (node.Has("swing_period_s")) {
    way.swing_period_s = node["swing_period_s"].NumberBetween(kShortestSwing, kLongestSwing);
  }
  way.loss = NumberWithin(node, "loss", 0, 1, way.loss);
  way.burst_enter = NumberWithin(node, "burst_enter", 0, 1, way.burst_enter);
  way.burst_leave = NumberWithin(node, "burst_leave", 0, 1, way.burst_leave);
  way.burst_loss = NumberWithin(node, "burst_loss", 0, 1, way.burst_loss);
  way.reorder = NumberWithin(node, "reorder", 0, 1, way.reorder);
  way.reorder_ms = NumberWithin(node, "reorder_ms", 0, 1000, way.reorder_ms);
  way.duplicate = NumberWithin(node, "duplicate", 0, 1, way.duplicate);
  return way;
}

std::vector<LabNetwork::Step> ReadSchedule(const JsonNode& node, double delay_s) {
  std::vector<LabNetwork::Step> schedule;
  const std::vector<JsonNode> items = node.Items();
  if (items.size() > kMostSteps) {
    node.Fault("more than " + std::to_string(kMostSteps) + " steps");
    return schedule;
  }
  for (const JsonNode& item : items) {
    item.AllowKeys({"at_s", "delay_s", "cut"});
    LabNetwork::Step step;
    step.at_s = item["at_s"].NumberFrom(0);
    step.delay_s = NumberWithin(item, "delay_s", 0, kLongestDelay,
                                schedule.empty() ? delay_s : schedule.back().delay_s);
    if (item.Has("cut")) step.cut = item["cut"].TrueOrFalse();
    if (!schedule.empty() && step.at_s <= schedule.back().at_s) {
      item["at_s"].Fault("must be later than the step before");
    }
    schedule.push_back(step);
  }
  return schedule;
}

/// Gives each way of the network its way of the trace.
void TakeTrace(const TraceChoice& traced, LabNetwork& network) {
  network.traced = traced;
  network.there.trace = traced.there;
  network.back.trace = traced.back;
}

LabNetwork ReadNetwork(const JsonNode& node, double delay_s, const std::filesystem::path& folder) {
  LabNetwork network;
  if (node.IsObject()) {
    node.AllowKeys({"name", "delay_ms", "jitter_ms", "swing_ms", "swing_period_s", "loss",
                    "burst_enter", "burst_leave", "burst_loss", "reorder", "reorder_ms",
                    "duplicate", "skew", "schedule", kTraceKeys[0], kTraceKeys[1], kTraceKeys[2],
                    kTraceKeys[3], kTraceKeys[4]});
    network.name = node.Has("name") ? node["name"].Text("a name") : "own";
    network.there = network.back = ReadWay(node);
    TakeTrace(ReadTraceKeys(node, folder), network);
    network.skew = NumberWithin(node, "skew", 0, 1, 0);
    if (node.Has("schedule")) network.schedule = ReadSchedule(node["schedule"], delay_s);
    return network;
  }
  constexpr const char* kNames = "clean, lossy, asymmetric, the name of a model or an object";
  network.name = node.Text(kNames);
  if (IsModel(network.name)) {
    const Result<const LinkTrace*> there = KeepModel(network.name, TraceDirection::kThere, 1);
    const Result<const LinkTrace*> back = KeepModel(network.name, TraceDirection::kBack, 1);
    if (there && back) {
      TakeTrace({.there = *there, .back = *back, .mix = true}, network);
    } else {
      node.Fault((there ? back : there).error().what);
    }
  } else if (network.name == "lossy") {
    network.there = network.back = {.jitter_ms = 30, .loss = 0.05};
  } else if (network.name == "asymmetric") {
    network.skew = 0.8;
  } else if (network.name != "clean") {
    node.Expected(kNames);
  }
  return network;
}

LabCase ReadCase(const JsonNode& root, const std::filesystem::path& folder) {
  if (root.Has("blocks")) {
    root["blocks"].Fault("this file is a sweep: 'tandem stability sweep' runs it");
  }
  root.AllowKeys({"name", "scene", "body", "users", "hands", "motion", "law", "delay_s", "network",
                  "publish_hz", "seconds", "seed"});
  LabCase test;
  if (root.Has("name")) test.name = root["name"].Text("a name");
  if (root.Has("scene")) test.scene = root["scene"].Text("a scene");
  if (root.Has("body")) test.body = root["body"].Text("the name of a body");
  if (root.Has("users")) {
    test.users = static_cast<std::size_t>(root["users"].WholeNumber(2, kMostUsers));
  }
  if (root.Has("hands")) {
    const std::vector<JsonNode> hands = root["hands"].Items();
    if (hands.size() > kMostUsers) {
      root["hands"].Fault("more hands than the " + std::to_string(kMostUsers) +
                          " users there may be");
      return test;
    }
    for (const JsonNode& node : hands) test.hands.push_back(ReadHand(node, folder));
    if (test.hands.empty()) root["hands"].Expected("at least one hand");
  } else {
    test.hands = {*HandNamed("relaxed", {1.0, Mat3::Identity()})};
  }
  if (root.Has("motion")) test.motion = ReadMotion(root["motion"]);
  if (root.Has("law")) test.law = ReadLaw(root["law"]);
  test.delay_s = NumberWithin(root, "delay_s", 0, kLongestDelay, test.delay_s);
  if (root.Has("network")) test.network = ReadNetwork(root["network"], test.delay_s, folder);
  // a trace has its own delays
  if (test.network.traced.there != nullptr && !root.Has("delay_s")) test.delay_s = 0;
  if (root.Has("publish_hz")) {
    test.publish_hz = NumberWithin(root, "publish_hz", 10, 1000, test.publish_hz);
  }
  if (root.Has("seconds")) test.seconds = NumberWithin(root, "seconds", 0, 3600, 0);
  if (root.Has("seed")) {
    test.seed = static_cast<std::uint64_t>(root["seed"].WholeNumber(0, 2'000'000'000));
  }
  return test;
}

Result<LabCase> CaseIn(const Result<JsonFile>& json, const std::filesystem::path& folder) {
  if (!json) return json.error();
  LabCase test = ReadCase(json->root(), folder);
  if (const std::optional<Error> fault = json->fault()) return *fault;
  return test;
}

}  // namespace

Result<LabCase> LoadCase(const std::filesystem::path& file) {
  Result<LabCase> test = CaseIn(JsonFile::Read(file), file.parent_path());
  if (!test) return test;
  const std::filesystem::path scene = test->scene;
  if (scene.extension() == ".json" && scene.is_relative()) {
    test->scene = (file.parent_path() / scene).string();
  }
  return test;
}

Result<LabCase> ParseCase(const std::string& text, const std::string& name,
                          const std::filesystem::path& folder) {
  return CaseIn(JsonFile::Parse(text, name), folder);
}

}  // namespace tandem
