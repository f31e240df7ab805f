#include <algorithm>
#include <utility>

#include "collab/peer/peer.h"

// Takes what other peers say, and the user's commands.

namespace tandem {

void Peer::TakeMessages(std::int64_t now_ns) noexcept {
  FrameObserver* const observer = options_.observer;
  ownership_.Begin(now_ns);
  MembershipChange change;
  while (inbox_->membership().TryPop(change)) {
    if (observer != nullptr) observer->OnReceived(change);
    OnMembership(change);
  }
  ownership_.Settle();
  Event event;
  while (inbox_->events().TryPop(event)) {
    if (observer != nullptr) observer->OnReceived(event);
    OnEvent(event);
  }
  Command command;
  while (commands_.TryPop(command)) {
    if (observer != nullptr) observer->OnCommand(command);
    OnCommand(command);
  }
  if (std::exchange(stop_pressed_, false)) {
    // the hand lets go by an order, which is recorded like other orders
    command = {.kind = Command::Kind::kStop};
    if (observer != nullptr) observer->OnCommand(command);
    OnCommand(command);
  }
  inbox_->Collect();
  while (const ObjectState* state = inbox_->states().Due(now_ns)) {
    if (observer != nullptr) observer->OnReceived(*state);
    if (validator_.Accept(*state)) {
      OnState(*state);
      round_trips_.OnState(*state);
    }
    inbox_->states().Drop();
  }
  while (const CouplingLinks* links = inbox_->links().Due(now_ns)) {
    if (observer != nullptr) observer->OnReceived(*links);
    if (validator_.Accept(*links)) {
      if (shared_) shared_->OnLinks(*links);
      round_trips_.OnLinks(*links);
    }
    inbox_->links().Drop();
  }
}

void Peer::OnMembership(const MembershipChange& change) noexcept {
  if (change.kind == MembershipChange::Kind::kBeliefs) return ownership_.OnMembership(change);
  validator_.OnMembership(change);
  ownership_.OnMembership(change);
  remote_.OnMembership(change);
  round_trips_.OnMembership(change);
  if (!shared_) return;
  if (change.Holds(world_->model().object[static_cast<std::size_t>(held_)])) {
    Couple(change.peer);
  } else {
    shared_->Part(change.peer);
  }
}

void Peer::OnState(const ObjectState& state) noexcept {
  if (!ownership_.Accepts(state)) return;
  ownership_.OnState(state);
  if ((state.flags & (kStateParked | kStateLoose)) != 0) return remote_.OnState(state);
  telemetry_.NoteLimits(state);
  if (shared_) shared_->OnState(state);
  remote_.OnState(state);
}

void Peer::OnEvent(const Event& event) noexcept {
  ownership_.OnEvent(event);
  if (event.kind != EventKind::kHeal || !shared_) return;
  const auto body = static_cast<std::size_t>(held_);
  const bool ours = event.object == world_->model().object[body];
  if (ours && ownership_.HeldBy(body, event.peer)) separation_.RequestReunionForPeer();
}

void Peer::OnCommand(const Command& command) noexcept {
  switch (command.kind) {
    case Command::Kind::kGrab:
      ownership_.Ask(command.object);
      return;
    case Command::Kind::kRelease:
      ownership_.Release();
      return;
    case Command::Kind::kGive:
      ownership_.Give(command.to);
      return;
    case Command::Kind::kHeal:
      if (!separation_.apart()) {
        notifications_.TryPush({Notification::Kind::kNotApart, kNoObject, 0});
        return;
      }
      separation_.RequestReunion();
      ownership_.RequestReunion();
      return;
    case Command::Kind::kLayer:
      inputs_.clearance.force_layer = command.layer;
      return;
    case Command::Kind::kDisplace:
      inputs_.clearance.displacement = command.metres;
      return;
    case Command::Kind::kStop:
      guard_.Stop();
      device_->Stop();
      ownership_.Stop();
      return;
    case Command::Kind::kResume:
      guard_.Resume();
      device_->Resume();
      ownership_.Resume();
      return;
    case Command::Kind::kScale:
      device_->Rescale(command.metres);
      device_can_ = device_->capabilities();
      return;
  }
}

}  // namespace tandem
