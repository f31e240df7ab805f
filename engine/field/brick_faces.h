#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/field/face_distance.h"
#include "engine/field/field_brick.h"
#include "engine/voxel/voxel.h"

namespace tandem {

inline constexpr std::size_t kCellsPerBrick = 64;

/// The greatest error that an interpolated cell may have within the band, voxels. Cells that err
/// more are told by faces.
inline constexpr double kMostCellError = 0.02;
/// A cell's error is measured at 27 places, and at some over the middle of each face that can be
/// the nearest there; between them it is greater by less than this factor.
inline constexpr double kBetweenPlaces = 1.25;
/// The same for 125 places.
inline constexpr double kBetweenFinePlaces = 1.06;
/// Where all faces that count have unit normals and heights (voxels) as near one another as this,
/// interpolation is not measured. Slopes that differ by a make it err by 0.43 a at the most, so the
/// error is below kLeastBound.
inline constexpr double kSameNormal = 0.008;
inline constexpr float kSameHeight = 0.001F;
inline constexpr double kLeastBound = 0.01;

/// The faces near one brick, and what they say of its nodes and cells while a field is built.
class BrickFaces {
 public:
  /// Every face that is nearer than this to a node is among the faces, voxels.
  static constexpr float kReach = 2.25F;

  /// `first` is the brick's lowest node. `all` are the field's faces, `near` some of their numbers.
  BrickFaces(const GridIndex& first, const std::vector<FieldFace>& all,
             std::span<const std::uint32_t> near);

  /// Measures the faces from the nodes and tells how near they come to one, voxels. Before
  /// Values().
  float LookAtNodes();
  /// Measures the faces from the cells: before all that follows.
  void LookAtCells();
  /// Whether any place of a cell is nearer to the faces than `distance`, or may be.
  bool ComesWithin(std::size_t cell, double distance) const noexcept;
  /// The distances of the nodes. `solid` has a bit for each. Nodes farther than kReach from all
  /// faces have a value of at least that, along the plane of the brick's nearest face if it can be.
  std::array<float, kBrickNodes> Values(const std::array<bool, kBrickNodes>& solid) const;
  float DistanceOf(std::size_t node) const noexcept { return nodes_.distance[node]; }
  /// The side that the faces tell of a node.
  bool SolidAt(std::size_t node) const noexcept { return nodes_.Signed(node) < 0; }

  struct Errors {
    std::uint64_t erring = 0;          // the cells with more than kMostCellError within the band
    double within_band = kLeastBound;  // of all others in the band, voxels
    double beyond = kLeastBound;       // where a reading is near, but beyond the band
    /// Of each cell, how much farther than the surface a reading says it is, where it is near.
    std::array<float, kCellsPerBrick> over{};
  };
  /// How far the interpolated values are from the faces' distance. `open`: the faces may end in
  /// free space.
  Errors Measure(std::span<const float, kBrickNodes> values, double band, double most_near,
                 bool open) const;

  /// Every face that is the nearest to some place of a cell within the band: numbers among all
  /// faces, rising.
  std::vector<std::uint32_t> ListOf(std::size_t cell, double band) const;

 private:
  struct CellErrors {
    double within_band = 0;
    double beyond = 0;
    double over = 0;
  };
  CellErrors ErrorsOf(std::span<const float, kBrickNodes> values, std::size_t cell,
                      const PlaceLanes& pattern, const std::vector<std::uint32_t>& candidates,
                      double band, double most_near) const;
  /// The faces that can be the nearest to some place of a cell.
  std::vector<std::uint32_t> CandidatesOf(std::size_t cell) const;
  bool NearlyOnePlane(const std::vector<std::uint32_t>& candidates, std::size_t cell) const;
  /// Adds to `listed`, a flag a face, what is the nearest within the cube about `middle` (from the
  /// brick's lowest node) with half a side `half`, voxels. `contenders` are all that can be.
  void AddNearestIn(const std::array<float, 3>& middle, float half, double band,
                    std::span<const std::uint32_t> contenders,
                    std::vector<std::uint8_t>& listed) const;
  /// A pattern of places in the cell, and for each candidate some that lie over it: a face that is
  /// slimmer than the pattern, such as the rim of a sheet, is the nearest between its places alone.
  PlaceLanes PlacesIn(std::size_t cell, const PlaceLanes& pattern,
                      const std::vector<std::uint32_t>& candidates) const;

  std::span<const std::uint32_t> near_;
  const std::vector<FieldFace>& all_;
  Vec3 first_L_;
  std::vector<NearFace> faces_;
  NearestLanes nodes_;
  std::uint32_t nearest_ = 0;  // of faces_, to the centre of some cell
  /// By face: the distances of the cells' centres and their heights over its plane, voxels.
  std::vector<std::array<float, kCellsPerBrick>> distances_;
  std::vector<std::array<float, kCellsPerBrick>> heights_;
  std::array<float, kCellsPerBrick> cell_least_{};  // of these distances
};

}  // namespace tandem
