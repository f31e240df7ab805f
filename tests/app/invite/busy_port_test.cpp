#include <array>
#include <memory>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/app/invite/inviter.h"

// Tests a joiner whose inviter many others call.

namespace tandem {
namespace {

using testing::Caller;
using ::testing::HasSubstr;
using testing::Inviter;
using testing::OnLoopback;
using testing::WhyNot;
using End = EnrolmentListener::End;
using Kind = EnrolmentFault::Kind;

// Sixty-five idle connections of one address, as a scanner or a browser makes them.
TEST(BusyPortOfInvitations, IdleConnectionsKeepNoJoinerOut) {
  Inviter inviter;
  std::vector<std::unique_ptr<Caller>> idle;
  for (int i = 0; i < 65; ++i) {
    idle.push_back(std::make_unique<Caller>(inviter.invitation.enrolment.port));
  }
  EXPECT_EQ(WhyNot(inviter.invitation), "");
  EXPECT_EQ(inviter.Wait(), End::kUsed);
}

/// A port that closes the first connections at once, and leads the next one to another port.
class BusyPort {
 public:
  BusyPort(std::uint16_t leads_to, int closes) : socket_(socket(AF_INET, SOCK_STREAM, 0)) {
    EXPECT_TRUE(OnLoopback(socket_, 0) && listen(socket_, 8) == 0);
    thread_ = std::thread([this, leads_to, closes] {
      for (int i = 0; i < closes; ++i) close(accept(socket_, nullptr, nullptr));
      const int client = accept(socket_, nullptr, nullptr);
      if (client < 0) return;
      const Caller inviter(leads_to);
      Lead(client, inviter.socket_now());
      close(client);
    });
  }
  ~BusyPort() {
    shutdown(socket_, SHUT_RDWR);
    thread_.join();
    close(socket_);
  }
  BusyPort(const BusyPort&) = delete;
  BusyPort& operator=(const BusyPort&) = delete;
  std::uint16_t port() const {
    sockaddr_in at{};
    socklen_t size = sizeof at;
    getsockname(socket_, reinterpret_cast<sockaddr*>(&at), &size);
    return ntohs(at.sin_port);
  }

 private:
  /// Passes bytes both ways until one end hangs up.
  static void Lead(int one, int other) {
    for (;;) {
      std::array<pollfd, 2> waits{{{one, POLLIN, 0}, {other, POLLIN, 0}}};
      poll(waits.data(), waits.size(), -1);
      const bool from_one = waits[0].revents != 0;
      std::array<char, 4096> buffer;
      const ssize_t size = recv(from_one ? one : other, buffer.data(), buffer.size(), 0);
      if (size <= 0) return;
      send(from_one ? other : one, buffer.data(), static_cast<std::size_t>(size), MSG_NOSIGNAL);
    }
  }

  int socket_;
  std::thread thread_;
};

// An inviter that many call closes connections that it has not answered.
TEST(BusyPortOfInvitations, JoinerWhoseConnectionIsClosedTriesAgain) {
  Inviter inviter;
  const BusyPort busy(inviter.invitation.enrolment.port, 5);
  Invitation by_it = inviter.invitation;
  by_it.enrolment.port = busy.port();
  // the proof is of the line with the port, so the answer is a refusal
  EXPECT_THAT(WhyNot(by_it, Kind::kRefused), HasSubstr("is not the invitation that is open here"));
}

// They keep the connection after their refusal, for as long as the listener lets them.
TEST(BusyPortOfInvitations, RefusedClientsThatStayKeepNoJoinerOut) {
  Inviter inviter;
  std::vector<std::unique_ptr<Caller>> refused;
  for (std::size_t i = 0; i < EnrolmentListener::kMostConnections; ++i) {
    refused.push_back(std::make_unique<Caller>(inviter.invitation.enrolment.port));
    TlsEndpoint tls = refused.back()->Greet();
    ASSERT_TRUE(tls.open());
    tls.Say("no request\n");
    refused.back()->Send(tls.TakeToSend());
    ASSERT_TRUE(refused.back()->Receive(5000));
  }
  EXPECT_EQ(WhyNot(inviter.invitation), "");
}

}  // namespace
}  // namespace tandem
