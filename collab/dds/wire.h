#pragma once

#include <optional>
#include <vector>

#include "collab/drop_counts.h"
#include "collab/messages.h"
#include "tandem.h"  // idlc's

namespace tandem {

/// Beyond these no sound peer is; SI units.
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

/// Between the plain messages and their form on the wire (idl/tandem.idl).
///
/// FromWire answers why the sample is none that a sound peer sends, the first reason found, or
/// nothing when it is sound: a number that is not finite or beyond kWireBounds, a quaternion off
/// unit length by more than a thousandth (within, it is brought to unit length), a count beyond its
/// array, a peer of id 0. The output is then unspecified. Those of the control topics answer false
/// for the same. Those of state, links and view neither allocate nor throw.
void ToWire(const ObjectState& state, tandem_ObjectState& wire) noexcept;
std::optional<Drop> FromWire(const tandem_ObjectState& wire, ObjectState& state) noexcept;

/// A state and the links of its sender.
struct LinkedState {
  ObjectState state;
  CouplingLinks links;
};
/// At most kMaxLinks entries are sent. Whom the links are from, the state says.
void ToWire(const LinkedState& linked, tandem_LinkedState& wire) noexcept;
std::optional<Drop> FromWire(const tandem_LinkedState& wire, LinkedState& linked) noexcept;

/// In single precision; at most kMaxViewBodies bodies are sent.
void ToWire(const ViewFrame& frame, tandem_ViewFrame& wire) noexcept;
std::optional<Drop> FromWire(const tandem_ViewFrame& wire, ViewFrame& frame) noexcept;

void ToWire(const Event& event, tandem_Event& wire) noexcept;
bool FromWire(const tandem_Event& wire, Event& event) noexcept;

/// What the lists of a peer_info that is sent lie in.
struct InfoRoom {
  std::vector<tandem_Claim> claims;
  std::vector<tandem_Belief> beliefs;
};

/// Names too long for the wire are cut before a character. False: more claims than the wire can
/// say. The wire's lists lie in `room`, and live as long.
bool ToWire(const PeerInfo& info, tandem_PeerInfo& wire, InfoRoom& room);
/// Control characters in names become '?'. Whoever says that it looks on claims and believes
/// nothing, whatever the sample says.
bool FromWire(const tandem_PeerInfo& wire, PeerInfo& info);

/// Of a viewer: that, its name and its beat.
void ToWire(const PeerInfo& info, tandem_ViewerInfo& wire);
bool FromWire(const tandem_ViewerInfo& wire, PeerInfo& info);

/// The last that a peer, or a viewer, says. It borrows nothing.
template <typename Wire>
Wire GoodbyeOf(PeerId peer, std::uint64_t incarnation) {
  Wire wire{};
  wire.peer = peer;
  wire.protocol = kProtocol;
  wire.incarnation = incarnation;
  wire.leaving = true;
  return wire;
}

/// A file name too long for the wire is left out: half of one is no hint. False: more bodies than
/// the wire can say. Its list of bodies lies in `room`, and lives as long.
bool ToWire(const SceneManifest& manifest, tandem_SceneManifest& wire,
            std::vector<tandem_BodyDecl>& room);
/// False also for force parameters that no scene file may have, and for a revision that is none.
bool FromWire(const tandem_SceneManifest& wire, SceneManifest& manifest);

}  // namespace tandem
