#include "collab/peer.h"

#include "engine/base/check.h"
#include "engine/base/hash.h"

namespace tandem {

Peer::Peer(World& world, Device& device, PeerInbox& inbox, const PeerOptions& options)
    : world_(&world),
      device_(&device),
      inbox_(&inbox),
      options_(options),
      remote_(world.model()),
      gate_(options.id, world.model().object, inbox.drops()) {
  const WorldModel& model = world.model();
  inputs_.bodies.resize(model.bodies.size());
  inputs_.capacity = options.capacity;
  trace_.reserve(options.trace_frames);
  if (options.held_object < 0) return;
  const auto object = static_cast<std::size_t>(options.held_object);
  TANDEM_CHECK(object < model.body_index.size() && model.body_index[object] >= 0);
  held_ = model.body_index[object];
  const BodyModel& body = model.bodies[static_cast<std::size_t>(held_)];
  if (model.scene.bodies[object].shared) {
    shared_.emplace(options.id, static_cast<ObjectId>(object), body.inertia, options.coupling);
  }
}

const RigidState* Peer::held_state() const noexcept {
  return held_ < 0 ? nullptr : &world_->state(static_cast<std::size_t>(held_));
}

void Peer::Tick(std::int64_t now_ns, Outbox& out) noexcept {
  FrameTap* const tap = options_.tap;
  if (tap != nullptr) tap->Begin(now_ns, inputs_.capacity);
  Receive(now_ns);
  StartWhenReady(now_ns);

  const Anchor goal = device_->Read();
  if (tap != nullptr) tap->Felt(goal);
  remote_.Prepare(held_, inputs_);
  if (held_ >= 0) {
    const BodyModel& body = world_->model().bodies[static_cast<std::size_t>(held_)];
    const RigidState& state = *held_state();
    inputs_.hand = {.body = held_,
                    .X_BD = options_.X_BD,
                    .goal = goal,
                    .gains = DefaultHandGains(body.inertia)};
    if (shared_) shared_->Prepare(now_ns, state, inputs_);
  }
  report_ = world_->Step(inputs_);

  // the device gets exactly what the body received, about its own origin
  Wrench on_device;
  if (held_ >= 0) {
    const Vec3 r = held_state()->X_WB.q * options_.X_BD.p;
    on_device = {-(report_.hand_B_W.tau - r.cross(report_.hand_B_W.f)), -report_.hand_B_W.f};
  }
  device_->Render(on_device);

  FillOutbox(now_ns, out);
  Record(now_ns);
  if (tap != nullptr) tap->End(StateHash());
}

void Peer::Receive(std::int64_t now_ns) noexcept {
  FrameTap* const tap = options_.tap;
  MembershipChange change;
  while (inbox_->membership().TryPop(change)) {
    if (tap != nullptr) tap->Heard(change);
    OnMembership(change);
  }
  Event event;
  while (inbox_->events().TryPop(event)) {
    if (tap != nullptr) tap->Heard(event);
  }
  Command command;
  while (commands_.TryPop(command)) {
    if (tap != nullptr) tap->Asked(command);
  }
  inbox_->Collect();
  while (const ObjectState* state = inbox_->states().Due(now_ns)) {
    if (tap != nullptr) tap->Heard(*state);
    if (gate_.Admit(*state)) {
      if (shared_) shared_->OnState(*state);
      remote_.OnState(*state);
    }
    inbox_->states().Drop();
  }
  while (const CouplingLinks* links = inbox_->links().Due(now_ns)) {
    if (tap != nullptr) tap->Heard(*links);
    if (gate_.Admit(*links) && shared_) shared_->OnLinks(*links);
    inbox_->links().Drop();
  }
}

void Peer::OnMembership(const MembershipChange& change) noexcept {
  gate_.OnMembership(change);
  remote_.OnMembership(change);
  if (!shared_) return;
  if (change.Holds(static_cast<ObjectId>(options_.held_object))) {
    shared_->Join(change.peer);
  } else {
    shared_->Part(change.peer);
  }
}

void Peer::StartWhenReady(std::int64_t now_ns) noexcept {
  if (started_ns_) return;
  // partners on the shared body must have heard us too; of others a first pose is enough
  const std::size_t ready = shared_ ? shared_->coupled() : remote_.heard();
  if (ready < options_.wait_for) return;
  started_ns_ = now_ns;
  device_->Start();
}

void Peer::FillOutbox(std::int64_t now_ns, Outbox& out) noexcept {
  out.holds = held_ >= 0;
  if (!out.holds) return;
  ++seq_;
  gate_.NoteSent(now_ns);
  const RigidState& state = *held_state();
  out.state = {.peer = options_.id,
               .object = static_cast<ObjectId>(options_.held_object),
               .epoch = 1,
               .seq = seq_,
               .flags = report_.flags,
               .sample_ns = now_ns,
               .X_WB = state.X_WB,
               .V_WB = state.V_WB,
               .contact_B_W = report_.contact_B_W};
  out.shared = shared_.has_value();
  if (shared_) shared_->Describe(now_ns, seq_, report_, out.links);

  const BodyModel& body = world_->model().bodies[static_cast<std::size_t>(held_)];
  out.view.peer = options_.id;
  out.view.seq = seq_;
  out.view.sample_ns = now_ns;
  out.view.delay_ms = static_cast<float>(1e3 * (shared_ ? shared_->delay_s(now_ns) : 0.0));
  out.view.count = 1;
  out.view.bodies[0] = {
      .object = out.state.object,
      .flags = ViewBody::kHeld | (report_.contact_points > 0 ? ViewBody::kInContact : 0U),
      .X_W = state.X_WB * body.X_WB0.Inverse(),
      .hand_force_W = report_.hand_B_W.f};
}

void Peer::Record(std::int64_t now_ns) noexcept {
  if (held_ < 0 || !started_ns_ || trace_.size() == trace_.capacity()) return;
  const RigidState& state = *held_state();
  trace_.push_back({.time_ns = now_ns,
                    .X_WB = state.X_WB,
                    .V_WB = state.V_WB,
                    .hand_force = static_cast<float>(report_.hand_B_W.f.norm()),
                    .contact_points = report_.contact_points,
                    .loaded = report_.loaded_points > 0});
}

std::uint64_t Peer::StateHash() const noexcept {
  Hash64 hash;
  for (std::size_t b = 0; b < inputs_.bodies.size(); ++b) {
    const RigidState& state = world_->state(b);
    for (const double x : state.X_WB.q.coeffs()) hash.Add(x);
    for (const Vec3* v : {&state.X_WB.p, &state.V_WB.v, &state.V_WB.w}) {
      for (const double x : *v) hash.Add(x);
    }
  }
  return hash.value();
}

}  // namespace tandem
