#include "engine/contact/body_features.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace tandem {

namespace {

/// Voxels: the widest that a block's points lie apart along an axis.
constexpr double kBlockSide = 16;
constexpr int kChunkBits = 5;  // chunks lie in cubes of 32 voxels
constexpr std::size_t kMostBlocks = 64;
/// As FeatureNormals::edge_cosines: an edge whose faces turn by less than 20 degrees is met by its
/// distance alone.
constexpr float kSharpEdge = 0.985F;

/// As std::floor(), which calls a library where the compiler may not take an instruction for
/// granted.
std::int32_t RoundedDown(double x) {
  const auto cut = static_cast<std::int32_t>(x);
  return x < cut ? cut - 1 : cut;
}

GridIndex VoxelOf(const Vec3& place) {
  return {RoundedDown(place.x()), RoundedDown(place.y()), RoundedDown(place.z())};
}

/// A point with its place in V and its place in the order of blocks.
struct FoundFeature {
  Vec3 place;
  Vec3 inward;
  double half_length = 0;
  std::uint32_t edge = BodyFeatures::kNoEdge;
  std::uint64_t order = 0;
};

}  // namespace

BodyFeatures::BodyFeatures(std::span<const FeaturePoint> points, const Pose& X_VW) {
  const Mat3 R_VW = X_VW.q.toRotationMatrix();
  std::vector<FoundFeature> found;
  found.reserve(points.size());
  for (const FeaturePoint& point : points) {
    FoundFeature feature{X_VW * point.place_W, R_VW * -point.outward, point.half_length};
    feature.order = MortonCode(VoxelOf(feature.place));
    if (point.is_edge() && point.cosine < kSharpEdge) {
      feature.edge = static_cast<std::uint32_t>(edges_.size());
      edges_.push_back({.middle = feature.place,
                        .tangent = (R_VW * point.tangent).cast<float>(),
                        .outward = (-feature.inward).cast<float>(),
                        .half_length = static_cast<float>(feature.half_length),
                        .cosine = static_cast<float>(point.cosine),
                        .ends = point.ends});
      longest_half_ = std::max(longest_half_, feature.half_length);
    }
    found.push_back(feature);
  }
  std::stable_sort(found.begin(), found.end(), [](const FoundFeature& a, const FoundFeature& b) {
    return a.order < b.order;
  });
  point_count_ = found.size();
  for (std::size_t begin = 0; begin < found.size();) {
    Bounds box;
    std::size_t end = begin;
    for (; end < found.size() && end < begin + kLanes; ++end) {
      if (found[end].order >> (3 * kChunkBits) != found[begin].order >> (3 * kChunkBits)) break;
      Bounds wider = box;
      wider.Add(found[end].place);
      if (wider.size().maxCoeff() > kBlockSide) break;
      box = wider;
    }
    Block block;
    block.middle = VoxelOf(box.centre() + Vec3::Constant(0.5));
    const Vec3 middle(block.middle.x, block.middle.y, block.middle.z);
    Lanes lanes;
    double radius = 0;
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      const bool own = begin + lane < end;
      const FoundFeature& feature = found[own ? begin + lane : begin];
      const Vec3f from = (feature.place - middle).cast<float>();
      lanes.x[lane] = from.x();
      lanes.y[lane] = from.y();
      lanes.z[lane] = from.z();
      const double weight = feature.half_length > 0 ? std::min(1.0, 2 * feature.half_length) : 1.0;
      points_.push_back({feature.inward.cast<float>(), feature.edge, static_cast<float>(weight)});
      if (!own) continue;
      block.lanes = static_cast<std::uint16_t>(block.lanes | 1U << lane);
      const bool sharp = feature.edge != kNoEdge;
      if (sharp) block.sharp = static_cast<std::uint16_t>(block.sharp | 1U << lane);
      radius =
          std::max(radius, (feature.place - middle).norm() + (sharp ? feature.half_length : 0));
    }
    block.radius = static_cast<float>(radius * (1 + 1e-6));
    const bool joins =
        !chunks_.empty() && chunks_.back().count < kMostBlocks &&
        found[begin].order >> (3 * kChunkBits) == found[begin - 1].order >> (3 * kChunkBits);
    if (!joins) chunks_.push_back({.first = static_cast<std::uint32_t>(blocks_.size())});
    ++chunks_.back().count;
    block.chunk = static_cast<std::uint32_t>(chunks_.size() - 1);
    blocks_.push_back(block);
    lanes_.push_back(lanes);
    begin = end;
  }
  for (Chunk& chunk : chunks_) {
    const std::span<const Block> blocks(&blocks_[chunk.first], chunk.count);
    Bounds box;
    const auto middle_of = [](const Block& block) {
      return Vec3(block.middle.x, block.middle.y, block.middle.z);
    };
    for (const Block& block : blocks) {
      box.Add(middle_of(block) - Vec3::Constant(block.radius));
      box.Add(middle_of(block) + Vec3::Constant(block.radius));
    }
    chunk.middle = box.centre();
    for (const Block& block : blocks) {
      chunk.radius =
          std::max(chunk.radius, (middle_of(block) - chunk.middle).norm() + block.radius);
    }
  }
  IndexEdges();
  MeasureEdgeDistances();
}

void BodyFeatures::MeasureEdgeDistances() {
  if (edges_.empty()) return;
  constexpr std::int32_t kReach = static_cast<std::int32_t>(kFarEdges) >> kCellBits;
  GridIndex low = CellAt(edges_.front().middle);
  GridIndex high = low;
  for (const Edge& edge : edges_) {
    const GridIndex cell = CellAt(edge.middle);
    low = {std::min(low.x, cell.x), std::min(low.y, cell.y), std::min(low.z, cell.z)};
    high = {std::max(high.x, cell.x), std::max(high.y, cell.y), std::max(high.z, cell.z)};
  }
  constexpr GridIndex kMargin{kReach, kReach, kReach};
  first_cell_ = low - kMargin;
  cell_count_ = high - low + kMargin * 2 + GridIndex{1, 1, 1};
  edge_distances_.assign(static_cast<std::size_t>(cell_count_.x) *
                             static_cast<std::size_t>(cell_count_.y) *
                             static_cast<std::size_t>(cell_count_.z),
                         255);
  constexpr std::size_t kWidth = 2 * kReach + 1;
  using Squares = std::array<double, kWidth>;
  for (const Edge& edge : edges_) {
    const GridIndex at = CellAt(edge.middle);
    // by axis: the square of the distance from the cells about it
    std::array<Squares, 3> squares;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<Eigen::Index>(axis);
      const std::int32_t own = axis == 0 ? at.x : axis == 1 ? at.y : at.z;
      for (std::size_t k = 0; k < kWidth; ++k) {
        const double begin = (own - kReach + static_cast<std::int32_t>(k)) << kCellBits;
        const double apart =
            std::max({0.0, begin - edge.middle[a], edge.middle[a] - begin - (1 << kCellBits)});
        squares[axis][k] = apart * apart;
      }
    }
    for (std::size_t z = 0; z < kWidth; ++z) {
      for (std::size_t y = 0; y < kWidth; ++y) {
        const double across = squares[1][y] + squares[2][z];
        if (across >= kFarEdges * kFarEdges) continue;
        std::uint8_t* row = &edge_distances_[CellNumber(
            at + GridIndex{-kReach, static_cast<std::int32_t>(y) - kReach,
                           static_cast<std::int32_t>(z) - kReach})];
        for (std::size_t x = 0; x < kWidth; ++x) {
          const double steps = std::sqrt(squares[0][x] + across) / kEdgeStep;
          row[x] = std::min(row[x], static_cast<std::uint8_t>(std::min(steps, 255.0)));
        }
      }
    }
  }
}

bool BodyFeatures::HoldsCell(const GridIndex& cell) const noexcept {
  const GridIndex in = cell - first_cell_;
  return in.x >= 0 && in.y >= 0 && in.z >= 0 && in.x < cell_count_.x && in.y < cell_count_.y &&
         in.z < cell_count_.z;
}

std::size_t BodyFeatures::CellNumber(const GridIndex& cell) const noexcept {
  const GridIndex in = cell - first_cell_;
  return static_cast<std::size_t>(in.x) +
         static_cast<std::size_t>(cell_count_.x) *
             (static_cast<std::size_t>(in.y) +
              static_cast<std::size_t>(cell_count_.y) * static_cast<std::size_t>(in.z));
}

std::size_t BodyFeatures::bytes() const noexcept {
  const auto of = [](const auto& all) {
    return all.size() * sizeof(all[0]);
  };
  return of(blocks_) + of(lanes_) + of(points_) + of(chunks_) + of(edges_) + of(slots_) +
         of(edges_by_cell_) + of(edge_distances_);
}

double BodyFeatures::EdgesBeyond(const Vec3& place_V) const noexcept {
  const GridIndex cell = CellAt(place_V);
  return HoldsCell(cell) ? kEdgeStep * edge_distances_[CellNumber(cell)] : kFarEdges;
}

GridIndex BodyFeatures::CellAt(const Vec3& place_V) noexcept {
  return VoxelOf(place_V) >> kCellBits;
}

void BodyFeatures::IndexEdges() {
  edges_by_cell_.resize(edges_.size());
  std::vector<std::uint64_t> cells(edges_.size());
  for (std::uint32_t e = 0; e < edges_.size(); ++e) {
    edges_by_cell_[e] = e;
    cells[e] = MortonCode(CellAt(edges_[e].middle));
  }
  std::stable_sort(edges_by_cell_.begin(), edges_by_cell_.end(),
                   [&cells](std::uint32_t a, std::uint32_t b) {
                     return cells[a] < cells[b];
                   });
  slots_.assign(std::bit_ceil(2 * edges_.size() + 1), {});
  for (std::uint32_t begin = 0; begin < edges_.size();) {
    const std::uint64_t cell = cells[edges_by_cell_[begin]];
    std::uint32_t end = begin;
    while (end < edges_.size() && cells[edges_by_cell_[end]] == cell) ++end;
    std::size_t at = cell * 0x9e3779b97f4a7c15ULL >> 20U & (slots_.size() - 1);
    while (slots_[at].count != 0) at = (at + 1) & (slots_.size() - 1);
    slots_[at] = {cell, begin, end - begin};
    begin = end;
  }
}

std::span<const std::uint32_t> BodyFeatures::EdgesOf(const GridIndex& cell) const noexcept {
  // a cell with an edge is no way from it
  if (!HoldsCell(cell) || edge_distances_[CellNumber(cell)] != 0) return {};
  const std::uint64_t code = MortonCode(cell);
  std::size_t at = code * 0x9e3779b97f4a7c15ULL >> 20U & (slots_.size() - 1);
  for (; slots_[at].count != 0; at = (at + 1) & (slots_.size() - 1)) {
    if (slots_[at].cell == code) {
      return std::span(edges_by_cell_).subspan(slots_[at].first, slots_[at].count);
    }
  }
  return {};
}

}  // namespace tandem
