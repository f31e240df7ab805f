// The vectors of this project's kernels, for each instruction set: tags, vectors of three numbers
// in lanes, and masks as bits. Included by files that foreach_target.h includes again.
#include <cstddef>
#include <cstdint>

#if defined(TANDEM_SIMD_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TANDEM_SIMD_INL_H
#undef TANDEM_SIMD_INL_H
#else
#define TANDEM_SIMD_INL_H
#endif

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tandem::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

// tags of vectors of at most 512 bits, and the vectors
using F = hn::CappedTag<float, 16>;
using I = hn::RebindToSigned<F>;
using U = hn::RebindToUnsigned<F>;
using D = hn::CappedTag<double, 8>;
using W = hn::RebindToUnsigned<D>;
using Floats = hn::Vec<F>;
using Ints = hn::Vec<I>;
using Uints = hn::Vec<U>;
using Doubles = hn::Vec<D>;
using Words = hn::Vec<W>;

/// Vectors of three numbers, one in each lane.
template <typename Components>
struct Lanes3Of {
  Components x, y, z;
};
using Lanes3 = Lanes3Of<Floats>;
using IntLanes3 = Lanes3Of<Ints>;

/// Returns the vector of three numbers in all lanes.
HWY_INLINE Lanes3 Broadcast(const float* v) {
  const F f;
  return {hn::Set(f, v[0]), hn::Set(f, v[1]), hn::Set(f, v[2])};
}

/// Returns dot products. They are never fused: every processor must find the same ones.
HWY_INLINE Floats Dot(const Lanes3& a, const Lanes3& b) {
  return hn::Add(hn::Add(hn::Mul(a.x, b.x), hn::Mul(a.y, b.y)), hn::Mul(a.z, b.z));
}

HWY_INLINE Lanes3 ToFloats(const IntLanes3& v) {
  const F f;
  return {hn::ConvertTo(f, v.x), hn::ConvertTo(f, v.y), hn::ConvertTo(f, v.z)};
}

/// Returns a mask of at most 32 lanes as bits, the first lane's lowest.
template <typename Tag, typename Mask>
HWY_INLINE unsigned MaskBits(Tag tag, Mask mask) {
  std::uint64_t bits = 0;  // Highway may write 8 bytes
  hn::StoreMaskBits(tag, mask, reinterpret_cast<std::uint8_t*>(&bits));
  return static_cast<unsigned>(bits);
}

}  // namespace
}  // namespace tandem::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
