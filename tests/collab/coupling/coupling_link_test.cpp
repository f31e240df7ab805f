#include "collab/coupling/coupling_link.h"

#include <memory>

#include <gtest/gtest.h>

#include "engine/base/units.h"
#include "tests/support/allocation_counter.h"

namespace tandem {
namespace {

using LinkState = CouplingLink::State;

constexpr PeerId kNearEnd = 1;
constexpr PeerId kFarEnd = 2;

/// One link by itself, with what SharedBody would keep for it. The peer's instance stands still,
/// `place_m` from ours along x.
struct OneLink {
  /// Brings a state of the peer.
  void HearState() {
    ObjectState state;
    state.peer = kFarEnd;
    state.epoch = 1;
    state.seq = ++seq;
    state.sample_ns = 7'000'000'000 + now;  // another clock
    state.X_WB.p.x() = place_m;
    link.OnState(state);
  }

  /// Brings links of the peer with an echo of our stamp of `age_ms` ago; returns how many echoes
  /// are refused.
  std::size_t HearLinks(std::int64_t age_ms, double its_stiffness) {
    CouplingLinks links;
    links.from = kFarEnd;
    links.seq = ++seq;
    links.count = 1;
    links.entries[0].to = kNearEnd;
    links.entries[0].echo_ns = now - age_ms * kMs;
    links.entries[0].stiffness = its_stiffness;
    return link.OnLinks(links, kNearEnd, sent);
  }

  /// Runs a frame in which nothing comes.
  void Frame() {
    const std::int64_t last = now;
    now += kMs;
    link.Measure(now, last);
    if (link.received()) {
      const LinkFrame frame{.now_ns = now, .own = own, .per_mass = per_mass, .experiments = {}};
      const LawInputs common = LawInputsAt(link.peak_loop_age_s(), 2, 1.5);
      allowed = law->Link(common).stiffness;
      SharedStiffness shared{.law = *law,
                             .common = common,
                             .allowed = law->Link(common),
                             .longest_loop_age_s = link.peak_loop_age_s()};
      shared.most = allowed;
      if (link.closed()) shared.sum = link.stiffness();
      link.MoveCopy(frame);
      link.Slew(frame, shared);
      link.Couple(frame, coupling);
    }
    sent.Add(now);
  }

  /// Runs frames in which state and links come, with a loop of 20 ms.
  void Frames(int count, double its_stiffness = 50) {
    for (int i = 0; i < count; ++i) {
      HearState();
      HearLinks(20, its_stiffness);
      Frame();
    }
  }

  OneLink() {
    for (int i = 0; i < 100; ++i) Frame();  // stamps that may be echoed
  }

  double place_m = 0.001;
  CouplingLink link;
  SentStamps sent;
  std::shared_ptr<const CouplingLaw> law = DefaultLaw();
  RigidState own;
  Mat3 per_mass = 1e-3 * Mat3::Identity();
  StepInputs::Link coupling;
  double allowed = 0;  // N/m, by the law in the last frame
  std::int64_t now = 1000 * kMs;
  std::uint32_t seq = 0;
};

TEST(CouplingLink, ListensUntilBothPeersHaveHeardEachOther) {
  OneLink received;
  EXPECT_EQ(received.link.state(), LinkState::kListening);
  EXPECT_EQ(received.link.newest(), nullptr);
  received.HearState();
  EXPECT_EQ(received.link.state(), LinkState::kListening);
  EXPECT_TRUE(received.link.received());
  received.HearLinks(20, 50);
  EXPECT_EQ(received.link.state(), LinkState::kRising);

  OneLink hearing;
  hearing.HearLinks(20, 50);
  EXPECT_EQ(hearing.link.state(), LinkState::kListening);
  EXPECT_FALSE(hearing.link.received());
  hearing.HearState();
  EXPECT_EQ(hearing.link.state(), LinkState::kRising);
}

TEST(CouplingLink, HasNoStiffnessWhileListening) {
  OneLink one;
  for (int i = 0; i < 100; ++i) {
    one.HearState();
    one.Frame();
  }
  EXPECT_EQ(one.link.state(), LinkState::kListening);
  EXPECT_EQ(one.link.stiffness(), 0);
  EXPECT_EQ(one.link.Describe(kFarEnd).stiffness, 0);
}

TEST(CouplingLink, IsEstablishedOnceItUsesTheSmallerOffer) {
  OneLink one;
  int rising = 0;
  while (one.link.state() != LinkState::kEstablished && rising < 5000) {
    EXPECT_LT(one.link.stiffness(), 50);
    one.Frames(1);
    ++rising;
  }
  EXPECT_GT(rising, 100);  // at most 400 N/m a second
  EXPECT_EQ(one.link.stiffness(), 50);
  one.Frames(1000, 1e6);
  EXPECT_EQ(one.link.state(), LinkState::kEstablished);
  EXPECT_LE(one.link.stiffness(), one.allowed);
}

// the law forbids no more than what the peer offers: a twentieth of the goal is a link that begins
TEST(CouplingLink, RestartsItsRiseBelowATwentiethOfTheLimit) {
  OneLink one;
  one.Frames(2000, 2);
  ASSERT_EQ(one.link.state(), LinkState::kEstablished);
  one.Frames(1, 39);
  EXPECT_EQ(one.link.state(), LinkState::kEstablished);
  one.Frames(1, 60);
  EXPECT_EQ(one.link.state(), LinkState::kRising);
}

TEST(CouplingLink, ReportsFramesThatChangeItsStiffness) {
  OneLink one;
  one.Frames(10);
  EXPECT_TRUE(one.link.rises());
  EXPECT_FALSE(one.link.falls());
  one.Frames(3000);
  EXPECT_FALSE(one.link.rises());
  EXPECT_FALSE(one.link.falls());
  one.Frames(1, 10);
  EXPECT_FALSE(one.link.rises());
  EXPECT_TRUE(one.link.falls());
}

TEST(CouplingLink, AfterPartItFadesAndIgnoresSamples) {
  OneLink one;
  one.Frames(3000);
  one.link.Part();
  EXPECT_EQ(one.link.state(), LinkState::kFading);
  EXPECT_FALSE(one.link.closed());
  const std::uint32_t last = one.link.newest()->seq;
  double before = one.link.stiffness();
  int fading = 0;
  while (!one.link.over() && fading < 5000) {
    one.Frames(1);
    EXPECT_LT(one.link.stiffness(), before);
    before = one.link.stiffness();
    ++fading;
  }
  EXPECT_EQ(one.link.newest()->seq, last);
  EXPECT_EQ(one.link.stiffness(), 0);
  // 1 mm of 50 N/m are far from 8 N/s: the fade takes its 200 ms
  EXPECT_NEAR(fading, 200, 2);
}

TEST(CouplingLink, EndsAtOnceIfThePeerWasNeverHeard) {
  OneLink one;
  EXPECT_FALSE(one.link.over());
  one.link.Part();
  EXPECT_TRUE(one.link.over());
}

TEST(CouplingLink, ReturningPeerContinuesTheLinksForce) {
  OneLink one;
  one.Frames(3000);
  one.link.Part();
  one.Frames(50);
  const double left = one.link.stiffness();
  ASSERT_GT(left, 10);
  one.link.Rejoin();
  EXPECT_EQ(one.link.state(), LinkState::kListening);
  EXPECT_EQ(one.link.stiffness(), left);
  EXPECT_EQ(one.link.loop_age_s(one.now), 0);
  EXPECT_EQ(one.link.peak_loop_age_s(), 0);
  one.HearState();
  EXPECT_EQ(one.link.state(), LinkState::kListening);  // the echo must be new
  one.Frames(1);
  EXPECT_EQ(one.link.state(), LinkState::kRising);
  EXPECT_NEAR(one.link.loop_age_s(one.now), 0.021, 1e-12);
  one.Frames(3000);
  EXPECT_EQ(one.link.state(), LinkState::kEstablished);
}

TEST(CouplingLink, RejoinLeavesAnUnfadedLinkUnchanged) {
  OneLink one;
  one.Frames(3000);
  one.link.Rejoin();
  EXPECT_EQ(one.link.state(), LinkState::kEstablished);
  EXPECT_GT(one.link.peak_loop_age_s(), 0);
}

TEST(CouplingLink, RefusesUnsentAndOutdatedEchoes) {
  OneLink one;
  EXPECT_EQ(one.HearLinks(-5, 50), 1U);  // a stamp of the future
  EXPECT_EQ(one.HearLinks(20, 50), 0U);
  EXPECT_EQ(one.HearLinks(30, 50), 1U);
  EXPECT_EQ(one.HearLinks(20, 50), 0U);  // the same again is no error
  one.Frame();
  EXPECT_NEAR(one.link.loop_age_s(one.now), 0.021, 1e-12);
}

TEST(CouplingLink, OutdatedSamplesChangeNothing) {
  OneLink one;
  one.Frames(100);
  const std::uint32_t newest = one.seq;
  one.seq = newest - 10;
  one.HearState();
  one.HearLinks(1, 0);
  EXPECT_EQ(one.link.newest()->seq, newest - 1);  // states and links share our numbers here
  EXPECT_NEAR(one.link.loop_age_s(one.now), 0.021, 1e-12);
}

TEST(CouplingLink, ForceCapBoundsTheSpringAndTheOffer) {
  OneLink one;
  one.place_m = 0.02;
  one.Frames(6000);
  ASSERT_NEAR(one.link.stiffness(), 50, 1e-9);  // 1 N
  one.link.CapForce(0.5);
  one.Frames(3000);
  EXPECT_NEAR(one.link.stiffness() * one.place_m, 0.5, 1e-6);
  EXPECT_NEAR(one.link.Describe(kFarEnd).stiffness, one.link.stiffness(), 1e-9);
}

TEST(CouplingLink, ForceFadeTakesEffectAtOnce) {
  OneLink one;
  one.place_m = 0.02;
  one.Frames(6000);
  ASSERT_NEAR(one.link.stiffness(), 50, 1e-9);
  one.link.FadeForce(0.25);
  one.Frames(1);
  EXPECT_NEAR(one.link.stiffness(), 0.25 * 50, 1e-3);
  EXPECT_NEAR(one.link.Describe(kFarEnd).stiffness, 0.25 * 50, 1e-3);
  one.link.CapForce(1e30);
  one.Frames(100);
  EXPECT_NEAR(one.link.Describe(kFarEnd).stiffness, one.allowed, 1e-9);
  EXPECT_GT(one.link.stiffness(), 0.25 * 50);  // slowly: the parts are at rest
}

TEST(CouplingLink, AllocatesNothing) {
  OneLink one;
  const testing::AllocationCounter counter;
  one.Frames(100);
  one.link.Part();
  one.Frames(10);
  one.link.Rejoin();
  one.Frames(10);
  EXPECT_EQ(counter.count(), 0);
}

}  // namespace
}  // namespace tandem
