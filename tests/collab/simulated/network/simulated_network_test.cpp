#include "collab/simulated/network/simulated_network.h"

#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "engine/base/units.h"

namespace tandem {
namespace {

// Notes what it is told, as lines of text with the time of the network.
class ReceivedLog : public Inbox {
 public:
  void OnState(const ObjectState& state, std::int64_t arrival_ns) override {
    lines.push_back("state " + std::to_string(state.seq));
    arrivals_ns.push_back(arrival_ns);
  }
  void OnLinks(const CouplingLinks&, std::int64_t) override { lines.emplace_back("links"); }
  void OnView(const ViewFrame&, std::int64_t) override { lines.emplace_back("view"); }
  void OnPeerInfo(const PeerInfo& info, std::int64_t) override {
    lines.push_back("info " + std::to_string(info.beat));
  }
  void OnPeerLeft(PeerId) override { lines.emplace_back("left"); }
  void OnPeerLost(PeerId) override { lines.emplace_back("lost"); }
  void OnEvent(const Event& event, std::int64_t) override {
    lines.push_back("event " + std::to_string(event.seq));
  }
  void OnScene(const SceneManifest& scene) override { lines.push_back("scene " + scene.name); }

  std::vector<std::string> Take() { return std::exchange(lines, {}); }

  std::vector<std::string> lines;
  std::vector<std::int64_t> arrivals_ns;
};

class SimulatedNetworkTest : public ::testing::Test {
 protected:
  SimulatedNetworkTest() { network.Advance(now_ns); }
  void Run(std::int64_t ms) {
    for (std::int64_t end = now_ns + ms * kMs; now_ns < end; now_ns += kMs) network.Advance(now_ns);
  }
  void Beat(std::uint32_t beat) {
    PeerInfo info;
    info.peer = 1;
    info.beat = beat;
    one->Publish(info);
  }
  void State(std::uint32_t seq) {
    ObjectState state;
    state.peer = 1;
    state.seq = seq;
    one->Publish(state);
  }

  SimulatedNetwork network;
  std::int64_t now_ns = 1000 * kMs;
  ReceivedLog first, second;
  std::unique_ptr<Transport> one = network.Join(1, Role::kActive, first);
  std::unique_ptr<Transport> two =
      network.Join(2, Role::kActive, second, {.offset_ns = 5'000'000'000, .drift_ppm = 100});
};

using Lines = std::vector<std::string>;

TEST_F(SimulatedNetworkTest, LateJoinerGetsTheNewestKeptSamples) {
  SceneManifest scene;
  scene.offered_by = 1;
  scene.name = "s";
  one->Publish(scene);
  Beat(1);
  Beat(2);
  Run(10);
  ReceivedLog third;
  const auto three = network.Join(3, Role::kActive, third);
  Run(10);
  EXPECT_EQ(third.Take(), (Lines{"scene s", "info 2"}));
}

TEST_F(SimulatedNetworkTest, LeaveArrivesAfterSentData) {
  network.link(1, 2).Switch({.delay_ms = 50});
  Beat(1);
  one->Leave();
  Run(49);
  EXPECT_EQ(second.Take(), Lines{});
  Run(200);
  EXPECT_EQ(second.Take(), (Lines{"info 1", "left"}));
  Run(3000);
  EXPECT_EQ(second.Take(), Lines{});
}

TEST_F(SimulatedNetworkTest, CrashIsNoticedAtLeaseExpiry) {
  Beat(1);
  Run(250);
  second.Take();
  one.reset();
  Run(450);
  EXPECT_EQ(second.Take(), Lines{});
  Run(250);
  EXPECT_EQ(second.Take(), Lines{"lost"});
}

TEST_F(SimulatedNetworkTest, CutIsOneWayAndDelaysReliableData) {
  Beat(1);
  Run(100);
  first.Take();
  second.Take();
  network.Cut(1, 2, true);
  State(1);
  Beat(2);
  Beat(3);
  Event event;
  event.peer = 1;
  event.seq = 7;
  one->Publish(event);
  ObjectState back;
  two->Publish(back);
  Run(500);
  EXPECT_EQ(first.Take(), Lines{"state 0"});
  EXPECT_EQ(second.Take(), Lines{});
  Run(700);
  EXPECT_EQ(second.Take(), Lines{"lost"});
  network.Cut(1, 2, false);
  State(2);
  Run(10);
  EXPECT_EQ(second.Take(), (Lines{"state 2", "info 3", "event 7"}));
}

TEST_F(SimulatedNetworkTest, ALongCutForgetsEvents) {
  Beat(1);
  Run(100);
  network.Cut(1, 2, true);
  Event event;
  event.peer = 1;
  event.seq = 7;
  one->Publish(event);
  Run(3000);
  second.Take();
  Beat(2);
  network.Cut(1, 2, false);
  Run(200);
  EXPECT_EQ(second.Take(), Lines{"info 2"});
}

TEST_F(SimulatedNetworkTest, ResumedPeerGetsTheNewestSamplesAndBrieflyLosesOthers) {
  Beat(1);
  Run(100);
  second.Take();
  network.Halt(2, true);
  for (std::uint32_t i = 1; i <= 20; ++i) State(i);
  Beat(2);
  Run(3000);
  EXPECT_EQ(second.Take(), Lines{});
  network.Halt(2, false);
  Run(2);
  Lines expected;
  for (int i = 13; i <= 20; ++i) expected.push_back("state " + std::to_string(i));
  expected.insert(expected.end(), {"lost", "info 2"});
  EXPECT_EQ(second.Take(), expected);
}

TEST_F(SimulatedNetworkTest, LossOfReliableDataDelaysInOrder) {
  network.link(1, 2).Switch({.loss = 0.5});
  for (std::uint32_t beat = 1; beat <= 50; ++beat) Beat(beat);
  Run(5000);
  Lines expected;
  for (int i = 1; i <= 50; ++i) expected.push_back("info " + std::to_string(i));
  EXPECT_EQ(second.Take(), expected);
}

TEST_F(SimulatedNetworkTest, ArrivalsAreStampedWithTheReceiversClock) {
  Run(1000);
  State(1);
  ASSERT_EQ(second.arrivals_ns.size(), 1U);
  const std::int64_t t = now_ns - kMs;  // time of the last Advance
  EXPECT_EQ(second.arrivals_ns[0], 5'000'000'000 + t + t / 10'000);
}

TEST_F(SimulatedNetworkTest, ViewersReceiveOnlyViewsAndActivePeersNone) {
  ReceivedLog viewer;
  const auto three = network.Join(3, Role::kViewer, viewer);
  ObjectState state;
  state.seq = 1;
  one->Publish(state, CouplingLinks{});
  one->Publish(ViewFrame{});
  EXPECT_EQ(second.Take(), (Lines{"state 1", "links"}));
  EXPECT_EQ(viewer.Take(), Lines{"view"});
}

}  // namespace
}  // namespace tandem
