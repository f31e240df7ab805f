#pragma once

#include <memory>
#include <vector>

#include "collab/peer/peer_node.h"
#include "collab/simulated/network/simulated_network.h"

namespace tandem {

/// Complete peers on the simulated network, frame by frame in virtual time, in one thread. They run
/// the product's code without its threads and sockets. Every peer goes by its own clock. The same
/// inputs give the same bits.
class SimulatedSession {
 public:
  explicit SimulatedSession(std::uint64_t seed = 1) : network_(seed) {}

  /// Adds a peer, present from the next frame on. Returns its number.
  std::size_t Add(std::unique_ptr<PeerNode> node, PeerId id, const PeerClock& clock = {});

  std::size_t size() const noexcept { return members_.size(); }
  PeerNode& node(std::size_t peer) { return *members_[peer].node; }
  PeerId id(std::size_t peer) const { return members_[peer].id; }
  /// Returns whether the peer has neither left nor been killed.
  bool present(std::size_t peer) const { return members_[peer].transport != nullptr; }
  bool halted(std::size_t peer) const { return members_[peer].halted; }
  SimulatedNetwork& network() noexcept { return network_; }
  const SimulatedNetwork& network() const noexcept { return network_; }
  /// Returns the true time; no peer sees it.
  std::int64_t now_ns() const noexcept { return now_ns_; }

  /// Runs one millisecond for all peers.
  void Step();
  /// Makes a peer say goodbye and leave.
  void Leave(std::size_t peer);
  /// Makes a peer vanish as by kill -9. The others notice when its lease is over.
  void Kill(std::size_t peer);
  /// Sets the conditions of the link from `from` to `to`, drawn from `seed`. `member` is the number
  /// of `to`, or -1 before it has come.
  void Switch(PeerId from, PeerId to, int member, const LinkConditions& link, std::uint64_t seed);
  /// Stops a peer as by SIGSTOP, or lets it go on. Then its own clock has jumped.
  void Halt(std::size_t peer, bool halted);

 private:
  struct Member {
    std::unique_ptr<PeerNode> node;
    std::unique_ptr<Transport> transport;  // null: not present
    PeerId id = 0;
    bool halted = false;
  };

  SimulatedNetwork network_;
  std::vector<Member> members_;
  std::int64_t frame_ = 0;
  std::int64_t now_ns_ = 1'000'000'000;  // not 0, which means "never"
};

}  // namespace tandem
