#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "engine/base/spatial.h"

namespace tandem {

/// What peers tell one another, as plain values; idl/tandem.idl is their form on the wire. SI
/// units, world frame; times are the *sender's* monotonic clock in ns and are never compared with
/// the receiver's, only sent back (`echo_ns`).

using PeerId = std::uint64_t;    // random, never 0
using ObjectId = std::uint32_t;  // index into Scene::bodies

inline constexpr std::uint32_t kProtocol = 1;
inline constexpr std::size_t kMaxPeers = 8;  // active ones, oneself included
inline constexpr std::size_t kMaxLinks = kMaxPeers;
inline constexpr std::size_t kMaxViewBodies = 24;

enum class Role : std::uint8_t { kActive, kViewer };

/// An instance of a body as one peer simulates it; topic state/1, up to 1 kHz.
struct ObjectState {
  PeerId peer = 0;
  ObjectId object = 0;
  std::uint32_t epoch = 0;  // +1 at each grab
  std::uint32_t seq = 0;
  std::uint32_t flags = 0;
  std::int64_t sample_ns = 0;
  Pose X_WB;
  Twist V_WB;
  Wrench contact_B_W;  // contact on the body about its centre of mass, without couplings
};

/// What one coupling between two instances of a shared body needs and does.
struct LinkEntry {
  PeerId to = 0;
  std::int64_t echo_ns = 0;  // newest sample_ns of `to` that the sender holds
  double stiffness = 0;      // N/m that the sender would use; both ends use the smaller
  Wrench applied_B_W;        // on the sender's instance; shown, never applied by the receiver
};

/// With each state of a shared body; topic link/1.
struct CouplingLinks {
  PeerId from = 0;
  ObjectId object = 0;
  std::uint32_t seq = 0;
  std::int64_t sample_ns = 0;
  std::uint32_t count = 0;
  std::array<LinkEntry, kMaxLinks> entries{};
};

/// A body as viewers get it: X_W is its displacement from its initial pose, so that p_W now = X_W *
/// p_W at first.
struct ViewBody {
  static constexpr std::uint32_t kHeld = 1;  // by the sender's hand
  static constexpr std::uint32_t kInContact = 2;

  ObjectId object = 0;
  std::uint32_t flags = 0;
  Pose X_W;
  Vec3 hand_force_W = Vec3::Zero();  // what the sender's hand coupling puts on it
};

/// A peer's bodies, for viewers; topic view/1, 60 Hz.
struct ViewFrame {
  PeerId peer = 0;
  std::uint32_t seq = 0;
  std::int64_t sample_ns = 0;
  float delay_ms = 0;  // half the loop age, the largest over its partners; 0 when alone
  std::uint32_t count = 0;
  std::array<ViewBody, kMaxViewBodies> bodies{};
};

/// Who takes part; topic peer_info, on change and again a few times a second (`beat`).
struct PeerInfo {
  PeerId peer = 0;
  std::uint32_t protocol = kProtocol;
  std::uint32_t beat = 0;
  Role role = Role::kActive;
  std::string name;
  std::uint64_t scene_hash = 0;
  std::vector<ObjectId> held;
};

/// What the session is about; topic scene, kept for those who come later.
struct SceneManifest {
  std::uint64_t scene_hash = 0;  // the key
  std::string name;
  std::string file;  // where the offering peer has it: a hint for viewers on the same machine
  double voxel_size = 0;
  std::uint32_t body_count = 0;
};

}  // namespace tandem
