#pragma once

#include <array>
#include <cstddef>

#include "engine/base/spatial.h"
#include "engine/voxel/surface_details.h"
#include "engine/voxel/voxmap.h"

namespace tandem {

/// The pieces of a map's exact surface about a group of points, found and unpacked once for all of
/// them, by component, as vectors read them.
///
/// Lengths in voxels, from the group's middle, single precision. Used by one thread; no call
/// allocates.
class NearPieces {
 public:
  /// Voxels: how far apart a group's points may stand along each axis.
  static constexpr int kSpread = 8;
  static constexpr std::size_t kMostSources = 256;
  static constexpr std::size_t kLanes = 16;
  static constexpr float kFarAway = 1e6F;  // where gaps' voxels are
  static constexpr std::size_t RoundedUp(std::size_t count) noexcept {
    return (count + kLanes - 1) / kLanes * kLanes;
  }
  static constexpr std::size_t kMost = 2 * kMostSources + 6 * kLanes;

  NearPieces(const Voxmap& voxmap, const SurfaceDetails& details) noexcept
      : voxmap_(&voxmap), details_(&details) {}

  /// Turns to the sources of `field` within one voxel of those from `low` to `high`, which are at
  /// most kSpread apart. False if there are more than can be kept.
  bool Gather(const GridIndex& low, const GridIndex& high, Field field) noexcept;

  using Column = std::array<float, kMost>;
  using Columns = std::array<Column, 3>;
  /// A ridge of the surface stands for its two faces, a sheet for its two sides.
  struct Pieces {
    alignas(64) Columns voxel;  // lowest corners; gaps are filled with what is far away
    alignas(64) Columns place;
    alignas(64) Columns normal;   // outward
    alignas(64) Columns tangent;  // of edges, as the rest
    alignas(64) Column half;      // with what it reaches into the next
    alignas(64) Column arc_half;
    alignas(64) Column arc_cosine;
    alignas(64) Column arc_last;
  };
  const Pieces& pieces() const noexcept { return pieces_; }
  /// Of the surface: [0, ridges()) plain pieces, [ridges(), corners()) ridges' faces, and
  /// [corners(), count()) vertices and notches. Of other fields all are plain.
  std::size_t ridges() const noexcept { return ridges_; }
  std::size_t corners() const noexcept { return corners_; }
  std::size_t count() const noexcept { return count_; }

  const GridIndex& middle() const noexcept { return middle_; }

  /// As the map packs them.
  struct Packed {
    std::size_t count = 0;
    std::array<SurfaceDetail, kMostSources + kLanes> details;
    std::array<GridIndex, kMostSources + kLanes> voxels;  // from the middle
  };

 private:
  bool List(const GridIndex& low, const GridIndex& high, Field field) noexcept;
  /// Unpacks behind count_, up to a whole vector.
  void Unpack(const Packed& packed) noexcept;
  void FillGap() noexcept;
  void AddOtherSides(const Packed& packed, std::size_t first, Field field) noexcept;
  void AddOtherFaces(const Packed& packed, std::size_t first) noexcept;
  void SetArcs(const Packed& packed, std::size_t first) noexcept;

  const Voxmap* voxmap_;
  const SurfaceDetails* details_;
  GridIndex middle_;
  std::size_t ridges_ = 0;
  std::size_t corners_ = 0;
  std::size_t count_ = 0;
  Packed plain_{};
  Packed of_ridges_{};
  Packed of_corners_{};
  Pieces pieces_{};
};

}  // namespace tandem
