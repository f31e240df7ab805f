#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <string>

#include "collab/controller/control_scene.h"
#include "collab/controller/controlled_peer.h"
#include "collab/controller/simulation_facts.h"
#include "collab/holdings.h"

namespace tandem {

/// What hosts ask of the hand, one task at a time: to take a part, to let go of it, to hand it
/// over, to drive it back along its way. A state machine, fed with what the simulation and the
/// session say.
///
///   take        [let go ->] aim -> take -> in hand
///   back        go back
///   undo, reset [aim -> take ->] go back -> let go -> forget that way [-> take the next]
///
/// To aim: the hand's device is told of the part first, so that it is there when the part is taken.
class HandTask {
 public:
  static constexpr std::int64_t kTakeNs = 7'000'000'000;  // nobody's answer is told after 5 s
  static constexpr std::int64_t kStepNs = 2'000'000'000;  // for all else that takes a frame or two

  explicit HandTask(ControlledPeer& peer) : peer_(&peer) {}

  struct Ended : Answer {
    std::uint64_t tag = 0;
  };

  /// The tag of the task that begins next; 0: nobody waits for its answer.
  void Next(std::uint64_t tag) noexcept { next_tag_ = tag; }
  /// Each begins a task; the one before it ends, and TakeEnded() has its answer.
  void Take(int moving, const GrabRequest& request, const ControlScene& scene, std::int64_t now_ns);
  void AskFor(int moving, const ControlScene& scene, std::int64_t now_ns);
  void LetGo(std::int64_t now_ns);
  void Give(PeerId to, std::int64_t now_ns);
  void GoBack(RetraceRequest::To to, std::int64_t now_ns);
  /// Ends the task, with that answer.
  void End(const Answer& answer);

  void OnFacts(const SimulationFacts& facts, const ControlScene& scene, std::int64_t now_ns);
  void OnNews(const HoldingNews& news, const std::string& line, const ControlScene& scene);

  bool busy() const noexcept { return step_ != Step::kNone; }
  bool going_back() const noexcept {
    return step_ != Step::kNone && back_;
  }  /// The answers to tasks that have ended, one after the other.
  std::optional<Ended> TakeEnded();

  /// A goal for the hand; ends a way back.
  void Mean(GoalOrder::Input input, const Pose& X_WG, const Vec3& linear, const Vec3& angular);
  /// The goal stays where the hand is.
  void Hold(const Pose& X_WG);
  GoalLimits& limits() noexcept { return order_.limits; }
  void TellLimits() { peer_->Tell(order_); }

 private:
  enum class Step : std::uint8_t {
    kNone,
    kFreeing,  // lets go, to take again
    kAiming,
    kTaking,
    kAsking,   // has asked another for it
    kLeaving,  // lets go, and that is all
    kGiving,
    kBack,     // on the way
    kPutting,  // lets go after the way
    kDropping  // the way is being forgotten
  };

  void Begin(Step step, std::int64_t now_ns);
  void Enter(Step step, std::int64_t now_ns);
  bool Order(Command::Kind kind, ObjectId object = kNoObject, PeerId to = 0);
  /// Tells the device; then comes kAiming, and kTaking or kAsking.
  void Aim(bool keeps_way, Step then, std::int64_t now_ns);
  void TellWay(GoalOrder::Way way);
  void OnBack(const SimulationFacts& facts, const ControlScene& scene, std::int64_t now_ns);
  /// Undo and reset: takes the part of the newest way, or says that all is done.
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
  bool keep_way_ = false;  // it was not gone to its end
  std::string stopped_by_;
  int parts_ = 0;              // brought back so far
  Step then_ = Step::kTaking;  // after kAiming
  std::uint64_t tag_ = 0;
  std::uint64_t next_tag_ = 0;
  std::deque<Ended> ended_;
};

}  // namespace tandem
