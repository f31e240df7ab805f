#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include "collab/dds/diagnostics/path_messages.h"
#include "collab/dds/diagnostics/reachability.h"
#include "engine/realtime/clock.h"

namespace tandem::testing {

inline sockaddr_in AddressOf(const std::string& host, std::uint16_t port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  inet_pton(AF_INET, host.c_str(), &address.sin_addr);
  address.sin_port = htons(port);
  return address;
}

/// A line of the tests' own between a requester and a responder. It loses, delays, reorders and
/// doubles the samples that the test names, each way, and nothing else.
class Relay {
 public:
  /// The fate of a sample: its delays, none where it is lost.
  using Fate = std::vector<std::int64_t> (*)(std::uint32_t seq);

  Relay(const sockaddr_in& responder, Fate there, Fate back)
      : responder_(responder), there_(there), back_(back) {
    for (int* handle : {&front_, &rear_}) {
      *handle = socket(AF_INET, SOCK_DGRAM, 0);
      const sockaddr_in any = AddressOf("0.0.0.0", 0);
      bind(*handle, reinterpret_cast<const sockaddr*>(&any), sizeof any);
    }
    sockaddr_in own{};
    socklen_t size = sizeof own;
    getsockname(front_, reinterpret_cast<sockaddr*>(&own), &size);
    port_ = ntohs(own.sin_port);
    thread_ = std::thread([this] {
      Run();
    });
  }
  ~Relay() {
    stop_ = true;
    thread_.join();
    close(front_);
    close(rear_);
  }
  Relay(const Relay&) = delete;
  Relay& operator=(const Relay&) = delete;

  std::uint16_t port() const { return port_; }

 private:
  struct Held {
    int out;
    sockaddr_in to;
    std::vector<std::byte> bytes;
  };

  void Run() {
    while (!stop_) {
      std::array<pollfd, 2> wait{{{front_, POLLIN, 0}, {rear_, POLLIN, 0}}};
      poll(wait.data(), wait.size(), 1);
      std::array<std::byte, 2048> room{};
      sockaddr_in from{};
      socklen_t size = sizeof from;
      ssize_t got = 0;
      while ((got = recvfrom(front_, room.data(), room.size(), MSG_DONTWAIT,
                             reinterpret_cast<sockaddr*>(&from), &size)) >= 0) {
        requester_ = from;
        Hold(std::span(room).first(static_cast<std::size_t>(got)), rear_, responder_, there_);
      }
      while ((got = recv(rear_, room.data(), room.size(), MSG_DONTWAIT)) >= 0) {
        Hold(std::span(room).first(static_cast<std::size_t>(got)), front_, requester_, back_);
      }
      const std::int64_t now_ns = MonotonicNowNs();
      while (!held_.empty() && held_.begin()->first <= now_ns) {
        const Held& next = held_.begin()->second;
        sendto(next.out, next.bytes.data(), next.bytes.size(), 0,
               reinterpret_cast<const sockaddr*>(&next.to), sizeof next.to);
        held_.erase(held_.begin());
      }
    }
  }

  void Hold(std::span<const std::byte> packet, int out, const sockaddr_in& to, Fate fate) {
    const std::optional<PathSample> sample = MessageIn<PathSample>(packet);
    const bool counts = sample && sample->head.word == PathMessageKind::kSample;
    const std::vector<std::int64_t> delays =
        counts ? fate(sample->seq) : std::vector<std::int64_t>{0};
    for (const std::int64_t delay : delays) {
      held_.emplace(MonotonicNowNs() + delay, Held{out, to, {packet.begin(), packet.end()}});
    }
  }

  sockaddr_in responder_;
  Fate there_;
  Fate back_;
  int front_ = -1;
  int rear_ = -1;
  std::uint16_t port_ = 0;
  sockaddr_in requester_{};
  std::multimap<std::int64_t, Held> held_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

/// Runs a responder that answers while it lives. Its socket is of the network of the thread that
/// makes it.
class Answering {
 public:
  Answering()
      : responder_(*ProbeResponder::Open(0)), thread_([this] {
          while (!stop_) responder_.Answer(10);
        }) {}
  ~Answering() {
    stop_ = true;
    thread_.join();
  }
  Answering(const Answering&) = delete;
  Answering& operator=(const Answering&) = delete;
  std::uint16_t port() const { return responder_.port(); }

 private:
  std::atomic<bool> stop_{false};
  ProbeResponder responder_;
  std::thread thread_;
};

}  // namespace tandem::testing
