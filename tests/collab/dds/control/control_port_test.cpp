#include "collab/dds/control/control_port.h"

#include <atomic>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <thread>

#include <gmock/gmock.h>

#include "collab/controller/controller.h"
#include "collab/dds/control/control_folder.h"
#include "collab/dds/control/control_packet.h"
#include "collab/dds/control/control_socket.h"
#include "collab/dds/wire/control_wire.h"
#include "engine/realtime/clock.h"
#include "tests/collab/controller/fake_peer.h"
#include "tests/support/scratch_folder.h"

// Talks to a controller's port in this program, by sound hosts and by packets of the tests' own.

namespace tandem {
namespace {

using Outcome = ControlConnection::Outcome;
using testing::FakePeer;
using testing::FourBodies;

tandem_control_Request RequestOf(HostId host, std::uint64_t number, const ControlRequest& request) {
  tandem_control_Request wire{};
  EXPECT_TRUE(ToWire(request, wire));
  wire.host = host;
  wire.number = number;
  wire.version = kControlVersion;
  return wire;
}

class ControlPortTest : public ::testing::Test {
 protected:
  ControlPortTest() {
    setenv("XDG_RUNTIME_DIR", scratch_.path().c_str(), 1);  // NOLINT(concurrency-mt-unsafe)
    Result<std::unique_ptr<ControlPort>> opened = ControlPort::Open("desk");
    EXPECT_TRUE(opened) << opened.error().what;
    port_ = *std::move(opened);
    server_.OnScene(FourBodies(), MonotonicNowNs());
    port_->Say(FourBodies(), false);
  }
  ControlConnection Connect() {
    Result<ControlConnection> made = ControlConnection::To(scratch_.path() / "tandem", "desk");
    EXPECT_TRUE(made) << made.error().what;
    return *std::move(made);
  }
  /// Lets the controller do what it does in a turn.
  void Turn() {
    port_->Wait(1'000'000);
    const std::int64_t now_ns = MonotonicNowNs();
    port_->Take(server_, now_ns);
    server_.OnFacts(peer_.facts, now_ns);
    for (const HostAnswer& answer : server_.TakeAnswers()) port_->Say(answer);
    port_->Say(server_.Snapshot());
  }
  /// Returns the numbers of the answers that have come over a connection.
  static std::vector<std::uint64_t> AnswersIn(ControlConnection& connection) {
    std::vector<std::uint64_t> numbers;
    std::vector<char> packet;
    while (connection.Receive(packet) == Outcome::kDone) {
      if (TopicOf(packet) != ControlTopic::kAnswer) continue;
      UsePacket<tandem_control_Answer>(packet, ControlTopic::kAnswer, [&](const auto& answer) {
        numbers.push_back(answer.number);
      });
    }
    return numbers;
  }

  ScratchFolder scratch_;
  FakePeer peer_;
  ControlServer server_{peer_, false};
  std::unique_ptr<ControlPort> port_;
};

TEST_F(ControlPortTest, ProgramThatSpeaksAsAnotherHostNeitherMutesItNorIsAnswered) {
  constexpr HostId kHost = 77;
  ControlConnection host = Connect();
  ControlConnection attacker = Connect();
  host.Send(PacketOf(RequestOf(kHost, 1, SnapshotRateRequest{})));
  Turn();
  EXPECT_THAT(AnswersIn(host), ::testing::ElementsAre(1));
  attacker.Send(
      PacketOf(RequestOf(kHost, std::numeric_limits<std::uint64_t>::max(), SnapshotRateRequest{})));
  tandem_control_Goal goodbye{};
  ToWire(HostGoal{.kind = HostGoal::Kind::kGoodbye}, goodbye);
  goodbye.host = kHost;
  attacker.Send(PacketOf(goodbye));
  Turn();
  EXPECT_EQ(port_->refused(), 2U);
  host.Send(PacketOf(RequestOf(kHost, 2, SnapshotRateRequest{})));
  Turn();
  EXPECT_THAT(AnswersIn(host), ::testing::ElementsAre(2));
  EXPECT_THAT(AnswersIn(attacker), ::testing::IsEmpty());
  // nor does a connection change the host as which it speaks
  host.Send(PacketOf(RequestOf(kHost + 1, 1, SnapshotRateRequest{})));
  Turn();
  EXPECT_EQ(port_->refused(), 3U);
}

TEST_F(ControlPortTest, DamagedPacketsAreRefusedAndChangeNothing) {
  ControlConnection host = Connect();
  const std::vector<char> sound = PacketOf(RequestOf(5, 1, QuitRequest{}));
  int sent = 0;
  for (std::size_t size = 1; size < sound.size(); ++size) {
    std::vector<char> damaged(sound.begin(), sound.begin() + static_cast<std::ptrdiff_t>(size));
    sent += host.Send(damaged) == Outcome::kDone ? 1 : 0;
    damaged = sound;
    damaged[size % 3] ^= static_cast<char>(size % 127 + 1);  // the mark of the interface
    sent += host.Send(damaged) == Outcome::kDone ? 1 : 0;
    Turn();
    AnswersIn(host);
  }
  EXPECT_EQ(port_->refused(), static_cast<std::uint64_t>(sent));
  EXPECT_GT(sent, 100);
  EXPECT_FALSE(peer_.quit);
  host.Send(sound);
  Turn();
  EXPECT_TRUE(peer_.quit);
}

TEST_F(ControlPortTest, HandOfAProcessThatEndsLetsGoAtOnce) {
  constexpr HostId kHost = 9;
  {
    ControlConnection host = Connect();
    host.Send(PacketOf(RequestOf(kHost, 1, GrabRequest{.body = "peg"})));
    for (int turns = 0; turns < 5; ++turns) Turn();
    ASSERT_EQ(peer_.facts.held, 0);
  }
  Turn();
  Turn();
  EXPECT_EQ(peer_.facts.held, -1) << "within two turns of a millisecond, not after 0.5 s";
}

TEST_F(ControlPortTest, ProgramThatReadsNothingIsDisconnectedAndTheOthersGoOn) {
  ControlConnection lazy = Connect();
  ControlConnection host = Connect();
  std::uint64_t number = 0;
  std::uint64_t lazy_sent = 0;
  std::uint64_t answered = 0;
  // some answers fill the socket, a megabyte of them the room before it
  for (int turns = 0; turns < 1000; ++turns) {
    for (int i = 0; i < 50; ++i) {
      if (lazy.Send(PacketOf(RequestOf(
              1, ++lazy_sent, GrabRequest{.body = std::string(60, 'x')}))) == Outcome::kGone) {
        turns = 1000;
        break;
      }
    }
    host.Send(PacketOf(RequestOf(2, ++number, SnapshotRateRequest{})));
    Turn();
    answered += AnswersIn(host).size();
  }
  EXPECT_EQ(lazy.Send(PacketOf(RequestOf(1, ++lazy_sent, SnapshotRateRequest{}))), Outcome::kGone);
  Turn();
  answered += AnswersIn(host).size();
  EXPECT_EQ(answered, number);
}

// Through the library that hosts use, with the controller's turns in another thread.
TEST_F(ControlPortTest, LibraryAttachesGrabsAndFindsTheNextControllerOfThatName) {
  std::atomic<bool> stop{false};
  std::thread turns([&] {
    while (!stop) Turn();
  });
  Result<Controller> host = Controller::Attach("desk");
  ASSERT_TRUE(host) << host.error().what;
  EXPECT_EQ(host->snapshot().bodies.size(), 4U);
  EXPECT_TRUE(host->Ask(GrabRequest{.body = "peg"}, 5).ok);
  stop = true;
  turns.join();
  port_.reset();
  const std::int64_t gone_ns = MonotonicNowNs();
  EXPECT_EQ(host->Ask(GrabRequest{.body = "peg"}, 10).reason, "the request could not be sent");
  EXPECT_LT(MonotonicNowNs() - gone_ns, 5'000'000'000);
  Result<std::unique_ptr<ControlPort>> next = ControlPort::Open("desk");
  ASSERT_TRUE(next) << next.error().what;
  port_ = *std::move(next);
  port_->Say(FourBodies(), false);
  stop = false;
  turns = std::thread([&] {
    while (!stop) Turn();
  });
  for (int i = 0; i < 500 && !host->attached(); ++i) host->Wait(std::chrono::milliseconds(10));
  EXPECT_TRUE(host->attached());
  EXPECT_TRUE(host->Ask(SnapshotRateRequest{}, 5).ok);
  stop = true;
  turns.join();
}

TEST_F(ControlPortTest, ControllerSeesAtMostItsPaceOfMessages) {
  ControlConnection host = Connect();
  tandem_control_Goal goal{};
  ToWire(HostGoal{}, goal);
  goal.host = 3;
  const std::vector<char> packet = PacketOf(goal);
  // some twenty thousand at once, and no more while the clock stands still
  const std::int64_t now_ns = MonotonicNowNs();
  for (int turns = 0; turns < 5000 && port_->refused() == 0; ++turns) {
    while (host.Send(packet) == Outcome::kDone) {
    }
    port_->Take(server_, now_ns);
  }
  EXPECT_GT(port_->refused(), 0U);
  // another program is heard meanwhile
  ControlConnection other = Connect();
  other.Send(PacketOf(RequestOf(4, 1, EmergencyStopRequest{})));
  Turn();
  EXPECT_TRUE(peer_.stopped);
}

}  // namespace
}  // namespace tandem
