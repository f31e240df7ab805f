#include "engine/field/distance_field.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "engine/base/bits.h"
#include "engine/base/hash.h"

namespace tandem {

namespace {

std::size_t InBrick(std::int32_t cell) {
  return static_cast<std::size_t>(cell & (kBrickCells - 1));
}

double Between(double low, double high, double share) {
  return low + share * (high - low);
}

/// Interpolates between four values on a square, the second axis slower.
double OnSquare(const std::array<double, 4>& values, double along, double across) {
  return Between(Between(values[0], values[1], along), Between(values[2], values[3], along),
                 across);
}

std::int32_t Axis(const GridIndex& index, std::size_t axis) {
  return axis == 0 ? index.x : (axis == 1 ? index.y : index.z);
}

GridIndex Shifted(GridIndex index, std::size_t axis, std::int32_t by) {
  (axis == 0 ? index.x : (axis == 1 ? index.y : index.z)) += by;
  return index;
}

}  // namespace

/// Interpolates between eight values on a cube, x fastest.
double DistanceField::InCube(const std::array<double, 8>& values, const Vec3& from) {
  return Between(OnSquare({values[0], values[1], values[2], values[3]}, from.x(), from.y()),
                 OnSquare({values[4], values[5], values[6], values[7]}, from.x(), from.y()),
                 from.z());
}

double DistanceField::Interpolated(const FieldBrick& brick, const Cell& cell) const {
  const std::uint8_t* steps = &steps_[brick.steps];
  std::array<double, 8> nodes;
  for (std::size_t i = 0; i < 8; ++i) {
    nodes[i] = NodeValue(brick, steps, InBrick(cell.cell.x) + (i & 1),
                         InBrick(cell.cell.y) + (i >> 1 & 1), InBrick(cell.cell.z) + (i >> 2));
  }
  return InCube(nodes, cell.from);
}

DistanceField::Cell DistanceField::CellOf(const Vec3& place_L) {
  // no place is below 0, so that to cut off is to round down
  const GridIndex cell{static_cast<std::int32_t>(place_L.x()),
                       static_cast<std::int32_t>(place_L.y()),
                       static_cast<std::int32_t>(place_L.z())};
  return {cell, place_L - Vec3(cell.x, cell.y, cell.z)};
}

std::int32_t DistanceField::EntryOf(const GridIndex& cell) const noexcept {
  const GridIndex hyperbrick = cell >> 5;
  const std::int32_t entry = hyperbricks_[static_cast<std::size_t>(
      hyperbrick.x + size_.x * (hyperbrick.y + size_.y * hyperbrick.z))];
  if (entry < 0) return entry;
  const auto table = static_cast<std::size_t>(entry);
  const std::int32_t in_table = tables_[table * kBricksPerHyperbrick + CellInBlock(cell >> 2)];
  return in_table < 0 ? in_table : static_cast<std::int32_t>(first_bricks_[table]) + in_table;
}

std::int32_t DistanceField::BoundEntry(double least, bool inside) {
  const double most = kMostBoundSteps;
  const auto steps = static_cast<std::int32_t>(std::clamp(least / kBoundStep, 0.0, most));
  return ~(2 * steps + (inside ? 1 : 0));
}

FieldReading DistanceField::OfBound(std::int32_t entry) {
  const double least = kBoundStep * (~entry >> 1);
  return {.value = (~entry & 1) != 0 ? -least : least, .near = false};
}

FieldReading DistanceField::Outside(const Vec3& place_L) const {
  const Vec3 beyond = (faces_L_.min - place_L).cwiseMax(place_L - faces_L_.max).cwiseMax(0.0);
  return {.value = beyond.norm(), .near = false};
}

FieldReading DistanceField::At(const Vec3& place_V) const {
  return Look(place_V, false).reading;
}

FieldGradient DistanceField::WithGradient(const Vec3& place_V) const {
  return Look(place_V, true);
}

FieldGradient DistanceField::Look(const Vec3& place_V, bool with_gradient) const {
  const Vec3 place_L = place_V - Vec3::Constant(0.5);
  const Vec3 size_L = kHyperbrickCells * Vec3(size_.x, size_.y, size_.z);
  // written so that a place that is no number lies outside too
  if (!((place_L.array() >= 0).all() && (place_L.array() < size_L.array()).all())) {
    return {.reading = Outside(place_L)};
  }
  const Cell cell = CellOf(place_L);
  const std::int32_t entry = EntryOf(cell.cell);
  if (entry < 0) return {.reading = OfBound(entry)};
  const FieldBrick& brick = bricks_[static_cast<std::size_t>(entry)];
  FieldGradient look{.reading = {.value = Interpolated(brick, cell), .near = true}};
  const std::optional<List> list = ListOf(brick, cell.cell);
  const double value = look.reading.value;
  if (!list && (value > most_near_ || value < -kMostNear)) {
    look.reading = {.value = value > 0 ? most_near_ - brick.Over() : outer_error_bound_ - kMostNear,
                    .near = false};
    return look;
  }
  if (with_gradient) look.gradient = GradientAt(brick, cell, place_L);
  if (!list) return look;
  std::array<double, 8> shares;
  for (std::size_t i = 0; i < 8; ++i) shares[i] = list->shares >> i & 1;
  const double share = InCube(shares, cell.from);
  const FieldGradient exact = OfList(*list, place_L);
  look.reading.value = Between(look.reading.value, exact.reading.value, share);
  look.gradient += share * (exact.gradient - look.gradient);
  return look;
}

Vec3 DistanceField::GradientAt(const FieldBrick& brick, const Cell& cell,
                               const Vec3& place_L) const {
  const std::uint8_t* steps = &steps_[brick.steps];
  const std::array<std::size_t, 3> low{InBrick(cell.cell.x), InBrick(cell.cell.y),
                                       InBrick(cell.cell.z)};
  std::array<double, 8> corners;
  for (std::size_t i = 0; i < 8; ++i) {
    corners[i] =
        NodeValue(brick, steps, low[0] + (i & 1), low[1] + (i >> 1 & 1), low[2] + (i >> 2));
  }
  Vec3 gradient;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t u = (axis + 1) % 3;
    const std::size_t v = (axis + 2) % 3;
    const auto a = static_cast<Eigen::Index>(axis);
    // the two distances whose middles the place lies between meet at the nearest node: one is the
    // cell's own, the other is to the node beyond
    const bool upper = cell.from[a] >= 0.5;
    const double share = place_L[a] - (Axis(cell.cell, axis) + (upper ? 1 : 0)) + 0.5;
    const std::int32_t beyond = static_cast<std::int32_t>(low[axis]) + (upper ? 2 : -1);
    const bool in_brick = beyond >= 0 && beyond <= kBrickCells;
    std::array<double, 4> slopes;
    for (std::size_t i = 0; i < 4; ++i) {
      const std::size_t corner = (i & 1) << u | (i >> 1) << v;
      const double own = corners[corner | std::size_t{1} << axis] - corners[corner];
      std::array<std::size_t, 3> at{low[0] + (corner & 1), low[1] + (corner >> 1 & 1),
                                    low[2] + (corner >> 2)};
      double outer = own;  // one side of the outermost node is enough where the band ends
      const double node = upper ? corners[corner | std::size_t{1} << axis] : corners[corner];
      if (in_brick) {
        at[axis] = static_cast<std::size_t>(beyond);
        const double value = NodeValue(brick, steps, at[0], at[1], at[2]);
        outer = upper ? value - node : node - value;
      } else {
        GridIndex there = Shifted(Shifted(cell.cell, u, static_cast<std::int32_t>(i & 1)), v,
                                  static_cast<std::int32_t>(i >> 1));
        there = Shifted(there, axis, upper ? 2 : -1);
        if (const std::optional<double> value = NodeBeyond(there, cell.cell)) {
          outer = upper ? *value - node : node - *value;
        }
      }
      slopes[i] = upper ? Between(own, outer, share) : Between(outer, own, share);
    }
    gradient[a] = OnSquare(slopes, cell.from[static_cast<Eigen::Index>(u)],
                           cell.from[static_cast<Eigen::Index>(v)]);
  }
  return gradient;
}

std::optional<double> DistanceField::NodeBeyond(const GridIndex& node,
                                                const GridIndex& cell) const {
  // along the two other axes the node may be the last of the cell's own row of bricks
  GridIndex in = node;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const bool ahead = Axis(node, axis) == (Axis(cell, axis) & ~(kBrickCells - 1)) + kBrickCells;
    if (ahead) in = Shifted(in, axis, -1);
  }
  if (in.x < 0 || in.y < 0 || in.z < 0 || in.x >= kHyperbrickCells * size_.x ||
      in.y >= kHyperbrickCells * size_.y || in.z >= kHyperbrickCells * size_.z) {
    return std::nullopt;
  }
  const std::int32_t entry = EntryOf(in);
  if (entry < 0) return std::nullopt;
  const FieldBrick& brick = bricks_[static_cast<std::size_t>(entry)];
  return NodeValue(brick, &steps_[brick.steps],
                   InBrick(in.x) + static_cast<std::size_t>(node.x - in.x),
                   InBrick(in.y) + static_cast<std::size_t>(node.y - in.y),
                   InBrick(in.z) + static_cast<std::size_t>(node.z - in.z));
}

std::optional<DistanceField::List> DistanceField::ListOf(const FieldBrick& brick,
                                                         const GridIndex& cell) const {
  if ((brick.flags & FieldBrick::kHasLists) == 0) return std::nullopt;
  const std::uint8_t* end = &steps_[brick.steps - sizeof(FieldLists)];
  FieldLists lists;
  std::memcpy(&lists, end, sizeof lists);
  const std::size_t bit = InBrick(cell.x) + 4 * InBrick(cell.y) + 16 * InBrick(cell.z);
  if ((lists.cells >> bit & 1U) == 0) return std::nullopt;
  const std::size_t before = CountBits(lists.cells & ((std::uint64_t{1} << bit) - 1));
  const std::uint8_t* list = end - (before + 1) * lists.ListBytes();
  return List{&list_faces_[lists.first_face], list + 2, lists.ListBytes() - 2, list[0], list[1]};
}

DistanceField::Sizes DistanceField::Count() const {
  Sizes sizes;
  sizes.bricks = bricks_.size();
  for (const FieldBrick& brick : bricks_) {
    if (brick.bits == 0) ++sizes.flat_bricks;
    if ((brick.flags & FieldBrick::kHasLists) == 0) continue;
    FieldLists lists;
    std::memcpy(&lists, &steps_[brick.steps - sizeof lists], sizeof lists);
    const std::size_t cells = CountBits(lists.cells);
    sizes.listed_cells += cells;
    sizes.list_bytes += sizeof lists + cells * lists.ListBytes();
  }
  sizes.list_faces = list_faces_.size();
  sizes.faces = faces_.size();
  sizes.table_bytes = (hyperbricks_.size() + first_bricks_.size()) * sizeof(std::int32_t) +
                      tables_.size() * sizeof(std::int16_t);
  sizes.brick_bytes = bricks_.size() * sizeof(FieldBrick) + steps_.size() - sizes.list_bytes;
  sizes.list_bytes += list_faces_.size() * sizeof(std::uint32_t) + faces_.size() * sizeof(Face);
  return sizes;
}

std::uint64_t DistanceField::Digest() const {
  Hash64 hash;
  hash.Add(voxel_size_);
  hash.Add(band_);
  hash.Add(range_);
  hash.Add(error_bound_);
  hash.Add(outer_error_bound_);
  hash.Add(origin_.x);
  hash.Add(origin_.y);
  hash.Add(origin_.z);
  const auto add = [&hash](const auto& all) {
    hash.AddBytes(all.data(), all.size() * sizeof(*all.data()));
  };
  add(hyperbricks_);
  add(first_bricks_);
  add(tables_);
  add(bricks_);
  add(steps_);
  add(list_faces_);
  add(faces_);
  return hash.value();
}

}  // namespace tandem
