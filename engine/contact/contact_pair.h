#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "engine/base/load.h"
#include "engine/contact/broad_phase.h"
#include "engine/contact/clearance.h"
#include "engine/contact/contact_model.h"
#include "engine/contact/schedule.h"
#include "engine/contact/tangent_plane.h"
#include "engine/voxel/pointshell.h"
#include "engine/voxel/surface_details.h"
#include "engine/voxel/voxmap.h"

namespace tandem {

class RefinedContacts;

/// Where a body of a pair is and how it moves.
struct BodyMotion {
  Pose X_WB;
  Twist V_WB;
};

/// Of an exact look: what it takes to ask a sieve (NearPieces) whether a point can push.
inline constexpr double kSiftShare = 0.08;

/// What a frame's test of a pair found.
struct PairReport {
  int contact_points = 0;      // marks <= 2 + layer, by the class rule
  int clear_points = 0;        // of these, known to make no contact yet (refined model)
  int looks = 0;               // exact looks at single points
  int sifted_points = 0;       // points that a sieve looked at, for a kSiftShare of a look each
  double look_work = 0;        // what these, asking and adding up came to, in exact looks
  int loaded_points = 0;       // of the contact points, below their tangent plane
  bool over_capacity = false;  // more contacts than can be held; the rest did not push
  TestCounts tests;
};

/// What a single pose says, every point read (for `tandem contact`).
struct PoseReading {
  int contact_points = 0;
  int touching_points = 0;  // marks <= 2 + layer in the surface field, whatever the class
  int nearest_voxels =
      std::numeric_limits<int>::max();  // least distance read; max when all are beyond
  Load on_shell;
};

/// How a pair is tested, and what its contacts do.
struct PairOptions {
  int force_layer = 2;  // at least LeastForceLayer() of the model, which is checked
  /// With these the refined model, on a pointshell whose points stand on features; without them the
  /// plain one. Must outlive the pair.
  const SurfaceDetails* details = nullptr;
  bool both_move = false;  // then cross() is kept
  ScheduleOptions schedule{};
};

/// A pointshell body against a voxmap body (paper §2.1). All contact arithmetic lives in the
/// voxmap's frame V; the sums go back to W. Equal and opposite: both bodies get the same force at
/// the same places.
class ContactPair {
 public:
  /// `X_BV` places V in the voxmap's body; `map_radius` is the largest distance of that body's
  /// surface from its frame's origin, m (0 for what never moves). `shell` and `voxmap` must outlive
  /// the pair.
  ContactPair(const Pointshell& shell, const Voxmap& voxmap, const Pose& X_BV, double map_radius,
              const PairOptions& options, const ContactGains& gains);
  ContactPair(ContactPair&&) noexcept;
  ContactPair& operator=(ContactPair&&) noexcept;
  ~ContactPair();

  /// Tests what has come due since the last call and adds what contact puts on both bodies. Does
  /// not allocate.
  PairReport Collide(const BodyMotion& shell_body, const BodyMotion& map_body, Load& on_shell,
                     Load& on_map) noexcept;

  /// How the last Collide()'s load on the shell changes as the map moves; the transpose the other
  /// way round. Kept for pairs that both move.
  const CrossLoad& cross() const noexcept { return cross_; }

  /// What the next frames' tests and looks will cost, as of the last Collide() (paper §5, Eqn. 2).
  TestLoad load() const noexcept;

  /// How far the two bodies may come towards one another before the next Collide(), m.
  void LimitTravel(double metres) noexcept;

  /// From the next Collide() on. Between whole layers contact pushes as deep as they say, and what
  /// the thicker one holds is tested. At least LeastForceLayer() of the model, which is checked.
  void SetClearance(const Clearance& clearance) noexcept;
  const Clearance& clearance() const noexcept { return clearance_; }

  /// Reads every point, whatever the schedule.
  PoseReading Read(const BodyMotion& shell_body, const BodyMotion& map_body) noexcept;

  const Voxmap& voxmap() const noexcept { return *voxmap_; }
  /// Where the bodies pushed each other in the last Collide() or Read().
  std::span<const Contact> contacts() const noexcept { return {contacts_.data(), contact_count_}; }
  Schedule& schedule() noexcept { return *schedule_; }
  const Schedule& schedule() const noexcept { return *schedule_; }
  const PointBlocks& blocks() const noexcept { return *blocks_; }

 private:
  /// The most that surface points of the two bodies can have come nearer since the last call, m.
  double TravelSince(const Pose& shell_WB, const Pose& map_WB) noexcept;
  /// Counts how the bodies turn against one another.
  void CountTurns(const Quat& q_VS) noexcept;
  /// A lower bound of the way between the shell's points and the map's marks as of the last
  /// Collide(), m: above zero, nothing can be in contact and nothing is tested.
  double Gap() const noexcept { return gap_ - std::abs(schedule_->displacement()); }
  /// A point for candidates_; the rest of them are given up when it is full.
  void AddCandidate(std::size_t block, std::uint32_t lane, PairReport& report) noexcept;
  /// Where a candidate is and what it reads.
  void Place(const Pose& X_VS, const Mat3& R_VS, const VoxelTransform& transform,
             Candidate& candidate) const noexcept;
  /// Finds the candidates' contacts, which helpers may share. `turned` as of RefinedContacts.
  void FindContacts(const Pose& X_VS, const VoxelTransform& transform,
                    const double* turned) noexcept;
  /// What the contacts come to.
  void AddForces(const Pose& X_VS, const BodyMotion& shell_body, const BodyMotion& map_body,
                 const Pose& X_WV, PairReport& report, Load& on_shell, Load& on_map) noexcept;

  /// Voxels that surfaces may still come nearer before a point can make a contact, as the refined
  /// model has told.
  double SlackOf(std::uint32_t block, std::uint32_t lane) const noexcept;
  void RememberSlack(std::span<const Candidate> candidates) noexcept;
  /// What candidates took to look at.
  struct alignas(64) LookCounts {
    int looks = 0;    // exact
    int regions = 0;  // of these, those that gave one
    int sifted = 0;
    void operator+=(const LookCounts& more) noexcept {
      looks += more.looks;
      regions += more.regions;
      sifted += more.sifted;
    }
  };
  static void Count(std::span<const Candidate> candidates, LookCounts& counts) noexcept;
  /// And what all of them did.
  void CountLooks(PairReport& report) noexcept;

  static constexpr std::size_t kMostCandidates = 1 << 14;
  static constexpr std::size_t kPiece = 32;  // candidates, some microseconds
  static constexpr std::size_t kBlocks = 6;  // whose tests take as long as a candidate

  const Pointshell* shell_;
  const Voxmap* voxmap_;
  Pose X_BV_;
  double map_radius_;
  Extent shell_extent_;
  Extent map_extent_;
  ContactGains gains_;
  bool both_move_;
  FrameHelpers* helpers_;    // null: none
  std::size_t shared_from_;  // candidates
  CrossLoad cross_;
  std::unique_ptr<const PointBlocks> blocks_;
  std::unique_ptr<Schedule> schedule_;
  std::unique_ptr<RefinedContacts> refined_;
  Clearance clearance_;
  double odometer_ = 0;   // voxels that surfaces can have come nearer since the first test
  double displaced_ = 0;  // m, of the points at the last test
  Quat q_VS_;             // at the last call
  double turned_ = 0;     // rad, in all, of one body against the other
  /// By point: the odometer before which it makes no contact; empty without coherence.
  std::vector<double> clear_until_;
  std::vector<Candidate> candidates_;
  std::size_t candidate_count_ = 0;
  std::vector<LookCounts> look_counts_;  // of each thread
  std::vector<Contact> contacts_;
  std::size_t contact_count_ = 0;
  double looks_ = 0;  // of the last frame, all but those at regions

  Pose shell_WB_;  // at the last call
  Pose map_WB_;
  bool placed_ = false;
  double waiting_ = 0;  // m of travel that the schedule has not been told of: nothing was near
  double gap_ = 0;      // m, at the last call, of points that are not displaced
};

}  // namespace tandem
