#pragma once

#include <cmath>
#include <cstdint>
#include <memory>
#include <vector>

#include "engine/base/linearized_force.h"
#include "engine/contact/pair/body_pair.h"
#include "engine/contact/pair/broad_phase.h"
#include "engine/contact/pair/clearance.h"
#include "engine/contact/pair/contact_model.h"
#include "engine/contact/pair/pair_travel.h"
#include "engine/contact/pair/tangent_plane.h"
#include "engine/contact/schedule/schedule.h"
#include "engine/voxel/map/voxmap.h"
#include "engine/voxel/points/pointshell.h"

namespace tandem {

/// Options of a pair: how it is tested, and how its contacts push.
struct PairOptions {
  int force_layer = 2;
  bool both_move = false;  // both bodies move: cross() is kept
  ScheduleOptions schedule{};
  /// Reads a voxmap that is in memory in part; null where all of it is.
  VoxelReader* reader = nullptr;
};

/// A pointshell body against a voxmap body: the plain model (paper §2.1).
class ContactPair final : public BodyPair {
 public:
  /// `X_BV` places V in the voxmap's body; `map_radius` is the largest distance of that body's
  /// surface from its frame's origin, m (0 for what never moves). `shell` and `voxmap` must outlive
  /// the pair.
  ContactPair(const Pointshell& shell, const Voxmap& voxmap, const Pose& X_BV, double map_radius,
              const PairOptions& options, const ContactGains& gains);
  PairReport Collide(const BodyMotion& shell_body, const BodyMotion& map_body,
                     LinearizedForce& on_shell, LinearizedForce& on_map) noexcept override;
  void Announce(const BodyMotion& shell_body, const BodyMotion& map_body) noexcept override;
  void Rest() noexcept override;
  TestDemand test_demand() const noexcept override;
  void LimitTravel(double metres) noexcept override;
  /// Between whole layers, contact pushes as deep as `layers` says, and the points in the thicker
  /// layer are tested.
  void SetClearance(const Clearance& clearance) noexcept override;
  ClearanceBounds clearance_bounds() const noexcept override;
  double voxel_size() const noexcept override { return voxmap_->voxel_size(); }
  Pose X_BV() const noexcept override { return X_BV_; }
  PoseReading Read(const BodyMotion& shell_body, const BodyMotion& map_body) noexcept override;
  std::span<const Contact> contacts() const noexcept override {
    return {contacts_.data(), contact_count_};
  }

  const Voxmap& voxmap() const noexcept { return *voxmap_; }
  Schedule& schedule() noexcept { return *schedule_; }
  const Schedule& schedule() const noexcept { return *schedule_; }
  const PointBlocks& blocks() const noexcept { return *blocks_; }

 private:
  /// Returns a lower bound of the distance between the shell's points and the map's marks as of the
  /// last Collide(), m. Above zero nothing can be in contact and nothing is tested.
  double Gap() const noexcept { return gap_ - std::abs(schedule_->displacement()); }
  /// Adds a point to candidates_; when that is full, reports it and drops the point.
  void AddCandidate(std::size_t block, std::uint32_t lane, PairReport& report) noexcept;
  /// Finds where a candidate is and which mark it reads.
  void Place(const Pose& X_VS, const Mat3& R_VS, const VoxelTransform& transform,
             Candidate& candidate) const noexcept;
  /// Finds the candidates' contacts; workers may share the work.
  void FindContacts(const Pose& X_VS, const VoxelTransform& transform) noexcept;
  /// Adds the loads of the contacts.
  void AddForces(const Pose& X_VS, const BodyMotion& shell_body, const BodyMotion& map_body,
                 const Pose& X_WV, PairReport& report, LinearizedForce& on_shell,
                 LinearizedForce& on_map) noexcept;

  static constexpr std::size_t kMostCandidates = 1 << 14;
  static constexpr std::size_t kPiece = 32;  // candidates of a piece, some microseconds
  static constexpr std::size_t kBlocks = 6;  // blocks whose tests take as long as a candidate

  const Pointshell* shell_;
  const Voxmap* voxmap_;
  Pose X_BV_;
  double map_radius_;
  Extent shell_extent_;
  Extent map_extent_;
  ContactGains gains_;
  bool both_move_;
  VoxelReader* reader_;
  WorkerPool* workers_;      // null: none
  std::size_t shared_from_;  // candidates from which on the work is shared
  std::unique_ptr<const PointBlocks> blocks_;
  std::unique_ptr<Schedule> schedule_;
  std::vector<Candidate> candidates_;
  std::size_t candidate_count_ = 0;
  std::vector<Contact> contacts_;
  std::size_t contact_count_ = 0;
  double query_cost_ = 0;  // query cost of the last frame

  PairTravel travel_;
  double waiting_ = 0;  // travel that the schedule has not been told, m: nothing is near
  double gap_ = 0;      // gap at the last call, m, for points that are not displaced
};

}  // namespace tandem
