#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/base/bits.h"
#include "engine/voxel/surface_voxels.h"
#include "engine/voxel/voxmap.h"

namespace tandem {

/// The exact surface in one surface voxel of a map, packed: what the refined contact model reads
/// (decision 0010). Directions are octahedral: a unit vector's place on the unfolded octahedron.
struct SurfaceDetail {
  /// Both sides of a thin sheet: the normal may as well point the other way.
  static constexpr std::uint8_t kTwoSided = 255;

  std::array<std::uint8_t, 3> place{};   // from the voxel's lowest corner, 1/255 voxel
  std::uint8_t half_length = 0;          // of the edge's part, 1/128 voxel
  std::array<std::int16_t, 2> normal{};  // outward
  /// Of the edge, its direction; and in the four lowest bits of each a code for the shape, which
  /// turns the direction by less than a millirad.
  std::array<std::int16_t, 2> tangent{};

  /// What lies in the voxel.
  enum class Shape : std::uint8_t {
    kSmooth,  // a piece of surface, or the rim of an open one
    kVertex,  // a feature vertex
    kNotch,   // a concave edge, or two faces whose edge passes by
    kRidge    // a convex edge: its faces' normals are known
  };
  Shape shape() const noexcept {
    const unsigned code = Code();
    return code >= kFirstShape ? static_cast<Shape>(code - kFirstShape) : Shape::kRidge;
  }
  /// Half the angle between the normals of a ridge's faces, in steps of kAngleStep rad.
  std::size_t half_angle_steps() const noexcept { return Code(); }
  void SetShape(Shape other_than_ridge) noexcept {
    SetCode(kFirstShape + static_cast<unsigned>(other_than_ridge));
  }
  void SetRidge(double half_angle) noexcept {
    SetCode(static_cast<unsigned>(std::lround(half_angle / kAngleStep)));
  }
  static constexpr unsigned kAngles = 253;  // 0 to a right angle
  static constexpr double kAngleStep = 0.5 * 3.14159265358979323846 / (kAngles - 1);

 private:
  static constexpr unsigned kFirstShape = kAngles;
  unsigned Code() const noexcept {
    return static_cast<unsigned>((tangent[0] & 15) | (tangent[1] & 15) << 4);
  }
  void SetCode(unsigned code) noexcept {
    tangent[0] = static_cast<std::int16_t>((tangent[0] & ~15) | static_cast<int>(code & 15U));
    tangent[1] = static_cast<std::int16_t>((tangent[1] & ~15) | static_cast<int>(code >> 4U));
  }
};
static_assert(sizeof(SurfaceDetail) == 12);

std::array<std::int16_t, 2> PackDirection(const Vec3& unit);
Vec3 UnpackDirection(const std::array<std::int16_t, 2>& packed) noexcept;

/// The outward normal on the side that faces along `towards`.
inline Vec3 FacingNormal(const SurfaceDetail& detail, const Vec3& towards) noexcept {
  const Vec3 n = UnpackDirection(detail.normal);
  return detail.half_length == SurfaceDetail::kTwoSided && n.dot(towards) < 0 ? Vec3(-n) : n;
}

/// The details of a map's surface voxels, found by chunk. Read-only once built.
class SurfaceDetails {
 public:
  /// The surface voxels of one chunk, in the order of CellInBlock, and their details.
  struct Chunk {
    SurfaceVoxels::Bits bits{};
    SurfaceVoxels::Bits edges{};            // of these, the ones that edges of other bodies lean on
    SurfaceVoxels::Bits vertices{};         // and the ones with a feature vertex
    SurfaceVoxels::Bits forked{};           // and the ones that more edges run in
    std::uint32_t first_forked = 0;         // of these, how many stand in the chunks before
    std::array<std::uint16_t, 8> before{};  // set bits in the words before
    std::uint32_t first = 0;

    /// The voxels that are sources of a field.
    const SurfaceVoxels::Bits& Sources(Field field) const noexcept {
      return field == Field::kVertex ? vertices : field == Field::kEdge ? edges : bits;
    }
  };
  static bool Has(const SurfaceVoxels::Bits& bits, std::size_t cell) noexcept {
    return (bits[cell >> 6] >> (cell & 63) & 1U) != 0;
  }

  /// An edge's part in a voxel that has a vertex or another edge already.
  struct MoreEdge {
    SurfaceDetail detail;
    bool ends = false;  // as VoxelSurface::ends
  };

  SurfaceDetails() = default;
  /// Of a mesh where it stood when `voxmap` was made of it, with the same flatness.
  SurfaceDetails(const TriangleMesh& mesh_W, double flatness_voxels, const Voxmap& voxmap);
  /// With the features that the map was made with.
  SurfaceDetails(const TriangleMesh& mesh_W, const Features& features, const Voxmap& voxmap);

  bool empty() const noexcept { return details_.empty(); }
  /// Of a chunk counted from the map's origin; null without surface voxels.
  const Chunk* At(const Voxmap& voxmap, const GridIndex& chunk_V) const noexcept {
    const std::uint32_t plane = voxmap.PlaneOf(Field::kSurface, chunk_V);
    const std::uint32_t chunk = chunk_of_plane_[plane];
    return chunk == 0 ? nullptr : &chunks_[chunk - 1];
  }
  /// Of a cell whose bit is set.
  const SurfaceDetail& Of(const Chunk& chunk, std::size_t cell) const noexcept {
    const std::uint64_t below = chunk.bits[cell >> 6] & ((std::uint64_t{1} << (cell & 63)) - 1);
    return details_[chunk.first + chunk.before[cell >> 6] + CountBits(below)];
  }
  /// The edges in a cell whose bit is set in `forked`, beside its own detail: all of a vertex
  /// voxel's.
  std::span<const MoreEdge> MoreEdges(const Chunk& chunk, std::size_t cell) const noexcept {
    std::size_t at = chunk.first_forked;
    for (std::size_t word = 0; word < cell >> 6; ++word) at += CountBits(chunk.forked[word]);
    at += CountBits(chunk.forked[cell >> 6] & ((std::uint64_t{1} << (cell & 63)) - 1));
    return std::span(more_edges_)
        .subspan(first_more_edge_[at], first_more_edge_[at + 1] - first_more_edge_[at]);
  }
  std::size_t bytes() const noexcept;

 private:
  std::vector<std::uint32_t> chunk_of_plane_;  // by plane of the map: 1 + its chunk, 0 for none
  std::vector<Chunk> chunks_;
  std::vector<SurfaceDetail> details_;
  std::vector<MoreEdge> more_edges_;
  std::vector<std::uint32_t> first_more_edge_;  // by forked voxel, and the end
};

}  // namespace tandem
