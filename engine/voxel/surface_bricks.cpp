#include "engine/voxel/surface_bricks.h"

#include <algorithm>
#include <bit>
#include <span>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include "engine/voxel/triangle_batch.h"

namespace tandem {

namespace {

constexpr int kBrickBits = kSnapBits + 6;  // snapped units across a hyperchunk
constexpr std::int32_t kFewBricks = 3;     // along a side, so that all are as well taken as told

using Corners = std::array<std::uint32_t, 3>;

std::vector<SnappedPoint> SnapAll(const std::vector<Vec3>& points, double voxel_size) {
  std::vector<SnappedPoint> snapped(points.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, points.size(), 4096), [&](const auto& some) {
    for (std::size_t i = some.begin(); i < some.end(); ++i)
      snapped[i] = Snap(points[i], voxel_size);
  });
  return snapped;
}

/// Calls visit(place) for the hyperchunks that a triangle may reach into.
template <typename Visit>
void ForEachHyperchunk(const SnappedTriangle& t, const Visit& visit) {
  std::array<std::int32_t, 3> low{};
  std::array<std::int32_t, 3> high{};
  for (std::size_t k = 0; k < 3; ++k) {
    low[k] = static_cast<std::int32_t>(std::min({t[0][k], t[1][k], t[2][k]}) >> kBrickBits);
    high[k] = static_cast<std::int32_t>(std::max({t[0][k], t[1][k], t[2][k]}) >> kBrickBits);
  }
  const bool few = high[0] - low[0] < kFewBricks && high[1] - low[1] < kFewBricks &&
                   high[2] - low[2] < kFewBricks;
  if (few) {
    for (std::int32_t z = low[2]; z <= high[2]; ++z) {
      for (std::int32_t y = low[1]; y <= high[1]; ++y) {
        for (std::int32_t x = low[0]; x <= high[0]; ++x) visit(GridIndex{x, y, z});
      }
    }
    return;
  }
  // a large triangle's hyperchunks are told as voxels are
  const TriangleRows rows(t, kBrickBits);
  std::vector<std::uint64_t> met(kBrickRows + TriangleRows::kPadding);
  for (std::int32_t z = low[2]; z <= high[2]; z += kHyperchunkSide) {
    for (std::int32_t y = low[1]; y <= high[1]; y += kHyperchunkSide) {
      for (std::int32_t x = low[0]; x <= high[0]; x += kHyperchunkSide) {
        std::fill(met.begin(), met.end(), 0);
        rows.Mark({x, y, z}, met.data(), 0, nullptr);
        for (std::size_t row = 0; row < kBrickRows; ++row) {
          for (std::uint64_t rest = met[row]; rest != 0; rest &= rest - 1) {
            visit(GridIndex{x + std::countr_zero(rest), y + static_cast<std::int32_t>(row & 63U),
                            z + static_cast<std::int32_t>(row >> 6U)});
          }
        }
      }
    }
  }
}

/// Which triangles may reach into each hyperchunk of a box.
struct Bins {
  std::vector<std::uint32_t> first;  // by cell of the box, and the end
  std::vector<std::uint32_t> items;
};

Bins BinByHyperchunk(const std::vector<SnappedPoint>& points, std::span<const Corners> triangles,
                     const HyperchunkBox& box) {
  struct Meeting {
    std::uint32_t cell;
    std::uint32_t triangle;
  };
  constexpr std::size_t kBlock = 16384;
  std::vector<std::vector<Meeting>> blocks((triangles.size() + kBlock - 1) / kBlock);
  tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t b) {
    const std::size_t end = std::min(triangles.size(), (b + 1) * kBlock);
    blocks[b].reserve(kBlock + kBlock / 4);
    for (std::size_t t = b * kBlock; t < end; ++t) {
      const auto& [i, j, k] = triangles[t];
      ForEachHyperchunk({points[i], points[j], points[k]}, [&](const GridIndex& place) {
        blocks[b].push_back(
            {static_cast<std::uint32_t>(box.CellOf(place)), static_cast<std::uint32_t>(t)});
      });
    }
  });
  Bins bins;
  bins.first.assign(box.cells() + 1, 0);
  for (const auto& block : blocks) {
    for (const Meeting& m : block) ++bins.first[m.cell + 1];
  }
  for (std::size_t c = 1; c < bins.first.size(); ++c) bins.first[c] += bins.first[c - 1];
  bins.items.resize(bins.first.back());
  std::vector<std::uint32_t> next(bins.first.begin(), bins.first.end() - 1);
  for (const auto& block : blocks) {
    for (const Meeting& m : block) bins.items[next[m.cell]++] = m.triangle;
  }
  return bins;
}

std::span<const std::uint32_t> ItemsAt(const Bins& bins, std::size_t cell) {
  return std::span(bins.items).subspan(bins.first[cell], bins.first[cell + 1] - bins.first[cell]);
}

/// Whether there is any.
bool FindOctets(const std::uint64_t* rows, std::array<std::uint8_t, kHyperchunkSide>& octets) {
  unsigned any = 0;
  for (std::size_t o = 0; o < kBrickRows / 8; ++o) {
    std::uint64_t bits = 0;
    for (std::size_t i = 0; i < 8; ++i) bits |= rows[8 * o + i];
    const unsigned bit = bits != 0 ? 1U << (o & 7U) : 0U;
    octets[o >> 3U] = static_cast<std::uint8_t>(octets[o >> 3U] | bit);
    any |= bit;
  }
  return any != 0;
}

}  // namespace

SurfaceBricks::SurfaceBricks(const TriangleMesh& mesh_W, const Features& features,
                             double voxel_size, const MeshFacing& facing) {
  const std::vector<SnappedPoint> points = SnapAll(mesh_W.vertices, voxel_size);
  std::vector<Corners> edges;
  edges.reserve(features.edges.size());
  for (const auto& [a, b] : features.edges) edges.push_back({a, b, b});
  std::vector<Corners> vertices;
  vertices.reserve(features.vertices.size());
  for (const std::uint32_t v : features.vertices) vertices.push_back({v, v, v});
  const std::array<std::span<const Corners>, kFields> items{mesh_W.triangles, edges, vertices};

  std::array<std::int64_t, 3> low{INT64_MAX, INT64_MAX, INT64_MAX};
  std::array<std::int64_t, 3> high{INT64_MIN, INT64_MIN, INT64_MIN};
  for (const Corners& t : mesh_W.triangles) {
    for (const std::uint32_t v : t) {
      for (std::size_t k = 0; k < 3; ++k) {
        low[k] = std::min(low[k], points[v][k]);
        high[k] = std::max(high[k], points[v][k]);
      }
    }
  }
  const auto place_of = [](const std::array<std::int64_t, 3>& p) {
    return GridIndex{static_cast<std::int32_t>(p[0] >> kBrickBits),
                     static_cast<std::int32_t>(p[1] >> kBrickBits),
                     static_cast<std::int32_t>(p[2] >> kBrickBits)};
  };
  const GridIndex border{1, 1, 1};
  box_.first = place_of(low) - border;
  box_.size = place_of(high) + border * 2 - box_.first;

  std::array<Bins, kFields> bins;
  for (std::size_t f = 0; f < kFields; ++f) bins[f] = BinByHyperchunk(points, items[f], box_);

  std::size_t sources = 0;
  for (std::int32_t z = 0; z < box_.size.z; ++z) {
    for (std::int32_t y = 0; y < box_.size.y; ++y) {
      for (std::int32_t x = 0; x < box_.size.x; ++x) {
        const GridIndex place = box_.first + GridIndex{x, y, z};
        const std::size_t cell = box_.CellOf(place);
        if (ItemsAt(bins[0], cell).empty()) continue;
        bricks_.emplace_back().place = place;
        for (const Bins& b : bins) sources += !ItemsAt(b, cell).empty();
      }
    }
  }
  std::sort(bricks_.begin(), bricks_.end(), [](const Brick& a, const Brick& b) {
    return MortonCode(a.place) < MortonCode(b.place);
  });
  brick_at_.assign(box_.cells(), 0);
  constexpr std::size_t kStride = kBrickRows + TriangleRows::kPadding;
  rows_ = ImageBytes(sources * kStride * sizeof(std::uint64_t));
  auto* rows = reinterpret_cast<std::uint64_t*>(rows_.data());
  std::vector<std::array<std::uint64_t*, kFields>> rows_of(bricks_.size());
  for (std::size_t b = 0; b < bricks_.size(); ++b) {
    const std::size_t cell = box_.CellOf(bricks_[b].place);
    brick_at_[cell] = static_cast<std::uint32_t>(b + 1);
    for (std::size_t f = 0; f < kFields; ++f) {
      if (ItemsAt(bins[f], cell).empty()) continue;
      rows_of[b][f] = rows;
      rows += kStride;
    }
  }
  tbb::parallel_for(std::size_t{0}, bricks_.size(), [&](std::size_t b) {
    Brick& brick = bricks_[b];
    const GridIndex first = brick.place * kHyperchunkSide;
    for (std::size_t f = 0; f < kFields; ++f) {
      if (rows_of[b][f] == nullptr) continue;
      TriangleBatch batch(first, rows_of[b][f], &brick.crossings);
      for (const std::uint32_t item : ItemsAt(bins[f], box_.CellOf(brick.place))) {
        const auto& [i, j, k] = items[f][item];
        const bool crosses = f == 0 && (facing.open.empty() || facing.open[item] == 0);
        batch.Add(points[i], points[j], points[k], crosses ? facing.of_triangle[item] : 0);
      }
      batch.Finish();
      if (FindOctets(rows_of[b][f], brick.sources[f].octets)) brick.sources[f].rows = rows_of[b][f];
    }
  });
}

}  // namespace tandem
