#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <future>
#include <map>
#include <memory>
#include <mutex>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include <dlfcn.h>
#include <gtest/gtest.h>
#include <sys/socket.h>

#include "engine/base/sanitized.h"
#include "tests/network/in_process_peer.h"
#include "tests/network/real_peers.h"
#include "tests/network/running_program.h"

namespace {

// Keeps what this program's own peer sends: Cyclone finds this sendmsg before the system's. RTPS
// data of user topics are told apart by their writers, all else by where it goes and what it is
// made of.
using Clock = std::chrono::steady_clock;

/// Packets alike to one place: answers, heartbeats and signs of life come in steady beats.
struct Stream {
  std::vector<Clock::time_point> at;  // times of its packets

  /// Returns the rate of a beat as its packets are apart, so that it does not matter where in it a
  /// window began. Packets that come now and then count by the window. A machine that stands still
  /// makes some of a beat's packets late: then it is as fast as most of them are.
  double PerSecond(double window_s) const {
    constexpr std::size_t kLeast = 4;
    const auto packets = static_cast<double>(at.size());
    if (at.size() < kLeast || Seconds(at.front(), at.back()) < 0.5 * window_s) {
      return packets / window_s;
    }
    std::vector<double> apart;
    for (std::size_t i = 1; i < at.size(); ++i) apart.push_back(Seconds(at[i - 1], at[i]));
    const auto middle = apart.begin() + static_cast<std::ptrdiff_t>(apart.size() / 2);
    std::ranges::nth_element(apart, middle);
    // with more packets than the beat has, the mean is above it
    return std::max((packets - 1) / Seconds(at.front(), at.back()), 1 / *middle);
  }
  static double Seconds(Clock::time_point from, Clock::time_point to) {
    return std::chrono::duration<double>(to - from).count();
  }
};

struct Sent {
  std::map<std::uint32_t, long> samples;  // counts by writer
  std::map<std::string, Stream> others;   // packets without any: matching, heartbeats, acks
  double window_s = 0;

  double OthersPerSecond() const {
    double sum = 0;
    for (const auto& [kind, stream] : others) sum += stream.PerSecond(window_s);
    return sum;
  }
  std::string Table() const {
    std::ostringstream table;
    for (const auto& [kind, stream] : others) {
      table << stream.at.size() << " packets, " << stream.PerSecond(window_s)
            << " a second: " << kind << "\n";
    }
    return table.str();
  }
};

std::atomic<bool> counting = false;
std::mutex sent_mutex;
Sent sent;

constexpr std::size_t kHeader = 20;
constexpr unsigned char kHeartbeat = 0x07;
constexpr unsigned char kAckNack = 0x06;
constexpr unsigned char kInfoDestination = 0x0e;
constexpr unsigned char kData = 0x15;
constexpr std::size_t kWriterAt = 12;           // in a data submessage
constexpr unsigned char kBuiltInWriter = 0xc0;  // bits of an entity's kind
// announcements find new participants: every two seconds or so one to each port that a participant
// may have, in bursts of which a window of the test holds one or two
constexpr std::array<unsigned char, 4> kAnnouncer{0, 1, 0, 0xc2};

std::string Hex(const unsigned char* bytes, std::size_t count) {
  constexpr const char* kDigits = "0123456789abcdef";
  std::string text;
  for (std::size_t i = 0; i < count; ++i) {
    text += kDigits[bytes[i] / 16];
    text += kDigits[bytes[i] % 16];
  }
  return text;
}

/// Returns what tells streams apart in a submessage: its kind, and to whom or of which reader and
/// writer.
std::string KindOf(const unsigned char* submessage) {
  std::string kind = Hex(submessage, 1);
  if (submessage[0] == kData) kind += Hex(submessage + kWriterAt - 4, 8);
  if (submessage[0] == kHeartbeat || submessage[0] == kAckNack) kind += Hex(submessage + 4, 8);
  if (submessage[0] == kInfoDestination) kind += Hex(submessage + 4, 12);
  return kind;
}

void Count(const std::string& address, const std::vector<unsigned char>& packet) {
  const std::scoped_lock lock(sent_mutex);
  bool apart = false;
  std::string kind = address;
  for (std::size_t at = kHeader; at + kWriterAt + 4 <= packet.size();) {
    const std::size_t length = packet[at + 2] + 256U * packet[at + 3];
    const unsigned char* writer = &packet[at + kWriterAt];
    kind += ' ';
    kind += KindOf(&packet[at]);
    if (packet[at] == kData && (writer[3] & kBuiltInWriter) != kBuiltInWriter) {
      std::uint32_t id = 0;
      for (int i = 0; i < 4; ++i) id = 256U * id + writer[i];
      ++sent.samples[id];
      apart = true;
    }
    apart =
        apart || (packet[at] == kData && std::equal(kAnnouncer.begin(), kAnnouncer.end(), writer));
    if (length == 0) break;
    at += 4 + length;
  }
  if (apart) return;
  sent.others[kind].at.push_back(Clock::now());
}

}  // namespace

extern "C" ssize_t sendmsg(int socket, const msghdr* message, int flags) {
  static const auto real = reinterpret_cast<decltype(&sendmsg)>(dlsym(RTLD_NEXT, "sendmsg"));
  if (counting) {
    std::vector<unsigned char> packet;
    for (std::size_t i = 0; i < message->msg_iovlen; ++i) {
      const auto* bytes = static_cast<const unsigned char*>(message->msg_iov[i].iov_base);
      packet.insert(packet.end(), bytes, bytes + message->msg_iov[i].iov_len);
    }
    Count(Hex(static_cast<const unsigned char*>(message->msg_name), message->msg_namelen), packet);
  }
  return real(socket, message, flags);
}

namespace tandem {
namespace {

using testing::InProcessPeer;
using testing::Program;
using testing::RealPeers;

/// Viewers of the relay, until they go out of scope. Each has files of its own for its words and
/// its report.
class RelayViewers {
 public:
  RelayViewers(const std::string& session, int count) {
    for (int i = 0; i < count; ++i) {
      const std::vector<std::string> watch{TANDEM_PROGRAM, "watch",    "--from-relay",
                                           "--session",    session,    "--interface",
                                           "lo",           "--report", Report(i)};
      viewers_.push_back(std::make_unique<Program>(watch, File(i, ".txt")));
    }
  }
  /// Waits until each of them hears the test's own peer, by the relay.
  bool AllHearOwn() const {
    return std::ranges::all_of(viewers_, [](const auto& viewer) {
      return viewer->Says("own joined", 60);
    });
  }
  /// Ends them, and returns the least number of samples that one of them received.
  double LeastSamples() {
    for (const auto& viewer : viewers_) viewer->process().Signal(SIGTERM);
    double least = 1e9;
    for (std::size_t i = 0; i < viewers_.size(); ++i) {
      EXPECT_TRUE(viewers_[i]->Wait(60)) << viewers_[i]->output();
      std::ifstream stream(Report(static_cast<int>(i)));
      const nlohmann::json report = nlohmann::json::parse(stream, nullptr, false);
      least = std::min(least, report.is_object() ? report.at("samples").get<double>() : 0.0);
    }
    return least;
  }

 private:
  std::string File(int i, const char* ending) const {
    return (folder_.path() / ("viewer" + std::to_string(i) + ending)).string();
  }
  std::string Report(int i) const { return File(i, ".json"); }

  TemporaryFolder folder_;
  std::vector<std::unique_ptr<Program>> viewers_;
};

/// Returns how many viewers the machine can serve beside the peers: two for each processor. Four
/// show what one of them costs, because the peer sends some 17 packets a second besides samples.
/// TANDEM_RELAY_VIEWERS=32: another number.
int Viewers() {
  const char* requested = std::getenv("TANDEM_RELAY_VIEWERS");
  if (requested != nullptr) return std::atoi(requested);
  return std::clamp(2 * static_cast<int>(std::thread::hardware_concurrency()), 4, 32);
}

/// Returns the frames of a window: some ten beats of each stream. TANDEM_RELAY_SECONDS=40: a longer
/// one.
int WindowFrames() {
  const char* seconds = std::getenv("TANDEM_RELAY_SECONDS");
  return seconds == nullptr ? 3000 : 1000 * std::atoi(seconds);
}

/// Returns what the own peer sends in a window of frames, each as long as the program makes it.
Sent SentInAWindow(InProcessPeer& own) {
  {
    const std::scoped_lock lock(sent_mutex);
    sent = {};
  }
  const Clock::time_point begin = Clock::now();
  counting = true;
  own.StepFrames(WindowFrames());
  counting = false;
  const std::scoped_lock lock(sent_mutex);
  sent.window_s = std::chrono::duration<double>(Clock::now() - begin).count();
  return sent;
}

// A thread that is late has packets sent twice, by chance. The true figures are in two windows
// alike, which are looked for in so many at the most.
constexpr std::size_t kMostWindows = 8;

bool Alike(const Sent& a, const Sent& b) {
  // share of some 17 a second; one packet in a window is six times that
  constexpr double kAlike = 0.003;
  const double apart = std::abs(a.OthersPerSecond() - b.OthersPerSecond());
  return apart <= kAlike * std::min(a.OthersPerSecond(), b.OthersPerSecond());
}

/// Puts one more window to the others, of which the one with the least besides samples is the
/// first. Samples are the same in all.
void AddWindow(InProcessPeer& own, std::vector<Sent>& windows) {
  windows.push_back(SentInAWindow(own));
  EXPECT_EQ(windows.back().samples, windows.front().samples);
  std::ranges::sort(windows, {}, &Sent::OthersPerSecond);
}

/// Returns what is sent in the window with the least, which there should be twice.
Sent LeastSent(InProcessPeer& own) {
  std::vector<Sent> windows;
  AddWindow(own, windows);
  do {
    AddWindow(own, windows);
  } while (!Alike(windows[0], windows[1]) && windows.size() < kMostWindows);
  return windows[0];
}

/// Returns whether the own peer sends no more than that in two windows: the cost of viewers is in
/// every one. Adds the frames of its windows.
::testing::AssertionResult SendsNoMoreThan(const Sent& alone, InProcessPeer& own, long& frames) {
  const double most = 1.01 * alone.OthersPerSecond();
  std::vector<Sent> windows;
  const auto enough = [most](const Sent& lesser, const Sent& more) {
    return Alike(lesser, more) && lesser.OthersPerSecond() <= most;
  };
  while (windows.size() < kMostWindows) {
    AddWindow(own, windows);
    frames += WindowFrames();
    EXPECT_EQ(windows[0].samples, alone.samples);
    if (std::ranges::adjacent_find(windows, enough) != windows.end()) {
      return ::testing::AssertionSuccess();
    }
  }
  return ::testing::AssertionFailure()
         << windows[0].OthersPerSecond() << " against " << most << " a second; with viewers:\n"
         << windows[0].Table() << "without:\n"
         << alone.Table();
}

TEST(Relay, ActivePeersTrafficIsIndependentOfTheAudience) {
  if (tandem::kIsSanitized) GTEST_SKIP() << "what a sanitizer slows down is not sent in time";
  // longer than all windows take, on a machine that gives it half of its time
  RealPeers partner(
      {.count = 1, .seconds = 60.0 + 4e-3 * static_cast<double>(kMostWindows) * WindowFrames()});
  InProcessPeer own(partner.session(), 99, InProcessPeer::Stepped{});
  Result<ChildProcess> relay = ChildProcess::Start(
      {TANDEM_PROGRAM, "relay", "--session", partner.session(), "--interface", "lo"});
  ASSERT_TRUE(relay);
  ASSERT_TRUE(own.StepUntilCoupled());
  own.StepFrames(4000);  // all have met, and have said all that is said once

  const Sent alone = LeastSent(own);
  ASSERT_GE(alone.samples.size(), 3U);  // states with their links, view and peer_info
  std::vector<long> counts;
  for (const auto& [writer, count] : alone.samples) counts.push_back(count);
  std::sort(counts.begin(), counts.end());
  EXPECT_GE(counts.back(), WindowFrames());

  RelayViewers watching(partner.session(), Viewers());
  std::future<bool> watched = std::async(std::launch::async, [&watching] {
    return watching.AllHearOwn();
  });
  long frames = 0;
  while (watched.wait_for(std::chrono::seconds(0)) != std::future_status::ready) {
    own.StepFrames(100);
  }
  ASSERT_TRUE(watched.get()) << "a viewer hears nothing of the session";
  own.StepFrames(1000);
  EXPECT_TRUE(SendsNoMoreThan(alone, own, frames));
  // they do look on: in each thousand frames the peer sends 60 pictures, and so does its partner
  EXPECT_GE(watching.LeastSamples(), 0.5 * 60e-3 * static_cast<double>(frames));
  relay->Signal(SIGTERM);
  EXPECT_EQ(relay->Wait(std::chrono::seconds(10)), 0);
}

}  // namespace
}  // namespace tandem
