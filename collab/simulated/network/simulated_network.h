#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <variant>
#include <vector>

#include "collab/receive/link_conditioner.h"
#include "collab/session/transport.h"

namespace tandem {

/// A peer's monotonic clock: offset + t (1 + drift).
struct PeerClock {
  std::int64_t offset_ns = 0;
  double drift_ppm = 0;
};

/// Sees each message that a peer puts on the wire, at that moment.
class WireWatch {
 public:
  virtual ~WireWatch() = default;
  virtual void OnState(PeerId from, const ObjectState& state) = 0;
  virtual void OnLinks(PeerId from, const CouplingLinks& links) = 0;
  virtual void OnView(PeerId from, const ViewFrame& view) = 0;
  virtual void OnPeerInfo(PeerId from, const PeerInfo& info) = 0;
  virtual void OnEvent(PeerId from, const Event& event) = 0;
};

/// A network in virtual time for any number of peers in one thread. It behaves as DDS does:
///
/// - States, links and views arrive in the frame in which they are sent. The receiver's
///   conditioners add delay, jitter and loss, as in the product. A cut drops them.
/// - All else is reliable and keeps its order on each link. Here the link's conditioner delays it,
///   a loss costs a re-send, and a cut holds it back. A long cut forgets all but the newest
///   peer_info and scene, and a goodbye.
/// - A peer that is silent for longer than the lease is lost to the peers that do not hear it; its
///   next peer_info brings it back.
///
/// Viewers get views and no states, active peers states and no views. Every peer has its own clock.
/// The same seed and calls give the same deliveries in the same order.
class SimulatedNetwork {
 public:
  static constexpr std::int64_t kLeaseNs = 600'000'000;        // as kLivelinessLeaseNs of
                                                               // collab/dds/cyclone/qos.h
  static constexpr std::int64_t kForgetNs = 2'000'000'000;     // a participant's lease
  static constexpr std::int64_t kAlivePeriodNs = 100'000'000;  // between two signs of life
  static constexpr std::int64_t kResendNs = 100'000'000;       // after a loss
  static constexpr std::size_t kHistory = 8;                   // motion samples kept for a halted
                                                               // reader

  explicit SimulatedNetwork(std::uint64_t seed = 1) : seed_(seed) {}

  /// Adds a peer. The network and `inbox` must outlive the transport. A transport that is destroyed
  /// without Leave() is a crash: the others learn of it when the lease runs out.
  std::unique_ptr<Transport> Join(PeerId peer, Role role, Inbox& inbox, PeerClock clock = {});

  /// Advances all to `now_ns` of true time and delivers what is due.
  void Advance(std::int64_t now_ns);

  /// Returns the link of control traffic from one peer to another, so that its conditions can be
  /// switched.
  LinkConditioner& link(PeerId from, PeerId to) { return LineOf(from, to).conditioner; }
  /// Cuts the link from one peer to another, or ends the cut. A cut link passes nothing.
  void Cut(PeerId from, PeerId to, bool cut);
  /// Halts a peer as SIGSTOP does: it hears nothing and shows no life. The owner must not run it.
  void Halt(PeerId peer, bool halted);
  /// Steps a peer's clock or changes its rate.
  void SetClock(PeerId peer, PeerClock clock) { members_.at(peer).clock = clock; }
  PeerClock clock(PeerId peer) const { return members_.at(peer).clock; }
  /// Returns the time of a peer's clock.
  std::int64_t LocalNow(PeerId peer) const;

  /// Returns the true time since which `to` has counted `from` as here and the link from `from` was
  /// not cut. Nothing: `from` is not here, or the link is cut.
  std::optional<std::int64_t> ClearSince(PeerId from, PeerId to) const;
  bool IsCut(PeerId from, PeerId to) const;
  /// Returns the longest time that control traffic between any two peers has lately been on its
  /// way, ns. It includes re-sends and the wait for earlier messages.
  std::int64_t LongestWay() const;

  /// Null: no watch.
  void SetWatch(WireWatch* watch) noexcept { watch_ = watch; }

 private:
  class Link;
  struct LivelinessState {};
  struct Left {};
  using Control = std::variant<LivelinessState, Left, PeerInfo, Event, SceneManifest>;
  struct Member {
    Role role = Role::kActive;
    Inbox* inbox = nullptr;
    PeerClock clock;
    std::uint64_t incarnation = 0;
    bool halted = false;
    std::optional<PeerInfo> info;  // newest, for latecomers
    std::optional<SceneManifest> scene;
    std::map<PeerId, std::deque<std::variant<ObjectState, CouplingLinks, ViewFrame>>> backlog;
  };
  struct RemotePeerState {  // state of one peer as another hears it
    bool known = false;
    bool alive = false;
    std::int64_t received_ns = 0;
    std::int64_t since_ns = 0;  // start of being alive
  };
  struct MessageInFlight {
    std::int64_t due_ns = 0;
    std::uint64_t to_incarnation = 0;
    Control what;
  };
  struct Line {  // way from one peer to another
    LinkConditioner conditioner{LinkConditions{}};
    bool cut = false;
    std::int64_t cut_since_ns = 0;
    std::int64_t healed_ns = 0;
    std::int64_t longest_ns = 0;         // longest way of an item in this window
    std::int64_t longest_before_ns = 0;  // longest way in the window before
    std::int64_t last_due_ns = 0;
    std::deque<MessageInFlight> under_way;
    RemotePeerState hearing;
  };

  Line& LineOf(PeerId from, PeerId to);
  std::int64_t LocalNowOf(const Member& member) const;
  void Send(PeerId from, PeerId to, const Control& what);
  void SendToAll(PeerId from, const Control& what);
  template <typename T>
  void SendMotion(PeerId from, Role to, const T& what);
  void Arrive(Member& to, const ObjectState& state);
  void Arrive(Member& to, const CouplingLinks& links);
  void Arrive(Member& to, const ViewFrame& view);
  void Deliver(PeerId from, PeerId to, Line& line, const Control& what);
  void EndLeases();
  void Remove(PeerId peer, bool graceful);

  std::uint64_t seed_;
  std::int64_t now_ns_ = 0;
  std::int64_t next_alive_ns_ = 0;
  std::int64_t next_window_ns_ = 0;  // end of the window of the longest ways
  std::uint64_t incarnations_ = 0;
  std::map<PeerId, Member> members_;
  std::map<std::pair<PeerId, PeerId>, Line> lines_;
  WireWatch* watch_ = nullptr;
};

}  // namespace tandem
