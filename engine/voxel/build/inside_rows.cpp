#include "engine/voxel/build/inside_rows.h"

#include <algorithm>

#include <tbb/parallel_for.h>

#include "engine/voxel/build/inside_winding.h"

namespace tandem {

namespace {

constexpr std::uint32_t kNone = ~0U;

/// The number of bodies that hold the voxels before a hyperchunk, row by row.
using Carry = std::array<std::int32_t, kBrickRows>;

/// Returns the bits from `from` on; none for 64.
std::uint64_t From(std::uint32_t from) {
  return from < 64 ? ~std::uint64_t{0} << from : 0;
}

/// Fills the rows of one brick and takes the carry to its other side. Returns whether any bit is
/// set.
bool FillRows(const std::vector<Crossing>& crossings, Carry& carry, std::uint64_t* rows) {
  std::array<std::uint32_t, kBrickRows> head;
  head.fill(kNone);
  std::vector<std::uint32_t> next(crossings.size());
  for (std::uint32_t i = 0; i < crossings.size(); ++i) {
    next[i] = head[crossings[i].row];
    head[crossings[i].row] = i;
  }
  std::uint64_t any = 0;
  std::vector<Crossing> in_row;
  for (std::size_t row = 0; row < kBrickRows; ++row) {
    std::int32_t count = carry[row];
    std::uint64_t bits = count > 0 ? ~std::uint64_t{0} : 0;
    if (head[row] != kNone) {
      in_row.clear();
      for (std::uint32_t i = head[row]; i != kNone; i = next[i]) in_row.push_back(crossings[i]);
      std::sort(in_row.begin(), in_row.end(), [](const Crossing& a, const Crossing& b) {
        return a.from < b.from;
      });
      for (const Crossing& c : in_row) {
        count += c.entering;
        bits = count > 0 ? bits | From(c.from) : bits & ~From(c.from);
      }
      carry[row] = count;
    }
    rows[row] = bits;
    any |= bits;
  }
  return any != 0;
}

}  // namespace

InsideRows::InsideRows(const SurfaceBricks& bricks, const TriangleMesh& mesh_W,
                       const MeshFacing& facing, double voxel_size)
    : rows_(bricks.bricks().size() * kBrickRows * sizeof(std::uint64_t)),
      rows_of_(bricks.box().cells()),
      solid_(bricks.box().cells()) {
  CountCrossings(bricks);
  if (!facing.open.empty()) AddOpenBodies(bricks, mesh_W, facing, voxel_size);
}

void InsideRows::CountCrossings(const SurfaceBricks& bricks) {
  const HyperchunkBox& box = bricks.box();
  auto* const rows = reinterpret_cast<std::uint64_t*>(rows_.data());
  const auto lines = static_cast<std::size_t>(box.size.y) * static_cast<std::size_t>(box.size.z);
  tbb::parallel_for(std::size_t{0}, lines, [&](std::size_t line) {
    Carry carry{};
    const auto l = static_cast<std::int32_t>(line);
    bool touched = false;
    for (std::int32_t x = 0; x < box.size.x; ++x) {
      const GridIndex place = box.first + GridIndex{x, l % box.size.y, l / box.size.y};
      const SurfaceBricks::Brick* brick = bricks.At(place);
      if (brick == nullptr) {
        // no surface passes through, so all rows agree
        solid_[box.CellOf(place)] = carry[0] > 0 ? 1 : 0;
        continue;
      }
      if (!touched && brick->crossings.empty()) continue;
      touched = true;
      const auto number = static_cast<std::size_t>(brick - bricks.bricks().data());
      std::uint64_t* mine = rows + number * kBrickRows;
      if (FillRows(brick->crossings, carry, mine)) rows_of_[box.CellOf(place)] = mine;
    }
  });
}

void InsideRows::AddOpenBodies(const SurfaceBricks& bricks, const TriangleMesh& mesh_W,
                               const MeshFacing& facing, double voxel_size) {
  const TriangleMesh open = OpenBodies(mesh_W, facing);
  const Bounds bounds = BoundsOf(open);
  const WindingNumber winding(open);
  const HyperchunkBox& box = bricks.box();
  wound_.resize(box.cells());
  tbb::parallel_for(std::size_t{0}, box.cells(), [&](std::size_t cell) {
    const auto c = static_cast<std::int32_t>(cell);
    const GridIndex place = box.first + GridIndex{c % box.size.x, c / box.size.x % box.size.y,
                                                  c / box.size.x / box.size.y};
    Bounds mine;
    const GridIndex first = place * kHyperchunkSide;
    mine.Add(voxel_size * Vec3(first.x, first.y, first.z));
    mine.Add(mine.min + Vec3::Constant(voxel_size * kHyperchunkSide));
    if (!bricks.layers().Hold(place) || solid_[cell] != 0 || !mine.Overlaps(bounds)) return;
    std::vector<std::uint64_t>& rows = wound_[cell];
    rows.assign(kBrickRows, 0);
    if (rows_of_[cell] != nullptr) std::copy_n(rows_of_[cell], kBrickRows, rows.begin());
    const SurfaceBricks::Brick* brick = bricks.At(place);
    AddWindingVoxels(winding, bounds, voxel_size, place,
                     brick != nullptr ? &brick->sources[0] : nullptr, rows.data());
    const auto is = [&](std::uint64_t word) {
      return std::all_of(rows.begin(), rows.end(), [word](std::uint64_t row) {
        return row == word;
      });
    };
    if (brick == nullptr && is(~std::uint64_t{0})) solid_[cell] = 1;
    if (solid_[cell] != 0 || is(0)) {
      rows = {};
    } else {
      rows_of_[cell] = rows.data();
    }
  });
}

}  // namespace tandem
