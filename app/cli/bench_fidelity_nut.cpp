#include <algorithm>
#include <cmath>
#include <numbers>

#include "app/cli/bench_fidelity.h"
#include "app/cli/factory_scene.h"
#include "engine/world/world.h"

namespace tandem {

namespace {

/// About z, of a body that has been turned from its first orientation, rad in (-pi, pi].
double TurnAboutZ(const Quat& q_from_first) {
  return 2.0 * std::atan2(q_from_first.z(), q_from_first.w());
}

}  // namespace

Result<NutFigures> MeasureNut(ContactModel contact, const std::filesystem::path& models,
                              double voxel) {
  constexpr double kPitch = 0.002;  // m
  constexpr int kTurnFrames = 4000;
  const auto loaded =
      LoadWorld(FactoryScene(contact, models, voxel, "factory_bolt_m16_loose",
                             "factory_nut_m16_loose_subdiv_3x", Vec3(0, 0, 0.006), 0.03));
  if (!loaded) return loaded.error();
  NutFigures figures;
  figures.voxel = voxel;
  const Pose X_WB0 = (*loaded)->bodies[0].X_WB0;
  TimesOfFrames times;
  {
    World world(*loaded);
    StepInputs inputs = HandInputs(**loaded);
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
    StepInputs inputs = HandInputs(**loaded);
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

}  // namespace tandem
