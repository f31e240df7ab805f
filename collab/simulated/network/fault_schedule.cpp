#include "collab/simulated/network/fault_schedule.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "collab/simulated/network/light_scene.h"

namespace tandem {

namespace {

constexpr std::int64_t kFaultsEndMs = 7000;
constexpr std::int64_t kSettleMs = 1000;  // until a hand takes something

class RandomSource {
 public:
  explicit RandomSource(std::uint64_t seed) : random_(seed) {}
  double Uniform(double low, double high) {
    return low + (high - low) * static_cast<double>(random_() >> 11U) * 0x1p-53;
  }
  std::int64_t Whole(std::int64_t low, std::int64_t high) {  // both included
    return low + static_cast<std::int64_t>(random_() % static_cast<std::uint64_t>(high - low + 1));
  }
  bool Chance(double chance) { return Uniform(0, 1) < chance; }

 private:
  std::mt19937_64 random_;
};

double BaseDelayMs(RandomSource& rng) {
  const double kind = rng.Uniform(0, 1);
  if (kind < 0.45) return rng.Uniform(0, 30);
  if (kind < 0.85) return rng.Uniform(30, 250);
  return rng.Uniform(250, 2000);
}

LinkConditions Rough(RandomSource& rng, double delay_ms) {
  LinkConditions link{.delay_ms = delay_ms};
  if (rng.Chance(0.5)) link.jitter_ms = rng.Uniform(0, 30);
  if (rng.Chance(0.5)) link.loss = rng.Uniform(0, 0.3);
  if (rng.Chance(0.2)) {
    link.burst_enter = rng.Uniform(0, 0.01);
    link.burst_leave = rng.Uniform(0.02, 0.2);
  }
  if (rng.Chance(0.3)) {
    link.reorder = rng.Uniform(0, 0.2);
    link.reorder_ms = rng.Uniform(1, 50);
  }
  if (rng.Chance(0.3)) link.duplicate = rng.Uniform(0, 0.1);
  if (rng.Chance(0.2)) {
    link.swing_ms = 0.5 * delay_ms;
    link.swing_period_s = rng.Uniform(1, 5);
  }
  return link;
}

/// Returns a hand that wanders for `seconds` and then stays at home, which is the same for all.
HandScript Wander(RandomSource& rng, double seconds) {
  HandScript script;
  // such a hand comes to rest within a second even with a body at arm's length
  script.impedance.damping = 15.0;
  script.impedance.rotation_damping = 0.1;
  script.waypoints = {{0, Vec3::Zero(), Quat::Identity()}};
  for (double t = rng.Uniform(0.5, 1.5); t < seconds - 1.0; t += rng.Uniform(0.5, 1.5)) {
    const Vec3 p(rng.Uniform(-0.03, 0.03), rng.Uniform(-0.03, 0.03), rng.Uniform(-0.02, 0.03));
    const Vec3 turn(rng.Uniform(-0.3, 0.3), rng.Uniform(-0.3, 0.3), rng.Uniform(-0.3, 0.3));
    const double angle = turn.norm();
    script.waypoints.push_back(
        {t, p, Quat(Eigen::AngleAxisd(angle, angle > 0 ? Vec3(turn / angle) : Vec3::UnitX()))});
  }
  const double home = std::max(seconds, script.waypoints.back().t + 0.7);
  // home differs from the start, so that a hand that never came is told from one that came
  script.waypoints.push_back(
      {home, Vec3(0.006, -0.004, 0.012), Quat(Eigen::AngleAxisd(0.15, Vec3(1, 2, 2) / 3.0))});
  return script;
}

class Drawer {
 public:
  explicit Drawer(std::uint64_t seed) : rng_(seed * 0x9E3779B97F4A7C15U + 1) {
    schedule_.seed = seed;
    schedule_.faults_end_ms = kFaultsEndMs;
  }

  FaultSchedule Draw() {
    DrawPeers();
    DrawLinks();
    schedule_.law = DrawLaw();
    const std::int64_t count = rng_.Whole(3, 9);
    for (std::int64_t i = 0; i < count; ++i) DrawFault();
    const std::int64_t wishes = rng_.Whole(2, 9);
    for (std::int64_t i = 0; i < wishes; ++i) DrawWish();
    for (std::size_t p = 0; p < schedule_.peers.size(); ++p) {
      ScheduledPeer& peer = schedule_.peers[p];
      // a halted hand is late by the time that it stood
      const auto run_ms = kFaultsEndMs - peer.joins_ms - halted_ms_[p] - kSettleMs - 800;
      peer.hand = Wander(rng_, std::max(1.0, 1e-3 * static_cast<double>(run_ms)));
    }
    std::stable_sort(schedule_.faults.begin(), schedule_.faults.end(),
                     [](const ScheduledFault& a, const ScheduledFault& b) {
                       return a.t_ms < b.t_ms;
                     });
    return std::move(schedule_);
  }

 private:
  /// Draws a law: the default in half of the schedules, the others often enough to be seen.
  std::string DrawLaw() {
    const double law = rng_.Uniform(0, 1);
    if (law < 0.5) return DefaultLaw()->name();
    if (law < 0.7) return "p+d";
    if (law < 0.85) return "pdopt";
    return law < 0.95 ? "linear" : "constant";
  }

  void DrawPeers() {
    const std::int64_t count = rng_.Whole(3, 5);
    int next_own = kLightSceneFirstOwn;
    for (std::int64_t p = 0; p < count; ++p) {
      ScheduledPeer peer;
      peer.id = static_cast<PeerId>(100 + rng_.Whole(0, 99) * 10 + p);
      peer.joins_ms = rng_.Chance(0.7) ? rng_.Whole(0, 300) : rng_.Whole(300, 4000);
      // the first two share a body
      const bool shares = p < 2 || next_own >= kLightSceneObjects || rng_.Chance(0.4);
      peer.object = shares ? kLightSceneShared : next_own++;
      peer.publish_hz = rng_.Chance(0.6) ? 1000 : rng_.Chance(0.5) ? 250 : 100;
      peer.clock = {.offset_ns = rng_.Whole(1, 1'000'000) * 1'000'000'000,
                    .drift_ppm = rng_.Uniform(-100, 100)};
      // some peers are on one machine
      if (p > 0 && peer.id / 10 % 4 == 0) peer.clock = schedule_.peers.back().clock;
      schedule_.peers.push_back(std::move(peer));
    }
    halted_ms_.assign(schedule_.peers.size(), 0);
    gone_.assign(schedule_.peers.size(), false);
  }

  void DrawLinks() {
    const std::size_t n = schedule_.peers.size();
    const double delay = BaseDelayMs(rng_);
    schedule_.delay_ms.assign(n, std::vector<double>(n, 0.0));
    schedule_.links.assign(n, std::vector<LinkConditions>(n));
    for (std::size_t from = 0; from < n; ++from) {
      for (std::size_t to = 0; to < n; ++to) {
        schedule_.delay_ms[from][to] = std::min(2000.0, delay * rng_.Uniform(0.5, 1.5));
        schedule_.links[from][to] = Rough(rng_, schedule_.delay_ms[from][to]);
      }
    }
  }

  ScheduledFault& Add(std::int64_t t_ms, ScheduledFault::Kind kind, std::size_t peer) {
    ScheduledFault& fault = schedule_.faults.emplace_back();
    fault.t_ms = t_ms;
    fault.kind = kind;
    fault.peer = static_cast<int>(peer);
    return fault;
  }

  void DrawFault() {
    using Kind = ScheduledFault::Kind;
    const auto n = static_cast<std::int64_t>(schedule_.peers.size());
    const auto peer = static_cast<std::size_t>(rng_.Whole(0, n - 1));
    // a different peer
    const auto other =
        static_cast<int>((static_cast<std::int64_t>(peer) + rng_.Whole(1, n - 1)) % n);
    const std::int64_t t = rng_.Whole(
        std::max<std::int64_t>(1000, schedule_.peers[peer].joins_ms + 200), kFaultsEndMs - 500);
    const std::int64_t lasts = std::min(rng_.Whole(50, 3000), kFaultsEndMs - 1 - t);
    const double what = rng_.Uniform(0, 1);
    if (gone_[peer] || halted_ms_[peer] > 0) return;
    if (what < 0.2) {
      if (std::count(gone_.begin(), gone_.end(), false) <= 2) return;
      gone_[peer] = true;
      Add(t, what < 0.1 ? Kind::kLeave : Kind::kKill, peer);
    } else if (what < 0.4) {
      halted_ms_[peer] = lasts;  // one pause for each peer
      Add(t, Kind::kHalt, peer);
      Add(t + lasts, Kind::kWake, peer);
    } else if (what < 0.7) {
      const int whom = rng_.Chance(0.3) ? -1 : other;
      const bool both_ways = whom < 0 || rng_.Chance(0.5);
      for (const bool cut : {true, false}) {
        ScheduledFault& fault = Add(cut ? t : t + lasts, cut ? Kind::kCut : Kind::kHeal, peer);
        fault.other = whom;
        fault.both_ways = both_ways;
      }
    } else if (what < 0.85) {
      ScheduledFault& fault = Add(t, Kind::kCondition, peer);
      fault.other = other;
      fault.conditions = Rough(rng_, std::min(2000.0, BaseDelayMs(rng_)));
    } else {
      Add(t, Kind::kClockStep, peer).step_ns = rng_.Whole(10, 2000) * 1'000'000;
    }
  }

  /// Draws a user's request.
  void DrawWish() {
    const auto n = static_cast<std::int64_t>(schedule_.peers.size());
    const auto peer = static_cast<std::size_t>(rng_.Whole(0, n - 1));
    const auto other =
        static_cast<std::size_t>((static_cast<std::int64_t>(peer) + rng_.Whole(1, n - 1)) % n);
    const std::int64_t t = rng_.Whole(schedule_.peers[peer].joins_ms + 200, kFaultsEndMs - 200);
    const double what = rng_.Uniform(0, 1);
    const auto object = static_cast<ObjectId>(rng_.Whole(1, kLightSceneObjects - 1));
    Command& command = Add(t, ScheduledFault::Kind::kCommand, peer).command;
    if (what < 0.5) {
      command = {Command::Kind::kGrab, object, 0};
    } else if (what < 0.7) {
      command = {Command::Kind::kRelease, kNoObject, 0};
    } else {
      command = {Command::Kind::kGive, kNoObject, schedule_.peers[other].id};
    }
  }

  RandomSource rng_;
  FaultSchedule schedule_;
  std::vector<std::int64_t> halted_ms_;
  std::vector<bool> gone_;
};

}  // namespace

double FaultSchedule::LongestRoundTripMs() const {
  double longest = 0;
  for (std::size_t a = 0; a < peers.size(); ++a) {
    for (std::size_t b = 0; b < a; ++b) {
      longest = std::max(longest, delay_ms[a][b] + delay_ms[b][a]);
    }
  }
  return longest;
}

double FaultSchedule::LongestWayMs() const {
  double longest = 0;
  const auto add = [&](const LinkConditions& link) {
    longest = std::max(longest, link.delay_ms + link.swing_ms + link.jitter_ms + link.reorder_ms);
  };
  for (const std::vector<LinkConditions>& row : links) {
    for (const LinkConditions& link : row) add(link);
  }
  for (const ScheduledFault& fault : faults) add(fault.conditions);
  return longest;
}

FaultSchedule DrawSchedule(std::uint64_t seed) {
  return Drawer(seed).Draw();
}

}  // namespace tandem
