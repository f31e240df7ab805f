#include "collab/lab/metrics/band_pass.h"

#include <cmath>

#include "engine/world/world.h"

namespace tandem {

BandPass::BandPass(double from_hz, double to_hz) {
  for (const bool high : {true, false}) {
    const double g = std::tan(M_PI * (high ? from_hz : to_hz) * kFrame);
    const double scale = 1.0 / (1.0 + M_SQRT2 * g + g * g);
    const double middle = high ? -2.0 : 2.0;
    const double b = scale * (high ? 1.0 : g * g);
    Section& section = sections_[high ? 0 : 1];
    section.b0 = section.b2 = b;
    section.b1 = middle * b;
    section.a1 = 2.0 * scale * (g * g - 1.0);
    section.a2 = scale * (1.0 - M_SQRT2 * g + g * g);
  }
}

Vec3 BandPass::Section::Pass(const Vec3& in) noexcept {
  const Vec3 out = b0 * in + s1;
  s1 = b1 * in - a1 * out + s2;
  s2 = b2 * in - a2 * out;
  return out;
}

Vec3 BandPass::Pass(const Vec3& in) noexcept {
  return sections_[1].Pass(sections_[0].Pass(in));
}

}  // namespace tandem
