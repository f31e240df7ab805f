#include "collab/lab/metrics/metrics.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/world/world.h"

namespace tandem {

namespace {

constexpr int kBinFrames = 50;
constexpr double kBin = kBinFrames * kFrame;
constexpr double kTooFar = 0.5;         // m
constexpr double kSettled = 2e-3;       // m from the last distance
constexpr double kStill = 1e-4;         // m/s
constexpr double kCalm = 2e-3;          // m/s
constexpr double kLeastSquare = 1e-24;  // m^2/s^2, for instances at rest
constexpr int kLeastWindows = 5;

/// Returns a twist's square as a speed: v.v + w.(I/m)w.
double SquareOf(const Vec3& v, const Vec3& w_B, const Inertia& body) {
  return v.squaredNorm() + w_B.dot(body.I_B * w_B) / body.mass;
}

Vec3 InBody(const RigidState& state) {
  return state.X_WB.q.conjugate() * state.V_WB.w;
}

bool IsNumber(const RigidState& state) {
  return state.X_WB.p.allFinite() && state.X_WB.q.coeffs().allFinite() &&
         state.V_WB.v.allFinite() && state.V_WB.w.allFinite();
}

}  // namespace

bool Observe(const Peer& peer, std::int64_t now_ns, UserFrame& out) {
  const RigidState* state = peer.held_state();
  const SharedBody* shared = peer.shared();
  out.present = state != nullptr && shared != nullptr;
  if (!out.present) return false;
  const StepReport& report = peer.report();
  out.state = *state;
  out.coupled = shared->coupled();
  out.ground_damping = shared->ground_damping();
  out.link_count = shared->Links(now_ns, out.links);
  for (std::size_t i = 0; i < out.link_count; ++i) out.links_B_W[i] = report.links_B_W[i];
  out.felt_W = peer.telemetry().rendered().F_D_W;
  out.guarded_frames = peer.guard().guarded();
  out.trapped = peer.separation().trapped();
  out.pushing = report.pushing_points > 0;
  return true;
}

const char* NameOf(Verdict verdict) {
  switch (verdict) {
    case Verdict::kStable:
      return "stable";
    case Verdict::kUnstable:
      return "unstable";
    case Verdict::kUndecided:
      break;
  }
  return "undecided";
}

Verdict Judge(const Metrics& metrics) {
  if (metrics.diverged) return Verdict::kUnstable;
  if (metrics.windows < kLeastWindows) return Verdict::kUndecided;
  if (metrics.growth > 0 && metrics.tail_rms > kStill) return Verdict::kUnstable;
  if (!(metrics.tail_rms > kCalm)) return Verdict::kStable;
  // a motion held up by its limits has a growth of nearly zero, of either sign
  const double measured_s = 2.0 / 3.0 * kFrame * static_cast<double>(metrics.frames);
  return metrics.growth * measured_s < -M_LN2 ? Verdict::kUndecided : Verdict::kUnstable;
}

bool DecaysAboveRest(const Metrics& metrics) {
  return !metrics.diverged && metrics.windows >= kLeastWindows && metrics.growth < 0 &&
         metrics.tail_rms > kCalm;
}

Meter::Meter(const Inertia& body, double tau_s, double judged_from_s)
    : body_(body), tau_s_(tau_s), judged_from_s_(judged_from_s) {}

void Meter::SeeOpening(std::span<const UserFrame> users) {
  for (const UserFrame& user : users) AddWork(user);
}

void Meter::See(std::span<const UserFrame> users) {
  last_.resize(users.size());
  if (running_.frames % kBinFrames == 0) bins_.emplace_back();
  Bin& bin = bins_.back();
  ++bin.frames;
  bool trapped = false;
  for (const UserFrame& user : users) {
    if (!user.present) continue;
    AddWork(user);
    trapped = trapped || user.trapped;
    running_.diverged = running_.diverged || !IsNumber(user.state);
  }
  running_.trapped_frames += trapped ? 1 : 0;
  SeeVelocities(users, bin);
  SeeDistances(users, bin);
  SeeForces(users, bin);
  ++running_.frames;
}

void Meter::AddWork(const UserFrame& user) {
  if (!user.present) return;
  const Twist& V = user.state.V_WB;
  double power = -user.ground_damping * SquareOf(V.v, InBody(user.state), body_);
  for (std::size_t i = 0; i < user.link_count; ++i) {
    power += user.links_B_W[i].f.dot(V.v) + user.links_B_W[i].tau.dot(V.w);
  }
  work_ += kFrame * power;
  running_.generated_J = std::max(running_.generated_J, work_);
}

void Meter::SeeVelocities(std::span<const UserFrame> users, Bin& bin) {
  Vec3 v = Vec3::Zero();
  Vec3 w = Vec3::Zero();
  double present = 0;
  for (const UserFrame& user : users) {
    if (!user.present) continue;
    v += user.state.V_WB.v;
    w += user.state.V_WB.w;
    present += 1;
  }
  if (present == 0) return;
  v /= present;
  w /= present;
  for (const UserFrame& user : users) {
    if (!user.present) continue;
    const RigidState& state = user.state;
    bin.all += SquareOf(state.V_WB.v, InBody(state), body_);
    const Vec3 turning = state.X_WB.q.conjugate() * (state.V_WB.w - w);
    bin.relative += SquareOf(state.V_WB.v - v, turning, body_);
  }
  if (users.size() < 2 || !users[0].present || !users[1].present) return;
  const Vec3 between = users[0].state.V_WB.v - users[1].state.V_WB.v;
  const Vec3 low = low_.Pass(between);
  const Vec3 high = high_.Pass(between);
  if (kFrame * static_cast<double>(running_.frames) < judged_from_s_) return;
  low_squares_ += low.squaredNorm();
  high_squares_ += high.squaredNorm();
  ++band_frames_;
}

void Meter::SeeDistances(std::span<const UserFrame> users, Bin& bin) {
  double square = 0;
  for (std::size_t i = 0; i < users.size(); ++i) {
    if (!users[i].present) continue;
    for (std::size_t j = 0; j < i; ++j) {
      if (!users[j].present) continue;
      const Pose& X = users[i].state.X_WB;
      const Pose& Y = users[j].state.X_WB;
      square = std::max(square, (X.p - Y.p).squaredNorm());
      half_turn_sine_ = std::max(half_turn_sine_, (X.q.conjugate() * Y.q).vec().squaredNorm());
    }
  }
  const double apart = std::sqrt(square);
  bin.apart += apart;
  bin.farthest = std::max(bin.farthest, apart);
  bin.nearest = bin.frames == 1 ? apart : std::min(bin.nearest, apart);
  running_.peak_apart = std::max(running_.peak_apart, apart);
  running_.diverged = running_.diverged || !(apart < kTooFar);
}

void Meter::SeeForces(std::span<const UserFrame> users, Bin& bin) {
  for (std::size_t i = 0; i < users.size(); ++i) {
    const UserFrame& user = users[i];
    Last& last = last_[i];
    if (!user.present) {
      last.known = false;
      continue;
    }
    Vec3 links = Vec3::Zero();
    bool clipped = false;
    for (std::size_t k = 0; k < user.link_count; ++k) {
      const LinkView& link = user.links[k];
      links += user.links_B_W[k].f;
      clipped = clipped || link.clipped;
      bin.links += 1;
      bin.stiffness += link.stiffness;
      bin.loop_age += link.loop_age_s;
      bin.te += link.te_s;
      running_.link_force = std::max(running_.link_force, user.links_B_W[k].f.norm());
      if (kFrame * static_cast<double>(running_.frames) < 1.0) continue;
      least_stiffness_ = std::min(least_stiffness_, link.stiffness);
    }
    running_.peak_force = std::max(running_.peak_force, user.felt_W.f.norm());
    if (last.known) {
      running_.peak_force_rate =
          std::max(running_.peak_force_rate, (user.felt_W.f - last.felt).norm() / kFrame);
      running_.link_force_rate =
          std::max(running_.link_force_rate, (links - last.links).norm() / kFrame);
      guarded_ += user.guarded_frames > last.guarded_frames ? 1 : 0;
    }
    ++user_frames_;
    clipped_ += clipped ? 1 : 0;
    last = {user.felt_W.f, links, true, user.guarded_frames};
  }
}

void Meter::FindGrowth(Metrics& out) const {
  const auto window = static_cast<std::size_t>(std::lround(std::max(0.5, 4.0 * tau_s_) / kBin));
  const std::size_t step = std::max<std::size_t>(1, window / 2);
  double n = 0, st = 0, sy = 0, stt = 0, sty = 0;
  const auto judged_from = static_cast<std::size_t>(std::ceil(judged_from_s_ / kBin));
  const std::size_t first = std::max(bins_.size() / 3, judged_from);
  for (std::size_t from = first; from + window <= bins_.size(); from += step) {
    double sum = 0;
    double frames = 0;
    for (std::size_t i = from; i < from + window; ++i) {
      sum += bins_[i].relative;
      frames += bins_[i].frames;
    }
    const double t = kBin * static_cast<double>(from);
    const double y = 0.5 * std::log(std::max(kLeastSquare, sum / frames));
    n += 1, st += t, sy += y, stt += t * t, sty += t * y;
  }
  out.windows = static_cast<int>(n);
  if (n >= 2) out.growth = (n * sty - st * sy) / (n * stt - st * st);
}

double Meter::SettleTime(double last_apart) const {
  // the last bin that is not within bounds ends the settling time
  for (std::size_t i = bins_.size(); i > 0; --i) {
    const Bin& bin = bins_[i - 1];
    const bool near = bin.farthest < last_apart + kSettled && bin.nearest > last_apart - kSettled;
    if (near) continue;
    if (i == bins_.size()) return std::numeric_limits<double>::quiet_NaN();
    return std::max(0.0, kBin * static_cast<double>(i) - judged_from_s_);
  }
  return 0;
}

Metrics Meter::Finish() const {
  Metrics out = running_;
  FindGrowth(out);
  const auto sum = [this](std::size_t last_bins, double Bin::*what) {
    double total = 0;
    for (std::size_t i = bins_.size() - std::min(last_bins, bins_.size()); i < bins_.size(); ++i) {
      total += bins_[i].*what;
    }
    return total;
  };
  const auto frames_of = [this](std::size_t last_bins) {
    double total = 0;
    for (std::size_t i = bins_.size() - std::min(last_bins, bins_.size()); i < bins_.size(); ++i) {
      total += bins_[i].frames;
    }
    return std::max(1.0, total);
  };
  const std::size_t tail = std::max<std::size_t>(1, bins_.size() / 10);
  out.tail_rms = std::sqrt(sum(tail, &Bin::all) / frames_of(tail));
  constexpr std::size_t kSecond = 1000 / kBinFrames;
  out.last_apart = sum(kSecond, &Bin::apart) / frames_of(kSecond);
  out.settle_s = SettleTime(out.last_apart);
  out.peak_turn = 2.0 * std::asin(std::min(1.0, std::sqrt(half_turn_sine_)));
  if (band_frames_ > 0) {
    out.band_low_rms = std::sqrt(low_squares_ / static_cast<double>(band_frames_));
    out.band_high_rms = std::sqrt(high_squares_ / static_cast<double>(band_frames_));
  }
  const double all = std::max(1.0, static_cast<double>(user_frames_));
  out.guarded_share = static_cast<double>(guarded_) / all;
  out.clip_share = static_cast<double>(clipped_) / all;
  const double links = std::max(1.0, sum(kSecond, &Bin::links));
  out.stiffness = sum(kSecond, &Bin::stiffness) / links;
  out.loop_age_s = sum(kSecond, &Bin::loop_age) / links;
  out.te_s = sum(kSecond, &Bin::te) / links;
  out.least_stiffness = std::isfinite(least_stiffness_) ? least_stiffness_ : 0.0;
  return out;
}

}  // namespace tandem
