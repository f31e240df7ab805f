#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "collab/peer/frame_observer.h"

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

template <typename Code, MaybeConst<Vec3> T>
void CodeFields(Code& code, T& vector) {
  for (int i = 0; i < 3; ++i) code(vector[i]);
}

/// Codes fields one after another: each is a number, or a type with CodeFields().
template <typename Code, typename... Fields>
void CodeEach(Code& code, Fields&... fields) {
  const auto code_one = [&code]<typename Field>(Field& field) {
    if constexpr (std::is_arithmetic_v<Field> || std::is_enum_v<Field>) {
      code(field);
    } else {
      CodeFields(code, field);
    }
  };
  (code_one(fields), ...);
}

template <typename Code, MaybeConst<Pose> T>
void CodeFields(Code& code, T& pose) {
  for (int i = 0; i < 4; ++i) code(pose.q.coeffs()[i]);
  CodeFields(code, pose.p);
}
template <typename Code, MaybeConst<Twist> T>
void CodeFields(Code& code, T& twist) {
  CodeEach(code, twist.w, twist.v);
}
template <typename Code, MaybeConst<Wrench> T>
void CodeFields(Code& code, T& wrench) {
  CodeEach(code, wrench.tau, wrench.f);
}
template <typename Code, MaybeConst<Anchor> T>
void CodeFields(Code& code, T& anchor) {
  CodeEach(code, anchor.X_WA, anchor.V_WA);
}
template <typename Code, MaybeConst<ObjectState> T>
void CodeFields(Code& code, T& state) {
  CodeEach(code, state.peer, state.object, state.epoch, state.seq, state.flags, state.sample_ns,
           state.X_WB, state.V_WB, state.contact_B_W);
}
template <typename Code, MaybeConst<CouplingLinks> T>
void CodeFields(Code& code, T& links) {
  CodeEach(code, links.from, links.object, links.seq, links.sample_ns, links.count);
  for (std::size_t i = 0; i < links.count && i < links.entries.size(); ++i) {
    auto& entry = links.entries[i];
    CodeEach(code, entry.to, entry.echo_ns, entry.stiffness, entry.gate_overflow,
             entry.applied_B_W);
  }
}
template <typename Code, MaybeConst<MembershipChange> T>
void CodeFields(Code& code, T& change) {
  CodeEach(code, change.kind, change.peer, change.claim_count);
  for (std::size_t i = 0; i < change.claim_count && i < change.claims.size(); ++i) {
    auto& claim = change.claims[i];
    CodeEach(code, claim.object, claim.epoch, claim.held);
  }
  code(change.belief_count);
  for (std::size_t i = 0; i < change.belief_count && i < change.beliefs.size(); ++i) {
    auto& belief = change.beliefs[i];
    CodeEach(code, belief.object, belief.peer, belief.epoch);
  }
}
template <typename Code, MaybeConst<Event> T>
void CodeFields(Code& code, T& event) {
  CodeEach(code, event.peer, event.seq, event.kind, event.object, event.epoch, event.to,
           event.X_WB);
}
template <typename Code, MaybeConst<Command> T>
void CodeFields(Code& code, T& command) {
  CodeEach(code, command.kind, command.object, command.to);
  if (command.kind == Command::Kind::kLayer) code(command.layer);
  if (command.kind == Command::Kind::kDisplace || command.kind == Command::Kind::kScale) {
    code(command.metres);
  }
}

}  // namespace tandem
