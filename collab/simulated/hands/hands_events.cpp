#include <algorithm>
#include <utility>

#include "collab/simulated/hands/hands_run.h"

// The events of a session of hands beside the acts of its hosts.

namespace tandem {

namespace {

constexpr std::size_t kMostPeers = 24;  // in the whole session
constexpr std::size_t kMostHosts = 3;   // at one controller
constexpr std::size_t kWaiting =
    4000;  // samples under way: four peers, a quarter of a second, some twice

}  // namespace

FaultSchedule DrawHandsSchedule(std::uint64_t seed, SeededRandom& rng) {
  FaultSchedule schedule;
  schedule.seed = seed;
  const double delay_ms = rng.Chance(0.4) ? rng.Uniform(0, 10) : rng.Uniform(10, 200);
  for (std::size_t p = 0; p < kMostPeers; ++p) {
    ScheduledPeer& peer = schedule.peers.emplace_back();
    peer.id = static_cast<PeerId>(100 + rng.Whole(0, 9) * 100) + p;
    peer.clock = {.offset_ns = rng.Whole(1, 1'000'000) * 1'000'000'000,
                  .drift_ppm = rng.Uniform(-100, 100)};
  }
  schedule.delay_ms.assign(kMostPeers, std::vector<double>(kMostPeers, 0.0));
  schedule.links.assign(kMostPeers, std::vector<LinkConditions>(kMostPeers));
  for (std::size_t from = 0; from < kMostPeers; ++from) {
    for (std::size_t to = 0; to < kMostPeers; ++to) {
      LinkConditions& link = schedule.links[from][to];
      link.delay_ms = std::min(200.0, delay_ms * rng.Uniform(0.5, 1.5));
      if (rng.Chance(0.5)) link.jitter_ms = rng.Uniform(0, 20);
      if (rng.Chance(0.5)) link.loss = rng.Uniform(0, 0.1);
      schedule.delay_ms[from][to] = link.delay_ms;
    }
  }
  return schedule;
}

void HandsRun::Log(const std::string& line) {
  if (log_) log_(Text("%7.3f s: ", 1e-3 * static_cast<double>(ms_)) + line);
}

void HandsRun::RunDueEvents() {
  for (std::size_t i = 0; i < joins_ms_.size();) {
    if (joins_ms_[i] > ms_) {
      ++i;
      continue;
    }
    joins_ms_.erase(joins_ms_.begin() + static_cast<std::ptrdiff_t>(i));
    if (next_peer_ < schedule_.peers.size()) Join(next_peer_++);
  }
  for (std::size_t i = 0; i < pauses_.size();) {
    if (pauses_[i].until_ms > ms_) {
      ++i;
      continue;
    }
    sites_[pauses_[i].site]->Halt(false);
    pauses_.erase(pauses_.begin() + static_cast<std::ptrdiff_t>(i));
  }
  EndDeviceFailures();
  for (std::size_t s = 0; s < sites_.size(); ++s) {
    if (sites_[s]->present() && sites_[s]->quits()) RemoveSite(s, false);
  }
  if (ms_ % 100 == 0) AddHosts();
  if (ms_ < next_event_ms_) return;
  next_event_ms_ = ms_ + rng_.Whole(50, 1500);
  RandomEvent();
}

std::size_t HandsRun::SomeSite() {
  std::vector<std::size_t> present;
  for (std::size_t s = 0; s < sites_.size(); ++s) {
    if (sites_[s]->present()) present.push_back(s);
  }
  if (present.empty()) return sites_.size();
  return present[static_cast<std::size_t>(
      rng_.Whole(0, static_cast<std::int64_t>(present.size()) - 1))];
}

void HandsRun::RandomEvent() {
  const std::size_t s = SomeSite();
  if (s == sites_.size()) return;
  SimulatedController& site = *sites_[s];
  const double what = rng_.Uniform(0, 1);
  if (what < 0.35) {
    if (site.rig() != nullptr) FailDevice(s);
  } else if (what < 0.45) {
    ++tally_["typed stops"];
    Log(site.name() + ": 'stop' is typed");
    site.Type(true);
  } else if (what < 0.6) {
    site.Type(false);
  } else if (what < 0.75) {
    PauseController(s);
  } else if (what < 0.8) {
    RemoveSite(s, rng_.Chance(0.8));
  } else if (what < 0.9) {
    const std::size_t other = SomeSite();
    LinkConditions link = schedule_.links[s][other];
    link.loss = rng_.Uniform(0, 0.2);
    link.jitter_ms = rng_.Uniform(0, 30);
    if (other != s) SwitchLink(s, other, link);
  }
}

void HandsRun::Join(std::size_t p) {
  const ScheduledPeer& peer = schedule_.peers[p];
  const bool any_device = std::ranges::any_of(sites_, [](const auto& site) {
    return site->present() && site->rig() != nullptr;
  });
  SimulatedController::Options options;
  options.id = peer.id;
  options.name = "peer-" + std::to_string(p);
  options.clock = peer.clock;
  options.device = !any_device && rng_.Chance(0.4);
  options.waiting = kWaiting;
  options.seed = schedule_.seed * 100 + p;
  options.log = log_;
  sites_.push_back(
      std::make_unique<SimulatedController>(session_, model_, options, checker_.violations()));
  member_[p] = static_cast<int>(sites_.back()->member());
  ++tally_[options.device ? "controllers with a device" : "controllers"];
  Log(options.name + (options.device ? " comes, with a device" : " comes"));
  for (std::size_t q = 0; q < schedule_.peers.size(); ++q) {
    if (q == p) continue;
    SwitchLink(q, p, schedule_.links[q][p]);
    SwitchLink(p, q, schedule_.links[p][q]);
  }
}

void HandsRun::SwitchLink(std::size_t from, std::size_t to, const LinkConditions& conditions) {
  checker_.LinkSwitched(from, to, conditions);
  session_.Switch(schedule_.peers[from].id, schedule_.peers[to].id, member_[to], conditions,
                  schedule_.seed);
}

void HandsRun::RemoveSite(std::size_t s, bool kill) {
  SimulatedController& site = *sites_[s];
  site.Halt(false);
  std::erase_if(pauses_, [s](const Pause& pause) {
    return pause.site == s;
  });
  if (kill) {
    session_.Kill(site.member());
  } else {
    session_.Leave(site.member());
  }
  ++tally_[kill ? "controllers killed" : "controllers ended"];
  Log(site.name() + (kill ? " is killed" : " leaves"));
  if (site.rig() != nullptr) site.rig()->End();
  joins_ms_.push_back(ms_ + rng_.Whole(100, 4000));
}

void HandsRun::PauseController(std::size_t s) {
  if (!sites_[s]->running()) return;
  const std::int64_t lasts_ms = rng_.Chance(0.6) ? rng_.Whole(3, 60) : rng_.Whole(60, 2500);
  sites_[s]->Halt(true);
  pauses_.push_back({s, ms_ + lasts_ms});
  ++tally_["controller pauses"];
  Log(sites_[s]->name() + Text(" stands still for %lld ms", static_cast<long long>(lasts_ms)));
}

void HandsRun::FailDevice(std::size_t s) {
  SimulatedDeviceProcess& rig = *sites_[s]->rig();
  const std::int64_t lasts_ms = rng_.Whole(1, 400);
  const double what = rng_.Uniform(0, 1);
  const bool halts = what < 0.35;
  if (halts) {
    ++tally_["device pauses"];
    rig.Halt(now_ns() + lasts_ms * 1'000'000, rng_.Chance(0.2));
  } else if (what < 0.55) {
    rig.hand().fails = true;
  } else if (what < 0.75) {
    rig.hand().nonsense = true;
  } else {
    rig.hand().pressed = true;
  }
  if (!halts) ++tally_[what < 0.75 ? "driver failures" : "stop buttons"];
  trouble_until_ms_[s] = ms_ + lasts_ms;
  Log(sites_[s]->name() + ": its device is in trouble");
}

void HandsRun::EndDeviceFailures() {
  for (auto& [s, until_ms] : trouble_until_ms_) {
    if (until_ms > ms_) continue;
    ModelledHand& hand = sites_[s]->rig()->hand();
    hand.fails = hand.nonsense = hand.pressed = false;
  }
}

void HandsRun::AddHosts() {
  for (const auto& site : sites_) {
    if (!site->present()) continue;
    const auto count =
        static_cast<std::size_t>(std::ranges::count_if(hosts_, [&](const auto& host) {
          return &host->site() == site.get();
        }));
    if (count >= kMostHosts || !rng_.Chance(count == 0 ? 0.3 : 0.02)) continue;
    const HostId id = next_host_++;
    hosts_.push_back(std::make_unique<SimulatedHost>(id, "host-" + std::to_string(id), *site,
                                                     schedule_.seed * 1000 + id, tally_));
  }
}

void HandsRun::EndAll() {
  Log("all is tidied up");
  for (const Pause& pause : pauses_) sites_[pause.site]->Halt(false);
  pauses_.clear();
  for (auto& [s, until_ms] : trouble_until_ms_) until_ms = ms_;
  EndDeviceFailures();
  for (const auto& site : sites_) {
    if (!site->present()) continue;
    if (site->rig() != nullptr) site->rig()->hand().Rest();
    const HostId id = next_host_++;
    hosts_.push_back(std::make_unique<SimulatedHost>(id, "tidy", *site, id, tally_));
  }
  for (const auto& host : hosts_) host->TidyUp();
  for (std::size_t p = 0; p < schedule_.peers.size(); ++p) {
    for (std::size_t q = 0; q < schedule_.peers.size(); ++q) {
      if (p != q) SwitchLink(p, q, {.delay_ms = schedule_.delay_ms[p][q]});
    }
  }
}

}  // namespace tandem
