#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/contact/features/body_features.h"
#include "engine/contact/schedule/due_calendar.h"
#include "engine/contact/schedule/schedule.h"
#include "engine/field/query/distance_field.h"

namespace tandem {

/// The reach up to which edges that cross are met as lines, voxels, where force begins farther off.
/// Points a voxel apart along an edge are at most a tenth of a voxel farther from what crosses it
/// there.
inline constexpr double kMostEdgeReach = 1.5;
inline double EdgeReach(double reach) noexcept {
  return std::min(reach, kMostEdgeReach);
}

/// Chooses which feature points of one body are looked up in another body's distance field in a
/// frame, and finds which of them touch (decision 0041). It guarantees that a point nearer than the
/// reach of contact is found in that frame, whatever the motion. The condition is that `motion` is
/// never less than the pair's real motion.
///
/// Each block of points stands in a calendar for the travel after which some of its points may
/// touch: their least distance, less the reach. Chunks whose blocks are all far stand there whole.
/// A block that is due is looked up at its middle. Its points are looked up only if the middle is
/// near.
///
/// F is the frame of the own field of the features' body; V is the frame of the other body's field.
/// Lengths are in voxels, which are the same in both. Used by one thread, which may have workers;
/// no call allocates.
class FieldSchedule {
 public:
  /// The centre of the pair's rotation in PairMotion: a place of F if the features turn, otherwise
  /// of V. `radius`: the greatest distance of that body's surface from it.
  struct Centre {
    Vec3 place = Vec3::Zero();
    bool of_features = false;
    double radius = 0;
  };
  /// `other`: the features of the field's body, whose sharp edges others may cross; null: edges are
  /// not tested. `coherence` off: everything is due in every frame. All arguments must outlive the
  /// schedule.
  FieldSchedule(const BodyFeatures& features, const DistanceField& field, const BodyFeatures* other,
                const Centre& centre, const ScheduleOptions& options);

  struct NearBlock {
    std::uint32_t block = 0;
    std::uint16_t touching = 0;  // lanes nearer than the reach
    std::uint16_t crossing = 0;  // lanes whose sharp edge may meet another
    std::uint16_t nearer = 0;    // touching lanes that may be nearer than the inner reach
    float count = 0;             // touching lanes; one just within the reach counts less than 1
  };
  /// Tests what is due. `motion`: of one body against the other since the last call, never less
  /// than the real one. `inner`: the inner reach, at most `reach`.
  void Test(const Pose& X_VF, const PairMotion& motion, double reach, double inner) noexcept;
  /// Returns the near blocks of the last Test(), in rising order.
  std::span<const NearBlock> near() const noexcept { return {near_.data(), near_count_}; }
  const TestCounts& counts() const noexcept { return counts_; }
  /// Counts the points nearer to the surface than the reach of the last Test(), at the same `X_VF`,
  /// that it did not find. Looks up every point. For tests; allocates.
  std::size_t CountUnfound(const Pose& X_VF) const;

  /// The farthest that the bodies come nearer in a frame where anything is near, voxels:
  /// MaxTravel's bound.
  static constexpr double kMostTravel = 0.5;
  /// Return the point tests that the next frame owes if nothing moves, and how many more with each
  /// voxel of travel, up to kMostTravel. They count by the cost of each block when it was last due.
  double due_tests() const noexcept;
  double due_tests_per_voxel() const noexcept;
  /// Returns the voxels of travel before anything is due.
  double free_travel() const noexcept {
    return std::min(calendar_.FreeTravel(), chunks_.FreeTravel());
  }

  /// Looks up every point. Returns a bound of the distance of the nearest point or edge, near the
  /// surface to a tenth of a voxel. near() then comes from all points. Reaches are as of Test().
  double Read(const Pose& X_VF, double reach, double inner) noexcept;

 private:
  static constexpr std::size_t kPiece = 64;  // blocks of a piece
  /// The gap of a block by its middle, voxels, from which on its points are not looked up.
  static constexpr double kMiddleEnough = 0.5;
  /// The gap from which on it need not stand in the calendar itself, if all blocks of its chunk are
  /// as far.
  static constexpr double kFar = 12.0;

  void Place(const Pose& X_VF) noexcept;
  /// Puts a chunk into the calendar if it is far as a whole; returns whether it did.
  bool PutIfFar(std::uint32_t chunk) noexcept;
  /// Returns the distance from the centre, for a place in F and the same place in V.
  double RadiusOf(const Vec3& place_F, const Vec3& place_V) const noexcept {
    return ((centre_.of_features ? place_F : place_V) - centre_.place).norm();
  }
  void AddDue(std::uint32_t block) noexcept {
    const std::uint32_t word = block >> 6U;
    is_due_[word] |= std::uint64_t{1} << (block & 63U);
    due_words_[word >> 6U] |= std::uint64_t{1} << (word & 63U);
  }
  /// Looks up the blocks due_[begin, end).
  void TestDue(std::size_t begin, std::size_t end) noexcept;
  struct BlockResults;
  void QueryPoints(std::span<const std::uint32_t> which) noexcept;
  /// Finds which touching lanes are within the inner reach. `bounds`: as of QueryEdges().
  void SortByReach(const float* bounds, BlockResults& results) const noexcept;
  /// Finds which sharp edges of a block may cross others. `bounds`: lower bounds of the distances
  /// of its points.
  void QueryEdges(std::uint32_t block, const float* bounds, BlockResults& results) noexcept;
  void TestAll() noexcept;
  void PutDue() noexcept;
  /// Returns what a block's edges will cost when it is due. Edges whose gaps are known beyond the
  /// last frame's travel are added to edges_ahead_, for travel.
  std::uint32_t EdgeCost(std::uint32_t block, const BlockResults& results) noexcept;

  const BodyFeatures* features_;
  const DistanceField* field_;
  const BodyFeatures* other_;
  ScheduleOptions options_;
  Centre centre_;
  DueCalendar<8> calendar_;  // blocks
  DueCalendar<1> chunks_;    // chunks that are far as wholes
  double reach_ = 0;
  double inner_ = 0;   // inner reach
  PairMotion motion_;  // motion of the last Test()
  double pace_ = 0;    // travel of a place as far out as the body's edge in the last Test(), voxels
  double middle_enough_ = kMiddleEnough;  // gap from which on points of a block are not looked up
  Mat3 R_VF_ = Mat3::Identity();
  std::array<float, 9> rows_{};
  Vec3 p_VF_ = Vec3::Zero();

  std::vector<std::uint8_t> is_far_;  // per block, as it was last looked up
  /// Per block: the odometer's reading up to which none of its edges can cross another, except in
  /// some lanes, and the cost of finding out. Empty where edges are not tested.
  struct EdgesDue {
    double at = 0;
    std::uint32_t ring = 0;
    std::uint32_t compared = 0;
    std::uint16_t crossing = 0;
  };
  std::vector<EdgesDue> edges_due_;
  std::vector<std::uint32_t> far_in_;     // per chunk: number of its far blocks
  std::vector<std::uint64_t> is_due_;     // one bit for each block
  std::vector<std::uint64_t> due_words_;  // one bit for each word of is_due_ that is not 0
  std::vector<std::uint32_t> due_;        // blocks, by rising number
  std::size_t due_count_ = 0;
  std::vector<std::uint32_t> due_chunks_;
  /// The results of the blocks of due_.
  struct BlockResults {
    float gap = 0;
    float out = 0;  // distance from the centre
    std::uint16_t touching = 0;
    std::uint16_t crossing = 0;
    std::uint16_t nearer = 0;
    float count = 0;
    bool points = false;  // its points were looked up
    std::uint32_t compared = 0;
  };
  std::vector<BlockResults> results_;
  std::vector<NearBlock> near_;
  std::size_t near_count_ = 0;
  double edges_ahead_ = 0;
  TestCounts counts_;
};

}  // namespace tandem
