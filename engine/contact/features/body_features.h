#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "engine/base/files/image_bytes.h"
#include "engine/base/spatial.h"
#include "engine/contact/features/feature_points.h"
#include "engine/contact/schedule/point_blocks.h"
#include "engine/voxel/map/voxel.h"

namespace tandem {

/// The features of a body's surface, packed: its feature points in the frame V of the body's
/// distance field, in voxels. Read-only once built.
///
/// Points that lie together share a block of 16, and neighbouring blocks share a chunk, so that
/// points that come near together are looked at together. All data lie in one block of bytes, which
/// feature_image.h draws and copies share.
class BodyFeatures {
 public:
  static constexpr std::size_t kLanes = PointBlocks::kLanes;
  /// The points of a block, relative to its middle. Lanes past its count repeat its first point.
  using Lanes = PointBlocks::Lanes;
  struct Block {
    GridIndex middle;
    /// Radius of a ball round the middle that holds the block's points and edge parts.
    float radius = 0;
    std::uint32_t chunk = 0;
    std::uint16_t lanes = 0;  // bit i: lane i holds a point and repeats none
    std::uint16_t sharp = 0;  // bit i: that point is on an edge that other edges may cross
  };
  /// The blocks [first, first + count).
  struct Chunk {
    Vec3 middle = Vec3::Zero();
    double radius = 0;
    std::uint32_t first = 0;
    std::uint32_t count = 0;
  };
  static constexpr std::uint32_t kNoEdge = ~0U;
  struct Point {
    Vec3f inward = Vec3f::Zero();  // unit, into the body
    std::uint32_t edge = kNoEdge;  // number of its edge, if other edges may cross that
    /// The weight of an edge's part is its length in voxels, so that finer parts push together as
    /// much as one of a voxel. The weight of a vertex is 1.
    float weight = 1;
  };
  /// The part of a sharp edge in a voxel.
  struct Edge {
    Vec3 middle = Vec3::Zero();
    Vec3f tangent = Vec3f::Zero();
    Vec3f outward = Vec3f::Zero();
    float half_length = 0;
    /// As FeatureNormals::edge_cosines; 0 where the edge is an open rim or has more than two faces.
    float cosine = 0;
    std::uint32_t ends = 0;  // 1: the part ends at a vertex, which the tangent points away from
    std::uint32_t unused = 0;
  };
  static_assert(sizeof(Edge) == 64);

  BodyFeatures() = default;
  /// `points` and X_VW are in voxels.
  BodyFeatures(std::span<const FeaturePoint> points, const Pose& X_VW);

  std::span<const Block> blocks() const noexcept { return blocks_; }
  std::span<const Chunk> chunks() const noexcept { return chunks_; }
  const Lanes& lanes(std::size_t block) const noexcept { return lanes_[block]; }
  const Point& point(std::size_t block, std::size_t lane) const noexcept {
    return points_[kLanes * block + lane];
  }
  Vec3 place(std::size_t block, std::size_t lane) const noexcept {
    const GridIndex& middle = blocks_[block].middle;
    const Lanes& lanes = lanes_[block];
    return Vec3(middle.x, middle.y, middle.z) + Vec3(lanes.x[lane], lanes.y[lane], lanes.z[lane]);
  }
  std::size_t point_count() const noexcept { return point_count_; }
  /// FeatureImage::Read() makes the same features from these bytes.
  std::span<const std::byte> bytes() const noexcept { return block_.bytes; }
  const Edge& edge(std::size_t number) const noexcept { return edges_[number]; }
  /// Returns the greatest half length of a sharp edge's part.
  double longest_half() const noexcept { return longest_half_; }

  /// Returns a lower bound of the distance from a place to the middle of any sharp edge's part,
  /// voxels; at most kFarEdges.
  double EdgesBeyond(const Vec3& place_V) const noexcept;
  static constexpr double kFarEdges = 12;
  /// Calls visit(edge) for all sharp edge parts whose middles may lie within the box from `low_V`
  /// to `high_V`, in an order that depends on nothing else.
  template <class Visit>
  void VisitEdgesIn(const Vec3& low_V, const Vec3& high_V, const Visit& visit) const noexcept {
    const GridIndex low = CellAt(low_V);
    const GridIndex high = CellAt(high_V);
    for (std::int32_t z = low.z; z <= high.z; ++z) {
      for (std::int32_t y = low.y; y <= high.y; ++y) {
        for (std::int32_t x = low.x; x <= high.x; ++x) {
          for (const std::uint32_t edge : EdgesOf({x, y, z})) visit(edges_[edge]);
        }
      }
    }
  }

 private:
  friend class FeatureImage;
  friend class FeatureBuilder;

  static constexpr int kCellBits = 2;  // edges are found by cubes of 4 voxels
  /// An entry of a hash table: a cell, and the range of its edges in edges_by_cell_.
  struct Slot {
    std::uint64_t cell = ~std::uint64_t{0};
    std::uint32_t first = 0;
    std::uint32_t count = 0;
  };
  /// The step of an entry of edge_distances_, voxels.
  static constexpr double kEdgeStep = kFarEdges / 255;
  /// A box of cells, x fastest.
  struct CellBox {
    GridIndex first;
    GridIndex count;

    bool Holds(const GridIndex& cell) const noexcept;
    std::size_t NumberOf(const GridIndex& cell) const noexcept;
  };

  /// The block must have the size that its header says.
  explicit BodyFeatures(ImageBlock block);
  static GridIndex CellAt(const Vec3& place_V) noexcept;
  /// Returns the slot at which the search for a cell begins; `slots` is a power of two.
  static std::size_t FirstSlot(std::uint64_t cell, std::size_t slots) noexcept {
    return (cell * 0x9e3779b97f4a7c15ULL >> 20U) & (slots - 1);
  }
  std::span<const std::uint32_t> EdgesOf(const GridIndex& cell) const noexcept;

  std::size_t point_count_ = 0;
  double longest_half_ = 0;
  CellBox cells_;
  ImageBlock block_;
  // views into block_
  std::span<const Block> blocks_;
  std::span<const Lanes> lanes_;
  std::span<const Point> points_;
  std::span<const Chunk> chunks_;
  std::span<const Edge> edges_;
  std::span<const Slot> slots_;  // count: a power of two
  std::span<const std::uint32_t> edges_by_cell_;
  /// Per cell, in kEdgeStep: the distance to the nearest middle of an edge's part.
  std::span<const std::uint8_t> edge_distances_;
};

}  // namespace tandem
