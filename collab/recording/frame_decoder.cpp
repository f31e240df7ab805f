#include <bit>
#include <cmath>
#include <cstring>
#include <type_traits>

#include "collab/recording/frame_code.h"
#include "collab/recording/recording.h"

namespace tandem {

namespace {

static_assert(std::endian::native == std::endian::little);

// The most parts of a frame. The lengths of the peer's queues (PeerDirectory, PeerInbox, Peer)
// bound changes, events and commands. A frame of the recorder's ring bounds the samples.
constexpr std::size_t kMostChanges = 256;
constexpr std::size_t kMostEvents = 1024;
constexpr std::size_t kMostCommands = 64;
constexpr std::size_t kMostSamples = std::size_t{1} << 16U;
constexpr std::int64_t kLatestNs = std::int64_t{1} << 61U;  // so that no sum of times overflows

// The bounds by which peers check one another's samples (collab/dds/wire/wire.h).
constexpr double kFarthest = 1e3;
constexpr double kFastest = 50;
constexpr double kFastestTurn = 500;
constexpr double kStrongest = 1e4;
constexpr double kStiffest = 1e6;
constexpr double kMostEnergy = 1e9;
constexpr double kUnitTolerance = 1e-3;

// Takes numbers from a frame's bytes. Past their end it gives zeros and becomes unsound.
class Decoder {
 public:
  explicit Decoder(std::span<const char> bytes)
      : data_(bytes.data()), end_(bytes.data() + bytes.size()) {}
  template <typename T>
  void operator()(T& value) {
    value = T{};
    if (static_cast<std::size_t>(end_ - data_) < sizeof value) {
      sound_ = false;
      data_ = end_;
      return;
    }
    if constexpr (std::is_same_v<T, bool>) {
      sound_ = sound_ && (*data_ == 0 || *data_ == 1);
      value = *data_ == 1;
    } else {
      std::memcpy(&value, data_, sizeof value);
    }
    data_ += sizeof value;
  }
  void Expect(bool holds) { sound_ = sound_ && holds; }
  bool done() const { return data_ == end_ || !sound_; }
  bool sound() const { return sound_; }

 private:
  const char* data_;
  const char* end_;
  bool sound_ = true;
};

bool IsWithin(const Vec3& v, double most) {
  for (const double x : v) {
    if (!(std::abs(x) <= most)) return false;  // nor NaN
  }
  return true;
}
bool IsWithin(double x, double most) {
  return x >= 0 && x <= most;
}
bool IsSound(const Pose& pose) {
  return IsWithin(pose.p, kFarthest) && std::abs(pose.q.norm() - 1.0) <= kUnitTolerance;
}
bool IsSound(const Twist& twist) {
  return IsWithin(twist.w, kFastestTurn) && IsWithin(twist.v, kFastest);
}
bool IsSound(const Wrench& wrench) {
  return IsWithin(wrench.tau, kStrongest) && IsWithin(wrench.f, kStrongest);
}

bool IsSound(const MembershipChange& change) {
  return change.peer != 0 && change.kind <= MembershipChange::Kind::kBeliefs &&
         change.claim_count <= kMaxClaims && change.belief_count <= kMaxClaims;
}
bool IsSound(const Event& event) {
  return event.peer != 0 && event.kind <= EventKind::kTouch && IsSound(event.X_WB);
}
bool IsSound(const Command& command) {
  return command.kind <= Command::Kind::kScale && std::isfinite(command.metres);
}
bool IsSound(const ObjectState& state) {
  return state.peer != 0 && IsSound(state.X_WB) && IsSound(state.V_WB) &&
         IsSound(state.contact_B_W);
}
bool IsSound(const CouplingLinks& links) {
  if (links.from == 0 || links.count > kMaxLinks) return false;
  for (std::size_t i = 0; i < links.count; ++i) {
    const LinkEntry& entry = links.entries[i];
    if (!IsWithin(entry.stiffness, kStiffest) || !IsWithin(entry.gate_overflow, kMostEnergy) ||
        !IsSound(entry.applied_B_W)) {
      return false;
    }
  }
  return true;
}

template <typename T>
void TakePart(Decoder& decoder, std::size_t most, std::vector<T>& parts) {
  decoder.Expect(parts.size() < most);
  if (!decoder.sound()) return;
  T& part = parts.emplace_back();
  CodeFields(decoder, part);
  decoder.Expect(IsSound(part));
}

void TakePart(Decoder& decoder, FramePart part, RecordedFrame& frame) {
  switch (part) {
    case FramePart::kMembership:
      return TakePart(decoder, kMostChanges, frame.changes);
    case FramePart::kEvent:
      return TakePart(decoder, kMostEvents, frame.events);
    case FramePart::kState:
      return TakePart(decoder, kMostSamples, frame.states);
    case FramePart::kLinks:
      return TakePart(decoder, kMostSamples, frame.links);
    case FramePart::kCommand:
      return TakePart(decoder, kMostCommands, frame.commands);
    case FramePart::kDevice:
      CodeFields(decoder, frame.device);
      // a hand may be anywhere; its numbers are finite
      decoder.Expect(frame.device.X_WA.p.allFinite() &&
                     std::abs(frame.device.X_WA.q.norm() - 1.0) <= kUnitTolerance &&
                     frame.device.V_WA.v.allFinite() && frame.device.V_WA.w.allFinite());
      return;
    default:  // begin and end stand once, in their places; names stand alone
      decoder.Expect(false);
  }
}

}  // namespace

std::optional<RecordedFrame> DecodeFrame(std::span<const char> bytes) {
  Decoder decoder(bytes);
  RecordedFrame frame;
  FramePart part{};
  decoder(part);
  decoder(frame.now_ns);
  decoder(frame.capacity);
  decoder.Expect(part == FramePart::kBegin && frame.now_ns >= 0 && frame.now_ns <= kLatestNs &&
                 std::isfinite(frame.capacity) && frame.capacity >= 0);
  bool ended = false;
  while (!decoder.done() && !ended) {
    decoder(part);
    ended = part == FramePart::kEnd;
    if (ended) {
      decoder(frame.state_hash);
    } else {
      TakePart(decoder, part, frame);
    }
  }
  if (!ended || !decoder.sound() || !decoder.done()) return std::nullopt;
  return frame;
}

}  // namespace tandem
