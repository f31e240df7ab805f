#include "app/study/run/study_session.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <memory>
#include <optional>
#include <sstream>
#include <utility>

#include <nlohmann/json.hpp>
#include <sys/stat.h>
#include <unistd.h>

#include "app/common/console.h"
#include "app/common/exit_codes.h"
#include "app/study/interview.h"
#include "app/study/results_table.h"
#include "app/study/run/study_results.h"
#include "app/study/run/study_trial.h"
#include "app/study/study_file.h"
#include "app/study/trial_case.h"
#include "app/study/trial_log.h"
#include "engine/base/files/whole_file.h"
#include "engine/base/hash.h"
#include "engine/base/text/hex.h"
#include "engine/base/text/json_text.h"

namespace tandem {

namespace {

namespace fs = std::filesystem;
using OrderedJson = nlohmann::ordered_json;

constexpr const char* kConsentQuestion =
    "Nothing is recorded before you agree. The study keeps what you do and answer under your "
    "pseudonym, never under your name. You may stop at any time, without a reason. Do you agree to "
    "take part?";
constexpr const char* kMouse =
    "In the window, press on the part and drag it. With the button held, the wheel moves it "
    "towards you and away, and Ctrl rotates it. Space is the emergency stop; Ctrl and Space end "
    "it.";
constexpr const char* kInputEnded =
    "the input ended before all questions were answered: run the same command again to go on there";

std::string ModeOf(const StudyRequest& request) {
  if (!request.dry_run) return "persons";
  return request.real_time ? "dry run by real peers" : "dry run in virtual time";
}

/// A study at work: its file, its folder, its log.
class StudySession {
 public:
  StudySession(const StudyRequest& request, Study study, std::string text, TrialLog log)
      : request_(request),
        study_(std::move(study)),
        text_(std::move(text)),
        log_(std::move(log)),
        pseudonyms_(PseudonymsOf(study_)),
        interview_(STDIN_FILENO, request.json ? stderr : stdout),
        runner_(study_, {.persons = !request.dry_run,
                         .real_peers = !request.dry_run || request.real_time,
                         .partner_site = request.partner_site,
                         .device = request.device,
                         .connection = request.connection,
                         .wait_seconds = request.wait_seconds}) {}

  int Run();

 private:
  struct Ended {
    int exit_code = kExitOk;
    bool goes_on = true;
  };
  static Ended Failed(int exit_code, const std::string& line) {
    return {Fail(exit_code, line), false};
  }

  const std::string& NameOf(int participant) const {
    return pseudonyms_[static_cast<std::size_t>(participant)];
  }
  bool Finished(int participant) const;
  std::optional<int> WhoseTurn() const;
  int Withdraw();
  Ended RunParticipant(int participant);
  Ended AskForConsent(int participant);
  Ended RunTrial(const TrialOfParticipant& trial);
  Ended Try(const TrialOfParticipant& trial, const fs::path& folder);
  Ended AskQuestions(const TrialOfParticipant& trial);
  void Pause(double seconds);
  fs::path FolderOf(const TrialOfParticipant& trial) const;
  int WriteResults() { return WriteStudyResults(request_, study_, log_); }

  const StudyRequest& request_;
  Study study_;
  std::string text_;  // text of the study file
  TrialLog log_;
  std::vector<std::string> pseudonyms_;
  Interview interview_;
  TrialRunner runner_;
  int lost_ = 0;
};

bool StudySession::Finished(int participant) const {
  for (const PlannedTrial& plan : TrialsOf(study_, participant)) {
    const TrialState state = log_.TrialOf(NameOf(participant), plan.number).state;
    if (state != TrialState::kDone && state != TrialState::kLost) return false;
  }
  return true;
}

/// Returns the first participant who has begun and is not done, else the first who has not begun.
/// Nothing: all are done.
std::optional<int> StudySession::WhoseTurn() const {
  for (const bool begun : {true, false}) {
    for (int participant = 0; participant < study_.participants; ++participant) {
      const std::string& name = NameOf(participant);
      if (log_.Withdrew(name) || log_.ConsentOf(name).has_value() != begun) continue;
      if (!Finished(participant)) return participant;
    }
  }
  return std::nullopt;
}

int StudySession::Withdraw() {
  if (std::ranges::find(pseudonyms_, request_.withdraw) == pseudonyms_.end()) {
    return Fail(kExitUsage, "--withdraw: this is not a pseudonym of this study");
  }
  std::error_code failed;
  fs::remove_all(request_.folder / request_.withdraw, failed);
  if (failed) return Fail(kExitFile, request_.folder.string() + ": " + failed.message());
  if (const auto fault = log_.Withdraw(request_.withdraw)) return Fail(kExitFile, fault->what);
  Say(request_.withdraw + " has withdrawn: the study has removed all their data");
  return kExitOk;
}

fs::path StudySession::FolderOf(const TrialOfParticipant& trial) const {
  return request_.folder / trial.pseudonym / TrialFolder(trial.plan.number);
}

StudySession::Ended StudySession::AskForConsent(int participant) {
  const std::string& name = NameOf(participant);
  if (log_.ConsentOf(name)) return {};
  if (!request_.dry_run) {
    interview_.Tell(study_.title + "\n");
    if (!study_.information.empty()) interview_.Tell(study_.information + "\n");
    interview_.Tell("Your pseudonym is " + name + ".");
    const auto answer = interview_.AskForWord(kConsentQuestion, {"yes", "no"});
    if (!answer) return Failed(kExitFailed, kInputEnded);
    if (*answer == "no") {
      interview_.Tell("Nothing was recorded. Thank you.");
      return {kExitOk, false};
    }
  }
  if (const auto fault = log_.Consent(name)) return Failed(kExitFile, fault->what);
  return {};
}

void StudySession::Pause(double seconds) {
  if (request_.dry_run || seconds <= 0) return;
  interview_.Tell("Pause of at least " + std::to_string(static_cast<long>(seconds)) +
                  " s. The study then tells you what comes next.");
  const auto until = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  // lines typed during the pause answer nothing
  while (std::chrono::steady_clock::now() < until) {
    interview_.LineWithin(std::chrono::milliseconds(100));
  }
}

StudySession::Ended StudySession::Try(const TrialOfParticipant& trial, const fs::path& folder) {
  const fs::path unfinished = folder.string() + ".unfinished";
  std::error_code none;
  // the files of a cut trial are kept under a name that says so
  for (const fs::path& left : {unfinished, folder}) {
    const int attempts = log_.TrialOf(trial.pseudonym, trial.plan.number).attempts;
    if (!fs::exists(left, none)) continue;
    fs::rename(left, folder.string() + ".cut-" + std::to_string(std::max(attempts, 1)), none);
    if (none) return Failed(kExitFile, left.string() + ": " + none.message());
  }
  fs::create_directories(unfinished, none);
  if (none) return Failed(kExitFile, unfinished.string() + ": " + none.message());
  if (const auto fault = log_.Begin(trial.pseudonym, trial.plan.number)) {
    return Failed(kExitFile, fault->what);
  }
  const Result<TrialMeasures> measures = runner_.Run(trial, unfinished, interview_);
  if (!measures) {
    const int attempts = log_.TrialOf(trial.pseudonym, trial.plan.number).attempts;
    const std::string line = "trial " + std::to_string(trial.plan.number) + " of " +
                             trial.pseudonym + ", attempt " + std::to_string(attempts) +
                             ", was cut: " + measures.error().what;
    // a person must look at what is wrong before the next attempt
    if (!request_.dry_run) return Failed(kExitFailed, line + "; run the same command to continue");
    Say(line);
    return {};
  }
  fs::rename(unfinished, folder, none);
  if (none) return Failed(kExitFile, unfinished.string() + ": " + none.message());
  if (const auto fault = log_.Ran(trial.pseudonym, trial.plan.number, *measures)) {
    return Failed(kExitFile, fault->what);
  }
  return {};
}

StudySession::Ended StudySession::AskQuestions(const TrialOfParticipant& trial) {
  std::map<std::string, std::string> answers;
  OrderedJson json = OrderedJson::object();
  for (const StudyQuestion& question : study_.questions) {
    interview_.ForgetTyped();
    const std::optional<std::string> answer =
        request_.dry_run ? ModelledAnswer(study_, trial.participant, trial.plan, question)
                         : interview_.Ask(question);
    if (!answer) return Failed(kExitFailed, kInputEnded);
    answers[question.key] = *answer;
    json[question.key] = *answer;
  }
  const fs::path file = FolderOf(trial) / "answers.json";
  if (const auto fault = WriteWholeFile(file, JsonText(json, 2) + "\n")) {
    return Failed(kExitFile, fault->what);
  }
  if (const auto fault = log_.Answered(trial.pseudonym, trial.plan.number, answers)) {
    return Failed(kExitFile, fault->what);
  }
  return {};
}

StudySession::Ended StudySession::RunTrial(const TrialOfParticipant& trial) {
  const StudyTask& task = study_.tasks[study_.blocks[trial.plan.block].task];
  const auto state = [&] {
    return log_.TrialOf(trial.pseudonym, trial.plan.number).state;
  };
  while (state() == TrialState::kPlanned || state() == TrialState::kCut) {
    if (!request_.dry_run) {
      char text[200];
      std::snprintf(text, sizeof text,
                    "Trial %d. It ends by itself %safter %g s; press Enter if you are done "
                    "earlier. Press Enter to begin.",
                    trial.plan.number, task.success.has_goal() ? "at its goal, or " : "",
                    task.time_limit_s);
      interview_.ForgetTyped();
      interview_.Tell(text);
      if (!interview_.Line()) return Failed(kExitFailed, kInputEnded);
    }
    if (const Ended ended = Try(trial, FolderOf(trial)); !ended.goes_on) return ended;
  }
  if (state() == TrialState::kLost) ++lost_;
  return state() == TrialState::kRan ? AskQuestions(trial) : Ended{};
}

StudySession::Ended StudySession::RunParticipant(int participant) {
  if (const Ended ended = AskForConsent(participant); !ended.goes_on) return ended;
  std::optional<std::size_t> block;
  for (const PlannedTrial& plan : TrialsOf(study_, participant)) {
    const TrialState state = log_.TrialOf(NameOf(participant), plan.number).state;
    if (state == TrialState::kDone || state == TrialState::kLost) continue;
    if (plan.number < request_.from_trial) continue;
    if (!request_.dry_run && block != plan.block) {
      const StudyBlock& next = study_.blocks[plan.block];
      if (block || plan.number > 1) Pause(next.pause_s);
      const std::string& instructions = study_.tasks[next.task].instructions;
      if (!instructions.empty()) interview_.Tell("\n" + instructions);
      if (!next.instructions.empty()) interview_.Tell("\n" + next.instructions);
      if (!block && request_.device.empty()) interview_.Tell(std::string("\n") + kMouse);
    }
    block = plan.block;
    const Ended ended = RunTrial({participant, NameOf(participant), plan});
    if (!ended.goes_on) return ended;
  }
  if (!request_.dry_run) interview_.Tell("That was the last trial. Thank you.");
  return {};
}

int StudySession::Run() {
  const fs::path copy = request_.folder / "study.json";
  if (const auto fault = WriteWholeFile(copy, text_)) return Fail(kExitFile, fault->what);
  if (!request_.withdraw.empty()) {
    const int withdrawn = Withdraw();
    return withdrawn == kExitOk ? WriteResults() : withdrawn;
  }
  Ended ended;
  if (!request_.results_only) {
    if (const auto fault = runner_.LoadScenes()) return Fail(kExitFile, fault->what);
    std::optional<int> who;
    if (!request_.participant.empty()) {
      const auto found = std::ranges::find(pseudonyms_, request_.participant);
      // the typed word is not repeated, because it may be a person's name
      if (found == pseudonyms_.end()) {
        return Fail(kExitUsage,
                    "--participant: this is not a pseudonym of this study; the study keeps no "
                    "names: give the pseudonym that it printed, such as " +
                        pseudonyms_.front() + ", or leave it out for the next participant");
      }
      who = static_cast<int>(found - pseudonyms_.begin());
      if (log_.Withdrew(*found)) return Fail(kExitUsage, *found + " has withdrawn");
    } else {
      who = WhoseTurn();
    }
    if (!who) Say("all participants are done");
    while (who && ended.goes_on) {
      ended = RunParticipant(*who);
      // persons come one by one; modelled hands run all at once
      who = request_.dry_run && request_.participant.empty() ? WhoseTurn() : std::nullopt;
    }
  }
  const int written = WriteResults();
  if (ended.exit_code != kExitOk) return ended.exit_code;
  if (written != kExitOk) return written;
  const auto lost = std::ranges::count_if(RowsOf(study_, log_), [](const ResultRow& row) {
    return row.logged.state == TrialState::kLost;
  });
  if (lost > lost_) {
    Say(WithPlural(static_cast<std::uint64_t>(lost), "trial") +
        " of this study lost so far: cut as often as the study allows");
  }
  Say("results are in " + request_.folder.string() + ": results.csv, codebook.md, report.html");
  return lost_ == 0 ? kExitOk
                    : Fail(kExitFailed, WithPlural(static_cast<std::uint64_t>(lost_), "trial") +
                                            " lost: cut as often as the study allows");
}

}  // namespace

int RunStudy(const StudyRequest& request) {
  umask(077);  // participants' data is for the study's user alone
  Result<Study> study = LoadStudy(request.file);
  if (!study) return Fail(kExitFile, study.error().what);
  if (request.partner_site && study->modelled_partner) {
    return Fail(kExitUsage,
                "--site partner: the study's partner is modelled: give the study file \"partner\": "
                "\"person\"");
  }
  std::ostringstream text;
  text << std::ifstream(request.file, std::ios::binary).rdbuf();
  Hash64 hash;
  hash.AddBytes(text.str().data(), text.str().size());
  std::error_code failed;
  fs::create_directories(request.folder, failed);
  if (failed) return Fail(kExitFile, request.folder.string() + ": " + failed.message());
  TrialLogHeader header{.study = study->name,
                        .study_hash = Hex(hash.value()),
                        .seed = study->seed,
                        .version = request.version,
                        .mode = ModeOf(request),
                        .site = request.partner_site ? "partner" : "participant"};
  if (request.results_only || !request.withdraw.empty()) {
    // results keep the mode and site of the trials
    if (const Result<TrialLog> known = TrialLog::Read(request.folder / "trials.jsonl", 1)) {
      header.mode = known->header().mode;
      header.site = known->header().site;
    }
  }
  Result<TrialLog> log = TrialLog::Open(request.folder / "trials.jsonl", header, study->attempts);
  if (!log) return Fail(kExitFile, log.error().what);
  StudySession session(request, *std::move(study), text.str(), *std::move(log));
  return session.Run();
}

}  // namespace tandem
