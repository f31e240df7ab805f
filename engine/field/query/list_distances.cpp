// Distances of places from the faces of their cells' lists.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <optional>

#include "engine/field/query/distance_field.h"
#include "engine/field/query/list_pairs.h"

namespace tandem {

namespace {

struct ListQuery {
  std::size_t lane;
  float bound;             // bound of the distance
  std::size_t begin, end;  // range of the pairs
};

/// Returns the signed distance of the nearest face. Among equally near faces, the face that turns
/// most to the place gives the side.
float NearestOf(const ListPairs& pairs, std::size_t begin, std::size_t end) {
  float least = std::numeric_limits<float>::max();
  for (std::size_t k = begin; k < end; ++k) least = std::min(least, pairs.squared[k]);
  const float distance = std::sqrt(least);
  const float most = distance + static_cast<float>(ListPairs::kTie);
  float height = 0;
  bool sheet = false;
  for (std::size_t k = begin; k < end; ++k) {
    if (pairs.squared[k] > most * most || std::abs(pairs.height[k]) <= std::abs(height)) continue;
    height = pairs.height[k];
    sheet = pairs.sheet[k];
  }
  return height < 0 && !sheet ? -distance : distance;
}

}  // namespace

std::optional<DistanceField::List> DistanceField::ListOf(const FieldLanes& lanes,
                                                         std::size_t lane) const {
  return ListOf(bricks_[static_cast<std::size_t>(lanes.entry[lane])], lanes.CellOf(lane));
}

void DistanceField::AddPairs(const List& list, const GridIndex& cell,
                             const std::array<float, 3>& from, ListPairs& pairs) const noexcept {
  const std::array<float, 3> whole{static_cast<float>(cell.x), static_cast<float>(cell.y),
                                   static_cast<float>(cell.z)};
  for (std::size_t byte = 0; byte < list.member_bytes; ++byte) {
    for (std::uint32_t bits = list.members[byte]; bits != 0; bits &= bits - 1) {
      if (!pairs.HasRoomFor(1)) return;
      const std::uint32_t entry =
          list.faces[8 * byte + static_cast<std::size_t>(std::countr_zero(bits))];
      pairs.Add(faces_[entry & ~kSheet], (entry & kSheet) != 0, whole, from);
    }
  }
}

double DistanceField::DistanceToFaces(const List& list, const Cell& cell) const noexcept {
  ListPairs pairs;
  const Vec3f from = cell.from.cast<float>();
  AddPairs(list, cell.cell, {from.x(), from.y(), from.z()}, pairs);
  const std::size_t count = pairs.count;
  MeasureDistances(pairs);
  return NearestOf(pairs, 0, count);
}

void DistanceField::AskLists(const FieldLanes& lanes, float reach,
                             std::span<const PlacedBlock> blocks, float* bounds,
                             FieldReadings* readings) const noexcept {
  ListPairs pairs;
  std::array<ListQuery, FieldLanes::kMost> queries;
  std::size_t count = 0;
  const auto decide = [&](std::size_t lane, float distance) {
    FieldReadings& reading = readings[lane / kBlockPlaces];
    bounds[lane] = distance;
    reading.least = std::min(reading.least, distance);
    if (distance < reach) {
      reading.within = static_cast<std::uint16_t>(reading.within | 1U << lane % kBlockPlaces);
    }
  };
  const bool beyond_fine = reach > fine_band();
  // beyond the band other faces may be nearer; and below its border pushes are interpolated too
  const auto exact_to = static_cast<float>(beyond_fine ? fine_band() : band_);
  const auto tell = [&] {
    MeasureDistances(pairs);
    for (const ListQuery& query : std::span(queries).first(count)) {
      const float distance = NearestOf(pairs, query.begin, query.end);
      decide(query.lane, distance > exact_to ? std::max(query.bound, exact_to) : distance);
    }
    count = 0;
    pairs.count = 0;
  };
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    readings[b].within &= blocks[b].lanes;
    readings[b].listed &= blocks[b].lanes;
    for (unsigned rest = readings[b].listed; rest != 0; rest &= rest - 1) {
      const std::size_t lane = kBlockPlaces * b + static_cast<std::size_t>(std::countr_zero(rest));
      const std::optional<List> list = ListOf(lanes, lane);
      float bound = lanes.value[lane] - static_cast<float>(kListOverStep) * list->over;
      if (beyond_fine) {
        const auto interpolated = lanes.value[lane] - static_cast<float>(most_over_);
        bound = std::min(bound, std::max(static_cast<float>(fine_band()), interpolated));
      }
      const std::size_t most = 8 * list->member_bytes;
      // where there are more faces than room, Pushes() decides
      if (bound >= reach || most > ListPairs::kMost) {
        decide(lane, bound);
        continue;
      }
      if (!pairs.HasRoomFor(most)) tell();
      const std::size_t begin = pairs.count;
      AddPairs(*list, lanes.CellOf(lane), lanes.FromCell(lane), pairs);
      queries[count++] = {lane, bound, begin, pairs.count};
    }
  }
  if (count > 0) tell();
}

}  // namespace tandem
