#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <string>

#include "collab/controller/control_scene.h"
#include "collab/controller/controlled_peer.h"
#include "collab/controller/simulation_facts.h"
#include "collab/ownership/ownership.h"

namespace tandem {

/// Carries out hosts' requests to the hand, one task at a time: take a part, let go of it, hand it
/// over, drive it back along its way. A state machine, fed with facts of the simulation and the
/// session.
///
///   take        [let go ->] aim -> take -> in hand
///   back        go back
///   undo, reset [aim -> take ->] go back -> let go -> forget that way [-> take the next]
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
    kBack,     // on the way back
    kPutting,  // lets go at the end of the way
    kDropping  // forgets the way
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
  std::string NameOf(const ControlScene& scene) const;

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
  int parts_ = 0;              // parts brought back so far
  Step then_ = Step::kTaking;  // step after kAiming
  std::uint64_t tag_ = 0;
  std::uint64_t next_tag_ = 0;
  std::deque<Ended> ended_;
};

}  // namespace tandem
