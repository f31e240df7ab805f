#include "collab/controller/fill_facts.h"

#include <algorithm>
#include <span>

namespace tandem {

namespace {

/// Keeps the deepest contacts of the body in hand.
void AddContacts(const World& world, InstanceIndex held, SimulationFacts& facts) noexcept {
  facts.contact_count = 0;
  for (std::size_t number = 0; number < world.pair_count(); ++number) {
    const bool is_shell = world.shell_of(number) == held;
    const InstanceIndex map = world.voxmap_of(number);
    if (!is_shell && map != held) continue;
    const InstanceIndex met = is_shell ? map : world.shell_of(number);
    const int other =
        met == kFixture || met >= world.model().bodies.size() ? -1 : static_cast<int>(met);
    const BodyPair& pair = world.pair(number);
    const Pose X_WV = map == kFixture ? pair.X_BV() : world.state(map).X_WB * pair.X_BV();
    for (const Contact& contact : pair.contacts()) {
      auto* place = facts.contacts.begin() + facts.contact_count;
      if (facts.contact_count < SimulationFacts::kMostContacts) {
        ++facts.contact_count;
      } else {
        place = std::ranges::min_element(facts.contacts, {}, &SimulationFacts::ContactFact::depth);
        if (place->depth >= contact.depth) continue;
      }
      const Vec3 n_W = X_WV.q * contact.nhat_V;
      *place = {.p_W = X_WV * contact.p_V,
                .n_W = is_shell ? n_W : Vec3(-n_W),
                .depth = contact.depth,
                .force = contact.force,
                .other = other};
    }
  }
}

void AddBodies(const PeerNode& node, const Ownership& ownership, SimulationFacts& facts,
               PeerId self) noexcept {
  const World& world = node.world();
  const std::size_t count = std::min(world.model().bodies.size(), SimulationFacts::kMostBodies);
  facts.body_count = static_cast<std::uint32_t>(count);
  for (std::size_t b = 0; b < count; ++b) {
    SimulationFacts::Body& body = facts.bodies[b];
    body.X_WB = world.state(b).X_WB;
    body.holder_count = static_cast<std::uint32_t>(ownership.Holders(b, body.holders));
    if (ownership.held() == static_cast<int>(b) && body.holder_count < body.holders.size()) {
      body.holders[body.holder_count++] = self;
    }
  }
}

}  // namespace

PartInHand SeePart(const PeerNode& node, const GoalDevice& device) noexcept {
  const Peer& peer = node.peer();
  const Ownership& ownership = peer.ownership();
  PartInHand part;
  part.wanted = ownership.held() >= 0 ? ownership.held() : ownership.wanted();
  if (part.wanted < 0) part.wanted = device.aimed_at();
  if (part.wanted < 0 || part.wanted >= static_cast<int>(node.world().model().bodies.size())) {
    return {};
  }
  const auto body = static_cast<std::size_t>(part.wanted);
  const BodyModel& model = node.world().model().bodies[body];
  part.attached = peer.attached() && peer.held_state() == &node.world().state(body);
  part.state = node.world().state(body);
  part.X_BG = peer.grasp();
  part.gains = DefaultHandGains(model.inertia);
  part.mass = model.inertia.mass;
  part.radius = model.radius;
  return part;
}

void FillFacts(PeerNode& node, const GoalDevice* device, std::uint64_t frame, std::int64_t now_ns,
               SimulationFacts& facts) noexcept {
  const Peer& peer = node.peer();
  const Ownership& ownership = peer.ownership();
  facts.frame = frame;
  facts.time_ns = now_ns;
  AddBodies(node, ownership, facts, node.id());
  facts.wanted = ownership.wanted();
  facts.held = ownership.held();
  facts.attached = peer.attached() && facts.held >= 0;
  facts.goal_device = device != nullptr;
  facts.hand_G_W = {};
  facts.contact_points = 0;
  facts.contact_count = 0;
  facts.instance_count = 0;
  facts.felt = peer.telemetry().rendered().F_D_W.f.norm();
  facts.safety = peer.safety_state();
  facts.safety_counts = peer.safety_counts();
  if (device != nullptr) {
    facts.grasp_seq = device->grasp_seq();
    facts.way_seq = device->way_seq();
    facts.way = device->way().state();
    facts.way_body = device->way().body();
    facts.requested = device->requested();
    facts.handle = device->handle().X_WA;
  }
  if (facts.held < 0) return;
  const auto held = static_cast<InstanceIndex>(facts.held);
  const Pose& X_WB = node.world().state(held).X_WB;
  facts.X_WG = facts.attached ? X_WB * peer.grasp() : X_WB;
  const Vec3 r = facts.X_WG.p - X_WB.p;
  const Wrench& hand = peer.report().hand_B_W;
  facts.hand_G_W = {hand.tau - r.cross(hand.f), hand.f};
  facts.contact_points = peer.report().contact_points;
  if (facts.contact_points > 0) AddContacts(node.world(), held, facts);
  if (peer.shared() != nullptr) {
    facts.instance_count = static_cast<std::uint32_t>(peer.shared()->Instances(facts.instances));
  }
}

}  // namespace tandem
