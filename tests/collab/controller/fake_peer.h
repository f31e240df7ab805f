#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "collab/controller/control_server.h"

namespace tandem::testing {

/// Returns a scene of two moving bodies that one user at a time holds, a shared one and a fixed
/// one.
inline ControlScene FourBodies() {
  ControlScene scene;
  scene.number = 1;
  scene.session = "s";
  scene.self = 7;
  scene.bodies = {{.name = "table", .fixed = true},
                  {.name = "peg", .moving = 0, .object = 1},
                  {.name = "bolt", .moving = 1, .object = 2},
                  {.name = "frame", .shared = true, .moving = 2, .object = 3}};
  scene.clearance = ClearanceBounds::ForMarks(8, 0.001);
  return scene;
}

/// A peer without a simulation for a server to act on. It notes what it is told, and does at once
/// what a lone peer would.
class FakePeer : public ControlledPeer {
 public:
  bool Order(const Command& command) override {
    orders.push_back(command);
    if (deaf) return true;
    if (command.kind == Command::Kind::kGrab) {
      facts.held = static_cast<int>(command.object) - 1;
      facts.attached = true;
      facts.X_WG = facts.bodies[static_cast<std::size_t>(facts.held)].X_WB;
      facts.bodies[static_cast<std::size_t>(facts.held)].holder_count = 1;
      if (!goal.keeps_way) facts.way_body = facts.held;
    }
    if (command.kind == Command::Kind::kRelease || command.kind == Command::Kind::kGive) {
      if (facts.held >= 0) facts.bodies[static_cast<std::size_t>(facts.held)].holder_count = 0;
      facts.held = -1;
      facts.attached = false;
    }
    return true;
  }
  void Tell(const GoalOrder& order) override {
    goal = order;
    facts.grasp_seq = order.grasp_seq;
    facts.requested = order.X_WG;
    // a part in hand follows at once, as far as nothing is in its way
    if (follows && facts.held >= 0 && order.input_seq != input_seq) {
      Pose& X_WB = facts.bodies[static_cast<std::size_t>(facts.held)].X_WB;
      X_WB = order.X_WG;
      if (facts.held == blocked) X_WB.p.x() = std::max(X_WB.p.x(), blocked_at_x);
      facts.X_WG = X_WB;
    }
    input_seq = order.input_seq;
    if (facts.way_seq == order.way_seq) return;
    facts.way_seq = order.way_seq;
    if (order.way == GoalOrder::Way::kDrop) facts.way_body = -1;
    if (order.way == GoalOrder::Way::kBack) facts.way = PathBacktracker::State::kUnderWay;
  }
  void Begin(std::uint64_t job, const ControlRequest& request) override {
    jobs.emplace_back(job, request);
  }
  void StopDevice(bool stop) override { stopped = stop; }
  bool ChangeWorkspace(const WorkspaceChange& change) override {
    change.ApplyTo(workspace);
    return true;
  }
  void Quit() override { quit = true; }

  std::size_t Count(Command::Kind kind) const {
    std::size_t count = 0;
    for (const Command& order : orders) count += order.kind == kind ? 1 : 0;
    return count;
  }

  std::vector<Command> orders;
  std::vector<std::pair<std::uint64_t, ControlRequest>> jobs;
  GoalOrder goal;
  SimulationFacts facts{.body_count = 3, .goal_device = true};
  bool deaf = false;  // orders come to nothing
  bool follows = false;
  int blocked = -1;         // body that cannot go below blocked_at_x
  double blocked_at_x = 0;  // m
  std::uint32_t input_seq = 0;
  bool stopped = false;
  WorkspaceOrder workspace;
  bool quit = false;
};

}  // namespace tandem::testing
