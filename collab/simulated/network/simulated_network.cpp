#include "collab/simulated/network/simulated_network.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tandem {

namespace {
constexpr std::int64_t kWindowNs = 2'000'000'000;  // least time for which a long way is remembered
}  // namespace

class SimulatedNetwork::Link : public Transport {
 public:
  Link(SimulatedNetwork& network, PeerId peer) : network_(&network), peer_(peer) {}
  ~Link() override { network_->Remove(peer_, false); }
  Link(const Link&) = delete;
  Link& operator=(const Link&) = delete;

  void Publish(const ObjectState& state) override {
    if (network_->watch_ != nullptr) network_->watch_->OnState(peer_, state);
    network_->SendMotion(peer_, Role::kActive, state);
  }
  void Publish(const ObjectState& state, const CouplingLinks& links) override {
    Publish(state);
    if (network_->watch_ != nullptr) network_->watch_->OnLinks(peer_, links);
    network_->SendMotion(peer_, Role::kActive, links);
  }
  void Publish(const ViewFrame& frame) override {
    if (network_->watch_ != nullptr) network_->watch_->OnView(peer_, frame);
    network_->SendMotion(peer_, Role::kViewer, frame);
  }
  void Publish(const PeerInfo& info) override {
    const auto self = network_->members_.find(peer_);
    if (self == network_->members_.end()) return;
    if (network_->watch_ != nullptr) network_->watch_->OnPeerInfo(peer_, info);
    // a transport lets no peer speak in another's name
    if (info.peer != peer_) return;
    self->second.info = info;
    self->second.info->incarnation = self->second.incarnation;
    network_->SendToAll(peer_, *self->second.info);
  }
  void Publish(const Event& event) override {
    if (!network_->members_.contains(peer_)) return;
    if (network_->watch_ != nullptr) network_->watch_->OnEvent(peer_, event);
    if (event.peer == peer_) network_->SendToAll(peer_, event);
  }
  void Publish(const SceneManifest& manifest) override {
    const auto self = network_->members_.find(peer_);
    if (self == network_->members_.end()) return;
    if (manifest.offered_by != peer_) return;
    self->second.scene = manifest;
    network_->SendToAll(peer_, manifest);
  }
  void Leave() override { network_->Remove(peer_, true); }

 private:
  SimulatedNetwork* network_;
  PeerId peer_;
};

std::unique_ptr<Transport> SimulatedNetwork::Join(PeerId peer, Role role, Inbox& inbox,
                                                  PeerClock clock) {
  Member& member = members_[peer];
  member = Member{};
  member.role = role;
  member.inbox = &inbox;
  member.clock = clock;
  member.incarnation = ++incarnations_;
  for (const auto& [id, other] : members_) {
    if (id == peer) continue;
    LineOf(id, peer).hearing = RemotePeerState{};
    if (other.scene) Send(id, peer, *other.scene);
    if (other.info) Send(id, peer, *other.info);
  }
  return std::make_unique<Link>(*this, peer);
}

SimulatedNetwork::Line& SimulatedNetwork::LineOf(PeerId from, PeerId to) {
  const auto [it, added] = lines_.try_emplace({from, to});
  if (added) it->second.conditioner = LinkConditioner({.seed = seed_}, from * 0x10001U + to);
  return it->second;
}

std::int64_t SimulatedNetwork::LocalNow(PeerId peer) const {
  return LocalNowOf(members_.at(peer));
}

std::int64_t SimulatedNetwork::LocalNowOf(const Member& member) const {
  const PeerClock& clock = member.clock;
  const double drift = 1e-6 * clock.drift_ppm * static_cast<double>(now_ns_);
  return clock.offset_ns + now_ns_ + std::llround(drift);
}

void SimulatedNetwork::Send(PeerId from, PeerId to, const Control& what) {
  Line& line = LineOf(from, to);
  std::array<std::int64_t, 2> due_ns{};
  std::int64_t sent_ns = now_ns_;
  if (std::holds_alternative<LivelinessState>(what)) {
    // a lost sign of life is not sent again: the next one follows soon
    if (line.cut || line.conditioner.Due(sent_ns, due_ns) == 0) return;
  } else {
    constexpr int kMostResends = 100;
    for (int i = 0; i < kMostResends && line.conditioner.Due(sent_ns, due_ns) == 0; ++i) {
      sent_ns += kResendNs;
      due_ns[0] = sent_ns;
    }
    if (line.cut && std::holds_alternative<PeerInfo>(what)) {
      // the newest peer_info is kept
      std::erase_if(line.under_way, [](const MessageInFlight& item) {
        return std::holds_alternative<PeerInfo>(item.what);
      });
    }
  }
  line.last_due_ns = std::max(line.last_due_ns, due_ns[0]);
  line.longest_ns = std::max(line.longest_ns, line.last_due_ns - now_ns_);
  const auto receiver = members_.find(to);
  if (receiver == members_.end()) return;
  line.under_way.push_back({line.last_due_ns, receiver->second.incarnation, what});
}

void SimulatedNetwork::SendToAll(PeerId from, const Control& what) {
  for (const auto& [id, member] : members_) {
    if (id != from) Send(from, id, what);
  }
}

template <typename T>
void SimulatedNetwork::SendMotion(PeerId from, Role to, const T& what) {
  if (!members_.contains(from)) return;
  for (auto& [id, member] : members_) {
    if (id == from || member.role != to || LineOf(from, id).cut) continue;
    if (!member.halted) {
      Arrive(member, what);
      continue;
    }
    auto& kept = member.backlog[from];
    kept.push_back(what);
    if (kept.size() > kHistory) kept.pop_front();
  }
}

void SimulatedNetwork::Arrive(Member& to, const ObjectState& state) {
  to.inbox->OnState(state, LocalNowOf(to));
}

void SimulatedNetwork::Arrive(Member& to, const CouplingLinks& links) {
  to.inbox->OnLinks(links, LocalNowOf(to));
}

void SimulatedNetwork::Arrive(Member& to, const ViewFrame& view) {
  to.inbox->OnView(view, LocalNowOf(to));
}

void SimulatedNetwork::Advance(std::int64_t now_ns) {
  now_ns_ = now_ns;
  if (now_ns_ >= next_alive_ns_) {
    next_alive_ns_ = now_ns_ + kAlivePeriodNs;
    for (const auto& [id, member] : members_) {
      if (member.halted) continue;
      for (const auto& [other, receiver] : members_) {
        if (other != id) Send(id, other, LivelinessState{});
      }
    }
  }
  if (now_ns_ >= next_window_ns_) {
    next_window_ns_ = now_ns_ + kWindowNs;
    for (auto& [key, line] : lines_) {
      line.longest_before_ns = std::exchange(line.longest_ns, line.last_due_ns - now_ns_);
    }
  }
  // leases end first, so that a peer that was halted finds the others' leases over, as a stopped
  // process does
  EndLeases();
  for (auto& [key, line] : lines_) {
    while (!line.cut && !line.under_way.empty() && line.under_way.front().due_ns <= now_ns_) {
      const auto receiver = members_.find(key.second);
      if (receiver != members_.end() && receiver->second.halted) break;
      const MessageInFlight item = std::move(line.under_way.front());
      line.under_way.pop_front();
      if (receiver == members_.end() || receiver->second.incarnation != item.to_incarnation) {
        continue;
      }
      Deliver(key.first, key.second, line, item.what);
    }
  }
}

void SimulatedNetwork::Deliver(PeerId from, PeerId to, Line& line, const Control& what) {
  Member& member = members_.at(to);
  RemotePeerState& hearing = line.hearing;
  hearing.received_ns = now_ns_;
  if (const auto* info = std::get_if<PeerInfo>(&what)) {
    hearing.known = true;
    if (!hearing.alive) hearing.since_ns = now_ns_;
    hearing.alive = true;
    member.inbox->OnPeerInfo(*info, LocalNowOf(member));
  } else if (const auto* event = std::get_if<Event>(&what)) {
    if (member.role == Role::kActive) member.inbox->OnEvent(*event, LocalNowOf(member));
  } else if (const auto* scene = std::get_if<SceneManifest>(&what)) {
    member.inbox->OnScene(*scene);
  } else if (std::holds_alternative<Left>(what)) {
    hearing = RemotePeerState{};
    member.inbox->OnPeerLeft(from);
  }
}

void SimulatedNetwork::EndLeases() {
  for (auto& [key, line] : lines_) {
    RemotePeerState& hearing = line.hearing;
    if (!hearing.alive || now_ns_ - hearing.received_ns <= kLeaseNs) continue;
    const auto receiver = members_.find(key.second);
    if (receiver == members_.end() || receiver->second.halted) continue;
    hearing.alive = false;
    receiver->second.inbox->OnPeerLost(key.first);
  }
}

void SimulatedNetwork::Cut(PeerId from, PeerId to, bool cut) {
  Line& line = LineOf(from, to);
  if (line.cut == cut) return;
  line.cut = cut;
  if (cut) {
    line.cut_since_ns = now_ns_;
    return;
  }
  line.healed_ns = now_ns_;
  if (now_ns_ - line.cut_since_ns <= kForgetNs) return;
  // the peer is found again as if new: peer_info and scene are kept for that, and a goodbye is a
  // fact
  std::erase_if(line.under_way, [](const MessageInFlight& item) {
    return !std::holds_alternative<PeerInfo>(item.what) &&
           !std::holds_alternative<SceneManifest>(item.what) &&
           !std::holds_alternative<Left>(item.what);
  });
}

std::optional<std::int64_t> SimulatedNetwork::ClearSince(PeerId from, PeerId to) const {
  const auto it = lines_.find({from, to});
  if (it == lines_.end() || it->second.cut || !it->second.hearing.alive) return std::nullopt;
  return std::max(it->second.hearing.since_ns, it->second.healed_ns);
}

bool SimulatedNetwork::IsCut(PeerId from, PeerId to) const {
  const auto it = lines_.find({from, to});
  return it != lines_.end() && it->second.cut;
}

std::int64_t SimulatedNetwork::LongestWay() const {
  std::int64_t longest = 0;
  for (const auto& [key, line] : lines_) {
    longest = std::max({longest, line.longest_ns, line.longest_before_ns});
  }
  return longest;
}

void SimulatedNetwork::Halt(PeerId peer, bool halted) {
  Member& member = members_.at(peer);
  member.halted = halted;
  if (halted) return;
  for (auto& [from, kept] : member.backlog) {
    for (const auto& item : kept) {
      std::visit(
          [&](const auto& what) {
            Arrive(member, what);
          },
          item);
    }
  }
  member.backlog.clear();
}

void SimulatedNetwork::Remove(PeerId peer, bool graceful) {
  if (!members_.contains(peer)) return;
  if (graceful) SendToAll(peer, Left{});
  members_.erase(peer);
}

}  // namespace tandem
