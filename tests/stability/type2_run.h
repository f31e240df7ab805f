#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "collab/simulated/simulated_session.h"
#include "engine/haptics/hand_script.h"

namespace tandem::testing {

/// Users of one shared box in free space, each a whole peer, in virtual time.
struct Type2Case {
  std::size_t users = 2;
  LinkConditions conditions{};  // of every link, each way
  double publish_hz = 1000;
  SharedBody::Options coupling{};
  HandImpedance hand{};                       // of all
  std::vector<HandImpedance> hands{};         // of the first ones, where they differ
  std::vector<std::vector<Waypoint>> ways{};  // of the first ones; the others stay
  double seconds = 12;                        // from when all loops are closed
  double kick = 0;                            // N for 50 ms, on the first hand, one second in
  /// Called before each frame, with the frame's number since all loops are closed.
  std::function<void(SimulatedSession&, int)> before{};
};

struct Type2Run {
  double growth = 0;               // 1/s, of the velocities' RMS, last two thirds
  double tail_rms = 0;             // m/s, last tenth
  double generated = 0;            // J that the links gave at the most, their drag included
  double peak_apart = 0;           // m, between the first two
  double last_apart = 0;           // m, mean of the last second
  double last_force = 0;           // N, of the first's link, mean of the last second
  double last_stiffness = 0;       // N/m
  double disagreement = 0;         // of that link's two wrenches, at the end
  double clip_share = 0;           // of frames in which a gate acted
  double longest_loop = 0;         // s, as told at the end
  std::vector<double> hand_force;  // N, of the first user
  std::vector<double> link_force;  // N, all links on the first user
  std::vector<double> link_each;   // N, of its first link

  /// What is bounded by a limit of speed or force need not grow: its tail tells.
  bool stable() const {
    return peak_apart < 0.5 && tail_rms < 2e-3 && (growth <= 0 || tail_rms < 1e-4);
  }
};

HandImpedance HandsOff();
HandImpedance HeavyHand();

/// The model that all of these use: made once.
std::shared_ptr<const WorldModel> SharedBoxInSpace();
std::unique_ptr<PeerNode> UserOf(const Type2Case& test, std::size_t user);
Type2Run RunType2(const Type2Case& test);

}  // namespace tandem::testing
