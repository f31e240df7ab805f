#include "app/stability/cell_facts.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <string_view>

#include <nlohmann/json.hpp>

namespace tandem {

namespace {

using Json = nlohmann::json;

// of an object or of a name
std::string NameIn(const Json& value) {
  if (value.is_string()) return value.get<std::string>();
  if (value.is_object() && value.contains("name")) return NameIn(value["name"]);
  if (value.is_object() && value.contains("mass_kg")) {
    return TableNumber(value["mass_kg"].get<double>()) + " kg";
  }
  return "own";
}

double NumberIn(const Json& object, const char* key, double otherwise) {
  return object.is_object() && object.contains(key) ? object[key].get<double>() : otherwise;
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

std::string MapKey(Json test) {
  for (const char* key : {"name", "seed", "delay_s", "seconds"}) test.erase(key);
  Json& law = test["law"];
  for (const char* key : {"ratio", "boundary_ratio"}) law.erase(key);
  if (law.contains("limits")) {
    law["limits"].erase("constant_stiffness");
    if (law["limits"].empty()) law.erase("limits");
  }
  return test.dump();
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
    facts.hands.append(facts.hands.empty() ? "" : " + ").append(NameIn(hand));
  }
  facts.delay_s = NumberIn(test, "delay_s", 0);
  facts.network = test.contains("network") ? NameIn(test["network"]) : "clean";
  facts.publish_hz = NumberIn(test, "publish_hz", 1000);
  const Json law = test.value("law", Json::object());
  facts.law = LawText(law);
  facts.gate = law.value("gate", true);
  facts.motion = test.value("motion", "kick");
  facts.map = MapKey(test);
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

}  // namespace tandem
