#include "engine/contact/field/field_pair.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

#include "engine/base/check.h"
#include "engine/contact/features/edge_contact.h"
#include "engine/contact/field/fading.h"
#include "engine/contact/field/fit_reach.h"
#include "engine/contact/field/push_rules.h"

namespace tandem {

namespace {

/// Voxels of depth from which a contact has full damping.
constexpr double kFullDampingDepth = 0.5;
/// Voxels of depth from which a contact counts in full among those that share their stiffness.
constexpr double kFullShareDepth = 0.25;
/// The number of full contacts whose stiffness together is the greatest.
constexpr double kStiffest = 100;
/// The deepest place in the other's surface where a shift and a displacement may let force begin,
/// voxels.
constexpr double kDeepestReach = -1.0;
/// Cosine between a point's inward normal and the direction off a sheet, or a thin wall, from which
/// on a push fades out. Below zero the point has come through.
constexpr double kWallFade = 0.2;
/// The number of features near the other body up to which round surfaces push where they face it,
/// and from which on they do not: a body with so many lies in a hollow, and looking them all up
/// takes long.
constexpr double kFewFeatures = 256;
constexpr double kCrowd = 512;
constexpr std::size_t kMostContacts = std::size_t{1} << 17U;

/// The shell's body as the one that turns: with its own features, or with its field.
FieldSchedule::Centre CentreOf(const BodySurface& shell, bool of_features) {
  const double s = shell.field.voxel_size();
  return {shell.X_BV.Inverse().p / s, of_features, shell.radius / s};
}

}  // namespace

FieldPair::FieldPair(const BodySurface& shell, const BodySurface& map, const Options& options,
                     const ContactGains& gains)
    : shell_(&shell),
      map_(&map),
      s_(map.field.voxel_size()),
      both_move_(options.both_move),
      gains_(gains),
      inward_shift_(options.inward_shift),
      of_shell_(shell.features, map.field, &map.features, CentreOf(shell, true), options.schedule),
      of_map_(map.features, shell.field, nullptr, CentreOf(shell, false), options.schedule),
      contacts_(std::min(kMostContacts,
                         1024 + 2 * (shell.features.point_count() + map.features.point_count()))),
      round_contacts_(shell.rounds, map.rounds, contacts_.size()) {
  TANDEM_CHECK(shell.field.voxel_size() == map.field.voxel_size());
  SetClearance({static_cast<double>(DefaultForceLayer(ContactModel::kRefined)), 0.0});
  reach_ = full_reach_;
}

FieldPair::Places FieldPair::PlacesOf(const BodyMotion& shell_body,
                                      const BodyMotion& map_body) const noexcept {
  Places places;
  const Pose X_WV = map_body.X_WB * map_->X_BV;
  const Pose X_VW = X_WV.Inverse();
  places.pair = {X_VW * shell_body.X_WB, X_WV, shell_body, map_body};
  places.shell_in_map = places.pair.X_VS * shell_->X_BV;
  places.shell_in_map.p /= s_;
  places.map_in_shell = places.shell_in_map.Inverse();
  return places;
}

PairMotion FieldPair::MotionSince(const Pose& X_VS) noexcept {
  const std::optional<Pose> before = std::exchange(X_VS_, X_VS);
  if (!before) return {.way = std::numeric_limits<double>::infinity()};
  constexpr double kRounding = 1 + 1e-9;
  return {.way = (X_VS.p - before->p).norm() / s_ * kRounding,
          .angle = RotationVector(X_VS.q * before->q.conjugate()).norm() * kRounding};
}

PairReport FieldPair::Collide(const BodyMotion& shell_body, const BodyMotion& map_body,
                              LinearizedForce& on_shell, LinearizedForce& on_map) noexcept {
  const Places places = PlacesOf(shell_body, map_body);
  const PairMotion motion = MotionSince(places.pair.X_VS);
  of_shell_.Test(places.shell_in_map, motion, LookUpReach(*shell_, *map_, shell_body.rolls),
                 reach_);
  of_map_.Test(places.map_in_shell, motion, LookUpReach(*map_, *shell_, map_body.rolls), reach_);
  FindContacts(places, shell_body.rolls, map_body.rolls);
  reach_ = FittedReach(contacts(), s_, reach_, full_reach_);
  AddForces(places, on_shell, on_map);
  CountDemand();
  PairReport report;
  report.tests = of_shell_.counts();
  report.tests += of_map_.counts();
  report.contact_points = static_cast<int>(contact_count_);
  report.pushing_points = static_cast<int>(contact_count_);
  report.exact_queries = static_cast<int>(contact_count_);
  report.query_cost = static_cast<double>(contact_count_ + round_queries_);
  report.over_capacity = over_capacity_;
  return report;
}

void FieldPair::Add(const Vec3& p_V, const Vec3& nhat_V, double depth, double share) noexcept {
  if (!(depth > 0 && share > 0)) return;
  if (contact_count_ == contacts_.size()) {
    over_capacity_ = true;
    return;
  }
  contacts_[contact_count_++] = {s_ * p_V, nhat_V, s_ * depth, share};
}

void FieldPair::FindContacts(const Places& places, bool shell_rolls, bool map_rolls) noexcept {
  contact_count_ = 0;
  round_queries_ = 0;
  over_capacity_ = false;
  const Pose& shell_in_map = places.shell_in_map;
  CollideField(of_shell_, {*shell_, *map_, places.shell_in_map, shell_in_map, true,
                           shell_rolls && !shell_->rounds.empty()});
  CollideField(of_map_, {*map_, *shell_, places.map_in_shell, shell_in_map, false,
                         map_rolls && !map_->rounds.empty()});
  CollideEdges(places.shell_in_map);
}

double FieldPair::LookUpReach(const BodySurface& own, const BodySurface& other,
                              bool rolls) const noexcept {
  if (!rolls || own.rounds.empty()) return reach_;
  return std::min(reach_ + own.rounds.most_cap, std::max(reach_, other.field.range()));
}

void FieldPair::CollideField(const FieldSchedule& schedule, const Direction& in) noexcept {
  CollidePoints(schedule, in, false, reach_);
  if (!in.rounds) return;
  double crowd = 0;
  for (const FieldSchedule::NearBlock& near : schedule.near()) crowd += near.count;
  const double strength = Fading(crowd, kFewFeatures, kCrowd);
  const std::size_t first = contact_count_;
  const double reach = strength > 0 ? LookUpReach(in.own, in.other, true) : reach_;
  round_contacts_.Begin(in.own.rounds, in.X_VF, reach - reach_, strength);
  CollidePoints(schedule, in, true, reach);
  if (!(strength > 0)) return;
  CollideFacing(in);
  contact_count_ = round_contacts_.Reduce(std::span(contacts_).first(contact_count_), first);
}

void FieldPair::CollidePoints(const FieldSchedule& schedule, const Direction& in, bool on_rounds,
                              double reach) noexcept {
  const BodyFeatures& features = in.own.features;
  const DistanceField& field = in.other.field;
  const Mat3 R_VF = in.X_VF.q.toRotationMatrix();
  std::array<TouchingPoint, FieldPushes::kMostPlaces> points;
  std::array<Vec3, FieldPushes::kMostPlaces> places_V;
  FieldPushes pushes;
  std::size_t count = 0;
  const auto push = [&] {
    field.Pushes(std::span(places_V).first(count), reach, pushes);
    for (std::size_t k = 0; k < count; ++k) {
      VisitPushes(points[k], places_V[k], pushes.PushesAt(k), field, [&](const FieldPush& on) {
        const std::size_t before = contact_count_;
        AddPush(places_V[k], on, on.share, in);
        if (!on_rounds) return;
        round_contacts_.Take(points[k].round, places_V[k], on, reach_ - on.distance,
                             contact_count_ > before ? before : RoundContacts::kNoContact);
      });
    }
    if (on_rounds) round_queries_ += count;
    count = 0;
  };
  for (const FieldSchedule::NearBlock& near : schedule.near()) {
    for (unsigned rest = reach > reach_ ? near.touching : near.nearer; rest != 0;
         rest &= rest - 1) {
      const auto lane = static_cast<std::size_t>(std::countr_zero(rest));
      const std::uint8_t round =
          in.rounds ? in.own.rounds.RoundOf(near.block, lane) : RoundFeatures::kNone;
      if ((round != RoundFeatures::kNone) != on_rounds) continue;
      const BodyFeatures::Point& point = features.point(near.block, lane);
      places_V[count] = R_VF * features.place(near.block, lane) + in.X_VF.p;
      points[count] = {.inward_V = R_VF * point.inward.cast<double>(), .weight = point.weight};
      if (point.edge != BodyFeatures::kNoEdge) {
        points[count].tangent_V = R_VF * features.edge(point.edge).tangent.cast<double>();
      }
      points[count].round = round;
      if (++count == points.size()) push();
    }
  }
  if (count > 0) push();
}

void FieldPair::CollideFacing(const Direction& in) noexcept {
  const DistanceField& field = in.other.field;
  std::array<RoundContacts::Facing, FieldPushes::kMostPlaces> facing;
  std::array<Vec3, FieldPushes::kMostPlaces> places_V;
  FieldPushes pushes;
  std::size_t count = 0;
  const auto push = [&] {
    field.Pushes(std::span(places_V).first(count), reach_, pushes);
    for (std::size_t k = 0; k < count; ++k) {
      // it is pushed as a feature would be that faces as it does
      VisitPushes({.inward_V = facing[k].away_V, .weight = 1}, places_V[k], pushes.PushesAt(k),
                  field, [&](const FieldPush& on) {
                    const double depth = reach_ - on.distance;
                    AddPush(places_V[k], on, round_contacts_.Deliver(facing[k], on, depth), in);
                  });
    }
    round_queries_ += count;
    count = 0;
  };
  round_contacts_.VisitFacing([&](const RoundContacts::Facing& place) {
    places_V[count] = place.place_V;
    facing[count] = place;
    if (++count == places_V.size()) push();
  });
  if (count > 0) push();
}

void FieldPair::AddPush(const Vec3& place_V, const FieldPush& push, double share,
                        const Direction& in) noexcept {
  const double depth = reach_ - push.distance;
  if (in.to_map) {
    Add(place_V, push.away_V, depth, share);
  } else {
    Add(in.shell_in_map * place_V, -(in.shell_in_map.q * push.away_V), depth, share);
  }
}

template <class Visit>
void FieldPair::VisitPushes(const TouchingPoint& point, const Vec3& place_V,
                            std::span<const FieldPush> pushes, const DistanceField& field,
                            const Visit& visit) noexcept {
  FieldPush inward;
  if (pushes.empty()) {
    const FieldReading reading = field.At(place_V);
    if (reading.near || reading.value >= 0) return;
    // deeper than the field tells the way out: along the point's own normal
    inward = {-DistanceField::kMostNear, point.inward_V, 1.0, false, 1};
    pushes = {&inward, 1};
  }
  for (FieldPush push : pushes) {
    push.share *= point.weight;
    const double facing = push.away_V.dot(point.inward_V);
    if (facing < kWallFade) {
      const std::optional<double> thickness = push.sheet ? 0.0 : Thickness(field, place_V, push);
      if (thickness) {
        push.share *= std::min(1.0, std::abs(facing) / kWallFade);
        if (facing < 0) push = Reversed(push, *thickness);
      }
    }
    if (point.tangent_V) push.share *= ShareOnEdge(push, *point.tangent_V);
    visit(push);
  }
}

void FieldPair::CollideEdges(const Pose& shell_in_map) noexcept {
  const Mat3 R = shell_in_map.q.toRotationMatrix();
  const BodyFeatures& features = shell_->features;
  const double reach = EdgeReach(reach_);
  const auto arc_of = [](float cosine) {
    return cosine > 0 ? EdgeArc::FromCosine(cosine) : LooseArc();
  };
  for (const FieldSchedule::NearBlock& near : of_shell_.near()) {
    for (unsigned rest = near.crossing; rest != 0; rest &= rest - 1) {
      const auto lane = static_cast<std::size_t>(std::countr_zero(rest));
      const BodyFeatures::Edge& edge = features.edge(features.point(near.block, lane).edge);
      const Vec3 p = shell_in_map * edge.middle;
      const Vec3 far = Vec3::Constant(reach + edge.half_length + map_->features.longest_half());
      ShellEdge own;
      bool made = false;
      map_->features.VisitEdgesIn(p - far, p + far, [&](const BodyFeatures::Edge& other) {
        const double apart = reach + edge.half_length + other.half_length;
        if ((other.middle - p).squaredNorm() > apart * apart) return;
        if (!made) {
          own = {p,
                 R * edge.tangent.cast<double>(),
                 -(R * edge.outward.cast<double>()),
                 edge.half_length,
                 arc_of(edge.cosine),
                 edge.ends != 0,
                 0.5};
          made = true;
        }
        Vec3 nhat = other.outward.cast<double>();
        if (other.cosine == 0 && nhat.dot(own.nhat) < 0) nhat = -nhat;
        const EdgeEdgeContact meeting =
            FindEdgeContact(own,
                            {other.middle, other.tangent.cast<double>(), nhat, other.half_length,
                             arc_of(other.cosine), other.ends != 0},
                            reach);
        if (!(meeting.depth > 0 && meeting.share > 0)) return;
        // edges are met as lines with wedges about them, which continue where their faces end
        const FieldReading surface = map_->field.At(meeting.on_shell);
        const double depth = std::min(meeting.depth, reach - surface.value);
        Add(meeting.place, meeting.normal, depth, meeting.share);
      });
    }
  }
}

void FieldPair::AddForces(const Places& places, LinearizedForce& on_shell,
                          LinearizedForce& on_map) noexcept {
  if (contact_count_ == 0) return;
  double area = 0;  // number of contacts, weighted up to full ones
  for (const Contact& contact : contacts()) {
    area += contact.share * std::min(1.0, contact.depth / (kFullShareDepth * s_));
  }
  ForceRule rule{gains_, s_, kFullDampingDepth, kFullStiffnessDepth};
  const double share = std::min(1.0, kStiffest / area);
  rule.gains.stiffness *= share;
  rule.gains.damping *= share;
  const CrossJacobian cross = AddContactForces(std::span(contacts_).first(contact_count_),
                                               places.pair, rule, on_shell, on_map);
  if (both_move_) cross_ = cross;
}

void FieldPair::CountDemand() noexcept {
  demand_.mandatory = of_shell_.due_tests() + of_map_.due_tests();
  demand_.per_metre = (of_shell_.due_tests_per_voxel() + of_map_.due_tests_per_voxel()) / s_;
  demand_.exact_queries = static_cast<double>(contact_count_ + round_queries_);
  demand_.bound = s_ * std::max(FieldSchedule::kMostTravel,
                                std::min(of_shell_.free_travel(), of_map_.free_travel()));
}

void FieldPair::SetClearance(const Clearance& clearance) noexcept {
  clearance_ = clearance;
  const double wanted = kRefinedClearance + clearance.layers -
                        DefaultForceLayer(ContactModel::kRefined) - clearance.displacement / s_ -
                        inward_shift_;
  const double before = std::exchange(
      full_reach_,
      std::clamp(wanted, kDeepestReach, std::min(shell_->field.range(), map_->field.range())));
  // a wider clearance applies at once, but in a tight fit as fast as there is room
  reach_ = reach_ < before ? std::min(reach_, full_reach_) : full_reach_;
}

ClearanceBounds FieldPair::clearance_bounds() const noexcept {
  const double range = std::min(shell_->field.range(), map_->field.range());
  return ClearanceBounds::ForFields(range - kRefinedClearance, s_);
}

std::size_t FieldPair::CountUnfound(const BodyMotion& shell_body,
                                    const BodyMotion& map_body) const {
  const Places places = PlacesOf(shell_body, map_body);
  return of_shell_.CountUnfound(places.shell_in_map) + of_map_.CountUnfound(places.map_in_shell);
}

PoseReading FieldPair::Read(const BodyMotion& shell_body, const BodyMotion& map_body) noexcept {
  const Places places = PlacesOf(shell_body, map_body);
  X_VS_.reset();  // the calendars know of this pose
  const double nearest = std::min(
      of_shell_.Read(places.shell_in_map, LookUpReach(*shell_, *map_, shell_body.rolls), reach_),
      of_map_.Read(places.map_in_shell, LookUpReach(*map_, *shell_, map_body.rolls), reach_));
  FindContacts(places, shell_body.rolls, map_body.rolls);
  PoseReading reading;
  reading.contact_points = static_cast<int>(contact_count_);
  for (const FieldSchedule* schedule : {&of_shell_, &of_map_}) {
    for (const FieldSchedule::NearBlock& near : schedule->near()) {
      reading.touching_points += std::popcount(near.touching);
    }
  }
  reading.nearest_voxels = static_cast<int>(std::max(0.0, std::floor(nearest)));
  LinearizedForce on_map;
  AddForces(places, reading.on_shell, on_map);
  return reading;
}

}  // namespace tandem
