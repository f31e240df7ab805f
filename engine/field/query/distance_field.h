#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <span>

#include "engine/base/files/image_bytes.h"
#include "engine/base/spatial.h"
#include "engine/field/query/field_brick.h"
#include "engine/field/query/field_lanes.h"
#include "engine/voxel/map/voxel.h"

namespace tandem {

/// The reading of a field at a place.
struct FieldReading {
  /// The signed distance from the surface, voxels, negative in the solid. Where not `near`, a lower
  /// bound of the distance, with the sign of the place.
  double value = 0;
  bool near = false;
};
struct FieldGradient {
  FieldReading reading;
  /// Gradient of the value, away from the solid; about a unit vector where `near`, otherwise zero.
  Vec3 gradient = Vec3::Zero();
};

/// Places as lanes, voxels relative to a whole place of V.
struct PlaceSpans {
  const float* x;
  const float* y;
  const float* z;
};

/// Places that are looked up together, given in another frame F relative to their middle, voxels.
inline constexpr std::size_t kBlockPlaces = 16;
struct PlacedBlock {
  PlaceSpans places_F;
  std::uint16_t lanes = 0xffff;      // one bit for each place that repeats none
  GridIndex base{};                  // a whole place of V, at most 2,048 voxels from the places
  std::array<float, 3> from_base{};  // their middle relative to `base`, in V
};

/// The readings of the places of a block, with one bit for each lane.
struct FieldReadings {
  float least = 0;           // lower bound of the distance of all places from the surface
  std::uint16_t within = 0;  // places nearer than the reach
  std::uint16_t listed = 0;  // places whose distance comes from faces
};

/// A push on a point near a surface, off that surface.
struct FieldPush {
  double distance = 0;         // voxels, negative in the solid
  Vec3 away_V = Vec3::Zero();  // unit
  double share = 0;            // share of the push that counts, 0 to 1
  bool sheet = false;          // off an open sheet, which pushes to either side
  /// Cosine of the angle between away_V and the normal of the nearest face, of several the one that
  /// turns most to the place. It is below 1 where an edge or a corner is nearest.
  double facing = 1;
};

/// The pushes of several places, in the order of the places.
struct FieldPushes {
  static constexpr std::size_t kMostPlaces = 64;
  static constexpr std::size_t kMostEach = 8;
  std::array<FieldPush, kMostPlaces * kMostEach> all;
  std::array<std::uint16_t, kMostPlaces + 1> first;  // per place

  std::span<const FieldPush> PushesAt(std::size_t place) const noexcept {
    return std::span(all).subspan(first[place], first[place + 1] - std::size_t{first[place]});
  }
};

struct ListPairs;

/// A body's signed Euclidean distance in voxels, in a narrow band round its surface; read-only once
/// built. Frame V: axes of W at the time of building, origin at the lowest corner of the box, a
/// whole number of hyperchunks from W's origin. Places are in voxels.
///
/// Nodes are the centres of voxels. Between them the value is interpolated along x, y and z, and so
/// is the gradient between the middles of the nodes' distances, so both are continuous:
///
///     value at     o-----o-----o-----o      gradient along the line at    --x-----x-----x--
///
/// Where that errs (sharp edges, notches, thin walls, sheets) a cell keeps a list of the faces that
/// are nearest in it. The distance from these is exact. It fades into the field over the next cell,
/// because a node has a share: 1 if one of its eight cells errs, otherwise 0, interpolated too.
///
/// The field is a table of tables: hyperbricks of 32^3 cells, bricks of 4^3 cells, or a bound for
/// either as a whole. All data lie in one block of bytes, which field_image.h draws and copies
/// share.
class DistanceField {
 public:
  DistanceField() = default;
  /// Readings are near from this depth on in the solid, voxels, and on the free side up to a
  /// quarter of a voxel beyond the range.
  static constexpr double kMostNear = 1.75;
  static constexpr double kLeastRange = 1.5;

  bool empty() const noexcept { return bricks_.empty(); }
  double voxel_size() const noexcept { return voxel_size_; }
  GridIndex origin() const noexcept { return origin_; }
  Vec3 p_WVo() const noexcept { return voxel_size_ * Vec3(origin_.x, origin_.y, origin_.z); }

  /// Returns the distance, voxels, below which every place is `near` and its reading within
  /// `error_bound`.
  double band() const noexcept { return band_; }
  /// Returns the distance, voxels, below which every place of the free side has a reading. In the
  /// solid every place nearer than kLeastRange has one. Beyond the band the error is up to
  /// `outer_error_bound`.
  double range() const noexcept { return range_; }
  /// Returns the distance from surfaces, voxels, up to which the distance of a push is exact within
  /// `error_bound`. Farther out the distance of a push is a lower bound.
  double fine_band() const noexcept { return std::max(0.0, band_ - kBandFade + kRounding); }
  /// Returns a lower bound of the distance for an interpolated value that may be `over` too great.
  /// Up to the fine band it is the value. Where that bound lies beyond the band it is `over` less
  /// than the value. In between the reduction is such that the bound grows with the value. The
  /// bound is never lower than kMostSquareOver allows.
  double AtLeast(double value, double over) const noexcept {
    const double fine = fine_band();
    if (value <= fine) return value;
    const double fade = band_ - fine;
    const double squared = value * value - kMostSquareOver;
    return std::max({value - over, fine + (value - fine) * fade / (fade + over),
                     std::sqrt(std::max(0.0, squared))});
  }
  /// Bound of the excess of an interpolated value's square over the distance's square. The square
  /// of a distance from any set, less the square of the place, is concave: it is the least of
  /// linear functions. So between the corners of a cell the distance's square is interpolated at
  /// most 3/4 too high, and with it the distance's. The remainder covers the rounding of storage.
  static constexpr double kMostSquareOver = 0.755;
  /// Returns the greatest error of a reading within the band, voxels: measured in each cell when
  /// the field was built.
  double error_bound() const noexcept { return error_bound_; }
  /// Returns the same for readings that are `near` beyond the band, where no cell has a list.
  double outer_error_bound() const noexcept { return outer_error_bound_; }
  /// Returns the greatest excess of a surface's distance over AtLeast() beyond fine_band().
  double most_early() const noexcept { return most_over_; }

  FieldReading At(const Vec3& place_V) const noexcept;
  /// Reads many places, with gradients. The bits are the same on every processor.
  void WithGradients(std::span<const Vec3> places_V, FieldGradient* gradients) const noexcept;

  /// Kinds of a reading of many: a bound; interpolated; interpolated, and At() uses faces.
  enum Kind : std::int32_t { kBound = 0, kNear = 1, kListed = 2 };
  /// Reads the values of many places, in single precision and without faces. Places are relative to
  /// `base`, at most 2,048 voxels from it. `count` is a multiple of 16. The bits are the same on
  /// every processor. `over`: the greatest excess of each value over the distance from the surface;
  /// null: not wanted.
  void Values(const GridIndex& base, const PlaceSpans& places, std::size_t count, float* values,
              std::int32_t* kinds, float* over = nullptr) const noexcept;
  /// Finds which places of blocks are nearer than `reach`, and a lower bound of each place's
  /// distance. R_VF is given by rows. Where faces give the distance, the bound is the distance
  /// itself, if it is below `reach`. Where a brick has more faces than are measured at once, and
  /// beyond the band, the bound may be below `reach` although the surface is not. The bits are the
  /// same on every processor.
  void ReadBlocks(const std::array<float, 9>& R_VF, float reach,
                  std::span<const PlacedBlock> blocks, float* bounds,
                  FieldReadings* readings) const noexcept;
  /// Finds how points at places, at most FieldPushes::kMostPlaces, are pushed off surfaces nearer
  /// than `reach`, which is at most `range`. A place has one push, or one for each of the faces of
  /// a notch. The pushes are continuous as a place moves. The bits are the same on every processor.
  void Pushes(std::span<const Vec3> places_V, double reach, FieldPushes& pushes) const noexcept;
  /// The greatest `over` of Values(), voxels.
  static constexpr double kMostOver = 63.0 / 32;

  struct Sizes {
    std::size_t bricks = 0;
    std::size_t flat_bricks = 0;
    std::size_t listed_cells = 0;
    std::size_t list_faces = 0;  // entries of the lists of all bricks
    std::size_t faces = 0;       // faces that lists name
    std::size_t table_bytes = 0;
    std::size_t brick_bytes = 0;
    std::size_t list_bytes = 0;  // lists and faces
    std::size_t bytes() const { return table_bytes + brick_bytes + list_bytes; }
  };
  Sizes Count() const;
  /// Returns a hash of all that is stored.
  std::uint64_t Digest() const;
  /// FieldImage::Read() makes the same field from these bytes.
  std::span<const std::byte> bytes() const noexcept { return block_.bytes; }

 private:
  friend class FieldBuilder;
  friend class FieldPacker;
  friend class HyperbrickMaker;
  friend class FieldImage;

  /// The block must have the size that its header says.
  explicit DistanceField(ImageBlock block);

  /// Voxels below the band's border over which the faces of lists fade into interpolation.
  static constexpr double kBandFade = 0.2;
  static constexpr double kRounding = 1e-9;
  /// The step of a bound in a table, voxels.
  static constexpr double kBoundStep = 0.125;
  static constexpr std::int32_t kMostBoundSteps = 16'000;  // greatest bound of a brick, steps

  /// The list of a cell: the faces that give its distance.
  struct List {
    const std::uint32_t* faces = nullptr;   // faces of the brick, in list_faces_
    const std::uint8_t* members = nullptr;  // one bit for each of the brick's faces
    std::size_t member_bytes = 0;
    std::uint8_t shares = 0;  // bit i: the share of the cell's corner i is 1, x fastest
    /// Excess of the interpolated value, as FieldBrick::Over(), in kListOverStep.
    std::uint8_t over = 0;
  };
  using Face = std::array<Vec3f, 3>;  // corners in L
  static constexpr double kListOverStep = 1.0 / 255;
  /// Flag of an entry of list_faces_: a sheet, which has free space on both sides.
  static constexpr std::uint32_t kSheet = 1U << 31U;
  struct Cell {
    GridIndex cell;  // index in the lattice
    Vec3 from;       // place relative to its lowest node
  };

  static Cell CellOf(const Vec3& place_L);
  /// Returns a brick's number, or a bound as BoundEntry() makes it.
  std::int32_t EntryOf(const GridIndex& cell) const noexcept;
  static std::int32_t BoundEntry(double least, bool inside);
  static FieldReading ReadBound(std::int32_t entry);
  FieldReading Outside(const Vec3& place_L) const;
  std::optional<List> ListOf(const FieldBrick& brick, const GridIndex& cell) const;
  /// Returns the list of a lane's cell, which has a brick.
  std::optional<List> ListOf(const FieldLanes& lanes, std::size_t lane) const;
  /// Adds a place with each face of a list, as many as there is room for. The place is a cell's
  /// lowest node and the vector from there.
  void AddPairs(const List& list, const GridIndex& cell, const std::array<float, 3>& from,
                ListPairs& pairs) const noexcept;
  /// Measures the faces of places whose lists decide whether they are nearer than `reach`.
  void AskLists(const FieldLanes& lanes, float reach, std::span<const PlacedBlock> blocks,
                float* bounds, FieldReadings* readings) const noexcept;
  static double InCube(const std::array<double, 8>& values, const Vec3& from);
  static double ShareOf(const List& list, const Vec3& from);
  double Interpolated(const FieldBrick& brick, const Cell& cell) const;
  FieldView View() const noexcept;
  /// Makes lanes of places, a whole number of vectors. Returns the number of lanes.
  std::size_t SetLanes(std::span<const Vec3> places_V, FieldLanes& lanes) const noexcept;
  /// Finds the interpolated values and gradients of lanes whose cells are known.
  void InterpolateGradients(std::size_t count, FieldLanes& lanes,
                            FieldGradients& gradients) const noexcept;
  class PushLanes;
  /// Returns the distance of a place from the faces of its cell's list.
  double DistanceToFaces(const List& list, const Cell& cell) const noexcept;
  /// Returns a bound of the excess of an interpolated value at a place. Continuous.
  double OverAt(const Cell& cell) const;
  /// Returns the same for anywhere in the brick at a place counted in bricks; 0 if there is none.
  float OverOfBrick(const GridIndex& brick) const noexcept;

  double voxel_size_ = 0;
  double band_ = 0;
  double range_ = 0;
  double most_near_ = kMostNear;  // greatest value of a reading that is `near`
  double most_over_ = 0;          // greatest excess of an interpolated value
  double error_bound_ = 0;
  double outer_error_bound_ = 0;
  GridIndex origin_;  // voxels from W's origin
  GridIndex size_;    // hyperbricks
  Bounds faces_L_;    // box of all faces
  ImageBlock block_;
  // views into block_
  std::span<const std::int32_t> hyperbricks_;    // per hyperbrick: number of its table, or a bound
  std::span<const std::uint32_t> first_bricks_;  // per table
  /// kBricksPerHyperbrick each: a brick's number relative to its table's first, or a bound.
  std::span<const std::int16_t> tables_;
  std::span<const FieldBrick> bricks_;
  std::span<const std::uint8_t> steps_;
  /// Per brick: numbers in faces_, with or without kSheet.
  std::span<const std::uint32_t> list_faces_;
  std::span<const Face> faces_;
};

}  // namespace tandem
