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
/// The sum of the weights of features with which facing places replace them in full.
constexpr double kFullWeight = 0.1;
/// The number of directions, as spread over the lattice, up to which facing places count, and from
/// which on they do not. A round surface that lies in a hollow touches all round.
constexpr double kFewWays = 16;
constexpr double kAllRound = 32;
/// Depths up to which a facing place replaces features in full, and from which on not at all, for
/// deep in a body many places hold it better than one.
constexpr double kShallow = 0.5;
constexpr double kDeep = 1.0;
/// The share of the cap within which features are looked up that lets facing places push, and that
/// with which they push in full.
constexpr double kBlind = 0.6;
/// The most layers along a cylinder. In longer ones they are farther apart than a voxel.
constexpr double kMostLayers = 65;
/// Voxels along a cylinder within which a feature tells of contact. Features lie up to three apart.
constexpr double kTellsOf = 4;
/// The share of a contact that is the rounding of nothing.
constexpr double kRounding = 1e-9;
/// Cosine of the angle between directions that count as one. A larger angle would be felt on
/// slopes.
constexpr double kSame = 1 - 1e-7;

/// Returns how much two directions are one and the same: nothing from 45 degrees between them on.
double Alike(const Vec3& one, const Vec3& other) {
  constexpr double kOfTheirOwn = 1.0 - 0.70710678118654752;
  return std::clamp(1.0 - (1.0 - one.dot(other)) / kOfTheirOwn, 0.0, 1.0);
}

}  // namespace

RoundContacts::RoundContacts(const RoundFeatures& one, const RoundFeatures& other,
                             std::size_t contacts) {
  std::size_t groups = 0;
  std::size_t nodes = 0;
  std::size_t features = 0;
  for (const RoundFeatures* body : {&one, &other}) {
    std::size_t of_body = 0;
    std::size_t layers = 0;
    for (const RoundFeatures::Round& round : body->rounds) {
      of_body += round.surface.is_sphere() ? 1 : LayersOf(round.surface);
      layers += LayersOf(round.surface);
    }
    groups = std::max(groups, of_body);
    nodes = std::max(nodes, layers * kSide * kSide);
    const auto points =
        static_cast<std::size_t>(std::ranges::count_if(body->of_point, [](std::uint8_t round) {
          return round != RoundFeatures::kNone;
        }));
    features = std::max(features, points);
  }
  nodes_.resize(nodes);
  heads_.assign(groups, kNone);
  round_of_.resize(groups);
  groups_.reserve(groups);
  weighty_.reserve(nodes);
  most_taken_ = std::min({contacts, 2 * features, kMostTaken});
  taken_.reserve(most_taken_);
}

std::uint32_t RoundContacts::LayersOf(const RoundSurface& surface) noexcept {
  if (surface.is_sphere()) return kSide;
  return static_cast<std::uint32_t>(
      std::clamp(std::ceil(2 * surface.half_length) + 1, 2.0, kMostLayers));
}

void RoundContacts::Begin(const RoundFeatures& features, const Pose& X_VF, double wide,
                          double strength) noexcept {
  features_ = &features;
  for (const std::uint32_t node : weighty_) nodes_[node] = {};
  for (const std::uint32_t group : groups_) heads_[group] = kNone;
  weighty_.clear();
  groups_.clear();
  taken_.clear();
  std::uint32_t node = 0;
  std::uint32_t group = 0;
  for (std::size_t r = 0; r < features.rounds.size(); ++r) {
    const RoundFeatures::Round& round = features.rounds[r];
    Placed& placed = placed_[r];
    placed.centre_V = X_VF * round.surface.centre;
    placed.axis_V = X_VF.q * round.surface.axis;
    placed.side_V = X_VF.q * round.side;
    placed.cap = std::min(round.cap, wide);
    placed.strength = strength * Fading(placed.cap / round.cap, 1.0, kBlind);
    placed.first_node = node;
    placed.first_group = group;
    placed.layers = LayersOf(round.surface);
    placed.step = 2 * round.surface.half_length / (placed.layers - 1);
    node += placed.layers * kSide * kSide;
    const std::uint32_t groups = round.surface.is_sphere() ? 1 : placed.layers;
    for (std::uint32_t g = 0; g < groups; ++g) {
      round_of_[group++] = static_cast<std::uint8_t>(r);
    }
  }
}

RoundContacts::Splat RoundContacts::SplatOf(std::uint8_t round, const Vec3& direction_V,
                                            double along) const noexcept {
  const RoundSurface& surface = features_->rounds[round].surface;
  const Placed& placed = placed_[round];
  constexpr double kHalf = 0.5 * kCells;
  Vec3 at = kHalf * (direction_V + Vec3::Ones());
  if (!surface.is_sphere()) {
    const Vec3 other_V = placed.axis_V.cross(placed.side_V);
    at = {kHalf * (direction_V.dot(placed.side_V) + 1.0), kHalf * (direction_V.dot(other_V) + 1.0),
          (along + surface.half_length) / placed.step};
  }
  std::array<std::uint32_t, 3> low{};
  const std::array<std::uint32_t, 3> most{kSide, kSide, placed.layers};
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    const double last = most[i] - 1;
    at[axis] = std::clamp(at[axis], 0.0, last);
    low[i] = static_cast<std::uint32_t>(std::min(std::floor(at[axis]), last - 1));
    at[axis] -= low[i];
  }
  Splat splat;
  for (std::uint32_t corner = 0; corner < 8; ++corner) {
    const std::array<std::uint32_t, 3> up{corner & 1U, corner >> 1U & 1U, corner >> 2U};
    splat.nodes[corner] =
        placed.first_node + ((low[2] + up[2]) * kSide + low[1] + up[1]) * kSide + low[0] + up[0];
    double share = 1;
    for (std::size_t i = 0; i < 3; ++i) {
      const double from = at[static_cast<Eigen::Index>(i)];
      share *= up[i] != 0 ? from : 1.0 - from;
    }
    splat.shares[corner] = share;
  }
  return splat;
}

std::uint32_t RoundContacts::GroupOf(std::uint8_t round, std::uint32_t node) const noexcept {
  const Placed& placed = placed_[round];
  if (features_->rounds[round].surface.is_sphere()) return placed.first_group;
  return placed.first_group + (node - placed.first_node) / (kSide * kSide);
}

void RoundContacts::AddWeight(std::uint8_t round, double weight, const Vec3& direction_V,
                              double along) noexcept {
  const RoundSurface& surface = features_->rounds[round].surface;
  const Placed& placed = placed_[round];
  if (surface.is_sphere()) {
    AddTo(round, SplatOf(round, direction_V, 0), 0, weight, direction_V);
    return;
  }
  const double last = placed.layers - 1;
  const double at = std::clamp((along + surface.half_length) / placed.step, 0.0, last);
  const double reach = std::max(1.0, kTellsOf / placed.step);
  const Splat first = SplatOf(round, direction_V, -surface.half_length);
  const auto end = static_cast<std::uint32_t>(std::min(last, std::floor(at + reach)));
  for (auto layer = static_cast<std::uint32_t>(std::max(0.0, std::ceil(at - reach))); layer <= end;
       ++layer) {
    const double near = 1.0 - std::abs(layer - at) / reach;
    AddTo(round, first, layer * kSide * kSide, near * weight, direction_V);
  }
}

void RoundContacts::AddTo(std::uint8_t round, const Splat& splat, std::uint32_t farther,
                          double weight, const Vec3& direction_V) noexcept {
  for (std::size_t corner = 0; corner < splat.nodes.size(); ++corner) {
    const double added = weight * splat.shares[corner];
    if (!(added > 0)) continue;
    const std::uint32_t n = splat.nodes[corner] + farther;
    Node& node = nodes_[n];
    if (!(node.weight > 0)) {
      node.group = GroupOf(round, n);
      if (heads_[node.group] == kNone) groups_.push_back(node.group);
      node.next = heads_[node.group];
      heads_[node.group] = n;
      weighty_.push_back(n);
    }
    node.weight += added;
    node.sum_V += added * direction_V;
  }
}

void RoundContacts::Take(std::uint8_t round, const Vec3& place_V, const FieldPush& push,
                         double depth, std::size_t contact) noexcept {
  const RoundFeatures::Round& own = features_->rounds[round];
  const Placed& placed = placed_[round];
  if (push.sheet || !(placed.strength > 0)) return;
  Vec3 from = place_V - placed.centre_V;
  const double along = from.dot(placed.axis_V);
  from -= along * placed.axis_V;
  Vec3 direction_V = push.away_V - push.away_V.dot(placed.axis_V) * placed.axis_V;
  const double sine = direction_V.norm();
  const bool ball = own.surface.is_sphere();
  const double share =
      Fading(push.facing, kOffFace, kOffEdge) * (ball ? 1.0 : Fading(sine, kOnSide, kOnEnd));
  if (!(share > 0)) return;
  direction_V /= sine;
  if (contact != kNoContact && taken_.size() < most_taken_) {
    taken_.push_back({contact, round, share, depth, direction_V, along});
  }
  // the feature's height over the place that faces the other body
  const double height = own.surface.radius * (1.0 + from.dot(direction_V) / from.norm());
  const double near = std::max(0.0, 1.0 - height / placed.cap);
  AddWeight(round, near * near * share * push.share, direction_V, along);
}

void RoundContacts::Unite(std::uint32_t group) noexcept {
  for (std::uint32_t n = heads_[group]; n != kNone; n = nodes_[n].next) {
    const Vec3 direction = nodes_[n].sum_V.normalized();
    std::uint32_t m = heads_[group];
    while (m != n && !(nodes_[m].counts_as == m &&
                       nodes_[m].sum_V.dot(direction) > kSame * nodes_[m].sum_V.norm())) {
      m = nodes_[m].next;
    }
    nodes_[n].counts_as = m;
    if (m == n) continue;
    nodes_[m].sum_V += nodes_[n].sum_V;
    nodes_[m].weight += nodes_[n].weight;
  }
}

void RoundContacts::Share(std::uint32_t group) noexcept {
  double sum = 0;
  double squares = 0;
  for (std::uint32_t n = heads_[group]; n != kNone; n = nodes_[n].next) {
    sum += nodes_[n].weight;
    squares += nodes_[n].weight * nodes_[n].weight;
  }
  const std::uint8_t round = round_of_[group];
  const double strength =
      placed_[round].strength * Fading(sum * sum, kFewWays * squares, kAllRound * squares);
  if (!(strength > 0)) return;
  Unite(group);
  for (std::uint32_t n = heads_[group]; n != kNone; n = nodes_[n].next) {
    if (nodes_[n].counts_as == n) nodes_[n].sum_V.normalize();
  }
  for (std::uint32_t n = heads_[group]; n != kNone; n = nodes_[n].next) {
    Node& node = nodes_[n];
    if (node.counts_as != n) continue;
    double all = 0;
    for (std::uint32_t m = heads_[group]; m != kNone; m = nodes_[m].next) {
      if (nodes_[m].counts_as != m) continue;
      all += nodes_[m].weight * Alike(node.sum_V, nodes_[m].sum_V);
    }
    const double least = std::max(all, kFullWeight);
    node.share = strength * node.weight / least;
    node.fullness = strength * all / least;
  }
}

RoundContacts::Facing RoundContacts::FacingAt(std::uint32_t node) const noexcept {
  const Node& at = nodes_[node];
  const std::uint8_t round = round_of_[at.group];
  const RoundSurface& surface = features_->rounds[round].surface;
  const Placed& placed = placed_[round];
  Vec3 place_V = placed.centre_V - surface.radius * at.sum_V;
  if (!surface.is_sphere()) {
    const double layer = at.group - placed.first_group;
    place_V += (layer * placed.step - surface.half_length) * placed.axis_V;
  }
  return {place_V, at.sum_V, node, at.share};
}

double RoundContacts::Deliver(const Facing& facing, const FieldPush& push, double depth) noexcept {
  if (push.sheet) return 0;
  const double part = push.share * Fading(push.facing, kOffFace, kOffEdge) *
                      Alike(push.away_V, facing.away_V) * Fading(depth, kShallow, kDeep);
  if (!(depth > 0 && part > 0)) return 0;
  Node& node = nodes_[facing.node];
  node.delivered += node.fullness * part;
  node.delivered_depth += node.fullness * part * depth;
  return facing.share * part;
}

std::size_t RoundContacts::Reduce(std::span<Contact> contacts, std::size_t first) const noexcept {
  for (const Taken& taken : taken_) {
    const Splat splat = SplatOf(taken.round, taken.direction_V, taken.along);
    double replaced = 0;
    for (std::size_t corner = 0; corner < splat.nodes.size(); ++corner) {
      const Node& there = nodes_[splat.nodes[corner]];
      if (there.counts_as == kNone) continue;
      const Node& node = nodes_[there.counts_as];
      replaced +=
          splat.shares[corner] * std::min(node.delivered, node.delivered_depth / taken.depth);
    }
    const double left = 1.0 - taken.share * std::min(1.0, replaced);
    contacts[taken.contact].share *= left > kRounding ? left : 0.0;
  }
  std::size_t kept = first;
  for (std::size_t i = first; i < contacts.size(); ++i) {
    if (contacts[i].share > 0) contacts[kept++] = contacts[i];
  }
  return kept;
}

}  // namespace tandem
