#include "engine/voxel/build/triangles/triangle_batch.h"

#include <algorithm>
#include <bit>

namespace tandem {

void TriangleBatch::Add(const SnappedPoint& a, const SnappedPoint& b, const SnappedPoint& c,
                        int facing) {
  std::array<std::int64_t, 3> low;
  std::array<std::int32_t, 3> size;
  std::array<std::int32_t, 3> offset;
  const std::array<std::int32_t, 3> first{first_.x, first_.y, first_.z};
  bool apart = false;
  for (std::size_t k = 0; k < 3; ++k) {
    low[k] = std::min({a[k], b[k], c[k]}) >> kSnapBits;
    size[k] = static_cast<std::int32_t>((std::max({a[k], b[k], c[k]}) >> kSnapBits) - low[k]) + 1;
    offset[k] = static_cast<std::int32_t>(low[k]) - first[k];
    apart = apart || offset[k] >= kHyperchunkSide || offset[k] + size[k] <= 0;
    low[k] <<= kSnapBits;
  }
  if (apart) return;
  const std::int32_t most = std::max(size[1], size[2]);
  if (most > TriangleLanes::kMostRows || size[0] > kHyperchunkSide / 2) {
    TriangleRows({a, b, c}, kSnapBits).Mark(first_, rows_, facing, crossings_);
    return;
  }
  // many triangles of a fine mesh are one voxel or a straight run, beside the centre lines
  const int thin = (size[0] == 1) + (size[1] == 1) + (size[2] == 1);
  if (thin >= 2) {
    const auto beside = [&](std::size_t k) {
      constexpr std::int64_t kHalf = std::int64_t{1} << (kSnapBits - 1);
      const std::int64_t middle = low[k] + kHalf;
      return (a[k] > middle && b[k] > middle && c[k] > middle) ||
             (a[k] < middle && b[k] < middle && c[k] < middle);
    };
    if (facing == 0 || (size[1] == 1 && beside(1)) || (size[2] == 1 && beside(2))) {
      const std::int32_t x0 = std::max(0, offset[0]);
      const std::int32_t x1 = std::min(kHyperchunkSide, offset[0] + size[0]) - 1;
      const std::uint64_t run = ~std::uint64_t{0} >> (63 - (x1 - x0)) << x0;
      const std::int32_t end_y = std::min(kHyperchunkSide, offset[1] + size[1]);
      const std::int32_t end_z = std::min(kHyperchunkSide, offset[2] + size[2]);
      for (std::int32_t z = std::max(0, offset[2]); z < end_z; ++z) {
        for (std::int32_t y = std::max(0, offset[1]); y < end_y; ++y) {
          rows_[y + kHyperchunkSide * z] |= run;
        }
      }
      return;
    }
  }
  TriangleLanes& lanes = lanes_[most <= 2 ? 0 : (most <= 4 ? 1 : 2)];
  const std::size_t lane = lanes.count++;
  for (std::size_t k = 0; k < 3; ++k) {
    lanes.p[0][k][lane] = static_cast<std::uint64_t>(a[k] - low[k]);
    lanes.p[1][k][lane] = static_cast<std::uint64_t>(b[k] - low[k]);
    lanes.p[2][k][lane] = static_cast<std::uint64_t>(c[k] - low[k]);
    lanes.size[k][lane] = size[k];
    lanes.offset[k][lane] = offset[k];
  }
  lanes.facing[lane] = facing;
  lanes.row[lane] = static_cast<std::uint32_t>(offset[1] + kHyperchunkSide * offset[2]);
  lanes.corners[lane] = {&a, &b, &c};
  lanes.rows_y = std::max(lanes.rows_y, size[1]);
  lanes.rows_z = std::max(lanes.rows_z, size[2]);
  if (lanes.count == TriangleLanes::kLanes) Flush(lanes);
}

void TriangleBatch::Flush(TriangleLanes& lanes) {
  for (std::size_t lane = lanes.count; lane < TriangleLanes::kLanes; ++lane) {
    for (auto& size : lanes.size) size[lane] = 0;  // nothing is met
  }
  MarkLanes(lanes, marks_);
  const auto rows_y = static_cast<std::size_t>(lanes.rows_y);
  const auto rows_z = static_cast<std::size_t>(lanes.rows_z);
  const unsigned used = (1U << lanes.count) - 1;
  const unsigned sure = used & ~marks_.doubtful;
  alignas(64) std::array<std::uint64_t, TriangleLanes::kLanes> kept;
  for (std::size_t lane = 0; lane < TriangleLanes::kLanes; ++lane) {
    kept[lane] = (sure >> lane & 1U) != 0 ? ~std::uint64_t{0} : 0;
  }
  for (std::size_t z = 0; z < rows_z; ++z) {
    for (std::size_t y = 0; y < rows_y; ++y) {
      const std::size_t i = y + rows_y * z;
      const auto row = static_cast<std::uint32_t>(y + kHyperchunkSide * z);
      // a row outside the block has no bits, so it does not matter which row gets them
      for (std::size_t lane = 0; lane < lanes.count; ++lane) {
        rows_[(lanes.row[lane] + row) % kBrickRows] |= marks_.bits[i][lane] & kept[lane];
      }
      for (unsigned rest = marks_.crossed[i] & sure; rest != 0; rest &= rest - 1) {
        const auto lane = static_cast<std::size_t>(std::countr_zero(rest));
        const int facing = static_cast<int>(lanes.facing[lane]);
        crossings_->push_back(
            {.row = static_cast<std::uint16_t>((lanes.row[lane] + row) % kBrickRows),
             .from = static_cast<std::uint8_t>(marks_.from[i][lane]),
             .entering =
                 static_cast<std::int8_t>((marks_.facing_x >> lane & 1U) != 0 ? -facing : facing)});
      }
    }
  }
  for (unsigned rest = marks_.doubtful & used; rest != 0; rest &= rest - 1) {
    const auto& [a, b, c] = lanes.corners[static_cast<std::size_t>(std::countr_zero(rest))];
    const auto lane = static_cast<std::size_t>(std::countr_zero(rest));
    TriangleRows({*a, *b, *c}, kSnapBits)
        .Mark(first_, rows_, static_cast<int>(lanes.facing[lane]), crossings_);
  }
  lanes.count = 0;
  lanes.rows_y = 0;
  lanes.rows_z = 0;
}

void TriangleBatch::Finish() {
  for (TriangleLanes& lanes : lanes_) {
    if (lanes.count > 0) Flush(lanes);
  }
}

}  // namespace tandem
