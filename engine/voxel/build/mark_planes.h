#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "engine/base/huge_vector.h"
#include "engine/voxel/build/growing_marks.h"
#include "engine/voxel/build/mark_packing.h"
#include "engine/voxel/build/surface_bricks.h"
#include "engine/voxel/map/voxmap_image.h"

namespace tandem {

/// Makes the planes of marks of one hyperchunk at a time (paper §3.1, §4); one object for each
/// thread.
///
/// A cube of bits grows from the sources by one voxel in all directions per step, and the voxels
/// that a step adds are one voxel farther. The sets are nested. So each binary digit of the marks
/// is the exclusive or of the sets at whose rim that digit changes. No voxel is examined by itself,
/// and rows of zeros are skipped in eights. Digits become marks chunk by chunk, by transposition.
///
/// The cube holds kHalo voxels all round. Fields of a wider range grow in rounds of that many
/// voxels, each from the result of the round before.
class MarkPlanes {
 public:
  /// `rounds`: the sources, then GrownSources() of the round before, Rounds(range) in all. They
  /// must outlive this object.
  MarkPlanes(std::span<const SurfaceBricks> rounds, int range, int bits);

  static std::size_t Rounds(int range) {
    return static_cast<std::size_t>((range + kHalo - 1) / kHalo);
  }

  /// Starts a hyperchunk.
  void Begin(const GridIndex& place);
  /// Appends the planes of a field, and notes them in the record, numbered from the first plane
  /// since Begin(). In the surface field `inside` has kBrickRows rows, null for none; `solid`
  /// instead if all but the surface is inside.
  void Add(Field field, const std::uint64_t* inside, bool solid);

  /// Grows the last round's sources in and round the hyperchunk by kHalo voxels, and writes the
  /// hyperchunk's kBrickRows rows. Returns false if there is nothing to grow.
  bool Grown(Field field, std::uint64_t* rows);

  const VoxmapRecord& record() const noexcept { return record_; }
  const HugeVector<std::uint8_t>& planes() const noexcept { return planes_; }
  /// Returns the number of voxels within the range of a surface voxel, on either side, including
  /// surface voxels.
  std::uint64_t band_voxels() const noexcept { return band_voxels_; }

  static constexpr int kHalo = GrowingMarks::kHalo;

 private:
  bool Gather(const SurfaceBricks& bricks, Field field, int range);
  void ClearCube();

  std::span<const SurfaceBricks> rounds_;
  int range_;
  int bits_;
  GridIndex place_;
  VoxmapRecord record_;
  HugeVector<std::uint8_t> planes_;
  std::uint32_t plane_count_ = 0;
  std::uint64_t band_voxels_ = 0;
  std::unique_ptr<GrowingMarks> growing_;
};

/// Returns the sources of all fields with all voxels within MarkPlanes::kHalo voxels of them, in
/// the same box. Works in parallel.
SurfaceBricks GrownSources(const SurfaceBricks& bricks);

}  // namespace tandem
