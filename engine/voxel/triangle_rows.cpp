#include "engine/voxel/triangle_rows.h"

#include <algorithm>
#include <cmath>

namespace tandem {

namespace {

constexpr int kSide = kHyperchunkSide;

int SignOf(Int128 value) {
  return value > 0 ? 1 : (value < 0 ? -1 : 0);
}

std::int32_t FloorOf(double x) {
  const auto whole = static_cast<std::int32_t>(x);
  return whole - (x < whole ? 1 : 0);
}

Int128 FloorQuotient(Int128 a, Int128 b) {  // b > 0
  const Int128 q = a / b;
  return q - (a % b < 0 ? 1 : 0);
}

}  // namespace

TriangleRows::TriangleRows(const SnappedTriangle& triangle, int side_bits) : side_bits_(side_bits) {
  std::array<std::int32_t, 3> low{};
  std::array<std::int32_t, 3> high{};
  for (std::size_t k = 0; k < 3; ++k) {
    const auto [least, greatest] = std::minmax({triangle[0][k], triangle[1][k], triangle[2][k]});
    low[k] = static_cast<std::int32_t>(least >> side_bits);
    high[k] = static_cast<std::int32_t>(greatest >> side_bits);
    const std::int64_t corner = std::int64_t{low[k]} << side_bits;
    for (std::size_t v = 0; v < 3; ++v) p_[v][k] = triangle[v][k] - corner;
  }
  lowest_ = {low[0], low[1], low[2]};
  highest_ = {high[0], high[1], high[2]};
  size_ = highest_ - lowest_ + GridIndex{1, 1, 1};
  const double scale = 1.0 / static_cast<double>(std::int64_t{1} << side_bits);
  for (std::size_t v = 0; v < 3; ++v) {
    for (std::size_t k = 0; k < 3; ++k) c_[v][k] = scale * static_cast<double>(p_[v][k]);
  }
  const double extent = std::max({size_.x, size_.y, size_.z});
  doubt_ = 1e-14 * (extent + 1);

  // the normal: exact in double precision while the corners are within 2^26 units
  std::array<double, 3> n{};
  const bool small =
      (std::int64_t{std::max({size_.x, size_.y, size_.z})} << side_bits) <= (std::int64_t{1} << 26);
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t i = (k + 1) % 3;
    const std::size_t j = (k + 2) % 3;
    if (small) {
      n[k] = (c_[1][i] - c_[0][i]) * (c_[2][j] - c_[0][j]) -
             (c_[1][j] - c_[0][j]) * (c_[2][i] - c_[0][i]);
      sense_[k] = n[k] > 0 ? 1 : (n[k] < 0 ? -1 : 0);
    } else {
      const Wide exact = Wide{p_[1][i] - p_[0][i]} * (p_[2][j] - p_[0][j]) -
                         Wide{p_[1][j] - p_[0][j]} * (p_[2][i] - p_[0][i]);
      n[k] = static_cast<double>(exact);
      sense_[k] = SignOf(exact);
    }
  }
  by_plane_ = sense_[0] != 0 && sense_[1] != 0 && sense_[2] != 0 && size_.x > 1 && size_.y > 1 &&
              size_.z > 1;
  if (sense_[0] != 0) {
    rise_y_ = -n[1] / n[0];
    rise_z_ = -n[2] / n[0];
    plane_doubt_ =
        1e-14 * (extent + std::abs(rise_y_) * (size_.y + 1) + std::abs(rise_z_) * (size_.z + 1));
  }
  // a box that is one cell thick casts shadows without bounds on the two planes through that axis,
  // or rather the box itself is their bound
  if (size_.x > 1 && size_.y > 1) FindShadow(0, 1, sense_[2], xy_);
  if (size_.x > 1 && size_.z > 1) FindShadow(0, 2, -sense_[1], xz_);
  if (size_.y > 1 && size_.z > 1) FindShadow(1, 2, sense_[0], yz_);
}

void TriangleRows::FindShadow(std::size_t u, std::size_t v, int sense, Shadow& shadow) const {
  const auto add = [&](std::size_t from, std::size_t to, bool upper) {
    shadow.bounds[shadow.count++] = {.u = c_[from][u],
                                     .v = c_[from][v],
                                     .slope = (c_[to][u] - c_[from][u]) / (c_[to][v] - c_[from][v]),
                                     .from = static_cast<std::uint8_t>(from),
                                     .to = static_cast<std::uint8_t>(to),
                                     .upper = upper};
  };
  if (sense != 0) {
    for (std::size_t from = 0; from < 3; ++from) {
      const std::size_t to = from == 2 ? 0 : from + 1;
      if (p_[to][v] == p_[from][v]) continue;
      add(from, to, (p_[to][v] > p_[from][v]) == (sense > 0));
    }
    return;
  }
  // a segment seen edge on: bounded on both sides by its line
  std::size_t from = 0;
  for (std::size_t k = 1; k < 3; ++k) {
    const auto length = [&](std::size_t a) {
      return std::abs(p_[(a + 1) % 3][v] - p_[a][v]);
    };
    if (length(k) > length(from)) from = k;
  }
  const std::size_t to = (from + 1) % 3;
  if (p_[to][v] == p_[from][v]) return;
  add(from, to, false);
  add(from, to, true);
}

int TriangleRows::LineAgainst(std::size_t from, std::size_t to, std::size_t u, std::size_t v,
                              std::int64_t half_u, std::int64_t half_v) const {
  const std::int64_t half = std::int64_t{1} << (side_bits_ - 1);
  const auto& a = p_[from];
  const auto& b = p_[to];
  const Wide difference =
      Wide{b[u] - a[u]} * (half_v * half - a[v]) - Wide{half_u * half - a[u]} * (b[v] - a[v]);
  return b[v] > a[v] ? SignOf(difference) : -SignOf(difference);
}

void TriangleRows::Narrow(const Shadow& shadow, std::size_t u, std::size_t v, std::int32_t row,
                          std::int32_t& low, std::int32_t& high) const {
  for (std::size_t i = 0; i < shadow.count; ++i) {
    const Bound& b = shadow.bounds[i];
    // where in the row of cells the line reaches farthest out
    const bool at_upper_border = b.upper ? b.slope > 0 : b.slope < 0;
    const std::int32_t at = row + (at_upper_border ? 1 : 0);
    const double x = b.u + b.slope * (at - b.v);
    if (b.upper ? x > high + 2.0 : x < low - 1.0) continue;
    if (b.upper ? x < -1.0 : x > high + 2.0) {
      high = -1;
      return;
    }
    std::int32_t cell = FloorOf(x);
    const double part = x - cell;
    if (part < doubt_ || part > 1 - doubt_) {
      const std::int32_t near = cell + (part > 0.5 ? 1 : 0);
      const int side =
          LineAgainst(b.from, b.to, u, v, 2 * std::int64_t{near}, 2 * std::int64_t{at});
      // a row's upper border is not attained, nor a whole u that the line has only there
      const bool reaches = b.upper && at_upper_border ? side > 0 : side >= 0;
      cell = reaches ? near : near - 1;
    }
    if (b.upper) {
      high = std::min(high, cell);
    } else {
      low = std::max(low, cell);
    }
  }
}

/// n . (a corner of the grid), of the sign that n[0] is positive.
TriangleRows::Wide TriangleRows::PlaneAt(std::int32_t x, std::int32_t y, std::int32_t z) const {
  std::array<Wide, 3> n{};
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t i = (k + 1) % 3;
    const std::size_t j = (k + 2) % 3;
    n[k] = Wide{p_[1][i] - p_[0][i]} * (p_[2][j] - p_[0][j]) -
           Wide{p_[1][j] - p_[0][j]} * (p_[2][i] - p_[0][i]);
  }
  const Wide value = n[0] * ((std::int64_t{x} << side_bits_) - p_[0][0]) +
                     n[1] * ((std::int64_t{y} << side_bits_) - p_[0][1]) +
                     n[2] * ((std::int64_t{z} << side_bits_) - p_[0][2]);
  return sense_[0] > 0 ? value : -value;
}

/// The cell in which the plane's x lies at a corner (y, z) of the grid.
std::int32_t TriangleRows::PlaneFloor(std::int32_t y, std::int32_t z) const {
  const Wide at_zero = PlaneAt(0, y, z);
  const Wide per_cell = PlaneAt(1, y, z) - at_zero;
  const Wide cell = FloorQuotient(-at_zero, per_cell);
  return static_cast<std::int32_t>(std::clamp<Wide>(cell, -2, size_.x + 1));
}

void TriangleRows::NarrowToPlane(std::int32_t y, std::int32_t z, std::int32_t& low,
                                 std::int32_t& high) const {
  const auto at = [&](std::int32_t yy, std::int32_t zz) {
    return c_[0][0] + rise_y_ * (yy - c_[0][1]) + rise_z_ * (zz - c_[0][2]);
  };
  const std::int32_t up_y = y + (rise_y_ > 0 ? 1 : 0);
  const std::int32_t up_z = z + (rise_z_ > 0 ? 1 : 0);
  const std::int32_t down_y = y + (rise_y_ > 0 ? 0 : 1);
  const std::int32_t down_z = z + (rise_z_ > 0 ? 0 : 1);
  const double greatest = at(up_y, up_z);
  const double least = at(down_y, down_z);
  const bool blind = plane_doubt_ > 0.25;
  if (blind || greatest <= static_cast<double>(high) + 2) {
    const double clamped = std::max(greatest, -2.0);
    std::int32_t cell = FloorOf(blind ? 0.0 : clamped);
    const double part = clamped - cell;
    if (blind || part < plane_doubt_ || part > 1 - plane_doubt_) {
      cell = PlaneFloor(up_y, up_z);
      // a whole x at an upper border in y or z is not attained
      if ((rise_y_ > 0 || rise_z_ > 0) && PlaneAt(cell, up_y, up_z) == 0) --cell;
    }
    high = std::min(high, cell);
  }
  if (blind || least >= static_cast<double>(low) - 1) {
    const double clamped = std::min(least, size_.x + 2.0);
    std::int32_t cell = FloorOf(blind ? 0.0 : clamped);
    const double part = clamped - cell;
    if (blind || part < plane_doubt_ || part > 1 - plane_doubt_) cell = PlaneFloor(down_y, down_z);
    low = std::max(low, cell);
  }
}

void TriangleRows::CentresInRow(std::int32_t z, std::int32_t& low, std::int32_t& high) const {
  // two sides span the centre's height, or none; the lower end belongs to a side, the upper not
  const std::int64_t half = std::int64_t{1} << (side_bits_ - 1);
  const std::int64_t height = (2 * std::int64_t{z} + 1) * half;
  std::array<std::int32_t, 2> first{};
  std::size_t found = 0;
  for (std::size_t from = 0; from < 3; ++from) {
    const std::size_t to = from == 2 ? 0 : from + 1;
    if ((p_[from][2] > height) == (p_[to][2] > height)) continue;
    const double slope = (c_[to][1] - c_[from][1]) / (c_[to][2] - c_[from][2]);
    const double x = c_[from][1] + slope * (z + 0.5 - c_[from][2]) - 0.5;
    // the first centre at the line or beyond
    const std::int32_t cell = FloorOf(x);
    const double part = x - cell;
    std::int32_t& centre = first[found++];
    centre = cell + 1;
    if (part < doubt_ || part > 1 - doubt_) {
      const std::int32_t near = cell + (part > 0.5 ? 1 : 0);
      const int side =
          LineAgainst(from, to, 1, 2, 2 * std::int64_t{near} + 1, 2 * std::int64_t{z} + 1);
      centre = side > 0 ? near + 1 : near;
    }
  }
  low = 0;
  high = -1;
  if (found != 2) return;
  low = std::min(first[0], first[1]);
  high = std::max(first[0], first[1]) - 1;
}

void TriangleRows::Mark(const GridIndex& first, std::uint64_t* rows, int facing,
                        std::vector<Crossing>* crossings) const {
  const GridIndex offset = lowest_ - first;  // of the triangle's own cells in the block
  const std::int32_t y0 = std::max(0, -offset.y);
  const std::int32_t y1 = std::min(size_.y - 1, kSide - 1 - offset.y);
  const std::int32_t z0 = std::max(0, -offset.z);
  const std::int32_t z1 = std::min(size_.z - 1, kSide - 1 - offset.z);
  if (y0 > y1 || z0 > z1 || offset.x >= kSide || offset.x + size_.x <= 0) return;

  std::array<std::int32_t, kSide> low_xy;
  std::array<std::int32_t, kSide> high_xy;
  for (std::int32_t y = y0; y <= y1; ++y) {
    const auto i = static_cast<std::size_t>(y - y0);
    low_xy[i] = 0;
    high_xy[i] = size_.x - 1;
    Narrow(xy_, 0, 1, y, low_xy[i], high_xy[i]);
  }
  const bool crosses = facing != 0 && sense_[0] != 0;
  for (std::int32_t z = z0; z <= z1; ++z) {
    std::int32_t low_xz = 0;
    std::int32_t high_xz = size_.x - 1;
    Narrow(xz_, 0, 2, z, low_xz, high_xz);
    if (low_xz > high_xz) continue;
    std::int32_t low_y = y0;
    std::int32_t high_y = y1;
    Narrow(yz_, 1, 2, z, low_y, high_y);
    std::int32_t low_centre = 0;
    std::int32_t high_centre = -1;
    if (crosses) CentresInRow(z, low_centre, high_centre);
    for (std::int32_t y = low_y; y <= high_y; ++y) {
      const auto i = static_cast<std::size_t>(y - y0);
      std::int32_t low = std::max(low_xz, low_xy[i]);
      std::int32_t high = std::min(high_xz, high_xy[i]);
      if (by_plane_ && low <= high) NarrowToPlane(y, z, low, high);
      if (low > high) continue;
      const std::size_t row =
          static_cast<std::size_t>(offset.y + y) +
          static_cast<std::size_t>(kSide) * static_cast<std::size_t>(offset.z + z);
      const std::int32_t begin = std::max(0, low + offset.x);
      const std::int32_t end = std::min(kSide - 1, high + offset.x);
      if (begin <= end) rows[row] |= (~std::uint64_t{0} >> (kSide - 1 - (end - begin))) << begin;
      if (y < low_centre || y > high_centre) continue;
      // the crossing lies in one of the row's cells, whatever rounding says
      const double x =
          std::clamp(c_[0][0] + rise_y_ * (y + 0.5 - c_[0][1]) + rise_z_ * (z + 0.5 - c_[0][2]),
                     static_cast<double>(low), static_cast<double>(high) + 1);
      const std::int32_t cell = std::min(high, FloorOf(x));
      const std::int32_t in_block = cell + offset.x;
      if (in_block < 0 || in_block >= kSide) continue;
      crossings->push_back({.row = static_cast<std::uint16_t>(row),
                            .from = static_cast<std::uint8_t>(in_block + (x - cell > 0.5 ? 1 : 0)),
                            .entering = static_cast<std::int8_t>(-sense_[0] * facing)});
    }
  }
}

}  // namespace tandem
