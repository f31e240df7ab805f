#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/field/near_faces.h"

namespace tandem {

/// The greatest error that an interpolated cell may have within the band, voxels. Cells that err
/// more are told by faces.
inline constexpr double kMostCellError = 0.02;
/// A cell's error is measured at 27 places, and at some over the middle of each slim face that can
/// be the nearest there; between them it is greater by less than this factor.
inline constexpr double kBetweenPlaces = 1.25;
/// The same for 125 places.
inline constexpr double kBetweenFinePlaces = 1.06;
/// Where all faces that count have unit normals and heights (voxels) as near one another as this,
/// interpolation is not measured. Slopes that differ by a make it err by 0.43 a at the most, so the
/// error is below kLeastBound.
inline constexpr double kSameNormal = 0.008;
inline constexpr double kSameHeight = 0.001;
inline constexpr double kLeastBound = 0.01;

/// The faces near one brick, and what they say of its cells while a field is built.
class BrickFaces {
 public:
  /// `place` is the brick's in the hyperbrick, as CellInBlock.
  BrickFaces(const NearFaces& faces, std::size_t place, const CellCandidates& candidates);

  struct Errors {
    std::uint64_t erring = 0;          // the cells with more than kMostCellError within the band
    double within_band = kLeastBound;  // of all others in the band, voxels
    double beyond = kLeastBound;       // where a reading is near, but beyond the band
    /// Of each cell, how much farther than the surface a reading says it is, where it is near.
    std::array<float, kCellsPerBrick> over{};
    CellCandidates left;  // without those that were seen to be nowhere the nearest
  };
  /// How far the values of nodes, interpolated, are from the faces' distance in the cells that have
  /// a bit in `cells`. `open`: the faces may end in free space.
  Errors Measure(std::span<const float, kBrickNodes> values, std::uint64_t cells, double band,
                 double most_near, bool open) const;

  /// Every face that is the nearest to some place of a cell within the band: numbers among all
  /// faces, rising.
  std::vector<std::uint32_t> ListOf(std::size_t cell, double band) const;

 private:
  CellErrors ErrorsOf(const std::array<float, 8>& values, std::size_t cell,
                      std::span<const CellFace> faces, const PlaceLanes& places, double band,
                      double most_near) const;
  /// What a cell's candidates leave of places, the middles of its parts; and those of them that may
  /// be the nearest somewhere in the cell, at the end of `left`.
  NearestLanes NearestTo(const PlaceLanes& places, std::span<const CellFace> candidates,
                         std::vector<CellFace>& left) const;
  std::array<float, 3> LowestOf(std::size_t cell) const;
  bool NearlyOnePlane(std::size_t cell) const;
  PlaceLanes PlacesIn(std::size_t cell, const PlaceLanes& pattern) const;
  /// For each slim face that ends at a sharp edge some places that lie over it: a face that is
  /// slimmer than a pattern of places, such as the rim of a sheet, is the nearest between them
  /// alone.
  PlaceLanes PlacesOverSlim(std::size_t cell, std::span<const CellFace> faces) const;

  const NearFaces& faces_;
  std::array<float, 3> lowest_{};  // node, from the hyperbrick's middle
  const CellCandidates& candidates_;
};

}  // namespace tandem
