#include "app/judgement/path_distance.h"

#include <algorithm>
#include <map>
#include <utility>

#include "app/judgement/penetration_oracle.h"
#include "engine/base/units.h"
#include "engine/realtime/clock.h"

namespace tandem {

namespace {

constexpr std::size_t kMostTrianglesForDepths = 300'000;  // triangles of all bodies
constexpr double kRoundingShare = 1e-9;                   // share of a bound
constexpr double kRoundingLength = 1e-12;                 // m

Pose PlaceOf(int body, const std::vector<Pose>& bodies_WB) {
  return body < 0 ? Pose{} : bodies_WB[static_cast<std::size_t>(body)];
}

}  // namespace

double MostMoved(const Pose& from_WB, const Pose& to_WB, double radius) noexcept {
  const double half_sine = (from_WB.q.conjugate() * to_WB.q).vec().norm();
  return (to_WB.p - from_WB.p).norm() + 2 * half_sine * radius;
}

PathMeshes::PathMeshes(std::shared_ptr<const WorldModel> model) : model_(std::move(model)) {
  for (std::size_t b = 0; b < model_->bodies.size(); ++b) {
    const TriangleMesh mesh_B = MeshOf(static_cast<int>(b));
    double radius = 0;
    for (const Vec3& p_B : mesh_B.vertices) radius = std::max(radius, p_B.norm());
    radius_.push_back(radius);
    trees_.emplace_back(mesh_B);
  }
  trees_.emplace_back();
  if (model_->has_fixture) trees_.back() = MeshTree(MeshOf(kFixture));
}

TriangleMesh PathMeshes::MeshOf(int body) const {
  TriangleMesh mesh;
  const Pose X_BW =
      body == kFixture ? Pose{} : model_->bodies[static_cast<std::size_t>(body)].X_WB0.Inverse();
  for (std::size_t i = 0; i < model_->meshes_W.size(); ++i) {
    if (model_->body_index[i] == body) Append(mesh, Transformed(model_->meshes_W[i], X_BW));
  }
  return mesh;
}

PathDistance::PathDistance(std::shared_ptr<const PathMeshes> meshes)
    : meshes_(std::move(meshes)),
      searched_(meshes_->model().bodies.size() * (meshes_->model().bodies.size() + 1)) {}

void PathDistance::See(std::size_t body, const std::vector<Pose>& bodies_WB, std::int64_t at_ns) {
  const WorldModel& model = meshes_->model();
  if (model.has_fixture) SeePair(body, PathMeshes::kFixture, bodies_WB, at_ns);
  for (std::size_t other = 0; other < model.bodies.size(); ++other) {
    if (other != body) SeePair(body, static_cast<int>(other), bodies_WB, at_ns);
  }
}

void PathDistance::SeePair(std::size_t body, int other, const std::vector<Pose>& bodies_WB,
                           std::int64_t at_ns) {
  Searched& last = SearchedOf(body, other);
  const Pose& X_WB = bodies_WB[body];
  const Pose X_WO = PlaceOf(other, bodies_WB);
  double at_most = std::numeric_limits<double>::infinity();
  if (last.known) {
    double moved = MostMoved(last.X_WB, X_WB, meshes_->radius(body));
    if (other >= 0) {
      moved += MostMoved(last.X_WO, X_WO, meshes_->radius(static_cast<std::size_t>(other)));
    }
    // a pair that crosses is searched again as soon as it moves, because its depth is wanted
    const double room = last.distance - moved;
    if (moved <= 0 || (room > 0 && room >= nearest_.distance)) return;
    at_most = (1 + kRoundingShare) * (last.distance + moved) + kRoundingLength;
  }
  ++searches_;
  const Pose X_OB = X_WO.Inverse() * X_WB;
  const MeshTree& part = meshes_->TreeOf(static_cast<int>(body));
  const MeshTree& others = meshes_->TreeOf(other);
  ClosestPoints closest = FindClosestPoints(part, X_OB, others, {.at_most = at_most});
  // rounding may have hidden everything as far as the bound
  if (closest.distance > at_most) closest = FindClosestPoints(part, X_OB, others, {});
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
  const WorldModel& model = meshes_->model();
  std::size_t triangles = 0;
  for (const TriangleMesh& mesh : model.meshes_W) triangles += mesh.triangles.size();
  if (triangles > kMostTrianglesForDepths) return std::nullopt;
  std::map<std::pair<std::size_t, int>, std::vector<const NearestPlace*>> by_pair;
  for (const NearestPlace& place : met_) by_pair[{place.body, place.other}].push_back(&place);
  const std::int64_t begin_ns = MonotonicNowNs();
  DeepestPlace deepest;
  for (const auto& [pair, places] : by_pair) {
    const auto [body, other] = pair;
    std::vector<std::vector<Pose>> poses_OB(1);
    for (const NearestPlace* place : places) {
      poses_OB[0].push_back(PlaceOf(other, place->bodies_WB).Inverse() * place->bodies_WB[body]);
    }
    const TriangleMesh part_B = meshes_->MeshOf(static_cast<int>(body));
    const double voxel = SampledVoxel(part_B, model.scene.voxel_size);
    const PenetrationOracle oracle(meshes_->MeshOf(other), part_B, voxel);
    PenetrationReport report = oracle.Check(poses_OB, 1, [&] {
      return ToSeconds(MonotonicNowNs() - begin_ns) > seconds;
    });
    oracle.Refine(poses_OB, report);
    const double depth = voxel * report.max_penetration_voxels;
    if (depth <= deepest.depth) continue;
    deepest = {depth, voxel * report.error_voxels, *places[report.worst_pose]};
    deepest.place.p_W = PlaceOf(other, deepest.place.bodies_WB) * report.p_FWorst;
  }
  return deepest;
}

}  // namespace tandem
