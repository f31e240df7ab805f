#include <algorithm>
#include <array>
#include <atomic>
#include <cstdlib>
#include <fstream>
#include <map>
#include <mutex>

#include <dlfcn.h>
#include <gtest/gtest.h>
#include <sys/socket.h>

#include "tests/network/own_peer.h"
#include "tests/network/real_peers.h"

namespace {

// What this program's own peer sends: Cyclone finds this sendmsg before the system's. RTPS data of
// user topics are told apart by their writers.
struct Sent {
  std::map<std::uint32_t, long> samples;  // by writer
  long others = 0;                        // packets without any: matching, heartbeats, acks
};

std::atomic<bool> counting = false;
std::mutex sent_mutex;
Sent sent;

constexpr std::size_t kHeader = 20;
constexpr unsigned char kData = 0x15;
constexpr std::size_t kWriterAt = 12;           // in a data submessage
constexpr unsigned char kBuiltInWriter = 0xc0;  // bits of an entity's kind
// what finds new participants: every two seconds or so one to each port that one may have, in
// bursts that a window of the test holds one or two of
constexpr std::array<unsigned char, 4> kAnnouncer{0, 1, 0, 0xc2};

void Count(const std::vector<unsigned char>& packet) {
  const std::scoped_lock lock(sent_mutex);
  bool apart = false;
  for (std::size_t at = kHeader; at + kWriterAt + 4 <= packet.size();) {
    const std::size_t length = packet[at + 2] + 256U * packet[at + 3];
    const unsigned char* writer = &packet[at + kWriterAt];
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
  if (!apart) ++sent.others;
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
    Count(packet);
  }
  return real(socket, message, flags);
}

namespace tandem {
namespace {

using testing::OwnPeer;
using testing::RealPeers;

/// Viewers of the relay, until they go out of scope; what each said is in a file of its own.
class RelayViewers {
 public:
  RelayViewers(const std::string& session, int count) {
    for (int i = 0; i < count; ++i) {
      Result<ChildProcess> viewer =
          ChildProcess::Start({TANDEM_PROGRAM, "watch", "--from-relay", "--session", session,
                               "--interface", "lo", "--report", Report(i).string()});
      if (viewer) viewers_.push_back(std::move(*viewer));
    }
  }
  /// Ends them; the least that one of them received.
  double LeastReceived() {
    double least = 1e9;
    for (ChildProcess& viewer : viewers_) viewer.Signal(SIGTERM);
    for (std::size_t i = 0; i < viewers_.size(); ++i) {
      EXPECT_EQ(viewers_[i].Wait(std::chrono::seconds(20)), 0);
      std::ifstream stream(Report(static_cast<int>(i)));
      const nlohmann::json report = nlohmann::json::parse(stream, nullptr, false);
      least = std::min(least, report.is_object() ? report.at("samples").get<double>() : 0.0);
    }
    return least;
  }

 private:
  std::filesystem::path Report(int i) const {
    return folder_.path() / ("viewer" + std::to_string(i) + ".json");
  }

  TemporaryFolder folder_;
  std::vector<ChildProcess> viewers_;
};

/// Of a window. One of two seconds has some 35 packets without a sample, so that "within 1 %" can
/// not be told from chance: it is held to no more than five beyond. TANDEM_RELAY_SECONDS=40 has
/// 700, and is held to 1 %.
int WindowFrames() {
  const char* seconds = std::getenv("TANDEM_RELAY_SECONDS");
  return seconds == nullptr ? 2000 : 1000 * std::atoi(seconds);
}
double MostOthers(long alone) {
  constexpr long kEnough = 500;
  const auto before = static_cast<double>(alone);
  return alone < kEnough ? before + 5 : 1.01 * before;
}

/// What the own peer sends in a window of frames, each as long as the program makes it.
Sent SentInAWindow(OwnPeer& own) {
  {
    const std::scoped_lock lock(sent_mutex);
    sent = {};
  }
  counting = true;
  own.StepFrames(WindowFrames());
  counting = false;
  const std::scoped_lock lock(sent_mutex);
  return sent;
}

TEST(Relay, AnActivePeerSendsTheSameHoweverManyLookOn) {
  RealPeers partner({.count = 1, .seconds = 60.0 + 4e-3 * WindowFrames()});
  OwnPeer own(partner.session(), 99, OwnPeer::Stepped{});
  Result<ChildProcess> relay = ChildProcess::Start(
      {TANDEM_PROGRAM, "relay", "--session", partner.session(), "--interface", "lo"});
  ASSERT_TRUE(relay);
  own.StepFrames(8000);  // all have met, and have said all that is said once

  const Sent alone = SentInAWindow(own);
  ASSERT_GE(alone.samples.size(), 3U);  // of state, link, view; peer_info too is a user's topic
  std::vector<long> counts;
  for (const auto& [writer, count] : alone.samples) counts.push_back(count);
  std::sort(counts.begin(), counts.end());
  EXPECT_GE(counts.back(), WindowFrames());

  for (const int viewers : {8, 32}) {
    RelayViewers watching(partner.session(), viewers);
    own.StepFrames(4000);
    const Sent watched = SentInAWindow(own);
    EXPECT_EQ(watched.samples, alone.samples) << viewers << " viewers";
    EXPECT_LE(static_cast<double>(watched.others), MostOthers(alone.others))
        << viewers << " viewers";
    // they do look on: 60 pictures a second of each of two peers
    EXPECT_GE(watching.LeastReceived(), 60.0) << viewers << " viewers";
  }
  relay->Signal(SIGTERM);
  EXPECT_EQ(relay->Wait(std::chrono::seconds(10)), 0);
}

}  // namespace
}  // namespace tandem
