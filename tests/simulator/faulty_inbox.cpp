#include "tests/simulator/faulty_inbox.h"

#include "tests/simulator/injected_faults.h"

namespace tandem {

void FaultyInbox::OnState(const ObjectState& state, std::int64_t arrival_ns) {
  if (Injected(Fault::kStatesDropped) && state.peer % 4 == 0) return;
  inbox_->OnState(state, arrival_ns);
}

void FaultyInbox::OnLinks(const CouplingLinks& links, std::int64_t arrival_ns) {
  if (Injected(Fault::kLinksDropped) && arrival_ns % 4'000'000'000 > 1'000'000'000) return;
  inbox_->OnLinks(links, arrival_ns);
}

void FaultyInbox::OnView(const ViewFrame& frame, std::int64_t arrival_ns) {
  inbox_->OnView(frame, arrival_ns);
}

void FaultyInbox::OnPeerInfo(const PeerInfo& info, std::int64_t arrival_ns) {
  inbox_->OnPeerInfo(info, arrival_ns);
}

void FaultyInbox::OnPeerLeft(PeerId peer) {
  if (Injected(Fault::kLostGoodbye)) return;
  inbox_->OnPeerLeft(peer);
}

void FaultyInbox::OnPeerLost(PeerId peer) {
  if (Injected(Fault::kLostLease)) return;
  inbox_->OnPeerLost(peer);
}

void FaultyInbox::OnEvent(const Event& event, std::int64_t arrival_ns) {
  inbox_->OnEvent(event, arrival_ns);
}

void FaultyInbox::OnScene(const SceneManifest& manifest) {
  inbox_->OnScene(manifest);
}

void FaultyInbox::OnSceneWithdrawn(PeerId peer) {
  inbox_->OnSceneWithdrawn(peer);
}

void FaultyInbox::OnTwin(const PeerInfo& info) {
  inbox_->OnTwin(info);
}

void FaultyInbox::OnDropped(PeerId from, Drop reason) {
  inbox_->OnDropped(from, reason);
}

}  // namespace tandem
