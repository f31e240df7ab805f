#include "engine/contact/features/edge_contact.h"

#include <algorithm>
#include <cmath>

namespace tandem {

namespace {

/// The angle beyond the arc between an edge's two faces over which a push fades out, rad.
constexpr double kArcFade = 0.15;
const double kFadeCosine = std::cos(kArcFade);
const double kFadeSine = std::sin(kArcFade);
/// Half the arc of a loose edge, rad.
constexpr double kLooseArc = 1.25;
/// Voxels over which a push fades out as parallel pieces come to be a voxel apart.
constexpr double kBesideFade = 0.25;

/// Returns the share of a push that counts, from its distance to the end of an edge.
double ShareFromEnd(double from, double fade) {
  return std::clamp(from / fade, 0.0, 1.0);
}

/// Returns the same from the distance to the end of a piece that another piece continues.
double ShareOfPiece(double from) {
  return std::clamp(0.5 + 0.5 * from / kSeam, 0.0, 1.0);
}

/// Returns the same for a piece `away` from another along the same line, and `gap` above it along
/// the normal. Parallel edges are about as near along the whole of their faces. Pieces a voxel
/// apart are looked at or not, depending on the point's voxel. So a push has faded out there, or it
/// would come and go at once. Depth does not reduce the share.
double ShareBeside(const Vec3& away, const Vec3& normal, double gap) {
  const double height = std::clamp(gap, -kRefinedClearance, kRefinedClearance);
  const Vec3 apart = away + (height - gap) * normal;
  return std::clamp((1.0 - apart.cwiseAbs().maxCoeff()) / kBesideFade, 0.0, 1.0);
}

/// A vector in the plane across a line, as cosine and sine. Of length 1 it is a direction or a
/// rotation.
struct Rotation {
  double cosine;
  double sine;

  Rotation Times(const Rotation& other) const {
    return {cosine * other.cosine - sine * other.sine, sine * other.cosine + cosine * other.sine};
  }
  Rotation Inverse() const { return {cosine, -sine}; }
  /// The rotation by 0 for a vector without length.
  Rotation Unit() const {
    const double length = std::sqrt(Dot(*this));
    if (length == 0) return {1, 0};
    return {cosine / length, sine / length};
  }
  /// Returns the sine of the angle from this to the other, times their lengths.
  double Cross(const Rotation& other) const { return cosine * other.sine - sine * other.cosine; }
  double Dot(const Rotation& other) const { return cosine * other.cosine + sine * other.sine; }
};

/// An edge seen along its line. The normals of its faces lie in an arc round its own; half the arc
/// is at most a right angle.
struct Wedge {
  Vec3 normal;
  Rotation half;
};
struct Leaning {
  Vec3 normal = Vec3::Zero();
  double share = 0;
};

/// The directions in both of two arcs, from `low` to `high`. Where the arcs do not meet, both are
/// the middle of the gap between them, and `share` falls as the gap widens.
struct BothArcs {
  Rotation low;
  Rotation high;
  double share = 1.0;
};

/// Intersects two arcs: one lies about 0, the other about `turn`.
BothArcs CommonOf(const Rotation& half, const Rotation& turn, const Rotation& other_half) {
  // tells whether `turn` is more than an angle that is at most a right angle
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

/// Finds how an edge leans on another along the same line `t`, `away` from it. The normal is the
/// direction in both arcs that parts them most: along it lies the distance of two wedges.
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
  Vec3 n;     // outward normal of the map's edge, on the side that the shell's edge faces
  Vec3 away;  // p - q
  double other_end;
  double half;        // half length with what it reaches into the next
  double other_half;  // the same for the map's
  double cosine;      // between t and t'
  double sine;
  double along;         // `away` along t
  double other_along;   // `away` along t'
  double facing;        // cosine between the directions in which they push
  double least_across;  // least `facing` at which crossing edges push one another
};

/// The result of one way of meeting.
struct Way {
  bool apart = false;
  bool pushes = false;
  double u = 0;  // the places on both lines where they come closest: p + u t, q + v t'
  double v = 0;
  Vec3 normal = Vec3::Zero();
  double gap = 0;
  double share = 0;
};

/// Meets parallel pieces: each part of the shell's edge rests on the part of the map's beside it.
Way BesideOne(const Pieces& pieces, const EdgeArc& other_arc) {
  const ShellEdge& edge = pieces.edge;
  Way met;
  met.v = pieces.other_along;
  met.apart = std::abs(met.v) > pieces.other_half;
  met.pushes = pieces.facing > kFacing;
  if (met.apart || !met.pushes) return met;
  const Leaning leaning =
      LeanOnParallel(edge.tangent, pieces.away, {pieces.n, {other_arc.cosine, other_arc.sine}},
                     {edge.nhat, {edge.arc.cosine, edge.arc.sine}});
  met.normal = leaning.normal;
  met.gap = pieces.away.dot(leaning.normal);
  met.share = leaning.share;
  return met;
}

/// Meets crossing pieces, along the direction that is square to both.
Way AcrossOne(const Pieces& pieces, const EdgeArc& other_arc) {
  const ShellEdge& edge = pieces.edge;
  const double square_sine = pieces.sine * pieces.sine;
  Way met;
  met.u = (pieces.cosine * pieces.other_along - pieces.along) / square_sine;
  met.v = (pieces.other_along - pieces.cosine * pieces.along) / square_sine;
  met.apart = std::abs(met.u) > pieces.half || std::abs(met.v) > pieces.other_half;
  met.pushes = pieces.facing > pieces.least_across;
  if (met.apart || !met.pushes) return met;
  met.normal = edge.tangent.cross(pieces.other_t).normalized();
  const double side = met.normal.dot(pieces.n + edge.nhat);
  if (side < 0) met.normal = -met.normal;
  met.gap = pieces.away.dot(met.normal);
  // the material of both bodies must lie behind the plane between the edges
  met.share =
      other_arc.ShareOf(met.normal.dot(pieces.n)) * edge.arc.ShareOf(met.normal.dot(edge.nhat));
  if (std::abs(side) < kSides) met.pushes = false;
  return met;
}

}  // namespace

EdgeArc::EdgeArc(double half_angle)
    : cosine(std::cos(half_angle)),
      sine(std::sin(half_angle)),
      last(std::cos(half_angle + kArcFade)),
      scale(1.0 / (cosine - last)) {}

EdgeArc EdgeArc::FromCosine(double cosine) {
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

namespace {
/// Initialized before any frame, after the fades that it depends on.
const EdgeArc kLooseEdgeArc = [] {
  EdgeArc loose(kLooseArc);
  loose.loose = true;
  return loose;
}();
}  // namespace

const EdgeArc& LooseArc() noexcept {
  return kLooseEdgeArc;
}

EdgeEdgeContact FindEdgeContact(const ShellEdge& edge, const OtherEdge& other,
                                double reach) noexcept {
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
  const bool parallel = sine < kParallel;
  const Way met = parallel ? BesideOne(pieces, other_arc) : AcrossOne(pieces, other_arc);
  EdgeEdgeContact meeting;
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
  meeting.on_shell = edge.p + met.u * edge.tangent;
  meeting.place = parallel ? edge.p : Vec3(0.5 * (meeting.on_shell + q + met.v * other_t));
  return meeting;
}

}  // namespace tandem
