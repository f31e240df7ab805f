#include <gtest/gtest.h>
#include <signal.h>

#include "tests/collab/dds/child_peer.h"
#include "tests/collab/dds/live_peer.h"

// Tests what one program can do to a plain session through DDS's own interface. security_test.cpp
// tests the same in a secured one.

namespace tandem::testing {
namespace {

using std::chrono::milliseconds;

constexpr PeerId kAnna = 11;
constexpr PeerId kBen = 22;
constexpr PeerId kMallory = 33;
// 1,500 attacks.
constexpr milliseconds kAttack{1500};

/// Anna is here and hears Ben, who is in a process of its own; Mallory attacks from a third one.
class Attack : public ::testing::Test {
 protected:
  void SetUp() override {
    auto joined = JoinOverDds(LoopbackOptions(session_, kAnna, Role::kActive), received_);
    ASSERT_TRUE(joined.has_value()) << joined.error().what;
    anna_ = *std::move(joined);
    ben_ = std::make_unique<ChildPeer>(session_, kBen);
    ASSERT_TRUE(received_.WaitFor([](const Recorder::Heard& h) {
      return h.infos.contains(kBen) && h.states.contains(kBen) && !h.scenes.empty();
    }));
  }
  void Begin(const std::string& mode) {
    mallory_ = std::make_unique<ChildPeer>(
        std::vector<std::string>{TANDEM_DDS_ATTACKER, session_, "-", "-", mode,
                                 std::to_string(kMallory), "-", std::to_string(kBen)});
    ASSERT_TRUE(mallory_->Says("attacking"));
  }
  bool WaitForDrop(PeerId from, Drop reason) {
    return received_.WaitFor([=](const Recorder::Heard& h) {
      return h.dropped.contains({from, reason});
    });
  }
  /// Expects that Ben is neither lost nor taken leave of while the attack goes on, and is still
  /// heard after.
  void ExpectBenIsHere() {
    EXPECT_FALSE(received_.WaitFor(
        [](const Recorder::Heard& h) {
          return h.left.contains(kBen) || h.lost.contains(kBen);
        },
        kAttack));
    const Recorder::Heard now = received_.Now();
    EXPECT_TRUE(received_.WaitFor([&](const Recorder::Heard& h) {
      return h.info_count.at(kBen) > now.info_count.at(kBen) &&
             h.states.at(kBen).seq > now.states.at(kBen).seq;
    }));
    EXPECT_EQ(received_.Now().infos.at(kBen).name, "Ada");
  }

  const std::string session_ = RandomSession();
  Recorder received_;
  std::unique_ptr<Transport> anna_;
  std::unique_ptr<ChildPeer> ben_;
  std::unique_ptr<ChildPeer> mallory_;
};

TEST_F(Attack, DisposingOfAPeersInstanceDoesNotMakeItLeave) {
  Begin("dispose");
  EXPECT_TRUE(WaitForDrop(kMallory, Drop::kImpostor));
  ExpectBenIsHere();
}

TEST_F(Attack, WritingToALostPeersInstanceDoesNotKeepItAlive) {
  Begin("dispose");
  EXPECT_TRUE(WaitForDrop(kMallory, Drop::kImpostor));
  ben_->Signal(SIGKILL);
  EXPECT_TRUE(received_.WaitFor(
      [](const Recorder::Heard& h) {
        return h.lost.contains(kBen);
      },
      milliseconds(2000)));
}

TEST_F(Attack, GoodbyeIsHeardInSpiteOfTheAttack) {
  Begin("dispose");
  EXPECT_TRUE(WaitForDrop(kMallory, Drop::kImpostor));
  ben_->Command("leave");
  EXPECT_TRUE(received_.WaitFor([](const Recorder::Heard& h) {
    return h.left.contains(kBen);
  }));
}

TEST_F(Attack, SecondParticipantCannotSpeakAsAPresentPeer) {
  Begin("sit_down");
  EXPECT_TRUE(WaitForDrop(kBen, Drop::kImpostor)) << "told once it has lasted";
  ExpectBenIsHere();
}

TEST_F(Attack, StatesForgedInAPeersPartitionAreDropped) {
  Begin("state_as_victim");
  EXPECT_TRUE(WaitForDrop(0, Drop::kNoOwner));
  EXPECT_FALSE(received_.WaitFor(
      [](const Recorder::Heard& h) {
        return h.states.at(kBen).epoch == 666;
      },
      kAttack));
}

TEST_F(Attack, ViewersClaimsAreIgnored) {
  Begin("look_on");
  ASSERT_TRUE(received_.WaitFor([](const Recorder::Heard& h) {
    return h.infos.contains(kMallory);
  }));
  EXPECT_EQ(received_.Now().infos.at(kMallory).role, Role::kViewer);
  EXPECT_TRUE(received_.Now().infos.at(kMallory).claims.empty());
}

TEST_F(Attack, ViewerCannotFakeAnotherPeersPresence) {
  Begin("look_on_as_victim");
  EXPECT_TRUE(WaitForDrop(kMallory, Drop::kImpostor));
  ExpectBenIsHere();
}

TEST_F(Attack, ForgedEventsAreDropped) {
  Begin("grant");
  EXPECT_TRUE(WaitForDrop(kMallory, Drop::kStranger));
  mallory_.reset();
  Begin("grant_as_victim");
  EXPECT_TRUE(WaitForDrop(kMallory, Drop::kImpostor));
  EXPECT_TRUE(received_.Now().events.empty());
}

TEST_F(Attack, ForgedOrImpossibleManifestsAreDropped) {
  Begin("offer_as_first");
  EXPECT_TRUE(WaitForDrop(kMallory, Drop::kImpostor));
  mallory_.reset();
  Begin("offer_absurd");
  EXPECT_TRUE(WaitForDrop(kMallory, Drop::kAbsurdScene));
  for (const SceneManifest& manifest : received_.Now().scenes) EXPECT_EQ(manifest.offered_by, kBen);
}

}  // namespace
}  // namespace tandem::testing
