#include "engine/contact/field/touch_query.h"

#include <algorithm>
#include <array>
#include <bit>

#include "engine/base/check.h"

namespace tandem {

namespace {

/// The number of blocks whose middles are looked up together.
constexpr std::size_t kTogether = 64;

Vec3 MiddleOf(const BodyFeatures::Block& block) {
  return {static_cast<double>(block.middle.x), static_cast<double>(block.middle.y),
          static_cast<double>(block.middle.z)};
}

/// Places of V, relative to its origin, and a field's results at them.
template <std::size_t kMost>
struct Places {
  std::array<float, kMost> x{}, y{}, z{};
  std::array<float, kMost> values;
  std::array<float, kMost> over;
  std::array<std::int32_t, kMost> kinds;

  void Set(std::size_t i, const Vec3& place_V) noexcept {
    x[i] = static_cast<float>(place_V.x());
    y[i] = static_cast<float>(place_V.y());
    z[i] = static_cast<float>(place_V.z());
  }
  void LookUpAll(const DistanceField& field, std::size_t count) noexcept {
    field.Values({0, 0, 0}, {x.data(), y.data(), z.data()}, (count + 15) / 16 * 16, values.data(),
                 kinds.data(), over.data());
  }
};

}  // namespace

TouchQuery::TouchQuery(const BodySurface& one, const BodySurface& other)
    : s_(one.field.voxel_size()),
      bodies_{&one, &other},
      sides_{Side{.features = &one.features, .field = &other.field, .chunks = {}},
             Side{.features = &other.features, .field = &one.field, .chunks = {}}} {
  TANDEM_CHECK(one.field.voxel_size() == other.field.voxel_size());
  for (Side& side : sides_) side.chunks.reserve(side.features->chunks().size());
}

std::optional<Vec3> TouchQuery::Find(const Pose& X_WA, const Pose& X_WB) noexcept {
  const std::array<Pose, 2> X_WV{X_WA * bodies_[0]->X_BV, X_WB * bodies_[1]->X_BV};
  for (std::size_t i = 0; i < 2; ++i) {
    const Pose X_VF = X_WV[1 - i].Inverse() * X_WV[i];
    sides_[i].R_VF = X_VF.q.toRotationMatrix();
    sides_[i].p_VF = X_VF.p / s_;
  }
  const auto in_world = [&](std::size_t side, const Vec3& place_F) -> Vec3 {
    return X_WV[side] * Vec3(s_ * place_F);
  };
  if (witness_) {
    const Side& side = sides_[witness_->side];
    const FieldReading reading = side.field->At(side.R_VF * witness_->place_F + side.p_VF);
    if (reading.value <= kTouching) return in_world(witness_->side, witness_->place_F);
  }
  witness_.reset();
  for (Side& side : sides_) FindChunks(side);
  // the side that may be deeper first
  const auto depth_of = [this](std::size_t i) {
    return sides_[i].chunks.empty() ? 0.0F : sides_[i].chunks.front().first;
  };
  const std::size_t first = depth_of(1) < depth_of(0) ? 1 : 0;
  for (const std::size_t side : {first, 1 - first}) {
    const std::optional<Vec3> place_F = FindIn(sides_[side]);
    if (!place_F) continue;
    witness_ = Witness{side, *place_F};
    return in_world(side, *place_F);
  }
  return std::nullopt;
}

void TouchQuery::FindChunks(Side& side) const noexcept {
  side.chunks.clear();
  const std::span<const BodyFeatures::Chunk> chunks = side.features->chunks();
  Places<kTogether> places;
  for (std::size_t begin = 0; begin < chunks.size(); begin += kTogether) {
    const std::size_t count = std::min(kTogether, chunks.size() - begin);
    for (std::size_t i = 0; i < count; ++i) {
      places.Set(i, side.R_VF * chunks[begin + i].middle + side.p_VF);
    }
    places.LookUpAll(*side.field, count);
    for (std::size_t i = 0; i < count; ++i) {
      const float least = places.values[i] - places.over[i] -
                          static_cast<float>(chunks[begin + i].radius + kTouching);
      if (least <= 0) side.chunks.emplace_back(least, static_cast<std::uint32_t>(begin + i));
    }
  }
  std::sort(side.chunks.begin(), side.chunks.end());
}

std::optional<Vec3> TouchQuery::FindIn(const Side& side) const noexcept {
  Places<kTogether> places;
  for (const auto& [least, number] : side.chunks) {
    const BodyFeatures::Chunk& chunk = side.features->chunks()[number];
    for (std::uint32_t begin = 0; begin < chunk.count; begin += kTogether) {
      const std::size_t count = std::min<std::size_t>(kTogether, chunk.count - begin);
      const auto block_at = [&](std::size_t i) {
        return chunk.first + begin + static_cast<std::uint32_t>(i);
      };
      for (std::size_t i = 0; i < count; ++i) {
        const Vec3 middle = MiddleOf(side.features->blocks()[block_at(i)]);
        places.Set(i, side.R_VF * middle + side.p_VF);
      }
      places.LookUpAll(*side.field, count);
      for (std::size_t i = 0; i < count; ++i) {
        const double radius = side.features->blocks()[block_at(i)].radius + kTouching;
        if (places.values[i] - places.over[i] > radius) continue;
        if (const auto place_F = FindInBlock(side, block_at(i))) return place_F;
      }
    }
  }
  return std::nullopt;
}

std::optional<Vec3> TouchQuery::FindInBlock(const Side& side, std::uint32_t block) const noexcept {
  const BodyFeatures& features = *side.features;
  for (unsigned rest = features.blocks()[block].lanes; rest != 0; rest &= rest - 1) {
    const auto lane = static_cast<std::size_t>(std::countr_zero(rest));
    const Vec3 place_F = features.place(block, lane);
    const std::uint32_t number = features.point(block, lane).edge;
    if (number == BodyFeatures::kNoEdge) {
      if (side.field->At(side.R_VF * place_F + side.p_VF).value <= kTouching) return place_F;
      continue;
    }
    const BodyFeatures::Edge& edge = features.edge(number);
    const Vec3 half_F = edge.half_length * edge.tangent.cast<double>();
    if (const auto found = FindOnEdge(side, edge.middle, half_F)) return found;
  }
  return std::nullopt;
}

std::optional<Vec3> TouchQuery::FindOnEdge(const Side& side, const Vec3& middle_F,
                                           const Vec3& half_F) const noexcept {
  const Vec3 middle_V = side.R_VF * middle_F + side.p_VF;
  const double half = half_F.norm();
  Places<16> place;
  place.Set(0, middle_V);
  place.LookUpAll(*side.field, 1);
  if (place.values[0] - place.over[0] > half + kTouching) return std::nullopt;
  const FieldReading reading = side.field->At(middle_V);
  if (reading.value <= kTouching) return middle_F;
  const bool in_band = reading.value < side.field->band();
  if (in_band && reading.value - side.field->error_bound() > half) return std::nullopt;
  if (half < kTouching) return std::nullopt;
  const Vec3 quarter_F = 0.5 * half_F;
  if (const auto found = FindOnEdge(side, middle_F - quarter_F, quarter_F)) return found;
  return FindOnEdge(side, middle_F + quarter_F, quarter_F);
}

}  // namespace tandem
