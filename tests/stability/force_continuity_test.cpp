#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "collab/coupling/coupling_law.h"
#include "collab/simulated/network/simulated_session.h"
#include "tests/stability/free_box.h"
#include "tests/support/scripted_node.h"

namespace tandem {
namespace {

using testing::FreeBox;
using testing::ScriptedNode;

/// N in each frame, from when the loops are closed.
struct Forces {
  std::vector<Vec3> hand;
  std::vector<Vec3> links;
};

/// One user pulls at so many others with 3 N on its links together.
class Pull {
 public:
  Pull(double tau, std::size_t others) : tau_(tau), others_(others) {
    const double k = DefaultLaw()->Link(LawInputsAt(2 * tau + 0.002, 1 + others, 1.5)).stiffness;
    const double side = 1.0 / (1.0 / 300 + 1.0 / 800);  // the hand and its coupling
    const double share = 1.0 / static_cast<double>(others);
    const double way = 3.0 * (share / k + (1.0 + share) / side);
    Add({{0, Vec3::Zero(), Quat::Identity()}, {1, Vec3(way, 0, 0), Quat::Identity()}});
    for (std::size_t other = 0; other < others; ++other) Add({});
    for (int i = 0; i < 8000 && !Closed(); ++i) session.Step();
  }

  /// Adds another user, who waits for no more than one other.
  void Add(std::vector<Waypoint> waypoints) {
    const PeerId id = session.size() + 1;
    session.Add(ScriptedNode(FreeBox().model, id, 0, std::move(waypoints), 1e3 * tau_), id);
  }
  /// Runs a frame.
  void Step() {
    session.Step();
    for (const std::size_t user : {0U, 1U}) {
      const Peer& peer = session.node(user).peer();
      if (!session.present(user) || peer.shared() == nullptr) continue;
      std::array<LinkView, kMaxLinks> views;
      Vec3 links = Vec3::Zero();
      const std::size_t count = peer.shared()->Links(0, views);
      for (std::size_t link = 0; link < count; ++link) links += peer.report().links_B_W[link].f;
      forces[user].hand.push_back(peer.report().hand_B_W.f);
      forces[user].links.push_back(links);
    }
  }

  SimulatedSession session;
  std::array<Forces, 2> forces;  // those of the user who pulls, and of the first of the others

 private:
  bool Closed() {
    for (std::size_t user = 0; user < session.size(); ++user) {
      const SharedBody* shared = session.node(user).peer().shared();
      if (shared == nullptr || shared->coupled() < others_) return false;
    }
    return true;
  }

  double tau_;
  std::size_t others_;
};

enum class What { kNothing, kJoin, kLeave, kKill, kHalt };

/// Returns what the first of two feels. 6 s in, something happens to a third one, who comes, or to
/// the second one, who goes.
Forces ThreeNewtons(double tau, What what) {
  Pull pull(tau, 1);
  for (int frame = 0; frame < 10000; ++frame) {
    if (frame == 8000 && what == What::kHalt) pull.session.Halt(1, false);
    if (frame == 6000) {
      if (what == What::kJoin) pull.Add({});
      if (what == What::kLeave) pull.session.Leave(1);
      if (what == What::kKill) pull.session.Kill(1);
      if (what == What::kHalt) pull.session.Halt(1, true);
    }
    pull.Step();
  }
  return pull.forces[0];
}

enum class Cut { kBothWays, kFromIt, kToIt };

/// Cuts off the user who pulls from all others 6 s in, for 3 s.
std::array<Forces, 2> CutOff(double tau, std::size_t others, Cut cut) {
  Pull pull(tau, others);
  for (int frame = 0; frame < 13000; ++frame) {
    for (PeerId other = 2; other <= 1 + others && (frame == 6000 || frame == 9000); ++other) {
      if (cut != Cut::kToIt) pull.session.network().Cut(1, other, frame == 6000);
      if (cut != Cut::kFromIt) pull.session.network().Cut(other, 1, frame == 6000);
    }
    pull.Step();
  }
  return pull.forces;
}

/// Returns the largest change of a force, in size or direction, within `frames`, event or not, from
/// 5.5 s on.
double LargestChange(const std::vector<Vec3>& force, std::size_t frames) {
  double largest = 0;
  for (std::size_t i = 5500; i + frames < force.size(); ++i) {
    largest = std::max(largest, (force[i + frames] - force[i]).norm());
  }
  return largest;
}

TEST(ForceContinuity, JoinOrLeaveChangesNoForceByMoreThanOneNewton) {
  for (const double tau : {0.001, 0.02, 0.1}) {
    const Forces calm = ThreeNewtons(tau, What::kNothing);
    ASSERT_NEAR(calm.links[5900].norm(), 3.0, 0.15) << tau;
    for (const What what : {What::kJoin, What::kLeave, What::kKill, What::kHalt}) {
      const Forces run = ThreeNewtons(tau, what);
      if (what == What::kLeave || what == What::kKill) {
        EXPECT_NEAR(run.links.back().norm(), 0, 1e-9);
      }
      for (const std::size_t frames : {1U, 100U}) {
        const double hand = LargestChange(run.hand, frames);
        const double link = LargestChange(run.links, frames);
        EXPECT_LE(hand - LargestChange(calm.hand, frames), 1.0)
            << "hand, tau " << tau << ", event " << static_cast<int>(what) << ", " << frames;
        EXPECT_LE(link - LargestChange(calm.links, frames), 1.0)
            << "link, tau " << tau << ", event " << static_cast<int>(what) << ", " << frames;
        RecordProperty("hand_" + std::to_string(static_cast<int>(1000 * tau)) + "ms_" +
                           std::to_string(static_cast<int>(what)) + "_" + std::to_string(frames),
                       std::to_string(hand));
        RecordProperty("link_" + std::to_string(static_cast<int>(1000 * tau)) + "ms_" +
                           std::to_string(static_cast<int>(what)) + "_" + std::to_string(frames),
                       std::to_string(link));
      }
    }
  }
}

// Many links go and come at once. A peer that is heard and does not hear, or the other way, is not
// lost: a link is softer the longer it has no echo.
TEST(ForceContinuity, IsolatedPeerFeelsNoChangeByMoreThanOneNewton) {
  for (const double tau : {0.001, 0.1}) {
    for (const std::size_t others : {1U, 2U, 4U, 8U}) {
      for (const Cut cut : {Cut::kBothWays, Cut::kFromIt, Cut::kToIt}) {
        SCOPED_TRACE("tau " + std::to_string(tau) + ", " + std::to_string(others) +
                     " others, cut " + std::to_string(static_cast<int>(cut)));
        const std::array<Forces, 2> runs = CutOff(tau, others, cut);
        ASSERT_NEAR(runs[0].links[5900].norm(), 3.0, 0.15);
        if (cut == Cut::kBothWays) {
          EXPECT_NEAR(runs[0].links[8900].norm(), 0.0, 1e-9);
        } else {
          EXPECT_LT(runs[0].links[8900].norm(), 1.5);
        }
        for (const Forces& run : runs) {
          ASSERT_EQ(run.hand.size(), 13000U);
          for (const std::size_t frames : {1U, 100U}) {
            EXPECT_LE(LargestChange(run.hand, frames), 1.0) << frames;
            EXPECT_LE(LargestChange(run.links, frames), 1.0) << frames;
          }
        }
      }
    }
  }
}

}  // namespace
}  // namespace tandem
