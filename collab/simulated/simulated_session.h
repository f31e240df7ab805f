#pragma once

#include <memory>
#include <vector>

#include "collab/peer_node.h"
#include "collab/simulated/simulated_network.h"

namespace tandem {

/// Whole peers on the simulated network, frame by frame in virtual time, in one thread: the
/// product's code, with nothing left out but threads and sockets. The same inputs give the same
/// bits.
class SimulatedSession {
 public:
  /// Adds a peer, present from the next frame on; gives its number.
  std::size_t Add(std::unique_ptr<PeerNode> node, PeerId id);

  PeerNode& node(std::size_t peer) { return *members_[peer].node; }
  SimulatedNetwork& network() noexcept { return network_; }
  std::int64_t now_ns() const noexcept { return now_ns_; }

  /// One millisecond for everybody.
  void Step();
  /// Says goodbye, or vanishes as by kill -9 (which the others notice at once here).
  void Leave(std::size_t peer);
  void Kill(std::size_t peer);

 private:
  struct Member {
    std::unique_ptr<PeerNode> node;
    std::unique_ptr<Transport> transport;  // null: not there
  };

  SimulatedNetwork network_;
  std::vector<Member> members_;
  std::int64_t frame_ = 0;
  std::int64_t now_ns_ = 1'000'000'000;  // not 0, which stands for "never"
};

}  // namespace tandem
