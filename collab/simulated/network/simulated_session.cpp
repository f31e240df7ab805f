#include "collab/simulated/network/simulated_session.h"

#include <utility>

namespace tandem {

namespace {
constexpr std::int64_t kFrameNs = 1'000'000;
constexpr std::int64_t kControlFrames = 20;  // between two ControlFrames
}  // namespace

std::size_t SimulatedSession::Add(std::unique_ptr<PeerNode> node, PeerId id,
                                  const PeerClock& clock) {
  network_.Advance(now_ns_);
  Member member;
  member.id = id;
  member.transport = network_.Join(id, Role::kActive, node->inbox(), clock);
  member.node = std::move(node);
  member.node->ControlFrame(network_.LocalNow(id), *member.transport);
  members_.push_back(std::move(member));
  return members_.size() - 1;
}

void SimulatedSession::Step() {
  network_.Advance(now_ns_);
  for (Member& member : members_) {
    if (!member.transport || member.halted) continue;
    member.node->HapticFrame(network_.LocalNow(member.id));
  }
  // a frame's states are on their way before the next frame begins
  for (Member& member : members_) {
    if (!member.transport || member.halted) continue;
    const std::int64_t local_ns = network_.LocalNow(member.id);
    member.node->SendFrame(local_ns, *member.transport);
    if (frame_ % kControlFrames == 0) member.node->ControlFrame(local_ns, *member.transport);
  }
  ++frame_;
  now_ns_ += kFrameNs;
}

void SimulatedSession::Leave(std::size_t peer) {
  Member& member = members_[peer];
  member.node->Leave(network_.LocalNow(member.id), *member.transport);
  members_[peer].transport.reset();
}

void SimulatedSession::Kill(std::size_t peer) {
  members_[peer].transport.reset();
}

void SimulatedSession::Switch(PeerId from, PeerId to, int member, const LinkConditions& link,
                              std::uint64_t seed) {
  if (member >= 0) node(static_cast<std::size_t>(member)).inbox().Switch(from, link);
  network_.link(from, to).Switch(
      {.delay_ms = link.delay_ms, .jitter_ms = link.jitter_ms, .loss = link.loss, .seed = seed});
}

void SimulatedSession::Halt(std::size_t peer, bool halted) {
  members_[peer].halted = halted;
  network_.Halt(members_[peer].id, halted);
}

}  // namespace tandem
