#include "engine/contact/field/round_contacts.h"

#include <algorithm>
#include <cmath>

#include "engine/contact/field/fading.h"

namespace tandem {

namespace {

/// Cosine of the angle between a push and its nearest face's normal: a push off a face, and off an
/// edge or a corner.
constexpr double kOffFace = 0.985;
constexpr double kOffEdge = 0.940;
/// Sine of the angle between a push and a cylinder's axis from which on its side pushes, and up to
/// which its end does.
constexpr double kOnSide = 0.35;
constexpr double kOnEnd = 0.20;
/// Cosine of the angle between the directions of one side.
constexpr double kOneSide = 0.94;
/// Cosine of the angle from the facing place beyond which a feature may have come through a wall.
constexpr double kTowards = 0.2;
/// The sum of the weights of features with which a side pushes in full.
constexpr double kFullWeight = 0.1;

}  // namespace

void RoundContacts::Begin(const RoundFeatures& features, const Pose& X_VF) noexcept {
  features_ = &features;
  side_count_ = 0;
  for (std::size_t r = 0; r < features.rounds.size(); ++r) {
    const RoundSurface& surface = features.rounds[r].surface;
    placed_[r] = {X_VF * surface.centre, X_VF.q * surface.axis};
    sides_of_[r] = 0;
  }
}

void RoundContacts::Take(std::uint8_t round, const Vec3& place_V, const FieldPush& push,
                         std::size_t contact) noexcept {
  if (contact != kNoContact) taken_[contact] = {};
  const RoundFeatures::Round& own = features_->rounds[round];
  const Placed& placed = placed_[round];
  const double share_of_face = push.sheet ? 0.0 : Fading(push.facing, kOffFace, kOffEdge);
  Vec3 from = place_V - placed.centre_V;
  const double along = from.dot(placed.axis_V);
  from -= along * placed.axis_V;
  const Vec3 across = push.away_V - push.away_V.dot(placed.axis_V) * placed.axis_V;
  const double sine = across.norm();
  const double share =
      share_of_face * (own.surface.is_sphere() ? 1.0 : Fading(sine, kOnSide, kOnEnd));
  if (share <= 0) return;
  // the feature's height over the place that faces the other body
  const double cosine = -from.dot(across) / (from.norm() * sine);
  if (!(cosine > kTowards)) return;
  const double height = own.surface.radius * (1.0 - cosine);
  const double near = std::max(0.0, 1.0 - height / own.cap);
  const double weight = near * near * share * push.share;

  std::size_t s = 0;
  while (s < side_count_ &&
         !(sides_[s].round == round && sides_[s].first_V.dot(push.away_V) > kOneSide)) {
    ++s;
  }
  if (s == side_count_) {
    if (s == kMostSides) return;
    sides_[side_count_++] = {.round = round, .first_V = push.away_V, .low = along, .high = along};
    ++sides_of_[round];
  }
  Side& side = sides_[s];
  side.sum_V += weight * push.away_V;
  side.weight += weight;
  side.low = std::min(side.low, along);
  side.high = std::max(side.high, along);
  if (contact != kNoContact) taken_[contact] = {static_cast<std::int32_t>(s), share};
}

double RoundContacts::Strength(std::size_t side) const noexcept {
  const Side& of = sides_[side];
  if (sides_of_[of.round] > kMostSidesOfOne) return 0;
  return std::min(1.0, of.weight / kFullWeight);
}

std::size_t RoundContacts::Reduce(std::span<Contact> contacts, std::size_t first) const noexcept {
  std::size_t kept = first;
  for (std::size_t i = first; i < contacts.size(); ++i) {
    Contact contact = contacts[i];
    if (taken_[i].side >= 0) {
      contact.share *= 1.0 - taken_[i].share * Strength(static_cast<std::size_t>(taken_[i].side));
    }
    if (contact.share > 0) contacts[kept++] = contact;
  }
  return kept;
}

RoundContacts::Row RoundContacts::RowOf(const Side& side) const noexcept {
  const RoundSurface& surface = features_->rounds[side.round].surface;
  const Placed& placed = placed_[side.round];
  Row row;
  row.away_V = side.sum_V.normalized();
  const Vec3 across = row.away_V - row.away_V.dot(placed.axis_V) * placed.axis_V;
  const Vec3 middle_V = placed.centre_V - surface.radius * across.normalized();
  row.begin_V = middle_V;
  row.step_V = Vec3::Zero();
  if (surface.is_sphere()) return row;
  // places at most a voxel apart, the first and the last on the rims
  const double steps = std::max(1.0, std::ceil(2 * surface.half_length));
  const double step = 2 * surface.half_length / steps;
  row.begin_V = middle_V - surface.half_length * placed.axis_V;
  row.step_V = step * placed.axis_V;
  const auto number = [&](double along) {
    return std::clamp((along + surface.half_length) / step, 0.0, steps);
  };
  row.first = static_cast<std::size_t>(std::floor(number(side.low - 1)));
  row.end = static_cast<std::size_t>(std::ceil(number(side.high + 1))) + 1;
  return row;
}

double RoundContacts::ShareOf(const Facing& facing, const FieldPush& push) noexcept {
  if (push.sheet || push.away_V.dot(facing.away_V) < kTowards) return 0;
  return facing.share * push.share * Fading(push.facing, kOffFace, kOffEdge);
}

}  // namespace tandem
