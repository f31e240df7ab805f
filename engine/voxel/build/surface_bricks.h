#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <vector>

#include "engine/geometry/mesh/facets.h"
#include "engine/geometry/mesh/mesh_facing.h"
#include "engine/geometry/mesh/triangle_mesh.h"
#include "engine/voxel/build/triangles/triangle_rows.h"
#include "engine/voxel/map/voxel.h"

namespace tandem {

/// A box of hyperchunks, x fastest.
struct HyperchunkBox {
  GridIndex first;  // hyperchunks from W's origin
  GridIndex size;

  std::size_t cells() const noexcept {
    return static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y) *
           static_cast<std::size_t>(size.z);
  }
  bool Holds(const GridIndex& place) const noexcept {
    const GridIndex i = place - first;
    return i.x >= 0 && i.y >= 0 && i.z >= 0 && i.x < size.x && i.y < size.y && i.z < size.z;
  }
  std::size_t CellOf(const GridIndex& place) const noexcept {
    const GridIndex i = place - first;
    return static_cast<std::size_t>(i.x) +
           static_cast<std::size_t>(size.x) *
               (static_cast<std::size_t>(i.y) +
                static_cast<std::size_t>(size.y) * static_cast<std::size_t>(i.z));
  }
  GridIndex PlaceOf(std::size_t cell) const noexcept {
    const auto c = static_cast<std::int32_t>(cell);
    return first + GridIndex{c % size.x, c / size.x % size.y, c / size.x / size.y};
  }
};

/// The hyperchunks from one z to another, which is excluded.
struct HyperchunkLayers {
  std::int32_t begin = INT32_MIN;
  std::int32_t end = INT32_MAX;

  bool Hold(const GridIndex& place) const noexcept { return place.z >= begin && place.z < end; }
};

/// The sources of the three fields (paper §4) as rows of bits: the voxels that the surface, its
/// feature edges and its feature vertices lie in. It also has the places where rows of voxel
/// centres cross the surface. An edge is a triangle without height and a vertex is one without
/// length. One exact test decides them all, so each source contains the next.
class SurfaceBricks {
 public:
  /// Numbers of bits of bytes: baseline instruction sets count bits by a call.
  static constexpr std::array<std::uint8_t, 256> kBitsOf = [] {
    std::array<std::uint8_t, 256> bits{};
    for (std::size_t i = 0; i < bits.size(); ++i) {
      bits[i] = static_cast<std::uint8_t>(std::popcount(i));
    }
    return bits;
  }();
  /// Rows by eights along y; eights without a voxel are not kept.
  struct Source {
    const std::uint64_t* words = nullptr;  // null if there are no voxels
    /// Per z: bit j for any voxel in the rows 8 j to 8 j + 7.
    std::array<std::uint8_t, kHyperchunkSide> octets{};
    std::array<std::uint16_t, kHyperchunkSide> first{};  // per z: number of octets before it

    bool empty() const noexcept { return words == nullptr; }
    /// Tells whether the source is known to be all of the hyperchunk.
    bool full() const noexcept { return words == kFullWords.data(); }
    /// Returns the rows 8 j to 8 j + 7 of a z; null if there is no voxel in them.
    const std::uint64_t* Octet(std::size_t z, std::size_t j) const noexcept {
      if ((octets[z] >> j & 1U) == 0) return nullptr;
      return words + 8 * (first[z] + kBitsOf[octets[z] & ((1U << j) - 1)]);
    }
  };
  struct Brick {
    GridIndex place;
    std::array<Source, kFields> sources;  // per Field
    std::vector<std::uint64_t> words;     // words of all sources
    std::vector<Crossing> crossings;      // crossings of closed bodies, in no order
  };
  /// Packs sources of kBrickRows rows each, made one after another, into bricks.
  class Packer {
   public:
    /// Takes the rows and sets them to zero.
    void Take(Field field, std::uint64_t* rows);
    void TakeFull(Field field);
    /// Gives the brick what was taken since the last call.
    void Fill(Brick& brick);

   private:
    std::array<Source, kFields> sources_;
    std::array<std::size_t, kFields> begin_{};
    std::vector<std::uint64_t> words_;
  };

  /// Finds the bricks of some layers, with crossings of closed bodies only. `border`: extra
  /// hyperchunks all round the box, at least one.
  SurfaceBricks(const TriangleMesh& mesh_W, const Features& features, double voxel_size,
                const MeshFacing& facing, int border, const HyperchunkLayers& layers = {});
  /// Takes one brick for each cell of the box.
  SurfaceBricks(const HyperchunkBox& box, std::vector<Brick> bricks);

  /// Returns the bricks in Morton order of their places; some may have no voxels.
  const std::vector<Brick>& bricks() const noexcept { return bricks_; }
  const HyperchunkLayers& layers() const noexcept { return layers_; }
  /// Returns the box of all places, whatever the layers, with its border.
  const HyperchunkBox& box() const noexcept { return box_; }
  /// Returns the brick at a cell of the box; null if it has no voxels.
  const Brick* At(const GridIndex& place) const noexcept {
    if (!box_.Holds(place)) return nullptr;
    const std::uint32_t brick = brick_at_[box_.CellOf(place)];
    return brick == 0 ? nullptr : &bricks_[brick - 1];
  }

 private:
  static const std::array<std::uint64_t, kBrickRows> kFullWords;

  HyperchunkBox box_;
  HyperchunkLayers layers_;
  std::vector<std::uint32_t> brick_at_;  // per cell of the box: 1 + its number, 0 for none
  std::vector<Brick> bricks_;
};

}  // namespace tandem
