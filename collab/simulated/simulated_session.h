#pragma once

#include <memory>
#include <vector>

#include "collab/peer_node.h"
#include "collab/simulated/simulated_network.h"

namespace tandem {

/// Whole peers on the simulated network, frame by frame in virtual time, in one thread: the
/// product's code, with nothing left out but threads and sockets. Every peer goes by its own clock.
/// The same inputs give the same bits.
class SimulatedSession {
 public:
  explicit SimulatedSession(std::uint64_t seed = 1) : network_(seed) {}

  /// Adds a peer, present from the next frame on; gives its number.
  std::size_t Add(std::unique_ptr<PeerNode> node, PeerId id, const PeerClock& clock = {});

  std::size_t size() const noexcept { return members_.size(); }
  PeerNode& node(std::size_t peer) { return *members_[peer].node; }
  PeerId id(std::size_t peer) const { return members_[peer].id; }
  /// Neither left nor killed.
  bool present(std::size_t peer) const { return members_[peer].transport != nullptr; }
  bool halted(std::size_t peer) const { return members_[peer].halted; }
  SimulatedNetwork& network() noexcept { return network_; }
  const SimulatedNetwork& network() const noexcept { return network_; }
  /// True time; no peer sees it.
  std::int64_t now_ns() const noexcept { return now_ns_; }

  /// One millisecond for everybody.
  void Step();
  /// Says goodbye.
  void Leave(std::size_t peer);
  /// Vanishes as by kill -9: the others notice when its lease is over.
  void Kill(std::size_t peer);
  /// What `from` sends to `to` comes by `link` from now on, by dice of `seed`. `member` is the
  /// number of `to`, or -1 before it has come.
  void Switch(PeerId from, PeerId to, int member, const LinkConditions& link, std::uint64_t seed);
  /// Stands still as by SIGSTOP, or goes on: then its own clock has jumped.
  void Halt(std::size_t peer, bool halted);

 private:
  struct Member {
    std::unique_ptr<PeerNode> node;
    std::unique_ptr<Transport> transport;  // null: not there
    PeerId id = 0;
    bool halted = false;
  };

  SimulatedNetwork network_;
  std::vector<Member> members_;
  std::int64_t frame_ = 0;
  std::int64_t now_ns_ = 1'000'000'000;  // not 0, which stands for "never"
};

}  // namespace tandem
