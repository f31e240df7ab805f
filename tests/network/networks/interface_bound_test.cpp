#include <array>
#include <chrono>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <set>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <linux/if_ether.h>
#include <net/if.h>
#include <netinet/in.h>
#include <netinet/ip.h>
#include <netinet/udp.h>
#include <netpacket/packet.h>
#include <sys/socket.h>
#include <unistd.h>

#include "tests/network/networks/machines.h"
#include "tests/network/running_program.h"

// Packets of real programs are recorded, and sent again one way by each interface, as a stranger
// does that gets no answers.

namespace tandem {
namespace {

using std::chrono::milliseconds;
using testing::Machine;
using testing::Program;

using Bytes = std::vector<std::uint8_t>;

struct Recorded {
  std::uint16_t port = 0;
  Bytes packet;
};

/// Takes the program out of the packet that it is for, so that any program takes it (RTPS 2.5,
/// section 9.4.5.7).
void AddressToAll(Bytes& packet) {
  for (std::size_t at = 20; at + 4 <= packet.size();) {
    const std::size_t size = packet[at + 2] | static_cast<std::size_t>(packet[at + 3]) << 8U;
    if (packet[at] == 0x0E) std::fill_n(packet.begin() + static_cast<long>(at) + 4, 12, 0);
    if (size == 0) return;
    at += 4 + size;
  }
}

/// Records the packets of DDS on a machine's loopback.
class Recorder {
 public:
  explicit Recorder(const Machine& machine) {
    machine.Within([this] {
      socket_ = socket(AF_PACKET, SOCK_DGRAM | SOCK_CLOEXEC, htons(ETH_P_IP));
      // the peers send thousands of packets before they are read
      const int bytes = 64 << 20;
      setsockopt(socket_, SOL_SOCKET, SO_RCVBUFFORCE, &bytes, sizeof bytes);
      sockaddr_ll at{};
      at.sll_family = AF_PACKET;
      at.sll_protocol = htons(ETH_P_IP);
      at.sll_ifindex = static_cast<int>(if_nametoindex("lo"));
      bind(socket_, reinterpret_cast<const sockaddr*>(&at), sizeof at);
    });
  }
  ~Recorder() { close(socket_); }
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  std::vector<Recorded> Take() const {
    std::vector<Recorded> all;
    Bytes frame(65536);
    for (;;) {
      sockaddr_ll from{};
      socklen_t size = sizeof from;
      const ssize_t got = recvfrom(socket_, frame.data(), frame.size(), MSG_DONTWAIT,
                                   reinterpret_cast<sockaddr*>(&from), &size);
      if (got < 0) return all;
      // on loopback each packet is seen on its way out and on its way in
      if (from.sll_pkttype == PACKET_OUTGOING || got < 28 || frame[9] != IPPROTO_UDP) continue;
      const std::size_t head = 4U * (frame[0] & 15U);
      const std::size_t content = head + sizeof(udphdr);
      if (static_cast<std::size_t>(got) < content + 20) continue;
      if (std::memcmp(&frame[content], "RTPS", 4) != 0) continue;
      Recorded one;
      one.port = static_cast<std::uint16_t>(frame[head + 2] << 8U | frame[head + 3]);
      one.packet.assign(frame.begin() + static_cast<long>(content), frame.begin() + got);
      AddressToAll(one.packet);
      all.push_back(std::move(one));
    }
  }

 private:
  int socket_ = -1;
};

/// Sends packets to one address of a machine, from `sender`, and hears nothing.
void SendOneWay(const Machine& sender, const std::vector<Recorded>& packets, const char* address) {
  sender.Within([&] {
    const int out = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    sockaddr_in to{};
    to.sin_family = AF_INET;
    inet_pton(AF_INET, address, &to.sin_addr);
    for (const Recorded& one : packets) {
      to.sin_port = htons(one.port);
      sendto(out, one.packet.data(), one.packet.size(), 0, reinterpret_cast<const sockaddr*>(&to),
             sizeof to);
      std::this_thread::sleep_for(std::chrono::microseconds(200));
    }
    close(out);
  });
}

/// Returns the addresses that a process's UDP sockets are bound to, as the kernel lists them.
std::set<std::string> BoundTo(const std::string& pid) {
  std::set<std::string> inodes;
  std::error_code gone;
  for (const auto& file : std::filesystem::directory_iterator("/proc/" + pid + "/fd", gone)) {
    const std::string target = std::filesystem::read_symlink(file.path(), gone).string();
    if (target.rfind("socket:[", 0) == 0) inodes.insert(target.substr(8, target.size() - 9));
  }
  std::set<std::string> addresses;
  std::ifstream table("/proc/" + pid + "/net/udp");
  std::string line;
  std::getline(table, line);
  while (std::getline(table, line)) {
    std::istringstream words(line);
    std::vector<std::string> word;
    for (std::string one; words >> one;) word.push_back(one);
    if (word.size() > 9 && inodes.contains(word[9])) addresses.insert(word[1].substr(0, 8));
  }
  return addresses;
}

class InterfaceBound : public ::testing::Test {
 protected:
  void SetUp() override {
    for (const Machine* machine : {&here_, &there_}) {
      if (!machine->why_not().empty()) GTEST_SKIP() << machine->why_not();
    }
    ASSERT_TRUE(Link(here_, "lan", there_, "lan"));
    ASSERT_TRUE(Link(here_, "other", there_, "other"));
    ASSERT_TRUE(
        here_.Run("ip addr add 10.72.1.1/24 dev lan; ip link set lan up; "
                  "ip addr add 10.72.2.1/24 dev other; ip link set other up"));
    ASSERT_TRUE(
        there_.Run("ip addr add 10.72.1.2/24 dev lan; ip link set lan up; "
                   "ip addr add 10.72.2.2/24 dev other; ip link set other up"));
  }
  std::unique_ptr<Program> Peer(const Machine& machine, const std::string& name,
                                const std::string& interface,
                                const std::vector<std::string>& more = {}) {
    std::vector<std::string> words{
        TANDEM_PROGRAM, "peer",       "--session",
        session_,       "--scene",    std::string(TANDEM_SCENES) + "/peg_in_slot.json",
        "--interface",  interface,    "--name",
        name,           "--capacity", "20000",
        "--seconds",    "60"};
    words.insert(words.end(), more.begin(), more.end());
    const std::string output = (folder_.path() / (name + std::to_string(++programs_))).string();
    return std::make_unique<Program>(machine.At(words), output);
  }

  Machine here_;
  Machine there_;
  TemporaryFolder folder_;
  std::string session_ = "bound-" + std::to_string(getpid());
  int programs_ = 0;
};

TEST_F(InterfaceBound, WhatIsSentOneWayToAnotherAddressDoesNotReachASessionOnLoopback) {
  std::vector<Recorded> packets;
  {
    const Recorder recorder(here_);
    const auto first = Peer(here_, "first", "lo");
    const auto ghost = Peer(here_, "ghost", "lo");
    ASSERT_TRUE(first->Says("ghost joined")) << first->output();
    std::this_thread::sleep_for(milliseconds(1500));
    packets = recorder.Take();
    // no goodbye is recorded, and the crash is over before the next begins
    first->process().Signal(SIGKILL);
    ghost->process().Signal(SIGKILL);
  }
  ASSERT_GT(packets.size(), 20U);
  const auto victim = Peer(here_, "victim", "lo");
  ASSERT_TRUE(victim->Says("session")) << victim->output();
  std::this_thread::sleep_for(milliseconds(500));
  for (int i = 0; i < 2; ++i) {
    SendOneWay(here_, packets, "10.72.1.1");
    SendOneWay(there_, packets, "10.72.1.1");
  }
  std::this_thread::sleep_for(milliseconds(500));
  EXPECT_EQ(victim->output().find(" joined"), std::string::npos) << victim->output();
  // the same packets from loopback are a peer's: the recording is good
  for (int i = 0; i < 5 && !victim->Says(" joined", 0.5); ++i) {
    SendOneWay(here_, packets, "127.0.0.1");
  }
  EXPECT_TRUE(victim->Says(" joined", 5)) << victim->output();
}

TEST_F(InterfaceBound, NoAddressButLoopbacksReachesAController) {
  const auto peer = Peer(here_, "anna", "lo", {"--control", session_});
  ASSERT_TRUE(peer->Says("in session")) << peer->output();
  std::this_thread::sleep_for(milliseconds(500));
  const std::set<std::string> bound = BoundTo(std::to_string(peer->process().pid()));
  EXPECT_EQ(bound, std::set<std::string>{"0100007F"});
}

TEST_F(InterfaceBound, SessionOnOneInterfaceDoesNotHearAnother) {
  const auto here = Peer(here_, "here", "lan");
  const auto wrong = Peer(there_, "wrong", "other");
  const auto right = Peer(there_, "right", "lan");
  ASSERT_TRUE(here->Says("right joined")) << here->output();
  ASSERT_TRUE(right->Says("here joined")) << right->output();
  // unicast by the wrong interface, to either address
  const auto direct = Peer(there_, "direct", "other", {"--peers", "10.72.2.1,10.72.1.1"});
  ASSERT_TRUE(direct->Says("session")) << direct->output();
  std::this_thread::sleep_for(milliseconds(3000));
  for (const std::string name : {"wrong", "direct"}) {
    EXPECT_EQ(here->output().find(name), std::string::npos) << here->output();
  }
}

}  // namespace
}  // namespace tandem
