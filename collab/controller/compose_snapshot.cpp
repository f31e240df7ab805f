#include "collab/controller/control_server.h"
#include "collab/controller/plain.h"

// Composes the server's snapshot for its hosts from the newest facts.

namespace tandem {

namespace {

static_assert(static_cast<int>(SnapshotSafety::State::kSilent) ==
              static_cast<int>(SafetyState::kSilent));
static_assert(static_cast<int>(SnapshotSafety::State::kOn) == static_cast<int>(SafetyState::kOn));

SnapshotSafety Plain(SafetyState state, const SafetyCounts& counts) {
  return {.state = static_cast<SnapshotSafety::State>(state),
          .clamped = counts.clamped,
          .slewed = counts.slewed,
          .zeroed = counts.zeroed,
          .expired = counts.expired,
          .stops = counts.stops};
}

}  // namespace

void ControlServer::AddHand(ControllerSnapshot& snapshot) const {
  const ControlScene& scene = *scene_;
  SnapshotHand& hand = snapshot.hand;
  hand.input = device_hand_ ? SnapshotHand::Input::kDevice : SnapshotHand::Input::kHost;
  hand.host = hand_host_;
  hand.body = scene.BodyOfMoving(facts_.held);
  hand.state = stopped_             ? SnapshotHand::State::kStopped
               : task_.going_back() ? SnapshotHand::State::kRetracing
               : facts_.held >= 0   ? SnapshotHand::State::kHolding
               : facts_.wanted >= 0 ? SnapshotHand::State::kAsking
                                    : SnapshotHand::State::kEmpty;
  hand.X_WG = Plain(facts_.X_WG);
  hand.goal = Plain(facts_.requested);
  hand.limited_goal = Plain(facts_.handle);
  hand.force_N = Plain(facts_.hand_G_W.f);
  hand.torque_Nm = Plain(facts_.hand_G_W.tau);
  hand.felt_N = facts_.felt;
}

void ControlServer::AddContacts(ControllerSnapshot& snapshot) const {
  snapshot.contact_points = facts_.contact_points;
  for (std::uint32_t i = 0; i < facts_.contact_count; ++i) {
    const SimulationFacts::ContactFact& fact = facts_.contacts[i];
    snapshot.contacts.push_back({Plain(fact.p_W), Plain(fact.n_W), fact.depth, fact.force});
  }
  if (facts_.held >= 0 && facts_.held == distance_held_) snapshot.distance = distance_;
}

ControllerSnapshot ControlServer::Snapshot() const {
  ControllerSnapshot snapshot;
  snapshot.frame = facts_.frame;
  snapshot.time_ns = facts_.time_ns;
  snapshot.peers = peers_;
  snapshot.colour = colour_;
  snapshot.news = notifications_;
  snapshot.news_count = news_count_;
  snapshot.safety = Plain(facts_.safety, facts_.safety_counts);
  if (stopped_) snapshot.safety.state = SnapshotSafety::State::kStopped;
  const ControlScene& known = scene_ ? *scene_ : old_scene_;
  snapshot.session = known.session;
  snapshot.scene = known.file;
  snapshot.scene_number = known.number;
  snapshot.self = known.self;
  snapshot.warnings = known.warnings;
  if (!scene_) return snapshot;
  snapshot.asked = asked_;
  AddHand(snapshot);
  AddContacts(snapshot);
  for (const ControlScene::Body& from : known.bodies) {
    SnapshotBody body;
    body.fixed = from.fixed;
    body.shared = from.shared;
    body.X_WB = Plain(from.X_WB0);
    const auto moving = static_cast<std::uint32_t>(from.moving);
    if (from.moving >= 0 && moving < facts_.body_count) {
      const SimulationFacts::Body& fact = facts_.bodies[moving];
      body.in_hand = facts_.held == from.moving;
      body.X_WB = Plain(fact.X_WB);
      body.X_W = Plain(fact.X_WB * from.X_WB0.Inverse());
      body.holders.assign(fact.holders.begin(), fact.holders.begin() + fact.holder_count);
    }
    snapshot.bodies.push_back(std::move(body));
  }
  for (std::uint32_t i = 0; i < facts_.instance_count && snapshot.hand.body >= 0; ++i) {
    const auto body = static_cast<std::size_t>(snapshot.hand.body);
    const Pose X_W = facts_.instances[i].X_WB * known.bodies[body].X_WB0.Inverse();
    snapshot.instances.push_back({facts_.instances[i].peer, body, Plain(X_W)});
  }
  return snapshot;
}

}  // namespace tandem
