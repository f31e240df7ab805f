#include "app/study/trial_log.h"

#include <cerrno>
#include <cmath>
#include <cstring>
#include <ctime>
#include <fstream>
#include <sstream>

#include <fcntl.h>
#include <nlohmann/json.hpp>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "engine/base/files/whole_file.h"
#include "engine/base/text/json_reader.h"
#include "engine/base/text/json_text.h"

namespace tandem {

namespace {

using OrderedJson = nlohmann::ordered_json;

std::string LineOf(const TrialLogHeader& header) {
  return JsonText(OrderedJson{{"study", header.study},
                              {"study_hash", header.study_hash},
                              {"seed", header.seed},
                              {"version", header.version},
                              {"mode", header.mode},
                              {"site", header.site}});
}

TrialLogHeader HeaderOf(const JsonNode& node) {
  node.AllowKeys({"study", "study_hash", "seed", "version", "mode", "site"});
  TrialLogHeader header;
  header.study = node["study"].Text();
  header.study_hash = node["study_hash"].Text();
  header.seed = node["seed"].Unsigned();
  header.version = node["version"].Text();
  header.mode = node["mode"].Text();
  header.site = node["site"].Text();
  return header;
}

Error FaultOf(const std::filesystem::path& file, const std::string& what) {
  return Error{file.string() + ": " + what};
}

OrderedJson EventOf(const char* event, const std::string& participant) {
  return {{"event", event}, {"participant", participant}, {"at", UtcNow()}};
}

OrderedJson EventOf(const char* event, const std::string& participant, int trial, int attempt) {
  return {{"event", event},
          {"participant", participant},
          {"trial", trial},
          {"attempt", attempt},
          {"at", UtcNow()}};
}

TrialMeasures MeasuresOf(const JsonNode& node) {
  TrialMeasures measures;
  for (const TrialMeasure& measure : AllTrialMeasures()) {
    const JsonNode value = node[measure.name];
    if (value.Compact() != "null") measures.*measure.value = value.Number();
  }
  return measures;
}

}  // namespace

const char* NameOf(TrialState state) {
  switch (state) {
    case TrialState::kPlanned:
      return "planned";
    case TrialState::kCut:
      return "cut";
    case TrialState::kRan:
      return "unanswered";
    case TrialState::kDone:
      return "done";
    case TrialState::kLost:
      return "lost";
  }
  return "";
}

std::string UtcNow() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&now, &utc);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &utc);
  return text;
}

TrialLog::TrialLog(TrialLog&& other) noexcept
    : file_(std::move(other.file_)),
      attempts_(other.attempts_),
      descriptor_(std::exchange(other.descriptor_, -1)),
      header_(std::move(other.header_)),
      consents_(std::move(other.consents_)),
      withdrawn_(std::move(other.withdrawn_)),
      trials_(std::move(other.trials_)) {}

TrialLog::~TrialLog() {
  if (descriptor_ >= 0) close(descriptor_);
}

std::optional<Error> TrialLog::TakeLine(const std::string& line, std::size_t number) {
  const Result<JsonFile> json =
      JsonFile::Parse(line, file_.string() + " line " + std::to_string(number));
  if (!json) return json.error();
  const JsonNode root = json->root();
  if (number == 1) {
    header_ = HeaderOf(root);
    return json->fault();
  }
  const std::string event = root["event"].Text("an event");
  const std::string participant = root["participant"].Text("a pseudonym");
  const std::string at = root["at"].Text("a time");
  if (event == "consent") {
    consents_[participant] = at;
    withdrawn_.erase(participant);
    return json->fault();
  }
  if (event == "withdrawn") {
    withdrawn_[participant] = at;
    return json->fault();
  }
  LoggedTrial& trial = trials_[{participant, root["trial"].WholeNumber(1, 100'000)}];
  trial.attempts = root["attempt"].WholeNumber(1, 1000);
  if (event == "begun") {
    trial.begun_at = at;
    trial.state = trial.attempts < attempts_ ? TrialState::kCut : TrialState::kLost;
  } else if (event == "ran") {
    trial.measures = MeasuresOf(root["measures"]);
    trial.state = TrialState::kRan;
  } else if (event == "answered") {
    for (const JsonNode& answer : root["answers"].Items()) {
      answer.AllowKeys({"key", "answer"});
      trial.answers[answer["key"].Text()] = answer["answer"].PlainText(1 << 12);
    }
    trial.state = TrialState::kDone;
  } else {
    root["event"].Expected("consent, withdrawn, begun, ran or answered");
  }
  return json->fault();
}

std::optional<Error> TrialLog::Take(const std::string& text, std::size_t& whole) {
  std::size_t number = 0;
  for (whole = 0; whole < text.size();) {
    const std::size_t end = text.find('\n', whole);
    if (end == std::string::npos) return std::nullopt;  // unfinished line
    if (const auto fault = TakeLine(text.substr(whole, end - whole), ++number)) return fault;
    whole = end + 1;
  }
  return std::nullopt;
}

Result<TrialLog> TrialLog::Open(const std::filesystem::path& file, const TrialLogHeader& header,
                                int attempts) {
  TrialLog log;
  log.file_ = file;
  log.attempts_ = attempts;
  log.descriptor_ = open(file.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0600);
  if (log.descriptor_ < 0) return FaultOf(file, std::strerror(errno));
  // it holds what participants answered; an older one may be readable by all
  fchmod(log.descriptor_, 0600);
  if (flock(log.descriptor_, LOCK_EX | LOCK_NB) != 0) {
    return FaultOf(file, "another 'tandem study' uses it: wait until that one ends");
  }
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  std::size_t whole = 0;
  if (const auto fault = log.Take(text.str(), whole)) return *fault;
  if (whole < text.str().size() && ftruncate(log.descriptor_, static_cast<off_t>(whole)) != 0) {
    return FaultOf(file, std::strerror(errno));
  }
  if (whole == 0) {
    log.header_ = header;
    if (const auto fault = log.Add(LineOf(header))) return *fault;
  }
  if (log.header_.study_hash != header.study_hash) {
    return FaultOf(file,
                   "belongs to another study file: finish with that one (study.json beside this "
                   "log is a copy), or use another folder");
  }
  if (log.header_.mode != header.mode || log.header_.site != header.site) {
    return FaultOf(file, "belongs to '" + log.header_.mode + "' at the site '" + log.header_.site +
                             "': run '" + header.mode + "' at the site '" + header.site +
                             "' in another folder");
  }
  return log;
}

Result<TrialLog> TrialLog::Read(const std::filesystem::path& file, int attempts) {
  TrialLog log;
  log.file_ = file;
  log.attempts_ = attempts;
  std::ifstream stream(file, std::ios::binary);
  if (!stream) return FaultOf(file, std::strerror(errno));
  std::ostringstream text;
  text << stream.rdbuf();
  std::size_t whole = 0;
  if (const auto fault = log.Take(text.str(), whole)) return *fault;
  if (whole == 0) return FaultOf(file, "holds no log of trials");
  return log;
}

std::optional<std::string> TrialLog::ConsentOf(const std::string& participant) const {
  const auto found = consents_.find(participant);
  if (found == consents_.end()) return std::nullopt;
  return found->second;
}

LoggedTrial TrialLog::TrialOf(const std::string& participant, int trial) const {
  const auto found = trials_.find({participant, trial});
  return found == trials_.end() ? LoggedTrial{} : found->second;
}

std::optional<Error> TrialLog::Add(const std::string& line) {
  const std::string whole = line + "\n";
  // one write, so that a killed program never leaves a partial line before a whole one
  if (write(descriptor_, whole.data(), whole.size()) != static_cast<ssize_t>(whole.size()) ||
      fdatasync(descriptor_) != 0) {
    return FaultOf(file_, std::string("cannot be written: ") + std::strerror(errno));
  }
  return std::nullopt;
}

std::optional<Error> TrialLog::Consent(const std::string& participant) {
  const std::string line = JsonText(EventOf("consent", participant));
  if (const auto fault = Add(line)) return fault;
  return TakeLine(line, 2);
}

std::optional<Error> TrialLog::Begin(const std::string& participant, int trial) {
  const std::string line =
      JsonText(EventOf("begun", participant, trial, TrialOf(participant, trial).attempts + 1));
  if (const auto fault = Add(line)) return fault;
  return TakeLine(line, 2);
}

std::optional<Error> TrialLog::Ran(const std::string& participant, int trial,
                                   const TrialMeasures& measures) {
  OrderedJson event = EventOf("ran", participant, trial, TrialOf(participant, trial).attempts);
  for (const TrialMeasure& measure : AllTrialMeasures()) {
    const double value = measures.*measure.value;
    event["measures"][std::string(measure.name)] =
        std::isfinite(value) ? OrderedJson(value) : OrderedJson();
  }
  const std::string line = JsonText(event);
  if (const auto fault = Add(line)) return fault;
  return TakeLine(line, 2);
}

std::optional<Error> TrialLog::Answered(const std::string& participant, int trial,
                                        const std::map<std::string, std::string>& answers) {
  OrderedJson event = EventOf("answered", participant, trial, TrialOf(participant, trial).attempts);
  event["answers"] = OrderedJson::array();
  for (const auto& [key, answer] : answers) {
    event["answers"].push_back({{"key", key}, {"answer", answer}});
  }
  const std::string line = JsonText(event);
  if (const auto fault = Add(line)) return fault;
  return TakeLine(line, 2);
}

std::optional<Error> TrialLog::Withdraw(const std::string& participant) {
  std::ifstream stream(file_, std::ios::binary);
  std::string kept;
  std::size_t number = 0;
  for (std::string line; std::getline(stream, line);) {
    const OrderedJson json = OrderedJson::parse(line, nullptr, false);
    const bool theirs = ++number > 1 && json.value("participant", "") == participant;
    if (!theirs) kept += line + "\n";
  }
  kept += JsonText(EventOf("withdrawn", participant)) + "\n";
  if (const auto fault = WriteWholeFile(file_, kept)) return fault;
  // the path is another file now: later lines go there
  const int descriptor = open(file_.c_str(), O_RDWR | O_APPEND | O_CLOEXEC);
  if (descriptor < 0 || flock(descriptor, LOCK_EX | LOCK_NB) != 0) {
    if (descriptor >= 0) close(descriptor);
    return FaultOf(file_, std::strerror(errno));
  }
  close(std::exchange(descriptor_, descriptor));
  consents_.erase(participant);
  std::erase_if(trials_, [&participant](const auto& trial) {
    return trial.first.first == participant;
  });
  withdrawn_[participant] = UtcNow();
  return std::nullopt;
}

}  // namespace tandem
