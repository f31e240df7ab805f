#pragma once

#include <algorithm>
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

inline constexpr std::uint32_t kProtocol = 5;
inline constexpr std::size_t kMaxPeers = 16;   // active ones, oneself included
inline constexpr std::size_t kMaxLinks = 8;    // couplings of one instance
inline constexpr std::size_t kMaxClaims = 64;  // bodies that one peer answers for
inline constexpr std::size_t kMaxSceneBodies = 256;
inline constexpr ObjectId kNoObject = 0xFFFFFFFF;
inline constexpr std::size_t kMaxViewBodies = 24;

enum class Role : std::uint8_t { kActive, kViewer };

/// Bits of ObjectState::flags beside those of StepReport, which are the low byte, and those of
/// FrameLimits, which are the 21 from 0x200 on, and 0x80000000.
enum StateFlag : std::uint32_t {
  kStateParked = 0x100,     // nobody has it in hand: where it stands, 5 times a second
  kStateLoose = 0x40000000  // a free body that nobody has in hand: it moves, at its authority
};

/// An instance of a body as one peer simulates it, up to 1 kHz; topic state/1, or link/2 where
/// links go with it. Of the loose bodies of a peer one goes out in each frame, in turn.
struct ObjectState {
  PeerId peer = 0;
  ObjectId object = 0;
  std::uint32_t epoch = 0;  // +1 whenever the authority over the body changes
  std::uint32_t seq = 0;
  std::uint32_t flags = 0;
  std::int64_t sample_ns = 0;
  Pose X_WB;
  Twist V_WB;
  Wrench contact_B_W;  // as of StepReport: contact about the body's centre of mass, as applied
};

/// What one coupling between two instances of a shared body needs and does.
struct LinkEntry {
  PeerId to = 0;
  std::int64_t echo_ns = 0;  // newest sample_ns of `to` that the sender holds
  double stiffness = 0;      // N/m that the sender would use; both ends use the smaller
  double gate_overflow = 0;  // J that its energy gate let through beyond its tank, cumulative
  Wrench applied_B_W;        // on the sender's instance; shown, never applied by the receiver
};

/// From every active peer to the others, eight in turn where there are more, with each state of
/// what it holds; topic link/2. `object` is that body where it is shared, or kNoObject: then the
/// echoes alone count.
struct CouplingLinks {
  PeerId from = 0;
  ObjectId object = 0;
  std::uint32_t seq = 0;
  std::int64_t sample_ns = 0;
  std::uint32_t count = 0;
  std::array<LinkEntry, kMaxLinks> entries{};
};

/// Copies as much of a message as it uses: each is written by one core and read by another.
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

/// A body as viewers get it: X_W is its displacement from its initial pose, so that p_W now = X_W *
/// p_W at first.
struct ViewBody {
  static constexpr std::uint32_t kHeld = 1;  // by the sender's hand
  static constexpr std::uint32_t kInContact = 2;
  static constexpr std::uint32_t kTrapped = 4;  // something fixed keeps it from another's instance

  ObjectId object = 0;
  std::uint32_t flags = 0;  // these, and of what is held the FrameLimits of its holder
  Pose X_W;
  Vec3 hand_force_W = Vec3::Zero();  // what the sender's hand coupling puts on it
};

/// A peer's bodies, for viewers; topic view/1, 60 Hz.
struct ViewFrame {
  PeerId peer = 0;
  std::uint32_t seq = 0;
  std::int64_t sample_ns = 0;
  float delay_ms = 0;       // half the loop age, the largest over its partners; 0 when alone
  float mirror_lag_mm = 0;  // the farthest that others' bodies are here from where they were said
  float link_force = 0;     // N, the largest of its couplings on the body in hand
  Twist V_W;  // of the body in hand, at its X_W; for the picture between two frames, nothing else
  std::uint32_t count = 0;
  std::array<ViewBody, kMaxViewBodies> bodies{};
};

/// Who answers for a body. The greater claim counts: of the later epoch, then of the lower peer id.
struct Claim {
  ObjectId object = 0;
  std::uint32_t epoch = 0;
  bool held = false;  // in the claimant's hand

  friend bool operator==(const Claim&, const Claim&) = default;
};

enum class EventKind : std::uint8_t {
  kAsk,
  kGrant,
  kRefuse,
  kRelease,
  kHeal,
  kTouch  // what the sender holds pushes that free body: the sender wants to answer for it
};

/// What one peer says to another about a body, once; topic event, all of them in order.
struct Event {
  PeerId peer = 0;  // who says it
  std::uint32_t seq = 0;
  EventKind kind = EventKind::kAsk;
  ObjectId object = 0;
  std::uint32_t epoch = 0;
  PeerId to = 0;  // 0: to all
  Pose X_WB;      // of a grant or a release: where the body is
};

/// No claim is beyond this: epochs never wrap, whoever counts on.
inline constexpr std::uint32_t kLastEpoch = 0x7FFFFFFF;

/// Whom its sender takes for the one who answers for a body, and since which epoch: of the one who
/// had it before, a word; of others, a vote when two claim it.
struct Belief {
  ObjectId object = 0;
  PeerId peer = 0;
  std::uint32_t epoch = 0;

  friend bool operator==(const Belief&, const Belief&) = default;
};

/// What bears on the forces of a peer beside the scene's force parameters; shown to the others,
/// applied nowhere.
struct ForceTerms {
  std::string law;                // of couplings
  std::string gains;              // limits of it that are not its own, "name=value …"
  bool gate = true;               // links generate no energy
  bool contact = true;            // bodies push one another
  std::int32_t force_layer = -1;  // of what is in hand; -1: the scene's
  double displacement = 0;        // m, of its points along their inward normals

  friend bool operator==(const ForceTerms&, const ForceTerms&) = default;
};

/// "law p+dd, no contact", for a person.
std::string Describe(const ForceTerms& terms);

/// In what others' terms differ from ours, "law constant (here p+dd), no contact"; empty: in
/// nothing.
std::string TermsDifference(const ForceTerms& ours, const ForceTerms& theirs);

/// Who takes part; topic peer_info, on change and again a few times a second (`beat`). Viewers have
/// the topic viewer_info: they have a name and no more.
struct PeerInfo {
  PeerId peer = 0;
  std::uint32_t protocol = kProtocol;
  std::uint32_t beat = 0;
  Role role = Role::kActive;
  std::string name;
  std::uint64_t scene_hash = 0;   // of what the scene is made of
  std::uint64_t params_hash = 0;  // of its voxel size and force parameters
  std::vector<Claim> claims;      // bodies that the peer holds or answers for
  /// Random, of this run of the program; the transport fills it in. 0: of an older protocol.
  std::uint64_t incarnation = 0;
  bool leaving = false;  // the transport's: a goodbye
  ForceTerms terms;
  std::vector<Belief> beliefs;  // of what others answer for
};

/// A body of the scene, for those who compare theirs with it.
struct BodyDecl {
  std::string name;
  std::uint64_t values_hash = 0;  // scale, placement, mass, sharing, constraint
  std::uint64_t mesh_hash = 0;    // the bytes of its mesh file

  friend bool operator==(const BodyDecl&, const BodyDecl&) = default;
};

/// What the session is about; topic scene, kept for those who come later. Of several the one of the
/// highest revision counts, then that of the lowest `offered_by`; a peer that adopts one offers it
/// on, so that it outlives its author (SceneOffers).
struct SceneManifest {
  /// Of the offer of a peer that keeps to its own force parameters: the session's are others.
  static constexpr std::uint32_t kOwnOnly = 0;
  static constexpr std::uint32_t kSession = 1;
  static constexpr std::uint32_t kUnderWay = 2;  // of the session's, once somebody simulates by it

  PeerId offered_by = 0;  // the key
  std::uint32_t revision = kSession;
  std::uint64_t content_hash = 0;  // of all bodies, pairs and gravity
  std::string name;
  std::string file;  // where the offering peer has it: a hint for viewers on the same machine
  double voxel_size = 0;
  double contact_stiffness = 0;    // N/m at a point of a light body
  std::int32_t force_layer = 0;    // as of ForceParameters, and the two below
  std::uint8_t contact_model = 0;  // ContactModel
  double friction = 0;
  std::vector<BodyDecl> bodies;
};

}  // namespace tandem
