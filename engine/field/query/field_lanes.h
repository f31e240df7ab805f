#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "engine/voxel/map/voxel.h"

namespace tandem {

/// A field as its kernels read it.
struct FieldView {
  static constexpr float kBoundStep = 0.125F;
  const std::int32_t* hyperbricks = nullptr;
  const std::uint32_t* first_bricks = nullptr;
  const std::int16_t* tables = nullptr;
  const std::int32_t* bricks = nullptr;  // FieldBrick as four words
  const std::uint8_t* steps = nullptr;
  GridIndex cells;
  std::int32_t hyperbricks_x = 0, hyperbricks_y = 0;
  std::array<float, 3> box_min{}, box_max{};  // box of all faces, in L
  float most_near = 0;
  float most_near_inside = 0;
  float beyond_near = 0;  // a bound for what is farther than most_near_inside
  float band = 0;
  float error = 0;  // greatest error within the band
  float fine_band = 0;
  float most_over = 0;
};

/// Places that are looked up in a field together. A look-up is a chain of dependent reads. Here all
/// places take one step before any place takes the next. Vectors compute where to read. Plain loops
/// read: they are no slower than vectors that gather, and on many processors faster.
///
///   Find() | ReadBricks() | Unpack() | ReadWords() | Interpolate()     vectors: field_lanes-inl.h
struct FieldLanes {
  static constexpr std::size_t kMost = 256;
  static constexpr std::size_t kVector = 16;  // greatest number of lanes of a vector
  template <class T>
  using Lanes = std::array<T, kMost>;

  // after Find()
  alignas(64) Lanes<float> x, y, z;                        // relative to the cell's lowest node
  alignas(64) Lanes<std::int32_t> cell_x, cell_y, cell_z;  // cell in the lattice
  alignas(64) Lanes<std::int32_t> hyperbrick;              // below 0: outside of all
  alignas(64) Lanes<std::int32_t> in_table;
  GridIndex CellOf(std::size_t lane) const noexcept {
    return {cell_x[lane], cell_y[lane], cell_z[lane]};
  }
  std::array<float, 3> FromCell(std::size_t lane) const noexcept {
    return {x[lane], y[lane], z[lane]};
  }
  // after ReadBricks()
  alignas(64) Lanes<std::int32_t> entry;  // number of the brick; below 0: a bound as in a table
  alignas(64) std::array<std::int32_t, 4 * kMost> bricks;
  std::array<bool, kMost / kVector> near;  // some lane of the vector has a brick
  // after Unpack()
  alignas(64) Lanes<std::int32_t> bits, flags, over_of_lists;
  alignas(64) Lanes<std::int32_t> first_bit;  // first bit of the steps of the cell's lowest node
  alignas(64) Lanes<std::int32_t> cell_bit;   // bit of the cell in a word of FieldLists::cells
  alignas(64) Lanes<float> plane;             // plane's value at the place
  /// Bytes of the pool where the steps of two nodes in a row begin: of the cell's lower row, the
  /// row above it along y, along z, and along both. The last is the word of FieldLists::cells.
  static constexpr std::size_t kWords = 5;
  alignas(64) std::array<Lanes<std::int32_t>, kWords> byte;
  // after ReadWords()
  alignas(64) std::array<Lanes<std::int32_t>, kWords> word;
  // after Interpolate(); the value after Find() where `hyperbrick` is below 0
  alignas(64) Lanes<float> value, over;
  alignas(64) Lanes<std::int32_t> kind;
};

/// Gradients of lanes, by axis.
using FieldGradients = std::array<FieldLanes::Lanes<float>, 3>;

/// Finds the bricks of `count` lanes, a multiple of FieldLanes::kVector.
void ReadBricks(const FieldView& field, std::size_t count, FieldLanes& lanes) noexcept;
/// Reads the first `words` words of all vectors that are near.
void ReadWords(const FieldView& field, std::size_t count, std::size_t words,
               FieldLanes& lanes) noexcept;

}  // namespace tandem
