#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>

#include "app/bench/fidelity/checked_steps.h"
#include "app/bench/fidelity/factory_scene.h"
#include "app/bench/fidelity/fidelity.h"
#include "engine/world/world.h"

namespace tandem {

namespace {

/// Passes the part of a 1 kHz signal above 20 Hz. It is a Butterworth filter of second order.
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

/// Measures the share of a force that is felt as buzz: RMS of 20 to 500 Hz over the mean.
class Buzz {
 public:
  /// Adds a force, which `counts` or not. The filter needs all of the force from its first, or it
  /// takes the force at its beginning for a blow.
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

/// Returns 0 to 1 as x goes from 0 to 1, with the least jerk.
double Smooth(double x) {
  const double u = std::clamp(x, 0.0, 1.0);
  return u * u * u * (10 + u * (6 * u - 15));
}

struct Peg {
  const char* hole;
  const char* peg;
  double mass;  // kg, for steel
};

constexpr double kHoleTop = 0.0089916;  // m
constexpr int kInsertFrames = 3300;
constexpr double kInserted = 0.006;  // m below the hole's rim

/// Lets a hand insert one peg. Returns the final depth of the peg's end in the hole, m.
double Insert(const std::shared_ptr<const WorldModel>& model, double start_height,
              std::mt19937_64& random, Buzz& buzz, CheckedSteps& steps, TimesOfFrames& times) {
  World world(model);
  StepInputs inputs = HandInputs(*model);
  // the hand is as firm in rotation as HandImpedance
  inputs.hand.gains.rotation_stiffness = 3.0 * Mat3::Identity();
  inputs.hand.gains.rotation_damping = 0.03 * Mat3::Identity();
  const Pose X_WB0 = model->bodies[0].X_WB0;
  const double half_length = X_WB0.p.z() - start_height;
  const double heading = Uniform(random, 0, 2 * std::numbers::pi);
  const Vec3 aside = 0.0002 * Vec3(std::cos(heading), std::sin(heading), 0);
  Vec3 axis(Uniform(random, -1, 1), Uniform(random, -1, 1), Uniform(random, -1, 1));
  const Quat askew = RotationBy(0.5 * std::numbers::pi / 180 * axis.normalized());
  const double phase = Uniform(random, 0, 2 * std::numbers::pi);
  // returns the hand's pose with the peg's end at `end`
  const auto holding = [&](const Vec3& end) {
    return Pose{askew * X_WB0.q, end + askew * Vec3(0, 0, half_length)};
  };
  world.Place(0, holding(Vec3(0, 0, start_height) + aside));
  for (int frame = 0; frame < kInsertFrames; ++frame) {
    const double t = kFrame * frame;
    // the hand goes down until the peg rests, round and round in search of the hole, then in
    const double searching = std::clamp((t - 0.5) / 1.5, 0.0, 1.0);
    const double entering = Smooth((t - 2.0) / 1.0);
    const double radius = 0.0003 * searching * (1.0 - Smooth((t - 2.0) / 0.5));
    const double turn = phase + 2 * std::numbers::pi * 3.0 * t;
    const double height =
        start_height - (start_height - kHoleTop + 0.001) * Smooth(t / 0.5) - 0.007 * entering;
    inputs.hand.goal.X_WA = holding((1.0 + 5.0 * entering) * aside +
                                    Vec3(radius * std::cos(turn), radius * std::sin(turn), height));
    const TimedFrame done = steps.Step(world, inputs, times);
    buzz.Add(done.report.hand_B_W.f, t > 0.5);
  }
  const Pose& X_WB = world.state(0).X_WB;
  return kHoleTop - (X_WB * Vec3(0, 0, -half_length)).z();
}

}  // namespace

Result<PegFigures> MeasurePegs(ContactModel contact, const std::filesystem::path& models,
                               double voxel, int seeds, std::size_t contacts) {
  constexpr std::array<Peg, 3> kPegs{
      {{"factory_round_hole_16mm_subdiv_3x", "factory_round_peg_16mm_loose", 0.08},
       {"factory_round_hole_8mm_subdiv_3x", "factory_round_peg_8mm_tight", 0.02},
       {"factory_rectangular_hole_8mm_subdiv_3x", "factory_rectangular_peg_8mm_loose_subdiv_3x",
        0.02}}};
  constexpr double kStart = kHoleTop + 0.001;
  PegFigures figures;
  figures.voxel = voxel;
  const std::size_t all_frames = static_cast<std::size_t>(seeds) * kInsertFrames;
  int inserted = 0;
  TimesOfFrames times;
  for (std::size_t p = 0; p < kPegs.size(); ++p) {
    const auto loaded = LoadWorld(FactoryScene(contact, models, voxel, kPegs[p].hole, kPegs[p].peg,
                                               Vec3(0, 0, kStart), kPegs[p].mass));
    if (!loaded) return loaded.error();
    CheckedSteps steps(**loaded, contacts / kPegs.size(), all_frames / kPegs.size());
    for (int seed = static_cast<int>(p); seed < seeds; seed += static_cast<int>(kPegs.size())) {
      std::mt19937_64 random(100 + static_cast<std::uint64_t>(seed));
      Buzz buzz;
      const double depth = Insert(*loaded, kStart, random, buzz, steps, times);
      inserted += depth > kInserted ? 1 : 0;
      figures.buzz = std::max(figures.buzz, buzz.share());
      ++figures.trials;
    }
    figures.checks += steps.Checks();
  }
  figures.inserted_share = static_cast<double>(inserted) / std::max(1, figures.trials);
  figures.frames = LengthsOf(times);
  return figures;
}

}  // namespace tandem
