#include <algorithm>
#include <atomic>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <map>
#include <mutex>
#include <numeric>
#include <set>
#include <tuple>

#include <arpa/inet.h>
#include <dlfcn.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include "engine/base/units.h"
#include "engine/safety/force_guard.h"
#include "tests/network/hostile/packet_fuzzer.h"
#include "tests/network/in_process_peer.h"
#include "tests/network/real_peers.h"
#include "tests/support/machine/empty_loop.h"

namespace {

// Keeps what the test's own peer sends: Cyclone finds this program's sendmsg before the system's.
std::atomic<bool> keeping = false;
std::mutex kept_mutex;
std::vector<tandem::testing::Packet> kept;

}  // namespace

extern "C" ssize_t sendmsg(int socket, const msghdr* message, int flags) {
  static const auto real = reinterpret_cast<decltype(&sendmsg)>(dlsym(RTLD_NEXT, "sendmsg"));
  if (keeping) {
    tandem::testing::Packet packet;
    for (std::size_t i = 0; i < message->msg_iovlen; ++i) {
      const auto* bytes = static_cast<const unsigned char*>(message->msg_iov[i].iov_base);
      packet.insert(packet.end(), bytes, bytes + message->msg_iov[i].iov_len);
    }
    const std::scoped_lock lock(kept_mutex);
    kept.push_back(std::move(packet));
  }
  return real(socket, message, flags);
}

namespace tandem {
namespace {

using testing::InProcessPeer;
using testing::Packet;
using testing::PacketFuzzer;
using testing::RealPeers;

/// Returns as many as a quiet machine sends in so many seconds.
long FuzzPackets() {
  const char* seconds = std::getenv("TANDEM_FUZZ_SECONDS");
  return static_cast<long>(40'000 * (seconds != nullptr ? std::stod(seconds) : 5));
}

/// Returns one packet of each length and first submessages: thousands of packets differ in their
/// numbers only.
std::vector<Packet> Kinds(const std::vector<Packet>& packets) {
  std::map<std::vector<unsigned>, Packet> kinds;
  for (const Packet& packet : packets) {
    std::vector<unsigned> kind{static_cast<unsigned>(packet.size())};
    for (std::size_t at = 20; at + 4 <= packet.size() && kind.size() < 8;) {
      kind.push_back(packet[at]);
      at += 4U + packet[at + 2] + 256U * packet[at + 3];
    }
    kinds[kind] = packet;
  }
  std::vector<Packet> one_each;
  for (const auto& [kind, packet] : kinds) one_each.push_back(packet);
  return one_each;
}

constexpr unsigned char kAcknowledgement = 0x06, kHeartbeat = 0x07, kData = 0x15;

/// Returns what was said, however it was packed: each kind of submessage with whom it is of and
/// for. How many go into one packet depends on the machine's load, and so does the number of kinds
/// of packets.
std::set<std::vector<unsigned char>> Contents(const std::vector<Packet>& packets) {
  constexpr unsigned char kFirstWithEntities = kAcknowledgement;
  constexpr unsigned char kInfoTimestamp = 0x09, kInfoDestination = 0x0e;
  std::set<std::vector<unsigned char>> contents;
  for (const Packet& packet : packets) {
    for (std::size_t at = 20; at + 4 <= packet.size();) {
      const unsigned char kind = packet[at];
      const std::size_t length = packet[at + 2] + 256U * packet[at + 3];
      std::vector<unsigned char> one{kind};
      // data has two fields before its reader and writer
      const std::size_t entities = at + 4 + (kind == kData ? 4 : 0);
      if (kind >= kFirstWithEntities && kind != kInfoTimestamp && kind != kInfoDestination &&
          entities + 8 <= packet.size()) {
        const auto begin = packet.begin() + static_cast<std::ptrdiff_t>(entities);
        one.insert(one.end(), begin, begin + 8);
      }
      contents.insert(one);
      if (length == 0) break;
      at += 4 + length;
    }
  }
  return contents;
}

/// Sends so many bad packets to the ports in turn, forty a millisecond or as many as the machine
/// lets it.
void Fuzz(const std::vector<Packet>& good, const std::vector<std::uint16_t>& ports, long packets) {
  const int out = socket(AF_INET, SOCK_DGRAM, 0);
  PacketFuzzer fuzzer(good, 1);
  std::int64_t next_ns = MonotonicNowNs();
  for (long sent = 0; sent < packets; ++sent) {
    if (sent % 40 == 0) MachineClock().SleepUntil(next_ns += 1'000'000);
    const Packet& packet = fuzzer.Next();
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    to.sin_port = htons(ports[static_cast<std::size_t>(sent) % ports.size()]);
    sendto(out, packet.data(), packet.size(), 0, reinterpret_cast<const sockaddr*>(&to), sizeof to);
  }
  close(out);
}

/// Counts lines about the network. What the peers say of bodies and users is not counted.
long NetworkLinesOf(const std::filesystem::path& file) {
  std::ifstream stream(file);
  long lines = 0;
  for (std::string line; std::getline(stream, line);) lines += line.starts_with("dds: ") ? 1 : 0;
  return lines;
}

TEST(Fuzz, SessionSurvivesInvalidPacketsAtEveryPort) {
  constexpr double kLongEnough = 3600;  // s: they are ended
  const TemporaryFolder folder;
  const std::filesystem::path output = folder.path() / "said";
  RealPeers peers({.count = 2, .seconds = kLongEnough, .output = output.string()});

  // everything that is sent from the first packet on: discovery, matching, motion, membership,
  // scene
  keeping = true;
  InProcessPeer own(peers.session(), 0x1234567890abcdef);
  own.Run(3, [] {
    return false;
  });
  keeping = false;
  std::vector<Packet> good;
  {
    const std::scoped_lock lock(kept_mutex);
    good = Kinds(kept);
    const auto contents = Contents(kept);
    const auto of = [&](unsigned char kind) {
      return std::count_if(contents.begin(), contents.end(), [kind](const auto& one) {
        return one.front() == kind;
      });
    };
    EXPECT_GE(of(kData), 7);             // discovery's four, and three topics' or more
    EXPECT_GE(of(kHeartbeat), 7);        // those of reliable writers
    EXPECT_GE(of(kAcknowledgement), 7);  //
  }

  std::vector<std::uint16_t> ports = testing::UdpPortsOf(peers.peer(0).pid());
  ASSERT_GE(ports.size(), 2U);
  const std::vector<std::uint16_t> others = testing::UdpPortsOf(peers.peer(1).pid());
  ports.insert(ports.end(), others.begin(), others.end());

  const long lines_before = NetworkLinesOf(output);
  const std::int64_t begin_ns = MonotonicNowNs();
  std::atomic<bool> done = false;
  testing::EmptyLoop empty;
  std::thread fuzz([&] {
    Fuzz(good, ports, FuzzPackets());
    done = true;
  });
  own.Run(kLongEnough, [&done] {
    return done.load();
  });
  fuzz.join();
  const double machine_missed = empty.End();
  const long lines = NetworkLinesOf(output) - lines_before;
  const double elapsed_s = ToSeconds(MonotonicNowNs() - begin_ns);

  for (std::size_t i = 0; i < 2; ++i) peers.peer(i).Signal(SIGTERM);
  EXPECT_EQ(peers.Wait(), (std::vector<int>{0, 0}));
  // each of two programs prints ten lines in a window of a second or longer; the time touches the
  // windows that begin in it, at most one more than it has seconds, and the one before
  EXPECT_GT(lines, 0);
  EXPECT_LE(static_cast<double>(lines), 2 * 10 * (elapsed_s + 2));
  for (std::size_t i = 0; i < 2; ++i) {
    const nlohmann::json report = peers.Report(i);
    ASSERT_TRUE(report.is_object());
    // the hand goes on in real time
    EXPECT_LE(report.at("judged_missed").get<double>(),
              (0.1 + 2 * std::min(machine_missed, 0.2)) * report.at("judged_frames").get<double>());
    // the hand's spring, before anything guards the hand: bad packets do not move the body
    EXPECT_LE(report.at("peak_force_N").get<double>(), 20.0);
    const nlohmann::json& felt = report.at("felt");
    EXPECT_GT(felt.at("peak_N").get<double>(), 0.0);
    EXPECT_LE(felt.at("peak_N").get<double>(), 1.000001 * DeviceLimits{}.force);
    EXPECT_LE(felt.at("peak_Nm").get<double>(), 1.000001 * DeviceLimits{}.moment);
    EXPECT_LE(felt.at("peak_step_N").get<double>(), 1.000001 * ForceGuard::kForceStep);
    EXPECT_GT(report.at("delay_ms").get<double>(), 0);
  }
}

}  // namespace
}  // namespace tandem
