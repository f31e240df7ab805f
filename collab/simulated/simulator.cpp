#include "collab/simulated/simulator.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "collab/simulated/fault_schedule.h"
#include "collab/simulated/session_checker.h"
#include "engine/base/hash.h"
#include "engine/haptics/scripted_device.h"

namespace tandem {

namespace {

constexpr PeerId kViewerId = 7;
constexpr std::uint64_t kSceneHash = 1;
constexpr std::int64_t kDigestFrames = 10;
constexpr std::int64_t kForgetMs = 500;  // beyond the two seconds for which a peak is held

/// A scripted hand whose device shows the checker what it is given.
class WatchedHand : public Device {
 public:
  WatchedHand(HandScript script, const Pose& X_WB0, SessionChecker& checker, std::size_t peer)
      : hand_(std::move(script), X_WB0), checker_(&checker), peer_(peer) {}

  void Start() noexcept override { hand_.Start(); }
  Anchor Read() noexcept override { return hand_.Read(); }
  void Render(const Wrench& F_D_W) noexcept override {
    checker_->Felt(peer_, F_D_W.f);
    hand_.Render(F_D_W);
  }

 private:
  ScriptedDevice hand_;
  SessionChecker* checker_;
  std::size_t peer_;
};

class Run {
 public:
  Run(std::uint64_t seed, const std::shared_ptr<const WorldModel>& model)
      : schedule_(DrawSchedule(seed)),
        model_(model),
        checker_(schedule_, *model, kViewerId),
        session_(seed),
        member_(schedule_.peers.size(), -1),
        links_(schedule_.links) {
    viewer_link_ = session_.network().Join(kViewerId, Role::kViewer, viewer_);
    session_.network().SetWatch(&checker_);
  }
  ~Run() { session_.network().SetWatch(nullptr); }
  Run(const Run&) = delete;
  Run& operator=(const Run&) = delete;

  SeedResult Go() {
    SeedResult result;
    result.seed = schedule_.seed;
    std::size_t next_fault = 0;
    for (std::int64_t ms = 0; ms < schedule_.end_ms + kForgetMs; ++ms) {
      if (ms == schedule_.end_ms) checker_.LookAtEnd(session_, member_, viewer_);
      for (std::size_t p = 0; p < schedule_.peers.size(); ++p) {
        if (schedule_.peers[p].joins_ms == ms) Join(p);
      }
      for (; next_fault < schedule_.faults.size() && schedule_.faults[next_fault].t_ms <= ms;
           ++next_fault) {
        Apply(schedule_.faults[next_fault]);
      }
      if (ms == schedule_.faults_end_ms) EndFaults();
      session_.Step();
      checker_.Look(session_);
      if (ms % kDigestFrames == 0) Digest();
      for (std::size_t m = 0; m < session_.size(); ++m) {
        result.peer_seconds += session_.present(m) ? 1e-3 : 0.0;
      }
    }
    checker_.LookAtLinks(session_);
    result.broken = checker_.broken();
    result.digest = digest_.value();
    return result;
  }

 private:
  void Join(std::size_t p) {
    const ScheduledPeer& peer = schedule_.peers[p];
    NodeOptions options;
    options.peer.id = peer.id;
    options.peer.held_object = peer.object;
    options.name = std::to_string(peer.id);
    options.publish_hz = peer.publish_hz;
    const double most_delay_s = 1e-3 * 0.5 * schedule_.LongestRoundTripMs() + 2.1;
    options.waiting = static_cast<std::size_t>(1000.0 * most_delay_s *
                                               static_cast<double>(schedule_.peers.size()));
    const auto body =
        static_cast<std::size_t>(model_->body_index[static_cast<std::size_t>(peer.object)]);
    auto hand = std::make_unique<WatchedHand>(peer.hand, model_->bodies[body].X_WB0, checker_, p);
    member_[p] = static_cast<int>(
        session_.Add(std::make_unique<PeerNode>(model_, std::move(hand), kSceneHash, options),
                     peer.id, peer.clock));
    for (std::size_t q = 0; q < schedule_.peers.size(); ++q) {
      if (q == p) continue;
      SwitchLink(q, p, links_[q][p]);
      if (member_[q] < 0) SwitchLink(p, q, links_[p][q]);
    }
    // who comes into a cut is cut too
    for (const auto& [from, to] : cuts_) CutLink(from, to, true);
  }

  void SwitchLink(std::size_t from, std::size_t to, const LinkConditions& conditions) {
    links_[from][to] = conditions;
    links_[from][to].seed = schedule_.seed;
    checker_.LinkSwitched(from, to, conditions);
    const PeerId id = schedule_.peers[from].id;
    if (member_[to] >= 0) {
      session_.node(static_cast<std::size_t>(member_[to])).inbox().Switch(id, links_[from][to]);
    }
    session_.network()
        .link(id, schedule_.peers[to].id)
        .Switch({.delay_ms = conditions.delay_ms,
                 .jitter_ms = conditions.jitter_ms,
                 .loss = conditions.loss});
  }

  void CutLink(std::size_t from, std::size_t to, bool cut) {
    session_.network().Cut(schedule_.peers[from].id, schedule_.peers[to].id, cut);
  }

  void Cut(std::size_t from, std::size_t to, bool cut) {
    if (cut) {
      cuts_.emplace_back(from, to);
    } else {
      std::erase(cuts_, std::make_pair(from, to));
    }
    CutLink(from, to, cut);
  }

  void Apply(const ScheduledFault& fault) {
    const auto p = static_cast<std::size_t>(fault.peer);
    using Kind = ScheduledFault::Kind;
    if (fault.kind == Kind::kCut || fault.kind == Kind::kHeal) {
      const bool cut = fault.kind == Kind::kCut;
      if (fault.other >= 0) return Cut(p, static_cast<std::size_t>(fault.other), cut);
      for (std::size_t q = 0; q < schedule_.peers.size(); ++q) {
        if (q == p) continue;
        Cut(p, q, cut);
        Cut(q, p, cut);
      }
      return;
    }
    if (fault.kind == Kind::kCondition) {
      return SwitchLink(p, static_cast<std::size_t>(fault.other), fault.conditions);
    }
    if (member_[p] < 0) return;
    const auto member = static_cast<std::size_t>(member_[p]);
    if (!session_.present(member)) return;
    const PeerId id = schedule_.peers[p].id;
    switch (fault.kind) {
      case Kind::kLeave:
        return session_.Leave(member);
      case Kind::kKill:
        return session_.Kill(member);
      case Kind::kHalt:
        return session_.Halt(member, true);
      case Kind::kWake:
        return session_.Halt(member, false);
      case Kind::kClockStep: {
        PeerClock clock = session_.network().clock(id);
        clock.offset_ns += fault.step_ns;
        return session_.network().SetClock(id, clock);
      }
      case Kind::kCommand:
        session_.node(member).peer().commands().TryPush(fault.command);
        return;
      default:
        return;
    }
  }

  void EndFaults() {
    while (!cuts_.empty()) Cut(cuts_.back().first, cuts_.back().second, false);
    for (std::size_t p = 0; p < schedule_.peers.size(); ++p) {
      for (std::size_t q = 0; q < schedule_.peers.size(); ++q) {
        if (p != q) SwitchLink(p, q, {.delay_ms = schedule_.delay_ms[p][q]});
      }
    }
  }

  void Digest() {
    for (std::size_t m = 0; m < session_.size(); ++m) {
      for (std::size_t b = 0; b < model_->bodies.size(); ++b) {
        const Pose& X = session_.node(m).world().state(b).X_WB;
        for (int i = 0; i < 4; ++i) digest_.Add(X.q.coeffs()[i]);
        for (int i = 0; i < 3; ++i) digest_.Add(X.p[i]);
      }
    }
  }

  FaultSchedule schedule_;
  std::shared_ptr<const WorldModel> model_;
  SessionChecker checker_;
  Viewer viewer_;
  SimulatedSession session_;
  std::unique_ptr<Transport> viewer_link_;
  std::vector<int> member_;  // of the session, for each scheduled peer; -1: not yet there
  std::vector<std::vector<LinkConditions>> links_;
  std::vector<std::pair<std::size_t, std::size_t>> cuts_;
  Hash64 digest_;
};

const char* NameOf(ScheduledFault::Kind kind) {
  using Kind = ScheduledFault::Kind;
  switch (kind) {
    case Kind::kLeave:
      return "leaves";
    case Kind::kKill:
      return "is killed";
    case Kind::kHalt:
      return "is halted";
    case Kind::kWake:
      return "goes on";
    case Kind::kCut:
      return "is cut from";
    case Kind::kHeal:
      return "is joined again to";
    case Kind::kCondition:
      return "has another link to";
    case Kind::kClockStep:
      return "has its clock put forward";
    case Kind::kCommand:
      return "grabs or releases";
  }
  return "";
}

}  // namespace

SeedResult SimulateSeed(std::uint64_t seed, const std::shared_ptr<const WorldModel>& model) {
  return Run(seed, model).Go();
}

std::vector<std::string> DescribeSeed(std::uint64_t seed) {
  const FaultSchedule schedule = DrawSchedule(seed);
  std::vector<std::string> lines;
  char text[200];
  for (const ScheduledPeer& peer : schedule.peers) {
    std::snprintf(text, sizeof text, "%.3f s: peer %llu joins, object %d, %.0f Hz",
                  1e-3 * static_cast<double>(peer.joins_ms),
                  static_cast<unsigned long long>(peer.id), peer.object, peer.publish_hz);
    lines.emplace_back(text);
  }
  for (const ScheduledFault& fault : schedule.faults) {
    const auto id = [&](int peer) {
      return peer < 0 ? 0ULL
                      : static_cast<unsigned long long>(
                            schedule.peers[static_cast<std::size_t>(peer)].id);
    };
    std::snprintf(text, sizeof text, "%.3f s: peer %llu %s", 1e-3 * static_cast<double>(fault.t_ms),
                  id(fault.peer), NameOf(fault.kind));
    lines.emplace_back(text);
    using Kind = ScheduledFault::Kind;
    if (fault.kind == Kind::kCut || fault.kind == Kind::kHeal || fault.kind == Kind::kCondition) {
      lines.back() += fault.other < 0 ? " all" : " peer " + std::to_string(id(fault.other));
    }
  }
  std::snprintf(text, sizeof text,
                "longest round trip %.0f ms; faults end at %.3f s, all at %.3f s",
                schedule.LongestRoundTripMs(), 1e-3 * static_cast<double>(schedule.faults_end_ms),
                1e-3 * static_cast<double>(schedule.end_ms));
  lines.emplace_back(text);
  return lines;
}

}  // namespace tandem
