#include "engine/contact/features/body_features.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <utility>
#include <vector>

#include "engine/base/check.h"
#include "engine/contact/features/feature_image.h"

namespace tandem {

namespace {

/// The greatest extent of a block's points along an axis, voxels.
constexpr double kBlockSide = 16;
constexpr int kChunkBits = 5;  // chunks lie in cubes of 32 voxels
/// As FeatureNormals::edge_cosines. Edges whose faces turn by less than 20 degrees are met by their
/// distance alone.
constexpr float kSharpEdge = 0.985F;

/// As std::floor(), which calls a library where the compiler may not assume an instruction.
std::int32_t RoundedDown(double x) {
  const auto cut = static_cast<std::int32_t>(x);
  return x < cut ? cut - 1 : cut;
}

GridIndex VoxelOf(const Vec3& place) {
  return {RoundedDown(place.x()), RoundedDown(place.y()), RoundedDown(place.z())};
}

}  // namespace

/// Packs feature points, in the order of their places.
class FeatureBuilder {
 public:
  FeatureBuilder(std::span<const FeaturePoint> points, const Pose& X_VW) {
    FindFeatures(points, X_VW);
    PackBlocks();
    BoundChunks();
    IndexEdges();
    MeasureEdgeDistances();
  }
  FeatureImage::Parts Take() { return std::move(parts_); }

 private:
  using Block = BodyFeatures::Block;
  using Chunk = BodyFeatures::Chunk;
  using Edge = BodyFeatures::Edge;
  using Lanes = BodyFeatures::Lanes;
  static constexpr std::size_t kLanes = BodyFeatures::kLanes;

  /// A point with its place in V and its place in the order of blocks.
  struct FoundFeature {
    Vec3 place;
    Vec3 inward;
    double half_length = 0;
    std::uint32_t edge = BodyFeatures::kNoEdge;
    std::uint64_t order = 0;
  };

  void FindFeatures(std::span<const FeaturePoint> points, const Pose& X_VW);
  void PackBlocks();
  void PackBlock(std::size_t begin, std::size_t end, const Bounds& box);
  void BoundChunks();
  void IndexEdges();
  void MeasureEdgeDistances();

  std::vector<FoundFeature> found_;
  FeatureImage::Parts parts_;
};

void FeatureBuilder::FindFeatures(std::span<const FeaturePoint> points, const Pose& X_VW) {
  const Mat3 R_VW = X_VW.q.toRotationMatrix();
  found_.reserve(points.size());
  for (const FeaturePoint& point : points) {
    FoundFeature feature{X_VW * point.place_W, R_VW * -point.outward, point.half_length};
    feature.order = MortonCode(VoxelOf(feature.place));
    if (point.is_edge() && point.cosine < kSharpEdge) {
      feature.edge = static_cast<std::uint32_t>(parts_.edges.size());
      parts_.edges.push_back({.middle = feature.place,
                              .tangent = (R_VW * point.tangent).cast<float>(),
                              .outward = (-feature.inward).cast<float>(),
                              .half_length = static_cast<float>(feature.half_length),
                              .cosine = static_cast<float>(point.cosine),
                              .ends = point.ends ? 1U : 0U});
      parts_.header.longest_half = std::max(parts_.header.longest_half, feature.half_length);
    }
    found_.push_back(feature);
  }
  std::stable_sort(found_.begin(), found_.end(), [](const FoundFeature& a, const FoundFeature& b) {
    return a.order < b.order;
  });
  parts_.header.points = found_.size();
}

void FeatureBuilder::PackBlocks() {
  for (std::size_t begin = 0; begin < found_.size();) {
    Bounds box;
    std::size_t end = begin;
    for (; end < found_.size() && end < begin + kLanes; ++end) {
      if (found_[end].order >> (3 * kChunkBits) != found_[begin].order >> (3 * kChunkBits)) break;
      Bounds wider = box;
      wider.Add(found_[end].place);
      if (wider.size().maxCoeff() > kBlockSide) break;
      box = wider;
    }
    PackBlock(begin, end, box);
    begin = end;
  }
}

/// Packs the features [begin, end), which lie in `box`.
void FeatureBuilder::PackBlock(std::size_t begin, std::size_t end, const Bounds& box) {
  Block block;
  block.middle = VoxelOf(box.centre() + Vec3::Constant(0.5));
  const Vec3 middle(block.middle.x, block.middle.y, block.middle.z);
  Lanes lanes;
  double radius = 0;
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    const bool own = begin + lane < end;
    const FoundFeature& feature = found_[own ? begin + lane : begin];
    const Vec3f from = (feature.place - middle).cast<float>();
    lanes.x[lane] = from.x();
    lanes.y[lane] = from.y();
    lanes.z[lane] = from.z();
    const double weight = feature.half_length > 0 ? std::min(1.0, 2 * feature.half_length) : 1.0;
    parts_.points.push_back(
        {feature.inward.cast<float>(), feature.edge, static_cast<float>(weight)});
    if (!own) continue;
    block.lanes = static_cast<std::uint16_t>(block.lanes | 1U << lane);
    const bool sharp = feature.edge != BodyFeatures::kNoEdge;
    if (sharp) block.sharp = static_cast<std::uint16_t>(block.sharp | 1U << lane);
    radius = std::max(radius, (feature.place - middle).norm() + (sharp ? feature.half_length : 0));
  }
  block.radius = static_cast<float>(radius * (1 + 1e-6));
  const bool joins =
      !parts_.chunks.empty() && parts_.chunks.back().count < FeatureImage::kMostBlocks &&
      found_[begin].order >> (3 * kChunkBits) == found_[begin - 1].order >> (3 * kChunkBits);
  if (!joins) parts_.chunks.push_back({.first = static_cast<std::uint32_t>(parts_.blocks.size())});
  ++parts_.chunks.back().count;
  block.chunk = static_cast<std::uint32_t>(parts_.chunks.size() - 1);
  parts_.blocks.push_back(block);
  parts_.lanes.push_back(lanes);
}

void FeatureBuilder::BoundChunks() {
  for (Chunk& chunk : parts_.chunks) {
    const std::span<const Block> blocks(&parts_.blocks[chunk.first], chunk.count);
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
}

void FeatureBuilder::IndexEdges() {
  parts_.edges_by_cell.resize(parts_.edges.size());
  std::vector<std::uint64_t> cells(parts_.edges.size());
  for (std::uint32_t e = 0; e < parts_.edges.size(); ++e) {
    parts_.edges_by_cell[e] = e;
    cells[e] = MortonCode(BodyFeatures::CellAt(parts_.edges[e].middle));
  }
  std::stable_sort(parts_.edges_by_cell.begin(), parts_.edges_by_cell.end(),
                   [&cells](std::uint32_t a, std::uint32_t b) {
                     return cells[a] < cells[b];
                   });
  parts_.slots.assign(std::bit_ceil(2 * parts_.edges.size() + 1), {});
  for (std::uint32_t begin = 0; begin < parts_.edges.size();) {
    const std::uint64_t cell = cells[parts_.edges_by_cell[begin]];
    std::uint32_t end = begin;
    while (end < parts_.edges.size() && cells[parts_.edges_by_cell[end]] == cell) ++end;
    std::size_t at = BodyFeatures::FirstSlot(cell, parts_.slots.size());
    while (parts_.slots[at].count != 0) at = (at + 1) & (parts_.slots.size() - 1);
    parts_.slots[at] = {cell, begin, end - begin};
    begin = end;
  }
}

void FeatureBuilder::MeasureEdgeDistances() {
  if (parts_.edges.empty()) return;
  constexpr std::int32_t kReach =
      static_cast<std::int32_t>(BodyFeatures::kFarEdges) >> BodyFeatures::kCellBits;
  GridIndex low = BodyFeatures::CellAt(parts_.edges.front().middle);
  GridIndex high = low;
  for (const Edge& edge : parts_.edges) {
    const GridIndex cell = BodyFeatures::CellAt(edge.middle);
    low = {std::min(low.x, cell.x), std::min(low.y, cell.y), std::min(low.z, cell.z)};
    high = {std::max(high.x, cell.x), std::max(high.y, cell.y), std::max(high.z, cell.z)};
  }
  constexpr GridIndex kMargin{kReach, kReach, kReach};
  const BodyFeatures::CellBox cells{low - kMargin, high - low + kMargin * 2 + GridIndex{1, 1, 1}};
  parts_.header.first_cell = cells.first;
  parts_.header.cell_count = cells.count;
  parts_.edge_distances.assign(static_cast<std::size_t>(cells.count.x) *
                                   static_cast<std::size_t>(cells.count.y) *
                                   static_cast<std::size_t>(cells.count.z),
                               255);
  constexpr std::size_t kWidth = 2 * kReach + 1;
  using Squares = std::array<double, kWidth>;
  for (const Edge& edge : parts_.edges) {
    const GridIndex at = BodyFeatures::CellAt(edge.middle);
    // by axis: the squared distances from the cells about it
    std::array<Squares, 3> squares;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<Eigen::Index>(axis);
      const std::int32_t own = axis == 0 ? at.x : axis == 1 ? at.y : at.z;
      for (std::size_t k = 0; k < kWidth; ++k) {
        const double begin = (own - kReach + static_cast<std::int32_t>(k))
                             << BodyFeatures::kCellBits;
        const double apart = std::max(
            {0.0, begin - edge.middle[a], edge.middle[a] - begin - (1 << BodyFeatures::kCellBits)});
        squares[axis][k] = apart * apart;
      }
    }
    for (std::size_t z = 0; z < kWidth; ++z) {
      for (std::size_t y = 0; y < kWidth; ++y) {
        const double across = squares[1][y] + squares[2][z];
        if (across >= BodyFeatures::kFarEdges * BodyFeatures::kFarEdges) continue;
        std::uint8_t* row = &parts_.edge_distances[cells.NumberOf(
            at + GridIndex{-kReach, static_cast<std::int32_t>(y) - kReach,
                           static_cast<std::int32_t>(z) - kReach})];
        for (std::size_t x = 0; x < kWidth; ++x) {
          const double steps = std::sqrt(squares[0][x] + across) / BodyFeatures::kEdgeStep;
          row[x] = std::min(row[x], static_cast<std::uint8_t>(std::min(steps, 255.0)));
        }
      }
    }
  }
}

BodyFeatures::BodyFeatures(std::span<const FeaturePoint> points, const Pose& X_VW)
    : BodyFeatures(FeatureImage::Pack(FeatureBuilder(points, X_VW).Take())) {}

BodyFeatures::BodyFeatures(ImageBlock block) : block_(std::move(block)) {
  FeatureHeader header;
  TANDEM_CHECK(block_.bytes.size() >= sizeof header);
  std::memcpy(&header, block_.bytes.data(), sizeof header);
  const FeatureImage::Places places = FeatureImage::PlacesOf(header);
  TANDEM_CHECK(block_.bytes.size() == places.bytes);
  point_count_ = header.points;
  longest_half_ = header.longest_half;
  cells_ = {header.first_cell, header.cell_count};
  const std::uint64_t cells = block_.bytes.size() - places.edge_distances;
  blocks_ = ArrayIn<Block>(block_.bytes, places.blocks, header.blocks);
  lanes_ = ArrayIn<Lanes>(block_.bytes, places.lanes, header.blocks);
  points_ = ArrayIn<Point>(block_.bytes, places.points, kLanes * header.blocks);
  chunks_ = ArrayIn<Chunk>(block_.bytes, places.chunks, header.chunks);
  edges_ = ArrayIn<Edge>(block_.bytes, places.edges, header.edges);
  slots_ = ArrayIn<Slot>(block_.bytes, places.slots, header.slots);
  edges_by_cell_ = ArrayIn<std::uint32_t>(block_.bytes, places.edges_by_cell, header.edges);
  edge_distances_ = ArrayIn<std::uint8_t>(block_.bytes, places.edge_distances, cells);
}

bool BodyFeatures::CellBox::Holds(const GridIndex& cell) const noexcept {
  const GridIndex in = cell - first;
  return in.x >= 0 && in.y >= 0 && in.z >= 0 && in.x < count.x && in.y < count.y && in.z < count.z;
}

std::size_t BodyFeatures::CellBox::NumberOf(const GridIndex& cell) const noexcept {
  const GridIndex in = cell - first;
  return static_cast<std::size_t>(in.x) +
         static_cast<std::size_t>(count.x) *
             (static_cast<std::size_t>(in.y) +
              static_cast<std::size_t>(count.y) * static_cast<std::size_t>(in.z));
}

double BodyFeatures::EdgesBeyond(const Vec3& place_V) const noexcept {
  const GridIndex cell = CellAt(place_V);
  return cells_.Holds(cell) ? kEdgeStep * edge_distances_[cells_.NumberOf(cell)] : kFarEdges;
}

GridIndex BodyFeatures::CellAt(const Vec3& place_V) noexcept {
  return VoxelOf(place_V) >> kCellBits;
}

std::span<const std::uint32_t> BodyFeatures::EdgesOf(const GridIndex& cell) const noexcept {
  // the distance of a cell that holds an edge is 0
  if (!cells_.Holds(cell) || edge_distances_[cells_.NumberOf(cell)] != 0) return {};
  const std::uint64_t code = MortonCode(cell);
  std::size_t at = FirstSlot(code, slots_.size());
  for (; slots_[at].count != 0; at = (at + 1) & (slots_.size() - 1)) {
    if (slots_[at].cell == code) return edges_by_cell_.subspan(slots_[at].first, slots_[at].count);
  }
  return {};
}

}  // namespace tandem
