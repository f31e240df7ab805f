#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "engine/base/int128.h"
#include "engine/voxel/build/snapped_point.h"
#include "engine/voxel/map/voxel.h"

namespace tandem {

/// A hyperchunk of bits: rows of 64 voxels along x, row y + 64 z.
inline constexpr std::size_t kBrickRows = std::size_t{kHyperchunkSide} * kHyperchunkSide;

/// A place where the surface crosses the line through the centres of a row of voxels.
struct Crossing {
  std::uint16_t row = 0;     // y + 64 z, in its hyperchunk
  std::uint8_t from = 0;     // first voxel beyond it; 64: beyond the hyperchunk
  std::int8_t entering = 0;  // 1: towards rising x into the solid, -1: out of it
};

/// Finds the voxels that a triangle meets, row by row: exactly the cells that separating axes in
/// whole numbers give.
///
/// The separating axes fall into four groups: three shadows along the coordinate axes and the
/// triangle's own plane. In a row each of them leaves an interval of x, computed in double
/// precision for several rows at once. A bound so close to a cell's border that rounding could move
/// it is decided in whole numbers. So the cost is a few bounds a row, whatever the row's length.
class TriangleRows {
 public:
  /// Rows beyond the last one that Mark() may read and write back.
  static constexpr std::size_t kPadding = 8;

  /// Cells have 2^side_bits snapped units a side.
  TriangleRows(const SnappedTriangle& triangle, int side_bits);

  const GridIndex& lowest() const noexcept { return lowest_; }
  const GridIndex& highest() const noexcept { return highest_; }

  /// Sets the bits of the cells met, in a block of 64^3 cells whose lowest is `first` (kBrickRows +
  /// kPadding rows). Lists the crossings of its rows' centre lines there, once for each row and
  /// triangle. A centre line through an edge belongs to exactly one of the triangles that share it.
  /// `facing` of -1 reverses the crossings' sense; 0 lists none.
  void Mark(const GridIndex& first, std::uint64_t* rows, int facing,
            std::vector<Crossing>* crossings) const;

  /// Sets the bits, in the order of CellInBlock, of the cells met in a block of 8^3 cells.
  void MarkChunk(const GridIndex& chunk, std::array<std::uint64_t, kChunkSide>& cells) const;

  /// A side of the shadow on a plane (u, v). It bounds u in every row of cells v.
  struct Bound {
    double u, v;   // a point of it, in cells
    double slope;  // du / dv
    std::uint8_t from, to;
    bool upper;

    /// Returns the cells to the row's border where the line reaches farthest out; the upper border
    /// is not attained.
    int farthest() const noexcept { return (upper ? slope > 0 : slope < 0) ? 1 : 0; }
  };
  struct Shadow {
    std::size_t u, v;
    std::array<Bound, 3> bounds;
    std::size_t count = 0;
  };

  /// The data that the kernel reads, and the exact tests for cases that double precision leaves in
  /// doubt.
  struct View {
    /// Returns the last (for an upper bound) or first cell of a row within a bound.
    std::int32_t BoundCell(const Shadow& shadow, const Bound& bound, std::int32_t row) const;
    /// Return the last and the first cell of a row within the plane.
    std::int32_t PlaneHigh(std::int32_t y, std::int32_t z) const;
    std::int32_t PlaneLow(std::int32_t y, std::int32_t z) const;
    /// Returns the first cell y whose centre is at a side of the shadow along x or beyond, at the
    /// centre of row z.
    std::int32_t CentreCell(std::size_t from, std::size_t to, std::int32_t z) const;

    int side_bits;
    GridIndex size;                                // cells of the triangle's own box
    std::array<std::array<std::int64_t, 3>, 3> p;  // corners in units, from the box's lowest
    std::array<std::array<double, 3>, 3> c;        // the same in cells
    Shadow xy, xz, yz;
    std::array<int, 3> sense;  // signs of the normal
    bool by_plane;             // the plane narrows rows more than the shadows and the box do
    bool whole_box;            // all of its box is met, and no centre line; nothing else is set
    double rise_y;             // slopes of the plane's x, by y and z
    double rise_z;
    double doubt;        // doubt of a shadow's bound, cells
    double plane_doubt;  // doubt of the plane's

   private:
    int LineAgainst(std::size_t from, std::size_t to, std::size_t u, std::size_t v,
                    std::int64_t half_u, std::int64_t half_v) const;
    Int128 PlaneAt(std::int32_t x, std::int32_t y, std::int32_t z) const;
    std::int32_t PlaneFloor(std::int32_t y, std::int32_t z) const;
  };

 private:
  /// Tells whether it lies in one cell or a straight run, beside the centre lines.
  bool MissesCentres() const;
  /// Finds the normal and the plane. `extent`: the greatest side of the box, cells.
  void FindPlane(double extent);
  void FindShadow(std::size_t u, std::size_t v, int sense, Shadow& shadow) const;
  /// Marks a block of `side` cells a side, row y + side z.
  void MarkBlock(const GridIndex& first, std::int32_t side, std::uint64_t* rows, int facing,
                 std::vector<Crossing>* crossings) const;

  GridIndex lowest_;
  GridIndex highest_;
  View view_;
};

}  // namespace tandem
