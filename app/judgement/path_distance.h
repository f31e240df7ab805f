#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "engine/geometry/exact/mesh_tree.h"
#include "engine/world/world_model.h"

namespace tandem {

/// The place where a moving body came nearest to another body.
struct NearestPlace {
  /// m, between the triangles of both; 0 where they touch or cross, infinity where none was seen
  double distance = std::numeric_limits<double>::infinity();
  std::size_t body = 0;         // index into WorldModel::bodies
  int other = -1;               // index likewise; -1: the fixture
  std::int64_t at_ns = 0;       // time of that pose
  std::vector<Pose> bodies_WB;  // poses of all moving bodies at that time
  Vec3 p_W = Vec3::Zero();      // m, middle between the two nearest points
};

/// The greatest depth of a body in another along a path.
struct DeepestPlace {
  double depth = 0;  // m
  double error = 0;  // m, by which it may be deeper at that pose
  NearestPlace place;
};

/// Returns the farthest that a point within `radius` (m) of B's origin moves from one pose to the
/// other, m.
double MostMoved(const Pose& from_WB, const Pose& to_WB, double radius) noexcept;

/// Keeps the exact surfaces of a scene for distance queries. Read-only once built.
class PathMeshes {
 public:
  static constexpr int kFixture = -1;

  explicit PathMeshes(std::shared_ptr<const WorldModel> model);

  const WorldModel& model() const noexcept { return *model_; }
  /// Returns the index of a moving body, or of the fixture, which comes behind all of them.
  std::size_t Number(int body) const noexcept {
    return body == kFixture ? model_->bodies.size() : static_cast<std::size_t>(body);
  }
  /// Returns the mesh of a moving body in its frame, or of the fixture in W.
  TriangleMesh MeshOf(int body) const;
  const MeshTree& TreeOf(int body) const noexcept { return trees_[Number(body)]; }
  /// Returns the largest distance of a body's surface from its frame's origin, m.
  double radius(std::size_t body) const noexcept { return radius_[body]; }

 private:
  std::shared_ptr<const WorldModel> model_;
  std::vector<MeshTree> trees_;  // index is Number()
  std::vector<double> radius_;   // per moving body
};

/// Finds the least exact distance between a moving body and everything else, pose by pose (paper
/// §3.2). A distance changes by no more than points move. So a pose needs no search while the last
/// search leaves more room than the least distance so far.
class PathDistance {
 public:
  explicit PathDistance(std::shared_ptr<const PathMeshes> meshes);

  /// Takes the next pose of a body: `bodies_WB` are the places of all moving bodies.
  void See(std::size_t body, const std::vector<Pose>& bodies_WB, std::int64_t at_ns);

  const NearestPlace& nearest() const noexcept { return nearest_; }
  /// Returns the number of searches so far, each of one pair of bodies.
  std::size_t searches() const noexcept { return searches_; }
  /// Returns the deepest place of the poses at which the surfaces met, by samples of the body that
  /// are half a voxel apart, and its greatest depth there. The depth is 0 if no sample was inside.
  /// Of more than kMostMet poses it judges an even share. Nothing: the meshes are too large for it.
  /// Takes at most `seconds`, and the time of what is begun by then.
  std::optional<DeepestPlace> Deepest(double seconds) const;

 private:
  static constexpr std::size_t kMostMet = 20'000;
  /// The state of a pair at its last search.
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
  std::vector<NearestPlace> met_;  // poses at which surfaces met, one of every stride_
  std::size_t stride_ = 1;
  std::size_t met_given_ = 0;
  std::size_t searches_ = 0;
};

}  // namespace tandem
