#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "collab/peer/frame_tap.h"

namespace tandem {

/// The inputs of a frame as they stand in a recording: field by field, little-endian, doubles as
/// their bits. One function per type serves writing and reading: `code(x)` takes or gives a number.
/// A frame is its parts, each after a byte that names it. Peers' names stand between frames.
enum class FramePart : std::uint8_t {
  kBegin = 1,
  kMembership,
  kEvent,
  kState,
  kLinks,
  kCommand,
  kDevice,
  kEnd,
  kName  // stands alone, between frames: a peer's id, and its name in kNameBytes
};
inline constexpr std::size_t kNameBytes = 64;  // padded with zeros

template <typename T, typename U>
concept MaybeConst = std::same_as<std::remove_const_t<T>, U>;

template <typename Code, MaybeConst<Pose> T>
void CodeFields(Code& code, T& pose) {
  for (int i = 0; i < 4; ++i) code(pose.q.coeffs()[i]);
  for (int i = 0; i < 3; ++i) code(pose.p[i]);
}
template <typename Code, MaybeConst<Twist> T>
void CodeFields(Code& code, T& twist) {
  for (int i = 0; i < 3; ++i) code(twist.w[i]);
  for (int i = 0; i < 3; ++i) code(twist.v[i]);
}
template <typename Code, MaybeConst<Wrench> T>
void CodeFields(Code& code, T& wrench) {
  for (int i = 0; i < 3; ++i) code(wrench.tau[i]);
  for (int i = 0; i < 3; ++i) code(wrench.f[i]);
}
template <typename Code, MaybeConst<Anchor> T>
void CodeFields(Code& code, T& anchor) {
  CodeFields(code, anchor.X_WA);
  CodeFields(code, anchor.V_WA);
}
template <typename Code, MaybeConst<ObjectState> T>
void CodeFields(Code& code, T& state) {
  code(state.peer);
  code(state.object);
  code(state.epoch);
  code(state.seq);
  code(state.flags);
  code(state.sample_ns);
  CodeFields(code, state.X_WB);
  CodeFields(code, state.V_WB);
  CodeFields(code, state.contact_B_W);
}
template <typename Code, MaybeConst<CouplingLinks> T>
void CodeFields(Code& code, T& links) {
  code(links.from);
  code(links.object);
  code(links.seq);
  code(links.sample_ns);
  code(links.count);
  for (std::size_t i = 0; i < links.count && i < links.entries.size(); ++i) {
    auto& entry = links.entries[i];
    code(entry.to);
    code(entry.echo_ns);
    code(entry.stiffness);
    code(entry.gate_overflow);
    CodeFields(code, entry.applied_B_W);
  }
}
template <typename Code, MaybeConst<MembershipChange> T>
void CodeFields(Code& code, T& change) {
  code(change.kind);
  code(change.peer);
  code(change.claim_count);
  for (std::size_t i = 0; i < change.claim_count && i < change.claims.size(); ++i) {
    auto& claim = change.claims[i];
    code(claim.object);
    code(claim.epoch);
    code(claim.held);
  }
  code(change.belief_count);
  for (std::size_t i = 0; i < change.belief_count && i < change.beliefs.size(); ++i) {
    code(change.beliefs[i].object);
    code(change.beliefs[i].peer);
    code(change.beliefs[i].epoch);
  }
}
template <typename Code, MaybeConst<Event> T>
void CodeFields(Code& code, T& event) {
  code(event.peer);
  code(event.seq);
  code(event.kind);
  code(event.object);
  code(event.epoch);
  code(event.to);
  CodeFields(code, event.X_WB);
}
template <typename Code, MaybeConst<Command> T>
void CodeFields(Code& code, T& command) {
  code(command.kind);
  code(command.object);
  code(command.to);
  if (command.kind == Command::Kind::kLayer) code(command.layer);
  if (command.kind == Command::Kind::kDisplace || command.kind == Command::Kind::kScale) {
    code(command.metres);
  }
}

}  // namespace tandem
