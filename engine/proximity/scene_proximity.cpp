#include "engine/proximity/scene_proximity.h"

#include <algorithm>

#include "engine/voxel/build/voxelize.h"

namespace tandem {

namespace {

double SizeOf(const ProximityPart& part) {
  const BoxTree& tree = part.shape.mesh.tree;
  return tree.nodes.empty() ? 0 : tree.nodes[0].box.size().squaredNorm();
}

/// The plan of one part.
struct PartPlan {
  std::string name;
  std::vector<std::size_t> bodies;
  bool fixed = false;
  TriangleMesh mesh_W;
};

void Add(PartPlan& plan, const std::vector<ProximityBody>& bodies, std::size_t body) {
  plan.bodies.push_back(body);
  Append(plan.mesh_W, bodies[body].mesh_W);
}

std::vector<PartPlan> PlanParts(const std::vector<ProximityBody>& bodies) {
  std::vector<PartPlan> plans;
  PartPlan fixture;
  fixture.fixed = true;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (bodies[i].part_of) continue;
    if (bodies[i].fixed) {
      Add(fixture, bodies, i);
      continue;
    }
    PartPlan& plan = plans.emplace_back();
    plan.name = bodies[i].name;
    Add(plan, bodies, i);
  }
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (!bodies[i].part_of) continue;
    for (PartPlan& plan : plans) {
      if (plan.bodies.front() == *bodies[i].part_of) Add(plan, bodies, i);
    }
    if (bodies[*bodies[i].part_of].fixed) Add(fixture, bodies, i);
  }
  if (!fixture.bodies.empty()) {
    const bool one = fixture.bodies.size() == 1;
    fixture.name = one ? bodies[fixture.bodies.front()].name : "fixture";
    plans.insert(plans.begin(), std::move(fixture));
  }
  return plans;
}

}  // namespace

Result<std::vector<ProximityPart>> MakeProximityParts(const std::vector<ProximityBody>& bodies,
                                                      double voxel_size, int range_voxels,
                                                      const ProximityProgress& progress) {
  const std::vector<PartPlan> plans = PlanParts(bodies);
  std::vector<ProximityPart> parts;
  for (const PartPlan& plan : plans) {
    if (!progress(parts.size(), plans.size(), plan.name)) {
      return Error{"voxelizing was given up"};
    }
    Result<Voxmap> map =
        Voxelize(plan.mesh_W,
                 {.voxel_size = voxel_size, .range = range_voxels, .bits = BitsFor(range_voxels)});
    if (!map) return Error{"'" + plan.name + "': " + map.error().what};
    parts.push_back({plan.name, plan.bodies, plan.fixed, {plan.mesh_W, std::move(*map)}});
  }
  return parts;
}

SceneProximity::SceneProximity(std::shared_ptr<const std::vector<ProximityPart>> parts)
    : parts_(std::move(parts)) {
  for (std::size_t i = 0; i < parts_->size(); ++i) {
    for (std::size_t j = i + 1; j < parts_->size(); ++j) {
      const ProximityPart& first = (*parts_)[i];
      const ProximityPart& second = (*parts_)[j];
      // overlap is detected where a enters b: the smaller part may lie within the larger
      const bool to_first = first.fixed || SizeOf(first) > SizeOf(second);
      const ProximityShape& a = to_first ? second.shape : first.shape;
      const ProximityShape& b = to_first ? first.shape : second.shape;
      pairs_.push_back({to_first ? j : i, to_first ? i : j, ProximityPair(a, b)});
    }
  }
}

double SceneProximity::range() const noexcept {
  if (parts_->empty()) return 0;
  const Voxmap& map = parts_->front().shape.voxmap;
  return map.range() * map.voxel_size();
}

Pose SceneProximity::DisplacementOf(std::size_t part, std::span<const Pose> X_W) const noexcept {
  const ProximityPart& of = (*parts_)[part];
  return of.fixed || of.bodies.front() >= X_W.size() ? Pose{} : X_W[of.bodies.front()];
}

void SceneProximity::Take(Pair& pair, std::size_t part, std::span<const Pose> X_W,
                          const NearestOptions& options, SceneNearness& least) const noexcept {
  const Pose Y_W = DisplacementOf(pair.b, X_W);
  const Nearness near = pair.of.Nearest(Y_W.Inverse() * DisplacementOf(pair.a, X_W), options);
  const double floor = least.other == SceneNearness::kNone ? near.least : least.least;
  least.least = std::min(floor, near.least);
  least.most = std::min(least.most, near.most);
  // the deeper one counts where pairs overlap
  const bool deeper = near.overlap && near.depth > least.depth;
  const bool nearer = near.distance < least.distance;
  if (least.other != SceneNearness::kNone && !nearer && !deeper) return;
  const bool is_a = part == pair.a;
  least.part = part;
  least.other = is_a ? pair.b : pair.a;
  least.distance = near.distance;
  least.p_WPart = Y_W * (is_a ? near.p_BA : near.p_BB);
  least.p_WOther = Y_W * (is_a ? near.p_BB : near.p_BA);
  least.gradient_W = (is_a ? 1.0 : -1.0) * (Y_W.q * near.gradient_B);
  least.overlap = near.overlap;
  least.refined = near.refined;
  least.depth = near.depth;
}

SceneNearness SceneProximity::NearestTo(std::size_t part, std::span<const Pose> X_W,
                                        const NearestOptions& options) noexcept {
  SceneNearness least;
  least.part = part;
  for (Pair& pair : pairs_) {
    if (pair.a == part || pair.b == part) Take(pair, part, X_W, options, least);
  }
  return least;
}

SceneNearness SceneProximity::Nearest(std::span<const Pose> X_W,
                                      const NearestOptions& options) noexcept {
  SceneNearness least;
  for (Pair& pair : pairs_) Take(pair, pair.a, X_W, options, least);
  return least;
}

void SceneProximity::Distances(std::size_t part, std::span<const std::array<float, 3>> points_W,
                               std::span<const Pose> X_W,
                               std::span<float> distances) const noexcept {
  std::fill(distances.begin(), distances.end(), std::numeric_limits<float>::infinity());
  const Pose X = DisplacementOf(part, X_W);
  for (std::size_t other = 0; other < parts_->size(); ++other) {
    if (other == part) continue;
    LowerDistances(points_W, DisplacementOf(other, X_W).Inverse() * X,
                   (*parts_)[other].shape.voxmap, distances);
  }
}

ShadowCount SceneProximity::Shadow(std::span<const Pose> X_W, double distance,
                                   std::span<Vec3> centres_W) noexcept {
  ShadowCount all;
  for (Pair& pair : pairs_) {
    if (!(*parts_)[pair.b].fixed) continue;
    const ShadowCount count =
        pair.of.Shadow(DisplacementOf(pair.a, X_W), distance, centres_W.subspan(all.written));
    all.found += count.found;
    all.written += count.written;
  }
  return all;
}

}  // namespace tandem
