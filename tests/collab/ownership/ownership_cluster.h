#pragma once

#include <algorithm>
#include <map>
#include <memory>
#include <set>
#include <utility>
#include <vector>

#include "collab/ownership/ownership.h"

namespace tandem::testing {

inline constexpr ObjectId kOwn = 1;     // type-1
inline constexpr ObjectId kShared = 2;  // type-2

inline WorldModel TwoBodies() {
  WorldModel model;
  model.scene.bodies.resize(3);
  model.scene.bodies[kShared].shared = true;
  model.object = {kOwn, kShared};
  model.bodies.resize(2);
  return model;
}

/// Peers that hear one another's events and claims `delay` frames later, except over links that are
/// cut. Frames are 1 ms long.
class OwnershipCluster {
 public:
  using Kind = MembershipChange::Kind;

  explicit OwnershipCluster(const std::vector<PeerId>& ids, int delay = 0,
                            WorldModel model = TwoBodies())
      : model_(std::move(model)), delay_(delay) {
    for (const PeerId id : ids) Add(id);
  }

  void Add(PeerId id, bool own_only = false) {
    peers_.emplace(id, Node{std::make_unique<Ownership>(id, model_, 0, own_only), {}, true, false});
    for (auto& [other, node] : peers_) {
      if (other == id || !node.here) continue;
      Hear(other, Kind::kJoined, id);
      Hear(id, Kind::kJoined, other);
    }
  }
  Ownership& operator[](PeerId id) { return *peers_.at(id).ownership; }

  void Run(int frames) {
    for (int i = 0; i < frames; ++i) Frame();
  }
  /// Stops a peer as by SIGSTOP: it has no frames and sends nothing, and what comes in waits.
  void Stop(PeerId id, bool stopped) { peers_.at(id).stopped = stopped; }
  /// Cuts a peer off from all others, who lose it as it loses them.
  void Sever(PeerId id) {
    ForOthers(id, [this](PeerId from, PeerId at) {
      peers_.at(at).ownership->OnMembership({.kind = Kind::kLost, .peer = from});
      cut_.insert({from, at});
    });
  }
  void Rejoin(PeerId id) {
    ForOthers(id, [this](PeerId from, PeerId at) {
      cut_.erase({from, at});
      Hear(at, Kind::kBack, from);
    });
  }
  void Kill(PeerId id) {
    peers_.at(id).here = false;
    for (auto& [other, node] : peers_) {
      if (node.here) node.ownership->OnMembership({.kind = Kind::kLost, .peer = id});
    }
  }
  void Leave(PeerId id) {
    peers_.at(id).ownership->Leave();
    Frame();
    peers_.at(id).here = false;
    Run(delay_ + 1);
    for (auto& [other, node] : peers_) {
      if (node.here) node.ownership->OnMembership({.kind = Kind::kLeft, .peer = id});
    }
  }

  /// Returns the one peer that all who are here take for the authority; 0: they differ.
  PeerId Authority(std::size_t body) {
    std::set<PeerId> named;
    for (auto& [id, node] : peers_) {
      if (node.here) named.insert(node.ownership->authority(body));
    }
    return named.size() == 1 ? *named.begin() : 0;
  }
  std::vector<PeerId> Holders(std::size_t body) {
    std::vector<PeerId> holders;
    for (auto& [id, node] : peers_) {
      if (node.here && node.ownership->held() == static_cast<int>(body)) holders.push_back(id);
    }
    return holders;
  }
  /// Counts how often a frame had an own body in two hands at once, or parked by two peers.
  int doubles() const { return doubles_; }

 private:
  /// Calls `link(from, at)` both ways between a peer and each other.
  template <typename Link>
  void ForOthers(PeerId id, const Link& link) {
    for (const auto& [other, node] : peers_) {
      if (other == id) continue;
      link(id, other);
      link(other, id);
    }
  }
  struct AnnouncedClaims {
    std::vector<Claim> claims;
    std::vector<Belief> beliefs;
    bool operator==(const AnnouncedClaims&) const = default;
  };
  struct Node {
    std::unique_ptr<Ownership> ownership;
    AnnouncedClaims reported;
    bool here = true;
    bool stopped = false;
  };
  struct Flying {
    std::int64_t due_ms;
    PeerId from, to;
    bool is_event;
    Event event;
    AnnouncedClaims reported;
  };

  static MembershipChange Change(Kind kind, PeerId peer, const AnnouncedClaims& reported) {
    MembershipChange change{.kind = kind, .peer = peer};
    change.claim_count = static_cast<std::uint32_t>(reported.claims.size());
    std::ranges::copy(reported.claims, change.claims.begin());
    change.belief_count = static_cast<std::uint32_t>(reported.beliefs.size());
    std::ranges::copy(reported.beliefs, change.beliefs.begin());
    return change;
  }
  void Hear(PeerId at, Kind kind, PeerId of) {
    peers_.at(at).ownership->OnMembership(Change(kind, of, peers_.at(of).reported));
  }

  void Frame() {
    ++now_ms_;
    while (!flying_.empty() && flying_.front().due_ms <= now_ms_) {
      const Flying f = flying_.front();
      flying_.erase(flying_.begin());
      Node& node = peers_.at(f.to);
      if (!node.here || cut_.count({f.from, f.to}) != 0) continue;
      if (f.is_event) {
        node.ownership->OnEvent(f.event);
      } else {
        node.ownership->OnMembership(Change(Kind::kClaims, f.from, f.reported));
      }
    }
    for (auto& [id, node] : peers_) {
      if (!node.here || node.stopped) continue;
      std::array<Event, 8> events;
      std::size_t count = 0;
      node.ownership->Tick(now_ms_ * 1'000'000, events, count);
      std::array<Claim, kMaxClaims> claims{};
      std::array<Belief, kMaxClaims> beliefs{};
      const std::uint32_t claim_count = node.ownership->Claims(claims);
      const std::uint32_t belief_count = node.ownership->Beliefs(beliefs);
      const AnnouncedClaims reported{{claims.begin(), claims.begin() + claim_count},
                                     {beliefs.begin(), beliefs.begin() + belief_count}};
      for (auto& [other, unused] : peers_) {
        if (other == id) continue;
        for (std::size_t i = 0; i < count; ++i) {
          flying_.push_back({now_ms_ + delay_, id, other, true, events[i], {}});
        }
        if (!(reported == node.reported)) {
          flying_.push_back({now_ms_ + delay_, id, other, false, {}, reported});
        }
      }
      node.reported = reported;
    }
    int say = 0;
    for (auto& [id, node] : peers_) {
      const bool says = node.ownership->held() == 0 || node.ownership->Parks(0);
      if (node.here && !node.stopped && says && !node.ownership->listening()) ++say;
    }
    doubles_ += say > 1 ? 1 : 0;
  }

  const WorldModel model_;
  int delay_;
  std::int64_t now_ms_ = 0;
  std::map<PeerId, Node> peers_;
  std::vector<Flying> flying_;
  std::set<std::pair<PeerId, PeerId>> cut_;
  int doubles_ = 0;
};

}  // namespace tandem::testing
