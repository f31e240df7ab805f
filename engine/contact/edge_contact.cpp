#include "engine/contact/edge_contact.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace tandem {

namespace {

/// Rad: how far beyond the arc between an edge's two faces a push fades out.
constexpr double kArcFade = 0.15;
const double kFadeCosine = std::cos(kArcFade);
const double kFadeSine = std::sin(kArcFade);
/// The half arc of a loose edge, rad.
constexpr double kLooseArc = 1.25;
/// Voxels over which a push fades out as pieces side by side come to be a voxel apart.
constexpr double kBesideFade = 0.25;
/// How much farther the normal of edges side by side may turn than the bodies.
constexpr double kLeaningTurn = 3.0;

/// How much of a push counts so many voxels from the end of an edge.
double ShareFromEnd(double from, double fade) {
  return std::clamp(from / fade, 0.0, 1.0);
}

/// And so many from the end of a piece, which another goes on from.
double ShareOfPiece(double from) {
  return std::clamp(0.5 + 0.5 * from / kSeam, 0.0, 1.0);
}

/// And of a piece `away` from another along the same line, and `gap` above it along the normal.
/// Edges side by side are about as near along the whole of their faces, and pieces a voxel apart
/// are looked at or not as the point's voxel has it: so a push is gone by then, or it would come
/// and go at once. How deep they are is not held against them.
double ShareBeside(const Vec3& away, const Vec3& normal, double gap) {
  const double height = std::clamp(gap, -kRefinedClearance, kRefinedClearance);
  const Vec3 apart = away + (height - gap) * normal;
  return std::clamp((1.0 - apart.cwiseAbs().maxCoeff()) / kBesideFade, 0.0, 1.0);
}

/// A vector in the plane across a line, of length 1 a direction or a rotation: cosine and sine.
struct Rotation {
  double cosine;
  double sine;

  Rotation Times(const Rotation& other) const {
    return {cosine * other.cosine - sine * other.sine, sine * other.cosine + cosine * other.sine};
  }
  Rotation Inverse() const { return {cosine, -sine}; }
  /// None of a vector without a length.
  Rotation Unit() const {
    const double length = std::sqrt(Dot(*this));
    if (length == 0) return {1, 0};
    return {cosine / length, sine / length};
  }
  /// The sine of the angle from this to the other, times their lengths.
  double Cross(const Rotation& other) const { return cosine * other.sine - sine * other.cosine; }
  double Dot(const Rotation& other) const { return cosine * other.cosine + sine * other.sine; }
};

/// An edge seen along its line: its faces' normals lie in an arc round its own, half of which is
/// at most a right angle.
struct Wedge {
  Vec3 normal;
  Rotation half;
};
struct Leaning {
  Vec3 normal = Vec3::Zero();
  double share = 0;
};

/// The directions in both of two arcs, from `low` to `high`. Where arcs do not meet, both are the
/// middle of the gap between them, and `share` of a push fades as it widens.
struct BothArcs {
  Rotation low;
  Rotation high;
  double share = 1.0;
};

/// One arc lies about 0, the other about `turn`.
BothArcs CommonOf(const Rotation& half, const Rotation& turn, const Rotation& other_half) {
  // whether `turn` is more than an angle of at most a right angle
  const auto is_beyond = [&turn](const Rotation& angle) {
    return turn.cosine < 0 ? turn.sine > 0 : angle.Cross(turn) > 0;
  };
  const Rotation difference = half.Times(other_half.Inverse());
  BothArcs common;
  common.low = is_beyond(difference.Inverse()) ? turn.Times(other_half.Inverse()) : half.Inverse();
  common.high = is_beyond(difference) ? half : turn.Times(other_half);
  const Rotation sum = half.Times(other_half);
  if (turn.cosine >= sum.cosine) return common;
  const double gap =
      std::atan2(std::abs(turn.sine), turn.cosine) - std::atan2(sum.sine, sum.cosine);
  common.share = std::clamp(1.0 - gap / kArcFade, 0.0, 1.0);
  const Rotation middle{common.low.cosine + common.high.cosine, common.low.sine + common.high.sine};
  common.low = common.high = middle.Unit();
  return common;
}

/// How an edge leans on another along the same line `t`, `away` from it: along the direction in
/// both arcs that parts them most, which is how far apart two wedges are.
Leaning LeanOnParallel(const Vec3& t, const Vec3& away, const Wedge& below, const Wedge& above) {
  const Vec3 e1 = (below.normal - below.normal.dot(t) * t).normalized();
  const Vec3 e2 = t.cross(e1);
  const Rotation turn = Rotation{above.normal.dot(e1), above.normal.dot(e2)}.Unit();
  const BothArcs common = CommonOf(below.half, turn, above.half);
  const Rotation way{away.dot(e1), away.dot(e2)};
  const bool between = common.low.Cross(way) > 0 && way.Cross(common.high) > 0;
  const bool lower = common.low.Dot(way) > common.high.Dot(way);
  const Rotation best = between ? way.Unit() : lower ? common.low : common.high;
  return {best.cosine * e1 + best.sine * e2, common.share};
}

/// Two pieces of edges, voxels: the shell's through p along t, the map's through q along t'.
struct Pieces {
  const ShellEdge& edge;
  Vec3 other_t;
  Vec3 n;     // outward, of the map's, on the side that the shell's faces
  Vec3 away;  // p - q
  double other_end;
  double half;        // with what it reaches into the next
  double other_half;  // as well
  double cosine;      // between t and t'
  double sine;
  double along;         // away, along t
  double other_along;   // along t'
  double facing;        // cosine between the ways in which they push
  double least_across;  // facing of edges that cross and push one another, at least
};

/// What one way of meeting says.
struct Way {
  bool apart = false;
  bool pushes = false;
  double u = 0;  // the places on both lines where they come closest: p + u t, q + v t'
  double v = 0;
  Vec3 normal = Vec3::Zero();
  double gap = 0;
  double share = 0;
};

/// Side by side: each part of the shell's edge rests on the part of the map's beside it.
Way BesideOne(const Pieces& pieces, const EdgeArc& other_arc, ClearRegionMaker* clear, double way) {
  const ShellEdge& edge = pieces.edge;
  Way met;
  met.v = pieces.other_along;
  const double beside = std::abs(met.v) - pieces.other_half;
  met.apart = beside > 0;
  way = std::max(way, beside);
  if (clear != nullptr && way >= clear->reach()) clear = nullptr;
  if (met.apart && clear == nullptr) return met;
  met.pushes = pieces.facing > kFacing;
  if (!met.pushes && clear == nullptr) return met;
  const Leaning leaning =
      LeanOnParallel(edge.tangent, pieces.away, {pieces.n, {other_arc.cosine, other_arc.sine}},
                     {edge.nhat, {edge.arc.cosine, edge.arc.sine}});
  met.normal = leaning.normal;
  met.gap = pieces.away.dot(leaning.normal);
  met.share = leaning.share;
  if (clear != nullptr) {
    // the normal stays square to the shell's edge; across it, it may turn farther
    const double along = std::abs(pieces.along);
    const double across = (pieces.away - pieces.along * edge.tangent - met.gap * met.normal).norm();
    const double reach = clear->reach();
    const double swing =
        along + kLeaningTurn * (across + reach) +
        0.5 * kLeaningTurn * kLeaningTurn * clear->turn() * (std::abs(met.gap) + reach);
    clear->KeepAbove(met.normal, met.gap - kRefinedClearance, swing, way);
  }
  return met;
}

/// Voxels that the point of the shell may go while crossing edges stay beside each other, whose
/// bodies turn by up to `turn`: the places where they come closest run along by 1 / sine.
double BesideCrossing(const Pieces& pieces, const Way& met, double sine, double turn,
                      double reach) {
  const double away = pieces.away.norm() + reach;
  const auto past = [&](double at, double half, double arm) {
    return sine * (std::abs(at) - half) - turn * arm / sine - 2 * turn * std::abs(at);
  };
  const double cosine = std::abs(pieces.cosine);
  return std::max({past(met.u, pieces.half, away),
                   past(met.v, pieces.other_half, away + std::abs(pieces.along) + reach),
                   std::abs(pieces.along) - pieces.half - pieces.other_half * cosine -
                       turn * (away + pieces.other_half),
                   std::abs(pieces.other_along) - pieces.other_half - pieces.half * cosine -
                       turn * pieces.half});
}

/// One across the other: along the way that is square to both.
Way AcrossOne(const Pieces& pieces, const EdgeArc& other_arc, ClearRegionMaker* clear, double way) {
  const ShellEdge& edge = pieces.edge;
  const double square_sine = pieces.sine * pieces.sine;
  Way met;
  met.u = (pieces.cosine * pieces.other_along - pieces.along) / square_sine;
  met.v = (pieces.other_along - pieces.cosine * pieces.along) / square_sine;
  met.apart = std::abs(met.u) > pieces.half || std::abs(met.v) > pieces.other_half;
  double least_sine = 0;
  if (clear != nullptr) {
    least_sine = pieces.sine - clear->turn();
    way = std::max(way, BesideCrossing(pieces, met, least_sine, clear->turn(), clear->reach()));
    if (way >= clear->reach()) clear = nullptr;
  }
  if (met.apart && clear == nullptr) return met;
  met.pushes = pieces.facing > pieces.least_across;
  if (!met.pushes && clear == nullptr) return met;
  met.normal = edge.tangent.cross(pieces.other_t).normalized();
  const double side = met.normal.dot(pieces.n + edge.nhat);
  if (side < 0) met.normal = -met.normal;
  met.gap = pieces.away.dot(met.normal);
  // both bodies' material must lie behind the plane between the edges
  met.share =
      other_arc.ShareOf(met.normal.dot(pieces.n)) * edge.arc.ShareOf(met.normal.dot(edge.nhat));
  if (std::abs(side) < kSides) met.pushes = false;
  if (clear == nullptr) return met;
  // the normal turns about the map's edge, from where the shell's is at most u from it
  const double turned = 1.05 * clear->turn() / least_sine;
  if (std::abs(side) < 2 * turned + clear->turn()) {
    clear->KeepWithin(way);  // where the sides may swap, the gap says nothing
    return met;
  }
  // nor do edges push that are not within one another's arcs
  if (met.normal.dot(pieces.n) < other_arc.last - turned) return met;
  if (met.normal.dot(edge.nhat) < edge.arc.last - turned - clear->turn()) return met;
  const double reach = clear->reach();
  const double turns = 1.05 / least_sine;
  const double swing = turns * (std::abs(met.u) * pieces.sine + reach) +
                       0.5 * turns * turned * (std::abs(met.gap) + reach);
  clear->KeepAbove(met.normal, met.gap - kRefinedClearance, swing, way);
  return met;
}

/// By step of a ridge's half angle; last, the loose one.
const auto kArcs = [] {
  std::array<EdgeArc, SurfaceDetail::kAngles + 1> arcs;
  for (std::size_t i = 0; i < SurfaceDetail::kAngles; ++i) {
    arcs[i] = EdgeArc(SurfaceDetail::kAngleStep * static_cast<double>(i));
  }
  arcs.back() = EdgeArc(kLooseArc);
  arcs.back().loose = true;
  return arcs;
}();

}  // namespace

EdgeArc::EdgeArc(double half_angle)
    : cosine(std::cos(half_angle)),
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

const EdgeArc& LooseArc() noexcept {
  return kArcs.back();
}

const EdgeArc& ArcOf(const SurfaceDetail& detail) noexcept {
  const bool ridge = detail.shape() == SurfaceDetail::Shape::kRidge;
  return kArcs[ridge ? detail.half_angle_steps() : SurfaceDetail::kAngles];
}

namespace {

EdgeMeeting MeetOne(const ShellEdge& edge, const OtherEdge& other, double reach,
                    ClearRegionMaker* clear, double way) noexcept {
  if (clear != nullptr && way >= clear->reach()) clear = nullptr;
  const Vec3& q = other.q;
  const Vec3& other_t = other.tangent;
  const Vec3& n = other.nhat;
  const EdgeArc& other_arc = other.arc;
  const bool ends = other.ends;
  const double other_end = other.half;
  const Vec3 away = edge.p - q;
  const double cosine = edge.tangent.dot(other_t);
  const double sine = std::sqrt(std::max(0.0, 1.0 - cosine * cosine));
  const Pieces pieces{edge,
                      other_t,
                      n,
                      away,
                      other_end,
                      edge.half + kSeam,
                      other_end + kSeam,
                      cosine,
                      sine,
                      away.dot(edge.tangent),
                      away.dot(other_t),
                      n.dot(edge.nhat),
                      edge.arc.loose || other_arc.loose ? kFacing : kFacingAcross};
  // the far sides of thin walls do not push
  if (clear != nullptr && pieces.facing < pieces.least_across - clear->turn()) clear = nullptr;
  // edges about to become parallel, or no longer, are clear if they are so either way
  const bool parallel = sine < kParallel;
  const bool may_change = clear != nullptr && std::abs(sine - kParallel) <= clear->turn();
  if (may_change) {
    if (parallel) {
      AcrossOne(pieces, other_arc, clear, way);
    } else {
      BesideOne(pieces, other_arc, clear, way);
    }
  }
  const Way met = parallel ? BesideOne(pieces, other_arc, clear, way)
                           : AcrossOne(pieces, other_arc, clear, way);
  EdgeMeeting meeting;
  if (met.apart || !met.pushes) return meeting;
  double share = met.share;
  if (parallel) {
    share *= ShareBeside(away, met.normal, met.gap);
  } else {
    if (edge.ends) share *= ShareFromEnd(met.u + edge.half, edge.fade);
    if (ends) share *= ShareFromEnd(met.v + other_end, 0.5);
  }
  if (!edge.ends || met.u > 0) share *= ShareOfPiece(edge.half - std::abs(met.u));
  if (!ends || met.v > 0) share *= ShareOfPiece(other_end - std::abs(met.v));
  meeting.share = share;
  meeting.depth = std::max(0.0, reach - met.gap);
  meeting.normal = met.normal;
  meeting.place =
      parallel ? edge.p : Vec3(0.5 * (edge.p + met.u * edge.tangent + q + met.v * other_t));
  return meeting;
}

}  // namespace

EdgeMeeting Meet(const ShellEdge& edge, const OtherEdge& other, double reach) noexcept {
  return MeetOne(edge, other, reach, nullptr, 0);
}

EdgeMeeting Meet(const ShellEdge& edge, const SurfaceDetail& detail, const Vec3& q, bool ends,
                 const EdgeArc& other_arc, ClearRegionMaker* clear, double way) noexcept {
  const bool two_sided = detail.half_length == SurfaceDetail::kTwoSided;
  // of a thin sheet's edge only that it passes through the voxel is known
  const double half = two_sided ? 0.5 : detail.half_length / 128.0;
  return MeetOne(
      edge,
      {q, UnpackDirection(detail.tangent), FacingNormal(detail, edge.nhat), half, other_arc, ends},
      kRefinedClearance, clear, way);
}

}  // namespace tandem
