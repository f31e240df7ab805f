#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "collab/lab/lab_case.h"
#include "collab/peer.h"

namespace tandem {

/// What one frame of one user shows the lab; the same of a simulated peer, of a live one and of a
/// replayed recording.
struct UserFrame {
  RigidState state;           // of the own instance
  double ground_damping = 0;  // N s/m, of the law
  std::size_t link_count = 0;
  std::array<LinkView, kMaxLinks> links{};
  std::array<Wrench, kMaxLinks> links_B_W{};  // as applied
  Wrench felt_W;                              // by the hand
  double guarded_share = 1;                   // of that wrench which the force guard let through
  bool trapped = false;                       // a wall is between the instances
};

/// False while the peer does not hold the body or a loop is open.
bool Observe(const Peer& peer, std::int64_t now_ns, UserFrame& out);

/// All that is measured of a run (notes on stability, section 5). Growth, tail and energy count
/// turning as well: v^2 is v.v + w.(I/m)w.
struct Metrics {
  double growth = 0;           // 1/s, of ln RMS of the instances' velocities to one another
  double tail_rms = 0;         // m/s, last tenth
  double generated_J = 0;      // that all links gave at the most, their drags included
  double peak_apart = 0;       // m, any two instances
  double last_apart = 0;       // m, mean of the last second
  double peak_turn = 0;        // rad, any two
  double settle_s = 0;         // from the last push or waypoint until they stay within 2 mm of
                               // their last distance; NaN: never
  double band_low_rms = 0;     // m/s, 1 to 10 Hz, of the velocity between the first two
  double band_high_rms = 0;    // m/s, 10 to 100 Hz
  double peak_force = 0;       // N, felt by any hand
  double peak_force_rate = 0;  // N/s
  double link_force = 0;       // N, any link at the most
  double guarded_share = 0;    // of frames in which a force guard held back
  double clip_share = 0;       // of frames in which an energy gate held back
  double stiffness = 0;        // N/m of a link, mean of the last second
  double least_stiffness = 0;
  double loop_age_s = 0;  // mean of the last second
  bool blew_up = false;   // not a number, or 0.5 m apart
  std::int64_t frames = 0;
  std::int64_t trapped_frames = 0;
};

enum class Verdict : std::uint8_t { kStable, kUnstable, kUndecided };
const char* NameOf(Verdict verdict);

/// Unstable: it blew up, or its velocity grows and is above 0.1 mm/s at the end, or is above 2 mm/s
/// there. Undecided: fewer than five windows of growth.
Verdict Judge(const Metrics& metrics);

/// Watches a run frame by frame, in bins of 50 ms: what it keeps does not grow with the users.
class Meter {
 public:
  /// `tau_s`: one-way delay, for the windows of growth; `judged_from_s`: pushes and waypoints are
  /// over then.
  Meter(const Inertia& body, double tau_s, double judged_from_s);

  /// A frame of 1 ms, all users. One who is out of the session for it is left out.
  void See(std::span<const UserFrame> users);
  Metrics Finish() const;

 private:
  struct Bin {
    double relative = 0;  // sums of squares
    double all = 0;
    int frames = 0;
  };
  Inertia body_;
  double tau_s_;
  double judged_from_s_;
  std::vector<Bin> bins_;
  Metrics running_;
};

}  // namespace tandem
