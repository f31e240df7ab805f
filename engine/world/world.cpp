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

/// Returns the share of a pair's travel that falls to one instance. A mirrored one gives way to
/// nothing, so the other gets the larger share to escape faster. Parked ones need none.
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
    : model_(std::move(model)),
      instances_(MakeInstances(*model_)),
      together_(instances_.size()),
      contact_on_(schedule.experiments.contact),
      workers_(schedule.workers) {
  if (model_->fixture_pages != nullptr) {
    auto resident = ResidentVoxels::Make(model_->fixture_pages, model_->voxel_memory_bytes);
    TANDEM_CHECK(resident);  // LoadWorld() has checked it
    resident_ = std::move(*resident);
  }
  const std::size_t bodies = model_->bodies.size();
  for (InstanceIndex i = 0; i < instances_.size(); ++i) {
    AddFixturePair(i, schedule);
    // pairs with the first instance of each other body: two second ones never meet
    for (InstanceIndex first = 0; first < std::min(i, bodies); ++first) {
      if (first != instances_[i].shape) AddPair(i, first, schedule);
    }
    if (i < bodies) first_pairs_ = pairs_.size();
  }
  if (resident_ != nullptr) {
    resident_->Start();
    LoadPendingVoxels();
  }
}

std::vector<World::Instance> World::MakeInstances(const WorldModel& model) {
  std::vector<Instance> instances;
  for (const std::size_t shape : InstanceShapes(model)) {
    Instance& instance = instances.emplace_back();
    instance.shape = shape;
    instance.radii = AxisRadiiOf(model, shape);
    instance.state.X_WB = model.bodies[shape].X_WB0;
  }
  return instances;
}

void World::AddFixturePair(InstanceIndex instance, const ScheduleOptions& schedule) {
  if (!model_->has_fixture) return;
  pairs_.push_back({MakeFixturePair(*model_, instances_[instance].shape, resident_.get(), schedule),
                    instance, kFixture});
}

void World::AddPair(InstanceIndex a, InstanceIndex b, const ScheduleOptions& schedule) {
  const bool is_shell = IsShell(*model_, instances_[a].shape, instances_[b].shape);
  const InstanceIndex shell = is_shell ? a : b;
  const InstanceIndex map = is_shell ? b : a;
  pairs_.push_back(
      {MakeMovingPair(*model_, instances_[shell].shape, instances_[map].shape, schedule), shell,
       map});
}

void World::LoadPendingVoxels() {
  for (const Pair& pair : pairs_) {
    if (pair.map != kFixture) continue;
    const RigidState& shell = instances_[pair.shell].state;
    pair.contact->Announce({shell.X_WB, shell.V_WB}, {});
  }
  resident_->WaitUntilResident();
}

std::string World::MissingVoxelsReason() const {
  const std::string* fault = resident_ != nullptr ? resident_->fault() : nullptr;
  return fault != nullptr ? *fault
                          : "voxels were not read in time: the disk is too slow, or the memory for "
                            "voxels too small; give more by --voxel-memory";
}

void World::WaitForVoxels() {
  if (resident_ != nullptr) resident_->WaitUntilResident();
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

void World::Place(InstanceIndex instance, const Pose& X_WB) {
  TANDEM_CHECK(instance < instances_.size());
  instances_[instance].state = {X_WB, {}};
  if (resident_ != nullptr) LoadPendingVoxels();
}

bool World::Touched(InstanceIndex instance) const noexcept {
  return std::any_of(pairs_.begin(), pairs_.end(), [instance](const Pair& pair) {
    return pair.pushes && pair.Has(instance);
  });
}

bool World::Pushed(InstanceIndex instance) const noexcept {
  return std::any_of(pairs_.begin(), pairs_.end(), [instance](const Pair& pair) {
    return pair.pushes && pair.map != kFixture && pair.Has(instance);
  });
}

const StepReport& World::Step(const StepInputs& in) noexcept {
  BeginFrame(in);
  UpdateClearances(in);
  if (!ComputeContactForces()) return EndWaitingFrame();
  LimitTravel(in);
  ApplyCouplings(in);
  SolveVelocities();
  Integrate(in);
  ReportAppliedForces(in);
  return EndFrame();
}

void World::BeginFrame(const StepInputs& in) noexcept {
  report_ = {};
  applied_forces_.Clear();
  for (Instance& instance : instances_) {
    instance.load = {};
    instance.pushed = false;
  }
  for (Pair& pair : pairs_) pair.pushes = false;
  TANDEM_CHECK(in.instances.size() == instances_.size());
  BeginSimulated(in);
  held_.reset();
  if (in.hand.body >= 0) held_ = static_cast<InstanceIndex>(in.hand.body);
  if (resident_ != nullptr) resident_->BeginFrame();
}

const StepReport& World::EndFrame() noexcept {
  waited_ = 0;
  if (workers_ != nullptr) workers_->ReleaseWorkers();
  return report_;
}

const StepReport& World::EndWaitingFrame() noexcept {
  report_ = {};
  report_.flags = StepReport::kWaitsForVoxels;
  report_.waited = ++waited_;
  if (workers_ != nullptr) workers_->ReleaseWorkers();
  return report_;
}

void World::BeginSimulated(const StepInputs& in) noexcept {
  for (InstanceIndex i = 0; i < instances_.size(); ++i) {
    Instance& instance = instances_[i];
    const BodyDrive before = std::exchange(instance.drive, in.instances[i].drive);
    if (before == BodyDrive::kMirrored && instance.drive == BodyDrive::kSimulated) {
      instance.state.V_WB = in.instances[i].begin_V_WB;
    }
  }
}

void World::UpdateClearances(const StepInputs& in) noexcept {
  if (waited_ > 0) return;  // a frame that waits has already done so
  const Clearance scenes{static_cast<double>(model_->scene.force_layer), 0.0};
  for (Instance& instance : instances_) instance.displaced = 0;
  for (Pair& pair : pairs_) {
    Clearance goal = scenes;
    if (held_ && pair.Has(*held_)) {
      const bool ordered = in.clearance.force_layer != StepInputs::HandClearance::kSceneLayer;
      goal = pair.contact->clearance_bounds().Clamp(in.clearance.force_layer,
                                                    in.clearance.displacement);
      if (!ordered) goal.layers = scenes.layers;
    }
    if (pair.contact->clearance() != goal) {
      pair.contact->SetClearance(
          StepClearance(pair.contact->clearance(), goal, kFrame, model_->scene.voxel_size));
    }
    double& displaced = instances_[pair.shell].displaced;
    displaced = std::max(displaced, std::abs(pair.contact->clearance().displacement));
  }
}

void World::LimitTravel(const StepInputs& in) noexcept {
  TestDemand demand;
  for (const Pair& pair : pairs_) {
    if (Tested(pair)) demand += pair.contact->test_demand();
  }
  demand.bound = std::numeric_limits<double>::infinity();
  const double voxel = model_->scene.voxel_size;
  const double affordable = MaxTravel(demand, in.capacity, in.query_price, voxel);
  if (affordable < 0.5 * voxel) report_.flags |= StepReport::kOverCapacity;
  for (Instance& instance : instances_) {
    instance.max_travel = std::min(affordable, kFreeTravel * voxel);
  }
  for (Pair& pair : pairs_) {
    // a pair that is not tested learns of all travel at its next test
    if (contact_on_ && !Tested(pair)) continue;
    const double travel =
        contact_on_ ? std::min(affordable, pair.contact->test_demand().bound) : 0.5 * voxel;
    pair.contact->LimitTravel(travel);
    Instance& shell = instances_[pair.shell];
    if (pair.map == kFixture) {
      shell.max_travel = std::min(shell.max_travel, travel);
      continue;
    }
    // both of a pair shrink the gap by their travel
    Instance& map = instances_[pair.map];
    const double share = ShareOf(shell.drive, map.drive);
    shell.max_travel = std::min(shell.max_travel, share * travel);
    map.max_travel = std::min(map.max_travel, (1.0 - share) * travel);
  }
}

bool World::Tested(const Pair& pair) const noexcept {
  if (!IsSimulated(pair.shell) && !IsSimulated(pair.map)) return false;
  return IsActive(pair.shell) && IsActive(pair.map);
}

bool World::Couples(const Pair& pair) const noexcept {
  return pair.pushes && IsSimulated(pair.shell) && IsSimulated(pair.map);
}

BodyMotion World::MotionOf(InstanceIndex index) const noexcept {
  const RigidState& state = instances_[index].state;
  return {state.X_WB, state.V_WB, Rolls(index)};
}

bool World::ComputeContactForces() noexcept {
  if (!contact_on_) return true;
  bool all = true;
  const BodyMotion fixture{};
  LinearizedForce on_fixture;
  for (Pair& pair : pairs_) {
    if (!Tested(pair)) {
      pair.contact->Rest();
      continue;
    }
    Instance& shell = instances_[pair.shell];
    const BodyMotion shell_motion = MotionOf(pair.shell);
    PairReport found;
    if (pair.map == kFixture) {
      found = pair.contact->Collide(shell_motion, fixture, shell.load, on_fixture);
    } else {
      found = pair.contact->Collide(shell_motion, MotionOf(pair.map), shell.load,
                                    instances_[pair.map].load);
    }
    pair.pushes = found.pushing_points > 0;
    shell.pushed = shell.pushed || pair.pushes;
    if (pair.map != kFixture && pair.pushes) instances_[pair.map].pushed = true;
    all = all && !found.waits;
    report_.tests += found.tests;
    if (found.over_capacity) report_.flags |= StepReport::kContactsFull;
    report_.contact_points += found.contact_points;
    report_.exact_queries += found.exact_queries;
    report_.query_cost += found.query_cost;
    report_.pushing_points += found.pushing_points;
  }
  if (held_) applied_forces_.SetContact(instances_[*held_].load);
  return all;
}

void World::ApplyCouplings(const StepInputs& in) noexcept {
  for (InstanceIndex i = 0; i < instances_.size(); ++i) {
    Instance& instance = instances_[i];
    if (instance.drive != BodyDrive::kCompliant) continue;
    const StepInputs::InstanceInput& input = in.instances[i];
    instance.load += CouplingForce(input.pull, instance.state, Pose{}, {input.mirror_WB, {}});
  }
  if (held_) applied_forces_.Couple(in, instances_[*held_].state, instances_[*held_].load);
  for (Instance& instance : instances_) {
    if (instance.drive != BodyDrive::kSimulated) continue;
    instance.load.force.tail<3>() +=
        model_->bodies[instance.shape].inertia.mass * model_->scene.gravity_W;
  }
}

void World::SolveVelocities() noexcept {
  SolveTogether();
  for (InstanceIndex i = 0; i < instances_.size(); ++i) {
    Instance& instance = instances_[i];
    if (!instance.IsSimulated()) continue;
    instance.before = instance.state.V_WB;
    if (Rolls(i) && !instance.pushed) continue;  // it flies
    instance.desired = instance.together ? together_.twist(i)
                                         : TwistAlone(model_->bodies[instance.shape],
                                                      instance.state, instance.load, Rolls(i));
  }
}

void World::SolveTogether() noexcept {
  bool begun = false;
  for (const Pair& pair : pairs_) {
    if (!Couples(pair)) continue;
    if (!begun) together_.Begin();
    begun = true;
    for (const InstanceIndex i : {pair.shell, pair.map}) {
      if (together_.has(i)) continue;
      const Instance& instance = instances_[i];
      const BodyModel& model = model_->bodies[instance.shape];
      const RigidState& state = instance.state;
      const Mat6 basis =
          model.constraint ? AllowedBasis(*model.constraint, state.X_WB) : Mat6::Identity();
      together_.AddBody(i, EquationsOf(model, state, instance.load, Rolls(i)), state.V_WB, basis);
    }
    together_.Couple(pair.shell, pair.map, pair.contact->cross(), kFrame);
  }
  for (InstanceIndex i = 0; i < instances_.size(); ++i) {
    instances_[i].together = begun && together_.has(i);
  }
  if (!begun) return;
  together_.Solve();
  SumContactOfOthers();
}

void World::SumContactOfOthers() noexcept {
  if (!held_) return;
  for (const Pair& pair : pairs_) {
    if (!Couples(pair) || !pair.Has(*held_)) continue;
    const bool is_shell = pair.shell == *held_;
    const InstanceIndex other = is_shell ? pair.map : pair.shell;
    const Vec6 before = Stacked(instances_[other].state.V_WB);
    const Vec6 after = Stacked(together_.twist(other));
    applied_forces_.AddContactOfOther(pair.contact->cross(), is_shell, before, after);
  }
}

void World::Integrate(const StepInputs& in) noexcept {
  for (InstanceIndex i = 0; i < instances_.size(); ++i) {
    Instance& instance = instances_[i];
    const BodyModel& model = model_->bodies[instance.shape];
    const double radius = model.radius + instance.displaced;
    if (instance.drive == BodyDrive::kInactive && i != instance.shape) {
      instance.state = instances_[instance.shape].state;  // where it would begin
    } else if (instance.drive <= BodyDrive::kParked) {
      instance.state.V_WB = {};
    } else if (instance.drive == BodyDrive::kMirrored) {
      FollowMirror(model, instance.state, in.instances[i].mirror_WB,
                   instance.radii.Displaced(instance.displaced), instance.max_travel);
    } else if (Rolls(i)) {
      const Vec3* gravity_W = instance.pushed ? nullptr : &model_->scene.gravity_W;
      if (StepFreely(model, instance.state, instance.desired, gravity_W,
                     instance.radii.Displaced(instance.displaced), instance.max_travel)) {
        report_.flags |= StepReport::kTravelLimited;
      }
    } else if (StepBody(model, instance.state, instance.desired, radius, instance.max_travel)) {
      report_.flags |= StepReport::kTravelLimited;
    }
  }
}

void World::ReportAppliedForces(const StepInputs& in) noexcept {
  if (!held_ || !IsSimulated(*held_)) return;
  const Instance& held = instances_[*held_];
  applied_forces_.Report(in, held.before, held.desired, held.state.V_WB, report_);
}

}  // namespace tandem
