#include "engine/contact/field/pressed_depth.h"

#include <algorithm>
#include <array>
#include <cstdio>

#include "engine/base/two_digits.h"
#include "engine/contact/features/edge_contact.h"
#include "engine/contact/field/field_pair.h"
#include "engine/contact/field/fit_reach.h"
#include "engine/contact/pair/tangent_plane.h"

namespace tandem {

namespace {

/// The least gap of exact surfaces at plain contact's first force: in layer 0, and by layer, voxels
/// (decision 0004).
constexpr double kPlainBegins = -1.1;
constexpr double kPlainLayer = 1.3;

/// Returns how far below its beginning a force (N) brings a single place, voxels.
double DepthOfSpring(double force, double soft) {
  constexpr double kVoxel = 1.0;
  double low = 0;
  double high = 10;
  for (int i = 0; i < 60; ++i) {
    const double depth = 0.5 * (low + high);
    const double there = ContactForce(LeastContactStiffness(kVoxel), depth, kVoxel, soft);
    (there < force ? low : high) = depth;
  }
  return high;
}

std::string Millimetres(double metres) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.2g mm", 1e3 * metres);
  return text.data();
}

}  // namespace

double ContactYield::PressedDepth() const noexcept {
  const bool refined = contact == ContactModel::kRefined;
  const double begins = refined ? std::min(kLeastReach, kRefinedClearance - inward_shift_voxels)
                                : kPlainBegins + kPlainLayer * force_layer - inward_shift_voxels;
  const double spring = DepthOfSpring(force, refined ? kFullStiffnessDepth : 0.0);
  return std::max(0.0, spring - begins) * voxel_size;
}

double ContactYield::VoxelThatDecides(double depth) const noexcept {
  const double pressed = PressedDepth();
  return pressed > 0 ? DownToTwoDigits(0.5 * depth / pressed * voxel_size) : 0;
}

std::string ContactYield::Brief(double depth) const {
  const double pressed = PressedDepth();
  std::array<char, 120> text{};
  const std::string gives = Millimetres(pressed);
  if (depth > pressed) {
    std::snprintf(text.data(), text.size(), "contact gives %s at %.0f N: they cross", gives.c_str(),
                  force);
  } else {
    std::snprintf(text.data(), text.size(), "contact gives %s at %.0f N; voxel_m %.2g decides",
                  gives.c_str(), force, VoxelThatDecides(depth));
  }
  return text.data();
}

std::string ContactYield::Describe(double depth) const {
  const double pressed = PressedDepth();
  std::array<char, 200> text{};
  const std::string gives = "contact gives way by up to " + Millimetres(pressed);
  if (depth > pressed) {
    std::snprintf(text.data(), text.size(),
                  "%s where %.0f N rest on one place, which is less: the surfaces cross",
                  gives.c_str(), force);
  } else {
    std::snprintf(text.data(), text.size(),
                  "%s where %.0f N rest on one place, so this does not decide whether the part "
                  "fits: a voxel_m of %.2g or less does",
                  gives.c_str(), force, VoxelThatDecides(depth));
  }
  return text.data();
}

}  // namespace tandem
