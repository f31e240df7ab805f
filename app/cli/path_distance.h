#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "engine/geometry/mesh_tree.h"
#include "engine/world/world_model.h"

namespace tandem {

/// Where a moving body came nearest to another body.
struct NearestPlace {
  /// m, between the triangles of both; 0 where they touch or cross, infinity where nothing was seen
  double distance = std::numeric_limits<double>::infinity();
  std::size_t body = 0;         // into WorldModel::bodies
  int other = -1;               // likewise; -1: what is fixed
  std::int64_t at_ns = 0;       // time of that pose
  std::vector<Pose> bodies_WB;  // of all moving bodies at that time
  Vec3 p_W = Vec3::Zero();      // middle between the two nearest points, m
};

/// How deep a body went into another along a path.
struct DeepestPlace {
  double depth = 0;  // m
  NearestPlace place;
};

/// Returns the farthest that a point within `radius` (m) of B's origin moves from one pose to the
/// other, m.
double MostMoved(const Pose& from_WB, const Pose& to_WB, double radius) noexcept;

/// The exact surfaces of a scene for questions of distance. Read-only once built.
class PathMeshes {
 public:
  static constexpr int kFixture = -1;

  explicit PathMeshes(std::shared_ptr<const WorldModel> model);

  const WorldModel& model() const noexcept { return *model_; }
  /// Returns a moving body's number among all, behind which comes what is fixed.
  std::size_t Number(int body) const noexcept {
    return body == kFixture ? model_->bodies.size() : static_cast<std::size_t>(body);
  }
  /// Returns the mesh of a moving body in its frame, or of what is fixed in W.
  TriangleMesh MeshOf(int body) const;
  const MeshTree& TreeOf(int body) const noexcept { return trees_[Number(body)]; }
  /// Returns the largest distance of a body's surface from its frame's origin, m.
  double radius(std::size_t body) const noexcept { return radius_[body]; }

 private:
  std::shared_ptr<const WorldModel> model_;
  std::vector<MeshTree> trees_;  // by Number()
  std::vector<double> radius_;   // per moving body
};

/// The least exact distance between a moving body and everything else, pose by pose (paper §3.2).
/// Distance changes by no more than points move, so a pose needs no search while the last search
/// leaves more room than the least distance so far.
class PathDistance {
 public:
  explicit PathDistance(std::shared_ptr<const PathMeshes> meshes);

  /// Takes the next pose of a body: `bodies_WB` are the places of all moving bodies.
  void See(std::size_t body, const std::vector<Pose>& bodies_WB, std::int64_t at_ns);

  const NearestPlace& nearest() const noexcept { return nearest_; }
  /// Searches so far, one for a pair of bodies.
  std::size_t searches() const noexcept { return searches_; }
  /// Returns the deepest place of the poses at which the surfaces met, by samples of the body that
  /// are half a voxel apart; depth 0 where no sample was inside. Of more than kMostMet poses it
  /// judges an even share. Nothing: the meshes are too large for it. Takes `seconds` at the most,
  /// and what is begun by then.
  std::optional<DeepestPlace> Deepest(double seconds) const;

 private:
  static constexpr std::size_t kMostMet = 20'000;
  /// A pair as of its last search.
  struct Searched {
    bool known = false;
    Pose X_WB;
    Pose X_WO;
    double distance = 0;  // m
  };

  void SeePair(std::size_t body, int other, const std::vector<Pose>& bodies_WB, std::int64_t at_ns);
  void AddMet(const NearestPlace& place);

  Searched& SearchedOf(std::size_t body, int other) {
    return searched_[body * (meshes_->model().bodies.size() + 1) + meshes_->Number(other)];
  }

  std::shared_ptr<const PathMeshes> meshes_;
  std::vector<Searched> searched_;  // per pair
  NearestPlace nearest_;
  std::vector<NearestPlace> met_;  // poses at which surfaces met, each of stride_
  std::size_t stride_ = 1;
  std::size_t met_given_ = 0;
  std::size_t searches_ = 0;
};

}  // namespace tandem
