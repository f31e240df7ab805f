#include "engine/field/query/distance_field.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "engine/base/bits.h"
#include "engine/base/check.h"
#include "engine/base/hash.h"
#include "engine/field/query/field_image.h"

namespace tandem {

namespace {

std::size_t InBrick(std::int32_t cell) {
  return static_cast<std::size_t>(cell & (kBrickCells - 1));
}

double Lerp(double low, double high, double share) {
  return low + share * (high - low);
}

/// Interpolates between four values on a square, the second axis slower.
double OnSquare(const std::array<double, 4>& values, double along, double across) {
  return Lerp(Lerp(values[0], values[1], along), Lerp(values[2], values[3], along), across);
}

}  // namespace

DistanceField::DistanceField(ImageBlock block) : block_(std::move(block)) {
  FieldHeader header;
  TANDEM_CHECK(block_.bytes.size() >= sizeof header);
  std::memcpy(&header, block_.bytes.data(), sizeof header);
  const FieldImage::Places places = FieldImage::PlacesOf(header);
  TANDEM_CHECK(block_.bytes.size() == places.bytes);
  voxel_size_ = header.voxel_size;
  band_ = header.band;
  range_ = header.range;
  if (range_ > kLeastRange) most_near_ = range_ + 0.25;
  most_over_ = header.most_over;
  error_bound_ = header.error_bound;
  outer_error_bound_ = header.outer_error_bound;
  origin_ = header.origin;
  size_ = header.size;
  faces_L_.min = Vec3(header.faces_min_L.data());
  faces_L_.max = Vec3(header.faces_max_L.data());
  const auto hyperbricks = static_cast<std::uint64_t>(size_.x) *
                           static_cast<std::uint64_t>(size_.y) *
                           static_cast<std::uint64_t>(size_.z);
  hyperbricks_ = ArrayIn<std::int32_t>(block_.bytes, places.hyperbricks, hyperbricks);
  first_bricks_ = ArrayIn<std::uint32_t>(block_.bytes, places.first_bricks, header.tables);
  tables_ =
      ArrayIn<std::int16_t>(block_.bytes, places.tables, header.tables * kBricksPerHyperbrick + 1);
  bricks_ = ArrayIn<FieldBrick>(block_.bytes, places.bricks, header.bricks);
  steps_ = ArrayIn<std::uint8_t>(block_.bytes, places.steps, header.step_bytes);
  list_faces_ = ArrayIn<std::uint32_t>(block_.bytes, places.list_faces, header.list_faces);
  faces_ = ArrayIn<Face>(block_.bytes, places.faces, header.faces);
}

/// Interpolates between eight values on a cube, x fastest.
double DistanceField::InCube(const std::array<double, 8>& values, const Vec3& from) {
  return Lerp(OnSquare({values[0], values[1], values[2], values[3]}, from.x(), from.y()),
              OnSquare({values[4], values[5], values[6], values[7]}, from.x(), from.y()), from.z());
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
  // no place is below 0, so truncation rounds down
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

FieldReading DistanceField::ReadBound(std::int32_t entry) {
  const double least = kBoundStep * (~entry >> 1);
  return {.value = (~entry & 1) != 0 ? -least : least, .near = false};
}

FieldReading DistanceField::Outside(const Vec3& place_L) const {
  const Vec3 beyond = (faces_L_.min - place_L).cwiseMax(place_L - faces_L_.max).cwiseMax(0.0);
  return {.value = beyond.norm(), .near = false};
}

double DistanceField::ShareOf(const List& list, const Vec3& from) {
  std::array<double, 8> shares;
  for (std::size_t i = 0; i < 8; ++i) shares[i] = list.shares >> i & 1;
  return InCube(shares, from);
}

FieldReading DistanceField::At(const Vec3& place_V) const noexcept {
  const Vec3 place_L = place_V - Vec3::Constant(0.5);
  const Vec3 size_L = kHyperbrickCells * Vec3(size_.x, size_.y, size_.z);
  // written so that NaN lies outside too
  if (!((place_L.array() >= 0).all() && (place_L.array() < size_L.array()).all())) {
    return Outside(place_L);
  }
  const Cell cell = CellOf(place_L);
  const std::int32_t entry = EntryOf(cell.cell);
  if (entry < 0) return ReadBound(entry);
  const FieldBrick& brick = bricks_[static_cast<std::size_t>(entry)];
  const double value = Interpolated(brick, cell);
  const std::optional<List> list = ListOf(brick, cell.cell);
  if (list) {
    return {.value = Lerp(value, DistanceToFaces(*list, cell), ShareOf(*list, cell.from)),
            .near = true};
  }
  if (value <= most_near_ && value >= -kMostNear) return {.value = value, .near = true};
  return {.value = value > 0 ? most_near_ - brick.Over() : outer_error_bound_ - kMostNear,
          .near = false};
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
