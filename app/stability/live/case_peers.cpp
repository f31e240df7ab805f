#include "app/stability/live/case_peers.h"

#include <cstdio>

#include <nlohmann/json.hpp>

#include "collab/coupling/coupling_limits.h"
#include "collab/lab/case/case_parts.h"
#include "engine/base/files/whole_file.h"
#include "engine/base/text/json_text.h"
#include "scenes/generators/hand_file.h"

namespace tandem {

namespace {

using OrderedJson = nlohmann::ordered_json;

OrderedJson StepOf(const LinkConditions& conditions, double at_s) {
  OrderedJson step{{"delay_ms", conditions.delay_ms},
                   {"jitter_ms", conditions.jitter_ms},
                   {"swing_ms", conditions.swing_ms},
                   {"swing_period_s", conditions.swing_period_s},
                   {"loss", conditions.loss},
                   {"burst_enter", conditions.burst_enter},
                   {"burst_leave", conditions.burst_leave},
                   {"burst_loss", conditions.burst_loss},
                   {"reorder", conditions.reorder},
                   {"reorder_ms", conditions.reorder_ms},
                   {"duplicate", conditions.duplicate},
                   {"at_s", at_s}};
  if (conditions.trace == nullptr) return step;
  const LinkTrace::Source& source = conditions.trace->source;
  const bool made = !source.model.empty();
  step[made ? "model" : "trace"] = made ? source.model : source.file;
  step["way"] = source.back ? "back" : "there";
  step["stretch"] = source.stretch;
  step["start_s"] = conditions.trace_start_s;
  return step;
}

}  // namespace

std::string NameOfUser(std::size_t user) {
  return "user-" + std::to_string(user);
}

std::optional<Error> WriteCaseHand(const LabCase& test, std::size_t user,
                                   const std::filesystem::path& file) {
  HandScript script = ScriptOf(test, user);
  if (script.waypoints.empty()) script.waypoints.emplace_back();  // the hand stays at rest
  return WriteWholeFile(file, HandFile(script));
}

std::optional<Error> WriteCasePlan(const LabCase& test, std::size_t user,
                                   const std::filesystem::path& file) {
  OrderedJson links = OrderedJson::array();
  std::uint64_t seed = 0;
  for (std::size_t other = 0; other < test.users; ++other) {
    if (other == user) continue;
    OrderedJson steps = OrderedJson::array();
    const auto add = [&](double at_s, double delay_s) {
      const LinkConditions conditions = ConditionsOf(test, other, user, delay_s);
      seed = conditions.seed % 1'000'000'000;  // largest seed that a plan takes
      steps.push_back(StepOf(conditions, at_s));
    };
    const std::vector<LabNetwork::Step>& schedule = test.network.schedule;
    if (schedule.empty() || schedule.front().at_s > 0) add(0, test.delay_s);
    for (const LabNetwork::Step& step : schedule) add(step.at_s, step.delay_s);
    links.push_back({{"from", NameOfUser(other)}, {"steps", steps}});
  }
  const OrderedJson plan{{"seed", seed}, {"begins", "hand"}, {"links", links}};
  return WriteWholeFile(file, JsonText(plan, 2) + "\n");
}

std::vector<std::string> LawArguments(const LabCase& test) {
  std::vector<std::string> words{"--law", test.law.name, "--publish-hz",
                                 std::to_string(test.publish_hz), "--lab"};
  const CouplingLimits limits = LimitsOf(test.law);
  for (const LimitName& limit : kLimitNames) {
    char text[64];
    std::snprintf(text, sizeof text, "=%.17g", limits.*limit.value);
    words.insert(words.end(), {"--gain", std::string(limit.name) + text});
  }
  if (!test.law.gate) words.emplace_back("--no-gate");
  return words;
}

}  // namespace tandem
