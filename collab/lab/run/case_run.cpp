#include "collab/lab/run/case_run.h"

#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include "collab/lab/case/case_parts.h"
#include "collab/lab/metrics/metrics_table.h"
#include "collab/simulated/network/simulated_session.h"
#include "engine/base/hash.h"
#include "engine/base/units.h"
#include "engine/haptics/scripted_device.h"

namespace tandem {

namespace {

constexpr int kLongestOpening = 8000;  // frames until all loops are closed
constexpr int kDigestFrames = 10;      // between two states in the digest
constexpr int kMostLengths = 4;        // for a run that decays and is not at rest, in test.Lasts()
constexpr double kSamplesInReserve = 64;
constexpr double kDelayInReserve = 0.1;  // s

/// Returns how many samples may be under way to one user.
std::size_t MostWaiting(const LabCase& test) {
  const double others = static_cast<double>(test.users - 1);
  const double copies = 1.3;  // room for duplicates and bursts
  return static_cast<std::size_t>(kSamplesInReserve + copies * others * test.publish_hz *
                                                          (LongestDelay(test) + kDelayInReserve));
}

PeerId IdOf(std::size_t user) {
  return 1 + user;
}

std::unique_ptr<PeerNode> UserOf(const LabCase& test, const LabScene& scene,
                                 const std::shared_ptr<const CouplingLaw>& law, std::size_t user) {
  NodeOptions options;
  options.peer.id = IdOf(user);
  options.peer.held_object = static_cast<int>(scene.object);
  const HandScript script = ScriptOf(test, user);
  options.peer.X_BD = script.X_BD;
  options.peer.wait_for = test.users - 1;
  options.peer.law = law;
  options.peer.experiments.energy_gate = test.law.gate;
  options.peer.experiments.exchange_forces = test.law.exchange_forces;
  options.name = std::to_string(IdOf(user));
  options.publish_hz = test.publish_hz;
  options.waiting = MostWaiting(test);
  const auto body = static_cast<std::size_t>(scene.model->body_index[scene.object]);
  auto device = std::make_unique<ScriptedDevice>(script, scene.model->bodies[body].X_WB0);
  return std::make_unique<PeerNode>(scene.model, std::move(device), 1, options);
}

/// A running case.
class Run {
 public:
  Run(const LabCase& test, const LabScene& scene, const std::shared_ptr<const CouplingLaw>& law)
      : test_(test), session_(test.seed), frames_(test.users) {
    // senders with equal phases would show that one phase only
    std::mt19937_64 random(test.seed);
    for (std::size_t user = 0; user < test.users; ++user) {
      session_.Add(UserOf(test, scene, law, user), IdOf(user));
      SetDelay(user, test.delay_s);
      const auto later = random() % kMostLater;
      if (user + 1 == test.users) break;
      for (std::uint64_t i = 0; i < later; ++i) session_.Step();
    }
  }

  /// Steps all users by one frame and returns what they show.
  std::span<const UserFrame> Step() {
    session_.Step();
    for (std::size_t user = 0; user < frames_.size(); ++user) {
      const std::int64_t now_ns = session_.network().LocalNow(IdOf(user));
      Observe(session_.node(user).peer(), now_ns, frames_[user]);
    }
    return frames_;
  }

  bool Closed() {
    for (std::size_t user = 0; user < frames_.size(); ++user) {
      const UserFrame& frame = frames_[user];
      if (!frame.present || frame.coupled + 1 < frames_.size()) return false;
      if (!session_.node(user).peer().started_ns()) return false;
    }
    return true;
  }

  /// Applies the schedule's steps that are due in the coming frame.
  void Obey(double t_s) {
    while (next_step_ < test_.network.schedule.size() &&
           test_.network.schedule[next_step_].at_s <= t_s) {
      const LabNetwork::Step& step = test_.network.schedule[next_step_++];
      for (std::size_t user = 0; user < frames_.size(); ++user) {
        SetDelay(user, step.delay_s);
        for (std::size_t other = 0; other < frames_.size(); ++other) {
          if (other != user) session_.network().Cut(IdOf(user), IdOf(other), step.cut);
        }
      }
    }
  }

  /// Returns whether an inbox dropped samples for lack of room, which the case's network does not
  /// do.
  bool Overflowed() {
    for (std::size_t user = 0; user < frames_.size(); ++user) {
      if (session_.node(user).inbox().overflows() > 0) return true;
    }
    return false;
  }

  double simulated_s() const { return ToSeconds(session_.now_ns()) - 1.0; }

 private:
  static constexpr std::uint64_t kMostLater = 10;  // frames

  void SetDelay(std::size_t user, double delay_s) {
    for (std::size_t other = 0; other < frames_.size(); ++other) {
      if (other == user) continue;
      session_.node(user).inbox().Switch(IdOf(other), ConditionsOf(test_, other, user, delay_s));
    }
  }

  const LabCase& test_;
  SimulatedSession session_;
  std::vector<UserFrame> frames_;
  std::size_t next_step_ = 0;
};

void AddTo(Hash64& hash, const RigidState& state) {
  for (const double x : {state.X_WB.p.x(), state.X_WB.p.y(), state.X_WB.p.z()}) hash.Add(x);
  for (int i = 0; i < 4; ++i) hash.Add(state.X_WB.q.coeffs()[i]);
  for (int i = 0; i < 3; ++i) hash.Add(state.V_WB.v[i]);
  for (int i = 0; i < 3; ++i) hash.Add(state.V_WB.w[i]);
}

void AddTo(Hash64& hash, const Metrics& metrics) {
  for (const MetricField& field : MetricFields()) {
    std::visit(
        [&](auto member) {
          hash.Add(static_cast<double>(metrics.*member));
        },
        field.member);
  }
}

bool GoesOn(const Metrics& metrics, const RunLength& on) {
  if (on.rest_m_s <= 0) return DecaysAboveRest(metrics);
  return Judge(metrics) != Verdict::kStable || !(metrics.tail_rms < on.rest_m_s);
}

}  // namespace

CaseResult RunCase(const LabCase& given, const LabScene& scene, const SeriesSink& series,
                   const RunLength& on) {
  CaseResult result;
  const LabCase test = FittedTo(scene.inertia(), given);
  const auto law = LawOf(test.law);
  if (!law) {
    result.fault = law.error();
    return result;
  }
  Meter meter(scene.inertia(), test.MeanPathLength(), LastInputEnds(test));
  Run run(test, scene, *law);
  int opening = 0;
  do {
    meter.SeeOpening(run.Step());
    if (++opening > kLongestOpening) {
      result.fault = Error{"the loops between the users do not close within 8 s"};
      return result;
    }
  } while (!run.Closed());

  const auto length = std::llround(test.Duration() / kFrame);
  const std::int64_t lengths =
      on.most_s > 0 ? std::llround(std::ceil(on.most_s / test.Duration())) : kMostLengths;
  const std::int64_t most = length * (test.seconds > 0 ? 1 : lengths);
  Hash64 hash;
  std::int64_t frame = 0;
  for (std::int64_t end = length; end <= most; end += length) {
    for (; frame < end && !meter.diverged(); ++frame) {
      const double t_s = kFrame * static_cast<double>(frame);
      if (frame < length) run.Obey(t_s);
      const std::span<const UserFrame> users = run.Step();
      meter.See(users);
      if (series) series(t_s, users);
      if (frame % kDigestFrames != 0) continue;
      for (const UserFrame& user : users) {
        if (user.present) AddTo(hash, user.state);
      }
    }
    result.metrics = meter.Finish();
    if (!GoesOn(result.metrics, on)) break;
  }
  if (run.Overflowed()) result.fault = Error{"samples under way found no room"};
  AddTo(hash, result.metrics);
  result.verdict = Judge(result.metrics);
  result.digest = hash.value();
  result.simulated_s = run.simulated_s();
  return result;
}

}  // namespace tandem
