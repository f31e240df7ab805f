#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "collab/simulated/hands/simulated_controller.h"
#include "collab/simulated/network/fault_schedule.h"

namespace tandem {

/// A host application that acts at random. It grabs, drags at 60 to 1000 Hz, pushes, goes back,
/// stops everything, sends nonsense, repeats requests, is stopped for a while, crashes or leaves.
/// On the way to the controller goals may be lost and requests take 0 to 3 ms.
class SimulatedHost {
 public:
  SimulatedHost(HostId id, std::string name, SimulatedController& site, std::uint64_t seed,
                Tally& tally);

  /// Runs a millisecond. `peers` are names of peers.
  void Frame(std::int64_t now_ns, const std::vector<std::string>& peers);
  /// Makes the host only empty the hand and end stops.
  void TidyUp() { tidies_ = true; }
  /// Returns whether the host has crashed or left with a goodbye.
  bool gone() const { return gone_; }
  const SimulatedController& site() const { return *site_; }
  HostId id() const { return id_; }

 private:
  enum class Drag : std::uint8_t { kNone, kJump, kGlide, kCircle, kRate, kPush, kNonsense };

  void Ask(const ControlRequest& request);
  void Say(HostGoal::Kind kind);
  void SayGoal();
  void ReadMail();
  void ActAtRandom(const std::vector<std::string>& peers);
  void GrabRandomBody();
  void BeginDrag();
  void SetRandomParameter();
  void SendInvalidRequest();
  void GoBack();
  void FallSilent();
  void Tidy();
  std::string RandomBody();

  HostId id_;
  std::string name_;
  SimulatedController* site_;
  SeededRandom rng_;
  Tally* tally_;
  std::int64_t now_ns_ = 0;
  std::int64_t halted_until_ns_ = 0;
  std::int64_t next_beat_ns_ = 0;
  std::int64_t next_whim_ns_ = 0;
  std::int64_t next_goal_ns_ = 0;
  std::int64_t resume_ns_ = 0;  // time at which it ends its emergency stop; 0: none
  bool gone_ = false;
  bool tidies_ = false;
  std::uint64_t next_number_ = 1;
  std::int64_t last_due_ns_ = 0;  // arrival of its last request
  HostGoal goal_;
  Drag drag_ = Drag::kNone;
  std::int64_t goal_period_ns_ = 0;
  Vec3 target_ = Vec3::Zero();
  Quat turn_ = Quat::Identity();
  Vec3 begun_at_ = Vec3::Zero();
  std::int64_t begun_ns_ = 0;
  double glide_speed_ = 0.2;  // m/s
  ControllerSnapshot seen_;   // newest
};

}  // namespace tandem
