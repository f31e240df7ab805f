#include "tests/simulator/faulty_transport.h"

#include <utility>

#include "tests/simulator/injected_faults.h"

namespace tandem {

FaultyTransport::FaultyTransport(std::unique_ptr<FaultyInbox> inbox,
                                 std::unique_ptr<Transport> transport)
    : inbox_(std::move(inbox)), transport_(std::move(transport)) {}

void FaultyTransport::Publish(const ObjectState& state) {
  transport_->Publish(state);
}

void FaultyTransport::Publish(const ObjectState& state, const CouplingLinks& links) {
  transport_->Publish(state, links);
}

void FaultyTransport::Publish(const ViewFrame& frame) {
  transport_->Publish(frame);
}

void FaultyTransport::Publish(const PeerInfo& info) {
  transport_->Publish(info);
}

void FaultyTransport::Publish(const Event& event) {
  Event sent = event;
  if (Injected(Fault::kEventNumberStands)) sent.seq = 1;
  transport_->Publish(sent);
}

void FaultyTransport::Publish(const SceneManifest& manifest) {
  transport_->Publish(manifest);
}

void FaultyTransport::Leave() {
  transport_->Leave();
}

void FaultyTransport::SayGoodbye() {
  transport_->SayGoodbye();
}

std::string FaultyTransport::KeysEnd() const {
  return transport_->KeysEnd();
}

std::unique_ptr<Transport> JoinWithFault(SimulatedNetwork& network, PeerId peer, Inbox& inbox,
                                         PeerClock clock) {
  auto heard = std::make_unique<FaultyInbox>(inbox);
  auto sent = network.Join(peer, Role::kActive, *heard, clock);
  return std::make_unique<FaultyTransport>(std::move(heard), std::move(sent));
}

}  // namespace tandem
