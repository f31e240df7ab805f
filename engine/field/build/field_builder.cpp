#include "engine/field/build/field_builder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include <tbb/parallel_for.h>

#include "engine/field/build/brick_faces.h"
#include "engine/field/build/field_mesh.h"
#include "engine/field/build/field_packer.h"
#include "engine/field/build/hyperbrick_maker.h"
#include "engine/geometry/mesh/closest_on_triangle.h"
#include "engine/voxel/build/inside_winding.h"
#include "engine/voxel/build/voxelize.h"

namespace tandem {

namespace {

double DistanceFrom(const FieldFace& face, const Vec3& place_L) {
  const auto& [a, b, c] = face.corners_L;
  return (ClosestOnTriangle(a, b, c, place_L).point - place_L).norm();
}

/// Returns the header of a field before anything is stored.
FieldHeader HeaderOf(const FieldMesh& mesh, const FieldOptions& options) {
  FieldHeader header;
  header.voxel_size = options.voxel_size;
  header.band = options.band;
  header.range = options.range;
  header.error_bound = kLeastBound;
  header.origin = mesh.origin();
  header.size = mesh.box().size * (kHyperchunkSide / kHyperbrickCells);
  Bounds whole;
  for (const FieldFace& face : mesh.faces()) {
    const Bounds of_face = BoundsOfFace(face);
    whole.Add(of_face.min);
    whole.Add(of_face.max);
  }
  Vec3::Map(header.faces_min_L.data()) = whole.min;
  Vec3::Map(header.faces_max_L.data()) = whole.max;
  return header;
}

}  // namespace

/// Fills a field layer by layer of hyperbricks, so that it holds at most three layers besides what
/// is stored. It makes first the bricks, each hyperbrick by itself. Then it makes the lists of
/// cells, whose neighbours may lie in other hyperbricks. At last it puts everything into one block.
class FieldBuilder {
 public:
  FieldBuilder(const TriangleMesh& mesh_W, const MeshFacing& facing, const FieldOptions& options)
      : options_(options),
        mesh_(mesh_W, facing, options.voxel_size),
        packer_(HeaderOf(mesh_, options), mesh_.faces()),
        size_(packer_.header().size) {
    hyperbricks_.resize(static_cast<std::size_t>(size_.x) * static_cast<std::size_t>(size_.y) *
                        static_cast<std::size_t>(size_.z));
  }

  Result<DistanceField> Build() {
    FindFacesOfHyperbricks();
    // a layer's lists need the errors in the layers beside it, so a layer gets its lists after the
    // next one is filled; it is stored after the next one has lists
    const std::int32_t layers = size_.z;
    for (std::int32_t z = 0; z < layers + 2; ++z) {
      VisitLayer(z, [this](std::size_t i) {
        HyperbrickMaker(options_, mesh_, HyperbrickAt(i) * kHyperbrickCells, hyperbricks_[i])
            .Make();
      });
      VisitLayer(z - 1, [this](std::size_t i) {
        ListCells(i);
      });
      if (options_.stop.stop_requested()) return Error{"the field was stopped"};
      StoreLayer(z - 2);
    }
    return packer_.Pack();
  }

 private:
  GridIndex HyperbrickAt(std::size_t number) const {
    const auto n = static_cast<std::int32_t>(number);
    return {n % size_.x, n / size_.x % size_.y, n / size_.x / size_.y};
  }
  std::size_t NumberOf(const GridIndex& hyperbrick) const {
    return static_cast<std::size_t>(hyperbrick.x +
                                    size_.x * (hyperbrick.y + size_.y * hyperbrick.z));
  }
  bool Holds(const GridIndex& hyperbrick) const {
    return hyperbrick.x >= 0 && hyperbrick.y >= 0 && hyperbrick.z >= 0 && hyperbrick.x < size_.x &&
           hyperbrick.y < size_.y && hyperbrick.z < size_.z;
  }

  void FindFacesOfHyperbricks() {
    constexpr double kSide = kHyperbrickCells;
    const Vec3 more = Vec3::Constant(HyperbrickSurvey::kFarthest);
    for (std::uint32_t face = 0; face < mesh_.faces().size(); ++face) {
      const Bounds box = BoundsOfFace(mesh_.faces()[face]);
      const GridIndex low = HyperbrickOf(box.min - more);
      const GridIndex high = HyperbrickOf(box.max + more);
      for (std::int32_t z = low.z; z <= high.z; ++z) {
        for (std::int32_t y = low.y; y <= high.y; ++y) {
          for (std::int32_t x = low.x; x <= high.x; ++x) {
            const Vec3 centre_L = kSide * (Vec3(x, y, z) + Vec3::Constant(0.5));
            const double reach = HyperbrickSurvey::kFarthest + 0.5 * kSide * std::sqrt(3.0);
            if (DistanceFrom(mesh_.faces()[face], centre_L) > reach) continue;
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
    return {along(0, size_.x), along(1, size_.y), along(2, size_.z)};
  }

  /// Returns the brick at a place counted in bricks from V's origin; null if there is none.
  const BuiltBrick* BrickAt(const GridIndex& brick) const {
    const GridIndex at = brick >> 3;
    if (!Holds(at)) return nullptr;
    const BuiltHyperbrick& hyperbrick = hyperbricks_[NumberOf(at)];
    if (hyperbrick.entries.empty()) return nullptr;
    const std::int32_t entry = hyperbrick.entries[CellInBlock(brick)];
    return entry < 0 ? nullptr : &hyperbrick.bricks[static_cast<std::size_t>(entry)];
  }

  /// Returns which of a brick's nodes have a cell round them that errs.
  std::array<bool, kBrickNodes> NodesThatErr(const GridIndex& brick) const {
    std::array<bool, kBrickNodes> err{};
    for (std::int32_t i = 0; i < 27; ++i) {
      const GridIndex aside{i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1};
      const BuiltBrick* other = BrickAt(brick + aside);
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
    BuiltHyperbrick& hyperbrick = hyperbricks_[number];
    const GridIndex first_brick = HyperbrickAt(number) * 8;
    const NearFaces faces(first_brick * kBrickCells, mesh_.faces(), hyperbrick.near);
    for (BuiltBrick& brick : hyperbrick.bricks) {
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

  void ListCells(const NearFaces& near, BuiltBrick& brick, const GridIndex& at) const {
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
    if (z < 0 || z >= size_.z) return;
    const std::size_t begin = NumberOf({0, 0, z});
    tbb::parallel_for(begin, NumberOf({0, 0, z + 1}), [&](std::size_t i) {
      if (!options_.stop.stop_requested()) visit(i);
    });
  }

  void StoreLayer(std::int32_t z) {
    if (z < 0) return;
    const std::size_t end = NumberOf({0, 0, z + 1});
    for (std::size_t i = NumberOf({0, 0, z}); i < end; ++i) packer_.Store(hyperbricks_[i]);
  }

  const FieldOptions& options_;
  FieldMesh mesh_;
  FieldPacker packer_;
  GridIndex size_;  // hyperbricks
  std::vector<BuiltHyperbrick> hyperbricks_;
};

Result<DistanceField> BuildField(const TriangleMesh& mesh_W, const FieldOptions& options) {
  const VoxelizeOptions size{.voxel_size = options.voxel_size,
                             .max_memory_bytes = options.max_memory_bytes};
  if (std::optional<Error> fault = VoxelSizeFault(mesh_W, size)) return *fault;
  const MeshSides sides(mesh_W);
  const MeshFacing facing = FindFacing(mesh_W, sides);
  // both sides of each face, and of the parts that others cut it into
  const std::size_t places = 2 * mesh_W.triangles.size();
  if (auto fault = WindingCostFault(mesh_W, facing, options.voxel_size, places)) {
    return *std::move(fault);
  }
  return FieldBuilder(mesh_W, facing, options).Build();
}

}  // namespace tandem
