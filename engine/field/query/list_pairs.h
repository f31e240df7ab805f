#pragma once

#include <array>
#include <cstddef>
#include <cstring>

#include "engine/base/spatial.h"

namespace tandem {

/// Pairs of a place and a face, whose distances are measured together.
struct ListPairs {
  static constexpr std::size_t kMost = 512;
  /// Faces whose distances differ by at most this are equally near, voxels.
  static constexpr double kTie = 1e-4;
  std::size_t count = 0;
  /// A face's corners, four words each: x, y, z and an unused word; for the last corner an unused
  /// word, x, y, z.
  alignas(64) std::array<std::array<float, 4 * kMost>, 3> corners;
  /// A place as whole voxels and the rest, so that large terms cancel before anything is rounded.
  alignas(64) std::array<std::array<float, kMost>, 3> whole;
  alignas(64) std::array<std::array<float, kMost>, 3> rest;
  std::array<bool, kMost> sheet;  // the face is a sheet

  // results
  alignas(64) std::array<float, kMost> squared;                 // squared distance
  alignas(64) std::array<float, kMost> height;                  // height over the face's plane
  alignas(64) std::array<std::array<float, kMost>, 3> to_face;  // vector from the place

  bool HasRoomFor(std::size_t more) const noexcept { return count + more <= kMost; }
  void Add(const std::array<Vec3f, 3>& face, bool of_sheet, const std::array<float, 3>& whole_L,
           const std::array<float, 3>& rest_L) noexcept {
    const auto* words = reinterpret_cast<const float*>(face.data());
    std::memcpy(&corners[0][4 * count], words, 4 * sizeof(float));
    std::memcpy(&corners[1][4 * count], words + 3, 4 * sizeof(float));
    std::memcpy(&corners[2][4 * count], words + 5, 4 * sizeof(float));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      whole[axis][count] = whole_L[axis];
      rest[axis][count] = rest_L[axis];
    }
    sheet[count++] = of_sheet;
  }
};

/// Measures `squared` and `height`. The bits are the same on every processor.
void MeasureDistances(ListPairs& pairs) noexcept;
/// Measures `to_face`, too.
void MeasureWays(ListPairs& pairs) noexcept;

}  // namespace tandem
