#pragma once

#include <array>

#include "engine/base/spatial.h"

namespace tandem {

/// Passes the motion between two frequencies, each axis by itself. A Butterworth high-pass and a
/// Butterworth low-pass of second order stand in series, made by the bilinear transform. One sample
/// is one frame of 1 ms.
class BandPass {
 public:
  BandPass(double from_hz, double to_hz);
  Vec3 Pass(const Vec3& in) noexcept;

 private:
  struct Section {
    double b0 = 1, b1 = 0, b2 = 0, a1 = 0, a2 = 0;
    Vec3 s1 = Vec3::Zero();
    Vec3 s2 = Vec3::Zero();
    Vec3 Pass(const Vec3& in) noexcept;
  };
  std::array<Section, 2> sections_;
};

}  // namespace tandem
