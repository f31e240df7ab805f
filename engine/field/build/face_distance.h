#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "engine/base/spatial.h"

namespace tandem {

/// A flat piece of the surface that bounds a union of bodies. Lengths are in voxels. Places are in
/// the field's lattice L, whose whole numbers are centres of voxels.
struct FieldFace {
  std::array<Vec3, 3> corners_L;  // counter-clockwise seen from outside
  Vec3 nhat = Vec3::Zero();       // unit normal, out of the solid
  bool sheet = false;             // free space on both sides
  double width = 0;               // least height of the triangle
  /// Per edge k, from corner k to the next: the face that continues this one over the edge at an
  /// angle below that of kGentle. kNone: no face, a sharp edge, or an edge of a sheet.
  std::array<std::uint32_t, 3> beside{kNone, kNone, kNone};

  static constexpr std::uint32_t kNone = ~0U;
  static constexpr double kGentle = 0.866;  // cosine between normals
};

/// Places near one another, in voxels relative to an origin, as lanes. `count` is a multiple of 16.
struct PlaceLanes {
  static constexpr std::size_t kMost = 256;
  alignas(64) std::array<float, kMost> x, y, z;
  std::size_t count = 0;
};

/// Returns the nodes of a lattice with `side` nodes a side, `spacing` voxels apart, x fastest;
/// filled up with its last node.
PlaceLanes LatticeLanes(std::size_t side, double first, double spacing);

struct NearestLanes;

/// The errors of values that are interpolated in a cell, against the distances of places there,
/// voxels.
struct CellErrors {
  float within_band = 0;
  float beyond = 0;  // the same where a reading is near, but beyond the band
  float over = 0;    // greatest excess of a near reading over the distance from the surface

  void Add(const CellErrors& other) {
    within_band = std::max(within_band, other.within_band);
    beyond = std::max(beyond, other.beyond);
    over = std::max(over, other.over);
  }
};
/// Compares the places of a cell that has its lowest node at `lowest` and `values` at its corners,
/// x fastest.
CellErrors ErrorsInCell(const std::array<float, 8>& values, const std::array<float, 3>& lowest,
                        const PlaceLanes& places, const NearestLanes& exact, float band,
                        float most_near);

/// A cube of 4 x 4 x 4 places a voxel apart, x fastest.
inline constexpr std::size_t kCubeSide = 4;
inline constexpr std::size_t kCubePlaces = kCubeSide * kCubeSide * kCubeSide;

/// Returns one bit for each of `count` lanes, at most 64 and a multiple of 16, whose value is at
/// most its bound plus `margin`.
std::uint64_t LanesWithin(const float* values, const float* bounds, float margin,
                          std::size_t count = 64);

/// A face as seen from places near an origin, in single precision. Large terms are subtracted in
/// double precision first, so a distance below 16 voxels is right to 2e-5 voxels.
class NearFace {
 public:
  /// All places must be within 32 voxels of `origin_L`.
  NearFace(const FieldFace& face, const Vec3& origin_L);

  static constexpr unsigned kAllEdges = 7;
  /// Measures the distance of each place from the face, voxels, and its height over the face's
  /// plane. Over a sheet the height is absolute; null: not wanted. `edges` has a bit for each edge
  /// that some of the places lie beyond. The bits are the same on every processor.
  void Measure(const PlaceLanes& places, unsigned edges, float* distances, float* heights) const;
  /// Adds the face to those in `nearest`. `distances`: as of Measure(); null: not wanted.
  void MeasureInto(const PlaceLanes& places, unsigned edges, NearestLanes& nearest,
                   float* distances = nullptr) const;
  /// Does the same for the places of a cube, whose lowest place is at `lowest`.
  void MeasureCube(const std::array<float, 3>& lowest, float* distances) const;
  void MeasureCubeInto(const std::array<float, 3>& lowest, float* distances, float* heights) const;

  /// The cubes, with sides of a voxel, round the places of a cube, one bit for each.
  struct CubeSides {
    std::array<std::uint64_t, 3> before{};  // per edge: some of the cube lies beyond
    std::array<std::uint64_t, 3> beyond{};  // per edge: all of the cube lies beyond
  };
  CubeSides SidesOf(const std::array<float, 3>& lowest) const;
  /// The greatest error of an edge's place, voxels.
  static constexpr float kRounding = 1e-3F;

  /// The data that the kernel reads.
  struct View {
    struct Edge {
      std::array<float, 3> inward;  // unit vector in the face's plane
      float inward_offset;
      std::array<float, 2> along;  // unit vector, in the plane's coordinates
      float from, to;              // the edge's ends along it
    };
    std::array<float, 3> nhat;
    float offset;
    /// Axes of coordinates in the face's plane, right-handed.
    std::array<std::array<float, 3>, 2> axes;
    std::array<Edge, 3> edges;
    bool sheet;
  };
  const View& view() const noexcept { return view_; }

 private:
  View view_;
};

/// The signed distance of places from faces, negative in the solid. Its size is the distance of the
/// nearest face. Its sign comes from that of the equally near faces which turns most to the place:
/// at an edge or a corner no other face gives the right side.
struct NearestLanes {
  /// Faces whose distances differ by at most this are equally near, voxels.
  static constexpr float kTie = 1e-4F;
  alignas(64) std::array<float, PlaceLanes::kMost> distance;
  alignas(64) std::array<float, PlaceLanes::kMost> height;

  /// Begins with no face for `count` places.
  explicit NearestLanes(std::size_t count = PlaceLanes::kMost);
  float Signed(std::size_t lane) const noexcept {
    return height[lane] < 0 ? -distance[lane] : distance[lane];
  }
};

}  // namespace tandem
