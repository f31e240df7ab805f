#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/base/spatial.h"

namespace tandem {

/// A brick of 4 x 4 x 4 cells of the field has 5 x 5 x 5 nodes. It shares the nodes of its upper
/// faces with its neighbours, so that a look-up of a place reads one brick alone.
inline constexpr int kBrickCells = 4;
inline constexpr std::size_t kBrickSide = 5;
inline constexpr std::size_t kCellsPerBrick = kBrickCells * kBrickCells * kBrickCells;
inline constexpr std::size_t kBrickNodes = kBrickSide * kBrickSide * kBrickSide;
inline constexpr std::size_t NodeInBrick(std::size_t x, std::size_t y, std::size_t z) {
  return x + kBrickSide * (y + kBrickSide * z);
}

/// Cells and bricks along a hyperbrick's side.
inline constexpr std::int32_t kHyperbrickCells = 32;
inline constexpr std::int32_t kHyperbrickBricks = kHyperbrickCells / kBrickCells;
inline constexpr std::size_t kBricksPerHyperbrick = 512;

/// A brick's values at its nodes: a plane, and steps about it of as many bits as they need, none in
/// a flat brick. The steps of all nodes follow one another, x fastest, from the lowest bit on.
struct FieldBrick {
  static constexpr float kStep = 1.0F / 1024;  // voxels
  static constexpr float kSlope = 1.0F / 16384;
  /// A step and its neighbour along x are read as one word of 32 bits, from a whole byte on.
  static constexpr std::uint8_t kMostBits = 12;
  /// Flag of a brick with lists: FieldLists.
  static constexpr std::uint8_t kHasLists = 1;
  /// Flag of a brick whose steps are twice as large: some node is over two voxels off its plane.
  static constexpr std::uint8_t kLargeSteps = 2;

  /// The upper bits of the flags hold the greatest excess of a near reading in the brick over the
  /// distance from the surface, in steps of kOverStep voxels.
  static constexpr int kOverShift = 2;
  static constexpr float kOverStep = 1.0F / 32;
  float Over() const noexcept { return kOverStep * static_cast<float>(flags >> kOverShift); }
  void SetOver(float over) noexcept {
    const float count = std::min(63.0F, std::ceil(over / kOverStep));
    flags = static_cast<std::uint8_t>((flags & ((1U << kOverShift) - 1)) |
                                      static_cast<unsigned>(count) << kOverShift);
  }

  /// The same for the cells with lists: `over_of_lists` squared, times kListsOverUnit voxels. Most
  /// values are near zero, and small steps spare look-ups of lists.
  static constexpr float kListsOverUnit = 2.0F / 225;
  float OverOfLists() const noexcept {
    return kListsOverUnit * static_cast<float>(over_of_lists * over_of_lists);
  }
  void SetOverOfLists(float over) noexcept {
    const float count = std::min(15.0F, std::ceil(std::sqrt(over / kListsOverUnit)));
    over_of_lists = static_cast<unsigned>(count) & 15U;
    if (over_of_lists < 15 && OverOfLists() < over) ++over_of_lists;  // the root is rounded down
  }

  /// Returns the greatest excess of all cells, with lists or without.
  float MostOver() const noexcept { return std::max(Over(), OverOfLists()); }

  float mean = 0;                        // plane's value at the brick's lowest node, voxels
  std::array<std::int16_t, 3> slopes{};  // slopes of the plane along x, y, z, in units of kSlope
  std::uint8_t bits : 4 = 0;             // bits of a step
  std::uint8_t over_of_lists : 4 = 0;    // OverOfLists()
  std::uint8_t flags = 0;
  std::uint32_t steps = 0;  // place of the first step, bytes from the pool's start

  float Step() const noexcept { return (flags & kLargeSteps) != 0 ? 2 * kStep : kStep; }
  float Plane(float x, float y, float z) const noexcept {
    return mean + kSlope * (static_cast<float>(slopes[0]) * x + static_cast<float>(slopes[1]) * y +
                            static_cast<float>(slopes[2]) * z);
  }
};
static_assert(sizeof(FieldBrick) == 16);

/// The cells of a brick that have lists of faces. It stands before the brick's steps. Before it
/// stand the lists, the lowest cell's last. A list has the shares of the cell's corners, the cell's
/// error, and one bit for each of the brick's faces that tells whether the list has it.
struct FieldLists {
  std::uint64_t cells = 0;       // bit x + 4 y + 16 z
  std::uint32_t first_face = 0;  // index in the field's list_faces
  std::uint16_t faces = 0;       // number of the brick's faces
  std::uint16_t unused = 0;

  /// Returns the size of one list, bytes.
  std::size_t ListBytes() const noexcept { return 2 + (std::size_t{faces} + 7) / 8; }
};
static_assert(sizeof(FieldLists) == 16);

/// A brick with its own steps, none where it is flat.
struct PackedBrick {
  FieldBrick brick;
  std::vector<std::uint8_t> steps;
};

/// Packs a brick: the plane of least squares through the values (voxels, by NodeInBrick) and the
/// steps about it. A node that is within four voxels of the plane keeps its value to within half a
/// step.
PackedBrick PackBrick(std::span<const float, kBrickNodes> values);

/// Returns a flat brick: a plane with unit normal `nhat`, `at_lowest` (voxels) below the brick's
/// lowest node.
FieldBrick FlatBrick(const Vec3& nhat, double at_lowest);

/// Returns the value at a node, voxels. `steps` are the brick's own, and three bytes more.
float NodeValue(const FieldBrick& brick, const std::uint8_t* steps, std::size_t x, std::size_t y,
                std::size_t z);

}  // namespace tandem
