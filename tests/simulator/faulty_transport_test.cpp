#include "tests/simulator/faulty_transport.h"

#include <algorithm>
#include <cmath>
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
constexpr PeerId kOther = 9;
constexpr std::int64_t kArrivalNs = 2'000'000'000;
constexpr std::int64_t kSampleNs = 1'000'000'000;

/// An inbox that notes what it hears, in words, and keeps the newest message of some kinds.
class NotedInbox : public Inbox {
 public:
  std::vector<std::string> received;
  ObjectState state;
  CouplingLinks links;
  PeerInfo info;

  void OnState(const ObjectState& new_state, std::int64_t) override {
    state = new_state;
    Note("state", state.peer);
  }
  void OnLinks(const CouplingLinks& new_links, std::int64_t) override {
    links = new_links;
    Note("links", links.from);
  }
  void OnView(const ViewFrame& frame, std::int64_t) override { Note("view", frame.peer); }
  void OnPeerInfo(const PeerInfo& new_info, std::int64_t) override {
    info = new_info;
    Note("info", info.peer);
  }
  void OnPeerLeft(PeerId peer) override { Note("left", peer); }
  void OnPeerLost(PeerId peer) override { Note("lost", peer); }
  void OnEvent(const Event& event, std::int64_t) override { Note("event", event.seq); }
  void OnScene(const SceneManifest& manifest) override { Note("scene", manifest.offered_by); }
  void OnSceneWithdrawn(PeerId peer) override { Note("withdrawn", peer); }
  void OnTwin(const PeerInfo& twin) override { Note("twin", twin.peer); }
  void OnDropped(PeerId from, Drop) override { Note("dropped", from); }

 private:
  void Note(const std::string& what, std::uint64_t of) {
    received.push_back(what + " " + std::to_string(of));
  }
};

/// One message of each kind from one peer: the state of a shared body in its hand, with a link.
struct Messages {
  explicit Messages(PeerId peer) {
    state.peer = peer;
    state.object = 2;
    state.epoch = 7;
    state.seq = 1999;
    state.sample_ns = kSampleNs;
    links.from = peer;
    links.object = 2;
    links.seq = 1999;
    links.count = 1;
    links.entries[0].to = kOther;
    links.entries[0].stiffness = 50;
    view.peer = peer;
    info.peer = peer;
    info.beat = 9;
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
    std::erase_if(all.received, [&](const std::string& line) {
      return std::ranges::find(inbox.received, line) != inbox.received.end();
    });
    return all.received;
  }

  /// Sends messages of most kinds from a peer with a fault; returns the inbox of another one.
  static NotedInbox InboxAfter(Fault fault, const Messages& messages) {
    SimulatedNetwork network;
    NotedInbox own;
    NotedInbox other;
    const auto transport = JoinWithFault(network, kPeer, own, {});
    const auto listener = network.Join(kOther, Role::kActive, other);
    injected_fault = fault;
    transport->Publish(messages.state);
    transport->Publish(messages.state, messages.links);
    transport->Publish(messages.info);
    transport->Publish(messages.event);
    transport->Publish(messages.scene);
    transport->Leave();
    network.Advance(kArrivalNs);
    return other;
  }

  static std::vector<std::string> HeardFromPeerWith(Fault fault) {
    return InboxAfter(fault, Messages(kPeer)).received;
  }

  /// Returns the state that another peer hears of what a peer with a fault holds.
  static ObjectState HeldStateWith(Fault fault, std::uint32_t seq = 1999) {
    Messages messages(kPeer);
    messages.state.seq = seq;
    return InboxAfter(fault, messages).state;
  }

  /// Returns the inbox of another peer after all messages with the state of a parked body.
  static NotedInbox InboxAfterParked(Fault fault) {
    Messages messages(kPeer);
    messages.state.flags = kStateParked;
    return InboxAfter(fault, messages);
  }

  /// Returns the links that another peer hears from a peer with a fault.
  static CouplingLinks LinksWith(Fault fault, std::uint32_t seq = 1999, ObjectId object = 2) {
    Messages messages(kPeer);
    messages.links.seq = seq;
    messages.links.object = object;
    return InboxAfter(fault, messages).links;
  }
};

TEST_F(FaultyTransportTest, ForwardsEverythingReceived) {
  EXPECT_THAT(LostBy(Fault::kNone), IsEmpty());
}

TEST_F(FaultyTransportTest, FaultsDropTheirSamples) {
  EXPECT_THAT(LostBy(Fault::kLostGoodbye), ElementsAre("left 8"));
  EXPECT_THAT(LostBy(Fault::kLostLease), ElementsAre("lost 8"));
  EXPECT_THAT(LostBy(Fault::kStatesDropped), ElementsAre("state 8"));
  EXPECT_THAT(LostBy(Fault::kLinksDropped), ElementsAre("links 8"));
}

TEST_F(FaultyTransportTest, ForwardsEverythingSent) {
  EXPECT_THAT(
      HeardFromPeerWith(Fault::kNone),
      ElementsAre("state 8", "state 8", "links 8", "info 8", "event 5", "scene 8", "left 8"));
}

TEST_F(FaultyTransportTest, FaultsAlterTheirSamples) {
  EXPECT_THAT(
      HeardFromPeerWith(Fault::kEventNumberStands),
      ElementsAre("state 8", "state 8", "links 8", "info 8", "event 1", "scene 8", "left 8"));
}

TEST_F(FaultyTransportTest, ChangesStatesOfWhatAPeerHolds) {
  EXPECT_NEAR(HeldStateWith(Fault::kTurnTooLong).X_WB.q.norm(), 1.01, 1e-12);
  EXPECT_EQ(InboxAfterParked(Fault::kTurnTooLong).state.X_WB.q.norm(), 1);
  EXPECT_EQ(HeldStateWith(Fault::kStampOfBefore, 1900).sample_ns, kSampleNs - 50'000'000);
  EXPECT_EQ(HeldStateWith(Fault::kStampOfBefore, 1999).sample_ns, kSampleNs);
}

TEST_F(FaultyTransportTest, ChangesStatesOfParkedBodies) {
  EXPECT_EQ(InboxAfterParked(Fault::kEpochOfBefore).state.epoch, 6U);
  EXPECT_EQ(HeldStateWith(Fault::kEpochOfBefore).epoch, 7U);
}

TEST_F(FaultyTransportTest, SendsNoStatesOfParkedBodies) {
  using ::testing::Contains;
  EXPECT_THAT(InboxAfterParked(Fault::kNone).received, Contains("state 8").Times(2));
  EXPECT_THAT(InboxAfterParked(Fault::kNoParkedPose).received, Contains("state 8").Times(1));
  EXPECT_THAT(HeardFromPeerWith(Fault::kNoParkedPose), Contains("state 8").Times(2));
}

TEST_F(FaultyTransportTest, ChangesStiffnessOnceASecond) {
  EXPECT_TRUE(std::isnan(LinksWith(Fault::kNotFinite).entries[0].stiffness));
  EXPECT_EQ(LinksWith(Fault::kNotFinite, 1998).entries[0].stiffness, 50);
  EXPECT_EQ(LinksWith(Fault::kNegativeStiffness).entries[0].stiffness, -1);
  EXPECT_EQ(LinksWith(Fault::kNegativeStiffness, 1998).entries[0].stiffness, 50);
}

TEST_F(FaultyTransportTest, ChangesTheEndsOfLinks) {
  EXPECT_EQ(LinksWith(Fault::kOthersName).from, kOther);
  EXPECT_EQ(LinksWith(Fault::kOthersName).entries[0].to, kOther);
  EXPECT_EQ(LinksWith(Fault::kLinkToItself).from, kPeer);
  EXPECT_EQ(LinksWith(Fault::kLinkToItself).entries[0].to, kPeer);
}

TEST_F(FaultyTransportTest, LeavesEchoesAloneAsTheyAre) {
  for (const Fault fault :
       {Fault::kNotFinite, Fault::kNegativeStiffness, Fault::kOthersName, Fault::kLinkToItself}) {
    const CouplingLinks links = LinksWith(fault, 1999, kNoObject);
    EXPECT_EQ(links.from, kPeer);
    EXPECT_EQ(links.entries[0].to, kOther);
    EXPECT_EQ(links.entries[0].stiffness, 50);
  }
}

TEST_F(FaultyTransportTest, StopsTheBeat) {
  EXPECT_EQ(InboxAfter(Fault::kNone, Messages(kPeer)).info.beat, 9U);
  EXPECT_EQ(InboxAfter(Fault::kBeatStands, Messages(kPeer)).info.beat, 1U);
}

TEST_F(FaultyTransportTest, JoinsAReceivingPeer) {
  SimulatedNetwork network;
  NotedInbox own;
  NotedInbox other;
  const auto transport = JoinWithFault(network, kPeer, own, {});
  const auto speaker = network.Join(kOther, Role::kActive, other);
  speaker->Publish(Messages(kOther).state);
  EXPECT_THAT(own.received, ElementsAre("state 9"));
}

}  // namespace
}  // namespace tandem
