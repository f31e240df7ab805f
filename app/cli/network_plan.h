#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "collab/link_conditioner.h"
#include "collab/peer_directory.h"
#include "collab/peer_inbox.h"
#include "engine/base/result.h"

namespace tandem {

/// What the network is to do to what a peer hears, by sender and in time (docs/network-plans.md).
struct NetworkPlan {
  struct Step {
    double at_s = 0;  // from the plan's start
    LinkConditions conditions;
  };
  struct Link {
    std::string from;  // a peer's name; empty: everybody that no other link names
    std::vector<Step> steps;
  };
  bool from_hand = false;  // its time begins with the own hand; until then as at its begin
  std::uint64_t seed = 1;  // of what no step says; steps have it in their conditions
  std::vector<Link> links;
};

/// Errors name the file and the place in it.
Result<NetworkPlan> LoadNetworkPlan(const std::filesystem::path& file);

/// Samples of a kind that it holds back at once, at the most, of so many senders at 1 kHz.
std::size_t MostWaiting(const NetworkPlan& plan, std::size_t senders);

/// Carries a plan out. One thread, the control one.
class PlannedNetwork {
 public:
  /// `room`: samples of a kind that the inbox keeps.
  explicit PlannedNetwork(std::size_t room = PeerInbox::kDefaultWaiting) : room_(room) {}

  /// Instead of the one before, if any; its time begins at `now_ns`, or with the hand.
  void Start(NetworkPlan plan, std::int64_t now_ns);
  /// The own hand has begun; once.
  void HandBegins(std::int64_t now_ns);
  /// Whether a line of the user's is for the network: `network FILE`, `network off`.
  static bool IsOrder(const std::string& line);
  /// Starts that plan, or none; what was wrong, or nothing: then all goes on as it was. A plan that
  /// holds more back of so many senders than there is room for is wrong.
  std::optional<Error> Obey(const std::string& order, std::int64_t now_ns, std::size_t senders);
  /// Switches what is due; whom the plan names may come later or again. Gives a line for each
  /// switch.
  std::vector<std::string> Apply(std::int64_t now_ns, const PeerDirectory& directory,
                                 PeerInbox& inbox);

 private:
  struct Running {
    NetworkPlan::Link link;
    PeerId peer = 0;       // that the link was last switched for
    std::size_t done = 0;  // steps
    bool stale = false;    // a switch for everybody has undone it
  };

  std::size_t room_;
  std::vector<Running> links_;  // that for everybody first
  std::int64_t begin_ns_ = 0;
  bool hand_begun_ = false;
  bool waits_ = false;  // for the hand
};

}  // namespace tandem
