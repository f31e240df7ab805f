#include "collab/simulated/simulator.h"

#include <algorithm>
#include <atomic>
#include <optional>
#include <thread>
#include <utility>

#include "collab/coupling/coupling_law.h"
#include "collab/simulated/checkers/monitored_hand.h"
#include "collab/simulated/checkers/session_checker.h"
#include "collab/simulated/network/hostile_member.h"
#include "collab/simulated/network/light_scene.h"
#include "engine/base/hash.h"
#include "engine/base/units.h"

namespace tandem {

namespace {

constexpr PeerId kViewerId = 7;
constexpr PeerId kHighHostileId = 999'999;  // above all honest ids: last in line, and loses ties
constexpr PeerId kLowHostileId = 9;         // below all honest ids: first in line, and wins ties
constexpr std::uint64_t kSceneHash = 1;
constexpr std::int64_t kDigestFrames = 10;
constexpr std::int64_t kBeginNs = 1'000'000'000;  // true time of the first frame
constexpr std::int64_t kQuietMs = 2000;
constexpr std::int64_t kForgetMs = 500;      // beyond the two seconds for which a peak is held
constexpr std::int64_t kGraspMs = 500;       // and a round trip, until all know the last movement
constexpr std::int64_t kLongestMs = 30'000;  // longest time until the hands are at home
constexpr double kConstantStiffness = 2000;  // N/m, for the law that ignores delay
constexpr std::int64_t kSettleNs = 1'000'000'000;  // the value of `tandem peer`

/// Returns the hostile member's id; odd seeds draw the lowest id.
PeerId HostileIdOf(std::uint64_t seed) {
  return seed % 2 == 0 ? kHighHostileId : kLowHostileId;
}

class Run {
 public:
  Run(std::uint64_t seed, const std::shared_ptr<const WorldModel>& model, const SeedLog& log,
      bool hostile)
      : schedule_(DrawSchedule(seed)),
        model_(model),
        log_(log),
        checker_(schedule_, *model, kViewerId),
        session_(seed),
        member_(schedule_.peers.size(), -1),
        hands_(schedule_.peers.size(), nullptr),
        grasps_(schedule_.peers.size()),
        links_(schedule_.links) {
    viewer_link_ = session_.network().Join(kViewerId, Role::kViewer, viewer_);
    session_.network().SetWatch(&checker_);
    if (!hostile) return;
    const PeerId id = HostileIdOf(seed);
    hostile_.emplace(session_.network(), id, seed, kSceneHash, *model);
    checker_.SetHostile(id);
  }
  ~Run() { session_.network().SetWatch(nullptr); }
  Run(const Run&) = delete;
  Run& operator=(const Run&) = delete;

  SeedResult Go() {
    SeedResult result;
    result.seed = schedule_.seed;
    const auto round_trip_ms = static_cast<std::int64_t>(schedule_.LongestRoundTripMs());
    // messages sent before the faults ended may be under way for long after
    const std::int64_t known_ms =
        schedule_.faults_end_ms + static_cast<std::int64_t>(schedule_.LongestWayMs());
    std::int64_t rest_ms = kLongestMs + 1;  // time since which the faults are over and the hands at
                                            // home
    std::size_t next_fault = 0;
    for (std::int64_t ms = 0;; ++ms) {
      checker_.SetTime(session_.now_ns() - kBeginNs);
      for (std::size_t p = 0; p < schedule_.peers.size(); ++p) {
        if (schedule_.peers[p].joins_ms == ms) Join(p);
      }
      for (; next_fault < schedule_.faults.size() && schedule_.faults[next_fault].t_ms <= ms;
           ++next_fault) {
        Apply(schedule_.faults[next_fault]);
      }
      if (ms == schedule_.faults_end_ms) EndFaults();
      if (ms >= known_ms && ms < rest_ms && (ms == kLongestMs || HandsAreHome())) {
        if (ms == kLongestMs && schedule_.law != "constant") checker_.NeverAtRest();
        rest_ms = ms;
        LetGoOfOtherGrasps();
      }
      // hands that hold on go home once the pull of those that let go has faded
      if (ms > rest_ms && AnyGraspsAgain()) {
        if (ms < kLongestMs && !HandsAreHome()) rest_ms = ms;
        if (ms == rest_ms + round_trip_ms + kGraspMs) GraspAgain();
      }
      const std::int64_t end_ms = rest_ms + kQuietMs + 4 * round_trip_ms;
      // a law that ignores delay does not come to rest
      if (ms == end_ms && schedule_.law != "constant") {
        checker_.CheckEnd(session_, member_, viewer_);
      }
      result.seconds = 1e-3 * static_cast<double>(ms);
      if (ms == end_ms + kForgetMs) break;
      if (hostile_) ms < schedule_.faults_end_ms ? hostile_->Step() : hostile_->Leave();
      session_.Step();
      SeeGrasps();
      checker_.Check(session_);
      if (log_) PrintNotifications();
      if (ms % kDigestFrames == 0) Digest();
      for (std::size_t m = 0; m < session_.size(); ++m) {
        result.peer_seconds += session_.present(m) ? 1e-3 : 0.0;
      }
    }
    if (schedule_.law != "constant") checker_.CheckLinks(session_);
    result.broken = checker_.violations().all();
    result.digest = digest_.value();
    result.tally = CountOf(schedule_);
    result.tally["asked"] = checker_.events(EventKind::kAsk);
    result.tally["granted"] = checker_.events(EventKind::kGrant);
    result.tally["refused"] = checker_.events(EventKind::kRefuse);
    result.tally["let go"] = checker_.events(EventKind::kRelease);
    result.tally["taken in hand"] = taken_;
    if (hostile_) {
      result.tally["hostile words"] = hostile_->stated();
      for (std::size_t m = 0; m < session_.size(); ++m) {
        const DropCounts drops = session_.node(m).inbox().drops().CountsOf(hostile_->id());
        for (std::size_t i = 0; i < drops.size(); ++i) {
          if (drops[i] == 0) continue;
          result.tally[std::string("refused: ") + NameOf(static_cast<Drop>(i))] += drops[i];
        }
      }
    }
    return result;
  }

 private:
  void Join(std::size_t p) {
    const ScheduledPeer& peer = schedule_.peers[p];
    NodeOptions options;
    options.peer.id = peer.id;
    options.peer.held_object = peer.object;
    options.peer.settle_ns = kSettleNs;
    options.peer.law = *MakeLaw(schedule_.law, {.constant_stiffness = kConstantStiffness}, true);
    options.name = std::to_string(peer.id);
    options.publish_hz = peer.publish_hz;
    const double most_delay_s = 1e-3 * 0.5 * schedule_.LongestRoundTripMs() + 2.1;
    options.waiting = static_cast<std::size_t>(1000.0 * most_delay_s *
                                               static_cast<double>(schedule_.peers.size()));
    const auto body =
        static_cast<std::size_t>(model_->body_index[static_cast<std::size_t>(peer.object)]);
    auto hand = std::make_unique<MonitoredHand>(peer.hand, model_->bodies[body].X_WB0, checker_, p);
    hands_[p] = hand.get();
    auto node = std::make_unique<PeerNode>(model_, std::move(hand), kSceneHash, options);
    member_[p] = static_cast<int>(session_.Add(std::move(node), peer.id, peer.clock));
    for (std::size_t q = 0; q < schedule_.peers.size(); ++q) {
      if (q == p) continue;
      SwitchLink(q, p, links_[q][p]);
      if (member_[q] < 0) SwitchLink(p, q, links_[p][q]);
    }
    // a peer that comes into a cut is cut too
    for (const auto& [from, to] : cuts_) CutLink(from, to, true);
  }

  void SwitchLink(std::size_t from, std::size_t to, const LinkConditions& conditions) {
    links_[from][to] = conditions;
    checker_.LinkSwitched(from, to, conditions);
    session_.Switch(schedule_.peers[from].id, schedule_.peers[to].id, member_[to], conditions,
                    schedule_.seed);
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
    if (log_) log_(Describe(schedule_, fault));
    if (fault.kind == Kind::kCut || fault.kind == Kind::kHeal) {
      for (std::size_t q = 0; q < schedule_.peers.size(); ++q) {
        if (q == p || (fault.other >= 0 && static_cast<std::size_t>(fault.other) != q)) continue;
        Cut(p, q, fault.kind == Kind::kCut);
        if (fault.both_ways) Cut(q, p, fault.kind == Kind::kCut);
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
        checker_.ClockStepped(p, 1e-6 * static_cast<double>(fault.step_ns));
        return session_.network().SetClock(id, clock);
      }
      case Kind::kCommand:
        session_.node(member).peer().commands().TryPush(fault.command);
        checker_.Wished(id, session_.now_ns());
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

  /// Returns whether all hands stay where they are and have what they asked for. The bodies that
  /// they hold must not swing on their couplings any more.
  bool HandsAreHome() {
    for (std::size_t p = 0; p < schedule_.peers.size(); ++p) {
      if (!IsHere(p)) continue;
      if (!hands_[p]->at_home() || PeerOf(p).ownership().wanted() >= 0) return false;
      if (grasps_[p].held >= 0 && !grasps_[p].stillness.is_still()) return false;
    }
    return true;
  }

  bool IsHere(std::size_t p) const {
    return member_[p] >= 0 && session_.present(static_cast<std::size_t>(member_[p]));
  }

  Peer& PeerOf(std::size_t p) { return session_.node(static_cast<std::size_t>(member_[p])).peer(); }

  /// Notes which body each hand takes, and where.
  void SeeGrasps() {
    for (std::size_t p = 0; p < schedule_.peers.size(); ++p) {
      if (!IsHere(p)) continue;
      Grasp& grasp = grasps_[p];
      const int held = PeerOf(p).ownership().held();
      if (held != grasp.held && held >= 0) {
        ++taken_;
        const auto body = static_cast<std::size_t>(held);
        grasp.as_agreed = static_cast<int>(model_->object[body]) == schedule_.peers[p].object &&
                          grasp.at_first[body];
      }
      const World& world = session_.node(static_cast<std::size_t>(member_[p])).world();
      if (held != grasp.held) grasp.stillness = {};
      if (held >= 0) grasp.stillness.See(world.state(static_cast<std::size_t>(held)).V_WB);
      grasp.held = held;
      grasp.at_first.resize(model_->bodies.size());
      for (std::size_t b = 0; b < model_->bodies.size(); ++b) {
        const Pose& X = world.state(b).X_WB;
        const Pose& X0 = model_->bodies[b].X_WB0;
        grasp.at_first[b] = X.p == X0.p && X.q.coeffs() == X0.q.coeffs();
      }
    }
  }

  /// Makes the hands that grasped a shared body at another place than agreed let go, to take it
  /// again later. Hands with different grasps would pull at one another at rest.
  void LetGoOfOtherGrasps() {
    std::vector<std::size_t> holders;
    for (std::size_t p = 0; p < schedule_.peers.size(); ++p) {
      if (IsHere(p) && PeerOf(p).shared() != nullptr) holders.push_back(p);
    }
    const bool any_agreed = std::any_of(holders.begin(), holders.end(), [&](std::size_t p) {
      return grasps_[p].as_agreed;
    });
    for (const std::size_t p : holders) {
      if (grasps_[p].as_agreed || (!any_agreed && p == holders.front())) continue;
      PeerOf(p).commands().TryPush({Command::Kind::kRelease, kNoObject, 0});
      checker_.Wished(schedule_.peers[p].id, session_.now_ns());
      grasps_[p].again = true;
    }
  }

  bool AnyGraspsAgain() const {
    return std::any_of(grasps_.begin(), grasps_.end(), [](const Grasp& grasp) {
      return grasp.again;
    });
  }

  void GraspAgain() {
    for (std::size_t p = 0; p < schedule_.peers.size(); ++p) {
      if (!std::exchange(grasps_[p].again, false)) continue;
      PeerOf(p).commands().TryPush({Command::Kind::kGrab, kLightSceneShared, 0});
    }
  }

  void PrintNotifications() {
    for (std::size_t m = 0; m < session_.size(); ++m) {
      for (const std::string& line : session_.node(m).TakeNotifications()) {
        log_(Text("%6.3f s: peer %llu is told: ", ToSeconds(session_.now_ns() - kBeginNs),
                  static_cast<unsigned long long>(session_.id(m))) +
             line);
      }
    }
    for (; reported_ < checker_.violations().all().size(); ++reported_) {
      log_("   BROKEN " + checker_.violations().all()[reported_]);
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

  struct Grasp {
    int held = -1;           // body in hand a frame ago
    bool as_agreed = false;  // grasped at the place that all know, before the body had moved
    RestDetector stillness;  // stillness of the held body
    bool again = false;      // it is to take the shared body once more
    std::vector<bool> at_first;
  };

  FaultSchedule schedule_;
  std::shared_ptr<const WorldModel> model_;
  SeedLog log_;
  SessionChecker checker_;
  Viewer viewer_;
  SimulatedSession session_;
  std::unique_ptr<Transport> viewer_link_;
  std::optional<HostileMember> hostile_;
  std::vector<int> member_;  // number in the session of each scheduled peer; -1: not there yet
  std::vector<const MonitoredHand*> hands_;
  std::vector<Grasp> grasps_;
  std::vector<std::vector<LinkConditions>> links_;
  std::vector<std::pair<std::size_t, std::size_t>> cuts_;
  std::uint64_t taken_ = 0;
  std::size_t reported_ = 0;
  Hash64 digest_;
};

}  // namespace

SeedResult SimulateSeed(std::uint64_t seed, const std::shared_ptr<const WorldModel>& model,
                        const SeedLog& log, bool hostile) {
  return Run(seed, model, log, hostile).Go();
}

std::vector<SeedResult> RunSeeds(std::uint64_t first, std::uint64_t count, unsigned threads,
                                 const std::function<SeedResult(std::uint64_t)>& simulate) {
  std::vector<SeedResult> results(count);
  std::atomic<std::uint64_t> next{0};
  std::vector<std::jthread> workers;  // joined also where a thread cannot be started
  for (unsigned t = 0; t < threads; ++t) {
    workers.emplace_back([&] {
      for (std::uint64_t i = next++; i < count; i = next++) {
        results[i] = simulate(first + i);
      }
    });
  }
  for (std::jthread& worker : workers) worker.join();
  return results;
}

std::vector<SeedResult> SimulateSeeds(std::uint64_t first, std::uint64_t count, unsigned threads,
                                      const std::shared_ptr<const WorldModel>& model,
                                      const SeedLog& log, bool hostile) {
  return RunSeeds(first, count, threads, [&](std::uint64_t seed) {
    return SimulateSeed(seed, model, log, hostile);
  });
}

}  // namespace tandem
