#include "app/study/trial_case.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <nlohmann/json.hpp>

#include "collab/coupling/coupling_limits.h"
#include "collab/lab/case/case_file.h"
#include "collab/lab/case/case_parts.h"
#include "engine/base/files/whole_file.h"
#include "engine/base/text/json_text.h"
#include "engine/haptics/hand_script.h"
#include "scenes/generators/hand_file.h"

namespace tandem {

namespace {

using OrderedJson = nlohmann::ordered_json;

constexpr double kPersonsPace = 0.08;  // standard deviation of the pace's logarithm
constexpr double kTrialsPace = 0.03;
constexpr double kLeastS = 1e-3;

/// Draws a number of mean 0 and deviation 1 from twelve uniform draws. It is nearly normal, and
/// equal on every machine.
double NormalDraw(std::uint64_t seed, const std::string& what, std::uint64_t which) {
  double sum = -6;
  for (std::uint64_t i = 0; i < 12; ++i) {
    sum += 0x1p-53 * static_cast<double>(DrawOf(seed, what, which, i) >> 11U);
  }
  return sum;
}

std::uint64_t KeyOf(int participant, const PlannedTrial& trial) {
  return 100'000 * static_cast<std::uint64_t>(participant) +
         static_cast<std::uint64_t>(trial.number);
}

bool IsHandFile(const std::string& hand) {
  return std::filesystem::path(hand).extension() == ".json";
}

/// Returns the hands of a task at their own pace: those of files, or the lab's in a motion.
Result<std::array<HandScript, 2>> HandsOf(const StudyTask& task, const LabScene& scene) {
  std::array<HandScript, 2> scripts;
  const Scene& file = scene.model->scene;
  if (task.hands.empty()) {
    const std::string& body = file.bodies[scene.object].name;
    std::size_t user = 0;
    for (const SceneHand& hand : file.hands) {
      if (hand.body != body || user == scripts.size()) continue;
      const Result<HandScript> script = LoadHandScript(hand.file);
      if (!script) return script.error();
      scripts[user++] = *script;
    }
    if (user == scripts.size()) return scripts;
    return Error{"task " + task.name + ": its scene has no two hands on '" + body +
                 "': give 'hands' in the task"};
  }
  OrderedJson hands = OrderedJson::array();
  for (const std::string& hand : task.hands) {
    hands.push_back(IsHandFile(hand) ? OrderedJson{{"file", hand}} : OrderedJson(hand));
  }
  const OrderedJson json{{"hands", hands},
                         {"motion", task.motion.empty() ? "move" : task.motion},
                         {"delay_s", 0},
                         {"seconds", task.time_limit_s}};
  Result<LabCase> plain = ParseCase(JsonText(json), "task " + task.name);
  if (!plain) return plain.error();
  const LabCase fitted = FittedTo(scene.inertia(), *plain);
  for (std::size_t user = 0; user < scripts.size(); ++user) {
    scripts[user] = ScriptOf(fitted, user);
  }
  return scripts;
}

void SetPace(HandScript& script, double pace) {
  for (Waypoint& waypoint : script.waypoints) waypoint.t *= pace;
  for (Push& push : script.pushes) push.t *= pace;
  if (script.waypoints.empty()) script.waypoints.emplace_back();  // the hand stays in place
}

OrderedJson LawJson(const StudyCondition& condition) {
  OrderedJson law{{"name", condition.law}, {"gate", condition.gate}};
  const CouplingLimits usual;
  for (const LimitName& limit : kLimitNames) {
    const double value = condition.gains.*limit.value;
    if (value == usual.*limit.value) continue;
    if (limit.name == "ratio") {
      law["ratio"] = value;
    } else {
      law["limits"][std::string(limit.name)] = value;
    }
  }
  return law;
}

}  // namespace

double PaceOf(const Study& study, int participant, const PlannedTrial& trial) {
  const double person =
      NormalDraw(study.seed, "pace of a person", static_cast<std::uint64_t>(participant));
  const double once = NormalDraw(study.seed, "pace of a trial", KeyOf(participant, trial));
  return std::exp(kPersonsPace * person + kTrialsPace * once) *
         study.conditions[trial.condition].planted_slower;
}

Result<LabCase> MakeTrialCase(const Study& study, int participant, const PlannedTrial& trial,
                              const LabScene& scene, const TrialPlace& place) {
  const StudyCondition& condition = study.conditions[trial.condition];
  const StudyTask& task = study.tasks[study.blocks[trial.block].task];
  Result<std::array<HandScript, 2>> hands = HandsOf(task, scene);
  if (!hands) return hands.error();
  OrderedJson files = OrderedJson::array();
  for (std::size_t user = 0; user < hands->size(); ++user) {
    HandScript& script = (*hands)[user];
    SetPace(script, PaceOf(study, participant, trial));
    const std::string name = "user-" + std::to_string(user) + ".hand.json";
    if (const auto fault = WriteWholeFile(place.folder / name, HandFile(script))) return *fault;
    files.push_back({{"file", name}});
  }
  const OrderedJson json{
      {"name", "trial " + std::to_string(trial.number)},
      {"scene", place.scene},
      {"body", scene.model->scene.bodies[scene.object].name},
      {"users", 2},
      {"hands", files},
      {"law", LawJson(condition)},
      {"delay_s", 1e-3 * condition.delay_ms},
      {"network",
       {{"name", "own"},
        {"jitter_ms", condition.jitter_ms},
        {"loss", condition.loss},
        {"burst_enter", condition.burst_enter},
        {"burst_leave", condition.burst_leave},
        {"burst_loss", condition.burst_loss}}},
      {"publish_hz", study.publish_hz},
      {"seconds", std::max(task.time_limit_s, kLeastS)},
      {"seed", DrawOf(study.seed, "case", KeyOf(participant, trial)) % 1'000'000}};
  const std::filesystem::path file = place.folder / "case.json";
  if (const auto fault = WriteWholeFile(file, JsonText(json, 2) + "\n")) return *fault;
  return LoadCase(file);
}

std::string ModelledAnswer(const Study& study, int participant, const PlannedTrial& trial,
                           const StudyQuestion& question) {
  const std::uint64_t draw =
      DrawOf(study.seed, "answer " + question.key, KeyOf(participant, trial));
  switch (question.kind) {
    case QuestionKind::kChoice:
      return question.choices[draw % question.choices.size()];
    case QuestionKind::kScale:
      return std::to_string(1 + draw % kScaleMost);
    case QuestionKind::kText:
      break;
  }
  return "dry run";
}

}  // namespace tandem
