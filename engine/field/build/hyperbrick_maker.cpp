#include "engine/field/build/hyperbrick_maker.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/field/build/brick_faces.h"

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

std::array<float, kBrickNodes> Unpacked(const PackedBrick& packed) {
  std::vector<std::uint8_t> steps = packed.steps;
  steps.resize(steps.size() + 3);
  std::array<float, kBrickNodes> values;
  for (std::size_t node = 0; node < kBrickNodes; ++node) {
    values[node] = NodeValue(packed.brick, steps.data(), node % kBrickSide,
                             node / kBrickSide % kBrickSide, node / kBrickSide / kBrickSide);
  }
  return values;
}

/// Returns the distances of a brick's nodes. Nodes farther than the survey's reach get a value of
/// at least that, along `plane` where possible.
std::array<float, kBrickNodes> Values(const NearestLanes& nodes,
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

}  // namespace

void HyperbrickMaker::Make() {
  hyperbrick_.entries.assign(kBricksPerHyperbrick, kNoBrick);
  MakeBricks();
  if (BoundCube({0, 0, 0}, kHyperbrickCells)) {
    hyperbrick_.bound = hyperbrick_.entries.front();
    hyperbrick_.entries.clear();
  }
}

void HyperbrickMaker::MakeBricks() {
  // greatest distance of a node that counts
  const double kept = std::min(options_.range, DistanceField::kLeastRange) + kHalfVoxelDiagonal;
  const NearFaces faces(first_, mesh_.faces(), hyperbrick_.near);
  FarNodes far_nodes(mesh_.tree(), first_);
  const HyperbrickSurvey survey(faces, kept, !mesh_.open());
  for (std::size_t place = 0; place < kBricksPerHyperbrick; ++place) {
    BuiltBrick brick;
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
        if (!MeasureBrick(faces, survey, kept, far_nodes, brick)) continue;
    }
    hyperbrick_.entries[place] = static_cast<std::int32_t>(hyperbrick_.bricks.size());
    hyperbrick_.bricks.push_back(std::move(brick));
  }
  if (HasFarBricks()) MakeFarBricks({0, 0, 0}, kHyperbrickCells, far_nodes);
}

void HyperbrickMaker::MakeFarBricks(const GridIndex& from, int side, FarNodes& nodes) {
  const GridIndex centre = from + GridIndex{side / 2, side / 2, side / 2};
  const double kept = options_.range + kHalfVoxelDiagonal;
  if (nodes.DistanceOf(centre) - 0.5 * side * std::sqrt(3.0) > kept) return;
  if (side > kBrickCells) {
    for (int i = 0; i < 8; ++i) {
      const GridIndex step{i & 1, i >> 1 & 1, i >> 2};
      MakeFarBricks(from + step * (side / 2), side / 2, nodes);
    }
    return;
  }
  BuiltBrick brick;
  brick.place = CellInBlock(from >> 2);
  // no surface comes near such a brick, so it lies on one side
  if (hyperbrick_.entries[brick.place] != kNoBrick || mesh_.Solid(first_ + centre)) return;
  const std::array<float, kBrickNodes> values = nodes.InBrick(brick.place);
  const float nearest = *std::min_element(values.begin(), values.end());
  if (nearest > kept) return;
  brick.packed = PackBrick(values);
  // nodes within a step or two of a plane: nothing there is round, and no edge is near
  constexpr unsigned kFlatBits = 2;
  brick.outer_over =
      brick.packed.brick.bits <= kFlatBits ? static_cast<float>(kLeastBound) : MostOver(nearest);
  hyperbrick_.entries[brick.place] = static_cast<std::int32_t>(hyperbrick_.bricks.size());
  hyperbrick_.bricks.push_back(std::move(brick));
}

bool HyperbrickMaker::MeasureBrick(const NearFaces& faces, const HyperbrickSurvey& survey,
                                   double kept, FarNodes& far_nodes, BuiltBrick& brick) {
  const NearestLanes nodes = survey.NodesOf(brick.place);
  const auto* end = nodes.distance.begin() + kBrickNodes;
  if (*std::min_element(nodes.distance.begin(), end) > kept) return false;
  const GridIndex lowest = first_ + BlockCell(brick.place) * kBrickCells;
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
                                           DistanceField::kMostNear, mesh_.open());
  brick.candidates = std::move(errors.left);
  brick.erring = errors.erring;
  brick.over = errors.over;
  hyperbrick_.within_band = std::max(hyperbrick_.within_band, errors.within_band);
  hyperbrick_.beyond = std::max(hyperbrick_.beyond, errors.beyond);
  return true;
}

std::array<bool, kBrickNodes> HyperbrickMaker::SolidNodes(const GridIndex& lowest,
                                                          const NearestLanes& nodes) const {
  std::array<bool, kBrickNodes> solid;
  for (std::int32_t z = 0; z <= kBrickCells; ++z) {
    for (std::int32_t y = 0; y <= kBrickCells; ++y) {
      for (std::int32_t x = 0; x <= kBrickCells; ++x) {
        const std::size_t node = NodeInBrick(
            static_cast<std::size_t>(x), static_cast<std::size_t>(y), static_cast<std::size_t>(z));
        const bool by_faces = mesh_.open() && nodes.distance[node] < 2 * kHalfVoxelDiagonal;
        solid[node] = by_faces ? nodes.Signed(node) < 0 : mesh_.Solid(lowest + GridIndex{x, y, z});
      }
    }
  }
  return solid;
}

bool HyperbrickMaker::BoundCube(const GridIndex& from, int side) {
  const GridIndex middle{side / 2, side / 2, side / 2};
  const auto radius = 0.5 * side * std::sqrt(3.0);
  const GridIndex centre = first_ + from + middle;
  const std::size_t place = CellInBlock(from >> 2);
  if (side == kBrickCells && hyperbrick_.entries[place] != kNoBrick) return false;
  const double distance = mesh_.tree().Nearest(PlaceOf(centre));
  const double least = distance - radius;
  if (side > kBrickCells && (least < radius || least <= options_.range + kHalfVoxelDiagonal)) {
    for (int i = 0; i < 8; ++i) {
      const GridIndex step{i & 1, i >> 1 & 1, i >> 2};
      BoundCube(from + step * (side / 2), side / 2);
    }
    return false;
  }
  // in a brick that is not kept, the nodes and with them all places are beyond the range
  const bool solid = mesh_.Solid(centre);
  const double range =
      solid ? std::min(options_.range, DistanceField::kLeastRange) : options_.range;
  const std::int32_t entry = DistanceField::BoundEntry(std::max(least, range), solid);
  const std::int32_t bricks = side / kBrickCells;
  for (std::int32_t z = 0; z < bricks; ++z) {
    for (std::int32_t y = 0; y < bricks; ++y) {
      for (std::int32_t x = 0; x < bricks; ++x) {
        hyperbrick_.entries[CellInBlock((from >> 2) + GridIndex{x, y, z})] = entry;
      }
    }
  }
  return side == kHyperbrickCells;
}

}  // namespace tandem
