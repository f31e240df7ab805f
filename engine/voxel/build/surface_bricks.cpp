#include "engine/voxel/build/surface_bricks.h"

#include <algorithm>
#include <bit>
#include <span>

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include "engine/base/check.h"
#include "engine/base/huge_vector.h"
#include "engine/voxel/build/triangles/triangle_batch.h"

namespace tandem {

namespace {

constexpr int kBrickBits = kSnapBits + 6;  // snapped units across a hyperchunk
constexpr std::int32_t kFewBricks = 3;     // along a side; few enough to take all without a test

using Corners = std::array<std::uint32_t, 3>;

HugeVector<SnappedPoint> SnapAll(const std::vector<Vec3>& points, double voxel_size) {
  HugeVector<SnappedPoint> snapped(points.size());
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
  // a large triangle's hyperchunks are found as voxels are
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

/// The triangles that may reach into each hyperchunk of a box.
struct Bins {
  std::vector<std::uint32_t> first;  // per cell of the box, and the end
  HugeVector<std::uint32_t> items;
};

Bins BinByHyperchunk(const HugeVector<SnappedPoint>& points, std::span<const Corners> triangles,
                     const HyperchunkBox& box) {
  // for most triangles the one hyperchunk; kMany: visit them again
  constexpr std::uint32_t kMany = ~0U;
  HugeVector<std::uint32_t> cell_of(triangles.size());
  const auto for_each = [&](std::size_t t, const auto& visit) {
    const auto& [i, j, k] = triangles[t];
    ForEachHyperchunk({points[i], points[j], points[k]}, [&](const GridIndex& place) {
      visit(static_cast<std::uint32_t>(box.CellOf(place)));
    });
  };
  const auto place_of = [](const SnappedPoint& p) {
    return GridIndex{static_cast<std::int32_t>(p[0] >> kBrickBits),
                     static_cast<std::int32_t>(p[1] >> kBrickBits),
                     static_cast<std::int32_t>(p[2] >> kBrickBits)};
  };
  tbb::parallel_for(
      tbb::blocked_range<std::size_t>(0, triangles.size(), 16384), [&](const auto& some) {
        for (std::size_t t = some.begin(); t < some.end(); ++t) {
          const auto& [i, j, k] = triangles[t];
          const GridIndex place = place_of(points[i]);
          const bool one = place == place_of(points[j]) && place == place_of(points[k]);
          cell_of[t] = one ? static_cast<std::uint32_t>(box.CellOf(place)) : kMany;
        }
      });
  Bins bins;
  bins.first.assign(box.cells() + 1, 0);
  std::vector<std::uint32_t> many;  // triangle and cell, alternating
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    if (cell_of[t] != kMany) {
      ++bins.first[cell_of[t] + 1];
      continue;
    }
    for_each(t, [&](std::uint32_t cell) {
      ++bins.first[cell + 1];
      many.push_back(static_cast<std::uint32_t>(t));
      many.push_back(cell);
    });
  }
  for (std::size_t c = 1; c < bins.first.size(); ++c) bins.first[c] += bins.first[c - 1];
  bins.items.resize(bins.first.back());
  std::vector<std::uint32_t> next(bins.first.begin(), bins.first.end() - 1);
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    if (cell_of[t] != kMany) bins.items[next[cell_of[t]]++] = t;
  }
  for (std::size_t m = 0; m < many.size(); m += 2) bins.items[next[many[m + 1]]++] = many[m];
  return bins;
}

std::span<const std::uint32_t> ItemsAt(const Bins& bins, std::size_t cell) {
  return std::span(bins.items).subspan(bins.first[cell], bins.first[cell + 1] - bins.first[cell]);
}

/// Returns the box of the hyperchunks of all triangles, with a border.
HyperchunkBox BoxOf(const HugeVector<SnappedPoint>& points, std::span<const Corners> triangles,
                    int border) {
  std::array<std::int64_t, 3> low{INT64_MAX, INT64_MAX, INT64_MAX};
  std::array<std::int64_t, 3> high{INT64_MIN, INT64_MIN, INT64_MIN};
  for (const Corners& t : triangles) {
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
  const GridIndex around{border, border, border};
  HyperchunkBox box;
  box.first = place_of(low) - around;
  box.size = place_of(high) + around + GridIndex{1, 1, 1} - box.first;
  return box;
}

/// Returns empty bricks, in Morton order, where the surface may be.
std::vector<SurfaceBricks::Brick> BricksOf(const Bins& surface, const HyperchunkBox& box,
                                           const HyperchunkLayers& layers) {
  std::vector<SurfaceBricks::Brick> bricks;
  for (std::int32_t z = 0; z < box.size.z; ++z) {
    for (std::int32_t y = 0; y < box.size.y; ++y) {
      for (std::int32_t x = 0; x < box.size.x; ++x) {
        const GridIndex place = box.first + GridIndex{x, y, z};
        if (!layers.Hold(place) || ItemsAt(surface, box.CellOf(place)).empty()) continue;
        bricks.emplace_back().place = place;
      }
    }
  }
  std::sort(bricks.begin(), bricks.end(),
            [](const SurfaceBricks::Brick& a, const SurfaceBricks::Brick& b) {
              return MortonCode(a.place) < MortonCode(b.place);
            });
  return bricks;
}

using Items = std::array<std::span<const Corners>, kFields>;

void FillBricks(const HugeVector<SnappedPoint>& points, const Items& items,
                const std::array<Bins, kFields>& bins, const MeshFacing& facing,
                const HyperchunkBox& box, std::vector<SurfaceBricks::Brick>& bricks) {
  struct Scratch {
    std::vector<std::uint64_t> rows =
        std::vector<std::uint64_t>(kBrickRows + TriangleRows::kPadding, 0);
    SurfaceBricks::Packer packer;
    std::vector<Crossing> crossings;
  };
  tbb::enumerable_thread_specific<Scratch> scratch;
  tbb::parallel_for(std::size_t{0}, bricks.size(), [&](std::size_t b) {
    Scratch& mine = scratch.local();
    mine.crossings.clear();
    SurfaceBricks::Brick& brick = bricks[b];
    const GridIndex first = brick.place * kHyperchunkSide;
    for (std::size_t f = 0; f < kFields; ++f) {
      const auto here = ItemsAt(bins[f], box.CellOf(brick.place));
      if (!here.empty()) {
        TriangleBatch batch(first, mine.rows.data(), &mine.crossings);
        for (const std::uint32_t item : here) {
          const auto& [i, j, k] = items[f][item];
          const bool crosses = f == 0 && (facing.open.empty() || facing.open[item] == 0);
          batch.Add(points[i], points[j], points[k], crosses ? facing.of_triangle[item] : 0);
        }
        batch.Finish();
        mine.packer.Take(static_cast<Field>(f), mine.rows.data());
      }
    }
    mine.packer.Fill(brick);
    brick.crossings.assign(mine.crossings.begin(), mine.crossings.end());
  });
}

}  // namespace

constexpr std::array<std::uint64_t, kBrickRows> SurfaceBricks::kFullWords = [] {
  std::array<std::uint64_t, kBrickRows> words{};
  for (std::uint64_t& word : words) word = ~std::uint64_t{0};
  return words;
}();

void SurfaceBricks::Packer::Take(Field field, std::uint64_t* rows) {
  if (std::equal(kFullWords.begin(), kFullWords.end(), rows)) {
    TakeFull(field);
    std::fill_n(rows, kBrickRows, 0);
    return;
  }
  Source& source = sources_[static_cast<std::size_t>(field)];
  begin_[static_cast<std::size_t>(field)] = words_.size();
  std::uint16_t count = 0;
  for (std::size_t z = 0; z < kHyperchunkSide; ++z) {
    source.first[z] = count;
    unsigned here = 0;
    for (std::size_t j = 0; j < 8; ++j) {
      std::uint64_t* const octet = rows + 8 * j + kHyperchunkSide * z;
      std::uint64_t any = 0;
      for (std::size_t i = 0; i < 8; ++i) any |= octet[i];
      if (any == 0) continue;
      words_.insert(words_.end(), octet, octet + 8);
      std::fill_n(octet, 8, 0);
      here |= 1U << j;
      ++count;
    }
    source.octets[z] = static_cast<std::uint8_t>(here);
  }
  if (count > 0) source.words = words_.data();  // Fill() finds the brick's own words
}

void SurfaceBricks::Packer::TakeFull(Field field) {
  Source& source = sources_[static_cast<std::size_t>(field)];
  source.words = kFullWords.data();
  source.octets.fill(0xff);
  for (std::size_t z = 0; z < kHyperchunkSide; ++z) {
    source.first[z] = static_cast<std::uint16_t>(8 * z);
  }
}

void SurfaceBricks::Packer::Fill(Brick& brick) {
  brick.words.assign(words_.begin(), words_.end());
  for (std::size_t f = 0; f < kFields; ++f) {
    brick.sources[f] = sources_[f];
    if (!sources_[f].empty() && !sources_[f].full()) {
      brick.sources[f].words = brick.words.data() + begin_[f];
    }
  }
  sources_ = {};
  words_.clear();
}

SurfaceBricks::SurfaceBricks(const HyperchunkBox& box, std::vector<Brick> bricks)
    : box_(box), brick_at_(box.cells()), bricks_(std::move(bricks)) {
  TANDEM_CHECK(bricks_.size() == box.cells());
  for (std::size_t b = 0; b < bricks_.size(); ++b) brick_at_[b] = static_cast<std::uint32_t>(b + 1);
}

SurfaceBricks::SurfaceBricks(const TriangleMesh& mesh_W, const Features& features,
                             double voxel_size, const MeshFacing& facing, int border,
                             const HyperchunkLayers& layers)
    : layers_(layers) {
  const HugeVector<SnappedPoint> points = SnapAll(mesh_W.vertices, voxel_size);
  std::vector<Corners> edges;
  edges.reserve(features.edges.size());
  for (const auto& [a, b] : features.edges) edges.push_back({a, b, b});
  std::vector<Corners> vertices;
  vertices.reserve(features.vertices.size());
  for (const std::uint32_t v : features.vertices) vertices.push_back({v, v, v});
  const Items items{mesh_W.triangles, edges, vertices};

  box_ = BoxOf(points, mesh_W.triangles, border);
  std::array<Bins, kFields> bins;
  for (std::size_t f = 0; f < kFields; ++f) bins[f] = BinByHyperchunk(points, items[f], box_);

  bricks_ = BricksOf(bins[0], box_, layers_);
  brick_at_.assign(box_.cells(), 0);
  for (std::size_t b = 0; b < bricks_.size(); ++b) {
    brick_at_[box_.CellOf(bricks_[b].place)] = static_cast<std::uint32_t>(b + 1);
  }
  FillBricks(points, items, bins, facing, box_, bricks_);
}

}  // namespace tandem
