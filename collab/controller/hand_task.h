#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "collab/controller/body_trails.h"
#include "collab/controller/control_scene.h"
#include "collab/controller/controlled_peer.h"
#include "collab/controller/simulation_facts.h"
#include "collab/controller/snapshot.h"
#include "collab/ownership/ownership.h"

namespace tandem {

/// Carries out hosts' requests to the hand, one task at a time: take a part, let go of it, hand it
/// over, drive it back along its way. A state machine, fed with facts of the simulation and the
/// session.
///
///   take   [let go ->] aim -> take -> in hand
///   back   go back
///   undo   [aim -> take ->] go back -> let go -> forget that way
///   reset  aim -> take -> lead home -> let go [-> take the next], for each body that is not at its
///          first place, whoever moved it; hand_task_reset.cpp
///
/// Aiming tells the hand's device of the part first, so that the device is there when the part is
/// taken.
class HandTask {
 public:
  static constexpr std::int64_t kTakeNs = 7'000'000'000;  // kNoAnswer comes after 5 s
  static constexpr std::int64_t kStepNs = 2'000'000'000;  // other steps take a frame or two

  explicit HandTask(ControlledPeer& peer) : peer_(&peer) {}

  struct Ended : Answer {
    std::uint64_t tag = 0;
  };

  /// Sets the tag of the task that begins next; 0: no request waits for its answer.
  void Next(std::uint64_t tag) noexcept { next_tag_ = tag; }
  /// Each begins a task. It ends the task in progress, and TakeEnded() has that one's answer.
  void Take(int moving, const GrabRequest& request, const ControlScene& scene, std::int64_t now_ns);
  void AskFor(int moving, const ControlScene& scene, std::int64_t now_ns);
  void LetGo(std::int64_t now_ns);
  void Give(PeerId to, std::int64_t now_ns);
  void GoBack(RetraceRequest::To to, std::int64_t now_ns);
  /// Ends the task with that answer.
  void End(const Answer& answer);

  void OnFacts(const SimulationFacts& facts, const ControlScene& scene, std::int64_t now_ns);
  /// Takes the names of the peers, for answers that name the peer that holds a body.
  void OnPeers(const std::vector<SnapshotPeer>& peers) { peers_ = peers; }
  void OnNews(const Notification& news, const std::string& line, const ControlScene& scene);

  bool busy() const noexcept { return step_ != Step::kNone; }
  bool going_back() const noexcept { return step_ != Step::kNone && back_; }
  /// Takes the answers of ended tasks, one after the other.
  std::optional<Ended> TakeEnded();

  /// Sets a goal for the hand; ends a way back.
  void SetGoal(GoalOrder::Input input, const Pose& X_WG, const Vec3& linear, const Vec3& angular);
  /// Holds the goal where the hand is.
  void Hold(const Pose& X_WG);
  GoalLimits& limits() noexcept { return order_.limits; }
  void TellLimits() { peer_->Tell(order_); }

 private:
  enum class Step : std::uint8_t {
    kNone,
    kFreeing,  // lets go, to take a part again
    kAiming,
    kTaking,
    kAsking,   // has asked another peer for the part
    kLeaving,  // lets go, and does no more
    kGiving,
    kBack,       // on the way back
    kPutting,    // lets go at the end of the way
    kDropping,   // forgets the way
    kLeading,    // reset: leads a body to its first place
    kSetting,    // reset: lets go of it there
    kForgetting  // reset: forgets all ways
  };

  void Begin(Step step, std::int64_t now_ns);
  void Enter(Step step, std::int64_t now_ns);
  bool Order(Command::Kind kind, ObjectId object = kNoObject, PeerId to = 0);
  /// Tells the device; afterwards comes kAiming, then `then`, which is kTaking or kAsking.
  void Aim(bool keeps_way, Step then, std::int64_t now_ns);
  void TellWay(GoalOrder::Way way);
  void OnBack(const SimulationFacts& facts, const ControlScene& scene, std::int64_t now_ns);
  /// Undo and reset: takes the part of the newest way, or reports that all is done.
  void TakeNextWay(const SimulationFacts& facts, const ControlScene& scene, std::int64_t now_ns);
  std::string NameOf(const ControlScene& scene) const { return NameOf(scene, moving_); }
  std::string NameOf(const ControlScene& scene, int moving) const;

  /// The reset in progress.
  struct Reset {
    bool begun = false;
    std::deque<int> left;            // moving bodies that have not had their turn
    std::vector<int> failed;         // bodies that did not arrive, to be tried again
    std::map<int, std::string> why;  // why a body did not arrive
    std::string words;               // the answer
    bool progress = false;           // a body has arrived since the round began
    std::size_t next = 0;            // number of the poses of `way` that lie ahead
    std::vector<Pose> way;           // from the body's first place
    Pose goal;                       // place to which the body is led
    Pose X_BG;
    std::int64_t led_ns = 0;      // time of the last step of the goal's clock
    std::int64_t stepped_ns = 0;  // time of the goal's last step
  };
  /// Reset: takes the next body, or reports that all is done.
  void TakeNextHome(const SimulationFacts& facts, const ControlScene& scene, std::int64_t now_ns);
  /// Returns why nobody here can lead that body home now; empty: this hand can.
  std::string WhyNotLed(int moving, const SimulationFacts& facts, const ControlScene& scene) const;
  void BeginLeading(const SimulationFacts& facts, std::int64_t now_ns);
  void Lead(const SimulationFacts& facts, const ControlScene& scene, std::int64_t now_ns);
  /// Ends the turn of the body: it lets go. `why`: why the body did not arrive; empty: it did.
  void SetDown(const std::string& why, std::int64_t now_ns);
  void EndReset(const ControlScene& scene, std::int64_t now_ns);
  /// Forgets one way after another, so that nothing is left to undo.
  void ForgetWays(const SimulationFacts& facts, std::int64_t now_ns);

  ControlledPeer* peer_;
  GoalOrder order_;
  Step step_ = Step::kNone;
  std::int64_t since_ns_ = 0;
  int moving_ = -1;
  ObjectId object_ = kNoObject;
  bool back_ = false;  // the task is a way back
  RetraceRequest::To to_ = RetraceRequest::To::kGrasp;
  bool arrived_ = false;
  bool keep_way_ = false;  // the way was not gone to its end
  std::string stopped_by_;
  int parts_ = 0;  // parts brought back so far
  Reset reset_;
  BodyTrails trails_;
  std::vector<SnapshotPeer> peers_;
  Step then_ = Step::kTaking;  // step after kAiming
  std::uint64_t tag_ = 0;
  std::uint64_t next_tag_ = 0;
  std::deque<Ended> ended_;
};

}  // namespace tandem
