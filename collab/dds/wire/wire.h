#pragma once

#include <optional>
#include <vector>

#include "collab/session/drop_counts.h"
#include "collab/session/messages.h"
#include "tandem.h"  // idlc's

namespace tandem {

/// No sound peer is beyond these bounds; SI units.
struct WireBounds {
  double position = 1e3;
  double speed = 50;
  double spin = 500;
  double force = 1e4;
  double torque = 1e4;
  double stiffness = 1e6;
  double energy = 1e9;
  double delay_ms = 1e6;
};
inline constexpr WireBounds kWireBounds;

/// Converts between the plain messages and their wire format (idl/tandem.idl).
///
/// FromWire returns the first reason why no sound peer sends the sample, or nothing when it is
/// sound. The reasons are a number that is not finite or beyond kWireBounds, a count beyond its
/// array, and a peer of id 0. A quaternion more than a thousandth off unit length is a reason too;
/// within that it is brought to unit length. The output of an unsound sample is unspecified.
/// FromWire of event, peer_info, viewer_info and scene returns false for these reasons. Those of
/// state, links and view neither allocate nor throw.
void ToWire(const ObjectState& state, tandem_ObjectState& wire) noexcept;
std::optional<Drop> FromWire(const tandem_ObjectState& wire, ObjectState& state) noexcept;

/// A state and the links of its sender.
struct LinkedState {
  ObjectState state;
  CouplingLinks links;
};
/// Sends at most kMaxLinks entries. The state says which peer the links are from.
void ToWire(const LinkedState& linked, tandem_LinkedState& wire) noexcept;
std::optional<Drop> FromWire(const tandem_LinkedState& wire, LinkedState& linked) noexcept;

/// Sends single precision and at most kMaxViewBodies bodies.
void ToWire(const ViewFrame& frame, tandem_ViewFrame& wire) noexcept;
std::optional<Drop> FromWire(const tandem_ViewFrame& wire, ViewFrame& frame) noexcept;

void ToWire(const Event& event, tandem_Event& wire) noexcept;
bool FromWire(const tandem_Event& wire, Event& event) noexcept;

/// Holds the lists of a peer_info that is sent.
struct InfoBuffers {
  std::vector<tandem_Claim> claims;
  std::vector<tandem_Belief> beliefs;
};

/// Cuts names that are too long at the end of a character. False: there are more claims or beliefs
/// than the wire holds. The wire's lists lie in `room` and live as long as it.
bool ToWire(const PeerInfo& info, tandem_PeerInfo& wire, InfoBuffers& room);
/// Turns control characters in names into '?'. A viewer has no claims and beliefs, whatever the
/// sample says.
bool FromWire(const tandem_PeerInfo& wire, PeerInfo& info);

/// Sends of a viewer that it is one, its name and its beat.
void ToWire(const PeerInfo& info, tandem_ViewerInfo& wire);
bool FromWire(const tandem_ViewerInfo& wire, PeerInfo& info);

/// Returns the last sample of a peer or a viewer. It borrows nothing.
template <typename Wire>
Wire GoodbyeOf(PeerId peer, std::uint64_t incarnation) {
  Wire wire{};
  wire.peer = peer;
  wire.protocol = kProtocol;
  wire.incarnation = incarnation;
  wire.leaving = true;
  return wire;
}

/// Holds the lists of a manifest that is sent.
struct ManifestBuffers {
  std::vector<tandem_BodyDecl> bodies;
  std::vector<tandem_Sha256> digests;
};

/// Leaves out a file name that is too long, because half of one is no hint. False: there are more
/// bodies than the wire holds. The wire's lists lie in `room` and live as long as it.
bool ToWire(const SceneManifest& manifest, tandem_SceneManifest& wire, ManifestBuffers& room);
/// Returns false also for force parameters that no scene file may have, and for an invalid
/// revision.
bool FromWire(const tandem_SceneManifest& wire, SceneManifest& manifest);

}  // namespace tandem
