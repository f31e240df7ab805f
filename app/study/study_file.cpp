#include "app/study/study_file.h"

#include <algorithm>
#include <array>
#include <set>
#include <utility>

#include "collab/coupling/coupling_limits.h"
#include "engine/base/text/json_reader.h"

namespace tandem {

namespace {

constexpr int kMostParticipants = 900;
constexpr int kMostRepetitions = 1000;
constexpr int kMostAttempts = 10;
constexpr std::size_t kMostConditions = 64;
constexpr std::size_t kMostItems = 256;      // items of any other list
constexpr std::size_t kMostTrials = 10'000;  // trials of a participant
constexpr double kMostDelayMs = 1200;        // limit of the lab's cases
constexpr double kMostJitterMs = 1000;
constexpr double kMostGain = 1e7;
constexpr double kLongestTrial = 3600;  // s
constexpr std::size_t kLongestProse = 20'000;

bool IsPlainWord(const std::string& word) {
  return !word.empty() && word.size() <= 40 && std::ranges::all_of(word, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
           c == '-';
  });
}

/// Reads a word that may stand in names of files and columns.
std::string Word(const JsonNode& node) {
  const std::string word = node.Text("a word");
  if (!IsPlainWord(word)) node.Expected("a word of at most 40 letters, digits, - and _");
  return word;
}

std::string Prose(const JsonNode& object, std::string_view key) {
  return object.Has(key) ? object[key].PlainText(kLongestProse) : std::string();
}

double ShareIn(const JsonNode& object, std::string_view key, double otherwise) {
  return object.Has(key) ? object[key].NumberBetween(0, 1) : otherwise;
}

double NumberBetween(const JsonNode& object, std::string_view key, double least, double most,
                     double otherwise) {
  return object.Has(key) ? object[key].NumberBetween(least, most) : otherwise;
}

std::vector<JsonNode> Items(const JsonNode& object, std::string_view key, std::size_t most) {
  std::vector<JsonNode> items = object[key].Items();
  if (items.empty()) object[key].Expected("at least one");
  if (items.size() > most) {
    object[key].Fault("more than " + std::to_string(most));
    items.erase(items.begin() + static_cast<std::ptrdiff_t>(most), items.end());
  }
  return items;
}

void ReadGains(const JsonNode& node, StudyCondition& condition) {
  node.AllowKeys({kLimitNames[0].name, kLimitNames[1].name, kLimitNames[2].name,
                  kLimitNames[3].name, kLimitNames[4].name, kLimitNames[5].name,
                  kLimitNames[6].name, kLimitNames[7].name});
  for (const LimitName& limit : kLimitNames) {
    if (!node.Has(limit.name)) continue;
    condition.gains.*limit.value = node[limit.name].NumberBetween(0, kMostGain);
    if (const std::string why = WhyUnused(limit.name, condition.law); !why.empty()) {
      node[limit.name].Fault(why);
    }
  }
}

StudyCondition ReadCondition(const JsonNode& node) {
  node.AllowKeys({"name", "delay_ms", "jitter_ms", "loss", "burst_enter", "burst_leave",
                  "burst_loss", "law", "gains", "gate", "scene", "planted_slower"});
  StudyCondition condition;
  condition.name = Word(node["name"]);
  condition.delay_ms = NumberBetween(node, "delay_ms", 0, kMostDelayMs, 0);
  condition.jitter_ms = NumberBetween(node, "jitter_ms", 0, kMostJitterMs, 0);
  condition.loss = ShareIn(node, "loss", 0);
  condition.burst_enter = ShareIn(node, "burst_enter", 0);
  condition.burst_leave = ShareIn(node, "burst_leave", 1);
  condition.burst_loss = ShareIn(node, "burst_loss", 1);
  if (node.Has("law")) condition.law = node["law"].Text("the name of a law");
  if (const auto law = MakeLaw(condition.law, {}, true); !law) node["law"].Fault(law.error().what);
  if (node.Has("gains")) ReadGains(node["gains"], condition);
  if (const auto law = MakeLaw(condition.law, condition.gains, true); !law) {
    node["gains"].Fault(law.error().what);
  }
  if (node.Has("gate")) condition.gate = node["gate"].TrueOrFalse();
  if (node.Has("scene")) condition.scene = node["scene"].Text("a scene");
  condition.planted_slower = NumberBetween(node, "planted_slower", 0.1, 10, 1);
  return condition;
}

StudySuccess ReadSuccess(const JsonNode& node) {
  node.AllowKeys({"out", "moved_mm", "time_s", "peak_force_N", "collisions", "hold_s"});
  StudySuccess success;
  if (node.Has("out")) success.out = node["out"].TrueOrFalse();
  if (node.Has("moved_mm")) success.moved_mm = node["moved_mm"].NumberAbove(0);
  if (success.out && success.moved_mm) {
    node["moved_mm"].Fault(
        "give 'out' or 'moved_mm', not both: one of them decides when the task is done");
  }
  if (node.Has("time_s")) success.time_s = node["time_s"].NumberAbove(0);
  if (success.time_s && !success.has_goal()) {
    node["time_s"].Fault(
        "needs 'out' or 'moved_mm', because it limits the time until that is reached");
  }
  if (node.Has("hold_s")) {
    success.hold_s = node["hold_s"].NumberBetween(0.1, 60);
    if (!success.has_goal()) {
      node["hold_s"].Fault("needs 'out' or 'moved_mm', because it is how long that must be kept");
    }
  }
  if (node.Has("peak_force_N")) success.peak_force_N = node["peak_force_N"].NumberAbove(0);
  if (node.Has("collisions")) success.collisions = node["collisions"].WholeNumber(0, 1'000'000);
  return success;
}

StudyTask ReadTask(const JsonNode& node) {
  node.AllowKeys(
      {"name", "scene", "body", "instructions", "time_limit_s", "success", "hands", "motion"});
  StudyTask task;
  task.name = Word(node["name"]);
  task.scene = node["scene"].Text("a scene");
  if (node.Has("body")) task.body = node["body"].Text("the name of a body");
  task.instructions = Prose(node, "instructions");
  task.time_limit_s = node["time_limit_s"].NumberBetween(1, kLongestTrial);
  if (node.Has("success")) task.success = ReadSuccess(node["success"]);
  if (node.Has("hands")) {
    for (const JsonNode& hand : Items(node, "hands", 2)) {
      task.hands.push_back(hand.Text("off, relaxed, heavy, firm or a hand file"));
    }
  }
  if (node.Has("motion")) {
    task.motion = node["motion"].Text("the name of a motion");
    if (task.hands.empty())
      node["motion"].Fault("is a motion of the lab's hands: name hands in 'hands'");
  }
  return task;
}

/// Returns the index of the item that the node names.
template <typename Named>
std::size_t Find(const JsonNode& node, const std::vector<Named>& all) {
  const std::string name = node.Text("a name");
  const auto found = std::ranges::find(all, name, &Named::name);
  if (found != all.end()) return static_cast<std::size_t>(found - all.begin());
  std::string names;
  for (const Named& one : all) names += (names.empty() ? "" : ", ") + one.name;
  node.Expected("one of " + names);
  return 0;
}

StudyBlock ReadBlock(const JsonNode& node, const Study& study) {
  node.AllowKeys({"name", "task", "conditions", "repetitions", "order", "practice", "instructions",
                  "pause_s"});
  StudyBlock block;
  block.name = Word(node["name"]);
  block.task = Find(node["task"], study.tasks);
  std::set<std::size_t> seen;
  for (const JsonNode& item : Items(node, "conditions", kMostConditions)) {
    block.conditions.push_back(Find(item, study.conditions));
    if (!seen.insert(block.conditions.back()).second) {
      item.Fault("is given twice: use 'repetitions'");
    }
  }
  if (node.Has("repetitions")) {
    block.repetitions = node["repetitions"].WholeNumber(1, kMostRepetitions);
  }
  if (node.Has("order")) {
    const std::string order = node["order"].Text("an order");
    if (order == "williams") {
      block.order = StudyOrder::kWilliams;
    } else if (order == "shuffled") {
      block.order = StudyOrder::kShuffled;
    } else if (order == "as_written") {
      block.order = StudyOrder::kAsWritten;
    } else {
      node["order"].Expected("williams, shuffled or as_written");
    }
  }
  if (node.Has("practice")) block.practice = node["practice"].TrueOrFalse();
  block.instructions = Prose(node, "instructions");
  block.pause_s = NumberBetween(node, "pause_s", 0, kLongestTrial, 0);
  return block;
}

StudyQuestion ReadQuestion(const JsonNode& node) {
  node.AllowKeys({"key", "text", "kind", "choices", "low", "high"});
  StudyQuestion question;
  question.key = Word(node["key"]);
  question.text = node["text"].Text("a question");
  const std::string kind = node["kind"].Text("a kind of question");
  if (kind == "choice") {
    question.kind = QuestionKind::kChoice;
  } else if (kind == "scale") {
    question.kind = QuestionKind::kScale;
  } else if (kind == "text") {
    question.kind = QuestionKind::kText;
  } else {
    node["kind"].Expected("choice, scale or text");
  }
  if (question.kind == QuestionKind::kChoice) {
    for (const JsonNode& item : Items(node, "choices", kMostItems)) {
      question.choices.push_back(item.Text("an answer"));
    }
  } else if (node.Has("choices")) {
    node["choices"].Fault("only a question of kind 'choice' has choices");
  }
  for (const char* end : {"low", "high"}) {
    if (!node.Has(end)) continue;
    if (question.kind != QuestionKind::kScale) {
      node[end].Fault("only a question of kind 'scale' has words for its ends");
    }
    (end[0] == 'l' ? question.low : question.high) = node[end].Text("a meaning");
  }
  return question;
}

/// Reports a fault for each name that occurs twice.
template <typename Named>
void NoneTwice(const JsonNode& list, const std::vector<Named>& all, std::string Named::*name) {
  std::set<std::string> seen;
  for (const Named& one : all) {
    if (!seen.insert(one.*name).second) list.Fault("'" + one.*name + "' is given twice");
  }
}

Study ReadStudy(const JsonNode& root) {
  root.AllowKeys({"name", "title", "seed", "participants", "partner", "attempts", "publish_hz",
                  "information", "tasks", "conditions", "blocks", "questions"});
  Study study;
  study.name = Word(root["name"]);
  study.title = root.Has("title") ? root["title"].Text("a title") : study.name;
  study.seed = root["seed"].Unsigned(1'000'000'000);
  study.participants = root["participants"].WholeNumber(1, kMostParticipants);
  if (root.Has("partner")) {
    const std::string partner = root["partner"].Text("a partner");
    study.modelled_partner = partner == "modelled";
    if (partner != "modelled" && partner != "person")
      root["partner"].Expected("modelled or person");
  }
  if (root.Has("attempts")) study.attempts = root["attempts"].WholeNumber(1, kMostAttempts);
  study.publish_hz = NumberBetween(root, "publish_hz", 10, 1000, 1000);
  study.information = Prose(root, "information");
  for (const JsonNode& item : Items(root, "tasks", kMostItems)) {
    study.tasks.push_back(ReadTask(item));
  }
  for (const JsonNode& item : Items(root, "conditions", kMostConditions)) {
    study.conditions.push_back(ReadCondition(item));
  }
  std::size_t trials = 0;
  for (const JsonNode& item : Items(root, "blocks", kMostItems)) {
    study.blocks.push_back(ReadBlock(item, study));
    trials += study.blocks.back().conditions.size() *
              static_cast<std::size_t>(study.blocks.back().repetitions);
  }
  if (trials > kMostTrials) {
    root["blocks"].Fault("have " + std::to_string(trials) + " trials; a study has at most " +
                         std::to_string(kMostTrials));
  }
  if (root.Has("questions")) {
    for (const JsonNode& item : Items(root, "questions", kMostItems)) {
      study.questions.push_back(ReadQuestion(item));
    }
    NoneTwice(root["questions"], study.questions, &StudyQuestion::key);
  }
  NoneTwice(root["tasks"], study.tasks, &StudyTask::name);
  NoneTwice(root["conditions"], study.conditions, &StudyCondition::name);
  NoneTwice(root["blocks"], study.blocks, &StudyBlock::name);
  return study;
}

Result<Study> StudyIn(const Result<JsonFile>& json) {
  if (!json) return json.error();
  Study study = ReadStudy(json->root());
  if (const std::optional<Error> fault = json->fault()) return *fault;
  return study;
}

}  // namespace

Result<Study> LoadStudy(const std::filesystem::path& file) {
  Result<Study> study = StudyIn(JsonFile::Read(file));
  if (!study) return study;
  const auto find = [&file](std::string& name) {
    std::error_code none;
    const std::filesystem::path beside = file.parent_path() / name;
    const bool is_file = std::filesystem::path(name).extension() == ".json";
    if (!is_file || !std::filesystem::exists(beside, none)) return;
    name = std::filesystem::absolute(beside, none).lexically_normal().string();
  };
  for (StudyTask& task : study->tasks) {
    find(task.scene);
    for (std::string& hand : task.hands) find(hand);
  }
  for (StudyCondition& condition : study->conditions) find(condition.scene);
  return study;
}

Result<Study> ParseStudy(const std::string& text, const std::string& name) {
  return StudyIn(JsonFile::Parse(text, name));
}

}  // namespace tandem
