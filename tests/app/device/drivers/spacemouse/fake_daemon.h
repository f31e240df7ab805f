#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

namespace tandem::testing {

/// A daemon with spacenavd's protocol on a socket of the test's own, for one client at a time.
class FakeDaemon {
 public:
  using Packet = std::array<std::int32_t, 8>;

  /// `version` of the protocol: 0 or 1.
  FakeDaemon(const std::filesystem::path& socket, int version) : path_(socket), version_(version) {
    Listen();
  }
  ~FakeDaemon() { Die(); }

  void Die() {
    over_ = true;
    if (thread_.joinable()) thread_.join();
    std::filesystem::remove(path_);
  }
  void Rise() {
    over_ = false;
    Listen();
  }
  /// Sends an event in parts, `first` bytes and then the rest.
  void Send(const Packet& packet, std::size_t first = sizeof(Packet)) const {
    const int client = client_.load();
    const auto* bytes = reinterpret_cast<const char*>(packet.data());
    send(client, bytes, first, MSG_NOSIGNAL);
    if (first == sizeof packet) return;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    send(client, bytes + first, sizeof packet - first, MSG_NOSIGNAL);
  }
  void Motion(std::int32_t x, std::int32_t y, std::int32_t z, std::int32_t rx = 0,
              std::int32_t ry = 0, std::int32_t rz = 0) const {
    Send({0, x, y, z, rx, ry, rz, 8});
  }
  bool has_client() const { return client_.load() >= 0; }

  std::atomic<int> axes{6};                     // 0: no device
  std::atomic<bool> event_before_hello{false};  // a motion comes before the handshake's answer
  std::atomic<int> hello_ms{0};                 // duration of the handshake's answer
  std::atomic<bool> answers{true};              // it answers requests and the handshake
  std::atomic<bool> event_first{false};         // a motion comes before each answer
  std::atomic<float> sensitivity{0};            // sensitivity that a client of version 0 sent
  std::atomic<int> clients{0};

 private:
  void Listen() {
    const int listener = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strncpy(address.sun_path, path_.c_str(), sizeof address.sun_path - 1);
    bind(listener, reinterpret_cast<sockaddr*>(&address), sizeof address);
    listen(listener, 4);
    thread_ = std::thread([this, listener] {
      Serve(listener);
    });
  }
  static bool Readable(int socket) {
    pollfd wait{socket, POLLIN, 0};
    return poll(&wait, 1, 5) > 0;
  }
  void Serve(int listener) {
    std::string received;
    while (!over_) {
      if (Readable(listener)) {
        if (client_ >= 0) close(client_);
        client_ = accept(listener, nullptr, nullptr);
        ++clients;
        received.clear();
        is_new_ = true;
      }
      if (client_ < 0 || !Readable(client_)) continue;
      char buffer[256];
      const ssize_t size = recv(client_, buffer, sizeof buffer, MSG_DONTWAIT);
      if (size == 0) {
        close(client_);
        client_ = -1;
        continue;
      }
      if (size > 0) received.append(buffer, static_cast<std::size_t>(size));
      Answer(received);
    }
    if (client_ >= 0) close(client_);
    client_ = -1;
    close(listener);
  }
  void Answer(std::string& received) {
    if (is_new_ && received.size() >= 4) {
      is_new_ = false;
      std::int32_t hello = 0;
      std::memcpy(&hello, received.data(), 4);
      received.erase(0, 4);
      const std::int32_t answer = 0x7faa5500 | version_;
      if (event_before_hello) Motion(0, 350, 0);
      const int delay_ms = hello_ms.exchange(0);
      if (delay_ms > 0) std::this_thread::sleep_for(std::chrono::milliseconds(delay_ms));
      if (version_ > 0 && answers) send(client_, &answer, 4, MSG_NOSIGNAL);
    }
    if (version_ == 0 && received.size() >= 4) {
      float reported = 0;
      std::memcpy(&reported, received.data(), 4);
      sensitivity = reported;
      received.clear();
    }
    while (version_ > 0 && received.size() >= sizeof(Packet)) {
      Packet packet;
      std::memcpy(packet.data(), received.data(), sizeof packet);
      received.erase(0, sizeof packet);
      if (event_first) Motion(0, 350, 0);
      packet[1] = axes;
      packet[7] = axes > 0 ? 0 : -1;
      if (answers) Send(packet);
    }
  }

  std::filesystem::path path_;
  int version_;
  std::atomic<bool> over_{false};
  std::atomic<int> client_{-1};
  bool is_new_ = false;
  std::thread thread_;
};

}  // namespace tandem::testing
