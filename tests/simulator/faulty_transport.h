#pragma once

#include <memory>
#include <string>

#include "collab/session/transport.h"
#include "collab/simulated/network/simulated_network.h"
#include "tests/simulator/faulty_inbox.h"

namespace tandem {

/// A transport with the injected fault of the session. It changes some of the messages that a peer
/// sends, and sends all others as they are.
class FaultyTransport : public Transport {
 public:
  /// `inbox` is the one that `transport` delivers to.
  FaultyTransport(std::unique_ptr<FaultyInbox> inbox, std::unique_ptr<Transport> transport);

  void Publish(const ObjectState& state) override;
  void Publish(const ObjectState& state, const CouplingLinks& links) override;
  void Publish(const ViewFrame& frame) override;
  void Publish(const PeerInfo& info) override;
  void Publish(const Event& event) override;
  void Publish(const SceneManifest& manifest) override;
  void Leave() override;
  void SayGoodbye() override;
  std::string KeysEnd() const override;

 private:
  std::unique_ptr<FaultyInbox> inbox_;  // outlives the transport
  std::unique_ptr<Transport> transport_;
};

/// Joins an active peer to the network, as SimulatedNetwork::Join() does, but with the injected
/// fault between the network and the peer, both ways.
std::unique_ptr<Transport> JoinWithFault(SimulatedNetwork& network, PeerId peer, Inbox& inbox,
                                         PeerClock clock);

}  // namespace tandem
