#include "app/stability/report/cell_facts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <string_view>
#include <utility>

#include <nlohmann/json.hpp>

#include "engine/base/text/json_text.h"

namespace tandem {

namespace {

using Json = nlohmann::json;

double NumberIn(const Json& object, const char* key, double otherwise) {
  return object.is_object() && object.contains(key) ? object[key].get<double>() : otherwise;
}

// the name of a value, which is an object or the name itself
std::string NameIn(const Json& value) {
  if (value.is_string()) return value.get<std::string>();
  if (value.is_object() && value.contains("name")) return NameIn(value["name"]);
  return "own";
}

std::string HandText(const Json& hand) {
  if (!hand.is_object()) return NameIn(hand);
  if (hand.contains("file")) {
    return std::filesystem::path(hand["file"].get<std::string>()).stem().string();
  }
  std::string text;
  for (const auto& [key, unit] : {std::pair("mass_kg", " kg"), std::pair("damping_Ns_m", " N s/m"),
                                  std::pair("stiffness_N_m", " N/m")}) {
    if (!hand.contains(key)) continue;
    text.append(text.empty() ? "" : " ").append(TableNumber(hand[key].get<double>())).append(unit);
  }
  return text;
}

/// Returns " at 0 40 0 mm" for a hand with a grasp of its own, else nothing.
std::string GraspText(const Json& hand) {
  if (!hand.is_object() || !hand.contains("grasp_m")) return {};
  std::string text = " at";
  for (const Json& part : hand["grasp_m"]) text += " " + TableNumber(1e3 * part.get<double>());
  return text + " mm";
}

// such as "jitter 20 ms, loss 5 %"; a schedule is described by its steps
std::string LineText(const Json& network) {
  std::string text;
  for (const auto& [key, value] : network.items()) {
    if (key == "name") continue;
    text += text.empty() ? "" : ", ";
    const std::string_view name = key;
    if (name == "schedule") {
      text += "delays that change";
      for (const Json& step : value) {
        text.append(" ").append(TableNumber(1e3 * NumberIn(step, "delay_s", 0))).append(" ms");
        if (step.value("cut", false)) text += " cut";
      }
    } else if (name.ends_with("_ms")) {
      text.append(name.substr(0, name.size() - 3)).append(" ");
      text.append(TableNumber(value.get<double>())).append(" ms");
    } else if (name == "loss" || name == "reorder" || name == "duplicate") {
      text.append(name).append(" ").append(TableNumber(1e2 * value.get<double>())).append(" %");
    } else if (!value.is_number()) {  // a model's or a trace's name, or a mixture
      text.append(name).append(" ").append(value.is_string() ? value.get<std::string>()
                                                             : JsonText(value));
    } else {
      text.append(name).append(" ").append(TableNumber(value.get<double>()));
    }
  }
  return text.empty() ? "clean" : text;
}

std::string LawText(const Json& law) {
  std::string text = NameIn(law);
  const Json limits = law.value("limits", Json::object());
  const double boundary_ratio = NumberIn(law, "boundary_ratio", 0);
  if (boundary_ratio > 0) {
    text.append(", ").append(TableNumber(boundary_ratio)).append(" of the boundary");
  } else if (limits.contains("constant_stiffness")) {
    text.append(" ").append(TableNumber(limits["constant_stiffness"].get<double>())).append(" N/m");
  }
  for (const auto& [key, value] : limits.items()) {
    if (key == "constant_stiffness") continue;
    const bool firm = key == "linear_stiffness" || key == "stiffness";
    const bool drag = key == "constant_damping" || key == "damping_budget";
    text.append(firm ? " " : " + ").append(TableNumber(value.get<double>()));
    if (firm) text += " N/m";
    if (drag) text += " N s/m";
    if (!firm && !drag) text += " " + key;
  }
  const double ratio = NumberIn(law, "ratio", 1);
  if (ratio != 1) text.append(" x ").append(TableNumber(ratio));
  if (law.value("exchange_forces", false)) text += ", forces exchanged";
  return text;
}

std::string KeyButSeed(Json test) {
  for (const char* key : {"name", "seed"}) test.erase(key);
  return JsonText(test);
}

std::string MapKey(Json test) {
  for (const char* key : {"name", "seed", "seconds"}) test.erase(key);
  Json& law = test["law"];
  for (const char* key : {"ratio", "boundary_ratio"}) law.erase(key);
  if (law.contains("limits")) {
    law["limits"].erase("constant_stiffness");
    if (law["limits"].empty()) law.erase("limits");
  }
  return JsonText(test);
}

}  // namespace

std::string TableNumber(double value) {
  if (!std::isfinite(value)) return std::isinf(value) ? "any" : "-";
  std::array<char, 40> text{};
  std::snprintf(text.data(), text.size(), std::abs(value) >= 1e3 ? "%.0f" : "%.3g", value);
  return text.data();
}

CellFacts FactsOf(const CellRecord& record) {
  const Json test = Json::parse(record.cell.case_json);
  CellFacts facts;
  facts.scene = test.value("scene", "free");
  facts.users = test.value("users", std::size_t{2});
  for (const Json& hand : test.value("hands", Json::array())) {
    const std::string kind = HandText(hand);
    facts.hands.append(facts.hands.empty() ? "" : " + ").append(kind).append(GraspText(hand));
    facts.hand_kinds.append(facts.hand_kinds.empty() ? "" : " + ").append(kind);
  }
  facts.delay_s = NumberIn(test, "delay_s", 0);
  const Json network = test.value("network", Json("clean"));
  const bool named = !network.is_object() || network.contains("name");
  facts.network = named ? NameIn(network) : LineText(network);
  facts.network_detail = facts.network;
  if (network.is_object() && named) facts.network_detail += " (" + LineText(network) + ")";
  facts.seed = test.value("seed", std::uint64_t{1});
  facts.publish_hz = NumberIn(test, "publish_hz", 1000);
  const Json law = test.value("law", Json::object());
  facts.law = LawText(law);
  facts.gate = law.value("gate", true);
  facts.motion = test.value("motion", "kick");
  Json but_grasp = test;
  if (but_grasp.contains("hands")) {
    for (Json& hand : but_grasp["hands"]) {
      if (!hand.is_object() || !hand.contains("grasp_m")) continue;
      double square = 0;
      for (const Json& part : hand["grasp_m"]) square += std::pow(part.get<double>(), 2);
      facts.grasp_m = std::max(facts.grasp_m, std::sqrt(square));
      hand.erase("grasp_m");
    }
  }
  facts.grasp_map = MapKey(std::move(but_grasp));
  Json but_delay = test;
  but_delay.erase("delay_s");
  facts.map = MapKey(std::move(but_delay));
  facts.but_seed = KeyButSeed(test);
  return facts;
}

std::string LineOf(const CellRecord& record, const CellFacts& facts) {
  return "cell " + std::to_string(record.cell.number) + ": " + facts.scene + ", " +
         std::to_string(facts.users) + " users, hands " + facts.hands + ", " +
         TableNumber(1e3 * facts.delay_s) + " ms, " + facts.network + ", " +
         TableNumber(facts.publish_hz) + " Hz, " + facts.law + ", " + facts.motion;
}

double StiffnessOf(const CellRecord& record, const CellFacts& facts) {
  if (record.outcome.predicted) return record.outcome.predicted->stiffness;
  return static_cast<double>(facts.users - 1) * record.outcome.result.metrics.stiffness;
}

double ShownGrowth(const CaseResult& result) {
  constexpr double kWild = 0.1;     // m/s at the end
  constexpr double kAtRest = 1e-9;  // m/s
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  const Metrics& metrics = result.metrics;
  if (metrics.diverged) return kInfinite;
  if (result.verdict == Verdict::kUnstable && metrics.tail_rms > kWild) return kInfinite;
  if (result.verdict == Verdict::kStable && metrics.tail_rms < kAtRest) return -kInfinite;
  return metrics.growth;
}

}  // namespace tandem
