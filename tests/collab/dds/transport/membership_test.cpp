#include <thread>

#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include "tests/collab/dds/child_peer.h"
#include "tests/collab/dds/live_peer.h"
#include "tests/support/machine/lag_meter.h"
#include "tests/support/machine/processor_wait.h"

namespace tandem::testing {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr PeerId kHere = 11;
constexpr PeerId kThere = 22;
constexpr PeerId kViewer = 33;

bool IsHere(const Recorder::Heard& h) {
  return h.infos.contains(kThere) && h.states.contains(kThere);
}
int Count(const std::map<PeerId, int>& of) {
  const auto it = of.find(kThere);
  return it == of.end() ? 0 : it->second;
}
bool IsLost(const Recorder::Heard& h) {
  return Count(h.lost) > 0;
}
bool HasLeft(const Recorder::Heard& h) {
  return Count(h.left) > 0;
}

/// One peer here, which says nothing, and another in a process of its own, which has been heard.
class Membership : public ::testing::Test {
 protected:
  void SetUp() override {
    auto joined = JoinOverDds(LoopbackOptions(session_, kHere, Role::kActive), received_);
    ASSERT_TRUE(joined.has_value()) << joined.error().what;
    here_ = *std::move(joined);
    there_ = std::make_unique<ChildPeer>(session_, kThere);
    ASSERT_TRUE(received_.WaitFor(IsHere));
  }

  /// Expects that it comes to pass in that time, or later by no more than the machine woke a thread
  /// too late in it and others had the processors.
  template <class Condition>
  void ExpectWithin(milliseconds bound, const Condition& condition) {
    const LagMeter lag;
    ProcessorWait here(getpid());
    ProcessorWait there(there_->pid());
    const steady_clock::time_point begin = steady_clock::now();
    EXPECT_TRUE(received_.WaitFor(condition, bound + std::chrono::seconds(20)));
    const auto took = steady_clock::now() - begin;
    const std::chrono::duration<double> waited(here.Look() + there.Look());
    EXPECT_LE(took, lag.AllowedLag(bound) + waited)
        << "took " << took / milliseconds(1) << " ms, the machine was late by "
        << lag.worst() / milliseconds(1) << " ms, others had the processors for " << waited.count()
        << " s";
  }

  const std::string session_ = RandomSession();
  Recorder received_;
  std::unique_ptr<Transport> here_;
  std::unique_ptr<ChildPeer> there_;
};

TEST_F(Membership, GoodbyeIsHeardWithin50Milliseconds) {
  there_->Command("leave");
  ExpectWithin(milliseconds(50), HasLeft);
  // its end, when its lease would have run out, does not make it lost as well
  EXPECT_FALSE(received_.WaitFor(IsLost, milliseconds(1500)));
  EXPECT_EQ(Count(received_.Now().left), 1);
}

TEST_F(Membership, PeerWithoutGoodbyeIsLost) {
  there_->Command("drop");
  ExpectWithin(milliseconds(500), IsLost);
  EXPECT_FALSE(HasLeft(received_.Now()));
}

TEST_F(Membership, KilledPeerIsLostWithinASecondAndReturnsOnRestart) {
  there_->Signal(SIGKILL);
  ExpectWithin(milliseconds(1000), IsLost);
  EXPECT_FALSE(HasLeft(received_.Now()));
  const auto states_before = received_.Now().states.at(kThere).sample_ns;

  there_ = std::make_unique<ChildPeer>(session_, kThere);
  EXPECT_TRUE(received_.WaitFor([&](const Recorder::Heard& h) {
    return h.infos.contains(kThere) && h.states.at(kThere).sample_ns > states_before;
  }));
}

// The peer says what the session is about once, while its crashed run has not been given up yet.
TEST_F(Membership, OfferOfAnImmediatelyRestartedPeerIsHeard) {
  ASSERT_TRUE(received_.WaitFor([](const Recorder::Heard& h) {
    return !h.scenes.empty();
  }));
  const std::size_t offered = received_.Now().scenes.size();
  there_->Signal(SIGKILL);
  there_ = std::make_unique<ChildPeer>(session_, kThere);
  EXPECT_TRUE(received_.WaitFor(
      [&](const Recorder::Heard& h) {
        return h.scenes.size() > offered;
      },
      std::chrono::seconds(30)));
  EXPECT_FALSE(received_.Now().dropped.contains({kThere, Drop::kImpostor})) << "it is none";
}

// The halt is shorter than the participant's lease (2 s): only its writers are given up, and its
// next beat brings it back.
TEST_F(Membership, SuspendedPeerIsLostAndReturns) {
  there_->Signal(SIGSTOP);
  ExpectWithin(milliseconds(2000), IsLost);
  there_->Signal(SIGCONT);
  ExpectWithin(milliseconds(2000), IsHere);
  EXPECT_FALSE(HasLeft(received_.Now()));
}

// The halt is longer: the whole participant is given up and is discovered anew.
TEST_F(Membership, LongSuspendedPeerIsRediscovered) {
  const steady_clock::time_point stopped = steady_clock::now();
  there_->Signal(SIGSTOP);
  ExpectWithin(milliseconds(2000), IsLost);
  std::this_thread::sleep_until(stopped + milliseconds(4000));
  EXPECT_FALSE(IsHere(received_.Now()));
  const auto before = received_.Now().states.at(kThere).sample_ns;
  there_->Signal(SIGCONT);
  ExpectWithin(milliseconds(1000), [&](const Recorder::Heard& h) {
    return h.infos.contains(kThere) && h.states.at(kThere).sample_ns > before;
  });
  EXPECT_FALSE(HasLeft(received_.Now()));
  EXPECT_EQ(received_.Now().infos.at(kThere).claims.size(), 2U);
}

// A viewer that looks on with us loses nobody, and its own end is heard as any peer's.
TEST_F(Membership, ViewersGoodbyeIsHeard) {
  ChildPeer viewer(session_, kViewer, {Role::kViewer, 0});
  ASSERT_TRUE(received_.WaitFor([](const Recorder::Heard& h) {
    return h.infos.contains(kViewer);
  }));
  EXPECT_EQ(received_.Now().infos.at(kViewer).role, Role::kViewer);
  viewer.Command("leave");
  ExpectWithin(milliseconds(200), [](const Recorder::Heard& h) {
    return h.left.contains(kViewer);
  });
  EXPECT_FALSE(IsLost(received_.Now()));
}

}  // namespace
}  // namespace tandem::testing
