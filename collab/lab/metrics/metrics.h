#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "collab/lab/case/lab_case.h"
#include "collab/lab/metrics/band_pass.h"
#include "collab/peer/peer.h"

namespace tandem {

/// The measured state of one user in one frame. It is the same for a simulated peer, a live peer
/// and a replayed recording.
struct UserFrame {
  bool present = false;       // the user holds the body; without it the other fields do not count
  std::size_t coupled = 0;    // peers whose loop is closed
  RigidState state;           // state of the own instance
  double ground_damping = 0;  // N s/m, from the law
  std::size_t link_count = 0;
  std::array<LinkView, kMaxLinks> links{};
  std::array<Wrench, kMaxLinks> links_B_W{};  // wrenches as applied
  Wrench felt_W;                              // wrench that the device was given
  std::uint64_t guarded_frames = 0;           // frames in which the guard held back, since the peer
                                              // began
  bool trapped = false;                       // a wall is between the instances
  bool pushing = false;                       // contact pushes
};

/// Fills `out` with the peer's last frame, which it made at `now_ns` of its own clock. Returns
/// out.present.
bool Observe(const Peer& peer, std::int64_t now_ns, UserFrame& out);

/// All figures of a run. Growth, tail and energy include rotation: v^2 is v.v + w.(I/m)w, summed
/// over the users.
struct Metrics {
  double growth = 0;           // 1/s, slope of ln RMS of the instances' velocities to their mean,
                               // over windows of max(0.5 s, 4 delays), last two thirds of the run
                               // and after the last push or waypoint
  int windows = 0;             // number of windows for growth; they overlap by half
  double tail_rms = 0;         // m/s, last tenth
  double generated_J = 0;      // most energy that all links together gave, their drags included
  double peak_apart = 0;       // m, any two instances
  double last_apart = 0;       // m, mean of the last second
  double peak_turn = 0;        // rad, any two instances
  double settle_s = 0;         // time from the last push or waypoint until the instances stay
                               // within 2 mm of their last distance; NaN: never
  double band_low_rms = 0;     // m/s, 0.2 to 5 Hz, velocity between the first two after the last
                               // push
  double band_high_rms = 0;    // m/s, 5 to 100 Hz: buzz of contact; a late link swings at lower
                               // frequencies
  double peak_force = 0;       // N, largest at any hand
  double peak_force_rate = 0;  // N/s
  double link_force = 0;       // N, largest of any link
  double link_force_rate = 0;  // N/s, all links of a user
  double guarded_share = 0;    // share of frames in which a force guard held back
  double clip_share = 0;       // share of frames in which an energy gate held back
  double stiffness = 0;        // N/m of a link, mean of the last second
  double least_stiffness = 0;  // N/m, lowest of any link, from a second after the first frame
  double loop_age_s = 0;       // mean of the last second
  double te_s = 0;             // delay that the laws use, mean of the last second
  bool diverged = false;       // the state is not a number, or the instances are 0.5 m apart
  std::int64_t frames = 0;
  std::int64_t trapped_frames = 0;
};

enum class Verdict : std::uint8_t { kStable, kUnstable, kUndecided };
const char* NameOf(Verdict verdict);

/// A run that blew up is unstable. Otherwise, with fewer than five windows of growth it is
/// undecided. If its velocity grows and is above 0.1 mm/s at the end, it is unstable. If its
/// velocity is at most 2 mm/s at the end, it is stable. Above that it is unstable, unless its
/// velocity at least halves in two thirds of the run's time. Then it decays, is not at rest yet and
/// is undecided.
Verdict Judge(const Metrics& metrics);

/// Returns whether a longer run may show that the case comes to rest. Then the velocity falls, and
/// at the end it is above the 2 mm/s of the verdict.
bool DecaysAboveRest(const Metrics& metrics);

/// Measures a run frame by frame, in bins of 50 ms. Its memory does not grow with the number of
/// users.
class Meter {
 public:
  /// `tau_s` is the one-way delay, for the windows of growth. Pushes and waypoints are over
  /// `judged_from_s` after the first See().
  Meter(const Inertia& body, double tau_s, double judged_from_s);

  /// Adds a frame of 1 ms with all users, in the same order each time. A user that is not present
  /// is left out.
  void See(std::span<const UserFrame> users);
  /// Adds a frame while the loops close. Only its energy counts, so that springs are empty at
  /// first.
  void SeeOpening(std::span<const UserFrame> users);
  /// Returns whether the state is not a number, or the instances are 0.5 m apart.
  bool diverged() const noexcept { return running_.diverged; }
  Metrics Finish() const;

 private:
  struct Bin {
    double relative = 0;  // sums of squares over the frames, m^2/s^2
    double all = 0;
    double apart = 0;  // sum, m
    double nearest = 0;
    double farthest = 0;
    int frames = 0;
    double links = 0;  // number of links, summed over the frames
    double stiffness = 0;
    double loop_age = 0;
    double te = 0;
  };
  struct Last {  // values of a user in the frame before
    Vec3 felt = Vec3::Zero();
    Vec3 links = Vec3::Zero();
    bool known = false;
    std::uint64_t guarded_frames = 0;
  };

  void AddWork(const UserFrame& user);
  void SeeVelocities(std::span<const UserFrame> users, Bin& bin);
  void SeeDistances(std::span<const UserFrame> users, Bin& bin);
  void SeeForces(std::span<const UserFrame> users, Bin& bin);
  double SettleTime(double last_apart) const;
  void FindGrowth(Metrics& out) const;

  Inertia body_;
  double tau_s_;
  double judged_from_s_;
  std::vector<Bin> bins_;
  std::vector<Last> last_;
  BandPass low_{0.2, 5.0};
  BandPass high_{5.0, 100.0};
  double low_squares_ = 0;
  double high_squares_ = 0;
  std::int64_t band_frames_ = 0;
  double work_ = 0;            // energy in J that the links gave so far
  double half_turn_sine_ = 0;  // squared sine of half the largest turn
  std::int64_t user_frames_ = 0;
  std::int64_t guarded_ = 0;
  std::int64_t clipped_ = 0;
  double least_stiffness_ = std::numeric_limits<double>::infinity();
  Metrics running_;
};

}  // namespace tandem
