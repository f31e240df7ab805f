#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/base/spatial.h"
#include "engine/voxel/surface_details.h"
#include "engine/voxel/voxmap.h"

namespace tandem {

/// The pieces of a map's exact surface about its cells of 4 x 4 x 4 voxels, found and unpacked when
/// first asked for, by component, as vectors read them. They are kept while there is room, the
/// latest found; what is found again is the same.
///
/// Lengths in voxels, from the cell's middle, single precision. Used by one thread; no call
/// allocates.
class NearPieces {
 public:
  static constexpr int kCellSide = 4;  // voxels
  static constexpr std::size_t kMostSources = 128;
  static constexpr std::size_t kLanes = 16;
  static constexpr float kFarAway = 1e6F;  // where gaps' voxels are

  using Row = std::array<float, kLanes>;
  using Rows = std::array<Row, 3>;
  /// A ridge of the surface stands for its two faces, a sheet for its two sides.
  struct alignas(64) Block {
    Rows voxel{};  // lowest corners; gaps are filled with what is far away
    Rows place{};
    Rows normal{};      // outward
    Rows tangent{};     // of edges, as the rest
    Row half{};         // with what it reaches into the next
    Row arc_tangent{};  // of half of the arc's half
    Row arc_cosine{};
    Row arc_last{};
  };

  /// Of a field, the sources within one voxel of those in a cell.
  class Cell {
   public:
    std::span<const Block> all() const noexcept { return {blocks_, count_}; }
    /// Of the surface: plain pieces, ridges' faces, and vertices and notches. Of other fields all
    /// are plain.
    std::span<const Block> plain() const noexcept { return {blocks_, ridges_}; }
    std::span<const Block> ridges() const noexcept {
      return all().subspan(ridges_).first(corners_ - ridges_);
    }
    std::span<const Block> corners() const noexcept { return all().subspan(corners_); }
    /// Nothing is known: there are more than can be kept.
    bool too_many() const noexcept { return too_many_; }

   private:
    friend class NearPieces;
    bool too_many_ = false;
    std::uint16_t ridges_ = 0;
    std::uint16_t corners_ = 0;
    std::uint16_t count_ = 0;
    std::uint64_t at_ = 0;           // in all that was ever kept
    const Block* blocks_ = nullptr;  // null: no cell
  };

  /// From here a cell's lengths are counted.
  static GridIndex MiddleOf(const GridIndex& voxel) noexcept {
    constexpr int kHalf = kCellSide / 2;
    const auto along = [](std::int32_t at) {
      return (at & ~(kCellSide - 1)) + kHalf;
    };
    return {along(voxel.x), along(voxel.y), along(voxel.z)};
  }

  /// With room for the pieces about some `cells`.
  NearPieces(const Voxmap& voxmap, const SurfaceDetails& details, std::size_t cells);

  /// About the cell of a voxel; valid until the next call.
  const Cell& About(const GridIndex& voxel, Field field) noexcept;

  /// As the map packs them.
  struct Packed {
    std::size_t count = 0;
    std::array<SurfaceDetail, kMostSources + kLanes> details;
    std::array<GridIndex, kMostSources + kLanes> voxels;  // from the middle
  };

 private:
  static constexpr std::size_t kWays = 8;
  static constexpr std::size_t kMostBlocks = 2 * kMostSources / kLanes + 6;
  static constexpr std::size_t kBlocksOfCell = 4;  // some, in the mean

  bool Keeps(const Cell& cell) const noexcept {
    return cell.blocks_ != nullptr && cell.at_ + blocks_.size() >= head_ + kMostBlocks;
  }
  void Find(const GridIndex& middle, Field field, Cell& cell) noexcept;
  bool List(const GridIndex& middle, Field field) noexcept;
  /// Unpacks behind what is there, up to a whole block.
  void Unpack(const Packed& packed) noexcept;
  void FillBlock() noexcept;
  void AddOtherSides(const Packed& packed, std::size_t first) noexcept;
  void AddOtherFaces(const Packed& packed, std::size_t first) noexcept;
  void SetArcs(const Packed& packed) noexcept;

  const Voxmap* voxmap_;
  const SurfaceDetails* details_;
  /// Where a cell may be.
  struct alignas(64) Place {
    std::array<std::uint64_t, kWays> keys{};
    std::array<Cell, kWays> cells{};
  };
  std::vector<Place> places_;
  std::vector<Block> blocks_;  // of cells one after another, the oldest overwritten
  std::uint64_t head_ = 0;     // blocks that were ever kept
  Block* out_ = nullptr;       // of the cell that is being found
  std::size_t count_ = 0;      // and its pieces so far
  Packed plain_{};
  Packed of_ridges_{};
  Packed of_corners_{};
};

}  // namespace tandem
