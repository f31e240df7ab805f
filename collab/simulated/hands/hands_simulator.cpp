#include "collab/simulated/hands/hands_simulator.h"

#include <algorithm>
#include <functional>
#include <utility>

#include "collab/simulated/hands/hands_run.h"

namespace tandem {

namespace {

constexpr PeerId kHandsViewer = 7;
constexpr std::int64_t kHandsBeginNs = 1'000'000'000;  // true time of the first frame
constexpr std::int64_t kTidyMs = 8000;                 // end of a session, in which all comes to
                                                       // rest
constexpr std::int64_t kLongestTidyMs = 30'000;
constexpr std::int64_t kHandsQuietMs = 2000;
constexpr std::int64_t kStillMs = 500;  // time before the end in which nothing may move
constexpr double kStill = 1e-4;         // m
constexpr double kStillStep = 1e-6;     // m a frame
constexpr std::int64_t kHandsDigestFrames = 10;
// goals may turn instances at 4 rad/s, so on a longer loop the instance has moved on from its copy
constexpr SessionChecker::Bounds kHandBounds{.fast = true, .short_loop = 0.02, .kept = 10};
constexpr std::int64_t kNewsNs = 3'000'000'000;

}  // namespace

HandsRun::HandsRun(std::uint64_t seed, double seconds,
                   const std::shared_ptr<const WorldModel>& model, const SeedLog& log)
    : rng_(seed),
      schedule_(DrawHandsSchedule(seed, rng_)),
      model_(model),
      log_(log),
      events_end_ms_(static_cast<std::int64_t>(1e3 * seconds) - kTidyMs),
      checker_(schedule_, *model, kHandsViewer, kHandBounds),
      session_(seed),
      member_(schedule_.peers.size(), -1) {
  viewer_link_ = session_.network().Join(kHandsViewer, Role::kViewer, viewer_);
  session_.network().SetWatch(&checker_);
  holders_.of.resize(model->bodies.size());
  const std::int64_t first = rng_.Whole(2, 3);
  for (std::int64_t p = 0; p < first; ++p) joins_ms_.push_back(rng_.Whole(0, 400));
}

SeedResult HandsRun::Run() {
  const auto round_trip_ms = static_cast<std::int64_t>(schedule_.LongestRoundTripMs());
  std::int64_t rest_ms = -1;  // time since which all is at rest
  std::vector<Pose> before;   // poses of all bodies at all sites
  for (;; ++ms_) {
    Frame();
    if (ms_ < events_end_ms_) continue;
    if (ms_ == events_end_ms_) EndAll();
    const bool waited = ms_ - events_end_ms_ > kLongestTidyMs;
    const bool at_rest = AllAtRest();
    if (rest_ms < 0 && waited) checker_.NeverAtRest();
    if (rest_ms < 0 ? waited || at_rest : !waited && !at_rest) rest_ms = ms_;
    if (rest_ms < 0) continue;
    const std::int64_t end_ms = rest_ms + kHandsQuietMs + 4 * round_trip_ms;
    if (ms_ == end_ms - kStillMs) before = Poses();
    if (ms_ < end_ms) continue;
    const std::vector<Pose> poses = Poses();
    for (std::size_t i = 0; i < poses.size(); ++i) {
      const double moved = (poses[i].p - before[i].p).norm();
      if (moved <= kStill) continue;
      checker_.violations().Add("a body moves though all is quiet", 0,
                                Text("by %.3f mm", 1e3 * moved));
    }
    CheckEnd();
    break;
  }
  SeedResult result;
  result.seed = schedule_.seed;
  result.broken = checker_.violations().all();
  result.digest = digest_.value();
  result.peer_seconds = peer_seconds_;
  result.seconds = 1e-3 * static_cast<double>(ms_ + 1);
  result.tally = tally_;
  return result;
}

std::vector<Pose> HandsRun::Poses() const {
  std::vector<Pose> poses;
  for (const auto& site : sites_) {
    for (std::size_t b = 0; site->present() && b < model_->bodies.size(); ++b) {
      poses.push_back(site->node().world().state(b).X_WB);
    }
  }
  return poses;
}

void HandsRun::Frame() {
  checker_.SetTime(now_ns() - kHandsBeginNs);
  if (ms_ < events_end_ms_) RunDueEvents();
  std::vector<std::string> names;
  for (const auto& site : sites_) {
    if (site->present()) names.push_back(site->name());
  }
  for (const auto& host : hosts_) host->Frame(now_ns(), names);
  std::erase_if(hosts_, [](const auto& host) {
    return host->gone() || !host->site().present();
  });
  for (const auto& site : sites_) site->BeforeFrame();
  Step();
  SeeHolders();
  for (const auto& site : sites_) site->AfterFrame(holders_);
  for (std::size_t p = 0; p < sites_.size(); ++p) {
    // sites have the order of the scheduled peers
    if (sites_[p]->running())
      checker_.RenderedForces(p, sites_[p]->node().peer().telemetry().rendered().F_D_W);
  }
  checker_.Check(session_);
  for (const auto& site : sites_) {
    if (site->present()) peer_seconds_ += 1e-3;
  }
  if (ms_ % kHandsDigestFrames == 0) Digest();
  for (; log_ && reported_ < checker_.violations().all().size(); ++reported_) {
    log_("   BROKEN " + checker_.violations().all()[reported_]);
  }
}

void HandsRun::Step() {
  // the session's frame lies within the wait of a device for its controller's answer
  const std::int64_t due_ns = now_ns();
  bool stepped = false;
  const std::function<void()> step = [&] {
    if (!std::exchange(stepped, true)) session_.Step();
  };
  for (const auto& site : sites_) {
    if (site->rig() != nullptr) site->rig()->Tick(due_ns, step);
  }
  step();
}

void HandsRun::SeeHolders() {
  TrueHolders seen;
  seen.of.resize(model_->bodies.size());
  std::vector<bool> running;
  for (const auto& site : sites_) {
    running.push_back(site->running());
    if (!site->present()) continue;
    const int held = site->node().peer().ownership().held();
    if (held >= 0) seen.of[static_cast<std::size_t>(held)].push_back(site->id());
  }
  for (std::vector<PeerId>& holders : seen.of) std::ranges::sort(holders);
  if (seen.of != holders_.of || running != running_) holders_.since_ns = now_ns();
  holders_.of = std::move(seen.of);
  holders_.known_after_ns = kNewsNs + 2 * session_.network().LongestWay();
  running_ = std::move(running);
}

void HandsRun::Digest() {
  for (const auto& site : sites_) {
    for (std::size_t b = 0; b < model_->bodies.size(); ++b) {
      const Pose& X = site->node().world().state(b).X_WB;
      for (int i = 0; i < 4; ++i) digest_.Add(X.q.coeffs()[i]);
      for (int i = 0; i < 3; ++i) digest_.Add(X.p[i]);
    }
    if (site->rig() == nullptr) continue;
    for (int i = 0; i < 3; ++i) digest_.Add(site->rig()->hand().given().f[i]);
  }
}

bool HandsRun::AllAtRest() {
  // a body that others have put down moves home at 50 mm/s where it was pushed (RemoteBodies)
  std::vector<Pose> poses = Poses();
  bool still = poses.size() == last_poses_.size();
  for (std::size_t i = 0; still && i < poses.size(); ++i) {
    still = (poses[i].p - last_poses_[i].p).norm() < kStillStep;
  }
  last_poses_ = std::move(poses);
  return still && std::ranges::all_of(sites_, [](const auto& site) {
           return !site->present() || (site->at_rest() && !site->stopped());
         });
}

void HandsRun::CheckEnd() {
  checker_.CheckEnd(session_, member_, viewer_);
}

SeedResult SimulateHands(std::uint64_t seed, double seconds,
                         const std::shared_ptr<const WorldModel>& model, const SeedLog& log) {
  return HandsRun(seed, seconds, model, log).Run();
}

std::vector<SeedResult> SimulateHandSeeds(std::uint64_t first, std::uint64_t count,
                                          unsigned threads, double seconds,
                                          const std::shared_ptr<const WorldModel>& model,
                                          const SeedLog& log) {
  return RunSeeds(first, count, threads, [&](std::uint64_t seed) {
    return SimulateHands(seed, seconds, model, log);
  });
}

}  // namespace tandem
