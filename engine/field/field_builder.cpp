#include "engine/field/field_builder.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <tbb/parallel_for.h>

#include "engine/field/brick_faces.h"
#include "engine/field/face_tree.h"
#include "engine/field/field_faces.h"
#include "engine/field/field_image.h"
#include "engine/field/near_faces.h"
#include "engine/geometry/closest_on_triangle.h"
#include "engine/voxel/inside_rows.h"
#include "engine/voxel/voxelize.h"

namespace tandem {

namespace {

constexpr double kHalfVoxelDiagonal = 0.8662;
constexpr std::int32_t kNoBrick = -1;

/// Returns the greatest excess of an interpolated distance at a place that is `distance` away,
/// voxels: DistanceField::kMostSquareOver.
float MostOver(float distance) {
  return std::sqrt(distance * distance + static_cast<float>(DistanceField::kMostSquareOver)) -
         distance;
}

Vec3 PlaceOf(const GridIndex& index) {
  return {static_cast<double>(index.x), static_cast<double>(index.y), static_cast<double>(index.z)};
}

double DistanceFrom(const FieldFace& face, const Vec3& place_L) {
  const auto& [a, b, c] = face.corners_L;
  return (ClosestOnTriangle(a, b, c, place_L).point - place_L).norm();
}

Bounds BoundsOfFace(const FieldFace& face) {
  Bounds box;
  for (const Vec3& corner : face.corners_L) box.Add(corner);
  return box;
}

}  // namespace

/// Fills a field layer by layer of hyperbricks, so that it holds at most three layers besides what
/// is stored. It makes first the bricks, each hyperbrick by itself. Then it makes the lists of
/// cells, whose neighbours may lie in other hyperbricks. At last it puts everything into one block.
class FieldBuilder {
 public:
  FieldBuilder(const TriangleMesh& mesh_W, const MeshFacing& facing, const FieldOptions& options)
      : options_(options),
        surface_(mesh_W, Features{}, options.voxel_size, facing, 1),
        inside_(surface_, mesh_W, facing, options.voxel_size),
        open_(!facing.open.empty()) {
    const HyperchunkBox& box = surface_.box();
    FieldHeader& header = field_.header;
    header.voxel_size = options.voxel_size;
    header.band = options.band;
    header.range = options.range;
    header.origin = box.first * kHyperchunkSide;
    header.size = box.size * (kHyperchunkSide / kHyperbrickCells);
    all_ = FindFieldFaces(mesh_W, facing, options.voxel_size, header.origin);
    Bounds whole;
    for (const FieldFace& face : all_) {
      const Bounds of_face = BoundsOfFace(face);
      whole.Add(of_face.min);
      whole.Add(of_face.max);
    }
    Vec3::Map(header.faces_min_L.data()) = whole.min;
    Vec3::Map(header.faces_max_L.data()) = whole.max;
    tree_.emplace(all_);
    kept_.assign(all_.size(), ~0U);
    hyperbricks_.resize(static_cast<std::size_t>(field_.header.size.x) *
                        static_cast<std::size_t>(field_.header.size.y) *
                        static_cast<std::size_t>(field_.header.size.z));
  }

  Result<DistanceField> Build() {
    FindFacesOfHyperbricks();
    field_.header.error_bound = kLeastBound;
    // a layer's lists need the errors in the layers beside it, so a layer gets its lists after the
    // next one is filled; it is stored after the next one has lists
    const std::int32_t layers = field_.header.size.z;
    for (std::int32_t z = 0; z < layers + 2; ++z) {
      VisitLayer(z, [this](std::size_t i) {
        FillHyperbrick(i);
      });
      VisitLayer(z - 1, [this](std::size_t i) {
        ListCells(i);
      });
      if (options_.stop.stop_requested()) return Error{"the field was stopped"};
      StoreLayer(z - 2);
    }
    // the kernel counts bytes in 32 bits
    constexpr std::size_t kMost = std::numeric_limits<std::int32_t>::max() - 64;
    if (field_.steps.size() > kMost) {
      return Error{"the steps of the field would need more than 2 GiB; take larger voxels"};
    }
    return FieldImage::Pack(std::move(field_));
  }

 private:
  /// Cells that have a list, in rising order.
  struct CellLists {
    std::uint64_t cells = 0;
    std::vector<std::uint8_t> shares;
    std::vector<std::uint8_t> overs;
    std::vector<std::vector<std::uint32_t>> faces;
  };
  struct Brick {
    std::size_t place = 0;  // in its hyperbrick, as CellInBlock
    PackedBrick packed;
    std::uint64_t in_band = 0;  // cells that the band reaches, none in a flat brick
    CellCandidates candidates;
    std::uint64_t erring = 0;
    std::array<float, kCellsPerBrick> over{};
    float outer_over = 0;  // the same where no cell is measured
    CellLists lists;
  };
  struct Hyperbrick {
    std::vector<std::uint32_t> near;  // faces
    std::vector<Brick> bricks;
    /// Per place: number of a brick, or a bound's entry. Empty where `bound` holds throughout.
    std::vector<std::int32_t> entries;
    std::int32_t bound = 0;
    double within_band = 0;
    double beyond = 0;
  };

  GridIndex HyperbrickAt(std::size_t number) const {
    const auto n = static_cast<std::int32_t>(number);
    return {n % field_.header.size.x, n / field_.header.size.x % field_.header.size.y,
            n / field_.header.size.x / field_.header.size.y};
  }
  std::size_t NumberOf(const GridIndex& hyperbrick) const {
    return static_cast<std::size_t>(
        hyperbrick.x + field_.header.size.x * (hyperbrick.y + field_.header.size.y * hyperbrick.z));
  }
  bool Holds(const GridIndex& hyperbrick) const {
    return hyperbrick.x >= 0 && hyperbrick.y >= 0 && hyperbrick.z >= 0 &&
           hyperbrick.x < field_.header.size.x && hyperbrick.y < field_.header.size.y &&
           hyperbrick.z < field_.header.size.z;
  }

  /// Tells whether the centre of a voxel of V is in the solid, by the rows of crossings. Where a
  /// body is open they leave out voxels that the surface passes through.
  bool Solid(const GridIndex& voxel_V) const {
    const HyperchunkBox& box = surface_.box();
    const GridIndex hyperchunk = (voxel_V >> 6) + box.first;
    if (!box.Holds(hyperchunk)) return false;
    const std::size_t cell = box.CellOf(hyperchunk);
    const std::uint64_t* rows = inside_.RowsOf(cell);
    if (rows == nullptr) return inside_.Solid(cell);
    const auto row = static_cast<std::size_t>((voxel_V.y & 63) + 64 * (voxel_V.z & 63));
    return (rows[row] >> (voxel_V.x & 63) & 1U) != 0;
  }

  /// Tells whether places of the free side have readings farther off than the survey of a
  /// hyperbrick sees.
  bool HasFarBricks() const { return options_.range > DistanceField::kLeastRange; }

  void FindFacesOfHyperbricks() {
    constexpr double kSide = kHyperbrickCells;
    const Vec3 more = Vec3::Constant(HyperbrickSurvey::kFarthest);
    for (std::uint32_t face = 0; face < all_.size(); ++face) {
      const Bounds box = BoundsOfFace(all_[face]);
      const GridIndex low = HyperbrickOf(box.min - more);
      const GridIndex high = HyperbrickOf(box.max + more);
      for (std::int32_t z = low.z; z <= high.z; ++z) {
        for (std::int32_t y = low.y; y <= high.y; ++y) {
          for (std::int32_t x = low.x; x <= high.x; ++x) {
            const Vec3 centre_L = kSide * (Vec3(x, y, z) + Vec3::Constant(0.5));
            const double reach = HyperbrickSurvey::kFarthest + 0.5 * kSide * std::sqrt(3.0);
            if (DistanceFrom(all_[face], centre_L) > reach) continue;
            hyperbricks_[NumberOf({x, y, z})].near.push_back(face);
          }
        }
      }
    }
  }
  /// Returns the hyperbrick of a place, or the one next to it.
  GridIndex HyperbrickOf(const Vec3& place_L) const {
    const auto along = [&](Eigen::Index axis, std::int32_t count) {
      const double at = std::floor(place_L[axis] / kHyperbrickCells);
      return static_cast<std::int32_t>(std::clamp(at, 0.0, count - 1.0));
    };
    return {along(0, field_.header.size.x), along(1, field_.header.size.y),
            along(2, field_.header.size.z)};
  }

  void FillHyperbrick(std::size_t number) {
    Hyperbrick& hyperbrick = hyperbricks_[number];
    const GridIndex first = HyperbrickAt(number) * kHyperbrickCells;
    hyperbrick.entries.assign(kBricksPerHyperbrick, kNoBrick);
    MakeBricks(hyperbrick, first);
    if (BoundCube(hyperbrick, {0, 0, 0}, kHyperbrickCells, first)) {
      hyperbrick.bound = hyperbrick.entries.front();
      hyperbrick.entries.clear();
    }
  }

  void MakeBricks(Hyperbrick& hyperbrick, const GridIndex& first) {
    // greatest distance of a node that counts
    const double kept = std::min(options_.range, DistanceField::kLeastRange) + kHalfVoxelDiagonal;
    const NearFaces faces(first, all_, hyperbrick.near);
    FarNodes far_nodes(*tree_, first);
    const HyperbrickSurvey survey(faces, kept, !open_);
    for (std::size_t place = 0; place < kBricksPerHyperbrick; ++place) {
      Brick brick;
      brick.place = place;
      switch (survey.KindOf(place)) {
        case HyperbrickSurvey::Kind::kFar:
          continue;
        case HyperbrickSurvey::Kind::kFlat: {
          const HyperbrickSurvey::Plane plane = survey.PlaneOf(place);
          brick.packed.brick = FlatBrick(plane.nhat, plane.at_lowest);
          if (HasFarBricks()) {
            std::array<float, kBrickNodes> values = Unpacked(brick.packed);
            if (far_nodes.MeasureBeyond(place, values)) {
              brick.packed = PackBrick(values);
              brick.outer_over = MostOver(DistanceField::kLeastRange);
            }
          }
          brick.over.fill(static_cast<float>(kLeastBound));
          break;
        }
        case HyperbrickSurvey::Kind::kMeasured:
          if (!MeasureBrick(faces, survey, first, kept, far_nodes, hyperbrick, brick)) continue;
      }
      hyperbrick.entries[place] = static_cast<std::int32_t>(hyperbrick.bricks.size());
      hyperbrick.bricks.push_back(std::move(brick));
    }
    if (HasFarBricks()) MakeFarBricks(hyperbrick, {0, 0, 0}, kHyperbrickCells, first, far_nodes);
  }

  /// Makes the bricks of the free side that are farther off than a survey sees, in a cube of a
  /// hyperbrick (in cells from the hyperbrick's first).
  void MakeFarBricks(Hyperbrick& hyperbrick, const GridIndex& from, int side,
                     const GridIndex& first, FarNodes& nodes) const {
    const GridIndex centre = from + GridIndex{side / 2, side / 2, side / 2};
    const double kept = options_.range + kHalfVoxelDiagonal;
    if (nodes.DistanceOf(centre) - 0.5 * side * std::sqrt(3.0) > kept) return;
    if (side > kBrickCells) {
      for (int i = 0; i < 8; ++i) {
        const GridIndex step{i & 1, i >> 1 & 1, i >> 2};
        MakeFarBricks(hyperbrick, from + step * (side / 2), side / 2, first, nodes);
      }
      return;
    }
    Brick brick;
    brick.place = CellInBlock(from >> 2);
    // no surface comes near such a brick, so it lies on one side
    if (hyperbrick.entries[brick.place] != kNoBrick || Solid(first + centre)) return;
    const std::array<float, kBrickNodes> values = nodes.OfBrick(brick.place);
    const float nearest = *std::min_element(values.begin(), values.end());
    if (nearest > kept) return;
    brick.packed = PackBrick(values);
    // nodes within a step or two of a plane: nothing there is round, and no edge is near
    constexpr unsigned kFlatBits = 2;
    brick.outer_over =
        brick.packed.brick.bits <= kFlatBits ? static_cast<float>(kLeastBound) : MostOver(nearest);
    hyperbrick.entries[brick.place] = static_cast<std::int32_t>(hyperbrick.bricks.size());
    hyperbrick.bricks.push_back(std::move(brick));
  }

  /// Fills a brick by measuring the faces, and tells whether it comes near enough to be kept.
  bool MeasureBrick(const NearFaces& faces, const HyperbrickSurvey& survey, const GridIndex& first,
                    double kept, FarNodes& far_nodes, Hyperbrick& hyperbrick, Brick& brick) const {
    const NearestLanes nodes = survey.NodesOf(brick.place);
    const auto* end = nodes.distance.begin() + kBrickNodes;
    if (*std::min_element(nodes.distance.begin(), end) > kept) return false;
    const GridIndex lowest = first + BlockCell(brick.place) * kBrickCells;
    HyperbrickSurvey::BrickCells cells = survey.CellsOf(brick.place, DistanceField::kMostNear);
    std::array<float, kBrickNodes> values = Values(nodes, SolidNodes(lowest, nodes), cells.plane);
    if (HasFarBricks() && far_nodes.MeasureBeyond(brick.place, values)) {
      brick.outer_over = MostOver(DistanceField::kLeastRange);
    }
    brick.packed = PackBrick(values);
    for (std::size_t cell = 0; cell < kCellsPerBrick; ++cell) {
      const double least = cells.least[cell] - kHalfVoxelDiagonal;
      if (least < options_.band) brick.in_band |= std::uint64_t{1} << cell;
    }
    BrickFaces::Errors errors = BrickFaces(faces, brick.place, cells.candidates)
                                    .Measure(Unpacked(brick.packed), cells.near, options_.band,
                                             DistanceField::kMostNear, open_);
    brick.candidates = std::move(errors.left);
    brick.erring = errors.erring;
    brick.over = errors.over;
    hyperbrick.within_band = std::max(hyperbrick.within_band, errors.within_band);
    hyperbrick.beyond = std::max(hyperbrick.beyond, errors.beyond);
    return true;
  }

  /// Returns the distances of a brick's nodes. Nodes farther than the survey's reach get a value of
  /// at least that, along `plane` where possible.
  static std::array<float, kBrickNodes> Values(const NearestLanes& nodes,
                                               const std::array<bool, kBrickNodes>& solid,
                                               const HyperbrickSurvey::Plane& plane) {
    std::array<float, kBrickNodes> values;
    for (std::size_t node = 0; node < kBrickNodes; ++node) {
      float distance = nodes.distance[node];
      if (distance > HyperbrickSurvey::kReach) {
        const Vec3 from_lowest(static_cast<double>(node % kBrickSide),
                               static_cast<double>(node / kBrickSide % kBrickSide),
                               static_cast<double>(node / kBrickSide / kBrickSide));
        const auto height = static_cast<float>(plane.at_lowest + plane.nhat.dot(from_lowest));
        distance = std::max(HyperbrickSurvey::kReach, solid[node] ? -height : height);
      }
      values[node] = solid[node] ? -distance : distance;
    }
    return values;
  }

  std::array<bool, kBrickNodes> SolidNodes(const GridIndex& lowest,
                                           const NearestLanes& nodes) const {
    std::array<bool, kBrickNodes> solid;
    for (std::int32_t z = 0; z <= kBrickCells; ++z) {
      for (std::int32_t y = 0; y <= kBrickCells; ++y) {
        for (std::int32_t x = 0; x <= kBrickCells; ++x) {
          const std::size_t node =
              NodeInBrick(static_cast<std::size_t>(x), static_cast<std::size_t>(y),
                          static_cast<std::size_t>(z));
          const bool by_faces = open_ && nodes.distance[node] < 2 * kHalfVoxelDiagonal;
          solid[node] = by_faces ? nodes.Signed(node) < 0 : Solid(lowest + GridIndex{x, y, z});
        }
      }
    }
    return solid;
  }

  static std::array<float, kBrickNodes> Unpacked(const PackedBrick& packed) {
    std::vector<std::uint8_t> steps = packed.steps;
    steps.resize(steps.size() + 3);
    std::array<float, kBrickNodes> values;
    for (std::size_t node = 0; node < kBrickNodes; ++node) {
      values[node] = NodeValue(packed.brick, steps.data(), node % kBrickSide,
                               node / kBrickSide % kBrickSide, node / kBrickSide / kBrickSide);
    }
    return values;
  }

  /// Gives a bound to the places without a brick in a cube of a hyperbrick (in cells from the
  /// hyperbrick's first). It is one bound for all where that is at least a third of their distance.
  /// Returns whether it is one bound.
  bool BoundCube(Hyperbrick& hyperbrick, const GridIndex& from, int side,
                 const GridIndex& first) const {
    const GridIndex middle{side / 2, side / 2, side / 2};
    const auto radius = 0.5 * side * std::sqrt(3.0);
    const GridIndex centre = first + from + middle;
    const std::size_t place = CellInBlock(from >> 2);
    if (side == kBrickCells && hyperbrick.entries[place] != kNoBrick) return false;
    const double distance = tree_->Nearest(PlaceOf(centre));
    const double least = distance - radius;
    if (side > kBrickCells && (least < radius || least <= options_.range + kHalfVoxelDiagonal)) {
      for (int i = 0; i < 8; ++i) {
        const GridIndex step{i & 1, i >> 1 & 1, i >> 2};
        BoundCube(hyperbrick, from + step * (side / 2), side / 2, first);
      }
      return false;
    }
    // in a brick that is not kept, the nodes and with them all places are beyond the range
    const bool solid = Solid(centre);
    const double range =
        solid ? std::min(options_.range, DistanceField::kLeastRange) : options_.range;
    const std::int32_t entry = DistanceField::BoundEntry(std::max(least, range), solid);
    const std::int32_t bricks = side / kBrickCells;
    for (std::int32_t z = 0; z < bricks; ++z) {
      for (std::int32_t y = 0; y < bricks; ++y) {
        for (std::int32_t x = 0; x < bricks; ++x) {
          hyperbrick.entries[CellInBlock((from >> 2) + GridIndex{x, y, z})] = entry;
        }
      }
    }
    return side == kHyperbrickCells;
  }

  /// Returns the brick at a place counted in bricks from V's origin; null if there is none.
  const Brick* BrickAt(const GridIndex& brick) const {
    const GridIndex at = brick >> 3;
    if (!Holds(at)) return nullptr;
    const Hyperbrick& hyperbrick = hyperbricks_[NumberOf(at)];
    if (hyperbrick.entries.empty()) return nullptr;
    const std::int32_t entry = hyperbrick.entries[CellInBlock(brick)];
    return entry < 0 ? nullptr : &hyperbrick.bricks[static_cast<std::size_t>(entry)];
  }

  /// Returns which of a brick's nodes have a cell round them that errs.
  std::array<bool, kBrickNodes> NodesThatErr(const GridIndex& brick) const {
    std::array<bool, kBrickNodes> err{};
    for (std::int32_t i = 0; i < 27; ++i) {
      const GridIndex aside{i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1};
      const Brick* other = BrickAt(brick + aside);
      if (other == nullptr || other->erring == 0) continue;
      for (std::int32_t cell = 0; cell < 64; ++cell) {
        if ((other->erring >> cell & 1U) == 0) continue;
        for (std::int32_t corner = 0; corner < 8; ++corner) {
          const GridIndex node = aside * kBrickCells +
                                 GridIndex{cell & 3, cell >> 2 & 3, cell >> 4} +
                                 GridIndex{corner & 1, corner >> 1 & 1, corner >> 2};
          const auto within = [](std::int32_t n) {
            return n >= 0 && n <= kBrickCells;
          };
          if (!within(node.x) || !within(node.y) || !within(node.z)) continue;
          err[NodeInBrick(static_cast<std::size_t>(node.x), static_cast<std::size_t>(node.y),
                          static_cast<std::size_t>(node.z))] = true;
        }
      }
    }
    return err;
  }

  void ListCells(std::size_t number) {
    Hyperbrick& hyperbrick = hyperbricks_[number];
    const GridIndex first_brick = HyperbrickAt(number) * 8;
    const NearFaces faces(first_brick * kBrickCells, all_, hyperbrick.near);
    for (Brick& brick : hyperbrick.bricks) {
      ListCells(faces, brick, first_brick + BlockCell(brick.place));
      float over = brick.outer_over;
      float over_of_lists = 0;
      for (std::size_t cell = 0; cell < kCellsPerBrick; ++cell) {
        const bool listed = (brick.lists.cells >> cell & 1U) != 0;
        float& most = listed ? over_of_lists : over;
        most = std::max(most, brick.over[cell]);
      }
      brick.packed.brick.SetOver(over);
      brick.packed.brick.SetOverOfLists(over_of_lists);
    }
  }

  void ListCells(const NearFaces& near, Brick& brick, const GridIndex& at) const {
    if (brick.in_band == 0) return;
    const std::array<bool, kBrickNodes> err = NodesThatErr(at);
    if (std::none_of(err.begin(), err.end(), [](bool e) {
          return e;
        }))
      return;
    const BrickFaces faces(near, brick.place, brick.candidates);
    for (std::size_t cell = 0; cell < kCellsPerBrick; ++cell) {
      if ((brick.in_band >> cell & 1U) == 0) continue;
      std::uint8_t shares = 0;
      for (std::size_t corner = 0; corner < 8; ++corner) {
        const std::size_t node =
            NodeInBrick((cell & 3) + (corner & 1), (cell >> 2 & 3) + (corner >> 1 & 1),
                        (cell >> 4) + (corner >> 2));
        if (err[node]) shares = static_cast<std::uint8_t>(shares | 1U << corner);
      }
      if (shares == 0) continue;
      std::vector<std::uint32_t> list = faces.ListOf(cell, options_.band);
      if (list.empty()) continue;
      brick.lists.cells |= std::uint64_t{1} << cell;
      brick.lists.shares.push_back(shares);
      const double steps = std::ceil(brick.over[cell] / DistanceField::kListOverStep);
      brick.lists.overs.push_back(static_cast<std::uint8_t>(std::min(255.0, steps)));
      brick.lists.faces.push_back(std::move(list));
    }
    brick.candidates = {};
  }

  /// Calls `visit(hyperbrick)` for the hyperbricks of a layer along z, in parallel.
  template <typename Visit>
  void VisitLayer(std::int32_t z, const Visit& visit) {
    if (z < 0 || z >= field_.header.size.z) return;
    const std::size_t begin = NumberOf({0, 0, z});
    tbb::parallel_for(begin, NumberOf({0, 0, z + 1}), [&](std::size_t i) {
      if (!options_.stop.stop_requested()) visit(i);
    });
  }

  void StoreLayer(std::int32_t z) {
    if (z < 0) return;
    const std::size_t end = NumberOf({0, 0, z + 1});
    for (std::size_t i = NumberOf({0, 0, z}); i < end; ++i) Store(hyperbricks_[i]);
  }

  void Store(Hyperbrick& hyperbrick) {
    field_.header.error_bound = std::max(field_.header.error_bound, hyperbrick.within_band);
    field_.header.outer_error_bound = std::max(field_.header.outer_error_bound, hyperbrick.beyond);
    if (hyperbrick.entries.empty()) {
      field_.hyperbricks.push_back(hyperbrick.bound);
      return;
    }
    field_.hyperbricks.push_back(static_cast<std::int32_t>(field_.first_bricks.size()));
    field_.first_bricks.push_back(static_cast<std::uint32_t>(field_.bricks.size()));
    for (const std::int32_t entry : hyperbrick.entries) {
      field_.tables.push_back(static_cast<std::int16_t>(entry));
    }
    for (Brick& brick : hyperbrick.bricks) Store(brick);
    hyperbrick = {};
  }

  void Store(const Brick& brick) {
    FieldBrick stored = brick.packed.brick;
    if (brick.lists.cells != 0) {
      stored.flags |= FieldBrick::kHasLists;
      StoreLists(brick.lists);
    }
    stored.steps = static_cast<std::uint32_t>(field_.steps.size());
    field_.steps.insert(field_.steps.end(), brick.packed.steps.begin(), brick.packed.steps.end());
    field_.bricks.push_back(stored);
    field_.header.most_over =
        std::max(field_.header.most_over, static_cast<double>(stored.MostOver()));
  }

  void StoreLists(const CellLists& cells) {
    std::vector<std::uint32_t> faces;  // faces of the brick
    for (const std::vector<std::uint32_t>& list : cells.faces) {
      faces.insert(faces.end(), list.begin(), list.end());
    }
    std::sort(faces.begin(), faces.end());
    faces.erase(std::unique(faces.begin(), faces.end()), faces.end());
    const FieldLists lists{cells.cells, static_cast<std::uint32_t>(field_.list_faces.size()),
                           static_cast<std::uint16_t>(faces.size())};
    for (const std::uint32_t face : faces) {
      const std::uint32_t sheet = all_[face].sheet ? DistanceField::kSheet : 0U;
      field_.list_faces.push_back(Keep(face) | sheet);
    }
    for (std::size_t k = cells.faces.size(); k-- > 0;) {
      std::vector<std::uint8_t> list(lists.ListBytes());
      list[0] = cells.shares[k];
      list[1] = cells.overs[k];
      for (const std::uint32_t face : cells.faces[k]) {
        const auto at = static_cast<std::size_t>(
            std::lower_bound(faces.begin(), faces.end(), face) - faces.begin());
        list[2 + at / 8] = static_cast<std::uint8_t>(list[2 + at / 8] | 1U << at % 8);
      }
      field_.steps.insert(field_.steps.end(), list.begin(), list.end());
    }
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(&lists);
    field_.steps.insert(field_.steps.end(), bytes, bytes + sizeof lists);
  }

  /// Returns the number among the stored faces of a face that a list names.
  std::uint32_t Keep(std::uint32_t face) {
    if (kept_[face] == ~0U) {
      kept_[face] = static_cast<std::uint32_t>(field_.faces.size());
      DistanceField::Face stored;
      for (std::size_t k = 0; k < 3; ++k) {
        stored[k] = all_[face].corners_L[k].cast<float>();
      }
      field_.faces.push_back(stored);
    }
    return kept_[face];
  }

  const FieldOptions& options_;
  SurfaceBricks surface_;
  InsideRows inside_;
  bool open_;
  std::vector<FieldFace> all_;
  std::optional<FaceTree> tree_;
  std::vector<Hyperbrick> hyperbricks_;
  std::vector<std::uint32_t> kept_;  // per face: its number in the field, or ~0
  FieldImage::Parts field_;
};

Result<DistanceField> BuildField(const TriangleMesh& mesh_W, const FieldOptions& options) {
  const VoxelizeOptions size{.voxel_size = options.voxel_size,
                             .max_memory_bytes = options.max_memory_bytes};
  if (std::optional<Error> fault = VoxelSizeFault(mesh_W, size)) return *fault;
  const MeshSides sides(mesh_W);
  const MeshFacing facing = FindFacing(mesh_W, sides);
  return FieldBuilder(mesh_W, facing, options).Build();
}

}  // namespace tandem
