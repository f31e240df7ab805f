#include "app/bench/fidelity/push_judge.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "engine/geometry/exact/tree_pair.h"
#include "engine/geometry/mesh/closest_on_triangle.h"

namespace tandem {

namespace {

constexpr double kTieVoxels = 0.02;       // surfaces this close count as equally near
constexpr double kTouchingVoxels = 1e-3;  // places this close count as the same
constexpr double kOnSurfaceVoxels = 5e-3;
constexpr double kFartherVoxels = 0.6;
constexpr double kAskewDeg = 10;

using Corners = std::array<Vec3, 3>;

/// A triangle and its distance from a place, m.
struct Near {
  const Corners* corners;
  Vec3 nhat;
  OnTriangle closest;
  double distance;
};

/// Returns the triangles that are within `more` of the nearest one's distance, the nearest first.
/// It leaves out triangles without area, because their neighbours have their edges.
std::vector<Near> NearestTriangles(const MeshTree& mesh, const Vec3& p, double more) {
  std::vector<Near> found;
  double least = std::numeric_limits<double>::infinity();
  VisitNearLeaves(mesh.tree, p, least, [&](const BoxTree::Node& leaf) {
    for (std::size_t i = leaf.first; i < leaf.first + leaf.count; ++i) {
      const Corners& t = mesh.triangles[i];
      const Vec3 across = (t[1] - t[0]).cross(t[2] - t[0]);
      if (!(across.norm() > 1e-8 * (t[1] - t[0]).norm() * (t[2] - t[0]).norm())) continue;
      const OnTriangle closest = ClosestOnTriangle(t[0], t[1], t[2], p);
      const double distance = (closest.point - p).norm();
      if (distance > least + more) continue;
      least = std::min(least, distance);
      found.push_back({&t, across.normalized(), closest, distance});
    }
    return (least + more) * (least + more);
  });
  std::erase_if(found, [&](const Near& near) {
    return near.distance > least + more;
  });
  std::sort(found.begin(), found.end(), [](const Near& a, const Near& b) {
    return a.distance < b.distance;
  });
  return found;
}

/// Returns whether the surface goes on from a triangle's closest point to places that are nearer.
bool GoesOnNearer(const Near& near, const std::vector<Near>& all, double touching) {
  if (near.closest.on_face) return false;
  return std::any_of(all.begin(), all.end(), [&](const Near& other) {
    if (other.distance >= near.distance - 1e-6 * touching) return false;
    const Corners& t = *other.corners;
    const Vec3 met = ClosestOnTriangle(t[0], t[1], t[2], near.closest.point).point;
    return (met - near.closest.point).norm() < touching;
  });
}

}  // namespace

void FalsePushes::Count(const JudgedPush& push, double pushed) {
  const bool is_farther = push.distance_voxels > kFartherVoxels;
  const bool is_askew = push.askew_deg > kAskewDeg;
  ++contacts;
  farther += is_farther ? 1 : 0;
  askew += is_askew ? 1 : 0;
  force += pushed;
  false_force += is_farther || is_askew ? pushed : 0;
}

FalsePushes& FalsePushes::operator+=(const FalsePushes& other) {
  contacts += other.contacts;
  farther += other.farther;
  askew += other.askew;
  force += other.force;
  false_force += other.false_force;
  return *this;
}

PushJudge::Surface::Surface(const TriangleMesh& of) : mesh(of), winding(of) {}

PushJudge::Surface::Ways PushJudge::Surface::At(const Vec3& p, double tie, double touching) const {
  const std::vector<Near> near = NearestTriangles(mesh, p, tie);
  const double out = winding.At(p) >= 0.5 ? -1.0 : 1.0;
  Ways ways{near.empty() ? std::numeric_limits<double>::infinity() : near[0].distance, {}};
  for (const Near& triangle : near) {
    // on the surface itself only the faces tell a direction
    if (triangle.distance < 1e-3 * touching) {
      ways.off.push_back(triangle.nhat);
    } else if (!GoesOnNearer(triangle, near, touching)) {
      ways.off.push_back(out / triangle.distance * (p - triangle.closest.point));
    }
  }
  return ways;
}

PushJudge::PushJudge(const TriangleMesh& map_W, const TriangleMesh& shell_B, double voxel_size)
    : s_(voxel_size), map_(map_W), shell_(shell_B) {}

JudgedPush PushJudge::Judge(const Vec3& p_W, const Vec3& nhat_W, const Pose& X_WB) const {
  const double tie = kTieVoxels * s_;
  const double touching = kTouchingVoxels * s_;
  const Surface::Ways off_map = map_.At(p_W, tie, touching);
  const Surface::Ways off_shell = shell_.At(X_WB.Inverse() * p_W, tie, touching);
  // A place on one surface tells the direction off the other. A place on both or on neither tells
  // the directions off either.
  const bool on_map = off_map.distance < kOnSurfaceVoxels * s_;
  const bool on_shell = off_shell.distance < kOnSurfaceVoxels * s_;
  std::vector<Vec3> right_W;
  if (on_shell || !on_map) right_W = off_map.off;
  if (on_map || !on_shell) {
    for (const Vec3& off_B : off_shell.off) right_W.emplace_back(-(X_WB.q * off_B));
  }
  return {(off_map.distance + off_shell.distance) / s_, AngleFromCone(nhat_W, right_W)};
}

double AngleFromCone(const Vec3& unit, const std::vector<Vec3>& spanning) {
  constexpr double kDegrees = 180 / std::numbers::pi;
  constexpr int kSweeps = 200;
  if (spanning.empty()) return 180;
  double nearest = -1;  // cosine
  for (const Vec3& way : spanning) nearest = std::max(nearest, way.dot(unit));
  // the combination of the vectors with shares of at least 0 that comes nearest
  std::vector<double> shares(spanning.size(), 0.0);
  Vec3 left = unit;
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    for (std::size_t i = 0; i < spanning.size(); ++i) {
      const double share = std::max(0.0, shares[i] + spanning[i].dot(left));
      left -= (share - shares[i]) * spanning[i];
      shares[i] = share;
    }
  }
  const double of_nearest = std::acos(std::clamp(nearest, -1.0, 1.0));
  const double sum = (unit - left).norm();
  return kDegrees * (sum > 0 ? std::min(of_nearest, std::atan2(left.norm(), sum)) : of_nearest);
}

}  // namespace tandem
