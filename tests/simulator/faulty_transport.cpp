#include "tests/simulator/faulty_transport.h"

#include <limits>
#include <utility>

#include "tests/simulator/injected_faults.h"

namespace tandem {

namespace {

bool IsParked(const ObjectState& state) {
  return (state.flags & kStateParked) != 0;
}

/// Returns the state that a peer with the fault sends in place of one.
ObjectState FaultyState(const ObjectState& state) {
  ObjectState sent = state;
  if (IsParked(state)) {
    if (Injected(Fault::kEpochOfBefore)) --sent.epoch;
    return sent;
  }
  if ((state.flags & kStateLoose) != 0) return sent;
  if (Injected(Fault::kTurnTooLong)) sent.X_WB.q.coeffs() *= 1.01;
  if (Injected(Fault::kStampOfBefore) && state.seq % 100 == 0) sent.sample_ns -= 50'000'000;
  return sent;
}

/// Returns the links that a peer with the fault sends in place of others. Those of a body that is
/// not shared are echoes alone, and stay as they are.
CouplingLinks FaultyLinks(const CouplingLinks& links) {
  CouplingLinks sent = links;
  if (links.object == kNoObject) return sent;
  const bool once_a_second = links.seq % 1000 == 999;
  for (std::size_t i = 0; i < links.count; ++i) {
    LinkEntry& entry = sent.entries[i];
    if (Injected(Fault::kNotFinite) && once_a_second) {
      entry.stiffness = std::numeric_limits<double>::quiet_NaN();
    }
    if (Injected(Fault::kNegativeStiffness) && once_a_second) entry.stiffness = -1.0;
    if (Injected(Fault::kOthersName)) sent.from = entry.to;
    if (Injected(Fault::kLinkToItself)) entry.to = links.from;
  }
  return sent;
}

}  // namespace

FaultyTransport::FaultyTransport(std::unique_ptr<FaultyInbox> inbox,
                                 std::unique_ptr<Transport> transport)
    : inbox_(std::move(inbox)), transport_(std::move(transport)) {}

void FaultyTransport::Publish(const ObjectState& state) {
  if (Injected(Fault::kNoParkedPose) && IsParked(state)) return;
  transport_->Publish(FaultyState(state));
}

void FaultyTransport::Publish(const ObjectState& state, const CouplingLinks& links) {
  transport_->Publish(FaultyState(state), FaultyLinks(links));
}

void FaultyTransport::Publish(const ViewFrame& frame) {
  transport_->Publish(frame);
}

void FaultyTransport::Publish(const PeerInfo& info) {
  PeerInfo sent = info;
  if (Injected(Fault::kBeatStands)) sent.beat = 1;
  transport_->Publish(sent);
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
  auto received = std::make_unique<FaultyInbox>(inbox);
  auto sent = network.Join(peer, Role::kActive, *received, clock);
  return std::make_unique<FaultyTransport>(std::move(received), std::move(sent));
}

}  // namespace tandem
