#include "collab/lab/run/press_run.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <vector>

#include "collab/simulated/network/simulated_session.h"
#include "engine/base/check.h"
#include "engine/haptics/scripted_device.h"

namespace tandem {

namespace {

constexpr std::size_t kUsers = 2;
constexpr std::size_t kJudgedFrames = 3000;
constexpr std::size_t kStroke = 1000;   // frames from one knock to the next
constexpr int kLongestMeeting = 20000;  // frames

/// Returns a move by `by` that begins at `from`, s.
std::vector<Waypoint> Shift(double from, double by, double seconds) {
  return {{0, Vec3::Zero(), Quat::Identity()},
          {from, Vec3::Zero(), Quat::Identity()},
          {from + seconds, Vec3(by, 0, 0), Quat::Identity()}};
}

/// Returns a way to and fro, from 30 mm back to 10 mm beyond the face of the other body.
std::vector<Waypoint> Knocks(double from, double seconds) {
  std::vector<Waypoint> way{{0, Vec3::Zero(), Quat::Identity()},
                            {from, Vec3::Zero(), Quat::Identity()}};
  for (double t = from + 1; t < from + seconds + 1; t += 1) {
    way.push_back({t - 0.5, Vec3(-0.03, 0, 0), Quat::Identity()});
    way.push_back({t, Vec3(kPressGap + 0.01, 0, 0), Quat::Identity()});
  }
  return way;
}

/// Returns when the hands begin to move, s from their start; the loops are closed by then.
double StartOf(const PressCase& test) {
  return 0.5 + 3e-3 * (test.conditions.delay_ms + test.conditions.jitter_ms);
}

HandScript ScriptOf(const PressCase& test, std::size_t user, double seconds) {
  HandScript script;
  const bool first = user == 0;
  const double from = StartOf(test);
  switch (test.motion) {
    case PressMotion::kPress:
      script.waypoints = Shift(from, first ? kPressTravel : -kPressTravel, 0.5);
      break;
    case PressMotion::kPush:
      if (first) script.waypoints = Shift(from, kPushTravel, 0.8);
      if (!first) script.impedance.stiffness = 0;
      break;
    case PressMotion::kTap:
      if (first) script.waypoints = Knocks(from, seconds);
      if (!first) script.impedance.stiffness = 400;
      break;
  }
  return script;
}

std::unique_ptr<PeerNode> NodeOf(const PressCase& test,
                                 const std::shared_ptr<const WorldModel>& model, std::size_t user,
                                 double seconds) {
  const LinkConditions& link = test.conditions;
  NodeOptions options;
  options.peer.id = 1 + user;
  options.peer.held_object = static_cast<int>(model->object[user]);
  options.peer.wait_for = 1;
  options.peer.experiments.mirror = test.mirror;
  options.publish_hz = test.publish_hz;
  options.name = std::to_string(1 + user);
  options.conditions = link;
  options.conditions.seed = link.seed + user;
  options.waiting = 64 + static_cast<std::size_t>(1.3 * test.publish_hz *
                                                  (0.1 + 1e-3 * (link.delay_ms + link.jitter_ms)));
  auto device =
      std::make_unique<ScriptedDevice>(ScriptOf(test, user, seconds), model->bodies[user].X_WB0);
  return std::make_unique<PeerNode>(model, std::move(device), 42, options);
}

/// One user's motion, frame by frame.
struct Trajectory {
  std::vector<double> x;      // m
  std::vector<double> speed;  // m/s
  std::vector<double> force;  // N
  std::vector<bool> touches;
};

/// Returns the root mean square over the judged frames.
template <typename Value>
double SpreadOf(std::size_t end, Value value) {
  double sum = 0;
  for (std::size_t i = end - kJudgedFrames; i < end; ++i) sum += value(i) * value(i);
  return std::sqrt(sum / static_cast<double>(kJudgedFrames));
}

double MeanOf(const std::vector<double>& values) {
  const auto from = values.end() - static_cast<std::ptrdiff_t>(kJudgedFrames);
  return std::accumulate(from, values.end(), 0.0) / static_cast<double>(kJudgedFrames);
}

void JudgeCourse(const Trajectory& course, bool strokes, PressResult& result) {
  const std::size_t end = course.x.size();
  const double mean_x = MeanOf(course.x);
  const double mean_force = MeanOf(course.force);
  int touches = 0;
  for (std::size_t i = end - kJudgedFrames; i < end; ++i) {
    touches += course.touches[i] && !course.touches[i - 1] ? 1 : 0;
  }
  const auto raise = [](double& worst, double value) {
    worst = std::max(worst, value);
  };
  raise(result.unrest, SpreadOf(end, [&](std::size_t i) {
          return course.x[i] - (strokes ? course.x[i - kStroke] : mean_x);
        }));
  raise(result.speed, SpreadOf(end, [&](std::size_t i) {
          return course.speed[i];
        }));
  raise(result.mean_force, mean_force);
  raise(result.force_std, SpreadOf(end, [&](std::size_t i) {
          return course.force[i] - mean_force;
        }));
  raise(result.touches_per_s, 1e3 * touches / static_cast<double>(kJudgedFrames));
}

}  // namespace

const char* NameOf(PressMotion motion) {
  switch (motion) {
    case PressMotion::kPress:
      return "press";
    case PressMotion::kPush:
      return "push";
    case PressMotion::kTap:
      return "tap";
  }
  return "";
}

const char* NameOf(MirrorModel mirror) {
  switch (mirror) {
    case MirrorModel::kCompliantMirror:
      return "blend";
    case MirrorModel::kHeld:
      return "held";
    case MirrorModel::kDeadReckoned:
      return "dead_reckoned";
  }
  return "";
}

double PressCase::DefaultDuration() const {
  return seconds > 0 ? seconds : std::max(12.0, 0.04 * conditions.delay_ms);
}

Result<PressResult> RunPress(const PressCase& test,
                             const std::shared_ptr<const WorldModel>& model) {
  TANDEM_CHECK(model->bodies.size() == kUsers);
  const double seconds = test.DefaultDuration();
  SimulatedSession session;
  for (std::size_t user = 0; user < kUsers; ++user) {
    session.Add(NodeOf(test, model, user, seconds), 1 + user);
  }
  const auto begun = [&] {
    return session.node(0).peer().started_ns() && session.node(1).peer().started_ns();
  };
  for (int frame = 0; !begun(); ++frame) {
    session.Step();
    if (frame > kLongestMeeting) return Error{"the hands have not begun within 20 s"};
  }

  PressResult result;
  const bool strokes = test.motion == PressMotion::kTap;
  const auto frames = static_cast<std::size_t>(1e3 * (StartOf(test) + seconds));
  TANDEM_CHECK(frames > kJudgedFrames + kStroke);
  std::array<Trajectory, kUsers> courses;
  const double first_way = model->bodies[1].X_WB0.p.x() - model->bodies[0].X_WB0.p.x();
  for (std::size_t i = 0; i < frames; ++i) {
    session.Step();
    for (std::size_t user = 0; user < kUsers; ++user) {
      const Peer& peer = session.node(user).peer();
      Trajectory& course = courses[user];
      course.x.push_back(peer.held_state()->X_WB.p.x());
      course.speed.push_back(peer.held_state()->V_WB.v.norm());
      course.force.push_back(peer.report().hand_B_W.f.norm());
      course.touches.push_back(peer.report().pushing_points > 0);
      result.peak_force = std::max(result.peak_force, course.force.back());
      result.most_lag = std::max(result.most_lag, peer.mirror_lag_m());
    }
    const double gap = courses[1].x.back() - courses[0].x.back() - first_way + kPressGap;
    result.most_overlap = std::max(result.most_overlap, -gap);
  }
  for (const Trajectory& course : courses) JudgeCourse(course, strokes, result);
  result.calm =
      strokes ? result.unrest < PressResult::kSameStroke : result.speed < PressResult::kRestSpeed;
  return result;
}

}  // namespace tandem
