#include "collab/receive/sample_validator.h"

#include <algorithm>
#include <utility>

#include "collab/receive/newer.h"

namespace tandem {

namespace {
constexpr std::uint32_t kMostOn = 8192;  // greatest step in number to a state that counts on
}  // namespace

SampleValidator::SampleValidator(PeerId self, const std::vector<std::uint32_t>& objects,
                                 DropTable& drops, std::vector<bool> shared)
    : self_(self), objects_(objects), shared_(std::move(shared)), drops_(&drops) {
  shared_.resize(objects.size());
  instances_.resize(senders_.capacity() * (objects.size() + 1));
}

std::span<SampleValidator::Instance> SampleValidator::InstancesOf(const PeerKey& sender) noexcept {
  const std::size_t each = objects_.size() + 1;
  return std::span(instances_).subspan(senders_.SlotOf(sender) * each, each);
}

SampleValidator::Instance* SampleValidator::InstanceOf(const PeerKey& sender,
                                                       ObjectId object) noexcept {
  const std::span<Instance> instances = InstancesOf(sender);
  if (object == kNoObject) return &instances.back();
  const auto it = std::find(objects_.begin(), objects_.end(), object);
  if (it == objects_.end()) return nullptr;
  return &instances[static_cast<std::size_t>(it - objects_.begin())];
}

bool SampleValidator::Drops(PeerId peer, Drop reason) noexcept {
  drops_->Count(peer, reason);
  return false;
}

void SampleValidator::OnMembership(const MembershipChange& change) noexcept {
  const PeerKey* const sender =
      change.present() ? senders_.FindOrInsert(change.peer) : senders_.Find(change.peer);
  if (sender == nullptr) return;
  const std::span<Instance> instances = InstancesOf(*sender);
  // a peer that comes anew, or again, numbers anew
  if (change.kind != MembershipChange::Kind::kClaims) {
    std::ranges::fill(instances, Instance{});
  }
  if (!change.present()) return senders_.Erase(change.peer);
  for (std::size_t i = 0; i < objects_.size(); ++i) {
    Instance& instance = instances[i];
    const Claim* claim = nullptr;
    for (std::uint32_t c = 0; c < change.claim_count; ++c) {
      if (change.claims[c].object == objects_[i]) claim = &change.claims[c];
    }
    // also where its states were ahead, and its claim follows them
    const bool goes_on = claim != nullptr && instance.claimed && claim->epoch >= instance.epoch &&
                         claim->epoch <= std::max(instance.epoch, instance.ahead);
    instance.received = instance.received && goes_on;
    instance.claimed = claim != nullptr;
    instance.coupled = claim != nullptr && claim->held && shared_[i];
    instance.epoch = claim != nullptr ? claim->epoch : 0;
    if (!goes_on || instance.ahead <= instance.epoch || !instance.coupled) instance.ahead = 0;
  }
}

// Returns whether the state follows the last one by number. A forged state far ahead mutes no peer.
bool SampleValidator::CountsOn(const Instance& instance, const ObjectState& state) noexcept {
  const bool moves = (state.flags & (kStateParked | kStateLoose)) == 0;
  const std::uint32_t newest = std::max(instance.epoch, instance.ahead);
  return instance.coupled && instance.received && moves && state.epoch >= newest &&
         IsAfter(state.seq, instance.seq) && state.seq - instance.seq <= kMostOn;
}

bool SampleValidator::Accept(const ObjectState& state) noexcept {
  const PeerKey* const sender = senders_.Find(state.peer);
  if (sender == nullptr || state.object == kNoObject) return true;
  Instance* instance = InstanceOf(*sender, state.object);
  if (instance == nullptr || !instance->claimed) return Drops(state.peer, Drop::kWrongOwner);
  const bool ahead = state.epoch != instance->epoch && CountsOn(*instance, state);
  if (state.epoch != instance->epoch && !ahead) return Drops(state.peer, Drop::kWrongEpoch);
  if (instance->received && !IsAfter(state.seq, instance->seq)) {
    return Drops(state.peer, Drop::kReplayed);
  }
  instance->received = true;
  instance->seq = state.seq;
  if (ahead) instance->ahead = state.epoch;
  return true;
}

bool SampleValidator::Accept(const CouplingLinks& links) noexcept {
  const PeerKey* const sender = senders_.Find(links.from);
  if (sender == nullptr) return true;
  Instance* instance = InstanceOf(*sender, links.object);
  if (instance == nullptr) return Drops(links.from, Drop::kWrongOwner);
  if (instance->linked && !IsAfter(links.seq, instance->links_seq)) {
    return Drops(links.from, Drop::kReplayed);
  }
  for (std::size_t i = 0; i < std::min<std::size_t>(links.count, kMaxLinks); ++i) {
    const LinkEntry& entry = links.entries[i];
    // 0: the peer has not heard us yet
    if (entry.to == self_ && entry.echo_ns != 0 && !sent_.Has(entry.echo_ns)) {
      return Drops(links.from, Drop::kBadEcho);
    }
  }
  instance->linked = true;
  instance->links_seq = links.seq;
  return true;
}

}  // namespace tandem
