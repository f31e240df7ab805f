#include "tests/simulator/faulty_transport.h"

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/simulator/injected_faults.h"

namespace tandem {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr PeerId kPeer = 8;
constexpr std::int64_t kArrivalNs = 2'000'000'000;

/// An inbox that notes what it hears, in words.
class NotedInbox : public Inbox {
 public:
  std::vector<std::string> heard;

  void OnState(const ObjectState& state, std::int64_t) override { Note("state", state.peer); }
  void OnLinks(const CouplingLinks& links, std::int64_t) override { Note("links", links.from); }
  void OnView(const ViewFrame& frame, std::int64_t) override { Note("view", frame.peer); }
  void OnPeerInfo(const PeerInfo& info, std::int64_t) override { Note("info", info.peer); }
  void OnPeerLeft(PeerId peer) override { Note("left", peer); }
  void OnPeerLost(PeerId peer) override { Note("lost", peer); }
  void OnEvent(const Event& event, std::int64_t) override { Note("event", event.seq); }
  void OnScene(const SceneManifest& manifest) override { Note("scene", manifest.offered_by); }
  void OnSceneWithdrawn(PeerId peer) override { Note("withdrawn", peer); }
  void OnTwin(const PeerInfo& info) override { Note("twin", info.peer); }
  void OnDropped(PeerId from, Drop) override { Note("dropped", from); }

 private:
  void Note(const std::string& what, std::uint64_t of) {
    heard.push_back(what + " " + std::to_string(of));
  }
};

/// One message of each kind from one peer.
struct Messages {
  explicit Messages(PeerId peer) {
    state.peer = peer;
    links.from = peer;
    view.peer = peer;
    info.peer = peer;
    event.peer = peer;
    event.seq = 5;
    scene.offered_by = peer;
  }
  ObjectState state;
  CouplingLinks links;
  ViewFrame view;
  PeerInfo info;
  Event event;
  SceneManifest scene;
};

/// Hears each kind of message once.
void HearAll(Inbox& inbox) {
  const Messages messages(kPeer);
  inbox.OnState(messages.state, kArrivalNs);
  inbox.OnLinks(messages.links, kArrivalNs);
  inbox.OnView(messages.view, kArrivalNs);
  inbox.OnPeerInfo(messages.info, kArrivalNs);
  inbox.OnPeerLeft(kPeer);
  inbox.OnPeerLost(kPeer);
  inbox.OnEvent(messages.event, kArrivalNs);
  inbox.OnScene(messages.scene);
  inbox.OnSceneWithdrawn(kPeer);
  inbox.OnTwin(messages.info);
  inbox.OnDropped(kPeer, Drop::kRingFull);
}

class FaultyTransportTest : public ::testing::Test {
 protected:
  ~FaultyTransportTest() override { injected_fault = Fault::kNone; }

  /// Returns what a peer does not hear that hears each kind of message once, with a fault.
  static std::vector<std::string> LostBy(Fault fault) {
    NotedInbox all;
    HearAll(all);
    NotedInbox inbox;
    FaultyInbox faulty(inbox);
    injected_fault = fault;
    HearAll(faulty);
    std::erase_if(all.heard, [&](const std::string& line) {
      return std::ranges::find(inbox.heard, line) != inbox.heard.end();
    });
    return all.heard;
  }

  /// Sends messages of most kinds from a peer with a fault; returns what another one hears.
  static std::vector<std::string> HeardFromPeerWith(Fault fault) {
    SimulatedNetwork network;
    NotedInbox own;
    NotedInbox other;
    const auto transport = JoinWithFault(network, kPeer, own, {});
    const auto listener = network.Join(kPeer + 1, Role::kActive, other);
    injected_fault = fault;
    const Messages messages(kPeer);
    transport->Publish(messages.state);
    transport->Publish(messages.state, messages.links);
    transport->Publish(messages.info);
    transport->Publish(messages.event);
    transport->Publish(messages.scene);
    transport->Leave();
    network.Advance(kArrivalNs);
    return other.heard;
  }
};

TEST_F(FaultyTransportTest, HandsOnAllThatAPeerHears) {
  EXPECT_THAT(LostBy(Fault::kNone), IsEmpty());
}

TEST_F(FaultyTransportTest, LosesWhatAFaultIsAbout) {
  EXPECT_THAT(LostBy(Fault::kLostGoodbye), ElementsAre("left 8"));
  EXPECT_THAT(LostBy(Fault::kLostLease), ElementsAre("lost 8"));
  EXPECT_THAT(LostBy(Fault::kStatesDropped), ElementsAre("state 8"));
  EXPECT_THAT(LostBy(Fault::kLinksDropped), ElementsAre("links 8"));
}

TEST_F(FaultyTransportTest, SendsAllThatAPeerSays) {
  EXPECT_THAT(
      HeardFromPeerWith(Fault::kNone),
      ElementsAre("state 8", "state 8", "links 8", "info 8", "event 5", "scene 8", "left 8"));
}

TEST_F(FaultyTransportTest, ChangesWhatAFaultIsAbout) {
  EXPECT_THAT(
      HeardFromPeerWith(Fault::kEventNumberStands),
      ElementsAre("state 8", "state 8", "links 8", "info 8", "event 1", "scene 8", "left 8"));
}

TEST_F(FaultyTransportTest, JoinsAPeerThatHears) {
  SimulatedNetwork network;
  NotedInbox own;
  NotedInbox other;
  const auto transport = JoinWithFault(network, kPeer, own, {});
  const auto speaker = network.Join(kPeer + 1, Role::kActive, other);
  speaker->Publish(Messages(kPeer + 1).state);
  EXPECT_THAT(own.heard, ElementsAre("state 9"));
}

}  // namespace
}  // namespace tandem
