#include "engine/contact/features/feature_image.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "engine/base/check.h"

namespace tandem {

namespace {

/// The greatest count of blocks, edges and cells, which 32 bits hold.
constexpr std::uint64_t kMost = std::numeric_limits<std::int32_t>::max();
/// The greatest distance of places from V's origin, voxels: no sum of them exceeds 32 bits.
constexpr std::int32_t kFarthest = 1 << 28;

std::uint64_t CellsOf(const GridIndex& count) {
  return static_cast<std::uint64_t>(count.x) * static_cast<std::uint64_t>(count.y) *
         static_cast<std::uint64_t>(count.z);
}

bool IsNear(const GridIndex& place) {
  const auto near = [](std::int32_t along) {
    return along >= -kFarthest && along <= kFarthest;
  };
  return near(place.x) && near(place.y) && near(place.z);
}

template <typename Vector>
bool IsPlace(const Vector& place) {
  // written so that NaN is no place
  return (place.array().abs() <= kFarthest).all();
}

bool IsLength(double length) {
  return length >= 0 && length <= kFarthest;
}

template <typename T>
void Put(const std::vector<T>& array, std::uint64_t place, ImageBytes& image) {
  if (array.empty()) return;
  std::memcpy(image.data() + place, array.data(), array.size() * sizeof(T));
}

}  // namespace

FeatureImage::Places FeatureImage::PlacesOf(const FeatureHeader& header) {
  ArrayLayout arrays(sizeof header);
  Places places{};
  places.blocks = arrays.Add(header.blocks, sizeof(BodyFeatures::Block));
  places.lanes = arrays.Add(header.blocks, sizeof(BodyFeatures::Lanes));
  places.points = arrays.Add(header.blocks, BodyFeatures::kLanes * sizeof(BodyFeatures::Point));
  places.chunks = arrays.Add(header.chunks, sizeof(BodyFeatures::Chunk));
  places.edges = arrays.Add(header.edges, sizeof(BodyFeatures::Edge));
  places.slots = arrays.Add(header.slots, sizeof(BodyFeatures::Slot));
  places.edges_by_cell = arrays.Add(header.edges, sizeof(std::uint32_t));
  places.edge_distances = arrays.Add(CellsOf(header.cell_count), 1);
  places.bytes = arrays.bytes();
  return places;
}

BodyFeatures FeatureImage::Pack(const Parts& parts) {
  FeatureHeader header = parts.header;
  header.blocks = parts.blocks.size();
  header.chunks = parts.chunks.size();
  header.edges = parts.edges.size();
  header.slots = parts.slots.size();
  TANDEM_CHECK(parts.lanes.size() == header.blocks &&
               parts.points.size() == BodyFeatures::kLanes * header.blocks &&
               parts.edges_by_cell.size() == header.edges &&
               parts.edge_distances.size() == CellsOf(header.cell_count));
  const Places places = PlacesOf(header);
  header.bytes = places.bytes;
  auto image = std::make_shared<ImageBytes>(places.bytes);
  std::memcpy(image->data(), &header, sizeof header);
  Put(parts.blocks, places.blocks, *image);
  Put(parts.lanes, places.lanes, *image);
  Put(parts.points, places.points, *image);
  Put(parts.chunks, places.chunks, *image);
  Put(parts.edges, places.edges, *image);
  Put(parts.slots, places.slots, *image);
  Put(parts.edges_by_cell, places.edges_by_cell, *image);
  Put(parts.edge_distances, places.edge_distances, *image);
  const std::span<const std::byte> bytes(image->data(), image->size());
  return BodyFeatures({std::move(image), bytes});
}

std::optional<BodyFeatures> FeatureImage::Read(ImageBlock block) {
  if (block.bytes.size() < sizeof(FeatureHeader)) return std::nullopt;
  FeatureHeader header;
  std::memcpy(&header, block.bytes.data(), sizeof header);
  if (!IsSound(header) || header.bytes != block.bytes.size() ||
      PlacesOf(header).bytes != header.bytes) {
    return std::nullopt;
  }
  BodyFeatures features(std::move(block));
  const bool sound =
      BlocksAreSound(features) && ChunksAreSound(features) && EdgesAreSound(features);
  return sound ? std::optional(std::move(features)) : std::nullopt;
}

bool FeatureImage::IsSound(const FeatureHeader& header) {
  const auto is_count = [](std::int32_t count) {
    return count >= 0 && count <= 1 << 20;
  };
  return IsLength(header.longest_half) && IsNear(header.first_cell) &&
         is_count(header.cell_count.x) && is_count(header.cell_count.y) &&
         is_count(header.cell_count.z) && CellsOf(header.cell_count) <= kMost &&
         header.blocks <= kMost / BodyFeatures::kLanes && header.chunks <= kMost &&
         header.edges <= kMost && header.slots <= 2 * kMost && std::has_single_bit(header.slots);
}

bool FeatureImage::BlocksAreSound(const BodyFeatures& features) {
  std::size_t points = 0;
  for (std::size_t b = 0; b < features.blocks_.size(); ++b) {
    const BodyFeatures::Block& block = features.blocks_[b];
    if (!IsNear(block.middle) || !IsLength(block.radius) || (block.sharp & ~block.lanes) != 0) {
      return false;
    }
    points += static_cast<std::size_t>(std::popcount(block.lanes));
    const BodyFeatures::Lanes& lanes = features.lanes_[b];
    for (std::size_t lane = 0; lane < BodyFeatures::kLanes; ++lane) {
      const BodyFeatures::Point& point = features.point(b, lane);
      const bool is_sharp = (block.sharp >> lane & 1) != 0;
      const bool has_edge = point.edge < features.edges_.size();
      if (!IsPlace(Vec3f(lanes.x[lane], lanes.y[lane], lanes.z[lane])) || !IsPlace(point.inward) ||
          !IsLength(point.weight) || (!has_edge && point.edge != BodyFeatures::kNoEdge) ||
          (is_sharp && !has_edge)) {
        return false;
      }
    }
  }
  return points == features.point_count_;
}

bool FeatureImage::ChunksAreSound(const BodyFeatures& features) {
  std::size_t next = 0;
  for (std::size_t c = 0; c < features.chunks_.size(); ++c) {
    const BodyFeatures::Chunk& chunk = features.chunks_[c];
    if (!IsPlace(chunk.middle) || !IsLength(chunk.radius) || chunk.first != next ||
        chunk.count == 0 || chunk.count > kMostBlocks ||
        next + chunk.count > features.blocks_.size()) {
      return false;
    }
    for (const BodyFeatures::Block& block : features.blocks_.subspan(next, chunk.count)) {
      if (block.chunk != c) return false;
    }
    next += chunk.count;
  }
  return next == features.blocks_.size();
}

bool FeatureImage::EdgesAreSound(const BodyFeatures& features) {
  for (const BodyFeatures::Edge& edge : features.edges_) {
    if (!IsPlace(edge.middle) || !IsPlace(edge.tangent) || !IsPlace(edge.outward) ||
        !IsLength(edge.half_length) || !std::isfinite(edge.cosine) || edge.ends > 1) {
      return false;
    }
  }
  for (const std::uint32_t edge : features.edges_by_cell_) {
    if (edge >= features.edges_.size()) return false;
  }
  // a search ends at a free slot
  bool has_free = false;
  for (const BodyFeatures::Slot& slot : features.slots_) {
    if (std::uint64_t{slot.first} + slot.count > features.edges_by_cell_.size()) return false;
    has_free = has_free || slot.count == 0;
  }
  return has_free;
}

}  // namespace tandem
