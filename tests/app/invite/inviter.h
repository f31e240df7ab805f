#pragma once

#include <array>
#include <atomic>
#include <ctime>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include "app/invite/enrolment_client.h"
#include "app/invite/enrolment_listener.h"
#include "app/invite/tls_endpoint.h"

namespace tandem::testing {

inline constexpr const char* kRequest = "a request";

inline bool OnLoopback(int socket, std::uint16_t port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  return bind(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
}

/// Runs an inviter on this machine in a thread. It signs whatever is asked: the signature is a word
/// and the request.
class Inviter {
 public:
  explicit Inviter(const std::string& session = "gear", std::time_t for_s = 600) {
    Result<EnrolmentListener> opened = EnrolmentListener::Open(0, false, OnLoopback);
    EXPECT_TRUE(opened);
    invitation.session = session;
    invitation.hosts = {"127.0.0.1"};
    invitation.secured = true;
    invitation.enrolment = {.port = opened->port(),
                            .until = std::time(nullptr) + for_s,
                            .secret = *NewSecret(),
                            .certificate = opened->certificate()};
    thread_ = std::thread([this, listener = *std::move(opened)]() mutable {
      end_ = listener.Serve(
          invitation, "ben",
          [this](const std::string& request) -> Result<MemberFiles> {
            ++signed_;
            if (request.empty()) return Error{"nothing to sign"};
            return MemberFiles{{"identity.pem", "signed: " + request}};
          },
          [this](const std::string& line) {
            const std::scoped_lock lock(mutex_);
            reported_ += line + "\n";
          },
          stop_);
    });
  }
  ~Inviter() { Stop(); }
  EnrolmentListener::End Stop() {
    stop_ = true;
    return Wait();
  }
  /// Waits until it ends by itself, and returns how it ended.
  EnrolmentListener::End Wait() {
    if (thread_.joinable()) thread_.join();
    return end_;
  }
  int times_signed() const { return signed_; }
  std::string reported() {
    const std::scoped_lock lock(mutex_);
    return reported_;
  }

  Invitation invitation;

 private:
  std::thread thread_;
  std::atomic<bool> stop_{false};
  std::atomic<int> signed_{0};
  std::mutex mutex_;
  std::string reported_;
  EnrolmentListener::End end_ = EnrolmentListener::End::kStopped;
};

/// A TCP connection to this machine.
class Caller {
 public:
  explicit Caller(std::uint16_t port) : socket_(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in at{};
    at.sin_family = AF_INET;
    at.sin_port = htons(port);
    at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(connect(socket_, reinterpret_cast<sockaddr*>(&at), sizeof at), 0);
  }
  ~Caller() { close(socket_); }
  Caller(const Caller&) = delete;
  Caller& operator=(const Caller&) = delete;

  int socket_now() const { return socket_; }
  void Send(const std::string& bytes) const {
    static_cast<void>(send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL));
  }
  /// Returns what comes within so long; nothing: the other end has hung up.
  std::optional<std::string> Receive(int wait_ms) const {
    pollfd wait{socket_, POLLIN, 0};
    if (poll(&wait, 1, wait_ms) <= 0) return "";
    std::array<char, 16384> buffer;
    const ssize_t size = recv(socket_, buffer.data(), buffer.size(), 0);
    if (size <= 0) return std::nullopt;
    return std::string(buffer.data(), static_cast<std::size_t>(size));
  }
  /// Shakes hands over TLS.
  TlsEndpoint Greet() const {
    TlsEndpoint tls = TlsEndpoint::Client();
    while (!tls.open() && !tls.failed()) {
      Send(tls.TakeToSend());
      const auto bytes = Receive(2000);
      if (!bytes || bytes->empty()) break;
      tls.Receive(*bytes);
    }
    Send(tls.TakeToSend());
    return tls;
  }

 private:
  int socket_;
};

/// Uses an invitation. Returns why that fails; empty: it does not.
inline std::string WhyNot(const Invitation& invitation,
                          std::optional<EnrolmentFault::Kind> kind = {}) {
  const EnrolmentOutcome outcome = Enrol(invitation, kRequest);
  if (!outcome.fault) return "";
  EXPECT_EQ(static_cast<int>(outcome.fault->kind),
            static_cast<int>(kind.value_or(outcome.fault->kind)));
  EXPECT_EQ(outcome.fault->what.find('\n'), std::string::npos);
  return outcome.fault->what;
}

}  // namespace tandem::testing
