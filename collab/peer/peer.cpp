#include "collab/peer/peer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "collab/coupling/energy_gate.h"
#include "engine/base/check.h"
#include "engine/base/hash.h"

namespace tandem {

namespace {

constexpr double kFarthest = 1e3;      // m; a handle farther away is implausible
constexpr double kFastest = 1e3;       // m/s; a faster handle is implausible
constexpr double kFastestTurn = 1e4;   // rad/s
constexpr double kNear = 1e-3;         // m from where it was said to be: the hand may take it
constexpr double kNearAngle = 0.01;    // rad
constexpr double kNearingStep = 1e-3;  // m a frame; step of a body that comes to the hand
constexpr double kNearingTurn = 0.02;  // rad a frame; likewise
constexpr std::int64_t kNearingFrames = 2000;  // longest approach of a body that does not arrive

bool AllFinite(const Wrench& F) {
  return F.f.allFinite() && F.tau.allFinite();
}

std::vector<bool> SharedOf(const WorldModel& model) {
  std::vector<bool> shared;
  for (const ObjectId object : model.object) shared.push_back(model.scene.bodies[object].shared);
  return shared;
}

}  // namespace

Peer::Peer(World& world, Device& device, PeerInbox& inbox, const PeerOptions& options)
    : world_(&world),
      device_(&device),
      inbox_(&inbox),
      options_(options),
      ownership_(options.id, world.model(), options.settle_ns, options.own_only, &inbox.drops()),
      separation_(options.id, world.model()),
      remote_(world.model(), options.experiments.mirror),
      validator_(options.id, world.model().object, inbox.drops(), SharedOf(world.model())),
      device_can_(device.capabilities()),
      guard_(device_can_.peak),
      round_trips_(options.id),
      telemetry_({.id = options.id,
                  .world = world,
                  .inputs = inputs_,
                  .report = report_,
                  .ownership = ownership_,
                  .remote = remote_,
                  .round_trips = round_trips_,
                  .separation = separation_,
                  .drops = inbox.drops()},
                 options.trace_frames) {
  const WorldModel& model = world.model();
  inputs_ = ParkedInputs(model);
  inputs_.capacity = options.capacity;
  inputs_.query_price = options.query_price;
  next_parked_ns_.resize(model.bodies.size());
  free_.resize(model.bodies.size());
  handle_.X_WA.p.setConstant(std::numeric_limits<double>::quiet_NaN());
  if (options.held_object < 0) return;
  const auto object = static_cast<std::size_t>(options.held_object);
  TANDEM_CHECK(object < model.body_index.size() && model.body_index[object] >= 0);
  ownership_.Ask(static_cast<ObjectId>(object));
}

const RigidState* Peer::held_state() const noexcept {
  return held_ < 0 ? nullptr : &world_->state(static_cast<std::size_t>(held_));
}

SafetyCounts Peer::safety_counts() const noexcept {
  SafetyCounts counts = guard_.counts();
  const std::uint64_t stops = counts.stops;
  counts += device_->safety().counts;
  // a stop reaches both guards
  counts.stops = std::max(stops, device_->safety().counts.stops);
  return counts;
}

SafetyState Peer::safety_state() const noexcept {
  const SafetyState device = device_->safety().state;
  return device == SafetyState::kOn ? guard_.state() : device;
}

void Peer::Tick(std::int64_t now_ns, Outbox& out) noexcept {
  FrameObserver* const observer = options_.observer;
  if (observer != nullptr) observer->Begin(now_ns, inputs_.capacity);
  Receive(now_ns);
  Simulate(now_ns);
  Publish(now_ns, out);
  if (observer != nullptr) observer->End(StateHash());
}

// The phases. Within each the order counts: every line uses what the lines before it have set.

void Peer::Receive(std::int64_t now_ns) noexcept {
  UpdateBodyPoses();
  TakeMessages(now_ns);
  NoteTouches();
  TickOwnership(now_ns);
  SyncHeldBody();
  if (shared_) CoupleWaiting();
  StartWhenReady(now_ns);
}

void Peer::Simulate(std::int64_t now_ns) noexcept {
  const Anchor goal = ReadDevice();
  PrepareOthers(now_ns);
  PrepareHand(now_ns, goal);
  report_ = world_->Step(inputs_);
  if (attached_ && separation_.guiding()) report_.hand_B_W = {};
  CountLimits();
  Render();
  DiscardBadWrenches();
}

void Peer::Publish(std::int64_t now_ns, Outbox& out) noexcept {
  FillOutbox(now_ns, out);
  PublishLoose(now_ns, out);
  PublishParked(now_ns);
  if (seq_ % PeerTable::kPeriod == 0) telemetry_.PublishTable(now_ns, shared());
  if (held_ >= 0 && started_ns_) telemetry_.RecordHand(now_ns, held_);
}

void Peer::PrepareOthers(std::int64_t now_ns) noexcept {
  round_trips_.Measure(now_ns, held_ >= 0);
  remote_.Extrapolate(round_trips_.loops());
  remote_.Prepare(held_, inputs_);
  PrepareLoose();
  PrepareParked();
  remote_.ApplyCompliance(*world_, round_trips_.loops(), inputs_);
}

void Peer::PrepareHand(std::int64_t now_ns, const Anchor& goal) noexcept {
  inputs_.hand.body = -1;
  inputs_.link_count = 0;
  inputs_.ground_damping = 0;
  inputs_.ground_rotation_damping.setZero();
  if (held_ < 0) return;
  if (!goal.X_WA.p.allFinite()) {
    // the hand's pose is not known yet: the body waits for it where it stands
    inputs_.instances[static_cast<std::size_t>(held_)].drive = BodyDrive::kParked;
  } else if (!attached_) {
    Attach(goal);
  }
  const BodyModel& body = world_->model().bodies[static_cast<std::size_t>(held_)];
  if (attached_) {
    inputs_.hand = {.body = held_,
                    .X_BD = X_BD_,
                    .goal = goal,
                    .gains = LimitGains(device_can_, DefaultHandGains(body.inertia))};
  }
  if (!shared_) return;
  separation_.Update(now_ns, *held_state(), *shared_);
  if (attached_) separation_.GuideHand(*held_state(), goal.X_WA, X_BD_, inputs_.hand);
  shared_->Prepare(now_ns, *held_state(), inputs_);
}

void Peer::DiscardBadWrenches() noexcept {
  if (!AllFinite(report_.hand_B_W) || !AllFinite(report_.contact_B_W)) {
    // NaN goes no further than the guard
    report_.hand_B_W = report_.contact_B_W = {};
    report_.links_B_W = {};
  }
  if (guard_.broken()) report_.hand_B_W = {};  // nor does the force that it keeps from the hand
}

Anchor Peer::ReadDevice() noexcept {
  device_->Holding(held_ >= 0);
  const Anchor read = device_->Read();
  // a device in this process has no other guard that would ask
  if (device_->stop_button() && !guard_.stopped()) {
    guard_.Stop();
    device_->Stop();
    stop_pressed_ = true;
  }
  // without motors there is no force to be taken away (DeviceLoop::Tick)
  if (device_->failed() && device_can_.freedoms_out > 0) guard_.Fail();
  const bool sound = read.X_WA.p.allFinite() && read.X_WA.p.cwiseAbs().maxCoeff() < kFarthest &&
                     std::abs(read.X_WA.q.norm() - 1.0) < 1e-6 && read.V_WA.v.allFinite() &&
                     read.V_WA.w.allFinite() && read.V_WA.v.cwiseAbs().maxCoeff() < kFastest &&
                     read.V_WA.w.cwiseAbs().maxCoeff() < kFastestTurn;
  if (sound) {
    handle_ = read;
  } else {
    handle_.V_WA = {};
  }
  if (options_.observer != nullptr) options_.observer->OnDevice(handle_);
  return handle_;
}

void Peer::UpdateBodyPoses() noexcept {
  for (std::size_t b = 0; b < body_count(); ++b) {
    ownership_.SetPose(b, world_->state(b).X_WB);
  }
}

void Peer::TickOwnership(std::int64_t now_ns) noexcept {
  std::array<Event, 8> events;
  std::size_t count = 0;
  ownership_.Tick(now_ns, events, count);
  for (std::size_t i = 0; i < count; ++i) events_.TryPush(events[i]);
  Notification notification;
  while (ownership_.TakeNotifications(notification)) notifications_.TryPush(notification);
  while (separation_.TakeNotifications(notification)) notifications_.TryPush(notification);
  ClaimList& list = claims_.back();
  list.count = ownership_.Claims(list.claims);
  list.belief_count = ownership_.Beliefs(list.beliefs);
  claims_.Publish();
}

void Peer::SyncHeldBody() noexcept {
  const int now_held = ownership_.held();
  if (now_held == held_) return;
  if (shared_) last_delay_s_ = shared_->mean_delay_s();
  shared_.reset();
  separation_.Begin(-1);
  held_ = now_held;
  attached_ = false;
  nearing_frames_ = 0;
  if (held_ < 0) return;
  const WorldModel& model = world_->model();
  const auto body = static_cast<std::size_t>(held_);
  const ObjectId object = model.object[body];
  if (!model.scene.bodies[object].shared) return;
  separation_.Begin(held_);
  uncoupled_.Clear();
  shared_.emplace(options_.id, object, model.bodies[body].inertia,
                  SharedBody::Options{options_.law, options_.experiments});
  std::array<PeerId, kMaxPeers> holders{};
  const std::size_t count = ownership_.Holders(body, holders);
  for (std::size_t i = 0; i < count; ++i) Couple(holders[i]);
}

void Peer::Couple(PeerId peer) noexcept {
  if (shared_->Join(peer)) return;
  if (uncoupled_.Find(peer) != nullptr || uncoupled_.FindOrInsert(peer) == nullptr) return;
  const ObjectId object = world_->model().object[static_cast<std::size_t>(held_)];
  notifications_.TryPush({Notification::Kind::kUncoupled, object, peer});
}

void Peer::CoupleWaiting() noexcept {
  for (const PeerKey& rest : uncoupled_) {
    const bool holds = ownership_.HeldBy(static_cast<std::size_t>(held_), rest.peer);
    if (!holds || shared_->Join(rest.peer)) uncoupled_.Erase(rest.peer);
  }
}

void Peer::Attach(const Anchor& goal) noexcept {
  const auto body = static_cast<std::size_t>(held_);
  const Pose& X_WB = held_state()->X_WB;
  // the hand takes a free body where it is; the other bodies first come to their told pose
  const bool free = world_->model().scene.bodies[world_->model().object[body]].free;
  const Pose* parked_at = shared_ || free ? nullptr : ownership_.ParkedAt(body);
  if (parked_at != nullptr && nearing_frames_ < kNearingFrames) {
    const bool near =
        (parked_at->p - X_WB.p).norm() < kNear && parked_at->q.angularDistance(X_WB.q) < kNearAngle;
    if (!near) {
      // its told pose is not reached here yet: the body is in our hand, so it comes at a hand's
      // pace
      ++nearing_frames_;
      const double turn = parked_at->q.angularDistance(X_WB.q);
      const double frames =
          std::max((parked_at->p - X_WB.p).norm() / kNearingStep, turn / kNearingTurn);
      inputs_.instances[body].drive = BodyDrive::kMirrored;
      inputs_.instances[body].mirror_WB =
          Interpolate(X_WB, *parked_at, 1.0 / std::max(1.0, frames));
      return;
    }
  }
  const Pose& X_WB0 = world_->model().bodies[body].X_WB0;
  const bool first = X_WB.p == X_WB0.p && X_WB.q.coeffs() == X_WB0.q.coeffs();
  const bool as_agreed =
      first && static_cast<int>(world_->model().object[body]) == options_.held_object;
  X_BD_ = as_agreed ? options_.X_BD : X_WB.Inverse() * goal.X_WA;
  attached_ = true;
  guard_.Begin();
}

void Peer::CountLimits() noexcept {
  const PeerTelemetry::FrameEvents events = telemetry_.CountStep();
  // the force that the hand felt before the wait comes back slowly
  if (events.voxels_came) guard_.Begin();
  if (events.first_crowded) notifications_.TryPush({Notification::Kind::kCrowded, kNoObject, 0});
}

void Peer::Render() noexcept {
  // the reaction of the body, about the device's own origin
  Wrench wanted;
  if (attached_ && !separation_.guiding()) {
    const Vec3 r = held_state()->X_WB.q * X_BD_.p;
    wanted = {-(report_.hand_B_W.tau - r.cross(report_.hand_B_W.f)), -report_.hand_B_W.f};
  }
  const bool broken = guard_.broken();
  const Wrench given = guard_.Pass(wanted);
  telemetry_.CountForce(given);
  device_->Render(given);
  if (guard_.broken() == broken) return;
  const ObjectId object = world_->model().object[static_cast<std::size_t>(held_)];
  notifications_.TryPush({Notification::Kind::kForceStopped, object, 0});
}

void Peer::PrepareParked() noexcept {
  for (std::size_t b = 0; b < body_count(); ++b) {
    StepInputs::InstanceInput& input = inputs_.instances[b];
    if (input.drive != BodyDrive::kParked) continue;
    const Pose* parked_at = ownership_.ParkedAt(b);
    if (parked_at == nullptr) continue;
    input.drive = BodyDrive::kMirrored;
    input.mirror_WB = *parked_at;
  }
}

void Peer::StartWhenReady(std::int64_t now_ns) noexcept {
  if (started_ns_) return;
  // the hand does not begin until its first body is in hand, or refused
  if (options_.held_object >= 0 && ownership_.wanted() >= 0) return;
  // coupled peers must have heard us too; from other peers a first pose is enough
  const std::size_t ready = shared_ ? shared_->coupled() : remote_.received_instances();
  if (ready < options_.wait_for) return;
  started_ns_ = now_ns;
  device_->Start();
}

void Peer::Leave(std::int64_t now_ns) noexcept {
  UpdateBodyPoses();
  ownership_.Leave();
  for (int turns = 0; turns < 32; ++turns) TickOwnership(now_ns);
}

std::uint64_t Peer::StateHash() const noexcept {
  Hash64 hash;
  for (std::size_t b = 0; b < body_count(); ++b) {
    const RigidState& state = world_->state(b);
    for (const double x : state.X_WB.q.coeffs()) hash.Add(x);
    for (const Vec3* v : {&state.X_WB.p, &state.V_WB.v, &state.V_WB.w}) {
      for (const double x : *v) hash.Add(x);
    }
  }
  return hash.value();
}

}  // namespace tandem
