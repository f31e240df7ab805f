#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "collab/receive/link_conditioner.h"
#include "collab/receive/peer_inbox.h"
#include "collab/session/peer_directory.h"
#include "engine/base/result.h"

namespace tandem {

/// A plan of what the network does to the samples that a peer hears, by sender and in time
/// (docs/network-plans.md).
struct NetworkPlan {
  struct Step {
    double at_s = 0;  // time from the plan's start
    LinkConditions conditions;
  };
  struct Link {
    std::string from;  // a peer's name; empty: every peer that no other link names
    std::vector<Step> steps;
  };
  bool from_hand = false;  // the plan's time begins with our own hand; until then it stands at 0
  std::uint64_t seed = 1;  // seed where no step holds; steps have it in their conditions
  std::vector<Link> links;
};

/// Loads a plan. Errors name the file and the place in it.
Result<NetworkPlan> LoadNetworkPlan(const std::filesystem::path& file);

/// Returns the most samples of a kind that the plan holds back at once, of `senders` senders at 1
/// kHz.
std::size_t MostWaiting(const NetworkPlan& plan, std::size_t senders);

/// Carries a plan out. For one thread, the control thread.
class PlannedNetwork {
 public:
  /// `room`: number of samples of a kind that the inbox keeps.
  explicit PlannedNetwork(std::size_t room = PeerInbox::kDefaultWaiting) : room_(room) {}

  /// Starts a plan in place of the previous one, if any. Its time begins at `now_ns`, or with the
  /// hand.
  void Start(NetworkPlan plan, std::int64_t now_ns);
  /// Tells that our own hand has begun. Call it once.
  void HandBegins(std::int64_t now_ns);
  /// Returns whether a line of the user's is an order for the network: `network FILE`, `network
  /// off`.
  static bool IsOrder(const std::string& line);
  /// Starts the ordered plan, or none. An error changes nothing. A plan that holds back more
  /// samples of `senders` senders than there is room for is an error.
  std::optional<Error> Obey(const std::string& order, std::int64_t now_ns, std::size_t senders);
  /// Switches the links that are due. A peer that the plan names may come later, or again. Returns
  /// a line for each switch.
  std::vector<std::string> Apply(std::int64_t now_ns, const PeerDirectory& directory,
                                 PeerInbox& inbox);

 private:
  struct Running {
    NetworkPlan::Link link;
    PeerId peer = 0;       // peer that the link was last switched for
    std::size_t done = 0;  // number of steps done
    bool stale = false;    // a switch of the link for everybody has undone it
  };

  std::size_t room_;
  std::vector<Running> links_;  // link for everybody first
  std::int64_t begin_ns_ = 0;
  bool hand_begun_ = false;
  bool waits_ = false;  // time stands until the hand begins
};

}  // namespace tandem
