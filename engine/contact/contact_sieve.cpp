#include "engine/contact/contact_sieve.h"

#include "engine/contact/plane_mean.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine/contact/contact_sieve.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tandem::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

using Lanes = hn::CappedTag<float, NearPieces::kLanes>;
using V = hn::Vec<Lanes>;
using M = hn::Mask<Lanes>;

constexpr auto kMargin = static_cast<float>(kSieveMargin);
constexpr auto kClearance = static_cast<float>(kRefinedClearance) + kMargin;
constexpr auto kLeastFacing = static_cast<float>(kFacing) - kMargin;
constexpr auto kLeastAcross = static_cast<float>(kFacingAcross) - kMargin;

struct V3 {
  V x, y, z;
};

using Block = NearPieces::Block;

HWY_INLINE V3 Load(const NearPieces::Rows& rows, std::size_t lane) {
  const Lanes d;
  return {hn::Load(d, &rows[0][lane]), hn::Load(d, &rows[1][lane]), hn::Load(d, &rows[2][lane])};
}
HWY_INLINE V3 Set(const std::array<float, 3>& a) {
  const Lanes d;
  return {hn::Set(d, a[0]), hn::Set(d, a[1]), hn::Set(d, a[2])};
}
HWY_INLINE V3 Sub(const V3& a, const V3& b) {
  return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
}
HWY_INLINE V3 Add(const V3& a, const V3& b) {
  return {hn::Add(a.x, b.x), hn::Add(a.y, b.y), hn::Add(a.z, b.z)};
}
HWY_INLINE V Dot(const V3& a, const V3& b) {
  return hn::Add(hn::Mul(a.x, b.x), hn::Add(hn::Mul(a.y, b.y), hn::Mul(a.z, b.z)));
}
HWY_INLINE V3 Cross(const V3& a, const V3& b) {
  return {hn::Sub(hn::Mul(a.y, b.z), hn::Mul(a.z, b.y)),
          hn::Sub(hn::Mul(a.z, b.x), hn::Mul(a.x, b.z)),
          hn::Sub(hn::Mul(a.x, b.y), hn::Mul(a.y, b.x))};
}
HWY_INLINE V3 Scaled(const V3& a, V by) {
  return {hn::Mul(by, a.x), hn::Mul(by, a.y), hn::Mul(by, a.z)};
}
HWY_INLINE V Length(const V3& a) {
  const Lanes d;
  return hn::Sqrt(hn::Max(Dot(a, a), hn::Set(d, 1e-12F)));
}
HWY_INLINE V3 Unit(const V3& a) {
  const Lanes d;
  return Scaled(a, hn::Div(hn::Set(d, 1.0F), Length(a)));
}

/// Pieces within one voxel.
HWY_INLINE M IsNear(const Block& block, const V3& voxel, std::size_t lane) {
  const Lanes d;
  const V3 off = Sub(Load(block.voxel, lane), voxel);
  const V most = hn::Max(hn::Abs(off.x), hn::Max(hn::Abs(off.y), hn::Abs(off.z)));
  return hn::Le(most, hn::Set(d, 1.0F));
}

/// What a plane says of a point: whether it counts so far beside, and is less than the clearance
/// below.
struct Under {
  V height;
  M counts;
  M low;
};
HWY_INLINE Under LookUnder(const V3& away, const V3& n, double reach) {
  const Lanes d;
  const float most = static_cast<float>(reach) + kMargin;
  const V height = Dot(away, n);
  const V square_beside = hn::Sub(Dot(away, away), hn::Mul(height, height));
  return {height, hn::Lt(square_beside, hn::Set(d, most * most)),
          hn::Lt(height, hn::Set(d, kClearance))};
}

/// Calls visit(block, lane) for whole vectors of pieces.
template <class Visit>
HWY_INLINE void ForLanes(std::span<const Block> blocks, const Visit& visit) {
  const Lanes d;
  for (const Block& block : blocks) {
    for (std::size_t lane = 0; lane < NearPieces::kLanes; lane += hn::Lanes(d)) visit(block, lane);
  }
}

/// Whether a vertex can stand on one of some pieces; `any_near` is set when one is near.
bool StandsOn(std::span<const Block> blocks, const SieveProbe& probe, bool& any_near) {
  const Lanes d;
  const V3 voxel = Set(probe.voxel);
  const V3 p = Set(probe.p);
  const V3 nhat = Set(probe.nhat);
  M near_any = hn::FirstN(d, 0);
  M stands_any = hn::FirstN(d, 0);
  ForLanes(blocks, [&](const Block& block, std::size_t lane) HWY_ATTR {
    const M near = IsNear(block, voxel, lane);
    const V3 n = Load(block.normal, lane);
    const Under under = LookUnder(Sub(p, Load(block.place, lane)), n, kLateralReach);
    const M facing = hn::Gt(Dot(n, nhat), hn::Set(d, kLeastFacing));
    near_any = hn::Or(near_any, near);
    stands_any =
        hn::Or(stands_any, hn::And(hn::And(near, facing), hn::And(under.counts, under.low)));
  });
  any_near = any_near || !hn::AllFalse(d, near_any);
  return !hn::AllFalse(d, stands_any);
}

/// The same of ridges, whose two faces lie in the two halves of the blocks: as
/// PlaneMean::AddRidge(), the lower face has a say over the edge and a little way inside.
bool StandsOnRidge(std::span<const Block> blocks, const SieveProbe& probe, bool& any_near) {
  const Lanes d;
  const V margin = hn::Set(d, kMargin);
  const V take_over = hn::Set(d, 2 * static_cast<float>(kTakeOver) + kMargin);
  const V3 voxel = Set(probe.voxel);
  const V3 p = Set(probe.p);
  const std::size_t half = blocks.size() / 2;
  M near_any = hn::FirstN(d, 0);
  M stands_any = hn::FirstN(d, 0);
  for (std::size_t i = 0; i < half; ++i) {
    for (std::size_t lane = 0; lane < NearPieces::kLanes; lane += hn::Lanes(d)) {
      const M near = IsNear(blocks[i], voxel, lane);
      const V3 away = Sub(p, Load(blocks[i].place, lane));
      const V3 one_n = Load(blocks[i].normal, lane);
      const V3 other_n = Load(blocks[half + i].normal, lane);
      const Under one = LookUnder(away, one_n, kLateralReach);
      const Under other = LookUnder(away, other_n, kLateralReach);
      const V cosine = Dot(one_n, other_n);
      const M over_edge =
          hn::And(hn::Gt(hn::Add(one.height, margin), hn::Mul(cosine, other.height)),
                  hn::Gt(hn::Add(other.height, margin), hn::Mul(cosine, one.height)));
      const V higher = hn::Sub(one.height, other.height);
      const M inside = hn::And(hn::Lt(hn::Max(one.height, other.height), margin),
                               hn::Lt(hn::Abs(higher), take_over));
      const M both = hn::Or(over_edge, inside);
      const M one_stands = hn::And(hn::And(one.counts, one.low),
                                   hn::Or(both, hn::Gt(hn::Add(higher, margin), hn::Zero(d))));
      const M other_stands = hn::And(hn::And(other.counts, other.low),
                                     hn::Or(both, hn::Lt(hn::Sub(higher, margin), hn::Zero(d))));
      near_any = hn::Or(near_any, near);
      stands_any = hn::Or(stands_any, hn::And(near, hn::Or(one_stands, other_stands)));
    }
  }
  any_near = any_near || !hn::AllFalse(d, near_any);
  return !hn::AllFalse(d, stands_any);
}

bool Stands(const NearPieces::Cell& surface, const SieveProbe& probe) {
  bool any_near = false;
  if (StandsOn(surface.plain(), probe, any_near)) return true;
  if (StandsOnRidge(surface.ridges(), probe, any_near)) return true;
  // corners have a say where nothing else is near
  return !any_near && StandsOn(surface.corners(), probe, any_near);
}

/// An edge of the shell and some of the map's, voxels: p + u t and q + v t'.
struct EdgePairs {
  V3 t, other_t;
  V3 n, nhat;
  V3 away;  // p - q
  V cosine, square_sine;
  V along, other_along;  // away, along t and t'
  V half, other_half;
};

struct Arc {
  V tangent;  // of half of the arc's half
  V cosine, last;
};

/// One across the other, along the way that is square to both.
M PushAcross(const EdgePairs& pairs, const Arc& arc, const Arc& other_arc) {
  const Lanes d;
  const V margin = hn::Set(d, kMargin);
  const V3 square = Cross(pairs.t, pairs.other_t);
  const V side = Dot(square, Add(pairs.n, pairs.nhat));
  const V3 normal = Scaled(square, hn::Div(hn::CopySign(hn::Set(d, 1.0F), side), Length(square)));
  const M sides = hn::Ge(Dot(normal, Add(pairs.n, pairs.nhat)),
                         hn::Set(d, static_cast<float>(kSides) - kMargin));
  const M in_arcs = hn::And(hn::Gt(Dot(normal, pairs.n), hn::Sub(other_arc.last, margin)),
                            hn::Gt(Dot(normal, pairs.nhat), hn::Sub(arc.last, margin)));
  return hn::And(hn::And(sides, in_arcs), hn::Lt(Dot(normal, pairs.away), hn::Set(d, kClearance)));
}

/// The ends of an arc seen along its edge, a little inside: its normal turned by `cosine`, `sine`
/// either way.
struct ArcEnds {
  V cosine, sine;
  explicit ArcEnds(const Arc& arc) {
    const Lanes d;
    const V inside = hn::Set(d, 2 * kMargin);  // rad
    const V half_sine = hn::Mul(arc.tangent, hn::Add(hn::Set(d, 1.0F), arc.cosine));
    // of an arc that is thinner, its normal
    cosine = hn::Min(hn::Set(d, 1.0F), hn::Add(arc.cosine, hn::Mul(inside, half_sine)));
    sine = hn::Max(hn::Zero(d), hn::Sub(half_sine, hn::Mul(inside, arc.cosine)));
  }
};

/// Side by side they push along the direction in both arcs that parts them most, or midway between
/// their arcs. That direction is the one they are apart in, if it lies in both, and else an end of
/// one arc that lies in the other. And there is one within half of what one arc is wider than the
/// other of the middle between normals.
M PushBeside(const EdgePairs& pairs, const Arc& arc, const Arc& other_arc) {
  const Lanes d;
  const V rounding = hn::Set(d, 0.01F * kMargin);  // of cosines
  const auto across = [&](const V3& a) HWY_ATTR {
    return Sub(a, Scaled(pairs.t, Dot(a, pairs.t)));
  };
  const V3 away = across(pairs.away);
  const V length = Length(away);
  const V3 n = Unit(across(pairs.n));
  const V3 nhat = Unit(across(pairs.nhat));
  // no less than half of the difference, which it is the tangent of
  const V turn = hn::Div(hn::Abs(hn::Sub(arc.tangent, other_arc.tangent)),
                         hn::Add(hn::Set(d, 1.0F), hn::Mul(arc.tangent, other_arc.tangent)));
  V least = hn::Sub(Dot(away, Unit(Add(n, nhat))), hn::Mul(turn, length));
  const auto take = [&](M within, V gap) HWY_ATTR {
    least = hn::IfThenElse(within, hn::Max(least, gap), least);
  };
  const V above = Dot(away, n);
  const V other_above = Dot(away, nhat);
  const auto within = [&](V gap, V arc_cosine) HWY_ATTR {
    return hn::Gt(gap, hn::Mul(hn::Add(arc_cosine, rounding), length));
  };
  take(hn::And(within(above, other_arc.cosine), within(other_above, arc.cosine)), length);
  const V cosine = Dot(n, nhat);
  const V3 beside_n = Cross(pairs.t, n);
  const V sine = Dot(beside_n, nhat);
  const auto take_end = [&](V a, V b, V turned_cosine, V arc_cosine) HWY_ATTR {
    take(hn::Gt(turned_cosine, hn::Add(arc_cosine, rounding)), hn::Add(a, b));
  };
  const ArcEnds ends(other_arc);
  const V up = hn::Mul(ends.cosine, above);
  const V aside = hn::Mul(ends.sine, Dot(away, beside_n));
  const V to_nhat = hn::Mul(ends.cosine, cosine);
  const V by_n = hn::Mul(ends.sine, sine);
  take_end(up, aside, hn::Add(to_nhat, by_n), arc.cosine);
  take_end(up, hn::Neg(aside), hn::Sub(to_nhat, by_n), arc.cosine);
  const ArcEnds other_ends(arc);
  const V other_up = hn::Mul(other_ends.cosine, other_above);
  const V other_aside = hn::Mul(other_ends.sine, Dot(away, Cross(pairs.t, nhat)));
  const V to_n = hn::Mul(other_ends.cosine, cosine);
  const V by_nhat = hn::Mul(other_ends.sine, sine);
  take_end(other_up, other_aside, hn::Sub(to_n, by_nhat), other_arc.cosine);
  take_end(other_up, hn::Neg(other_aside), hn::Add(to_n, by_nhat), other_arc.cosine);
  return hn::Lt(least, hn::Set(d, kClearance));
}

/// Whether an edge of the shell can push one of some lanes of the map's.
bool LeansOn(const Block& block, std::size_t lane, const V3& voxel, const V3& p, V half,
             const Arc& arc, EdgePairs& pairs) {
  const Lanes d;
  // in both ranges edges are taken either way
  constexpr auto kLeastSine = static_cast<float>(kParallel) - kMargin;
  constexpr auto kMostSine = static_cast<float>(kParallel) + kMargin;
  const V margin = hn::Set(d, kMargin);
  pairs.n = Load(block.normal, lane);
  pairs.other_t = Load(block.tangent, lane);
  pairs.away = Sub(p, Load(block.place, lane));
  pairs.cosine = Dot(pairs.t, pairs.other_t);
  pairs.square_sine = hn::Sub(hn::Set(d, 1.0F), hn::Mul(pairs.cosine, pairs.cosine));
  pairs.along = Dot(pairs.away, pairs.t);
  pairs.other_along = Dot(pairs.away, pairs.other_t);
  const V other_half = hn::Load(d, &block.half[lane]);
  const V facing = Dot(pairs.n, pairs.nhat);
  const M near = hn::And(IsNear(block, voxel, lane), hn::Gt(facing, hn::Set(d, kLeastAcross)));
  // the places where they come closest lie on both pieces: |u| <= half, |v| <= other half
  const V u = hn::Sub(hn::Mul(pairs.cosine, pairs.other_along), pairs.along);
  const V v = hn::Sub(pairs.other_along, hn::Mul(pairs.cosine, pairs.along));
  const M meet =
      hn::And(hn::Le(hn::Abs(u), hn::Mul(hn::Add(half, margin), pairs.square_sine)),
              hn::Le(hn::Abs(v), hn::Mul(hn::Add(other_half, margin), pairs.square_sine)));
  const M crossing =
      hn::And(hn::And(near, meet), hn::Gt(pairs.square_sine, hn::Set(d, kLeastSine * kLeastSine)));
  const M beside = hn::And(hn::And(hn::And(near, hn::Gt(facing, hn::Set(d, kLeastFacing))),
                                   hn::Le(hn::Abs(pairs.other_along), hn::Add(other_half, margin))),
                           hn::Lt(pairs.square_sine, hn::Set(d, kMostSine * kMostSine)));
  if (hn::AllFalse(d, hn::Or(crossing, beside))) return false;
  const Arc other_arc{hn::Load(d, &block.arc_tangent[lane]), hn::Load(d, &block.arc_cosine[lane]),
                      hn::Load(d, &block.arc_last[lane])};
  return (!hn::AllFalse(d, crossing) &&
          !hn::AllFalse(d, hn::And(crossing, PushAcross(pairs, arc, other_arc)))) ||
         (!hn::AllFalse(d, beside) &&
          !hn::AllFalse(d, hn::And(beside, PushBeside(pairs, arc, other_arc))));
}

bool Leans(const NearPieces::Cell& edges, const SieveProbe& probe) {
  const Lanes d;
  const V3 voxel = Set(probe.voxel);
  const V3 p = Set(probe.p);
  const V half = hn::Set(d, probe.half);
  const Arc arc{hn::Set(d, probe.arc_tangent), hn::Set(d, probe.arc_cosine),
                hn::Set(d, probe.arc_last)};
  EdgePairs pairs;
  pairs.t = Set(probe.tangent);
  pairs.nhat = Set(probe.nhat);
  for (const Block& block : edges.all()) {
    for (std::size_t lane = 0; lane < NearPieces::kLanes; lane += hn::Lanes(d)) {
      if (LeansOn(block, lane, voxel, p, half, arc, pairs)) return true;
    }
  }
  return false;
}

SievedBearing Bears(const NearPieces::Cell& vertices, const SieveProbe& probe) {
  const Lanes d;
  const V3 voxel = Set(probe.voxel);
  const V3 p = Set(probe.p);
  const V3 nhat = Set(probe.nhat);
  M over_any = hn::FirstN(d, 0);
  M low_any = hn::FirstN(d, 0);
  ForLanes(vertices.all(), [&](const Block& block, std::size_t lane) HWY_ATTR {
    const Under under = LookUnder(Sub(p, Load(block.place, lane)), nhat, kVertexReach);
    const M over = hn::And(IsNear(block, voxel, lane), under.counts);
    over_any = hn::Or(over_any, over);
    low_any = hn::Or(low_any, hn::And(over, under.low));
  });
  if (!hn::AllFalse(d, low_any)) return SievedBearing::kBears;
  return hn::AllFalse(d, over_any) ? SievedBearing::kNone : SievedBearing::kHigh;
}

}  // namespace
}  // namespace tandem::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tandem {

HWY_EXPORT(Stands);
HWY_EXPORT(Leans);
HWY_EXPORT(Bears);

namespace {

std::array<float, 3> AsFloats(const Vec3& a) {
  return {static_cast<float>(a.x()), static_cast<float>(a.y()), static_cast<float>(a.z())};
}

SieveProbe ProbeAt(const SievedPoint& point) {
  const GridIndex middle = NearPieces::MiddleOf(point.voxel_V);
  const GridIndex off = point.voxel_V - middle;
  SieveProbe probe;
  probe.voxel = AsFloats(Vec3(off.x, off.y, off.z));
  probe.p = AsFloats(point.p - Vec3(middle.x, middle.y, middle.z));
  probe.nhat = AsFloats(point.nhat);
  return probe;
}

}  // namespace

bool MayStand(const NearPieces::Cell& surface, const SievedPoint& vertex) noexcept {
  return HWY_DYNAMIC_DISPATCH(Stands)(surface, ProbeAt(vertex));
}

bool MayLean(const NearPieces::Cell& edges, const SievedPoint& middle,
             const SievedEdge& edge) noexcept {
  SieveProbe probe = ProbeAt(middle);
  probe.tangent = AsFloats(edge.tangent);
  probe.half = static_cast<float>(edge.half + kSeam);
  probe.arc_tangent = static_cast<float>(edge.arc.sine / (1.0 + edge.arc.cosine));
  probe.arc_cosine = static_cast<float>(edge.arc.cosine);
  probe.arc_last = static_cast<float>(edge.arc.last);
  return HWY_DYNAMIC_DISPATCH(Leans)(edges, probe);
}

SievedBearing MayBear(const NearPieces::Cell& vertices, const SievedPoint& point) noexcept {
  return HWY_DYNAMIC_DISPATCH(Bears)(vertices, ProbeAt(point));
}

}  // namespace tandem
#endif
