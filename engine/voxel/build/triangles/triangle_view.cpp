#include <algorithm>
#include <cmath>

#include "engine/voxel/build/triangles/triangle_rows.h"

// Finds a triangle's bounds, and decides in whole numbers where double precision leaves a doubt;
// triangle_rows.cpp walks the rows.

namespace tandem {

namespace {

int SignOf(Int128 value) {
  return value > 0 ? 1 : (value < 0 ? -1 : 0);
}

Int128 FloorQuotient(Int128 a, Int128 b) {  // b > 0
  const Int128 q = a / b;
  return q - (a % b < 0 ? 1 : 0);
}

/// Returns 2^-bits.
double Inverse(int bits) {
  return 1.0 / static_cast<double>(std::int64_t{1} << bits);
}

}  // namespace

TriangleRows::TriangleRows(const SnappedTriangle& triangle, int side_bits) : view_() {
  std::array<std::int32_t, 3> low{};
  std::array<std::int32_t, 3> high{};
  for (std::size_t k = 0; k < 3; ++k) {
    const auto [least, greatest] = std::minmax({triangle[0][k], triangle[1][k], triangle[2][k]});
    low[k] = static_cast<std::int32_t>(least >> side_bits);
    high[k] = static_cast<std::int32_t>(greatest >> side_bits);
    const std::int64_t corner = std::int64_t{low[k]} << side_bits;
    for (std::size_t v = 0; v < 3; ++v) view_.p[v][k] = triangle[v][k] - corner;
  }
  view_.side_bits = side_bits;
  lowest_ = {low[0], low[1], low[2]};
  highest_ = {high[0], high[1], high[2]};
  view_.size = highest_ - lowest_ + GridIndex{1, 1, 1};
  view_.xy.count = view_.xz.count = view_.yz.count = 0;
  const double scale = Inverse(side_bits);
  for (std::size_t v = 0; v < 3; ++v) {
    for (std::size_t k = 0; k < 3; ++k) view_.c[v][k] = scale * static_cast<double>(view_.p[v][k]);
  }
  if (MissesCentres()) {
    view_.whole_box = true;
    return;
  }
  const double extent = std::max({view_.size.x, view_.size.y, view_.size.z});
  view_.doubt = 1e-14 * (extent + 1);
  FindPlane(extent);
  // a box that is one cell thick casts shadows without bounds on the two planes through that axis:
  // the box itself is their bound
  if (view_.size.x > 1 && view_.size.y > 1) FindShadow(0, 1, view_.sense[2], view_.xy);
  if (view_.size.x > 1 && view_.size.z > 1) FindShadow(0, 2, -view_.sense[1], view_.xz);
  if (view_.size.y > 1 && view_.size.z > 1) FindShadow(1, 2, view_.sense[0], view_.yz);
}

bool TriangleRows::MissesCentres() const {
  // many triangles of a fine mesh lie in one voxel or a straight run, beside the centre lines
  const auto& v = view_.c;
  const auto beside = [&](std::size_t k) {
    return (v[0][k] > 0.5 && v[1][k] > 0.5 && v[2][k] > 0.5) ||
           (v[0][k] < 0.5 && v[1][k] < 0.5 && v[2][k] < 0.5);
  };
  const bool one_y = view_.size.y == 1;
  const bool one_z = view_.size.z == 1;
  const bool straight = (one_y && one_z) || (view_.size.x == 1 && (one_y || one_z));
  return straight && ((one_y && beside(1)) || (one_z && beside(2)));
}

void TriangleRows::FindPlane(double extent) {
  // the normal: exact in double precision while the corners are within 2^26 units
  std::array<double, 3> n{};
  const bool small = (std::int64_t{std::max({view_.size.x, view_.size.y, view_.size.z})}
                      << view_.side_bits) <= (std::int64_t{1} << 26);
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t i = (k + 1) % 3;
    const std::size_t j = (k + 2) % 3;
    if (small) {
      n[k] = (view_.c[1][i] - view_.c[0][i]) * (view_.c[2][j] - view_.c[0][j]) -
             (view_.c[1][j] - view_.c[0][j]) * (view_.c[2][i] - view_.c[0][i]);
      view_.sense[k] = n[k] > 0 ? 1 : (n[k] < 0 ? -1 : 0);
    } else {
      const Int128 exact = Int128{view_.p[1][i] - view_.p[0][i]} * (view_.p[2][j] - view_.p[0][j]) -
                           Int128{view_.p[1][j] - view_.p[0][j]} * (view_.p[2][i] - view_.p[0][i]);
      n[k] = static_cast<double>(exact);
      view_.sense[k] = SignOf(exact);
    }
  }
  view_.by_plane = view_.sense[0] != 0 && view_.sense[1] != 0 && view_.sense[2] != 0 &&
                   view_.size.x > 1 && view_.size.y > 1 && view_.size.z > 1;
  if (view_.sense[0] != 0) {
    view_.rise_y = -n[1] / n[0];
    view_.rise_z = -n[2] / n[0];
    view_.plane_doubt = 1e-14 * (extent + std::abs(view_.rise_y) * (view_.size.y + 1) +
                                 std::abs(view_.rise_z) * (view_.size.z + 1));
  }
}

void TriangleRows::FindShadow(std::size_t u, std::size_t v, int sense, Shadow& shadow) const {
  shadow.u = u;
  shadow.v = v;
  const auto add = [&](std::size_t from, std::size_t to, bool upper) {
    shadow.bounds[shadow.count++] = {
        .u = view_.c[from][u],
        .v = view_.c[from][v],
        .slope = (view_.c[to][u] - view_.c[from][u]) / (view_.c[to][v] - view_.c[from][v]),
        .from = static_cast<std::uint8_t>(from),
        .to = static_cast<std::uint8_t>(to),
        .upper = upper};
  };
  if (sense != 0) {
    for (std::size_t from = 0; from < 3; ++from) {
      const std::size_t to = from == 2 ? 0 : from + 1;
      if (view_.p[to][v] == view_.p[from][v]) continue;
      add(from, to, (view_.p[to][v] > view_.p[from][v]) == (sense > 0));
    }
    return;
  }
  // a segment seen edge on: bounded on both sides by its line
  std::size_t from = 0;
  for (std::size_t k = 1; k < 3; ++k) {
    const auto length = [&](std::size_t a) {
      return std::abs(view_.p[(a + 1) % 3][v] - view_.p[a][v]);
    };
    if (length(k) > length(from)) from = k;
  }
  const std::size_t to = (from + 1) % 3;
  if (view_.p[to][v] == view_.p[from][v]) return;
  add(from, to, false);
  add(from, to, true);
}

/// Returns the sign of (u of the line through two corners, where it has that v) - u, in half cells.
int TriangleRows::View::LineAgainst(std::size_t from, std::size_t to, std::size_t u, std::size_t v,
                                    std::int64_t half_u, std::int64_t half_v) const {
  const std::int64_t half = std::int64_t{1} << (side_bits - 1);
  const auto& a = p[from];
  const auto& b = p[to];
  const Int128 difference =
      Int128{b[u] - a[u]} * (half_v * half - a[v]) - Int128{half_u * half - a[u]} * (b[v] - a[v]);
  return b[v] > a[v] ? SignOf(difference) : -SignOf(difference);
}

std::int32_t TriangleRows::View::BoundCell(const Shadow& shadow, const Bound& bound,
                                           std::int32_t row) const {
  const std::int32_t at = row + bound.farthest();
  const double x = bound.u + bound.slope * (at - bound.v);
  const auto near = static_cast<std::int32_t>(std::floor(x + 0.5));
  const int side = LineAgainst(bound.from, bound.to, shadow.u, shadow.v, 2 * std::int64_t{near},
                               2 * std::int64_t{at});
  // a whole u that the line has only at the row's upper border is not attained
  const bool reaches = bound.upper && bound.farthest() != 0 ? side > 0 : side >= 0;
  return reaches ? near : near - 1;
}

/// Returns n . (a corner of the grid), with the sign for which n[0] is positive.
Int128 TriangleRows::View::PlaneAt(std::int32_t x, std::int32_t y, std::int32_t z) const {
  std::array<Int128, 3> n{};
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t i = (k + 1) % 3;
    const std::size_t j = (k + 2) % 3;
    n[k] = Int128{p[1][i] - p[0][i]} * (p[2][j] - p[0][j]) -
           Int128{p[1][j] - p[0][j]} * (p[2][i] - p[0][i]);
  }
  const Int128 value = n[0] * ((std::int64_t{x} << side_bits) - p[0][0]) +
                       n[1] * ((std::int64_t{y} << side_bits) - p[0][1]) +
                       n[2] * ((std::int64_t{z} << side_bits) - p[0][2]);
  return sense[0] > 0 ? value : -value;
}

/// Returns the cell in which the plane's x lies at a corner (y, z) of the grid.
std::int32_t TriangleRows::View::PlaneFloor(std::int32_t y, std::int32_t z) const {
  const Int128 at_zero = PlaneAt(0, y, z);
  const Int128 per_cell = PlaneAt(1, y, z) - at_zero;
  const Int128 cell = FloorQuotient(-at_zero, per_cell);
  return static_cast<std::int32_t>(std::clamp<Int128>(cell, -2, size.x + 1));
}

std::int32_t TriangleRows::View::PlaneHigh(std::int32_t y, std::int32_t z) const {
  const std::int32_t up_y = y + (rise_y > 0 ? 1 : 0);
  const std::int32_t up_z = z + (rise_z > 0 ? 1 : 0);
  const std::int32_t cell = PlaneFloor(up_y, up_z);
  // a whole x at an upper border in y or z is not attained
  return (rise_y > 0 || rise_z > 0) && PlaneAt(cell, up_y, up_z) == 0 ? cell - 1 : cell;
}

std::int32_t TriangleRows::View::PlaneLow(std::int32_t y, std::int32_t z) const {
  return PlaneFloor(y + (rise_y > 0 ? 0 : 1), z + (rise_z > 0 ? 0 : 1));
}

std::int32_t TriangleRows::View::CentreCell(std::size_t from, std::size_t to,
                                            std::int32_t z) const {
  const double slope = (c[to][1] - c[from][1]) / (c[to][2] - c[from][2]);
  const double x = c[from][1] + slope * (z + 0.5 - c[from][2]) - 0.5;
  const auto near = static_cast<std::int32_t>(std::floor(x + 0.5));
  const int side = LineAgainst(from, to, 1, 2, 2 * std::int64_t{near} + 1, 2 * std::int64_t{z} + 1);
  return side > 0 ? near + 1 : near;
}

}  // namespace tandem
