#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/contact/body_features.h"
#include "engine/contact/due_calendar.h"
#include "engine/contact/schedule.h"
#include "engine/field/distance_field.h"

namespace tandem {

/// Voxels: edges that cross are met as lines up to here, where force begins farther off. Points a
/// voxel apart along an edge are at most a tenth of a voxel farther from what crosses it there.
inline constexpr double kMostEdgeReach = 1.5;
inline double EdgeReach(double reach) noexcept {
  return std::min(reach, kMostEdgeReach);
}

/// Which feature points of one body are looked up in another body's distance field in a frame, and
/// which of them touch (decision 0041). What it guarantees: a point that is nearer than the reach
/// of contact is found in that frame, whatever the motion, as long as `motion` is never less than
/// what the pair really moved.
///
/// Each block of points stands in a calendar for the travel after which some of its points may
/// touch: their least distance, less the reach. Chunks whose blocks are all far stand there whole.
/// A block that is due is looked up at its middle; only if that is near, at its points.
///
/// F: the frame of the features' body's own field; V: that of the other's. Lengths in voxels, which
/// are the same in both. Used by one thread, which may have helpers; no call allocates.
class FieldSchedule {
 public:
  /// About what the pair turns as motions tell it: a place of F if the features do, otherwise of V,
  /// and the greatest distance of that body's surface from it.
  struct Centre {
    Vec3 place = Vec3::Zero();
    bool of_features = false;
    double radius = 0;
  };
  /// `other`: the features of the field's body, whose sharp edges others may cross; null: edges
  /// are not asked for. `coherence` off: everything is due in every frame. All that is given must
  /// outlive it.
  FieldSchedule(const BodyFeatures& features, const DistanceField& field, const BodyFeatures* other,
                const Centre& centre, const ScheduleOptions& options);

  struct NearBlock {
    std::uint32_t block = 0;
    std::uint16_t touching = 0;  // lanes nearer than the reach
    std::uint16_t crossing = 0;  // lanes whose sharp edge may meet another
  };
  /// `motion`: of one body against the other since the last call, never less than it was.
  void Test(const Pose& X_VF, const PairMotion& motion, double reach) noexcept;
  /// By rising block, as of the last Test().
  std::span<const NearBlock> near() const noexcept { return {near_.data(), near_count_}; }
  const TestCounts& counts() const noexcept { return counts_; }
  /// Counts the points nearer to the surface than the reach of the last Test(), which was at
  /// `X_VF`, that it did not find. It looks up every point. For tests; allocates.
  std::size_t CountUnfound(const Pose& X_VF) const;

  /// Voxels that the bodies come nearer in a frame at the most where anything is near: MaxTravel's
  /// bound.
  static constexpr double kMostTravel = 0.5;
  /// Point tests that the next frame owes if nothing moves, and how many more with each voxel of
  /// travel, up to kMostTravel: by what each block cost when it was last due.
  double owed() const noexcept;
  double owed_per_voxel() const noexcept;
  /// Voxels before anything is due.
  double free_way() const noexcept { return std::min(calendar_.FreeWay(), chunks_.FreeWay()); }

  /// A bound of the distance of the nearest point or edge, near the surface to a tenth of a voxel;
  /// every point is looked up, and near() is of all.
  double Read(const Pose& X_VF, double reach) noexcept;

 private:
  static constexpr std::size_t kPiece = 64;  // blocks
  /// Voxels of gap of a block by its middle, from which on its points are not looked up.
  static constexpr double kMiddleEnough = 0.5;
  /// And from which on it need not stand in the calendar itself, if all of its chunk are as far.
  static constexpr double kFar = 12.0;

  void Place(const Pose& X_VF) noexcept;
  /// Puts a chunk into the calendar if it is far as a whole; tells whether.
  bool PutIfFar(std::uint32_t chunk) noexcept;
  /// Of a place and where it is in V: how far from the centre.
  double OutOf(const Vec3& place_F, const Vec3& place_V) const noexcept {
    return ((centre_.of_features ? place_F : place_V) - centre_.place).norm();
  }
  void AddDue(std::uint32_t block) noexcept {
    const std::uint32_t word = block >> 6U;
    is_due_[word] |= std::uint64_t{1} << (block & 63U);
    due_words_[word >> 6U] |= std::uint64_t{1} << (word & 63U);
  }
  /// Looks up the blocks due_[begin, end).
  void TestDue(std::size_t begin, std::size_t end) noexcept;
  struct Told;
  void LookAtPoints(std::span<const std::uint32_t> which) noexcept;
  /// Which sharp edges of a block may cross others, of which `bounds` are the distances at least of
  /// its points.
  void LookAtEdges(std::uint32_t block, const float* bounds, Told& told) noexcept;
  void TestAll() noexcept;
  void PutDue() noexcept;
  /// Tells what a block's edges will cost when it is due. Those that are known for farther than the
  /// last frame's travel are added to edges_ahead_, for travel.
  std::uint32_t EdgeCost(std::uint32_t block, const Told& told) noexcept;

  const BodyFeatures* features_;
  const DistanceField* field_;
  const BodyFeatures* other_;
  ScheduleOptions options_;
  Centre centre_;
  DueCalendar<8> calendar_;  // blocks
  DueCalendar<1> chunks_;    // those that are far as wholes
  double reach_ = 0;
  PairMotion motion_;                     // of the last Test()
  double pace_ = 0;                       // voxels, of what is as far out as the body's edge then
  double middle_enough_ = kMiddleEnough;  // from here on points of a block are not looked up
  Mat3 R_VF_ = Mat3::Identity();
  std::array<float, 9> rows_{};
  Vec3 p_VF_ = Vec3::Zero();

  std::vector<std::uint8_t> is_far_;  // by block, as it was last looked up
  /// By block: up to what odometer none of its edges can cross another, but in some lanes, and what
  /// it cost to find out. None where edges are not asked for.
  struct EdgesDue {
    double at = 0;
    std::uint32_t ring = 0;
    std::uint32_t compared = 0;
    std::uint16_t crossing = 0;
  };
  std::vector<EdgesDue> edges_due_;
  std::vector<std::uint32_t> far_in_;     // by chunk: how many of its blocks
  std::vector<std::uint64_t> is_due_;     // a bit for each block
  std::vector<std::uint64_t> due_words_;  // a bit for each word of that which is not 0
  std::vector<std::uint32_t> due_;        // blocks, by rising number
  std::size_t due_count_ = 0;
  std::vector<std::uint32_t> due_chunks_;
  /// What the blocks of due_ came to.
  struct Told {
    float gap = 0;
    float out = 0;  // from the centre
    std::uint16_t touching = 0;
    std::uint16_t crossing = 0;
    bool points = false;  // were looked up
    std::uint32_t compared = 0;
  };
  std::vector<Told> told_;
  std::vector<NearBlock> near_;
  std::size_t near_count_ = 0;
  double edges_ahead_ = 0;
  TestCounts counts_;
};

}  // namespace tandem
