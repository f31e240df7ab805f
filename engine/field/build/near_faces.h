#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/field/build/face_distance.h"
#include "engine/field/query/field_brick.h"
#include "engine/voxel/map/voxel.h"

namespace tandem {

/// The faces near a hyperbrick, as seen from its middle.
class NearFaces {
 public:
  /// `first` is the hyperbrick's lowest node. `all` are the field's faces, `near` some of their
  /// numbers, rising.
  NearFaces(const GridIndex& first, const std::vector<FieldFace>& all,
            std::span<const std::uint32_t> near);

  std::size_t size() const noexcept { return near_.size(); }
  /// Returns a face by its place among the near faces.
  const FieldFace& operator[](std::size_t i) const { return all_[near_[i]]; }
  const NearFace& seen(std::size_t i) const { return seen_[i]; }
  /// Returns, by edge, the place of the face that continues this one as FieldFace::beside, or
  /// kNone.
  const std::array<std::uint32_t, 3>& beside(std::size_t i) const { return beside_[i]; }
  std::uint32_t number(std::size_t i) const { return near_[i]; }
  /// Returns the hyperbrick's middle, in L.
  const Vec3& middle_L() const noexcept { return middle_L_; }

  /// A box, voxels. `middle` is relative to the hyperbrick's middle; `half` has half its sides.
  struct Box {
    std::array<float, 3> middle, half;
  };
  /// Returns a bit for each edge of a face that some of a box lies beyond.
  unsigned EdgesBefore(std::uint32_t face, const Box& box) const {
    unsigned edges = 0;
    for (unsigned k = 0; k < 3; ++k) {
      if (InwardDistance(face, k, box) <= SideDistance(face, k, box)) edges |= 1U << k;
    }
    return edges;
  }
  /// Tells whether all of a box lies beyond edges of a face over which the surface continues
  /// gently, in faces for which `stays(face)` holds. Then one of these is as near everywhere in the
  /// box, and gives the same side. `edges`: as of EdgesBefore().
  template <typename Stays>
  bool GoesOn(std::uint32_t face, unsigned edges, const Box& box, const Stays& stays) const {
    bool beyond = false;
    for (unsigned k = 0; k < 3; ++k) {
      if ((edges >> k & 1U) == 0) continue;
      if (beside_[face][k] == FieldFace::kNone || !stays(beside_[face][k])) return false;
      beyond = beyond || InwardDistance(face, k, box) < -SideDistance(face, k, box);
    }
    return beyond;
  }

 private:
  /// Returns how far inside an edge the middle of a box is. SideDistance() returns how far from
  /// there the box reaches.
  float InwardDistance(std::uint32_t face, unsigned k, const Box& box) const {
    const NearFace::View::Edge& edge = seen_[face].view().edges[k];
    float inward = -edge.inward_offset;
    for (std::size_t axis = 0; axis < 3; ++axis) inward += edge.inward[axis] * box.middle[axis];
    return inward;
  }
  float SideDistance(std::uint32_t face, unsigned k, const Box& box) const {
    const NearFace::View::Edge& edge = seen_[face].view().edges[k];
    float aside = NearFace::kRounding;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      aside += std::abs(edge.inward[axis]) * box.half[axis];
    }
    return aside;
  }

  const std::vector<FieldFace>& all_;
  std::span<const std::uint32_t> near_;
  Vec3 middle_L_;
  std::vector<NearFace> seen_;
  std::vector<std::array<std::uint32_t, 3>> beside_;  // as FieldFace::beside, by place
};

/// A face that can be the nearest in a cell.
struct CellFace {
  std::uint32_t face = 0;   // place among the near faces
  std::uint32_t edges = 7;  // edges that some of the cell lies beyond, as NearFaces::EdgesBefore()
};
/// Faces among which is the nearest to each place of a brick's cells within reach, rising.
struct CellCandidates {
  std::array<std::uint32_t, kCellsPerBrick + 1> first{};
  std::vector<CellFace> faces;

  std::span<const CellFace> FacesOf(std::size_t cell) const {
    return std::span(faces).subspan(first[cell], first[cell + 1] - first[cell]);
  }
};

/// Finds what the faces near a hyperbrick mean for its nodes and cells while a field is built.
class HyperbrickSurvey {
 public:
  /// Reach of the faces, voxels. Every face nearer than this to a node is among them. So is every
  /// face that can be the nearest to a place of a cell that is as near.
  static constexpr float kReach = 2.25F;
  /// Distance from the hyperbrick beyond which a face has no effect there, voxels.
  static constexpr double kFarthest = 4;

  /// A brick is wanted if its nodes come nearer than `kept` (voxels). `closed`: no face ends in
  /// free space.
  HyperbrickSurvey(const NearFaces& faces, double kept, bool closed);

  enum class Kind : std::uint8_t {
    kFar,       // no node comes nearer than `kept`
    kFlat,      // all faces that count are in one plane, which does not end there
    kMeasured,  // anything else
  };
  /// Returns the kind of a brick. `brick` is its place in the hyperbrick, as CellInBlock.
  Kind KindOf(std::size_t brick) const noexcept { return bricks_[brick].kind; }

  /// A plane by its normal and the height of a brick over it, voxels.
  struct Plane {
    Vec3 nhat = Vec3::Zero();
    double at_lowest = 0;  // height of the brick's lowest node over the plane
  };
  /// Returns the plane of a flat brick.
  Plane PlaneOf(std::size_t brick) const { return PlaneOf(brick, bricks_[brick].nearest); }
  /// The faces' distances from a brick's cells.
  struct BrickCells {
    /// Per cell: the distance of its centre from the faces, voxels.
    std::array<float, kCellsPerBrick> least;
    std::uint64_t near = 0;  // cells that the faces come near to, which have candidates
    CellCandidates candidates;
    Plane plane;  // plane of the nearest face
  };

  // for measured bricks

  /// Returns the distances of a brick's nodes from the faces, and the heights over the face that
  /// gives the side. Distances beyond kReach are not right.
  NearestLanes NodesOf(std::size_t brick) const;
  /// Finds a brick's cells. A cell is near if the faces may come nearer than `within` (voxels) to
  /// its places.
  BrickCells CellsOf(std::size_t brick, double within) const;

 private:
  static constexpr std::int32_t kBlocks = kHyperbrickBricks + 1;  // blocks of nodes along a side
  static constexpr std::uint32_t kNone = ~0U;
  struct Brick {
    Kind kind = Kind::kFar;
    std::uint32_t nearest = kNone;  // a face
    bool sure = false;              // some face surely comes near
  };
  struct Visit {
    std::uint32_t brick;
    std::uint32_t face;
  };
  using CellDistances = std::array<float, kCellsPerBrick>;

  void FindKinds(double kept, bool closed);
  void DropFarPlanes(double kept);
  void MakeRoom();
  void Measure(double kept);
  void SortByBrick(const std::vector<Visit>& visits);
  Plane PlaneOf(std::size_t brick, std::uint32_t face) const;
  /// Finds in which cells of a brick each of `faces` is a candidate, given the cells for which it
  /// is near enough. A face is left out where others are as near.
  void LeaveOut(std::span<const std::uint32_t> faces, std::span<const NearFace::CubeSides> sides,
                std::vector<std::uint64_t>& cells) const;

  const NearFaces& faces_;
  std::array<Brick, kBricksPerHyperbrick> bricks_;
  std::vector<std::int32_t> blocks_;  // per block: its first node, or below 0
  std::vector<float> node_distances_, node_heights_;
  std::array<std::uint32_t, kBricksPerHyperbrick + 1> first_faces_{};  // per brick
  std::vector<std::uint32_t> brick_faces_;  // faces that may count in the brick
};

}  // namespace tandem
