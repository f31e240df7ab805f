#include "collab/peer_directory.h"

#include <algorithm>
#include <cstdio>
#include <set>
#include <utility>

#include "collab/planted_faults.h"

namespace tandem {

namespace {

std::string WhyRefused(const PeerInfo& info, std::uint64_t scene_hash) {
  char text[160];
  if (info.protocol != kProtocol) {
    std::snprintf(text, sizeof text, "it speaks protocol %u and we %u: bring both to one version",
                  info.protocol, kProtocol);
    return text;
  }
  if (info.role == Role::kActive && info.scene_hash != scene_hash) {
    std::snprintf(text, sizeof text,
                  "its scene is %016llx and ours %016llx: open the same scene with the same files",
                  static_cast<unsigned long long>(info.scene_hash),
                  static_cast<unsigned long long>(scene_hash));
    return text;
  }
  return {};
}

}  // namespace

PeerDirectory::PeerDirectory(PeerId self, std::uint64_t scene_hash, std::string name)
    : self_(self), scene_hash_(scene_hash), name_(std::move(name)) {}

int PeerDirectory::NumberOfNamesake(const PeerInfo& info) const {
  // of those who are gone for good the name is free again
  std::set<int> taken;
  if (info.name == name_) taken.insert(1);
  for (const auto& [id, entry] : entries_) {
    const bool same = id != info.peer && entry.presence != Presence::kLeft;
    if (same && entry.told_name == info.name) taken.insert(entry.namesake);
  }
  int number = 1;
  while (taken.count(number) != 0) ++number;
  return number;
}

void PeerDirectory::OnPeerInfo(const PeerInfo& info) {
  if (info.peer == self_ || info.peer == 0) return;
  const std::lock_guard lock(mutex_);
  const auto [it, added] = entries_.try_emplace(info.peer);
  Entry& entry = it->second;
  const bool returned = !added && entry.presence != Presence::kHere;
  const bool claims_changed = entry.info.claims != info.claims;
  if (added || entry.told_name != info.name) {
    entry.namesake = NumberOfNamesake(info);
    entry.told_name = info.name;
  }
  entry.info = info;
  const bool clash = entry.namesake > 1;
  if (clash) entry.info.name += " (" + std::to_string(entry.namesake) + ")";
  entry.presence = Presence::kHere;
  entry.refused = WhyRefused(info, scene_hash_);
  const std::string role = info.role == Role::kViewer ? " (viewer)" : "";
  if (added && !entry.refused.empty()) {
    news_.push_back(entry.info.name + role + " is not taken in: " + entry.refused);
  } else if (added && clash) {
    news_.push_back("another " + info.name + role + " joined, shown as " + entry.info.name);
  } else if (added) {
    news_.push_back(entry.info.name + role + " joined");
  } else if (returned) {
    news_.push_back(entry.info.name + role + " is back");
  }
  using Kind = MembershipChange::Kind;
  if (Planted(Fault::kLostReturn) && returned) return;
  if (added || returned || claims_changed) {
    Tell(entry, added ? Kind::kJoined : returned ? Kind::kBack : Kind::kClaims);
  }
}

void PeerDirectory::OnGone(PeerId peer, Presence presence) {
  const std::lock_guard lock(mutex_);
  const auto it = entries_.find(peer);
  if (it == entries_.end() || it->second.presence == presence) return;
  const bool was_here = it->second.presence == Presence::kHere;
  it->second.presence = presence;
  news_.push_back(it->second.info.name + (presence == Presence::kLeft ? " left" : " is lost"));
  if (was_here) {
    Tell(it->second, presence == Presence::kLeft ? MembershipChange::Kind::kLeft
                                                 : MembershipChange::Kind::kLost);
  }
}

void PeerDirectory::Tell(const Entry& entry, MembershipChange::Kind kind) {
  if (entry.info.role != Role::kActive || !entry.refused.empty()) return;
  MembershipChange change;
  change.kind = kind;
  change.peer = entry.info.peer;
  change.claim_count =
      static_cast<std::uint32_t>(std::min(entry.info.claims.size(), change.claims.size()));
  std::copy_n(entry.info.claims.begin(), change.claim_count, change.claims.begin());
  if (Planted(Fault::kClaimsForgotten)) change.claim_count = 0;
  if (!changes_.TryPush(change)) {
    news_.push_back(entry.info.name + ": the membership queue is full; its change is not felt");
  }
}

std::vector<PeerDirectory::Entry> PeerDirectory::Entries() const {
  const std::lock_guard lock(mutex_);
  std::vector<Entry> entries;
  for (const auto& [id, entry] : entries_) entries.push_back(entry);
  return entries;
}

std::string PeerDirectory::NameOf(PeerId peer) const {
  const std::lock_guard lock(mutex_);
  const auto it = entries_.find(peer);
  return it == entries_.end() ? "somebody" : it->second.info.name;
}

PeerId PeerDirectory::PeerNamed(const std::string& name) const {
  const std::lock_guard lock(mutex_);
  for (const auto& [id, entry] : entries_) {
    const bool here = entry.presence == Presence::kHere && entry.info.role == Role::kActive;
    if (here && entry.info.name == name) return id;
  }
  return 0;
}

std::vector<std::string> PeerDirectory::TakeNews() {
  const std::lock_guard lock(mutex_);
  return std::exchange(news_, {});
}

}  // namespace tandem
