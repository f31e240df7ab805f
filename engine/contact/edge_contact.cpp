#include "engine/contact/edge_contact.h"

#include <algorithm>
#include <cmath>

namespace tandem {

namespace {

/// Sine of the angle between two edges below which they are taken as parallel.
constexpr double kParallel = 0.15;
/// Rad: how far beyond the arc between an edge's two faces a push fades out.
constexpr double kArcFade = 0.15;
const double kFadeCosine = std::cos(kArcFade);
const double kFadeSine = std::sin(kArcFade);
/// Voxels: how far a piece of an edge, whose ends are known to a hundredth, reaches into the next.
/// They share what lies there.
constexpr double kSeam = 0.05;
/// Voxels: the most that a slack can be, when what is three voxels away is not looked at.
constexpr double kMostTravel = 1.6;
/// Of the two edges' normals along the way they push each other, least sum: contacts have 0.3.
constexpr double kSides = 0.2;

/// How much of a push counts so many voxels from the end of an edge.
double ShareFromEnd(double from) {
  constexpr double kFade = 0.5;
  return std::clamp(from / kFade, 0.0, 1.0);
}

/// And so many from the end of a piece, which another goes on from.
double ShareOfPiece(double from) {
  return std::clamp(0.5 + 0.5 * from / kSeam, 0.0, 1.0);
}

/// An edge seen along its line: its faces' normals lie in an arc round its own.
struct Wedge {
  Vec3 normal;
  double half;  // of the arc, rad
};
struct Leaning {
  Vec3 normal = Vec3::Zero();
  double share = 0;
};

/// How an edge leans on another along the same line `t`, `away` from it: along the direction in
/// both arcs that parts them most, which is how far apart two wedges are.
Leaning LeanOnParallel(const Vec3& t, const Vec3& away, const Wedge& below, const Wedge& above) {
  const Vec3 e1 = (below.normal - below.normal.dot(t) * t).normalized();
  const Vec3 e2 = t.cross(e1);
  const double turn = std::atan2(above.normal.dot(e2), above.normal.dot(e1));
  double low = std::max(-below.half, turn - above.half);
  double high = std::min(below.half, turn + above.half);
  Leaning leaning;
  leaning.share = std::clamp(1.0 - (low - high) / kArcFade, 0.0, 1.0);
  if (low > high) low = high = 0.5 * (low + high);
  const double x = away.dot(e1);
  const double y = away.dot(e2);
  double best = std::atan2(y, x);
  if (best < low || best > high) {
    const bool lower =
        x * std::cos(low) + y * std::sin(low) > x * std::cos(high) + y * std::sin(high);
    best = lower ? low : high;
  }
  leaning.normal = std::cos(best) * e1 + std::sin(best) * e2;
  return leaning;
}

}  // namespace

EdgeArc::EdgeArc(double half_angle)
    : half(half_angle),
      cosine(std::cos(half_angle)),
      sine(std::sin(half_angle)),
      last(std::cos(half_angle + kArcFade)),
      scale(1.0 / (cosine - last)) {}

EdgeArc EdgeArc::OfCosine(double cosine) {
  EdgeArc arc;
  arc.cosine = cosine;
  arc.sine = std::sqrt(std::max(0.0, 1.0 - cosine * cosine));
  arc.last = cosine * kFadeCosine - arc.sine * kFadeSine;
  arc.scale = 1.0 / (arc.cosine - arc.last);
  return arc;
}

double EdgeArc::ShareOf(double push_cosine) const noexcept {
  return std::clamp((push_cosine - last) * scale, 0.0, 1.0);
}

EdgeMeeting Meet(const ShellEdge& edge, const SurfaceDetail& detail, const Vec3& q, bool ends,
                 const EdgeArc& other_arc, double turn, double enough) noexcept {
  EdgeMeeting meeting;
  // of a thin sheet's edge only that it passes through the voxel is known
  const bool two_sided = detail.half_length == SurfaceDetail::kTwoSided;
  const double other_end = two_sided ? 0.5 : detail.half_length / 128.0;
  const double other_half = other_end + kSeam;
  const double half = edge.half + kSeam;
  const Vec3& t = edge.tangent;
  const Vec3 other_t = UnpackDirection(detail.tangent);
  const Vec3 away = edge.p - q;
  const double cosine = t.dot(other_t);
  const double square_sine = std::max(0.0, 1.0 - cosine * cosine);
  const double along = away.dot(t);
  const double other_along = away.dot(other_t);
  const bool parallel = square_sine < kParallel * kParallel;
  // an edge about to become parallel, or no longer, is looked at again
  const double margin = kMostTravel * turn;
  const auto square = [](double x) {
    return x * x;
  };
  const bool may_change = square_sine > square(std::max(0.0, kParallel - margin)) &&
                          square_sine < square(kParallel + margin);

  // most edges nearby are not beside this one, which takes least to tell
  double u = 0;  // the places on both lines where they come closest: p + u t, q + v t'
  double v = other_along;
  double beside = std::abs(other_along) - other_half;  // voxels to go until they are
  if (!parallel) {
    const double sine = std::sqrt(square_sine);
    u = (cosine * other_along - along) / square_sine;
    v = (other_along - cosine * along) / square_sine;
    const double past = std::max(std::abs(u) - half, std::abs(v) - other_half);
    const double reach = std::abs(along) + std::abs(other_along) + half + other_half;
    beside = std::max({sine * past / (1.0 + 2.0 * turn * reach / sine),
                       std::abs(along) - half - other_half * std::abs(cosine),
                       std::abs(other_along) - other_half - half * std::abs(cosine)});
  }
  if (may_change) beside = std::min(beside, 0.0);
  meeting.slack = beside;
  const bool apart = std::abs(u) > half || std::abs(v) > other_half;
  if (apart && (may_change || beside >= enough)) return meeting;

  const Vec3 n = FacingNormal(detail, edge.nhat);
  if (!(n.dot(edge.nhat) > kFacing)) return meeting;
  double gap = 0;
  double share = 0;
  double swing = 1.0;  // of the gap's change by turns
  if (parallel) {
    // side by side: each part of the shell's edge rests on the part of the map's beside it
    const Leaning leaning =
        LeanOnParallel(t, away, {n, other_arc.half}, {edge.nhat, std::acos(edge.arc.cosine)});
    meeting.normal = leaning.normal;
    meeting.place = edge.p;
    gap = away.dot(leaning.normal);
    share = leaning.share;
  } else {
    meeting.normal = t.cross(other_t).normalized();
    const double side = meeting.normal.dot(n + edge.nhat);
    if (side < 0) meeting.normal = -meeting.normal;
    meeting.place = 0.5 * (edge.p + u * t + q + v * other_t);
    gap = away.dot(meeting.normal);
    swing = 1.0 / std::sqrt(square_sine);
    // both bodies' material must lie behind the plane between the edges
    share =
        other_arc.ShareOf(meeting.normal.dot(n)) * edge.arc.ShareOf(meeting.normal.dot(edge.nhat));
    if (edge.ends) share *= ShareFromEnd(u + edge.half);
    if (ends) share *= ShareFromEnd(v + other_end);
    // where the sides may swap, the gap says nothing
    if (std::abs(side) < kSides + margin * swing) return meeting;
  }
  if (!edge.ends || u > 0) share *= ShareOfPiece(edge.half - std::abs(u));
  if (!ends || v > 0) share *= ShareOfPiece(other_end - std::abs(v));
  const double above = (gap - kRefinedClearance) / (1.0 + turn * swing * away.norm());
  if (!may_change) meeting.slack = std::max(beside, above);
  if (!apart) meeting.depth = std::max(0.0, (kRefinedClearance - gap) * share);
  return meeting;
}

}  // namespace tandem
