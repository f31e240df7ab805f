#include "engine/scene/force_parameters.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "engine/base/hash.h"
#include "engine/contact/features/edge_contact.h"
#include "engine/contact/field/field_pair.h"
#include "engine/contact/pair/tangent_plane.h"

namespace tandem {

namespace {

constexpr double kFrameSeconds = 1e-3;
constexpr double kSameGap = 1e-6;  // m

double PointStiffness(const ForceParameters& parameters, double mass) {
  const double of_mass = DefaultContactGains(parameters.voxel_size, mass, kFrameSeconds).stiffness;
  return std::max(parameters.stiffness, of_mass);
}

}  // namespace

ForceParameters ParametersOf(const Scene& scene) {
  return {.voxel_size = scene.voxel_size,
          .contact = scene.contact,
          .force_layer = scene.force_layer,
          .friction = scene.friction,
          .stiffness = LeastContactStiffness(scene.voxel_size)};
}

void Adopt(const ForceParameters& parameters, Scene& scene) {
  scene.voxel_size = parameters.voxel_size;
  scene.contact = parameters.contact;
  scene.force_layer = parameters.force_layer;
  scene.range_voxels = std::max(scene.range_voxels, parameters.force_layer + kWarningQueues);
  scene.friction = parameters.friction;
}

std::uint64_t HashOf(const ForceParameters& parameters) {
  Hash64 hash;
  // adding 0 turns a negative zero, which means the same, into 0
  hash.Add(parameters.voxel_size + 0.0);
  hash.Add(static_cast<std::uint8_t>(parameters.contact));
  hash.Add(parameters.force_layer);
  hash.Add(parameters.friction + 0.0);
  hash.Add(parameters.stiffness + 0.0);
  return hash.value();
}

std::string Describe(const ForceParameters& parameters) {
  std::array<char, 160> text{};
  std::snprintf(text.data(), text.size(),
                "voxels of %g mm, %s contact, force layer %d, friction %g",
                1e3 * parameters.voxel_size,
                parameters.contact == ContactModel::kRefined ? "refined" : "plain",
                parameters.force_layer, parameters.friction);
  return text.data();
}

double GapAtFirstForce(const ForceParameters& parameters) {
  return parameters.voxel_size * (parameters.contact == ContactModel::kRefined
                                      ? kRefinedClearance
                                      : static_cast<double>(parameters.force_layer));
}

std::optional<UnequalPush> ComparePush(const ForceParameters& first, const ForceParameters& second,
                                       double mass) {
  const double wider = GapAtFirstForce(first) - GapAtFirstForce(second);
  UnequalPush push;
  if (std::abs(wider) > kSameGap) {
    push.first_harder = wider < 0;
    push.head_start = std::abs(wider);
    const ForceParameters& pushed = push.first_harder ? second : first;
    const double soft =
        pushed.contact == ContactModel::kRefined ? kFullStiffnessDepth * pushed.voxel_size : 0.0;
    push.alone_force =
        ContactForce(PointStiffness(pushed, mass), push.head_start, pushed.voxel_size, soft);
    return push;
  }
  const double ratio = PointStiffness(first, mass) / PointStiffness(second, mass);
  if (std::abs(ratio - 1) < 1e-3) return std::nullopt;
  push.first_harder = ratio < 1;
  push.ratio = ratio < 1 ? 1 / ratio : ratio;
  return push;
}

}  // namespace tandem
