#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/result.h"
#include "engine/world/proximity.h"

/// A whole scene as its parts come near to one another (paper §3.1).
namespace tandem {

/// A body of a scene, where it stands at first.
struct ProximityBody {
  std::string name;
  bool fixed = false;
  TriangleMesh mesh_W;
  std::optional<std::size_t> part_of = std::nullopt;  // the body that it moves with
};

/// What is near as one: all that is fixed together, as the simulation has it, or one moving body
/// with those that are part of it.
struct ProximityPart {
  std::string name;                 // "fixture" where several bodies are fixed
  std::vector<std::size_t> bodies;  // in the scene; first the one whose displacement counts
  bool fixed = false;
  ProximityShape shape;
};

/// Told before each part is voxelized; answers whether to go on.
using ProximityProgress =
    std::function<bool(std::size_t done, std::size_t total, const std::string& part)>;

/// Voxelizes the bodies: the fixture first, if there is one, then the moving bodies in order. An
/// error names the part.
Result<std::vector<ProximityPart>> MakeProximityParts(const std::vector<ProximityBody>& bodies,
                                                      double voxel_size, int range_voxels,
                                                      const ProximityProgress& progress);

/// How near a part is to another, in W. The exact distance lies in [least, most].
struct SceneNearness {
  static constexpr std::size_t kNone = ~std::size_t{0};
  std::size_t part = kNone;   // a moving one
  std::size_t other = kNone;  // kNone: there is nothing to be near to
  double distance = std::numeric_limits<double>::infinity();  // m
  double least = 0;
  double most = std::numeric_limits<double>::infinity();
  Vec3 p_WPart = Vec3::Zero();
  Vec3 p_WOther = Vec3::Zero();
  Vec3 gradient_W = Vec3::Zero();  // where the part gains distance fastest
  bool overlap = false;
  bool refined = false;

  double error_bound() const { return std::max(most - distance, distance - least); }
};

/// Questions to all parts at once. Used by one thread; no call allocates. `X_W` holds each body's
/// displacement since it was voxelized, by its number in the scene; what is fixed has none.
class SceneProximity {
 public:
  explicit SceneProximity(std::shared_ptr<const std::vector<ProximityPart>> parts);

  const std::vector<ProximityPart>& parts() const noexcept { return *parts_; }
  /// Beyond it the fields say nothing, m.
  double range() const noexcept;

  /// Of one moving part to whatever is nearest to it.
  SceneNearness NearestTo(std::size_t part, std::span<const Pose> X_W,
                          const NearestOptions& options = {}) noexcept;
  /// Of all.
  SceneNearness Nearest(std::span<const Pose> X_W, const NearestOptions& options = {}) noexcept;

  /// The distance of each point of a part (m, in W as it stood at first) from all others; infinity
  /// beyond the range.
  void Distances(std::size_t part, std::span<const std::array<float, 3>> points_W,
                 std::span<const Pose> X_W, std::span<float> distances) const noexcept;

  /// The fixture's voxels near each of the moving parts, one part after the other.
  ShadowCount Shadow(std::span<const Pose> X_W, double distance,
                     std::span<Vec3> centres_W) noexcept;

 private:
  struct Pair {
    std::size_t a, b;  // b: the fixture, or the larger of two
    ProximityPair of;
  };
  Pose DisplacementOf(std::size_t part, std::span<const Pose> X_W) const noexcept;
  /// Takes a pair's nearness into `least`, seen from one of its parts.
  void Take(Pair& pair, std::size_t part, std::span<const Pose> X_W, const NearestOptions& options,
            SceneNearness& least) const noexcept;

  std::shared_ptr<const std::vector<ProximityPart>> parts_;
  std::vector<Pair> pairs_;
};

}  // namespace tandem
