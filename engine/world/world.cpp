#include "engine/world/world.h"

#include <algorithm>

#include "engine/base/check.h"

namespace tandem {

World::World(std::shared_ptr<const WorldModel> model) : model_(std::move(model)) {
  const std::vector<BodyModel>& bodies = model_->bodies;
  const int layer = model_->scene.force_layer;
  const auto gains_for = [this](double mass) {
    return DefaultContactGains(model_->scene.voxel_size, mass, kFrame);
  };
  bodies_.resize(bodies.size());
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    bodies_[b].state.X_WB = bodies[b].X_WB0;
    const int body = static_cast<int>(b);
    if (model_->has_fixture) {
      const Pose X_WV{Quat::Identity(), model_->fixture.p_WVo()};
      const ContactGains gains = gains_for(bodies[b].inertia.mass);
      pairs_.push_back({{bodies[b].points, model_->fixture, X_WV, layer, gains}, body, -1});
    }
    // the body with fewer points is the pointshell, for speed (paper §2.1)
    for (std::size_t other = 0; other < b; ++other) {
      const bool smaller = bodies[b].points.size() <= bodies[other].points.size();
      const std::size_t shell = smaller ? b : other;
      const std::size_t map = smaller ? other : b;
      const ContactGains gains =
          gains_for(std::max(bodies[b].inertia.mass, bodies[other].inertia.mass));
      pairs_.push_back({{bodies[shell].points, bodies[map].voxmap, bodies[map].X_BV, layer, gains},
                        static_cast<int>(shell),
                        static_cast<int>(map)});
    }
  }
}

void World::Place(std::size_t body, const Pose& X_WB) {
  TANDEM_CHECK(body < bodies_.size());
  bodies_[body].state = {X_WB, {}};
}

const StepReport& World::Step(const StepInputs& in) noexcept {
  report_ = {};
  for (Body& body : bodies_) body.load = {};
  ShareTravel(in);
  if (contact_on_) Collide(in);
  Couple(in);
  Move(in);
  return report_;
}

void World::ShareTravel(const StepInputs& in) noexcept {
  // what shrinks a gap is what both bodies of a pair travel: half a voxel between them (paper §5)
  const double bound = 0.5 * model_->scene.voxel_size;
  for (Body& body : bodies_) body.max_travel = bound;
  for (const Pair& pair : pairs_) {
    if (pair.map < 0) continue;
    const auto shell = static_cast<std::size_t>(pair.shell);
    const auto map = static_cast<std::size_t>(pair.map);
    if (in.bodies[shell].drive == BodyDrive::kParked ||
        in.bodies[map].drive == BodyDrive::kParked) {
      continue;
    }
    bodies_[shell].max_travel = std::min(bodies_[shell].max_travel, 0.5 * bound);
    bodies_[map].max_travel = std::min(bodies_[map].max_travel, 0.5 * bound);
  }
}

void World::Collide(const StepInputs& in) noexcept {
  const BodyMotion fixture{};
  Load on_fixture;
  for (Pair& pair : pairs_) {
    const auto shell = static_cast<std::size_t>(pair.shell);
    const bool shell_simulated = in.bodies[shell].drive == BodyDrive::kSimulated;
    const BodyMotion shell_motion{bodies_[shell].state.X_WB, bodies_[shell].state.V_WB};
    PairReport found;
    if (pair.map < 0) {
      if (!shell_simulated) continue;
      found = pair.contact.Collide(shell_motion, fixture, bodies_[shell].load, on_fixture);
    } else {
      const auto map = static_cast<std::size_t>(pair.map);
      if (!shell_simulated && in.bodies[map].drive != BodyDrive::kSimulated) continue;
      const BodyMotion map_motion{bodies_[map].state.X_WB, bodies_[map].state.V_WB};
      found =
          pair.contact.Collide(shell_motion, map_motion, bodies_[shell].load, bodies_[map].load);
    }
    report_.contact_points += found.contact_points;
    report_.loaded_points += found.loaded_points;
  }
  if (in.hand.body >= 0) {
    report_.contact_B_W = AsWrench(bodies_[static_cast<std::size_t>(in.hand.body)].load.force);
  }
}

void World::Couple(const StepInputs& in) noexcept {
  if (in.hand.body < 0) return;
  Body& held = bodies_[static_cast<std::size_t>(in.hand.body)];
  hand_load_ = CouplingLoad(in.hand.gains, held.state, in.hand.X_BD, in.hand.goal);
  held.load += hand_load_;
  for (std::size_t k = 0; k < in.link_count; ++k) {
    link_loads_[k] = CouplingLoad(in.links[k].gains, held.state, Pose{}, in.links[k].copy);
    held.load += link_loads_[k];
  }
  held.load += GroundDamping(in.ground_damping, in.ground_rotation_damping, held.state);
}

void World::Move(const StepInputs& in) noexcept {
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    Body& body = bodies_[b];
    const BodyModel& model = model_->bodies[b];
    const double radius = model.points.radius;
    if (in.bodies[b].drive == BodyDrive::kParked) {
      body.state.V_WB = {};
      continue;
    }
    if (in.bodies[b].drive == BodyDrive::kMirrored) {
      Follow(body.state, in.bodies[b].mirror_WB, kFrame, radius, body.max_travel);
      continue;
    }
    const Twist before = body.state.V_WB;
    const Twist wanted = ImplicitTwist(model.inertia, body.state, body.load, kFrame);
    Advance(body.state, wanted, kFrame, radius, body.max_travel);
    const Twist& after = body.state.V_WB;
    if (after.v != wanted.v || after.w != wanted.w) report_.flags |= StepReport::kTravelLimited;
    if (in.hand.body != static_cast<int>(b)) continue;
    report_.hand_B_W = AppliedWrench(hand_load_, before, after, kFrame);
    for (std::size_t k = 0; k < in.link_count; ++k) {
      report_.links_B_W[k] = AppliedWrench(link_loads_[k], before, after, kFrame);
    }
  }
}

}  // namespace tandem
