#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "engine/voxel/triangle_overlap.h"
#include "engine/voxel/voxel.h"

namespace tandem {

/// A hyperchunk of bits: rows of 64 voxels along x, row y + 64 z.
inline constexpr std::size_t kBrickRows = std::size_t{kHyperchunkSide} * kHyperchunkSide;

/// Where the surface crosses the line through the centres of a row of voxels.
struct Crossing {
  std::uint16_t row = 0;     // y + 64 z, in its hyperchunk
  std::uint8_t from = 0;     // the first voxel beyond it; 64: beyond the hyperchunk
  std::int8_t entering = 0;  // 1: towards rising x into the solid, -1: out of it
};

/// The voxels that a triangle meets, row by row: the same cells as TriangleOverlap gives, exactly.
///
/// The separating axes fall into four groups: three shadows along the coordinate axes and the
/// triangle's own plane. In a row each of them leaves an interval of x, computed in double
/// precision; a bound so close to a cell's border that rounding could move it is decided in whole
/// numbers. So the cost is a few bounds a row, whatever its length.
class TriangleRows {
 public:
  /// Cells have 2^side_bits snapped units a side.
  TriangleRows(const SnappedTriangle& triangle, int side_bits);

  const GridIndex& lowest() const noexcept { return lowest_; }
  const GridIndex& highest() const noexcept { return highest_; }

  /// Sets the bits of the cells met, in a block of 64^3 cells whose lowest is `first`, and lists
  /// the crossings of its rows' centre lines there, once for each row and triangle. A centre line
  /// through an edge belongs to exactly one of the triangles that share it. `facing` turns the
  /// crossings' sense round when it is -1, and is 0 for none.
  void Mark(const GridIndex& first, std::uint64_t* rows, int facing,
            std::vector<Crossing>* crossings) const;

 private:
  using Wide = Int128;

  /// A side of the shadow on a plane (u, v): bounds u in every row of cells v.
  struct Bound {
    double u, v;   // a point of it, in cells
    double slope;  // du / dv
    std::uint8_t from, to;
    bool upper;
  };
  struct Shadow {
    std::array<Bound, 3> bounds;
    std::size_t count = 0;
  };

  void FindShadow(std::size_t u, std::size_t v, int sense, Shadow& shadow) const;
  /// Narrows [low, high] to the cells u of row v that meet the shadow.
  void Narrow(const Shadow& shadow, std::size_t u, std::size_t v, std::int32_t row,
              std::int32_t& low, std::int32_t& high) const;
  void NarrowToPlane(std::int32_t y, std::int32_t z, std::int32_t& low, std::int32_t& high) const;
  /// The sign of (u of the line through two corners, where it has that v) - u, exactly. In half
  /// cells.
  int LineAgainst(std::size_t from, std::size_t to, std::size_t u, std::size_t v,
                  std::int64_t half_u, std::int64_t half_v) const;
  std::int32_t PlaneFloor(std::int32_t y, std::int32_t z) const;
  Wide PlaneAt(std::int32_t x, std::int32_t y, std::int32_t z) const;
  /// The cells y whose centres, at the centre of row z, lie in the shadow along x.
  void CentresInRow(std::int32_t z, std::int32_t& low, std::int32_t& high) const;

  int side_bits_;
  GridIndex lowest_;
  GridIndex highest_;
  GridIndex size_;                                // cells of the triangle's own box
  std::array<std::array<std::int64_t, 3>, 3> p_;  // corners in units, from lowest_'s corner
  std::array<std::array<double, 3>, 3> c_;        // the same in cells
  Shadow xy_, xz_, yz_;
  std::array<int, 3> sense_{};  // signs of the normal
  bool by_plane_ = false;       // the plane says more than the shadows and the box
  double rise_y_ = 0;           // of the plane's x, by y and z
  double rise_z_ = 0;
  double doubt_ = 0;        // of a shadow's bound, cells
  double plane_doubt_ = 0;  // of the plane's
};

}  // namespace tandem
