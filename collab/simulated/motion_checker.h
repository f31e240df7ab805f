#pragma once

#include <vector>

#include "collab/simulated/breakages.h"
#include "collab/simulated/simulated_session.h"

namespace tandem {

/// What must hold of the bodies as each peer simulates them: finite; those in hand do not jump;
/// nothing passes into what the hand holds, but for what was in it when it was taken: bodies in
/// others' hands may overlap here, each as old as its way, and a shared one that is on its way from
/// one hand's instance to another's may be in the plate; a mirror within a voxel of it comes by
/// at most its share of the travel limit. Of the light scene, whose moving bodies are boxes of 40
/// mm.
class MotionChecker {
 public:
  static constexpr double kMostOverlap = 4e-3;  // m, two voxels: as deep as layers reach
  // m a frame: a pair may near by half a voxel, of which a mirror that yields has half; of one that
  // turns by 0.01 rad the arc is longer than the chord by a part in 100,000
  static constexpr double kMostMirrorTravel = 0.5e-3 * (1 + 1e-5);

  /// `fast`: hands move bodies by more than a voxel a frame; what their velocity says is no jump.
  MotionChecker(const WorldModel& model, Breakages& breakages, bool fast = false)
      : model_(&model), breakages_(&breakages), fast_(fast) {}

  /// What it answers for goes wherever it says.
  void SetHostile(PeerId peer) { hostile_ = peer; }
  /// Grants and releases say where a body is.
  void OnHostileEvent(const Event& event);
  /// After every frame.
  void Look(SimulatedSession& session);

 private:
  struct Seen {
    bool known = false;
    bool near = false;     // to the body in hand, within a voxel: contact begins at half of it
    bool excused = false;  // it overlapped what the hand took when it took it, or was put there
    Pose X_WB;
  };

  struct Placed {            // by the hostile member
    std::int64_t ns = 0;     // when last; 0: never
    bool untouched = false;  // in no hand since
  };

  void SeePlaced(SimulatedSession& session);
  bool IsPlaced(std::size_t body) const;
  void LookAtHeld(SimulatedSession& session, std::size_t member, std::size_t held);

  const WorldModel* model_;
  Breakages* breakages_;
  bool fast_;
  PeerId hostile_ = 0;                   // 0: there is none
  std::vector<std::vector<Seen>> seen_;  // [member][body], a frame ago
  std::vector<Placed> placed_;           // of each body
  std::int64_t now_ns_ = 0;
  std::vector<int> held_;       // of each member: simulated in its hand a frame ago
  std::vector<bool> in_plate_;  // of each member: what it took was in the plate, and is yet
};

}  // namespace tandem
