#include "collab/dds/cyclone/cyclone_log.h"

#include <array>
#include <chrono>
#include <mutex>
#include <string_view>
#include <utility>
#include <vector>

#include "collab/dds/cyclone/dds_api.h"
#include "engine/base/files/regular_file.h"
#include "engine/realtime/line_writer.h"

namespace tandem {
namespace {

constexpr int kLinesPerSecond = 3;  // and one line that counts the rest

// A part of Cyclone's message, and its meaning. The first that matches counts.
constexpr std::array<std::pair<const char*, const char*>, 12> kMeanings{{
    {"Certificate not valid", "somebody with keys of another session was refused"},
    {"PKCS7", "somebody's permissions, or our own, are not signed by the session's authority"},
    {"Could not get remote participant", "somebody's permissions were refused"},
    {"not allowed", "somebody tried what its permissions do not allow, and was refused"},
    {"Not Allowed By Security", "our own permissions do not allow this"},
    {"handshake", "somebody could not prove who it is"},
    {"free participant index", "too many programs take part on this machine"},
    {"socket buffer size", "the system keeps packets for less long than it could"},
    {"using network interface", "this machine has several networks; --interface chooses one"},
    {"multicast", "multicast does not work here; name the others with --peers"},
    {"malformed", "a damaged or hostile packet was dropped"},
    {"deserialization", "a message that this version cannot read was dropped"},
}};
constexpr std::size_t kMaxKept = 100;
constexpr std::size_t kLongestMessage = 400;  // bytes

// Cyclone calls it from any of its threads, also the receive thread, so nothing here waits.
class CycloneLog {
 public:
  void Add(std::string line) {
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
  void Print(const std::string& line) {
    const auto now = std::chrono::steady_clock::now();
    if (now - second_ >= std::chrono::seconds(1)) {
      if (dropped_ > 0) ReportDdsMessage("(" + std::to_string(dropped_) + " more messages)");
      second_ = now;
      printed_ = 0;
      dropped_ = 0;
    }
    if (printed_ < kLinesPerSecond) {
      ++printed_;
      ReportDdsMessage(ExplainMessage(line));
    } else {
      ++dropped_;
    }
  }

  std::mutex mutex_;
  bool capturing_ = false;
  std::vector<std::string> kept_;
  std::chrono::steady_clock::time_point second_;
  int printed_ = 0;
  long dropped_ = 0;
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
  for (const auto& [piece, meaning] : kMeanings) {
    if (message.find(piece) != std::string::npos) {
      return std::string(meaning) + " (" + message + ")";
    }
  }
  return "the network layer says: " + message;
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
