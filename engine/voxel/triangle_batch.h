#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "engine/voxel/triangle_rows.h"

namespace tandem {

/// Marks small triangles in a block of 64^3 voxels, eight at a time, with a triangle in each lane
/// of a vector. TriangleRows does the same one by one and row by row. Bits and crossings are the
/// same. A triangle is left to TriangleRows if it has more than a few rows, or a bound so close to
/// a voxel's border that rounding could move it.
class TriangleBatch {
 public:
  static constexpr std::size_t kLanes = 8;
  /// The greatest number of rows along y, and along z, of a triangle here.
  static constexpr std::int32_t kMostRows = 8;

  /// A voxel's side is 2^kSnapBits units. `first` is the block's lowest voxel. `rows` are
  /// kBrickRows and TriangleRows::kPadding more. Crossings are as of TriangleRows::Mark, in no
  /// order.
  TriangleBatch(const GridIndex& first, std::uint64_t* rows, std::vector<Crossing>* crossings)
      : first_(first), rows_(rows), crossings_(crossings) {}

  /// Adds a triangle. Its corners must stay where they are until Finish().
  void Add(const SnappedPoint& a, const SnappedPoint& b, const SnappedPoint& c, int facing);
  /// Marks the triangles that are left.
  void Finish();

  /// Triangles of about as many rows, lane by lane.
  struct alignas(64) Lanes {
    template <typename T>
    using ByLane = std::array<T, kLanes>;

    std::array<std::array<ByLane<std::uint64_t>, 3>, 3> p;  // corners in units, from its own box
    std::array<ByLane<double>, 3> size;                     // size of its box, voxels
    std::array<ByLane<double>, 3> offset;                   // place of its box in the block, voxels
    ByLane<double> facing;
    ByLane<std::uint32_t> row;  // row of its box's lowest corner, modulo kBrickRows
    ByLane<std::array<const SnappedPoint*, 3>> corners;
    std::size_t count = 0;
    std::int32_t rows_y = 0;  // the most of any lane
    std::int32_t rows_z = 0;
  };
  /// The result: by row y + rows_y z, then by lane.
  struct alignas(64) Marks {
    std::array<std::array<std::uint64_t, kLanes>, kMostRows * kMostRows> bits;
    /// First voxel beyond the crossing.
    std::array<std::array<double, kLanes>, kMostRows * kMostRows> from;
    std::array<std::uint8_t, kMostRows * kMostRows> crossed;  // lanes that have a crossing
    unsigned facing_x;  // lanes whose normal is along rising x
    unsigned doubtful;  // lanes left to TriangleRows
  };

 private:
  void Flush(Lanes& lanes);

  GridIndex first_;
  std::uint64_t* rows_;
  std::vector<Crossing>* crossings_;
  std::array<Lanes, 3> lanes_;  // for up to 2, 4 and 8 rows
  Marks marks_;
};

}  // namespace tandem
