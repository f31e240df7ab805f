// Packets of a plain socket, laid out as DDS never lays them out, against a running peer. The
// peer's own packets show whether it took an announcement: DDS greets every program that it takes
// for one, at the port that the announcement names.
#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include "tests/network/hostile/packet_fuzzer.h"
#include "tests/network/real_peers.h"
#include "tests/network/running_program.h"

namespace tandem {
namespace {

using testing::RealPeers;
using testing::TextOf;
using testing::UdpPortsOf;

constexpr std::uint32_t kEndless = 0x7FFFFFFF;  // s, a lease
constexpr std::uint32_t kAllEndpoints = 0xC3F;

class Octets {
 public:
  Octets& Number(std::uint64_t value, int bytes) {
    for (int i = 0; i < bytes; ++i) bytes_ += static_cast<char>(value >> (8 * i));
    return *this;
  }
  Octets& Text(std::string_view text) {
    bytes_ += text;
    return *this;
  }
  Octets& Zeros(std::size_t count) { return Text(std::string(count, '\0')); }
  Octets& Parameter(std::uint16_t id, const Octets& value) {
    std::string padded = value.bytes_;
    padded.resize((padded.size() + 3) / 4 * 4, '\0');
    return Number(id, 2).Number(padded.size(), 2).Text(padded);
  }
  /// Appends a submessage, little endian (RTPS 2.5, section 9.4.5.1).
  Octets& Submessage(std::uint8_t kind, std::uint8_t flags, const Octets& content) {
    return Number(kind, 1)
        .Number(flags | 1U, 1)
        .Number(content.bytes_.size(), 2)
        .Text(content.get());
  }
  const std::string& get() const { return bytes_; }

 private:
  std::string bytes_;
};

Octets IdOf(std::uint64_t program) {
  return Octets().Number(program, 8).Number(0x04030201, 4);
}

/// A socket of loopback, with a port of its own.
class LoopbackSocket {
 public:
  LoopbackSocket() : descriptor_(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in at = AddressOf(0);
    EXPECT_EQ(bind(descriptor_, reinterpret_cast<sockaddr*>(&at), sizeof at), 0);
    socklen_t size = sizeof at;
    getsockname(descriptor_, reinterpret_cast<sockaddr*>(&at), &size);
    port_ = ntohs(at.sin_port);
  }
  ~LoopbackSocket() { close(descriptor_); }
  LoopbackSocket(const LoopbackSocket&) = delete;
  LoopbackSocket& operator=(const LoopbackSocket&) = delete;

  std::uint16_t port() const { return port_; }
  void Send(const std::string& packet, std::uint16_t port) const {
    const sockaddr_in to = AddressOf(port);
    sendto(descriptor_, packet.data(), packet.size(), 0, reinterpret_cast<const sockaddr*>(&to),
           sizeof to);
  }
  /// Returns whether a packet from one of the ports has come, or comes within that time. Packets
  /// from others are dropped: a port that the system gives may have been a program's that has
  /// ended.
  bool Hears(const std::vector<std::uint16_t>& from, std::chrono::milliseconds within) const {
    const auto end = std::chrono::steady_clock::now() + within;
    for (;;) {
      const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(
          end - std::chrono::steady_clock::now());
      pollfd wait{descriptor_, POLLIN, 0};
      if (poll(&wait, 1, static_cast<int>(std::max(left.count(), 0L))) <= 0) return false;
      sockaddr_in sender{};
      socklen_t size = sizeof sender;
      char octet = 0;
      recvfrom(descriptor_, &octet, 1, 0, reinterpret_cast<sockaddr*>(&sender), &size);
      if (std::ranges::count(from, ntohs(sender.sin_port)) > 0) return true;
    }
  }

 private:
  static sockaddr_in AddressOf(std::uint16_t port) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address.sin_port = htons(port);
    return address;
  }

  int descriptor_;
  std::uint16_t port_ = 0;
};

/// Content of an announcement of a program (RTPS 2.5, section 8.5.3.2).
struct Announced {
  std::uint64_t sender = 0;  // sender of the packet
  std::uint64_t program = 0;
  std::uint16_t port = 0;  // port at which the program is to be greeted
  std::uint32_t lease_s = 10;
  std::uint32_t endpoints = kAllEndpoints;
};

/// Returns a packet of such an announcement behind other submessages.
std::string Packet(const Announced& announced, const std::string& session, const Octets& in_front) {
  const Octets locator = Octets()
                             .Number(1, 4)  // IPv4 over UDP
                             .Number(announced.port, 4)
                             .Zeros(12)
                             .Number(0x0100007F, 4);
  const std::string tag = "tandem/" + session;
  Octets list;
  list.Number(0x0300, 2).Number(0, 2);  // parameters, little endian
  list.Parameter(0x0015, Octets().Number(0x0502, 2).Number(0, 2));
  list.Parameter(0x0016, Octets().Number(0x1001, 2).Number(0, 2));
  list.Parameter(0x0050, IdOf(announced.program).Number(0xC1010000, 4));
  list.Parameter(0x0032, locator).Parameter(0x0031, locator);
  if (announced.endpoints != 0) list.Parameter(0x0058, Octets().Number(announced.endpoints, 4));
  if (announced.lease_s != 0) {
    list.Parameter(0x0002, Octets().Number(announced.lease_s, 4).Number(0, 4));
  }
  list.Parameter(0x4014, Octets().Number(tag.size() + 1, 4).Text(tag).Number(0, 1));
  list.Number(1, 2).Number(0, 2);
  Octets data;
  data.Number(0, 2).Number(16, 2).Number(0xC7000100, 4).Number(0xC2000100, 4);
  data.Number(0, 4).Number(1, 4).Text(list.get());
  return Octets()
      .Text("RTPS")
      .Number(0x10010502, 4)
      .Text(IdOf(announced.sender).get())
      .Text(in_front.get())
      .Submessage(0x15, 0x04, data)
      .get();
}

constexpr const char* kOfAnother = "another's INFO_SRC";

/// Returns what may stand in front of data, by name (RTPS 2.5, section 9.4.5).
std::map<std::string, Octets> WhatStandsInFront(std::uint64_t sender) {
  const Octets nothing;
  const Octets eight = Octets().Number(0x0102030405060708, 8);
  const Octets source = Octets().Zeros(4).Number(0x10010502, 4).Text(IdOf(sender).get());
  const Octets other = Octets().Zeros(4).Number(0x10010502, 4).Text(IdOf(~sender).get());
  const Octets locators =
      Octets().Number(1, 4).Number(1, 4).Number(9, 4).Zeros(12).Number(0x0100007F, 4);
  const auto of = [](std::uint8_t kind, const Octets& content, std::uint8_t flags = 0) {
    return Octets().Submessage(kind, flags, content);
  };
  Octets many;
  for (int i = 0; i < 40; ++i) many.Submessage(0x01, 0, nothing).Submessage(0x09, 0x02, nothing);
  return {{"nothing", nothing},
          {"an empty PAD", of(0x01, nothing)},
          {"a PAD", of(0x01, eight)},
          {"eighty empty ones", many},
          {"a big PAD", of(0x01, Octets().Zeros(1200))},
          {"an empty INFO_TS", of(0x09, nothing, 0x02)},
          {"an INFO_TS", of(0x09, eight)},
          {"an INFO_SRC", of(0x0C, source)},
          {kOfAnother, of(0x0C, other)},
          {"an INFO_REPLY_IP4", of(0x0D, eight)},
          {"an INFO_DST", of(0x0E, Octets().Zeros(12))},
          {"an INFO_REPLY", of(0x0F, locators)},
          {"an unknown one", of(0x02, eight)},
          {"a vendor's", of(0x80, eight)},
          {"Cyclone's", of(0x81, eight)},
          {"the last one there is", of(0xFF, eight)}};
}

TEST(HostilePackets, PrecedingSubmessagesDoNotHideAForgedAnnouncement) {
  const TemporaryFolder folder;
  const std::filesystem::path output = folder.path() / "said";
  RealPeers peers({.count = 1, .seconds = 3600, .output = output.string()});
  for (int i = 0; i < 1000 && TextOf(output).find("is in session") == std::string::npos; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  const std::vector<std::uint16_t> ports = UdpPortsOf(peers.peer(0).pid());
  ASSERT_FALSE(ports.empty());
  const LoopbackSocket out;
  const auto send = [&](const std::string& packet) {
    for (const std::uint16_t port : ports) out.Send(packet, port);
  };

  // A loaded machine loses packets: each round is sent again until the peer greets its sound one.
  constexpr int kRounds = 10;
  const LoopbackSocket of_forged;
  std::uint64_t number = 0x5000;
  long forged = 0;
  for (const auto& [name, unused] : WhatStandsInFront(0)) {
    const std::uint64_t sender = ++number;
    const Octets front = WhatStandsInFront(sender).at(name);
    // forgotten after a lease, or with the last of all, or by a program that nobody paces
    std::vector<Announced> bad = {{.lease_s = kEndless}, {.lease_s = 0}, {.endpoints = 0}};
    for (Announced& one : bad) one.program = sender;
    bad.push_back({.program = ++number});
    const LoopbackSocket of_sound;
    bool received = false;
    for (int round = 0; round < kRounds && !received; ++round) {
      for (Announced one : bad) {
        one.sender = sender;
        one.port = of_forged.port();
        send(Packet(one, peers.session(), front));
      }
      send(Packet({.sender = sender, .program = sender, .port = of_sound.port()}, peers.session(),
                  front));
      received = of_sound.Hears(ports, std::chrono::seconds(1));
    }
    // a packet that speaks for another program is refused whole
    EXPECT_EQ(received, name != kOfAnother) << name;
    forged += static_cast<long>(bad.size());
  }
  EXPECT_FALSE(of_forged.Hears(ports, std::chrono::milliseconds(200)))
      << "the peer took a forged one";

  peers.peer(0).Signal(SIGTERM);
  EXPECT_EQ(peers.Wait(), std::vector<int>{0});
  EXPECT_GE(peers.Report(0).at("packets_refused").at("forged").get<long>(), forged);
}

}  // namespace
}  // namespace tandem
