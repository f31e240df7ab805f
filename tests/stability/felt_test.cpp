#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "collab/coupling_law.h"
#include "collab/simulated/simulated_session.h"
#include "tests/stability/free_box.h"
#include "tests/support/scripted_node.h"

namespace tandem {
namespace {

using testing::FreeBox;
using testing::ScriptedNode;

enum class What { kNothing, kJoin, kLeave, kKill, kHalt };

/// N in each frame of the first user's, from when the loop is closed.
struct Forces {
  std::vector<Vec3> hand;
  std::vector<Vec3> links;
};

/// Two hold against one another with 3 N on the link; 6 s in something happens to a third one, who
/// comes, or to the second one, who goes.
Forces ThreeNewtons(double tau, What what) {
  const double k = DefaultLaw()->Link(LawInputsAt(2 * tau + 0.002, 2, 1.5)).stiffness;
  const double side = 1.0 / (1.0 / 300 + 1.0 / 800);  // the hand and its coupling
  const double way = 3.0 * (1.0 / k + 2.0 / side);
  SimulatedSession session;
  const auto add = [&](PeerId id, std::vector<Waypoint> waypoints) {
    session.Add(ScriptedNode(FreeBox().model, id, 0, std::move(waypoints), 1e3 * tau), id);
  };
  add(1, {{0, Vec3::Zero(), Quat::Identity()}, {1, Vec3(way, 0, 0), Quat::Identity()}});
  add(2, {});
  const auto coupled = [&](std::size_t user) {
    const SharedBody* shared = session.node(user).peer().shared();
    return shared != nullptr && shared->coupled() > 0;
  };
  for (int i = 0; i < 8000 && !(coupled(0) && coupled(1)); ++i) session.Step();
  Forces forces;
  std::array<LinkView, kMaxLinks> views;
  for (int frame = 0; frame < 10000; ++frame) {
    if (frame == 8000 && what == What::kHalt) session.Halt(1, false);
    if (frame == 6000) {
      if (what == What::kJoin) add(3, {});
      if (what == What::kLeave) session.Leave(1);
      if (what == What::kKill) session.Kill(1);
      if (what == What::kHalt) session.Halt(1, true);
    }
    session.Step();
    const Peer& first = session.node(0).peer();
    Vec3 links = Vec3::Zero();
    const std::size_t count = first.shared()->Links(0, views);
    for (std::size_t link = 0; link < count; ++link) links += first.report().links_B_W[link].f;
    forces.hand.push_back(first.report().hand_B_W.f);
    forces.links.push_back(links);
  }
  return forces;
}

/// The largest change of a force, in size or direction, within `frames`, event or not; from 5.5 s
/// on.
double LargestChange(const std::vector<Vec3>& force, std::size_t frames) {
  double largest = 0;
  for (std::size_t i = 5500; i + frames < force.size(); ++i) {
    largest = std::max(largest, (force[i + frames] - force[i]).norm());
  }
  return largest;
}

TEST(Felt, WhoComesOrGoesChangesNoForceByMoreThanOneNewton) {
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

}  // namespace
}  // namespace tandem
