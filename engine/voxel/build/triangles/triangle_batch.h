#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "engine/voxel/build/triangles/triangle_lanes.h"
#include "engine/voxel/build/triangles/triangle_rows.h"

namespace tandem {

/// Marks small triangles in a block of 64^3 voxels, eight at a time, with a triangle in each lane
/// of a vector. TriangleRows does the same one by one and row by row. Bits and crossings are the
/// same. A triangle is left to TriangleRows if it has more than a few rows, or a bound so close to
/// a voxel's border that rounding could move it.
class TriangleBatch {
 public:
  /// A voxel's side is 2^kSnapBits units. `first` is the block's lowest voxel. `rows` are
  /// kBrickRows and TriangleRows::kPadding more. Crossings are as of TriangleRows::Mark, in no
  /// order.
  TriangleBatch(const GridIndex& first, std::uint64_t* rows, std::vector<Crossing>* crossings)
      : first_(first), rows_(rows), crossings_(crossings) {}

  /// Adds a triangle. Its corners must stay where they are until Finish().
  void Add(const SnappedPoint& a, const SnappedPoint& b, const SnappedPoint& c, int facing);
  /// Marks the triangles that are left.
  void Finish();

 private:
  void Flush(TriangleLanes& lanes);

  GridIndex first_;
  std::uint64_t* rows_;
  std::vector<Crossing>* crossings_;
  std::array<TriangleLanes, 3> lanes_;  // for up to 2, 4 and 8 rows
  TriangleMarks marks_;
};

}  // namespace tandem
