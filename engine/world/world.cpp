#include "engine/world/world.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "engine/base/check.h"
#include "engine/world/body_pairs.h"
#include "engine/world/body_step.h"

namespace tandem {

namespace {

/// Travel where nothing is near, voxels a frame: half a hyperchunk (paper fn. 3).
constexpr double kFreeTravel = 32.0;

/// Returns the share of a pair's travel that falls to one body. A mirrored body gives way to
/// nothing, so the other gets the larger share to escape faster. Parked bodies need none.
double ShareOf(BodyDrive drive, BodyDrive other) {
  constexpr auto weight = [](BodyDrive of) {
    return of <= BodyDrive::kParked ? 0.0 : of == BodyDrive::kMirrored ? 0.3 : 0.7;
  };
  const double sum = weight(drive) + weight(other);
  return sum > 0 ? weight(drive) / sum : 0.5;
}

/// Tells whether the pair's pointshell is body `a`.
bool IsShell(const WorldModel& model, std::size_t a, std::size_t b) {
  return model.scene.IsPointshell(model.object[a], model.bodies[a].surface_points, model.object[b],
                                  model.bodies[b].surface_points);
}

}  // namespace

World::World(std::shared_ptr<const WorldModel> model, const ScheduleOptions& schedule)
    : model_(std::move(model)), together_(2 * model_->bodies.size()), helpers_(schedule.helpers) {
  const std::vector<BodyModel>& bodies = model_->bodies;
  bodies_.resize(bodies.size());
  if (model_->fixture_pages != nullptr) {
    auto resident = ResidentVoxels::Make(model_->fixture_pages, model_->voxel_memory_bytes);
    TANDEM_CHECK(resident);  // LoadWorld() has checked it
    resident_ = std::move(*resident);
  }
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    bodies_[b].state.X_WB = bodies[b].X_WB0;
    bodies_[b].shape = b;
    AddFixturePair(b, schedule);
    for (std::size_t other = 0; other < b; ++other) AddPair(b, other, schedule);
  }
  first_pairs_ = pairs_.size();
  // other peers may hold a shared body in two places at once
  for (std::size_t b = 0; b < bodies.size() && bodies.size() > 1; ++b) {
    if (model_->scene.bodies[model_->object[b]].shared) AddSecondInstance(b, schedule);
  }
  if (resident_ != nullptr) {
    resident_->Start();
    BringInVoxels();
  }
}

void World::AddSecondInstance(std::size_t body, const ScheduleOptions& schedule) {
  bodies_[body].second = static_cast<int>(bodies_.size());
  bodies_.push_back(bodies_[body]);
  bodies_.back().second = -1;
  AddFixturePair(bodies_.size() - 1, schedule);
  for (std::size_t other = 0; other < model_->bodies.size(); ++other) {
    if (other != body) AddPair(bodies_.size() - 1, other, schedule);
  }
}

void World::AddFixturePair(std::size_t body, const ScheduleOptions& schedule) {
  if (!model_->has_fixture) return;
  pairs_.push_back({MakeFixturePair(*model_, bodies_[body].shape, resident_.get(), schedule),
                    static_cast<int>(body), -1});
}

void World::AddPair(std::size_t a, std::size_t b, const ScheduleOptions& schedule) {
  const bool is_shell = IsShell(*model_, bodies_[a].shape, bodies_[b].shape);
  const std::size_t shell = is_shell ? a : b;
  const std::size_t map = is_shell ? b : a;
  pairs_.push_back({MakeMovingPair(*model_, bodies_[shell].shape, bodies_[map].shape, schedule),
                    static_cast<int>(shell), static_cast<int>(map)});
}

void World::BringInVoxels() {
  for (const Pair& pair : pairs_) {
    if (pair.map >= 0) continue;
    const RigidState& shell = bodies_[static_cast<std::size_t>(pair.shell)].state;
    pair.contact->Announce({shell.X_WB, shell.V_WB}, {});
  }
  resident_->WaitUntilThere();
}

std::string World::WhyVoxelsLack() const {
  const std::string* fault = resident_ != nullptr ? resident_->fault() : nullptr;
  return fault != nullptr ? *fault
                          : "voxels were not read in time: the disk is too slow, or the memory for "
                            "voxels too small; give more by --voxel-memory";
}

void World::WaitForVoxels() {
  if (resident_ != nullptr) resident_->WaitUntilThere();
}

const ContactPair& World::point_pair(std::size_t number) const {
  const auto* pair = dynamic_cast<const ContactPair*>(pairs_[number].contact.get());
  TANDEM_CHECK(pair != nullptr);
  return *pair;
}

const FieldPair& World::field_pair(std::size_t number) const {
  const auto* pair = dynamic_cast<const FieldPair*>(pairs_[number].contact.get());
  TANDEM_CHECK(pair != nullptr);
  return *pair;
}

BodyDrive World::DriveOf(const StepInputs& in, std::size_t body) const noexcept {
  if (body < in.bodies.size()) return in.bodies[body].drive;
  const StepInputs::BodyInput& first = in.bodies[bodies_[body].shape];
  const bool here = first.parted && first.drive >= BodyDrive::kMirrored;
  return here ? first.second_drive : BodyDrive::kAbsent;
}

bool World::IsSimulated(const StepInputs& in, int body) const noexcept {
  if (body < 0) return false;
  const BodyDrive drive = DriveOf(in, static_cast<std::size_t>(body));
  return drive == BodyDrive::kSimulated || drive == BodyDrive::kYielding;
}

void World::Place(std::size_t body, const Pose& X_WB) {
  TANDEM_CHECK(body < bodies_.size());
  bodies_[body].state = {X_WB, {}};
  if (resident_ != nullptr) BringInVoxels();
}

bool World::Touched(std::size_t body) const noexcept {
  return std::any_of(pairs_.begin(), pairs_.end(), [body](const Pair& pair) {
    const int b = static_cast<int>(body);
    return pair.pushes && (pair.shell == b || pair.map == b);
  });
}

bool World::Pushed(std::size_t body) const noexcept {
  return std::any_of(pairs_.begin(), pairs_.end(), [body](const Pair& pair) {
    const int b = static_cast<int>(body);
    return pair.pushes && pair.map >= 0 && (pair.shell == b || pair.map == b);
  });
}

const StepReport& World::Step(const StepInputs& in) noexcept {
  BeginFrame(in);
  UpdateClearances(in);
  if (!ComputeContactForces(in)) return EndFrameThatWaits();
  LimitTravel(in);
  ApplyCouplings(in);
  SolveVelocities(in);
  Integrate(in);
  ReportAppliedForces(in);
  return EndFrame();
}

void World::BeginFrame(const StepInputs& in) noexcept {
  report_ = {};
  held_loads_.Clear();
  for (Body& body : bodies_) body.load = {};
  for (Pair& pair : pairs_) pair.pushes = false;
  BeginSimulated(in);
  if (resident_ != nullptr) resident_->BeginFrame();
}

const StepReport& World::EndFrame() noexcept {
  waited_ = 0;
  if (helpers_ != nullptr) helpers_->Dismiss();
  return report_;
}

const StepReport& World::EndFrameThatWaits() noexcept {
  report_ = {};
  report_.flags = StepReport::kWaitsForVoxels;
  report_.waited = ++waited_;
  if (helpers_ != nullptr) helpers_->Dismiss();
  return report_;
}

void World::BeginSimulated(const StepInputs& in) noexcept {
  for (std::size_t b = 0; b < in.bodies.size(); ++b) {
    const BodyDrive before = std::exchange(bodies_[b].drive, in.bodies[b].drive);
    if (before == BodyDrive::kMirrored && bodies_[b].drive == BodyDrive::kSimulated) {
      bodies_[b].state.V_WB = in.bodies[b].begin_V_WB;
    }
  }
}

void World::UpdateClearances(const StepInputs& in) noexcept {
  if (waited_ > 0) return;  // a frame that waits has already done so
  const Clearance scenes{static_cast<double>(model_->scene.force_layer), 0.0};
  for (Body& body : bodies_) body.displaced = 0;
  for (Pair& pair : pairs_) {
    Clearance goal = scenes;
    const bool in_hand =
        in.hand.body >= 0 && (pair.shell == in.hand.body || pair.map == in.hand.body);
    if (in_hand) {
      const bool ordered = in.clearance.force_layer != StepInputs::HandClearance::kSceneLayer;
      goal = pair.contact->clearance_bounds().Within(in.clearance.force_layer,
                                                     in.clearance.displacement);
      if (!ordered) goal.layers = scenes.layers;
    }
    if (pair.contact->clearance() != goal) {
      pair.contact->SetClearance(
          Nearer(pair.contact->clearance(), goal, kFrame, model_->scene.voxel_size));
    }
    double& displaced = bodies_[static_cast<std::size_t>(pair.shell)].displaced;
    displaced = std::max(displaced, std::abs(pair.contact->clearance().displacement));
  }
}

void World::LimitTravel(const StepInputs& in) noexcept {
  TestLoad load;
  for (const Pair& pair : pairs_) {
    if (Tested(pair, in)) load += pair.contact->load();
  }
  load.bound = std::numeric_limits<double>::infinity();
  const double voxel = model_->scene.voxel_size;
  const double affordable = MaxTravel(load, in.capacity, in.look_price, voxel);
  if (affordable < 0.5 * voxel) report_.flags |= StepReport::kOverCapacity;
  for (Body& body : bodies_) body.max_travel = std::min(affordable, kFreeTravel * voxel);
  for (Pair& pair : pairs_) {
    // a pair that is not tested learns of all travel at its next test
    if (contact_on_ && !Tested(pair, in)) continue;
    const double travel =
        contact_on_ ? std::min(affordable, pair.contact->load().bound) : 0.5 * voxel;
    pair.contact->LimitTravel(travel);
    Body& shell = bodies_[static_cast<std::size_t>(pair.shell)];
    if (pair.map < 0) {
      shell.max_travel = std::min(shell.max_travel, travel);
      continue;
    }
    // both bodies of a pair shrink the gap by their travel
    Body& map = bodies_[static_cast<std::size_t>(pair.map)];
    const double share = ShareOf(DriveOf(in, static_cast<std::size_t>(pair.shell)),
                                 DriveOf(in, static_cast<std::size_t>(pair.map)));
    shell.max_travel = std::min(shell.max_travel, share * travel);
    map.max_travel = std::min(map.max_travel, (1.0 - share) * travel);
  }
}

bool World::Tested(const Pair& pair, const StepInputs& in) const noexcept {
  if (!IsSimulated(in, pair.shell) && !IsSimulated(in, pair.map)) return false;
  return DriveOf(in, static_cast<std::size_t>(pair.shell)) != BodyDrive::kAbsent &&
         (pair.map < 0 || DriveOf(in, static_cast<std::size_t>(pair.map)) != BodyDrive::kAbsent);
}

bool World::ComputeContactForces(const StepInputs& in) noexcept {
  if (!contact_on_) return true;
  bool all = true;
  const BodyMotion fixture{};
  Load on_fixture;
  for (Pair& pair : pairs_) {
    if (!Tested(pair, in)) {
      pair.contact->Rest();
      continue;
    }
    Body& shell = bodies_[static_cast<std::size_t>(pair.shell)];
    const BodyMotion shell_motion{shell.state.X_WB, shell.state.V_WB};
    PairReport found;
    if (pair.map < 0) {
      found = pair.contact->Collide(shell_motion, fixture, shell.load, on_fixture);
    } else {
      Body& map = bodies_[static_cast<std::size_t>(pair.map)];
      found = pair.contact->Collide(shell_motion, {map.state.X_WB, map.state.V_WB}, shell.load,
                                    map.load);
    }
    pair.pushes = found.loaded_points > 0;
    all = all && !found.waits;
    report_.tests += found.tests;
    if (found.over_capacity) report_.flags |= StepReport::kContactsFull;
    report_.contact_points += found.contact_points;
    report_.looks += found.looks;
    report_.look_work += found.look_work;
    report_.loaded_points += found.loaded_points;
  }
  if (in.hand.body >= 0) {
    held_loads_.SetContact(bodies_[static_cast<std::size_t>(in.hand.body)].load);
  }
  return all;
}

void World::ApplyCouplings(const StepInputs& in) noexcept {
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    if (DriveOf(in, b) != BodyDrive::kYielding) continue;
    const StepInputs::BodyInput& input = in.bodies[bodies_[b].shape];
    const bool first = b == bodies_[b].shape;
    bodies_[b].load += CouplingLoad(first ? input.pull : input.second_pull, bodies_[b].state,
                                    Pose{}, {first ? input.mirror_WB : input.second_WB, {}});
  }
  if (in.hand.body >= 0) {
    Body& held = bodies_[static_cast<std::size_t>(in.hand.body)];
    held_loads_.Couple(in, held.state, held.load);
  }
  for (std::size_t b = 0; b < in.bodies.size(); ++b) {
    if (in.bodies[b].drive != BodyDrive::kSimulated) continue;
    bodies_[b].load.force.tail<3>() += model_->bodies[b].inertia.mass * model_->scene.gravity_W;
  }
}

void World::SolveVelocities(const StepInputs& in) noexcept {
  SolveTogether(in);
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    Body& body = bodies_[b];
    if (!IsSimulated(in, static_cast<int>(b))) continue;
    body.before = body.state.V_WB;
    body.wanted = body.together ? together_.twist(b)
                                : TwistAlone(model_->bodies[body.shape], body.state, body.load);
  }
}

void World::SolveTogether(const StepInputs& in) noexcept {
  bool begun = false;
  for (const Pair& pair : pairs_) {
    if (!pair.pushes || !IsSimulated(in, pair.shell) || !IsSimulated(in, pair.map)) continue;
    if (!begun) together_.Begin();
    begun = true;
    const auto shell = static_cast<std::size_t>(pair.shell);
    const auto map = static_cast<std::size_t>(pair.map);
    for (const std::size_t b : {shell, map}) {
      if (together_.has(b)) continue;
      const BodyModel& model = model_->bodies[bodies_[b].shape];
      const RigidState& state = bodies_[b].state;
      const Mat6 basis =
          model.constraint ? AllowedBasis(*model.constraint, state.X_WB) : Mat6::Identity();
      together_.AddBody(b, EquationsOf(model, state, bodies_[b].load), state.V_WB, basis);
    }
    together_.Couple(shell, map, pair.contact->cross(), kFrame);
  }
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    bodies_[b].together = begun && together_.has(b);
  }
  if (!begun) return;
  together_.Solve();
  SumContactOfOthers(in);
}

/// Finds how the load on the held body changes as the bodies that it pushes move.
void World::SumContactOfOthers(const StepInputs& in) noexcept {
  for (const Pair& pair : pairs_) {
    if (!pair.pushes || !IsSimulated(in, pair.shell) || !IsSimulated(in, pair.map)) continue;
    const bool is_shell = pair.shell == in.hand.body;
    if (!is_shell && pair.map != in.hand.body) continue;
    const auto other = static_cast<std::size_t>(is_shell ? pair.map : pair.shell);
    const Vec6 before = Stacked(bodies_[other].state.V_WB);
    const Vec6 after = Stacked(together_.twist(other));
    held_loads_.AddContactOfOther(pair.contact->cross(), is_shell, before, after);
  }
}

void World::Integrate(const StepInputs& in) noexcept {
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    Body& body = bodies_[b];
    const BodyModel& model = model_->bodies[body.shape];
    const double radius = model.radius + body.displaced;
    const BodyDrive drive = DriveOf(in, b);
    if (drive == BodyDrive::kAbsent) {
      body.state = bodies_[body.shape].state;  // where it would begin
    } else if (drive == BodyDrive::kParked) {
      body.state.V_WB = {};
    } else if (drive == BodyDrive::kMirrored) {
      const StepInputs::BodyInput& input = in.bodies[body.shape];
      const Pose& target_WB = b == body.shape ? input.mirror_WB : input.second_WB;
      FollowMirror(model, body.state, target_WB, radius, body.max_travel);
    } else if (StepBody(model, body.state, body.wanted, radius, body.max_travel)) {
      report_.flags |= StepReport::kTravelLimited;
    }
  }
}

void World::ReportAppliedForces(const StepInputs& in) noexcept {
  if (!IsSimulated(in, in.hand.body)) return;
  const Body& held = bodies_[static_cast<std::size_t>(in.hand.body)];
  held_loads_.Report(in, held.before, held.wanted, held.state.V_WB, report_);
}

}  // namespace tandem
