#include "app/cli/path_distance.h"

#include <algorithm>
#include <utility>

#include "app/cli/penetration_oracle.h"
#include "engine/realtime/clock.h"

namespace tandem {

namespace {

constexpr std::size_t kMostTrianglesForDepths = 300'000;  // of all bodies
constexpr double kRoundingShare = 1e-9;                   // of a bound
constexpr double kRoundingLength = 1e-12;                 // m

Pose PlaceOf(int body, const std::vector<Pose>& bodies_WB) {
  return body < 0 ? Pose{} : bodies_WB[static_cast<std::size_t>(body)];
}

}  // namespace

double MostMoved(const Pose& from_WB, const Pose& to_WB, double radius) noexcept {
  const double half_sine = (from_WB.q.conjugate() * to_WB.q).vec().norm();
  return (to_WB.p - from_WB.p).norm() + 2 * half_sine * radius;
}

PathDistance::PathDistance(std::shared_ptr<const WorldModel> model)
    : model_(std::move(model)),
      trees_(model_->bodies.size() + 1),
      searched_(model_->bodies.size() * trees_.size()) {
  for (std::size_t b = 0; b < model_->bodies.size(); ++b) {
    double radius = 0;
    for (const Vec3& p_B : MeshOf(static_cast<int>(b)).vertices) {
      radius = std::max(radius, p_B.norm());
    }
    radius_.push_back(radius);
  }
}

TriangleMesh PathDistance::MeshOf(int body) const {
  TriangleMesh mesh;
  const Pose X_BW =
      body < 0 ? Pose{} : model_->bodies[static_cast<std::size_t>(body)].X_WB0.Inverse();
  for (std::size_t i = 0; i < model_->meshes_W.size(); ++i) {
    if (model_->body_index[i] == body) Append(mesh, Transformed(model_->meshes_W[i], X_BW));
  }
  return mesh;
}

const MeshTree& PathDistance::TreeOf(int body) {
  std::unique_ptr<MeshTree>& tree =
      trees_[body < 0 ? trees_.size() - 1 : static_cast<std::size_t>(body)];
  if (!tree) tree = std::make_unique<MeshTree>(MeshOf(body));
  return *tree;
}

void PathDistance::See(std::size_t body, const std::vector<Pose>& bodies_WB, std::int64_t at_ns) {
  if (model_->has_fixture) SeePair(body, kFixture, bodies_WB, at_ns);
  for (std::size_t other = 0; other < model_->bodies.size(); ++other) {
    if (other != body) SeePair(body, static_cast<int>(other), bodies_WB, at_ns);
  }
}

void PathDistance::SeePair(std::size_t body, int other, const std::vector<Pose>& bodies_WB,
                           std::int64_t at_ns) {
  const std::size_t column = other < 0 ? trees_.size() - 1 : static_cast<std::size_t>(other);
  Searched& last = searched_[body * trees_.size() + column];
  const Pose& X_WB = bodies_WB[body];
  const Pose X_WO = PlaceOf(other, bodies_WB);
  double at_most = std::numeric_limits<double>::infinity();
  if (last.known) {
    double moved = MostMoved(last.X_WB, X_WB, radius_[body]);
    if (other >= 0) moved += MostMoved(last.X_WO, X_WO, radius_[column]);
    // a pair that crosses is searched again as soon as it moves, for its depth
    const double room = last.distance - moved;
    if (moved <= 0 || (room > 0 && room >= nearest_.distance)) return;
    at_most = (1 + kRoundingShare) * (last.distance + moved) + kRoundingLength;
  }
  ++searches_;
  const Pose X_OB = X_WO.Inverse() * X_WB;
  ClosestPoints closest =
      FindClosestPoints(TreeOf(static_cast<int>(body)), X_OB, TreeOf(other), {.at_most = at_most});
  if (closest.distance > at_most) {
    closest = FindClosestPoints(TreeOf(static_cast<int>(body)), X_OB, TreeOf(other), {});
  }
  last = {.known = true, .X_WB = X_WB, .X_WO = X_WO, .distance = closest.distance};
  const bool meet = closest.distance <= 0;
  if (!meet && closest.distance >= nearest_.distance) return;
  NearestPlace place{.distance = closest.distance,
                     .body = body,
                     .other = other,
                     .at_ns = at_ns,
                     .bodies_WB = bodies_WB,
                     .p_W = X_WO * (0.5 * (closest.p_BA + closest.p_BB))};
  if (meet) AddMet(place);
  if (closest.distance < nearest_.distance) nearest_ = std::move(place);
}

void PathDistance::AddMet(const NearestPlace& place) {
  if (met_given_++ % stride_ != 0) return;
  met_.push_back(place);
  if (met_.size() < kMostMet) return;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < met_.size(); i += 2) met_[kept++] = met_[i];
  met_.resize(kept);
  stride_ *= 2;
}

std::optional<DeepestPlace> PathDistance::Deepest(double seconds) const {
  std::size_t triangles = 0;
  for (const TriangleMesh& mesh : model_->meshes_W) triangles += mesh.triangles.size();
  if (triangles > kMostTrianglesForDepths) return std::nullopt;
  const std::int64_t begin_ns = MonotonicNowNs();
  DeepestPlace deepest;
  std::vector<bool> done(searched_.size(), false);
  for (const NearestPlace& first : met_) {
    const std::size_t pair =
        first.body * trees_.size() +
        (first.other < 0 ? trees_.size() - 1 : static_cast<std::size_t>(first.other));
    if (done[pair]) continue;
    done[pair] = true;
    std::vector<std::vector<Pose>> poses_OB(1);
    std::vector<const NearestPlace*> places;
    for (const NearestPlace& place : met_) {
      if (place.body != first.body || place.other != first.other) continue;
      places.push_back(&place);
      poses_OB[0].push_back(PlaceOf(place.other, place.bodies_WB).Inverse() *
                            place.bodies_WB[place.body]);
    }
    const TriangleMesh part_B = MeshOf(static_cast<int>(first.body));
    const double voxel = SampledVoxel(part_B, model_->scene.voxel_size);
    const PenetrationReport report =
        PenetrationOracle(MeshOf(first.other), part_B, voxel).Check(poses_OB, 1, [&] {
          return 1e-9 * static_cast<double>(MonotonicNowNs() - begin_ns) > seconds;
        });
    const double depth = voxel * report.max_penetration_voxels;
    if (depth <= deepest.depth) continue;
    deepest = {depth, *places[report.worst_pose]};
    deepest.place.p_W = PlaceOf(first.other, deepest.place.bodies_WB) * report.p_FWorst;
  }
  return deepest;
}

}  // namespace tandem
