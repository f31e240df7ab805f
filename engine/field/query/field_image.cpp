#include "engine/field/query/field_image.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include <tbb/parallel_for.h>

#include "engine/base/check.h"

namespace tandem {

namespace {

/// The kernel counts words of bricks, corners of faces and bytes in 32 bits.
constexpr std::uint64_t kMost = std::numeric_limits<std::int32_t>::max();
constexpr std::uint64_t kMostTables = kMost / (sizeof(std::int16_t) * kBricksPerHyperbrick);
constexpr std::uint64_t kMostBricks = kMost / 4;
constexpr std::uint64_t kMostFaces = kMost / 9;
constexpr std::int32_t kMostSide = 1 << 16;  // hyperbricks
/// The bytes that the kernel reads at a step, and at the last entry of a table.
constexpr std::uint64_t kStepRead = 4;

std::uint64_t HyperbricksOf(const GridIndex& size) {
  return static_cast<std::uint64_t>(size.x) * static_cast<std::uint64_t>(size.y) *
         static_cast<std::uint64_t>(size.z);
}

bool IsFinite(double value) {
  return std::isfinite(value);
}

/// Copies an array to its place and frees it.
template <typename T>
void Put(std::vector<T>& array, std::uint64_t place, ImageBytes& image) {
  if (!array.empty()) std::memcpy(image.data() + place, array.data(), array.size() * sizeof(T));
  std::vector<T>().swap(array);
}

}  // namespace

FieldImage::Places FieldImage::PlacesOf(const FieldHeader& header) {
  ArrayLayout arrays(sizeof header);
  Places places{};
  places.hyperbricks = arrays.Add(HyperbricksOf(header.size), sizeof(std::int32_t));
  places.first_bricks = arrays.Add(header.tables, sizeof(std::uint32_t));
  places.tables = arrays.Add(header.tables * kBricksPerHyperbrick + 1, sizeof(std::int16_t));
  places.bricks = arrays.Add(header.bricks, sizeof(FieldBrick));
  places.steps = arrays.Add(header.step_bytes, 1);
  places.list_faces = arrays.Add(header.list_faces, sizeof(std::uint32_t));
  places.faces = arrays.Add(header.faces, sizeof(DistanceField::Face));
  places.bytes = arrays.bytes();
  return places;
}

DistanceField FieldImage::Pack(Parts parts) {
  FieldHeader& header = parts.header;
  TANDEM_CHECK(parts.hyperbricks.size() == HyperbricksOf(header.size));
  // the kernel reads four bytes at each pair of nodes and at each entry
  parts.steps.resize(parts.steps.size() + kStepRead);
  parts.tables.resize(parts.tables.size() + 1);
  header.tables = parts.first_bricks.size();
  header.bricks = parts.bricks.size();
  header.step_bytes = parts.steps.size();
  header.list_faces = parts.list_faces.size();
  header.faces = parts.faces.size();
  const Places places = PlacesOf(header);
  header.bytes = places.bytes;
  auto image = std::make_shared<ImageBytes>(places.bytes);
  std::memcpy(image->data(), &header, sizeof header);
  Put(parts.hyperbricks, places.hyperbricks, *image);
  Put(parts.first_bricks, places.first_bricks, *image);
  Put(parts.tables, places.tables, *image);
  Put(parts.bricks, places.bricks, *image);
  Put(parts.steps, places.steps, *image);
  Put(parts.list_faces, places.list_faces, *image);
  Put(parts.faces, places.faces, *image);
  const std::span<const std::byte> bytes(image->data(), image->size());
  return DistanceField({std::move(image), bytes});
}

std::optional<DistanceField> FieldImage::Read(ImageBlock block) {
  if (block.bytes.size() < sizeof(FieldHeader)) return std::nullopt;
  FieldHeader header;
  std::memcpy(&header, block.bytes.data(), sizeof header);
  if (!IsSound(header) || header.bytes != block.bytes.size() ||
      PlacesOf(header).bytes != header.bytes) {
    return std::nullopt;
  }
  DistanceField field(std::move(block));
  const bool sound = TablesAreSound(field) && FacesAreSound(field) && BricksAreSound(field);
  return sound ? std::optional(std::move(field)) : std::nullopt;
}

bool FieldImage::IsSound(const FieldHeader& header) {
  const auto is_side = [](std::int32_t side) {
    return side > 0 && side <= kMostSide;
  };
  const auto is_length = [](double length) {
    return IsFinite(length) && length >= 0;
  };
  bool box = true;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    box = box && IsFinite(header.faces_min_L[axis]) && IsFinite(header.faces_max_L[axis]) &&
          header.faces_min_L[axis] <= header.faces_max_L[axis];
  }
  return box && is_side(header.size.x) && is_side(header.size.y) && is_side(header.size.z) &&
         HyperbricksOf(header.size) <= kMost && header.tables <= kMostTables && header.bricks > 0 &&
         header.bricks <= kMostBricks && header.step_bytes >= kStepRead &&
         header.step_bytes <= kMost && header.list_faces <= kMost && header.faces <= kMostFaces &&
         IsFinite(header.voxel_size) && header.voxel_size > 0 && is_length(header.band) &&
         is_length(header.range) && is_length(header.error_bound) &&
         is_length(header.outer_error_bound) && is_length(header.most_over);
}

bool FieldImage::TablesAreSound(const DistanceField& field) {
  const auto tables = static_cast<std::int64_t>(field.first_bricks_.size());
  for (const std::int32_t entry : field.hyperbricks_) {
    if (entry >= tables) return false;
  }
  for (std::size_t t = 0; t < field.first_bricks_.size(); ++t) {
    for (const std::int16_t entry :
         field.tables_.subspan(t * kBricksPerHyperbrick, kBricksPerHyperbrick)) {
      const auto number = std::uint64_t{field.first_bricks_[t]} +
                          static_cast<std::uint64_t>(std::max<int>(entry, 0));
      if (entry >= 0 && number >= field.bricks_.size()) return false;
    }
  }
  return true;
}

bool FieldImage::FacesAreSound(const DistanceField& field) {
  // faces lie in the box, and values compared with their distances are right to a ten-thousandth
  const Vec3f most = static_cast<float>(kHyperbrickCells) *
                     Vec3f(static_cast<float>(field.size_.x), static_cast<float>(field.size_.y),
                           static_cast<float>(field.size_.z));
  for (const DistanceField::Face& face : field.faces_) {
    for (const Vec3f& corner : face) {
      const bool inside = (corner.array() >= -1).all() && (corner.array() <= most.array()).all();
      if (!inside) return false;
    }
  }
  return std::ranges::all_of(field.list_faces_, [&field](std::uint32_t entry) {
    return (entry & ~DistanceField::kSheet) < field.faces_.size();
  });
}

bool FieldImage::BricksAreSound(const DistanceField& field) {
  std::atomic<bool> sound{true};
  constexpr std::size_t kTogether = 4096;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, field.bricks_.size(), kTogether),
                    [&](const tbb::blocked_range<std::size_t>& range) {
                      for (std::size_t i = range.begin(); i < range.end(); ++i) {
                        if (!IsSound(field, field.bricks_[i])) sound = false;
                      }
                    });
  return sound;
}

bool FieldImage::IsSound(const DistanceField& field, const FieldBrick& brick) {
  const std::uint64_t last = brick.steps + (kBrickNodes - 1) * std::uint64_t{brick.bits} / 8;
  if (!IsFinite(brick.mean) || brick.bits > FieldBrick::kMostBits ||
      last + kStepRead > field.steps_.size()) {
    return false;
  }
  return (brick.flags & FieldBrick::kHasLists) == 0 || ListsAreSound(field, brick);
}

bool FieldImage::ListsAreSound(const DistanceField& field, const FieldBrick& brick) {
  if (brick.steps < sizeof(FieldLists)) return false;
  const std::size_t end = brick.steps - sizeof(FieldLists);
  FieldLists lists;
  std::memcpy(&lists, &field.steps_[end], sizeof lists);
  const auto cells = static_cast<std::size_t>(std::popcount(lists.cells));
  if (cells * lists.ListBytes() > end ||
      std::uint64_t{lists.first_face} + lists.faces > field.list_faces_.size()) {
    return false;
  }
  for (std::size_t k = 1; k <= cells; ++k) {
    // one bit for each of the brick's faces, and at least one set: the kernel reads the nearest
    // face
    const std::span<const std::uint8_t> members =
        field.steps_.subspan(end - k * lists.ListBytes() + 2, lists.ListBytes() - 2);
    if (std::ranges::all_of(members, [](std::uint8_t byte) {
          return byte == 0;
        })) {
      return false;
    }
    if (lists.faces % 8 != 0 && members.back() >> lists.faces % 8 != 0) return false;
  }
  return true;
}

}  // namespace tandem
