#include "collab/simulated/hands/simulated_host.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "engine/base/units.h"

namespace tandem {

namespace {

constexpr std::int64_t kBeatNs = 50 * kMs;
constexpr double kGoalLoss = 0.02;
constexpr double kTwice = 0.05;  // share of requests that come twice
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

Vec3 PlaceOf(const PlainPose& X) {
  return {X.p_W[0], X.p_W[1], X.p_W[2]};
}

}  // namespace

SimulatedHost::SimulatedHost(HostId id, std::string name, SimulatedController& site,
                             std::uint64_t seed, Tally& tally)
    : id_(id), name_(std::move(name)), site_(&site), rng_(seed), tally_(&tally) {
  site.Attach(id);
  ++(*tally_)["hosts"];
}

void SimulatedHost::Ask(const ControlRequest& request) {
  HostMessage message;
  // reliable, in order
  last_due_ns_ = std::max(last_due_ns_, now_ns_ + rng_.Whole(0, 3) * kMs);
  message.due_ns = last_due_ns_;
  message.host = id_;
  message.name = name_;
  message.number = next_number_++;
  message.request = request;
  ++(*tally_)["requests"];
  if (rng_.Chance(kTwice)) {
    HostMessage again = message;
    again.due_ns += rng_.Whole(0, 50) * kMs;
    site_->Send(std::move(again));
  }
  site_->Send(std::move(message));
}

void SimulatedHost::Say(HostGoal::Kind kind) {
  HostMessage message;
  message.due_ns = now_ns_ + rng_.Whole(0, 2) * kMs;
  message.host = id_;
  message.name = name_;
  message.is_goal = true;
  message.goal = goal_;
  message.goal.kind = kind;
  const bool lost = rng_.Chance(kGoalLoss) && kind != HostGoal::Kind::kGoodbye;
  if (!lost) site_->Send(std::move(message));
}

void SimulatedHost::ReadMail() {
  HostMail mail = site_->TakeMail(id_);
  if (mail.snapshot) seen_ = *mail.snapshot;
  for (const HostAnswer& answer : mail.answers) {
    ++(*tally_)[answer.answer.ok ? "requests done" : "requests refused"];
  }
}

void SimulatedHost::Frame(std::int64_t now_ns, const std::vector<std::string>& peers) {
  now_ns_ = now_ns;
  if (gone_ || now_ns < halted_until_ns_) return;
  if (std::exchange(halted_until_ns_, 0) != 0) site_->HostWoken(id_);
  ReadMail();
  if (now_ns >= next_beat_ns_) {
    next_beat_ns_ = now_ns + kBeatNs;
    Say(goal_.kind == HostGoal::Kind::kPose && goal_.seq > 0 ? HostGoal::Kind::kPose
                                                             : HostGoal::Kind::kBeat);
  }
  if (tidies_) return Tidy();
  if (resume_ns_ != 0 && now_ns >= resume_ns_) {
    resume_ns_ = 0;
    Ask(ResumeRequest{});
  }
  if (drag_ != Drag::kNone && now_ns >= next_goal_ns_) {
    next_goal_ns_ = now_ns + goal_period_ns_;
    SayGoal();
  }
  if (now_ns < next_whim_ns_) return;
  next_whim_ns_ = now_ns + rng_.Whole(30, 1300) * kMs;
  ActAtRandom(peers);
}

void SimulatedHost::Tidy() {
  drag_ = Drag::kNone;
  if (now_ns_ < next_whim_ns_) return;
  next_whim_ns_ = now_ns_ + 400 * kMs;
  if (site_->stopped()) Ask(ResumeRequest{});
  if (!site_->at_rest()) Ask(ReleaseRequest{});
}

void SimulatedHost::ActAtRandom(const std::vector<std::string>& peers) {
  const bool holds = seen_.hand.body >= 0 && seen_.hand.host == id_;
  const bool stopped = seen_.safety.state == SnapshotSafety::State::kStopped;
  if (stopped && rng_.Chance(0.4)) return Ask(ResumeRequest{});
  const double what = rng_.Uniform(0, 1);
  if (holds ? what < 0.45 : what < 0.1) return BeginDrag();
  if (what < 0.52) return GrabRandomBody();
  if (what < 0.60) return Ask(ReleaseRequest{});
  if (what < 0.65) {
    const auto i = static_cast<std::size_t>(rng_.Whole(0, 7));
    return Ask(GiveRequest{.peer = i < peers.size() ? peers[i] : "nobody"});
  }
  if (what < 0.68) return Ask(AskForRequest{.body = RandomBody()});
  if (what < 0.77) return GoBack();
  if (what < 0.82) return SetRandomParameter();
  if (what < 0.84) return Ask(SnapshotRateRequest{rng_.Uniform(0.5, 1100)});
  if (what < 0.87) return SendInvalidRequest();
  if (what < 0.89) {
    ++(*tally_)["emergency stops by hosts"];
    if (rng_.Chance(0.8)) resume_ns_ = now_ns_ + rng_.Whole(50, 1500) * kMs;
    return Ask(EmergencyStopRequest{});
  }
  if (what < 0.91) return Ask(ResumeRequest{});
  if (what < 0.93) {
    drag_ = Drag::kNone;
    return;
  }
  if (what < 0.985) FallSilent();
}

std::string SimulatedHost::RandomBody() {
  static constexpr std::array kNames{"shared", "shared", "left", "right"};
  return kNames[static_cast<std::size_t>(rng_.Whole(0, 3))];
}

void SimulatedHost::GrabRandomBody() {
  GrabRequest grab{.body = RandomBody()};
  std::size_t body = 1;
  while (body < seen_.bodies.size() && grab.body != (body == 1   ? "shared"
                                                     : body == 2 ? "left"
                                                                 : "right")) {
    ++body;
  }
  if (body < seen_.bodies.size() && rng_.Chance(0.7)) {
    const Vec3 p = PlaceOf(seen_.bodies[body].X_WB) + rng_.Place(0.03);
    grab.grasp_W = {{p.x(), p.y(), p.z()}};
  }
  ++(*tally_)["grabs"];
  Ask(grab);
  // the user drags at once, or looks first
  if (rng_.Chance(0.7)) BeginDrag();
}

void SimulatedHost::BeginDrag() {
  ++(*tally_)["drags"];
  static constexpr std::array kRates{60.0, 90.0, 125.0, 250.0, 1000.0};
  goal_period_ns_ = static_cast<std::int64_t>(
      1e9 / kRates[static_cast<std::size_t>(rng_.Whole(0, kRates.size() - 1))]);
  begun_ns_ = now_ns_;
  begun_at_ = PlaceOf(seen_.hand.X_WG);
  glide_speed_ = rng_.Uniform(0.02, 1.5);
  turn_ = rng_.Chance(0.5) ? Quat::Identity() : rng_.Turn(rng_.Chance(0.2) ? 3.0 : 0.5);
  target_ = rng_.Place(0.1);
  const double where = rng_.Uniform(0, 1);
  if (where < 0.25) target_.z() = rng_.Uniform(-0.09, -0.045);  // into the plate
  if (where > 0.6 && seen_.bodies.size() > 3) {                 // into a body
    const auto body = static_cast<std::size_t>(rng_.Whole(1, 3));
    target_ = PlaceOf(seen_.bodies[body].X_WB);
  }
  if (where > 0.93) target_ = rng_.Place(2);  // far away
  const double how = rng_.Uniform(0, 1);
  drag_ = how < 0.3    ? Drag::kJump
          : how < 0.6  ? Drag::kGlide
          : how < 0.7  ? Drag::kCircle
          : how < 0.82 ? Drag::kRate
          : how < 0.94 ? Drag::kPush
                       : Drag::kNonsense;
}

void SimulatedHost::SayGoal() {
  ++goal_.seq;
  goal_.kind = HostGoal::Kind::kPose;
  goal_.X_WG = {turn_, target_};
  goal_.linear.setZero();
  goal_.angular.setZero();
  const double t = ToSeconds(now_ns_ - begun_ns_);
  const Vec3 way = target_ - begun_at_;
  switch (drag_) {
    case Drag::kGlide:
      if (way.norm() > glide_speed_ * t) {
        goal_.X_WG.p = begun_at_ + glide_speed_ * t * way.normalized();
      }
      break;
    case Drag::kCircle:
      goal_.X_WG.p += 0.03 * Vec3(std::cos(10 * t), std::sin(10 * t), 0);
      break;
    case Drag::kRate:
    case Drag::kPush:
      goal_.kind = drag_ == Drag::kRate ? HostGoal::Kind::kRate : HostGoal::Kind::kPush;
      goal_.linear = (drag_ == Drag::kRate ? 3.0 : 150.0) * target_;
      goal_.angular = (drag_ == Drag::kRate ? 10.0 : 1.0) * Vec3(target_.y(), 0, target_.x());
      break;
    case Drag::kNonsense: {
      static constexpr std::array kWrong{kNan, 1e300, 1e9, -2e3,
                                         std::numeric_limits<double>::infinity()};
      const double wrong = kWrong[static_cast<std::size_t>(rng_.Whole(0, kWrong.size() - 1))];
      (rng_.Chance(0.5) ? goal_.X_WG.p : goal_.linear)[rng_.Whole(0, 2)] = wrong;
      if (rng_.Chance(0.2)) goal_.X_WG.q.coeffs() *= 2;
      if (rng_.Chance(0.3)) goal_.kind = HostGoal::Kind::kRate;
      break;
    }
    default:
      break;
  }
  Say(goal_.kind);
  if (drag_ == Drag::kNonsense) drag_ = Drag::kNone;
}

void SimulatedHost::SetRandomParameter() {
  switch (rng_.Whole(0, 7)) {
    case 0:
      return Ask(SetParameterRequest{"hand_force_N", rng_.Uniform(0.05, 31)});
    case 1:
      return Ask(SetParameterRequest{"hand_speed_m_s", rng_.Uniform(0.005, 2.1)});
    case 2:
      return Ask(SetParameterRequest{"hand_smoothing_s", rng_.Uniform(-0.01, 0.21)});
    case 3:
      return Ask(SetParameterRequest{"device_scale", rng_.Uniform(0.3, 1.2)});
    case 4:
      return Ask(SetParameterRequest{"device_clutch", rng_.Chance(0.3) ? 1.0 : 0.0});
    case 5: {
      const Quat q = rng_.Turn(3);
      return Ask(SetViewRequest{{q.x(), q.y(), q.z(), q.w()}});
    }
    default:
      Ask(SetParameterRequest{"hand_force_N", 10});
      return Ask(SetParameterRequest{"hand_speed_m_s", 1});
  }
}

void SimulatedHost::SendInvalidRequest() {
  switch (rng_.Whole(0, 7)) {
    case 0:
      return Ask(GrabRequest{.body = "plate"});
    case 1:
      return Ask(GrabRequest{.body = "no such body"});
    case 2:
      return Ask(GrabRequest{.body = "shared", .grasp_W = {{kNan, 0, 0}}});
    case 3:
      return Ask(GrabRequest{.body = "shared", .grasp_W = {{0, 1e200, 0}}});
    case 4:
      return Ask(SetClearanceRequest{.force_layer = 77, .displacement_m = 0});
    case 5:
      return Ask(SetParameterRequest{"hand_force_N", kNan});
    case 6:
      return Ask(SaveRequest{.file = "/nowhere"});
    default:
      return Ask(LoadSceneRequest{.file = "nothing"});
  }
}

void SimulatedHost::GoBack() {
  ++(*tally_)["ways back"];
  using To = RetraceRequest::To;
  static constexpr std::array kTo{To::kGrasp, To::kUndo, To::kReset};
  drag_ = Drag::kNone;  // a goal would end the way back
  Ask(RetraceRequest{kTo[static_cast<std::size_t>(rng_.Whole(0, 2))]});
  next_whim_ns_ = now_ns_ + rng_.Whole(100, 4000) * kMs;
}

void SimulatedHost::FallSilent() {
  const double how = rng_.Uniform(0, 1);
  if (how < 0.7) {
    ++(*tally_)["host pauses"];
    halted_until_ns_ = now_ns_ + rng_.Whole(20, 1200) * kMs;
    return;
  }
  gone_ = true;
  ++(*tally_)[how < 0.85 ? "host crashes" : "host goodbyes"];
  if (how >= 0.85) Say(HostGoal::Kind::kGoodbye);
  site_->Detach(id_);
}

}  // namespace tandem
