#pragma once

#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "app/view/model/hand/controller_link.h"
#include "app/view/model/hand/hand_picture.h"

namespace tandem {

/// A controller without physics, in the test's own process: a part goes where the goal is, but
/// never beyond `wall_x`, against which it then pushes with 100 N a metre.
struct FakeController {
  ControllerSnapshot now;
  std::vector<ControlRequest> requested;
  std::string refuse;     // when not empty, every grab is refused with these words
  bool received = true;   // else the controller is silent
  bool reachable = true;  // else nobody can attach
  double wall_x = 1e9;    // m; limit of the grasped point's x
  std::string ended;      // when not empty, the process has ended with these words
  std::vector<HandRequest> launched;
  int processes = 0;                    // number that run
  std::vector<std::string> last_words;  // lines that it says when it is asked to end
  Pose X_GB;  // displacement of the body in hand, as seen from the grasp frame

  FakeController() {
    now.self = 1;
    now.frame = 1;
    now.session = "bracket";
    SnapshotBody block;
    block.name = "block";
    block.fixed = true;
    SnapshotBody ball;
    ball.name = "ball";
    ball.shared = true;
    now.bodies = {block, ball};
  }

  AttachFunction Attach() {
    return [this](const std::string&) -> Result<std::unique_ptr<ControllerLink>> {
      if (!reachable) return Error{"no controller of that name is heard"};
      return std::unique_ptr<ControllerLink>(std::make_unique<Link>(*this));
    };
  }
  LaunchFunction Launch() {
    return [this](const HandRequest& request) -> Result<std::unique_ptr<ControllerProcess>> {
      launched.push_back(request);
      ++processes;
      return std::unique_ptr<ControllerProcess>(std::make_unique<Process>(*this));
    };
  }
  template <typename Request>
  std::vector<Request> Asked() const {
    std::vector<Request> some;
    for (const ControlRequest& one : requested) {
      if (const auto* request = std::get_if<Request>(&one)) some.push_back(*request);
    }
    return some;
  }

 private:
  struct Process : ControllerProcess {
    explicit Process(FakeController& c) : controller(c) {}
    ~Process() override { --controller.processes; }
    std::optional<std::string> Ended() override {
      return controller.ended.empty() ? std::nullopt : std::optional(controller.ended);
    }
    std::string LastLine() override { return {}; }
    std::vector<std::string> LinesSinceMark() override { return controller.last_words; }
    FakeController& controller;
  };

  struct Link : ControllerLink {
    explicit Link(FakeController& c) : controller(c) {}
    bool attached() const override { return controller.received; }
    void Send(const ControlRequest& request, OnAnswer on_answer) override {
      controller.requested.push_back(request);
      waiting.emplace_back(request, std::move(on_answer));
    }
    void SetGoal(const PlainPose& X_WG) override {
      if (controller.now.hand.body >= 0) controller.now.hand.goal = X_WG;
    }
    void Quit() override { controller.requested.emplace_back(QuitRequest{}); }
    const ControllerSnapshot& snapshot() const override { return seen; }
    bool Poll() override {
      if (!controller.received) return false;
      for (auto& [request, on_answer] : std::exchange(waiting, {})) {
        const Answer answer = controller.Obey(request);
        if (on_answer) on_answer(answer);
      }
      controller.Step();
      seen = controller.now;
      return true;
    }
    FakeController& controller;
    ControllerSnapshot seen = controller.now;
    std::vector<std::pair<ControlRequest, OnAnswer>> waiting;
  };

  Answer Obey(const ControlRequest& request) {
    if (const auto* grab = std::get_if<GrabRequest>(&request)) return Take(*grab);
    if (std::holds_alternative<ReleaseRequest>(request)) Drop(SnapshotHand::State::kEmpty);
    if (std::holds_alternative<EmergencyStopRequest>(request)) Drop(SnapshotHand::State::kStopped);
    if (std::holds_alternative<ResumeRequest>(request)) Drop(SnapshotHand::State::kEmpty);
    if (std::holds_alternative<GiveRequest>(request) && now.peers.empty()) {
      return {false, "nobody of that name is here"};
    }
    return {true, ""};
  }
  Answer Take(const GrabRequest& grab) {
    if (!refuse.empty()) return {false, refuse};
    for (std::size_t i = 0; i < now.bodies.size(); ++i) {
      if (now.bodies[i].name != grab.body) continue;
      now.bodies[i].in_hand = true;
      now.hand.body = static_cast<std::int64_t>(i);
      now.hand.state = SnapshotHand::State::kHolding;
      now.hand.X_WG = {*grab.grasp_W, {0, 0, 0, 1}};
      now.hand.goal = now.hand.X_WG;
      X_GB = ToPose(now.hand.X_WG).Inverse() * ToPose(now.bodies[i].X_W);
    }
    return {true, ""};
  }
  void Drop(SnapshotHand::State state) {
    for (SnapshotBody& body : now.bodies) body.in_hand = false;
    now.hand.body = -1;
    now.hand.state = state;
  }
  void Step() {
    ++now.frame;
    now.contacts.clear();
    now.contact_points = 0;
    now.hand.force_N = {};
    if (now.hand.body < 0) return;
    const double beyond = now.hand.goal.p_W[0] - wall_x;
    now.hand.X_WG = now.hand.goal;
    now.hand.X_WG.p_W[0] = std::min(now.hand.goal.p_W[0], wall_x);
    if (beyond > 0) {
      now.hand.force_N = {100 * beyond, 0, 0};
      now.contact_points = 1;
      now.contacts.push_back({now.hand.X_WG.p_W, {-1, 0, 0}, 0, 100 * beyond});
    }
    now.bodies[static_cast<std::size_t>(now.hand.body)].X_W = ToPlain(ToPose(now.hand.X_WG) * X_GB);
  }
};

}  // namespace tandem
