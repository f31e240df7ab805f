#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/study/trial_meter.h"
#include "engine/base/result.h"

namespace tandem {

/// The first line of a log: the study of its trials, and how they are run.
struct TrialLogHeader {
  std::string study;
  std::string study_hash;  // hash of the study file's bytes
  std::uint64_t seed = 1;
  std::string version;  // program's version
  std::string mode;     // persons, dry run in virtual time, dry run by real peers
  std::string site;     // participant, partner

  bool operator==(const TrialLogHeader&) const = default;
};

/// The state of a trial.
enum class TrialState : std::uint8_t {
  kPlanned,  // not begun
  kCut,      // begun, and interrupted
  kRan,      // measured, but its questions are not answered
  kDone,
  kLost  // cut as often as the study allows
};
const char* NameOf(TrialState state);

struct LoggedTrial {
  TrialState state = TrialState::kPlanned;
  int attempts = 0;
  std::string begun_at;  // time of the last attempt, UTC
  TrialMeasures measures;
  std::map<std::string, std::string> answers;  // answers by the questions' keys
};

using TrialKey = std::pair<std::string, int>;  // pseudonym, and number of the trial

/// The log of a study's trials, the only record of what was done, one line of JSON for each event.
/// A line is on the disk when a call returns. Opening the log cuts off an unfinished last line,
/// which a killed program may leave.
class TrialLog {
 public:
  /// Opens the log, or begins one. Errors: the log is of another study, mode or site; another
  /// program has it open; a line is damaged. `attempts`: how often a trial may be begun.
  static Result<TrialLog> Open(const std::filesystem::path& file, const TrialLogHeader& header,
                               int attempts);
  /// Reads a log without writing it. Its header may be any.
  static Result<TrialLog> Read(const std::filesystem::path& file, int attempts);

  TrialLog(TrialLog&& other) noexcept;
  TrialLog& operator=(TrialLog&&) = delete;
  ~TrialLog();

  const TrialLogHeader& header() const { return header_; }
  /// Returns when the participant consented, UTC; nothing: no consent.
  std::optional<std::string> ConsentOf(const std::string& participant) const;
  const std::map<std::string, std::string>& consents() const { return consents_; }
  bool Withdrew(const std::string& participant) const { return withdrawn_.contains(participant); }
  LoggedTrial TrialOf(const std::string& participant, int trial) const;

  std::optional<Error> Consent(const std::string& participant);
  std::optional<Error> Begin(const std::string& participant, int trial);
  std::optional<Error> Ran(const std::string& participant, int trial,
                           const TrialMeasures& measures);
  std::optional<Error> Answered(const std::string& participant, int trial,
                                const std::map<std::string, std::string>& answers);
  /// Removes all lines of the participant from the file, and records when they withdrew.
  std::optional<Error> Withdraw(const std::string& participant);

 private:
  TrialLog() = default;
  std::optional<Error> Take(const std::string& text, std::size_t& whole);
  std::optional<Error> TakeLine(const std::string& line, std::size_t number);
  std::optional<Error> Add(const std::string& line);

  std::filesystem::path file_;
  int attempts_ = 1;
  int descriptor_ = -1;
  TrialLogHeader header_;
  std::map<std::string, std::string> consents_;
  std::map<std::string, std::string> withdrawn_;
  std::map<TrialKey, LoggedTrial> trials_;
};

/// Returns the current time as "2026-01-31T09:26:53Z".
std::string UtcNow();

}  // namespace tandem
