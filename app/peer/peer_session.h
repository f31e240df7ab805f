#pragma once

#include <atomic>
#include <cstdint>
#include <optional>
#include <string>

#include "app/judgement/verdict.h"
#include "app/peer/peer_control.h"
#include "app/peer/peer_loops.h"
#include "app/peer/peer_orders.h"
#include "app/peer/session_setup.h"
#include "app/peer/text/notification_limiter.h"
#include "app/peer/text/peer_table_text.h"
#include "app/peer/text/refusal_notifier.h"
#include "app/recording/network_plan.h"
#include "engine/base/thread_roles.h"

namespace tandem {

/// No exit code: the session's force parameters came too late, or a host asked for another scene,
/// so the peer joins anew.
inline constexpr int kJoinAgain = -1;

/// A peer's stay in a session, as its control thread leads it in 50 turns a second: news, orders,
/// the network's plan, and the reasons to end.
class PeerSession {
 public:
  /// `control`: null: the peer is no controller. `may_join_again`: other force parameters, offered
  /// at the same time, still count.
  PeerSession(PeerArguments& arguments, SessionSetup& setup, PeerLoops& loops, PeerControl* control,
              bool may_join_again, NetworkPlan plan);

  /// Stays until a signal, an order, a host, a fault or the end of the frames. Returns the exit
  /// code or kJoinAgain.
  int RunUntil(const std::atomic<bool>& stop_asked) TANDEM_RUNS_ON(kControlThread);

  /// Says the news that still waits.
  void SayRest();
  /// Returns the last table with a peer in it.
  const PeerTable& table() const noexcept { return table_; }
  const NameFunction& name() const noexcept { return name_; }
  HeldPoses& poses() noexcept { return poses_; }

 private:
  void PrintNotifications(std::int64_t now_ns) TANDEM_RUNS_ON(kControlThread);
  void WatchDevice();
  void TellEntered(std::int64_t now_ns);
  void TellRecorder();
  void ObeyLine(const std::string& line, std::int64_t now_ns);
  void ObeyOrder(const std::string& line);
  bool Give(const Command& command);
  /// Takes the orders and the hosts' wishes. Returns the exit code or kJoinAgain where they end the
  /// stay.
  std::optional<int> TakeOrders(std::int64_t now_ns);
  /// Says why the peer cannot stay, and returns the exit code or kJoinAgain; nothing: it can.
  std::optional<int> WhyEnd(std::int64_t now_ns);
  /// Ends the wait for others where it takes too long.
  std::optional<int> WhyNotBegun(std::int64_t now_ns);
  void TellWaiting(std::int64_t now_ns);
  bool IsDone(std::int64_t now_ns);

  PeerArguments& arguments_;
  SessionSetup& setup_;
  PeerNode& node_;
  PeerLoops& loops_;
  PeerControl* control_;
  const bool may_join_again_;
  const std::int64_t opened_ns_;
  std::int64_t done_ns_ = 0;
  OrderReader orders_;
  NotificationLimiter notifications_;  // news about other programs
  RefusalNotifier refusals_;
  PlannedNetwork network_;
  const NameFunction name_;
  PeerTable table_;
  HeldPoses poses_;
  bool waiting_told_ = false;  // user knows that the hand waits for others
  bool hand_told_ = false;     // hand has begun
  bool stop_seen_ = false;     // stop at the device
  bool quit_ = false;
  const PeerNode::OnHand on_hand_;
};

}  // namespace tandem
