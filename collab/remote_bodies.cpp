#include "collab/remote_bodies.h"

#include <algorithm>

#include "collab/newer.h"

namespace tandem {

RemoteBodies::RemoteBodies(const WorldModel& model) {
  for (const std::uint32_t object : model.object) {
    bodies_.push_back({.object = object, .free = model.scene.bodies[object].free, .instances = {}});
  }
}

RemoteBodies::Instance* RemoteBodies::Find(Body& body, PeerId peer) noexcept {
  const auto it =
      std::find_if(body.instances.begin(), body.instances.end(), [peer](const Instance& i) {
        return i.peer == peer;
      });
  return it == body.instances.end() ? nullptr : &*it;
}

void RemoteBodies::OnMembership(const MembershipChange& change) noexcept {
  auto place = std::find(present_.begin(), present_.end(), change.peer);
  if (place == present_.end()) place = std::find(present_.begin(), present_.end(), PeerId{0});
  if (place != present_.end()) *place = change.present() ? change.peer : 0;
  for (Body& body : bodies_) {
    const bool holds = change.Holds(body.object);
    Instance* instance = Find(body, change.peer);
    if (instance == nullptr && holds) instance = Find(body, 0);
    if (instance == nullptr) continue;
    *instance = Instance{};
    if (holds) {
      instance->peer = change.peer;
      instance->holds = true;
    }
  }
}

void RemoteBodies::OnState(const ObjectState& state) noexcept {
  for (Body& body : bodies_) {
    if (body.object != state.object) continue;
    Instance* instance = Find(body, state.peer);
    if (instance == nullptr || !instance->holds) return;
    if (!instance->heard || IsNewer(state, instance->state)) {
      instance->state = state;
      instance->heard = true;
    }
    return;
  }
}

std::size_t RemoteBodies::heard() const noexcept {
  std::size_t count = 0;
  for (const Body& body : bodies_) {
    for (const Instance& instance : body.instances) count += instance.heard ? 1 : 0;
  }
  return count;
}

void RemoteBodies::Prepare(int held, StepInputs& inputs) const noexcept {
  const bool alone = std::all_of(present_.begin(), present_.end(), [](PeerId peer) {
    return peer == 0;
  });
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    StepInputs::BodyInput& input = inputs.bodies[b];
    if (static_cast<int>(b) == held) {
      input.drive = BodyDrive::kSimulated;
      continue;
    }
    // where several hold it, the one of the lowest number is followed
    const Instance* followed = nullptr;
    for (const Instance& instance : bodies_[b].instances) {
      if (instance.heard && (followed == nullptr || instance.peer < followed->peer)) {
        followed = &instance;
      }
    }
    const BodyDrive unheld = alone && bodies_[b].free ? BodyDrive::kSimulated : BodyDrive::kParked;
    input.drive = followed != nullptr ? BodyDrive::kMirrored : unheld;
    if (followed != nullptr) input.mirror_WB = followed->state.X_WB;
  }
}

}  // namespace tandem
