#include "app/view/model/scene/picture_composer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <set>

namespace tandem {

namespace {

using Presence = ViewedPeer::Presence;

const ViewBody* BodyOf(const ViewedPeer& peer, std::size_t body) {
  for (const ViewBody& candidate : peer.bodies) {
    if (candidate.object == body) return &candidate;
  }
  return nullptr;
}

/// For each body the peer whose instance is drawn solid; null: no peer has sent the body.
using Owners = std::vector<const ViewedPeer*>;

/// Counts the peers here that believe another peer to be a body's authority, by body and peer. Each
/// peer counts once for a body.
std::map<std::pair<ObjectId, PeerId>, int> NamedForBodies(const std::vector<ViewedPeer>& peers) {
  std::map<std::pair<ObjectId, PeerId>, int> named;
  for (const ViewedPeer& peer : peers) {
    if (peer.presence != Presence::kHere) continue;
    std::set<ObjectId> seen;
    for (const Belief& belief : peer.info.beliefs) {
      const bool first = seen.insert(belief.object).second;
      if (first && belief.peer != peer.info.peer) ++named[{belief.object, belief.peer}];
    }
  }
  return named;
}

/// Returns the owner of each body. Among the peers here that claim it, most votes of others count
/// first, then the greatest epoch, then the lowest id. Without a claim it is the first peer here
/// that has the body, else the peer heard last.
Owners OwnersOf(const std::vector<ViewedPeer>& peers, std::size_t bodies) {
  Owners owners(bodies, nullptr);
  const std::map<std::pair<ObjectId, PeerId>, int> named = NamedForBodies(peers);
  struct Best {
    int votes = -1;
    std::uint32_t epoch = 0;
  };
  std::vector<Best> best(bodies);
  for (const ViewedPeer& peer : peers) {
    if (peer.presence != Presence::kHere) continue;
    for (const Claim& claim : peer.info.claims) {
      if (claim.object >= bodies || BodyOf(peer, claim.object) == nullptr) continue;
      const auto votes = named.find({claim.object, peer.info.peer});
      const Best its{votes == named.end() ? 0 : votes->second, claim.epoch};
      Best& most = best[claim.object];
      const ViewedPeer*& owner = owners[claim.object];
      const bool equal = its.votes == most.votes && its.epoch == most.epoch;
      const bool more = its.votes > most.votes ||
                        (its.votes == most.votes && its.epoch > most.epoch) ||
                        (equal && peer.info.peer < owner->info.peer);
      if (!more) continue;
      most = its;
      owner = &peer;
    }
  }
  for (std::size_t body = 0; body < bodies; ++body) {
    if (owners[body] != nullptr) continue;
    for (const ViewedPeer& peer : peers) {
      if (BodyOf(peer, body) == nullptr) continue;
      const ViewedPeer* const before = owners[body];
      if (before == nullptr || peer.received_ns > before->received_ns) owners[body] = &peer;
      if (peer.presence != Presence::kHere) continue;
      owners[body] = &peer;
      break;
    }
  }
  return owners;
}

}  // namespace

bool IsTrapped(const ViewedPeer& peer) {
  return std::any_of(peer.bodies.begin(), peer.bodies.end(), [](const ViewBody& body) {
    return (body.flags & ViewBody::kTrapped) != 0;
  });
}

namespace {

/// Returns how a peer's instance is marked if another peer here has one too; else empty.
std::string DrawnAs(const std::vector<ViewedPeer>& peers, const ViewedPeer& peer, std::size_t body,
                    const Owners& owners) {
  const bool alone = std::none_of(peers.begin(), peers.end(), [&](const ViewedPeer& other) {
    return &other != &peer && other.presence == Presence::kHere && BodyOf(other, body) != nullptr;
  });
  if (alone) return {};
  return owners[body] == &peer ? " \u00b7 solid" : " \u00b7 ghost";
}

std::string LabelText(const ViewedPeer& peer, const std::string& drawn_as) {
  const std::string name = DisplayName(peer);
  if (peer.presence == Presence::kUnknown) return name;
  if (peer.presence == Presence::kLeft) return name + " \u00b7 left";
  if (peer.presence == Presence::kLost) return name + " \u00b7 lost";
  std::string text = name + drawn_as;
  if (peer.delay_ms > 0) text += " \u00b7 " + std::to_string(std::lround(peer.delay_ms)) + " ms";
  if (IsTrapped(peer)) text += " \u00b7 trapped";
  if (peer.info.stopped) text += " \u00b7 stopped";
  return text;
}

bool SamePose(const Pose& a, const Pose& b) {
  return a.p == b.p && a.q.coeffs() == b.q.coeffs();
}

}  // namespace

bool operator==(const BodyInstance& a, const BodyInstance& b) {
  return a.body == b.body && SamePose(a.X_W, b.X_W) && a.colour == b.colour &&
         a.opacity == b.opacity;
}
bool operator==(const InstanceLabel& a, const InstanceLabel& b) {
  return a.text == b.text && a.colour == b.colour && a.body == b.body && SamePose(a.X_W, b.X_W) &&
         a.opacity == b.opacity;
}
bool operator==(const DrawList& a, const DrawList& b) {
  return a.solids == b.solids && a.ghosts == b.ghosts && a.labels == b.labels;
}

std::string DisplayName(const ViewedPeer& peer) {
  if (!peer.info.name.empty()) return peer.info.name;
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "peer %04x",
                static_cast<unsigned>(peer.info.peer & 0xffffU));
  return text.data();
}

float PictureComposer::Opacity(const ViewedPeer& peer, double now_s) {
  const auto [entry, is_new] = known_.try_emplace(peer.info.peer, Known{peer.presence, now_s});
  Known& known = entry->second;
  if (known.presence != peer.presence) {
    // a peer that is already fading continues to fade, however its presence changes
    const bool was_here = known.presence == Presence::kHere;
    if (was_here || peer.presence == Presence::kHere) known.since_s = now_s;
    known.presence = peer.presence;
  }
  if (peer.presence == Presence::kHere) return 1.0F;
  return static_cast<float>(std::clamp(1.0 - (now_s - known.since_s) / kFadeSeconds, 0.0, 1.0));
}

Pose PictureComposer::Shown(const ViewedPeer& peer, const ViewBody& body,
                            const std::vector<BodyLook>& bodies, double now_s) {
  DeadReckoning::ReceivedMotion reported{peer.seq, body.X_W, {}};
  const bool free = (body.flags & (ViewBody::kInContact | ViewBody::kTrapped)) == 0;
  const bool held = (body.flags & ViewBody::kHeld) != 0;
  if (held && free && peer.presence == Presence::kHere) reported.V_W = peer.V_W;
  return ahead_[{peer.info.peer, body.object}].Show(reported, bodies[body.object].middle_W, now_s);
}

void PictureComposer::Forget(const ViewerPicture& picture) {
  std::set<PeerId> peers;
  for (const ViewedPeer& peer : picture.peers) peers.insert(peer.info.peer);
  std::erase_if(known_, [&peers](const auto& entry) {
    return !peers.contains(entry.first);
  });
  std::erase_if(ahead_, [&peers](const auto& entry) {
    return !peers.contains(entry.first.first);
  });
}

DrawList PictureComposer::Compose(const ViewerPicture& picture, const std::vector<BodyLook>& bodies,
                                  double now_s) {
  Forget(picture);
  DrawList list;
  // computed once for each picture
  std::map<std::pair<PeerId, std::size_t>, Pose> shown;
  for (const ViewedPeer& peer : picture.peers) {
    for (const ViewBody& body : peer.bodies) {
      if (body.object >= bodies.size()) continue;
      const bool held = peer.presence == Presence::kHere && (body.flags & ViewBody::kHeld) != 0;
      if (held) list.held.push_back(body.object);
      shown[{peer.info.peer, body.object}] = Shown(peer, body, bodies, now_s);
    }
  }
  const Owners owners = OwnersOf(picture.peers, bodies.size());
  for (std::size_t body = 0; body < bodies.size(); ++body) {
    BodyInstance solid{body, {}, bodies[body].colour, 1.0F};
    const std::size_t whole = bodies[body].part_of.value_or(body);
    const ViewedPeer* owner = bodies[body].fixed ? nullptr : owners[whole];
    if (owner != nullptr) solid.X_W = shown.at({owner->info.peer, whole});
    list.solids.push_back(solid);
    list.reported.push_back(owner != nullptr ? BodyOf(*owner, whole)->X_W : Pose{});
  }
  for (const ViewedPeer& peer : picture.peers) {
    const float opacity = Opacity(peer, now_s);
    if (opacity <= 0) continue;
    const Colour colour = ColourOfPerson(peer.info);
    const ViewBody* named = nullptr;  // body beside which the name stands: a held one first
    for (const ViewBody& body : peer.bodies) {
      if (body.object >= bodies.size() || bodies[body.object].fixed) continue;
      if (named == nullptr ||
          ((body.flags & ViewBody::kHeld) != 0 && (named->flags & ViewBody::kHeld) == 0)) {
        named = &body;
      }
      if (owners[body.object] == &peer) continue;
      for (std::size_t part = 0; part < bodies.size(); ++part) {
        if (bodies[part].part_of.value_or(part) != body.object) continue;
        const Pose& X_W = shown.at({peer.info.peer, body.object});
        list.ghosts.push_back({part, X_W, colour, kGhostOpacity * opacity});
      }
    }
    // the user's own name is not shown while the hand is empty
    const bool own = peer.info.peer == picture.self && picture.self != 0;
    if (named != nullptr && !(own && (named->flags & ViewBody::kHeld) == 0)) {
      const Pose& X_W = shown.at({peer.info.peer, named->object});
      const std::string drawn_as = DrawnAs(picture.peers, peer, named->object, owners);
      list.labels.push_back({LabelText(peer, drawn_as), colour, named->object, X_W, opacity});
    }
  }
  return list;
}

}  // namespace tandem
