#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "app/bench/fidelity/checked_steps.h"
#include "app/bench/fidelity/factory_scene.h"
#include "app/bench/fidelity/fidelity.h"
#include "app/bench/fidelity/force_steps.h"
#include "app/judgement/penetration_oracle.h"
#include "engine/world/world.h"

namespace tandem {

namespace {

constexpr double kFullTurn = 2 * std::numbers::pi;
constexpr int kTurnFrames = 4000;
constexpr int kPushFrames = 1000;  // frames of a push along the axis, either way
constexpr int kPoseEvery = 100;    // frames between the poses that are kept of a turn

/// Loads the nut of a fit, three pitches above its place in the file.
Result<std::shared_ptr<const WorldModel>> LoadNut(ContactModel contact,
                                                  const std::filesystem::path& models, double voxel,
                                                  const std::string& fit) {
  return LoadWorld(FactoryScene(contact, models, voxel, "factory_bolt_m16_" + fit,
                                "factory_nut_m16_" + fit + "_subdiv_3x", Vec3(0, 0, 0.006), 0.03));
}

/// Returns the turn about z of a body from its first orientation, rad in (-pi, pi].
double TurnAboutZ(const Quat& q_from_first) {
  return 2.0 * std::atan2(q_from_first.z(), q_from_first.w());
}

struct Turn {
  double turned = 0;  // rad
  double helix_error_mm = 0;
  std::vector<std::pair<Pose, Pose>>
      poses_WB;  // poses of the nut at intervals: before a frame and after
};

/// Turns the nut by a hand that gives way along the axis.
Turn TurnNut(const std::shared_ptr<const WorldModel>& model, CheckedSteps& steps,
             TimesOfFrames& times) {
  constexpr double kPitch = 0.002;  // m
  World world(model);
  StepInputs inputs = HandInputs(*model);
  const Pose X_WB0 = model->bodies[0].X_WB0;
  Turn turn;
  double last = 0;
  for (int frame = 0; frame < kTurnFrames; ++frame) {
    const double wanted = kFullTurn * frame / (kTurnFrames - 500);
    const Pose before = world.state(0).X_WB;
    inputs.hand.goal.X_WA = {RotationBy(Vec3(0, 0, std::min(wanted, kFullTurn))) * X_WB0.q,
                             {X_WB0.p.x(), X_WB0.p.y(), before.p.z()}};
    steps.Step(world, inputs, times);
    const Pose& after = world.state(0).X_WB;
    const double angle = TurnAboutZ(after.q * X_WB0.q.conjugate());
    turn.turned += std::remainder(angle - last, kFullTurn);
    last = angle;
    const double risen = after.p.z() - X_WB0.p.z();
    turn.helix_error_mm =
        std::max(turn.helix_error_mm, 1e3 * std::abs(risen - kPitch * turn.turned / kFullTurn));
    if (frame % kPoseEvery == 0) turn.poses_WB.emplace_back(before, after);
  }
  return turn;
}

/// Returns the largest jump of force between the poses of a turn, N.
double LargestStepOf(const Turn& turn, const WorldModel& model) {
  constexpr int kParts = 4;  // parts of the way of a frame
  const std::unique_ptr<BodyPair> pair = FixturePair(model);
  double largest = 0;
  for (const auto& [from, to] : turn.poses_WB) {
    const auto force_at = [&](double share) {
      return ForceAtRest(*pair, {from.q.slerp(share, to.q), from.p + share * (to.p - from.p)});
    };
    largest = LargestForceStep(force_at, kParts, largest);
  }
  return largest;
}

/// Returns the greatest depth of samples of either mesh in the other over the poses of a turn, mm.
double DeepestCrossing(const Turn& turn, const WorldModel& model) {
  constexpr double kMostSamples = 3e5;
  constexpr std::size_t kFixed = 0;
  constexpr std::size_t kMoving = 1;
  const TriangleMesh& fixed_W = model.meshes_W[kFixed];
  const TriangleMesh moving_B =
      Transformed(model.meshes_W[kMoving], model.bodies[0].X_WB0.Inverse());
  const auto deepest = [&](const TriangleMesh& solid, const TriangleMesh& sampled, bool inverse) {
    const double voxel = SampledVoxel(sampled, model.scene.voxel_size, kMostSamples);
    const PenetrationOracle oracle(solid, sampled, voxel);
    std::vector<std::vector<Pose>> series(1);
    for (const auto& poses : turn.poses_WB) {
      series[0].push_back(inverse ? poses.first.Inverse() : poses.first);
    }
    const PenetrationReport report = oracle.Check(series, 1, [] {
      return false;
    });
    return 1e3 * voxel * report.max_penetration_voxels;
  };
  return std::max(deepest(fixed_W, moving_B, false), deepest(moving_B, fixed_W, true));
}

}  // namespace

Result<NutFigures> MeasureNut(ContactModel contact, const std::filesystem::path& models,
                              double voxel, std::size_t contacts) {
  const auto loaded = LoadNut(contact, models, voxel, "loose");
  if (!loaded) return loaded.error();
  NutFigures figures;
  figures.voxel = voxel;
  const Pose X_WB0 = (*loaded)->bodies[0].X_WB0;
  CheckedSteps steps(**loaded, contacts, kTurnFrames + 2 * kPushFrames);
  TimesOfFrames times;
  const Turn turn = TurnNut(*loaded, steps, times);
  figures.turned = turn.turned;
  figures.helix_error_mm = turn.helix_error_mm;
  for (const double way : {-1.0, 1.0}) {
    World world(*loaded);
    StepInputs inputs = HandInputs(**loaded);
    for (int frame = 0; frame < kPushFrames; ++frame) {
      // the hand pushes with 16 N at the end
      inputs.hand.goal.X_WA = {X_WB0.q, X_WB0.p + way * 0.02 * frame / kPushFrames * Vec3::UnitZ()};
      steps.Step(world, inputs, times);
      figures.push_mm =
          std::max(figures.push_mm, 1e3 * std::abs(world.state(0).X_WB.p.z() - X_WB0.p.z()));
    }
  }
  figures.axial_blocked = figures.push_mm < 0.2;
  figures.frames = LengthsOf(times);
  figures.checks = steps.Checks();
  figures.largest_force_step = LargestStepOf(turn, **loaded);
  return figures;
}

Result<TightNutFigures> MeasureTightNut(ContactModel contact, const std::filesystem::path& models,
                                        double voxel) {
  const auto loaded = LoadNut(contact, models, voxel, "tight");
  if (!loaded) return loaded.error();
  CheckedSteps steps(**loaded, 0, kTurnFrames);
  TimesOfFrames times;
  const Turn turn = TurnNut(*loaded, steps, times);
  return TightNutFigures{.voxel = voxel,
                         .turned = turn.turned,
                         .helix_error_mm = turn.helix_error_mm,
                         .crossing_mm = DeepestCrossing(turn, **loaded),
                         .frames = LengthsOf(times)};
}

}  // namespace tandem
