#include "collab/dds/cyclone/cyclone_log.h"

#include <array>
#include <chrono>
#include <mutex>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "collab/dds/cyclone/dds_api.h"
#include "engine/base/files/regular_file.h"
#include "engine/realtime/line_writer.h"

namespace tandem {
namespace {

// A line of one meaning is written at most once in this time.
constexpr auto kQuiet = std::chrono::minutes(1);

// A part of Cyclone's message, and its meaning with what to do; empty: nothing is written. The
// first that matches counts; the last matches all.
constexpr std::array<std::pair<const char*, const char*>, 21> kMeanings{{
    // no participant of ours fits it: it is heard before ours is made or after it is gone
    {"Remote secure participant", ""},
    {"Certificate not valid", "somebody with keys of another session was refused"},
    {"PKCS7", "somebody's permissions, or our own, are not signed by the session's authority"},
    {"Could not get remote participant", "somebody's permissions were refused"},
    {"not allowed", "somebody tried what its permissions do not allow, and was refused"},
    {"Not Allowed By Security", "our own permissions do not allow this"},
    {"handshake", "somebody could not prove who it is"},
    {"free participant index",
     "too many programs take part on this machine: end some, or give another --domain"},
    {"socket buffer size",
     "the system keeps packets for less long than it could: see 'tandem doctor'"},
    {"does not match an available interface",
     "the network interface is not there: see 'tandem doctor'"},
    {"failed to find interfaces", "this machine has no network: see 'tandem doctor'"},
    {"failed to bind", "a UDP port is taken by another program: give another with --port"},
    {"conn_write", "packets cannot be sent at the moment: see 'tandem doctor'"},
    {"sendmsg", "packets cannot be sent at the moment: see 'tandem doctor'"},
    {"recvmsg", "packets cannot be received at the moment: see 'tandem doctor'"},
    {"truncated", "a packet that is too long was dropped"},
    {"multicast", "multicast does not work here: name the others with --peers"},
    {"malformed", "a damaged or hostile packet was dropped"},
    {"deserialization", "a message that this version cannot read was dropped"},
    {"using network interface", "this machine has several networks: --interface chooses one"},
    {"", "the network layer reports a fault of an unknown kind: see 'tandem doctor'"},
}};
constexpr std::size_t kMaxKept = 100;
constexpr std::size_t kLongestMessage = 400;  // bytes

std::size_t MeaningOf(const std::string& message) {
  std::size_t i = 0;
  while (message.find(kMeanings[i].first) == std::string::npos) ++i;
  return i;
}

// Cyclone calls it from any of its threads, also the receive thread, so nothing here waits.
class CycloneLog {
 public:
  void Add(std::string line) {
    if (ExplainMessage(line).empty()) return;
    const std::scoped_lock lock(mutex_);
    if (capturing_) {
      if (kept_.size() >= kMaxKept) kept_.erase(kept_.begin());
      kept_.push_back(std::move(line));
    } else {
      Print(line);
    }
  }
  void Capture() {
    const std::scoped_lock lock(mutex_);
    capturing_ = true;
  }
  std::vector<std::string> Release() {
    const std::scoped_lock lock(mutex_);
    capturing_ = false;
    return std::exchange(kept_, {});
  }

 private:
  // A line that says how often says so of those that were not written.
  struct Said {
    bool ever = false;
    std::chrono::steady_clock::time_point at;
    long since = 0;
  };

  void Print(const std::string& line) {
    const std::size_t meaning = MeaningOf(line);
    Said& said = said_[meaning];
    const auto now = std::chrono::steady_clock::now();
    if (said.ever && now - said.at < kQuiet) {
      ++said.since;
      return;
    }
    const std::string often =
        said.since > 0 ? " (" + std::to_string(said.since) + " times since the last line)" : "";
    said = {true, now, 0};
    ReportDdsMessage(kMeanings[meaning].second + often);
  }

  std::mutex mutex_;
  bool capturing_ = false;
  std::vector<std::string> kept_;
  std::array<Said, kMeanings.size()> said_;
};

// Never destroyed, because Cyclone's threads may outlive main().
CycloneLog& Log() {
  static auto& log = *new CycloneLog;
  return log;
}

void OnCycloneMessage(void* /*unused*/, const dds_log_data_t* data) {
  std::string_view message = data->message;
  while (message.ends_with('\n') || message.ends_with(' ')) message.remove_suffix(1);
  // the message may contain a name that a stranger chose
  if (!message.empty()) Log().Add(PlainLine(message, kLongestMessage));
}

}  // namespace

std::string ExplainMessage(const std::string& message) {
  return kMeanings[MeaningOf(message)].second;
}

void ReportDdsMessage(const std::string& line) {
  StandardError().WriteLine("dds: " + line);
}

void RedirectCycloneLog() {
  StandardError();  // makes its thread here, not on one of Cyclone's
  dds_set_log_sink(&OnCycloneMessage, nullptr);
}

CycloneLogCapture::CycloneLogCapture() {
  Log().Capture();
}
CycloneLogCapture::~CycloneLogCapture() {
  for (std::string& line : Log().Release()) Log().Add(std::move(line));
}
std::string CycloneLogCapture::Take() {  // NOLINT(readability-convert-member-functions-to-static)
  const std::vector<std::string> kept = Log().Release();
  Log().Capture();
  return kept.empty() ? std::string() : kept.back();
}

}  // namespace tandem
