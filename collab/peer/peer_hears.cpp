#include <algorithm>
#include <utility>

#include "collab/peer/peer.h"

// Takes what other peers say, and the user's commands.

namespace tandem {

void Peer::TakeMessages(std::int64_t now_ns) noexcept {
  FrameTap* const tap = options_.tap;
  holdings_.Begin(now_ns);
  MembershipChange change;
  while (inbox_->membership().TryPop(change)) {
    if (tap != nullptr) tap->Heard(change);
    OnMembership(change);
  }
  holdings_.Settle();
  Event event;
  while (inbox_->events().TryPop(event)) {
    if (tap != nullptr) tap->Heard(event);
    OnEvent(event);
  }
  Command command;
  while (commands_.TryPop(command)) {
    if (tap != nullptr) tap->Asked(command);
    OnCommand(command);
  }
  if (std::exchange(stop_pressed_, false)) {
    // the hand lets go by an order, which is recorded like other orders
    command = {.kind = Command::Kind::kStop};
    if (tap != nullptr) tap->Asked(command);
    OnCommand(command);
  }
  inbox_->Collect();
  while (const ObjectState* state = inbox_->states().Due(now_ns)) {
    if (tap != nullptr) tap->Heard(*state);
    if (gate_.Admit(*state)) {
      OnState(*state);
      echoes_.OnState(*state);
    }
    inbox_->states().Drop();
  }
  while (const CouplingLinks* links = inbox_->links().Due(now_ns)) {
    if (tap != nullptr) tap->Heard(*links);
    if (gate_.Admit(*links)) {
      if (shared_) shared_->OnLinks(*links);
      echoes_.OnLinks(*links);
    }
    inbox_->links().Drop();
  }
}

void Peer::OnMembership(const MembershipChange& change) noexcept {
  if (change.kind == MembershipChange::Kind::kBeliefs) return holdings_.OnMembership(change);
  gate_.OnMembership(change);
  holdings_.OnMembership(change);
  remote_.OnMembership(change);
  echoes_.OnMembership(change);
  if (!shared_) return;
  if (change.Holds(world_->model().object[static_cast<std::size_t>(held_)])) {
    Couple(change.peer);
  } else {
    shared_->Part(change.peer);
  }
}

void Peer::OnState(const ObjectState& state) noexcept {
  if (!holdings_.Accepts(state)) return;
  holdings_.OnState(state);
  if ((state.flags & (kStateParked | kStateLoose)) != 0) return remote_.OnState(state);
  telemetry_.NoteLimits(state);
  if (shared_) shared_->OnState(state);
  remote_.OnState(state);
}

void Peer::OnEvent(const Event& event) noexcept {
  holdings_.OnEvent(event);
  if (event.kind != EventKind::kHeal || !shared_) return;
  const auto body = static_cast<std::size_t>(held_);
  const bool ours = event.object == world_->model().object[body];
  if (ours && holdings_.HeldBy(body, event.peer)) parting_.AskForAnother();
}

void Peer::OnCommand(const Command& command) noexcept {
  switch (command.kind) {
    case Command::Kind::kGrab:
      holdings_.Ask(command.object);
      return;
    case Command::Kind::kRelease:
      holdings_.Release();
      return;
    case Command::Kind::kGive:
      holdings_.Give(command.to);
      return;
    case Command::Kind::kHeal:
      if (!parting_.apart()) {
        news_.TryPush({HoldingNews::Kind::kNotApart, kNoObject, 0});
        return;
      }
      parting_.Ask();
      holdings_.Heal();
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
      holdings_.Stop();
      return;
    case Command::Kind::kResume:
      guard_.Resume();
      device_->Resume();
      holdings_.Resume();
      return;
    case Command::Kind::kScale:
      device_->Rescale(command.metres);
      device_can_ = device_->capabilities();
      return;
  }
}

}  // namespace tandem
