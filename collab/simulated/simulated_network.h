#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <variant>
#include <vector>

#include "collab/link_conditioner.h"
#include "collab/transport.h"

namespace tandem {

/// A peer's monotonic clock: offset + t (1 + drift).
struct PeerClock {
  std::int64_t offset_ns = 0;
  double drift_ppm = 0;
};

/// Sees what peers put on the wire, as they do.
class WireWatch {
 public:
  virtual ~WireWatch() = default;
  virtual void OnState(PeerId from, const ObjectState& state) = 0;
  virtual void OnLinks(PeerId from, const CouplingLinks& links) = 0;
  virtual void OnView(PeerId from, const ViewFrame& view) = 0;
  virtual void OnPeerInfo(PeerId from, const PeerInfo& info) = 0;
  virtual void OnEvent(PeerId from, const Event& event) = 0;
};

/// A network in virtual time for any number of peers in one thread, that behaves as DDS does:
///
/// - states, links and views arrive in the frame in which they are sent; delay, jitter and loss are
///   the receiver's conditioners, as in the product. A cut drops them.
/// - the rest is reliable and keeps its order on each link: it is delayed by the link's conditioner
///   here, a loss costs a re-send, a cut holds it back, a long cut forgets all but the newest
///   peer_info and scene.
/// - whoever is silent for longer than the lease is lost to those who do not hear him; the next
///   peer_info brings him back.
///
/// Viewers get views and no states, active peers states and no views. Every peer has a clock of its
/// own. The same seed and calls give the same deliveries in the same order.
class SimulatedNetwork {
 public:
  static constexpr std::int64_t kLeaseNs = 600'000'000;        // as QosForPeerInfo's
  static constexpr std::int64_t kForgetNs = 2'000'000'000;     // a participant's lease
  static constexpr std::int64_t kAlivePeriodNs = 100'000'000;  // how often life is shown
  static constexpr std::int64_t kResendNs = 100'000'000;       // after a loss
  static constexpr std::size_t kHistory = 8;                   // motion kept for a halted reader

  explicit SimulatedNetwork(std::uint64_t seed = 1) : seed_(seed) {}

  /// Both the network and `inbox` must outlive the transport. A transport destroyed without Leave()
  /// is a crash: the others learn of it when the lease runs out.
  std::unique_ptr<Transport> Join(PeerId peer, Role role, Inbox& inbox, PeerClock clock = {});

  /// Brings everything to `now_ns` of true time and delivers what is due.
  void Advance(std::int64_t now_ns);

  /// The link of control traffic from one peer to another, to be switched.
  LinkConditioner& link(PeerId from, PeerId to) { return LineOf(from, to).conditioner; }
  /// Nothing passes from one to the other, of any kind; one-way.
  void Cut(PeerId from, PeerId to, bool cut);
  /// As by SIGSTOP: it hears nothing and shows no life; the owner does not run it.
  void Halt(PeerId peer, bool halted);
  /// A step of its clock, or another rate.
  void SetClock(PeerId peer, PeerClock clock) { members_.at(peer).clock = clock; }
  PeerClock clock(PeerId peer) const { return members_.at(peer).clock; }
  /// A peer's clock now.
  std::int64_t LocalNow(PeerId peer) const;

  /// Since when `to` has counted `from` as here and nothing between them was cut, that way;
  /// nothing: it does not, or something is. True time.
  std::optional<std::int64_t> ClearSince(PeerId from, PeerId to) const;
  bool IsCut(PeerId from, PeerId to) const;
  /// The longest that control traffic between any two has lately been on its way, all its re-sends
  /// and what waited before it included, ns.
  std::int64_t LongestWay() const;

  /// Null: nobody watches.
  void SetWatch(WireWatch* watch) noexcept { watch_ = watch; }

 private:
  class Link;
  struct Alive {};
  struct Left {};
  using Control = std::variant<Alive, Left, PeerInfo, Event, SceneManifest>;
  struct Member {
    Role role = Role::kActive;
    Inbox* inbox = nullptr;
    PeerClock clock;
    std::uint64_t incarnation = 0;
    bool halted = false;
    std::optional<PeerInfo> info;  // newest, for those who come later
    std::optional<SceneManifest> scene;
    std::map<PeerId, std::deque<std::variant<ObjectState, CouplingLinks, ViewFrame>>> backlog;
  };
  struct Hearing {  // of one peer by another
    bool known = false;
    bool alive = false;
    std::int64_t heard_ns = 0;
    std::int64_t since_ns = 0;  // alive
  };
  struct OnItsWay {
    std::int64_t due_ns = 0;
    std::uint64_t to_incarnation = 0;
    Control what;
  };
  struct Line {  // from one peer to another
    LinkConditioner conditioner{LinkConditions{}};
    bool cut = false;
    std::int64_t cut_since_ns = 0;
    std::int64_t healed_ns = 0;
    std::int64_t longest_ns = 0;         // way of an item, of this window
    std::int64_t longest_before_ns = 0;  // and of the one before
    std::int64_t last_due_ns = 0;
    std::deque<OnItsWay> under_way;
    Hearing hearing;
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
  std::int64_t next_window_ns_ = 0;  // of the longest ways
  std::uint64_t incarnations_ = 0;
  std::map<PeerId, Member> members_;
  std::map<std::pair<PeerId, PeerId>, Line> lines_;
  WireWatch* watch_ = nullptr;
};

}  // namespace tandem
