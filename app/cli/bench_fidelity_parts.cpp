#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>

#include "app/cli/bench_fidelity.h"
#include "engine/realtime/clock.h"
#include "engine/world/world.h"

namespace tandem {

namespace {

constexpr double kCapacity = 1e9;  // fidelity is asked for here, not speed

/// A part of models/factory before another that is fixed, in metres.
Scene Factory(ContactModel contact, const std::filesystem::path& models, double voxel,
              const std::string& fixed, const std::string& moving, const Vec3& at, double mass) {
  Scene scene;
  scene.file = models;
  scene.voxel_size = voxel;
  scene.contact = contact;
  scene.force_layer = DefaultForceLayer(contact);
  scene.bodies.resize(2);
  scene.bodies[0].name = fixed;
  scene.bodies[0].mesh = models / "factory" / (fixed + ".obj");
  scene.bodies[0].fixed = true;
  scene.bodies[1].name = moving;
  scene.bodies[1].mesh = models / "factory" / (moving + ".obj");
  scene.bodies[1].X_WM.p = at;
  scene.bodies[1].mass = mass;
  return scene;
}

StepInputs Inputs(const WorldModel& model) {
  StepInputs inputs;
  inputs.bodies.resize(model.bodies.size());
  for (StepInputs::BodyInput& body : inputs.bodies) body.drive = BodyDrive::kSimulated;
  inputs.capacity = kCapacity;
  inputs.hand.body = 0;
  inputs.hand.gains = DefaultHandGains(model.bodies[0].inertia);
  return inputs;
}

/// What of a signal of 1 kHz lies above 20 Hz: Butterworth's filter of second order.
class HighPass {
 public:
  double operator()(double x) {
    const double k = std::tan(std::numbers::pi * 20.0 * kFrame);
    const double norm = 1.0 / (1.0 + std::numbers::sqrt2 * k + k * k);
    const double y = norm * (x - 2 * x_[0] + x_[1]) - 2 * (k * k - 1) * norm * y_[0] -
                     (1 - std::numbers::sqrt2 * k + k * k) * norm * y_[1];
    x_ = {x, x_[0]};
    y_ = {y, y_[0]};
    return y;
  }

 private:
  std::array<double, 2> x_{};
  std::array<double, 2> y_{};
};

/// The share of a force that is felt as buzz: RMS of 20 to 500 Hz over the mean.
class Buzz {
 public:
  /// The filter needs to hear all of the force from its first, or it takes the force that there is
  /// when it begins for a blow; what it says is counted where `counts`.
  void Add(const Vec3& force, bool counts) {
    double square = 0;
    for (int i = 0; i < 3; ++i) {
      const double fast = axes_[static_cast<std::size_t>(i)](force[i]);
      square += fast * fast;
    }
    if (!counts) return;
    squares_ += square;
    sum_ += force.norm();
    ++count_;
  }
  double share() const { return sum_ > 0 ? std::sqrt(squares_ * count_) / sum_ : 0.0; }

 private:
  std::array<HighPass, 3> axes_;
  double squares_ = 0;
  double sum_ = 0;
  double count_ = 0;
};

/// About z, of a body that has been turned from its first orientation, rad in (-pi, pi].
double TurnAboutZ(const Quat& q_from_first) {
  return 2.0 * std::atan2(q_from_first.z(), q_from_first.w());
}

/// 0 to 1 as x goes from 0 to 1, with the least jerk.
double Smooth(double x) {
  const double u = std::clamp(x, 0.0, 1.0);
  return u * u * u * (10 + u * (6 * u - 15));
}

struct Peg {
  const char* hole;
  const char* peg;
  double mass;  // kg, of steel
};

constexpr double kHoleTop = 0.0089916;  // m
constexpr double kInserted = 0.006;     // m below the hole's rim

/// One peg, one hand. Gives how deep the peg's end is in the hole at last, m.
double Insert(const std::shared_ptr<const WorldModel>& model, double start_height,
              std::mt19937_64& random, Buzz& buzz, TimesOfFrames& times) {
  World world(model);
  StepInputs inputs = Inputs(*model);
  // as firm in rotation as a hand (HandImpedance)
  inputs.hand.gains.rotation_stiffness = 3.0 * Mat3::Identity();
  inputs.hand.gains.rotation_damping = 0.03 * Mat3::Identity();
  const Pose X_WB0 = model->bodies[0].X_WB0;
  const double half_length = X_WB0.p.z() - start_height;
  const double heading = Uniform(random, 0, 2 * std::numbers::pi);
  const Vec3 aside = 0.0002 * Vec3(std::cos(heading), std::sin(heading), 0);
  Vec3 axis(Uniform(random, -1, 1), Uniform(random, -1, 1), Uniform(random, -1, 1));
  const Quat askew = RotationBy(0.5 * std::numbers::pi / 180 * axis.normalized());
  const double phase = Uniform(random, 0, 2 * std::numbers::pi);
  // the hand's pose with the peg's end at `end`
  const auto holding = [&](const Vec3& end) {
    return Pose{askew * X_WB0.q, end + askew * Vec3(0, 0, half_length)};
  };
  world.Place(0, holding(Vec3(0, 0, start_height) + aside));
  for (int frame = 0; frame < 3300; ++frame) {
    const double t = kFrame * frame;
    // down until it rests, round and round in search of the hole, then in
    const double searching = std::clamp((t - 0.5) / 1.5, 0.0, 1.0);
    const double entering = Smooth((t - 2.0) / 1.0);
    const double radius = 0.0003 * searching * (1.0 - Smooth((t - 2.0) / 0.5));
    const double turn = phase + 2 * std::numbers::pi * 3.0 * t;
    const double height =
        start_height - (start_height - kHoleTop + 0.001) * Smooth(t / 0.5) - 0.007 * entering;
    inputs.hand.goal.X_WA = holding((1.0 + 5.0 * entering) * aside +
                                    Vec3(radius * std::cos(turn), radius * std::sin(turn), height));
    const TimedFrame done = TimedStep(world, inputs, times);
    buzz.Add(done.report.hand_B_W.f, t > 0.5);
  }
  const Pose& X_WB = world.state(0).X_WB;
  return kHoleTop - (X_WB * Vec3(0, 0, -half_length)).z();
}

}  // namespace

FrameLengths LengthsOf(const TimesOfFrames& times) {
  const auto us = [](const Histogram& ns, double quantile) {
    return 1e-3 * static_cast<double>(ns.Quantile(quantile));
  };
  return {.cpu_p50_us = us(times.stats.cpu(), 0.5),
          .cpu_p99_us = us(times.stats.cpu(), 0.99),
          .wall_p999_us = us(times.stats.wall(), 0.999),
          .frames = times.stats.frames(),
          .over_1ms = times.over_1ms,
          .missed = times.stats.missed()};
}

TimedFrame TimedStep(World& world, const StepInputs& inputs, TimesOfFrames& times) {
  constexpr std::int64_t kPeriodNs = 1'000'000;
  LoopClock& clock = MachineClock();
  const std::int64_t wall = clock.NowNs();
  const std::int64_t cpu = clock.ThreadCpuNs();
  const StepReport& report = world.Step(inputs);
  const std::int64_t cpu_ns = clock.ThreadCpuNs() - cpu;
  const std::int64_t wall_ns = clock.NowNs() - wall;
  times.stats.Add(0, cpu_ns, wall_ns, wall_ns / kPeriodNs);
  times.over_1ms += wall_ns > kPeriodNs ? 1U : 0U;
  return {report, cpu_ns};
}

Result<NutFigures> MeasureNut(ContactModel contact, const std::filesystem::path& models,
                              double voxel) {
  constexpr double kPitch = 0.002;  // m
  constexpr int kTurnFrames = 4000;
  const auto loaded =
      LoadWorld(Factory(contact, models, voxel, "factory_bolt_m16_loose",
                        "factory_nut_m16_loose_subdiv_3x", Vec3(0, 0, 0.006), 0.03));
  if (!loaded) return loaded.error();
  NutFigures figures;
  figures.voxel = voxel;
  const Pose X_WB0 = (*loaded)->bodies[0].X_WB0;
  TimesOfFrames times;
  {
    World world(*loaded);
    StepInputs inputs = Inputs(**loaded);
    double last = 0;
    for (int frame = 0; frame < kTurnFrames; ++frame) {
      const double wanted = 2 * std::numbers::pi * frame / (kTurnFrames - 500);
      // the hand turns about the axis and gives way along it
      inputs.hand.goal.X_WA = {
          RotationBy(Vec3(0, 0, std::min(wanted, 2 * std::numbers::pi))) * X_WB0.q,
          {X_WB0.p.x(), X_WB0.p.y(), world.state(0).X_WB.p.z()}};
      TimedStep(world, inputs, times);
      const RigidState& state = world.state(0);
      const double turn = TurnAboutZ(state.X_WB.q * X_WB0.q.conjugate());
      figures.turned += std::remainder(turn - last, 2 * std::numbers::pi);
      last = turn;
      const double risen = state.X_WB.p.z() - X_WB0.p.z();
      figures.helix_error_mm =
          std::max(figures.helix_error_mm,
                   1e3 * std::abs(risen - kPitch * figures.turned / (2 * std::numbers::pi)));
    }
  }
  for (const double way : {-1.0, 1.0}) {
    World world(*loaded);
    StepInputs inputs = Inputs(**loaded);
    for (int frame = 0; frame < 1000; ++frame) {
      // 16 N at the end
      inputs.hand.goal.X_WA = {X_WB0.q, X_WB0.p + way * 0.02 * frame / 1000 * Vec3::UnitZ()};
      TimedStep(world, inputs, times);
      figures.push_mm =
          std::max(figures.push_mm, 1e3 * std::abs(world.state(0).X_WB.p.z() - X_WB0.p.z()));
    }
  }
  figures.axial_blocked = figures.push_mm < 0.2;
  figures.frames = LengthsOf(times);
  return figures;
}

Result<PegFigures> MeasurePegs(ContactModel contact, const std::filesystem::path& models,
                               double voxel, int seeds) {
  constexpr std::array<Peg, 3> kPegs{
      {{"factory_round_hole_16mm_subdiv_3x", "factory_round_peg_16mm_loose", 0.08},
       {"factory_round_hole_8mm_subdiv_3x", "factory_round_peg_8mm_tight", 0.02},
       {"factory_rectangular_hole_8mm_subdiv_3x", "factory_rectangular_peg_8mm_loose_subdiv_3x",
        0.02}}};
  constexpr double kStart = kHoleTop + 0.001;
  PegFigures figures;
  figures.voxel = voxel;
  int inserted = 0;
  TimesOfFrames times;
  for (std::size_t p = 0; p < kPegs.size(); ++p) {
    const auto loaded = LoadWorld(Factory(contact, models, voxel, kPegs[p].hole, kPegs[p].peg,
                                          Vec3(0, 0, kStart), kPegs[p].mass));
    if (!loaded) return loaded.error();
    for (int seed = static_cast<int>(p); seed < seeds; seed += static_cast<int>(kPegs.size())) {
      std::mt19937_64 random(100 + static_cast<std::uint64_t>(seed));
      Buzz buzz;
      const double depth = Insert(*loaded, kStart, random, buzz, times);
      inserted += depth > kInserted ? 1 : 0;
      figures.buzz = std::max(figures.buzz, buzz.share());
      ++figures.trials;
    }
  }
  figures.inserted_share = static_cast<double>(inserted) / std::max(1, figures.trials);
  figures.frames = LengthsOf(times);
  return figures;
}

}  // namespace tandem
