#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "engine/base/huge_vector.h"
#include "engine/voxel/mark_packing.h"
#include "engine/voxel/surface_bricks.h"
#include "engine/voxel/voxmap_image.h"

namespace tandem {

/// Makes the planes of marks of one hyperchunk at a time (paper §3.1, §4); one for each thread.
///
/// A cube of bits grows from the sources by one voxel in all directions per step, and what a step
/// adds is one farther. The sets are nested, so each binary digit of the marks is the exclusive or
/// of the sets at whose rim that digit changes: no voxel is ever looked at by itself, and rows of
/// zeros are passed over in eights. Digits become marks chunk by chunk, by transposition.
///
/// The cube holds kHalo voxels all round. Fields of a wider range grow in rounds of that many
/// voxels, each from what the one before has reached.
class MarkPlanes {
 public:
  /// `rounds`: the sources, then GrownSources() of those before, Rounds(range) in all; they must
  /// outlive this.
  MarkPlanes(std::span<const SurfaceBricks> rounds, int range, int bits);

  static std::size_t Rounds(int range) {
    return static_cast<std::size_t>((range + kHalo - 1) / kHalo);
  }

  /// Starts a hyperchunk.
  void Begin(const GridIndex& place);
  /// Appends the planes of a field, and notes them in the record, numbered from the first one since
  /// Begin(). In the surface field `inside` has kBrickRows rows, null for none; `solid` instead if
  /// all is inside but the surface.
  void Add(Field field, const std::uint64_t* inside, bool solid);

  /// What the hyperchunk's part of the last round's sources and of those round it grows to in kHalo
  /// voxels, as kBrickRows rows. False if there is nothing to grow.
  bool Grown(Field field, std::uint64_t* rows);

  const VoxmapRecord& record() const noexcept { return record_; }
  const HugeVector<std::uint8_t>& planes() const noexcept { return planes_; }
  /// Voxels within the range of a surface voxel, either side, these among them.
  std::uint64_t band_voxels() const noexcept { return band_voxels_; }

  static constexpr int kHalo = 16;
  static constexpr int kSide = kHyperchunkSide + 2 * kHalo;
  /// Rows of a layer: kSide of them, the first at kFirstRow, so that vectors may reach past them.
  static constexpr int kStride = kSide + 16;
  static constexpr int kFirstRow = 8;
  /// Two words a row: voxels -16..47 and 16..79 from the hyperchunk's lowest. What grows in from
  /// beyond a word's ends is missed, and after 16 steps has not reached voxels 0..31 and 32..63.
  struct alignas(64) Layer {
    std::array<std::array<std::uint64_t, kStride>, 2> words{};
  };
  struct Scratch {
    std::array<Layer, kSide> cube{};
    std::array<Layer, 3> ring{};                // layers grown along x and y
    std::array<std::uint16_t, kSide> octets{};  // by layer: which eights of rows have bits
    std::array<std::uint16_t, 3> ring_octets{};
    std::array<std::uint16_t, kSide> touched{};  // by layer: eights of rows with bits at the end
    MarkDigits digits;
    std::uint64_t marked = 0;  // voxels with a mark
  };

 private:
  bool Gather(const SurfaceBricks& bricks, Field field, int range);
  void ClearCube();

  std::span<const SurfaceBricks> rounds_;
  int range_;
  int bits_;
  GridIndex place_;
  VoxmapRecord record_;
  HugeVector<std::uint8_t> planes_;
  std::uint32_t plane_count_ = 0;
  std::uint64_t band_voxels_ = 0;
  std::unique_ptr<Scratch> scratch_;
};

/// The sources of all fields with all voxels within MarkPlanes::kHalo voxels of them, in the same
/// box. In parallel.
SurfaceBricks GrownSources(const SurfaceBricks& bricks);

}  // namespace tandem
