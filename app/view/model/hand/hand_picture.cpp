#include "app/view/model/hand/hand_picture.h"

#include <algorithm>
#include <cmath>

namespace tandem {

namespace {

constexpr float kGoalOpacity = 0.28F;
constexpr double kLeastGoalLead = 2e-4;  // m, plus rad times 0.1 m; a smaller lead draws no ghost
constexpr float kContactTint = 0.45F;    // largest share of the tint, at full force
constexpr Colour kContactColour{0.90F, 0.10F, 0.05F};
constexpr Colour kNoForce{0.10F, 0.62F, 0.24F};
constexpr Colour kSomeForce{0.95F, 0.68F, 0.05F};
constexpr Colour kFullForce{0.85F, 0.08F, 0.05F};

Vec3 ToVec3(const std::array<double, 3>& v) {
  return {v[0], v[1], v[2]};
}

Colour Mixed(const Colour& a, const Colour& b, float share) {
  Colour mixed{};
  for (std::size_t i = 0; i < mixed.size(); ++i) mixed[i] = a[i] + share * (b[i] - a[i]);
  return mixed;
}

bool HeldBy(const SnapshotBody& body, std::uint64_t peer) {
  return std::find(body.holders.begin(), body.holders.end(), peer) != body.holders.end();
}

/// Returns the other user whose instance this controller shows, the body not being in this user's
/// hand; 0: none.
std::uint64_t ShownOf(const ControllerSnapshot& snapshot, std::size_t body) {
  const SnapshotBody& one = snapshot.bodies[body];
  if (one.in_hand || one.holders.empty() || HeldBy(one, snapshot.self)) return 0;
  return one.holders[0];
}

ViewedPeer Self(const ControllerSnapshot& snapshot, const std::string& name) {
  ViewedPeer self;
  self.info.peer = snapshot.self;
  self.info.name = name;
  self.info.role = Role::kActive;
  self.info.colour = snapshot.colour;
  self.info.stopped = snapshot.hand.state == SnapshotHand::State::kStopped;
  self.seq = static_cast<std::uint32_t>(snapshot.frame);
  self.received_ns = snapshot.time_ns;
  for (std::size_t i = 0; i < snapshot.bodies.size(); ++i) {
    const SnapshotBody& body = snapshot.bodies[i];
    if (body.fixed || ShownOf(snapshot, i) != 0) continue;
    ViewBody shown;
    shown.object = static_cast<ObjectId>(i);
    shown.X_W = ToPose(body.X_W);
    if (body.in_hand || HeldBy(body, snapshot.self)) shown.flags |= ViewBody::kHeld;
    if (body.in_hand && snapshot.contact_points > 0) shown.flags |= ViewBody::kInContact;
    if (body.in_hand) shown.hand_force_W = ToVec3(snapshot.hand.force_N);
    self.bodies.push_back(shown);
  }
  return self;
}

ViewedPeer Other(const ControllerSnapshot& snapshot, const SnapshotPeer& peer) {
  ViewedPeer other;
  other.info.peer = peer.id;
  other.info.name = peer.name;
  other.info.role = peer.active ? Role::kActive : Role::kViewer;
  other.info.colour = peer.colour;
  other.info.stopped = peer.stopped;
  other.presence = peer.here ? ViewedPeer::Presence::kHere : ViewedPeer::Presence::kLeft;
  other.delay_ms = 1e3 * peer.delay_s;
  other.link_force = peer.link_force_N;
  other.seq = static_cast<std::uint32_t>(snapshot.frame);
  other.received_ns = snapshot.time_ns;
  const auto add = [&](std::size_t body, const PlainPose& X_W) {
    ViewBody shown;
    shown.object = static_cast<ObjectId>(body);
    shown.X_W = ToPose(X_W);
    shown.flags = ViewBody::kHeld;
    other.bodies.push_back(shown);
  };
  for (const SnapshotInstance& instance : snapshot.instances) {
    if (instance.peer == peer.id && instance.body < snapshot.bodies.size()) {
      add(instance.body, instance.X_W);
    }
  }
  for (std::size_t i = 0; i < snapshot.bodies.size(); ++i) {
    if (ShownOf(snapshot, i) == peer.id) add(i, snapshot.bodies[i].X_W);
  }
  return other;
}

/// Returns the body in hand, an index into the snapshot's bodies; nothing: the hand is empty.
std::optional<std::size_t> InHand(const ControllerSnapshot& snapshot) {
  const std::int64_t body = snapshot.hand.body;
  if (body < 0 || static_cast<std::size_t>(body) >= snapshot.bodies.size()) return std::nullopt;
  return static_cast<std::size_t>(body);
}

}  // namespace

Pose ToPose(const PlainPose& X) {
  return {Quat(X.q_W[3], X.q_W[0], X.q_W[1], X.q_W[2]), ToVec3(X.p_W)};
}

PlainPose ToPlain(const Pose& X) {
  return {{X.p.x(), X.p.y(), X.p.z()}, {X.q.x(), X.q.y(), X.q.z(), X.q.w()}};
}

bool HandPicture::operator==(const HandPicture& other) const {
  const auto same = [](const Pose& a, const Pose& b) {
    return a.p == b.p && a.q.coeffs() == b.q.coeffs();
  };
  return tether == other.tether && contacts == other.contacts && hot == other.hot &&
         figures == other.figures && locked_line_W == other.locked_line_W &&
         X_WT.has_value() == other.X_WT.has_value() && (!X_WT || same(*X_WT, *other.X_WT));
}

ControllerSnapshot WithoutHand(const ControllerSnapshot& last) {
  ControllerSnapshot still = last;
  still.hand = {};
  still.instances.clear();
  still.contacts.clear();
  still.contact_points = 0;
  still.distance = {};
  still.asked.reset();
  for (SnapshotBody& body : still.bodies) {
    body.in_hand = false;
    std::erase(body.holders, last.self);
  }
  return still;
}

ViewerPicture PictureOf(const ControllerSnapshot& snapshot, const std::string& name, bool alive) {
  ViewerPicture picture;
  picture.samples = snapshot.frame;
  picture.newest_sample_ns = snapshot.time_ns;
  picture.self = snapshot.self;
  picture.peers.push_back(Self(snapshot, name));
  for (const SnapshotPeer& peer : snapshot.peers) {
    if (peer.id != snapshot.self) picture.peers.push_back(Other(snapshot, peer));
  }
  if (alive) return picture;
  using Presence = ViewedPeer::Presence;
  for (ViewedPeer& peer : picture.peers) {
    if (peer.presence == Presence::kHere) peer.presence = Presence::kUnknown;
    peer.info.stopped = false;
  }
  picture.peers.front().presence = Presence::kLost;
  return picture;
}

void AddGoal(const ControllerSnapshot& snapshot, const Pose& goal,
             const std::vector<BodyLook>& bodies, DrawList& list) {
  const std::optional<std::size_t> held = InHand(snapshot);
  if (!held) return;
  const double force = ToVec3(snapshot.hand.force_N).norm();
  for (BodyInstance& solid : list.solids) {
    if (solid.body >= bodies.size() || bodies[solid.body].part_of.value_or(solid.body) != *held) {
      continue;
    }
    solid.X_W = ToPose(snapshot.bodies[*held].X_W);  // the user's own hand is drawn without
                                                     // smoothing
    if (snapshot.contact_points > 0) {
      const auto share = static_cast<float>(std::min(force / kTetherFullForce, 1.0));
      solid.colour = Mixed(solid.colour, kContactColour, kContactTint * (0.4F + 0.6F * share));
    }
  }
  const Pose X_WG = ToPose(snapshot.hand.X_WG);
  const Pose lead = goal * X_WG.Inverse();
  const double turned = RotationVector(lead.q).norm();
  if ((goal.p - X_WG.p).norm() + 0.1 * turned < kLeastGoalLead) return;
  const Pose X_W = lead * ToPose(snapshot.bodies[*held].X_W);
  for (std::size_t part = 0; part < bodies.size(); ++part) {
    if (bodies[part].part_of.value_or(part) != *held) continue;
    list.ghosts.push_back({part, X_W, ForceColour(force), kGoalOpacity});
  }
}

HandPicture HandPictureOf(const ControllerSnapshot& snapshot, const Pose& goal) {
  HandPicture picture;
  if (!InHand(snapshot)) return picture;
  picture.tether =
      Tether{ToVec3(snapshot.hand.X_WG.p_W), goal.p, ToVec3(snapshot.hand.force_N).norm()};
  for (const SnapshotContact& contact : snapshot.contacts) {
    picture.contacts.push_back({ToVec3(contact.p_W), ToVec3(contact.n_W), contact.force_N});
  }
  return picture;
}

Colour ForceColour(double force_N) {
  const auto share = static_cast<float>(std::clamp(force_N / kTetherFullForce, 0.0, 1.0));
  return share < 0.5F ? Mixed(kNoForce, kSomeForce, 2 * share)
                      : Mixed(kSomeForce, kFullForce, 2 * share - 1);
}

}  // namespace tandem
