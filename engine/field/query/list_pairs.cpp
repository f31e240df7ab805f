#include "engine/field/query/list_pairs.h"

#include <algorithm>
#include <cstdint>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine/field/query/list_pairs.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "engine/base/simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tandem::HWY_NAMESPACE {
namespace {

HWY_INLINE Lanes3 Minus(const Lanes3& a, const Lanes3& b) {
  return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
}
HWY_INLINE Lanes3 Cross(const Lanes3& a, const Lanes3& b) {
  return {hn::Sub(hn::Mul(a.y, b.z), hn::Mul(a.z, b.y)),
          hn::Sub(hn::Mul(a.z, b.x), hn::Mul(a.x, b.z)),
          hn::Sub(hn::Mul(a.x, b.y), hn::Mul(a.y, b.x))};
}
HWY_INLINE Lanes3 Select(hn::Mask<F> mask, const Lanes3& yes, const Lanes3& no) {
  return {hn::IfThenElse(mask, yes.x, no.x), hn::IfThenElse(mask, yes.y, no.y),
          hn::IfThenElse(mask, yes.z, no.z)};
}

/// Returns the point of the edge that begins at `from` which is nearest to the origin.
HWY_INLINE Lanes3 OnEdge(const Lanes3& from, const Lanes3& along) {
  const F f;
  const Floats length = hn::Max(Dot(along, along), hn::Set(f, 1e-30F));
  const Floats t = hn::Div(hn::Neg(Dot(from, along)), length);
  const Floats in = hn::Min(hn::Max(t, hn::Zero(f)), hn::Set(f, 1.0F));
  return {hn::Add(from.x, hn::Mul(in, along.x)), hn::Add(from.y, hn::Mul(in, along.y)),
          hn::Add(from.z, hn::Mul(in, along.z))};
}

/// Returns a vector of corners relative to the places, of pairs from `k` on.
HWY_INLINE Lanes3 CornerOf(const ListPairs& pairs, std::size_t corner, std::size_t k) {
  const F f;
  Lanes3 at;
  Floats other;
  const float* words = &pairs.corners[corner][4 * k];
  if (corner == 2) {
    hn::LoadInterleaved4(f, words, other, at.x, at.y, at.z);
  } else {
    hn::LoadInterleaved4(f, words, at.x, at.y, at.z, other);
  }
  const auto from_place = [&](Floats along, std::size_t axis) HWY_ATTR {
    return hn::Sub(hn::Sub(along, hn::LoadU(f, &pairs.whole[axis][k])),
                   hn::LoadU(f, &pairs.rest[axis][k]));
  };
  return {from_place(at.x, 0), from_place(at.y, 1), from_place(at.z, 2)};
}

template <bool kWays>
HWY_INLINE void MeasureAll(ListPairs& pairs) {
  const F f;
  for (std::size_t k = 0; k < pairs.count; k += hn::MaxLanes(f)) {
    const Lanes3 a = CornerOf(pairs, 0, k);
    const Lanes3 b = CornerOf(pairs, 1, k);
    const Lanes3 c = CornerOf(pairs, 2, k);
    const Lanes3 ab = Minus(b, a);
    const Lanes3 bc = Minus(c, b);
    const Lanes3 ca = Minus(a, c);
    const Lanes3 normal = Cross(ab, bc);
    const Floats area = hn::Max(Dot(normal, normal), hn::Set(f, 1e-30F));
    const Floats length = hn::Sqrt(area);
    const Floats height = hn::Div(hn::Neg(Dot(a, normal)), length);
    // the origin lies over the face if it is to the left of all edges
    const auto left = [&](const Lanes3& from, const Lanes3& along) HWY_ATTR {
      return hn::Ge(Dot(Cross(from, along), normal), hn::Zero(f));
    };
    auto over = hn::And(left(a, ab), hn::And(left(b, bc), left(c, ca)));
    over = hn::And(over, hn::Gt(Dot(normal, normal), hn::Set(f, 1e-30F)));
    const Lanes3 on_ab = OnEdge(a, ab);
    const Lanes3 on_bc = OnEdge(b, bc);
    const Lanes3 on_ca = OnEdge(c, ca);
    const Floats from_ab = Dot(on_ab, on_ab);
    const Floats from_bc = Dot(on_bc, on_bc);
    const Floats from_ca = Dot(on_ca, on_ca);
    const Floats edges = hn::Min(from_ab, hn::Min(from_bc, from_ca));
    hn::Store(hn::IfThenElse(over, hn::Mul(height, height), edges), f, &pairs.squared[k]);
    hn::Store(height, f, &pairs.height[k]);
    if constexpr (kWays) {
      const Floats down = hn::Neg(hn::Div(height, length));
      const Lanes3 on_face{hn::Mul(down, normal.x), hn::Mul(down, normal.y),
                           hn::Mul(down, normal.z)};
      const Lanes3 on_edge =
          Select(hn::Le(from_ab, edges), on_ab, Select(hn::Le(from_bc, edges), on_bc, on_ca));
      const Lanes3 to = Select(over, on_face, on_edge);
      hn::Store(to.x, f, &pairs.to_face[0][k]);
      hn::Store(to.y, f, &pairs.to_face[1][k]);
      hn::Store(to.z, f, &pairs.to_face[2][k]);
    }
  }
}

void MeasureDistancesOf(ListPairs& pairs) {
  MeasureAll<false>(pairs);
}
void MeasureWaysOf(ListPairs& pairs) {
  MeasureAll<true>(pairs);
}

}  // namespace
}  // namespace tandem::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tandem {

namespace {
HWY_EXPORT(MeasureDistancesOf);
HWY_EXPORT(MeasureWaysOf);
}  // namespace

void MeasureDistances(ListPairs& pairs) noexcept {
  HWY_DYNAMIC_DISPATCH(MeasureDistancesOf)(pairs);
}

void MeasureWays(ListPairs& pairs) noexcept {
  HWY_DYNAMIC_DISPATCH(MeasureWaysOf)(pairs);
}

}  // namespace tandem
#endif
