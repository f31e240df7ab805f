#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "engine/voxel/build/snapped_point.h"

namespace tandem {

/// Small triangles of about as many rows, one in each lane of a vector.
struct alignas(64) TriangleLanes {
  static constexpr std::size_t kLanes = 8;
  /// The greatest number of rows along y, and along z, of a triangle here.
  static constexpr std::int32_t kMostRows = 8;
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

/// The marks of triangles in a block of 64^3 voxels: by row y + rows_y z, then by lane.
struct alignas(64) TriangleMarks {
  static constexpr std::size_t kLanes = TriangleLanes::kLanes;
  static constexpr std::size_t kMostRows = TriangleLanes::kMostRows * TriangleLanes::kMostRows;

  std::array<std::array<std::uint64_t, kLanes>, kMostRows> bits;
  /// First voxel beyond the crossing.
  std::array<std::array<double, kLanes>, kMostRows> from;
  std::array<std::uint8_t, kMostRows> crossed;  // lanes that have a crossing
  unsigned facing_x;                            // lanes whose normal is along rising x
  /// Lanes with a bound so close to a voxel's border that rounding could move it.
  unsigned doubtful;
};

/// Marks the triangles of all lanes. Marks of doubtful lanes do not count.
void MarkLanes(const TriangleLanes& lanes, TriangleMarks& out);

}  // namespace tandem
