#pragma once

#include <vector>

#include "collab/simulated/checkers/violations.h"
#include "collab/simulated/network/simulated_session.h"

namespace tandem {

/// Judges the bodies as each peer simulates them in the light scene, whose moving bodies are boxes
/// of 40 mm.
///
/// - All are finite, and a body in hand does not jump.
/// - No body passes into the body in hand, unless it was in it when the hand took that. Bodies in
///   others' hands may overlap here, each as old as its way. A shared body on its way from one
///   hand's instance to another's may be in the plate.
/// - A mirror within a voxel of the body in hand moves at most by its share of the travel limit.
class MotionChecker {
 public:
  static constexpr double kMostOverlap = 4e-3;  // m, two voxels: layers reach as deep
  // m a frame. A pair may approach by half a voxel in a frame, and a mirror that gives way by at
  // most half of that. If it turns by 0.01 rad, its arc exceeds the chord by a part in 100,000.
  static constexpr double kMostMirrorTravel = 0.5e-3 * (1 + 1e-5);

  /// With `fast`, hands move bodies by more than a voxel a frame; a motion that the velocity
  /// explains is no jump.
  MotionChecker(const WorldModel& model, Violations& violations, bool fast = false)
      : model_(&model), violations_(&violations), fast_(fast) {}

  /// Names the hostile peer. Its bodies go wherever it says.
  void SetHostile(PeerId peer) { hostile_ = peer; }
  /// Notes a grant or release, which says where a body is.
  void OnHostileEvent(const Event& event);
  /// Judges a frame; call it after every frame.
  void Check(SimulatedSession& session);

 private:
  struct Seen {
    bool known = false;
    bool near = false;     // within a voxel of the body in hand; contact begins at half of it
    bool excused = false;  // it overlapped the body in hand when that was taken, or was put there
    Pose X_WB;
  };

  struct Placed {            // placed by the hostile member
    std::int64_t ns = 0;     // last time; 0: never
    bool untouched = false;  // in no hand since then
  };

  void SeePlaced(SimulatedSession& session);
  bool IsPlaced(std::size_t body) const;
  void CheckHeld(SimulatedSession& session, std::size_t member, std::size_t held);

  const WorldModel* model_;
  Violations* violations_;
  bool fast_;
  PeerId hostile_ = 0;                   // 0: none
  std::vector<std::vector<Seen>> seen_;  // [member][body], a frame ago
  std::vector<Placed> placed_;           // indexed by body
  std::int64_t now_ns_ = 0;
  std::vector<int> held_;       // per member: body simulated in its hand a frame ago
  std::vector<bool> in_plate_;  // per member: the body was taken in the plate and is still there
};

}  // namespace tandem
