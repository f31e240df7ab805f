#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/field/build/near_faces.h"

namespace tandem {

/// The greatest error of an interpolated cell within the band, voxels. Cells that err more keep a
/// list of faces.
inline constexpr double kMostCellError = 0.02;
/// Bound of a cell's error between the places where it is measured, as a factor of the measured
/// error. The places are 27, and some over the middle of each slim face that can be the nearest
/// there.
inline constexpr double kBetweenPlaces = 1.25;
/// The same for 125 places.
inline constexpr double kBetweenFinePlaces = 1.06;
/// Bounds within which all unit normals and heights (voxels) of the faces that count are so close
/// that interpolation need not be measured. Slopes that differ by a cause an error of at most 0.43
/// a, so the error is below kLeastBound.
inline constexpr double kSameNormal = 0.008;
inline constexpr double kSameHeight = 0.001;
inline constexpr double kLeastBound = 0.01;

/// The faces near one brick, and what follows from them for its cells while a field is built.
class BrickFaces {
 public:
  /// `place`: of the brick in the hyperbrick, as CellInBlock.
  BrickFaces(const NearFaces& faces, std::size_t place, const CellCandidates& candidates);

  struct Errors {
    std::uint64_t erring = 0;          // cells with more than kMostCellError within the band
    double within_band = kLeastBound;  // greatest error of all other cells in the band, voxels
    double beyond = kLeastBound;       // the same where a reading is near, but beyond the band
    /// Per cell: the greatest excess of a near reading over the distance from the surface.
    std::array<float, kCellsPerBrick> over{};
    CellCandidates left;  // candidates without those that are nowhere the nearest
  };
  /// Measures the error of interpolated node values against the faces' distance, in the cells that
  /// have a bit in `cells`. `open`: the faces may end in free space.
  Errors Measure(std::span<const float, kBrickNodes> values, std::uint64_t cells, double band,
                 double most_near, bool open) const;

  /// Returns every face that is the nearest to some place of a cell within the band: numbers among
  /// all faces, rising.
  std::vector<std::uint32_t> ListOf(std::size_t cell, double band) const;

 private:
  CellErrors ErrorsOf(const std::array<float, 8>& values, std::size_t cell,
                      std::span<const CellFace> faces, const PlaceLanes& places, double band,
                      double most_near) const;
  /// Returns the nearest of a cell's candidates to places, the middles of its parts. Puts the
  /// candidates that may be the nearest somewhere in the cell at the end of `left`.
  NearestLanes NearestTo(const PlaceLanes& places, std::span<const CellFace> candidates,
                         std::vector<CellFace>& left) const;
  std::array<float, 3> LowestOf(std::size_t cell) const;
  bool NearlyOnePlane(std::size_t cell) const;
  PlaceLanes PlacesIn(std::size_t cell, const PlaceLanes& pattern) const;
  /// Returns some places over each slim face that ends at a sharp edge. A face that is slimmer than
  /// a pattern of places, such as the rim of a sheet, is the nearest only between them.
  PlaceLanes PlacesOverSlim(std::size_t cell, std::span<const CellFace> faces) const;

  const NearFaces& faces_;
  std::array<float, 3> lowest_{};  // lowest node, relative to the hyperbrick's middle
  const CellCandidates& candidates_;
};

}  // namespace tandem
