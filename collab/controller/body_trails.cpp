#include "collab/controller/body_trails.h"

#include <algorithm>

namespace tandem {

namespace {

double TravelBetween(double radius, const Pose& from, const Pose& to) {
  return TravelOf(to.p - from.p, from.q.angularDistance(to.q), radius);
}

}  // namespace

double BodyTrails::Travel(int moving, const Pose& from, const Pose& to) const {
  return TravelBetween(trails_[static_cast<std::size_t>(moving)].radius, from, to);
}

void BodyTrails::See(const SimulationFacts& facts, const ControlScene& scene) {
  if (trails_.size() != facts.body_count || scene_number_ != scene.number) {
    scene_number_ = scene.number;
    trails_.assign(facts.body_count, {});
    for (const ControlScene::Body& body : scene.bodies) {
      if (body.moving < 0 || static_cast<std::uint32_t>(body.moving) >= facts.body_count) continue;
      Trail& trail = trails_[static_cast<std::size_t>(body.moving)];
      trail.radius = std::max(trail.radius, body.radius);
      trail.poses = {body.X_WB0};
    }
  }
  for (std::size_t i = 0; i < trails_.size(); ++i) {
    if (!trails_[i].poses.empty()) Note(trails_[i], facts.bodies[i].X_WB);
  }
}

void BodyTrails::Note(Trail& trail, const Pose& X_WB) {
  const auto is_near = [&](const Pose& pose) {
    // the travel is at least the distance, which is quickly found
    return (pose.p - X_WB.p).squaredNorm() < kStep * kStep &&
           TravelBetween(trail.radius, pose, X_WB) < kStep;
  };
  if (is_near(trail.poses.back())) return;
  trail.moved = ++steps_;
  const auto back = std::ranges::find_if(trail.poses, is_near);
  if (back != trail.poses.end()) {
    trail.poses.erase(back + 1, trail.poses.end());
    return;
  }
  trail.poses.push_back(X_WB);
  if (trail.poses.size() < kMost) return;
  // every second pose, the first and the last among them
  std::vector<Pose> fewer;
  for (std::size_t i = 0; i < trail.poses.size(); i += 2) fewer.push_back(trail.poses[i]);
  if (trail.poses.size() % 2 == 0) fewer.push_back(trail.poses.back());
  trail.poses = std::move(fewer);
}

std::vector<int> BodyTrails::Displaced() const {
  std::vector<int> displaced;
  for (std::size_t i = 0; i < trails_.size(); ++i) {
    if (trails_[i].poses.size() > 1) displaced.push_back(static_cast<int>(i));
  }
  std::ranges::sort(displaced, [this](int a, int b) {
    return trails_[static_cast<std::size_t>(a)].moved > trails_[static_cast<std::size_t>(b)].moved;
  });
  return displaced;
}

}  // namespace tandem
