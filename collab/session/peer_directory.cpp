#include "collab/session/peer_directory.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <utility>

#include "engine/base/text/hex.h"

namespace tandem {

PeerDirectory::PeerDirectory(PeerId self, std::uint64_t scene_hash, std::string name,
                             OwnTerms terms)
    : self_(self),
      scene_hash_(scene_hash),
      name_(std::move(name)),
      terms_(std::move(terms)),
      parameters_hash_(HashOf(terms_.parameters)) {}

std::string PeerDirectory::WhyRefused(const PeerInfo& info) const {
  std::array<char, 160> text{};
  if (info.protocol != kProtocol) {
    std::snprintf(text.data(), text.size(),
                  "it uses protocol %u and this program %u: update both to one version",
                  info.protocol, kProtocol);
  } else if (info.role == Role::kActive &&
             (info.scene_hash != scene_hash_ || info.scene_digest != terms_.scene_digest)) {
    // forged scenes differ by their digests alone, of which a person needs the beginning
    const bool forged = info.scene_hash == scene_hash_;
    const auto shown = [forged](std::uint64_t hash, const Sha256& digest) {
      return forged ? HexOfBytes(digest).substr(0, 16) : Hex(hash);
    };
    std::snprintf(text.data(), text.size(),
                  "its scene is %s and ours %s: open the same scene with the same files",
                  shown(info.scene_hash, info.scene_digest).c_str(),
                  shown(scene_hash_, terms_.scene_digest).c_str());
  }
  return text.data();
}

bool PeerDirectory::IsFullFor(const PeerInfo& info) const {
  if (info.role != Role::kActive) return false;
  std::size_t others = 0;
  for (const auto& [id, entry] : entries_) {
    const bool taken_in = entry.presence == Presence::kHere && entry.refused.empty();
    if (id != info.peer && taken_in && entry.info.role == Role::kActive) ++others;
  }
  return others >= kMaxPeers - 1;
}

std::size_t PeerDirectory::CameBefore(std::uint32_t beat) const {
  const std::lock_guard lock(mutex_);
  std::size_t count = 0;
  for (const auto& [id, entry] : entries_) {
    const bool counts = entry.presence == Presence::kHere && entry.info.role == Role::kActive &&
                        WhyRefused(entry.info).empty();
    if (counts && tandem::CameBefore(entry.info, self_, beat)) ++count;
  }
  return count;
}

int PeerDirectory::NumberOfNamesake(const PeerInfo& info) const {
  // the name of a peer that is gone is free again, and who looks on may take part, too
  std::set<int> taken;
  if (info.name == name_ && info.role == Role::kActive) taken.insert(1);
  for (const auto& [id, entry] : entries_) {
    const bool same = id != info.peer && entry.presence == Presence::kHere;
    if (same && entry.told_name == info.name && entry.info.role == info.role) {
      taken.insert(entry.namesake);
    }
  }
  int number = 1;
  while (taken.count(number) != 0) ++number;
  return number;
}

void PeerDirectory::Replace(const PeerInfo& by) {
  std::erase_if(entries_, [&by](const auto& one) {
    const Entry& entry = one.second;
    return one.first != by.peer && entry.told_name == by.name &&
           entry.presence != Presence::kHere && !entry.owed_end;
  });
}

void PeerDirectory::RenameAfter(const Entry& lost) {
  for (auto& [id, entry] : entries_) {
    // it said nothing since the other came: the same person, whose first program has crashed
    const bool after = entry.presence == Presence::kHere && entry.told_name == lost.told_name &&
                       entry.info.role == lost.info.role && entry.first_heard > lost.last_heard;
    if (!after) continue;
    PeerInfo plain = entry.info;
    plain.name = entry.told_name;
    const int number = NumberOfNamesake(plain);
    if (number >= entry.namesake) return;
    entry.namesake = number;
    const std::string before = std::exchange(entry.info.name, NumberedName(entry));
    Say(before + " is shown as " + entry.info.name + " from now on");
    return;
  }
}

std::string PeerDirectory::NumberedName(const Entry& entry) {
  if (entry.namesake <= 1) return entry.told_name;
  return entry.told_name + " (" + std::to_string(entry.namesake) + ")";
}

PersonColour PeerDirectory::ColourFor(std::uint32_t beat, PersonColour now) const {
  const std::lock_guard lock(mutex_);
  std::vector<ColouredPerson> others;
  for (const auto& [id, entry] : entries_) {
    if (entry.presence != Presence::kHere) continue;
    others.push_back({.name = entry.told_name,
                      .role = entry.info.role,
                      .colour = entry.info.colour,
                      .before = tandem::CameBefore(entry.info, self_, beat)});
  }
  return ChooseColour(name_, Role::kActive, now, others);
}

PeerDirectory::Entry* PeerDirectory::PlaceFor(PeerId peer, bool& added) {
  added = false;
  if (const auto known = entries_.find(peer); known != entries_.end()) return &known->second;
  if (entries_.size() >= kMost) {
    auto longest = entries_.end();
    for (auto it = entries_.begin(); it != entries_.end(); ++it) {
      if (it->second.presence == Presence::kHere || it->second.owed_end) continue;
      if (longest == entries_.end() || it->second.gone < longest->second.gone) longest = it;
    }
    if (longest == entries_.end()) {
      if (!std::exchange(crowd_told_, true)) {
        Say("more than " + std::to_string(kMost) +
            " participants are here: this program ignores further ones");
      }
      return nullptr;
    }
    entries_.erase(longest);
  }
  added = true;
  return &entries_[peer];
}

void PeerDirectory::OnPeerInfo(const PeerInfo& info) {
  if (info.peer == self_ || info.peer == 0) return;
  const std::lock_guard lock(mutex_);
  bool added = false;
  Entry* const place = PlaceFor(info.peer, added);
  if (place == nullptr) return;
  Entry& entry = *place;
  const bool returned = !added && entry.presence != Presence::kHere;
  const bool is_other_run = !added && entry.info.incarnation != info.incarnation;
  const bool is_new_run = is_other_run && !returned;
  const bool was_refused = !added && !entry.refused.empty();
  const bool claims_changed = entry.info.claims != info.claims;
  const bool beliefs_changed = entry.info.beliefs != info.beliefs;
  const bool was_stopped = !added && entry.info.stopped;
  if (added || entry.told_name != info.name) {
    Replace(info);
    entry.namesake = NumberOfNamesake(info);
    entry.told_name = info.name;
    entry.first_heard = heard_ + 1;
  }
  entry.last_heard = ++heard_;
  entry.info = info;
  const bool clash = entry.namesake > 1;
  entry.info.name = NumberedName(entry);
  entry.presence = Presence::kHere;
  offers_.OnPresence(info.peer, true);
  entry.refused = WhyRefused(info);
  const bool newly = added || returned || was_refused || !entry.felt;
  if (newly && entry.refused.empty() && IsFullFor(info)) {
    entry.refused = std::to_string(kMaxPeers) + " active peers are here, the maximum";
  }
  const bool taken_in = was_refused && entry.refused.empty();
  const bool unequal =
      info.role == Role::kActive && entry.refused.empty() && info.params_hash != parameters_hash_;
  if (unequal != entry.unequal) entry.unequal_told = false;
  entry.unequal = unequal;
  const std::string role = info.role == Role::kViewer ? " (viewer)" : "";
  if (added && !entry.refused.empty()) {
    Say(entry.info.name + role + " is not accepted: " + entry.refused);
  } else if (added && clash) {
    Say("another " + info.name + role + " joined, shown as " + entry.info.name);
  } else if (added) {
    Say(entry.info.name + role + " joined");
  } else if (taken_in) {
    Say(entry.info.name + role + " is accepted now");
  } else if (returned) {
    Say(entry.info.name + role + " is back");
  }
  if (info.stopped != was_stopped && entry.refused.empty()) {
    Say(entry.info.name +
        (info.stopped ? " stopped: its hand holds and takes nothing" : " goes on after a stop"));
  }
  NotifyUnequal(entry);
  NotifyTerms(entry);
  using Kind = MembershipChange::Kind;
  // a peer that is here but has ceased to take part is gone for the hand
  const bool begins = Counts(entry) && !entry.felt;
  const bool ends = entry.felt && !Counts(entry);
  // messages of the earlier run do not count for this one
  if (is_new_run || ends) Tell(entry, Kind::kLost);
  if (begins || is_new_run || claims_changed) {
    const bool is_new = added || taken_in || is_other_run;
    Tell(entry, is_new ? Kind::kJoined : begins ? Kind::kBack : Kind::kClaims);
  } else if (beliefs_changed) {
    Tell(entry, Kind::kBeliefs);
  }
}

void PeerDirectory::OnScene(const SceneManifest& manifest) {
  if (manifest.offered_by == self_) return;
  const std::lock_guard lock(mutex_);
  offers_.OnScene(manifest);
  const auto it = entries_.find(manifest.offered_by);
  if (it != entries_.end()) NotifyUnequal(it->second);
}

void PeerDirectory::OnSceneWithdrawn(PeerId peer) {
  const std::lock_guard lock(mutex_);
  offers_.OnWithdrawn(peer);
}

void PeerDirectory::OnTwin(const PeerInfo& info) {
  const std::lock_guard lock(mutex_);
  if (!twin_)
    Say("another program uses your keys: " + info.name +
        " takes part a second time; the others accept the one that joined first");
  twin_ = info;
}

bool PeerDirectory::TwinCameBefore(std::uint32_t beat) const {
  const std::lock_guard lock(mutex_);
  return twin_ && std::int64_t{twin_->beat} > std::int64_t{beat} + 1;
}

void PeerDirectory::SetOwnTerms(const ForceTerms& terms) {
  const std::lock_guard lock(mutex_);
  if (own_ == terms) return;
  own_ = terms;
  for (auto& [id, entry] : entries_) NotifyTerms(entry);
}

void PeerDirectory::NotifyTerms(Entry& entry) {
  const bool counts = entry.info.role == Role::kActive && entry.refused.empty() &&
                      entry.presence == Presence::kHere && !own_.law.empty();
  if (!counts || entry.info.terms.law.empty()) return;
  std::string difference = TermsDifference(own_, entry.info.terms);
  if (difference == entry.terms_told) return;
  entry.terms_told = std::move(difference);
  Say(entry.info.name + (entry.terms_told.empty()
                             ? " now uses the same force terms as you"
                             : " uses other force terms: " + entry.terms_told));
}

void PeerDirectory::NotifyRefusals(const DropTable& drops) {
  for (const auto& [peer, counts] : drops.Rows()) {
    for (std::size_t i = 0; i < counts.size(); ++i) {
      const auto reason = static_cast<Drop>(i);
      const char* const what = ReasonText(reason);
      if (what == nullptr || counts[i] < TellFrom(reason)) continue;
      if (refusals_told_.size() >= kMostRefusals || !refusals_told_.emplace(peer, reason).second) {
        continue;
      }
      const std::string who = peer == self_ ? "somebody" : NameOf(peer);
      const std::lock_guard lock(mutex_);
      Say(who + " " + what + ": refused");
    }
  }
}

void PeerDirectory::NotifyUnequal(Entry& entry) {
  const SceneManifest* const offer = offers_.From(entry.info.peer);
  if (!entry.unequal || entry.unequal_told || offer == nullptr) return;
  const ForceParameters theirs = ParametersOf(*offer);
  if (HashOf(theirs) != entry.info.params_hash) return;  // its newer offer is on its way
  entry.unequal_told = true;
  Say(PushWarning(terms_.parameters, theirs, terms_.heaviest_kg, entry.info.name));
}

void PeerDirectory::OnGone(PeerId peer, Presence presence) {
  const std::lock_guard lock(mutex_);
  offers_.OnPresence(peer, false);
  const auto it = entries_.find(peer);
  if (it == entries_.end() || it->second.presence == presence) return;
  const bool was_here = it->second.presence == Presence::kHere;
  it->second.presence = presence;
  it->second.gone = ++departures_;
  Say(it->second.info.name + (presence == Presence::kLeft ? " left" : " is lost"));
  if (was_here) {
    Tell(it->second, presence == Presence::kLeft ? MembershipChange::Kind::kLeft
                                                 : MembershipChange::Kind::kLost);
  }
  if (presence == Presence::kLost) RenameAfter(it->second);
}

bool PeerDirectory::Counts(const Entry& entry) {
  return entry.info.role == Role::kActive && entry.refused.empty();
}

void PeerDirectory::Tell(Entry& entry, MembershipChange::Kind kind) {
  const bool is_gone =
      kind == MembershipChange::Kind::kLeft || kind == MembershipChange::Kind::kLost;
  if (is_gone ? !entry.felt : !Counts(entry)) return;
  entry.felt = !is_gone;
  if (is_gone) {
    entry.owed_here.reset();
    if (entry.reached) entry.owed_end = kind;
  } else {
    // news of the peer itself includes news of its claims
    entry.owed_here = std::min(entry.owed_here.value_or(kind), kind);
  }
  HandOver(entry);
}

void PeerDirectory::HandOverEnd(Entry& entry) {
  if (!entry.owed_end || !Push(entry, *entry.owed_end)) return;
  entry.owed_end.reset();
  entry.reached = false;
}

void PeerDirectory::HandOver(Entry& entry) {
  HandOverEnd(entry);
  if (!entry.owed_end && entry.owed_here && Push(entry, *entry.owed_here)) {
    entry.owed_here.reset();
    entry.reached = true;
  }
}

void PeerDirectory::NotifyOwed() {
  const std::lock_guard lock(mutex_);
  // ends first: they make room for peers that have come
  for (auto& [id, entry] : entries_) HandOverEnd(entry);
  for (auto& [id, entry] : entries_) HandOver(entry);
}

bool PeerDirectory::Push(const Entry& entry, MembershipChange::Kind kind) {
  MembershipChange change;
  change.kind = kind;
  change.peer = entry.info.peer;
  change.claim_count =
      static_cast<std::uint32_t>(std::min(entry.info.claims.size(), change.claims.size()));
  std::copy_n(entry.info.claims.begin(), change.claim_count, change.claims.begin());
  change.belief_count =
      static_cast<std::uint32_t>(std::min(entry.info.beliefs.size(), change.beliefs.size()));
  std::copy_n(entry.info.beliefs.begin(), change.belief_count, change.beliefs.begin());
  for (std::uint32_t i = 0; entry.unequal && i < change.claim_count; ++i) {
    const std::vector<ObjectId>& shared = terms_.shared;
    Claim& claim = change.claims[i];
    if (std::find(shared.begin(), shared.end(), claim.object) != shared.end()) claim.held = false;
  }
  return changes_.TryPush(change);
}

void PeerDirectory::Say(std::string line) {
  if (notifications_.size() < kMostNews) {
    notifications_.push_back(std::move(line));
  } else {
    ++untold_;
  }
}

std::optional<SceneManifest> PeerDirectory::SessionScene() const {
  const std::lock_guard lock(mutex_);
  const SceneManifest* const session = offers_.session();
  return session == nullptr ? std::nullopt : std::optional(*session);
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

std::vector<std::string> PeerDirectory::TakeNotifications() {
  const std::lock_guard lock(mutex_);
  if (untold_ > 0) notifications_.push_back("and " + std::to_string(untold_) + " more such lines");
  untold_ = 0;
  return std::exchange(notifications_, {});
}

}  // namespace tandem
