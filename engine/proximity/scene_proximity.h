#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/result.h"
#include "engine/proximity/proximity.h"

/// Proximity of the parts of a whole scene (paper §3.1).
namespace tandem {

/// A body of a scene in its first pose.
struct ProximityBody {
  std::string name;
  bool fixed = false;
  TriangleMesh mesh_W;
  std::optional<std::size_t> part_of = std::nullopt;  // body that it moves with
};

/// A part for proximity: all fixed bodies together, as in the simulation, or one moving body with
/// its parts.
struct ProximityPart {
  std::string name;                 // "fixture" where several bodies are fixed
  std::vector<std::size_t> bodies;  // numbers in the scene; the displacement of the first counts
  bool fixed = false;
  ProximityShape shape;
};

/// Called before each part is voxelized; returns whether to go on.
using ProximityProgress =
    std::function<bool(std::size_t done, std::size_t total, const std::string& part)>;

/// Voxelizes the bodies: the fixture first, if there is one, then the moving bodies in order. An
/// error names the part.
Result<std::vector<ProximityPart>> MakeProximityParts(const std::vector<ProximityBody>& bodies,
                                                      double voxel_size, int range_voxels,
                                                      const ProximityProgress& progress);

/// The nearness of a part to another, in W. The exact distance lies in [least, most].
struct SceneNearness {
  static constexpr std::size_t kNone = ~std::size_t{0};
  std::size_t part = kNone;                                   // a moving part
  std::size_t other = kNone;                                  // kNone: there is no other part
  double distance = std::numeric_limits<double>::infinity();  // m
  double least = 0;
  double most = std::numeric_limits<double>::infinity();
  Vec3 p_WPart = Vec3::Zero();
  Vec3 p_WOther = Vec3::Zero();
  Vec3 gradient_W = Vec3::Zero();  // direction in which the part gains distance fastest
  bool overlap = false;
  bool refined = false;
  double depth = 0;  // m, as in Nearness

  double error_bound() const { return std::max(most - distance, distance - least); }
};

/// Answers queries over all parts. Used by one thread; no call allocates. `X_W` holds each body's
/// displacement since its voxelization, by its number in the scene; fixed bodies have none.
class SceneProximity {
 public:
  explicit SceneProximity(std::shared_ptr<const std::vector<ProximityPart>> parts);

  const std::vector<ProximityPart>& parts() const noexcept { return *parts_; }
  /// Returns the range of the fields, m.
  double range() const noexcept;

  /// Returns the nearness of one moving part to whatever is nearest to it.
  SceneNearness NearestTo(std::size_t part, std::span<const Pose> X_W,
                          const NearestOptions& options = {}) noexcept;
  /// Returns the least nearness of all parts.
  SceneNearness Nearest(std::span<const Pose> X_W, const NearestOptions& options = {}) noexcept;

  /// Finds for each point of a part the distance to the nearest other part, m; infinity beyond the
  /// range. `points_W`: the points in W, with the part at its first pose.
  void Distances(std::size_t part, std::span<const std::array<float, 3>> points_W,
                 std::span<const Pose> X_W, std::span<float> distances) const noexcept;

  /// Finds the fixture's voxels near each of the moving parts, one part after the other.
  ShadowCount Shadow(std::span<const Pose> X_W, double distance,
                     std::span<Vec3> centres_W) noexcept;

 private:
  struct Pair {
    std::size_t a, b;  // b: the fixture, or the larger part
    ProximityPair of;
  };
  Pose DisplacementOf(std::size_t part, std::span<const Pose> X_W) const noexcept;
  /// Takes a pair's nearness into `least` if it is less, seen from one of its parts.
  void Take(Pair& pair, std::size_t part, std::span<const Pose> X_W, const NearestOptions& options,
            SceneNearness& least) const noexcept;

  std::shared_ptr<const std::vector<ProximityPart>> parts_;
  std::vector<Pair> pairs_;
};

}  // namespace tandem
