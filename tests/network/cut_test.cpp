#include <algorithm>
#include <chrono>
#include <cmath>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "engine/base/units.h"
#include "tests/network/cut_peers.h"
#include "tests/support/machine/lag_meter.h"
#include "tests/support/tap_hub_here.h"

// Tests what a cut of the network is to peers of the product, by real packets. A peer that is cut
// off is lost, not gone, and comes back. No hand feels more of that than of any other coming and
// going.

namespace tandem {
namespace {

using testing::CutPeers;
using testing::SeenFrame;
using testing::SeenPeer;
using Kind = MembershipChange::Kind;
using Ways = std::vector<std::pair<std::size_t, std::size_t>>;  // from, to

constexpr double kDegree = M_PI / 180;
// The cut comes after all have met, which is when hands begin or up to a second before. The first
// hand has pulled by then, and nothing has moved for more than a second.
constexpr std::chrono::milliseconds kCutAfter{4000};
constexpr std::chrono::milliseconds kSeenAfterwards{2500};
// time from the hand's start until the first hand, which pulls, moves on, more than a second after
// the cut
constexpr std::int64_t kMovesNs = 5'400'000'000;
constexpr std::int64_t kMovedNs = 6'100'000'000;

/// Returns hands of which the first pulls by 30 mm, and moves on by 20 mm and 10 degrees while it
/// is cut off. The others stay where they are.
std::vector<std::vector<Waypoint>> Hands() {
  const Vec3 pulled(0.03, 0, 0);
  const Vec3 moved(0.03, 0.02, 0);
  const Quat turned(Eigen::AngleAxisd(10 * kDegree, Vec3::UnitZ()));
  return {{{0, Vec3::Zero(), Quat::Identity()},
           {1, pulled, Quat::Identity()},
           {ToSeconds(kMovesNs), pulled, Quat::Identity()},
           {ToSeconds(kMovedNs), moved, turned}},
          {Waypoint{}},
          {Waypoint{}}};
}

/// Three who hold a cube, and ways between them that are cut for a while.
class Cut : public ::testing::Test {
 protected:
  void SetUp() override {
    if (const char* lacks = testing::WhyNoTapHub()) {
      GTEST_SKIP() << "over loopback no link can be cut, and a TAP hub " << lacks;
    }
  }

  /// Cyclone forgets a program that has been silent for 2 s, so a cut is longer.
  void Run(const Ways& ways, std::chrono::milliseconds length) {
    CutPeers peers(Hands());
    ASSERT_TRUE(peers.Meet()) << peers.OutputOf(0) << peers.OutputOf(1) << peers.OutputOf(2);
    std::this_thread::sleep_for(kCutAfter);
    const testing::LagMeter lag;
    for (const auto& [from, to] : ways) cut_ns_ = peers.Cut(from, to);
    std::this_thread::sleep_for(length);
    for (const auto& [from, to] : ways) healed_ns_ = peers.Cut(from, to, false);
    std::this_thread::sleep_for(kSeenAfterwards);
    late_ns_ = std::chrono::nanoseconds(lag.worst()).count();
    auto seen = peers.End();
    ASSERT_TRUE(seen.has_value()) << seen.error().what;
    seen_ = *std::move(seen);
    for (std::size_t i = 0; i < seen_.size(); ++i) output_.push_back(peers.OutputOf(i));

    // the other checks need this: there is a load, and the first moves while it is cut off
    const SeenPeer& first = seen_[0];
    ASSERT_GT(first.At(cut_ns_).links_f_W.norm(), 2.0);
    ASSERT_LT(cut_ns_ + kSecondNs, first.began_ns + kMovesNs);
    ASSERT_GT(healed_ns_ - kSecondNs / 2, first.began_ns + kMovedNs);
    const Pose X_cut = first.At(cut_ns_).X_WB;
    const Pose X_healed = first.At(healed_ns_).X_WB;
    ASSERT_GT((X_healed.p - X_cut.p).norm(), 0.005);
    ASSERT_GT(X_healed.q.angularDistance(X_cut.q), 3 * kDegree);
  }

  /// Returns how often a line of the other's is told to the person.
  int Told(std::size_t i, std::size_t other, const std::string& what) const {
    const std::string line = "user-" + std::to_string(other) + " " + what + "\n";
    int count = 0;
    for (std::size_t at = 0; (at = output_[i].find(line, at)) != std::string::npos; ++at) ++count;
    return count;
  }

  /// Expects that the other is lost once, in that time after the cut, and back once, within a
  /// second of its end, with the body where the other has it.
  void ExpectLostAndBack(std::size_t i, std::size_t other, std::int64_t within_ns = kSecondNs) {
    SCOPED_TRACE("user-" + std::to_string(other) + " as user-" + std::to_string(i) + " sees it");
    const PeerId id = seen_[other].id;
    EXPECT_EQ(seen_[i].Count(Kind::kLost, id), 1);
    EXPECT_EQ(seen_[i].Count(Kind::kBack, id), 1);
    EXPECT_EQ(seen_[i].Count(Kind::kLeft, id), 0);
    EXPECT_EQ(Told(i, other, "is lost"), 1);
    EXPECT_EQ(Told(i, other, "is back"), 1);
    const std::int64_t lost_ns = seen_[i].First(Kind::kLost, id) - cut_ns_;
    const std::int64_t back_ns = seen_[i].First(Kind::kBack, id) - healed_ns_;
    EXPECT_GT(lost_ns, 0);
    EXPECT_LE(lost_ns, within_ns + late_ns_);
    EXPECT_GT(back_ns, 0);
    EXPECT_LE(back_ns, kSecondNs + late_ns_);
    const std::string key = std::to_string(other) + "_to_" + std::to_string(i);
    RecordProperty("lost_ms_" + key, static_cast<int>(lost_ns / 1'000'000));
    RecordProperty("back_ms_" + key, static_cast<int>(back_ns / 1'000'000));

    const SeenFrame& frame = seen_[i].At(healed_ns_ + kSecondNs);
    EXPECT_EQ(frame.coupled, 2U);
    const InstanceView* const received = frame.InstanceOf(id);
    ASSERT_NE(received, nullptr);
    const Pose own = seen_[other].At(frame.now_ns).X_WB;
    EXPECT_LE((received->X_WB.p - own.p).norm(), 1e-3);
    EXPECT_LE(received->X_WB.q.angularDistance(own.q), 0.5 * kDegree);
  }

  void ExpectNothingNoticed(std::size_t i, std::size_t other) {
    SCOPED_TRACE("user-" + std::to_string(other) + " as user-" + std::to_string(i) + " sees it");
    for (const Kind kind : {Kind::kLost, Kind::kBack, Kind::kLeft}) {
      EXPECT_EQ(seen_[i].Count(kind, seen_[other].id), 0);
    }
    EXPECT_EQ(Told(i, other, "is lost"), 0);
  }

  /// Expects it of the forces of the hand and of the links together, between two frames and within
  /// 100 ms, as for all who come and go. Changes without any cut, from the second before it, do not
  /// count, nor do those while the hand moves.
  void ExpectNoForceChangesByMoreThanOneNewton() {
    for (std::size_t i = 0; i < seen_.size(); ++i) {
      for (const auto force : {&SeenFrame::hand_f_W, &SeenFrame::links_f_W}) {
        for (const std::size_t frames : {1U, 100U}) {
          const std::int64_t moves_ns = seen_[0].began_ns + kMovesNs;
          const double calm = LargestChange(i, force, frames, cut_ns_ - kSecondNs, cut_ns_);
          const double cut = LargestChange(i, force, frames, cut_ns_ - kSecondNs / 2, moves_ns);
          const double healed =
              LargestChange(i, force, frames, healed_ns_ - kSecondNs / 2, INT64_MAX);
          const std::string which = std::string(force == &SeenFrame::hand_f_W ? "hand" : "links") +
                                    "_" + std::to_string(i) + "_" + std::to_string(frames);
          EXPECT_LE(cut - calm, 1.0) << which << ", at the cut";
          EXPECT_LE(healed - calm, 1.0) << which << ", at its end";
          RecordProperty("cut_N_" + which, std::to_string(cut));
          RecordProperty("healed_N_" + which, std::to_string(healed));
        }
      }
    }
  }

  /// Returns the largest change of a force, in size or direction, within so many frames of that
  /// time.
  double LargestChange(std::size_t i, Vec3 SeenFrame::*force, std::size_t frames,
                       std::int64_t from_ns, std::int64_t to_ns) const {
    const std::vector<SeenFrame>& all = seen_[i].frames;
    double largest = 0;
    for (std::size_t k = frames; k < all.size() && all[k].now_ns < to_ns; ++k) {
      if (all[k - frames].now_ns < from_ns) continue;
      largest = std::max(largest, (all[k].*force - all[k - frames].*force).norm());
    }
    return largest;
  }

  std::int64_t cut_ns_ = 0;
  std::int64_t healed_ns_ = 0;
  std::int64_t late_ns_ = 0;  // the latest that the machine woke a thread of the test
  std::vector<SeenPeer> seen_;
  std::vector<std::string> output_;
};

TEST_F(Cut, IsolatedPeerIsLostAndReturnsWithItsBodyInPlace) {
  ASSERT_NO_FATAL_FAILURE(Run({{0, 1}, {1, 0}, {0, 2}, {2, 0}}, std::chrono::milliseconds(4300)));
  for (const std::size_t other : {1U, 2U}) {
    ExpectLostAndBack(0, other);
    ExpectLostAndBack(other, 0);
    ExpectNothingNoticed(other, 3 - other);
  }
  ExpectNoForceChangesByMoreThanOneNewton();
}

// The third hears both, and both hear the third.
TEST_F(Cut, CutBetweenTwoPeersDoesNotAffectTheThird) {
  ASSERT_NO_FATAL_FAILURE(Run({{0, 1}, {1, 0}}, std::chrono::milliseconds(4300)));
  ExpectLostAndBack(0, 1);
  ExpectLostAndBack(1, 0);
  for (const std::size_t other : {0U, 1U}) {
    ExpectNothingNoticed(2, other);
    ExpectNothingNoticed(other, 2);
  }
  ExpectNoForceChangesByMoreThanOneNewton();
}

// Nobody hears the first peer, which hears all. The others give it up after 2 s and say no more to
// it, but for announcements every 0.65 s. It may have counted the last of these as a sign of life:
// 0.6 s later they are lost to it as well.
TEST_F(Cut, OneWayCutIsNoticedAtBothEnds) {
  ASSERT_NO_FATAL_FAILURE(Run({{0, 1}, {0, 2}}, std::chrono::milliseconds(5100)));
  for (const std::size_t other : {1U, 2U}) {
    ExpectLostAndBack(other, 0);
    ExpectLostAndBack(0, other, 4 * kSecondNs);
    ExpectNothingNoticed(other, 3 - other);
  }
  ExpectNoForceChangesByMoreThanOneNewton();
}

}  // namespace
}  // namespace tandem
