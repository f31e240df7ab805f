#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "engine/base/files/sha256.h"
#include "engine/base/spatial.h"

namespace tandem {

/// Messages between peers, as plain values; idl/tandem.idl is their wire format. SI units, world
/// frame. Times are the *sender's* monotonic clock in ns. They are never compared with the
/// receiver's, only sent back (`echo_ns`).

using PeerId = std::uint64_t;    // random, never 0
using ObjectId = std::uint32_t;  // index into Scene::bodies

inline constexpr std::uint32_t kProtocol = 6;
inline constexpr std::size_t kMaxPeers = 16;   // active peers, this one included
inline constexpr std::size_t kMaxLinks = 8;    // couplings of one instance
inline constexpr std::size_t kMaxClaims = 64;  // bodies that one peer can answer for
inline constexpr std::size_t kMaxSceneBodies = 256;
inline constexpr ObjectId kNoObject = 0xFFFFFFFF;
inline constexpr std::size_t kMaxViewBodies = 24;

enum class Role : std::uint8_t { kActive, kViewer };

/// Bits of ObjectState::flags in addition to those of StepReport (the low byte) and of FrameLimits
/// (21 bits from 0x200 on, and 0x80000000).
enum StateFlag : std::uint32_t {
  kStateParked = 0x100,     // in no hand: the pose where it stands, 5 times a second
  kStateLoose = 0x40000000  // a free body in no hand: it moves at its authority
};

/// An instance of a body as one peer simulates it, at up to 1 kHz; topic state/1, or link/2 with
/// links. A peer sends one of its loose bodies in each frame, in turn.
struct ObjectState {
  PeerId peer = 0;
  ObjectId object = 0;
  std::uint32_t epoch = 0;  // grows by 1 whenever the authority over the body changes
  std::uint32_t seq = 0;
  std::uint32_t flags = 0;
  std::int64_t sample_ns = 0;
  Pose X_WB;
  Twist V_WB;
  Wrench contact_B_W;  // as in StepReport: applied contact wrench about the centre of mass
};

/// State of one coupling between two instances of a shared body, as its sender sees it.
struct LinkEntry {
  PeerId to = 0;
  std::int64_t echo_ns = 0;  // newest sample_ns of `to` that the sender has
  double stiffness = 0;      // N/m; the sender's offer: both ends use the smaller
  double gate_overflow = 0;  // J, cumulative; energy passed by the sender's gate beyond its tank
  Wrench applied_B_W;  // wrench on the sender's instance; shown, never applied by the receiver
};

/// Sent by every active peer to the others with each state of the body in hand, eight peers in turn
/// where there are more; topic link/2. `object` is the body in hand if it is shared. Otherwise it
/// is kNoObject, and the echoes alone count.
struct CouplingLinks {
  PeerId from = 0;
  ObjectId object = 0;
  std::uint32_t seq = 0;
  std::int64_t sample_ns = 0;
  std::uint32_t count = 0;
  std::array<LinkEntry, kMaxLinks> entries{};
};

/// Copies the used part of a message: one core writes each message and another reads it.
template <typename T>
void CopyUsed(T& to, const T& from) noexcept {
  to = from;
}
inline void CopyUsed(CouplingLinks& to, const CouplingLinks& from) noexcept {
  to.from = from.from;
  to.object = from.object;
  to.seq = from.seq;
  to.sample_ns = from.sample_ns;
  to.count = from.count;
  const std::size_t used = std::min<std::size_t>(from.count, kMaxLinks);
  std::copy_n(from.entries.begin(), used, to.entries.begin());
}

/// A body as sent to viewers. X_W is its displacement from its initial pose: p_W now = X_W * p_W at
/// first.
struct ViewBody {
  static constexpr std::uint32_t kHeld = 1;  // in the sender's hand
  static constexpr std::uint32_t kInContact = 2;
  static constexpr std::uint32_t kTrapped = 4;  // something fixed keeps it from another's instance

  ObjectId object = 0;
  std::uint32_t flags = 0;  // the flags above, and of a held body its holder's FrameLimits
  Pose X_W;
  Vec3 hand_force_W = Vec3::Zero();  // N; force of the sender's hand coupling on it
};

/// A peer's bodies, for viewers; topic view/1, 60 Hz.
struct ViewFrame {
  PeerId peer = 0;
  std::uint32_t seq = 0;
  std::int64_t sample_ns = 0;
  float delay_ms = 0;       // half the largest loop age over its coupled peers; 0 when alone
  float mirror_lag_mm = 0;  // greatest distance of its mirrors from their received poses
  float link_force = 0;     // N; largest force of its couplings on the body in hand
  Twist V_W;  // twist of the body in hand at its X_W; only for the picture between two frames
  std::uint32_t count = 0;
  std::array<ViewBody, kMaxViewBodies> bodies{};
};

/// A claim to answer for a body. A later epoch is greater, then a lower peer id; the greater claim
/// counts.
struct Claim {
  ObjectId object = 0;
  std::uint32_t epoch = 0;
  bool held = false;  // the claimant has it in hand

  friend bool operator==(const Claim&, const Claim&) = default;
};

enum class EventKind : std::uint8_t {
  kAsk,
  kGrant,
  kRefuse,
  kRelease,
  kHeal,
  kTouch  // the sender's body in hand pushes this free one: the sender wants to answer for it
};

/// One statement of a peer to another about a body; topic event, all delivered in order.
struct Event {
  PeerId peer = 0;  // sender
  std::uint32_t seq = 0;
  EventKind kind = EventKind::kAsk;
  ObjectId object = 0;
  std::uint32_t epoch = 0;
  PeerId to = 0;  // receiver; 0: all
  Pose X_WB;      // pose of a granted or released body
};

/// Greatest epoch of a claim: epochs never wrap, however far a peer counts.
inline constexpr std::uint32_t kLastEpoch = 0x7FFFFFFF;

/// The authority of a body in its sender's view, and its epoch. From the body's former authority it
/// is the word where the body went; from other peers it is a vote when two claim the body.
struct Belief {
  ObjectId object = 0;
  PeerId peer = 0;
  std::uint32_t epoch = 0;

  friend bool operator==(const Belief&, const Belief&) = default;
};

/// Settings that affect a peer's forces besides the scene's force parameters; shown to other peers,
/// applied nowhere.
struct ForceTerms {
  std::string law;                // coupling law
  std::string gains;              // limits that differ from the law's defaults, "name=value …"
  bool gate = true;               // links generate no energy
  bool contact = true;            // bodies push one another
  std::int32_t force_layer = -1;  // force layer of the body in hand; -1: the scene's
  double displacement = 0;        // m; displacement of its points along their inward normals

  friend bool operator==(const ForceTerms&, const ForceTerms&) = default;
};

/// Describes the terms for a person: "law p+dd, no contact".
std::string Describe(const ForceTerms& terms);

/// Describes how another's terms differ from ours: "law constant (here p+dd), no contact"; empty if
/// they agree.
std::string TermsDifference(const ForceTerms& ours, const ForceTerms& theirs);

/// A participant; topic peer_info, sent on change and a few times a second (`beat`). Viewers have
/// the topic viewer_info, with a name and no more.
struct PeerInfo {
  PeerId peer = 0;
  std::uint32_t protocol = kProtocol;
  std::uint32_t beat = 0;
  Role role = Role::kActive;
  std::string name;
  std::uint64_t scene_hash = 0;   // hash of the scene's content, for messages to people
  std::uint64_t params_hash = 0;  // hash of its voxel size and force parameters
  std::vector<Claim> claims;      // bodies that the peer holds or answers for
  /// Random number of this run of the program; the transport fills it in. 0: an older protocol.
  std::uint64_t incarnation = 0;
  bool leaving = false;     // a goodbye; set by the transport
  std::uint8_t colour = 0;  // number of its user's colour (PersonColour); 0: not chosen yet
  bool stopped = false;     // its hand is in an emergency stop: it holds and takes nothing
  ForceTerms terms;
  std::vector<Belief> beliefs;  // believed authorities of bodies of other peers
  Sha256 scene_digest{};        // digest of the scene's content
};

/// A body of the scene, for peers that compare theirs with it.
struct BodyDecl {
  std::string name;
  std::uint64_t values_hash = 0;  // scale, placement, mass, sharing, constraint
  std::uint64_t mesh_hash = 0;    // hash of the bytes of its mesh file
  Sha256 mesh_digest{};           // SHA-256 of its mesh file

  friend bool operator==(const BodyDecl&, const BodyDecl&) = default;
};

/// The scene of the session; topic scene, kept for later participants. Of several manifests that
/// with the highest revision counts, then that of the lowest `offered_by`. A peer that adopts a
/// manifest also offers it, so that it outlives its author (SceneOffers).
struct SceneManifest {
  /// Revision of an offer by a peer that keeps its own force parameters instead of the session's.
  static constexpr std::uint32_t kOwnOnly = 0;
  static constexpr std::uint32_t kSession = 1;   // revision of the session's manifest
  static constexpr std::uint32_t kUnderWay = 2;  // likewise, once a peer simulates by it

  PeerId offered_by = 0;  // the key
  std::uint32_t revision = kSession;
  std::uint64_t content_hash = 0;  // hash of all bodies, pairs and gravity
  std::string name;
  std::string file;  // path at the offering peer: a hint for viewers on the same machine
  double voxel_size = 0;
  double contact_stiffness = 0;    // N/m; at a point of a light body
  std::int32_t force_layer = 0;    // as in ForceParameters, like the two below
  std::uint8_t contact_model = 0;  // ContactModel
  double friction = 0;
  std::vector<BodyDecl> bodies;
  Sha256
      content_digest{};  // digest of all bodies, pairs and gravity; it alone identifies the scene
};

}  // namespace tandem
