#include <algorithm>
#include <cmath>
#include <numbers>

#include "app/bench/fidelity/fidelity.h"
#include "app/capacity/capacity.h"
#include "app/capacity/capacity_follower.h"
#include "engine/base/units.h"
#include "engine/world/world.h"

namespace tandem {

namespace {

/// The frames of a turn at the least travel limit.
constexpr int kMostFrames = 12'000;

Result<std::shared_ptr<const WorldModel>> LoadBall(Scene scene, ContactModel contact,
                                                   double voxel) {
  scene.contact = contact;
  scene.voxel_size = voxel;
  scene.force_layer =
      contact == ContactModel::kRefined ? DefaultForceLayer(contact) : 0;  // the paper's layer
  return LoadWorld(scene);
}

}  // namespace

Result<BallFigures> MeasureBall(ContactModel contact, const std::filesystem::path& scene_file,
                                double voxel) {
  const Result<Scene> scene = LoadScene(scene_file);
  if (!scene) return scene.error();
  const auto loaded = LoadBall(*scene, contact, voxel);
  if (!loaded) return loaded.error();
  const WorldModel& joint = **loaded;
  const auto ball = static_cast<std::size_t>(joint.BodyNamed("ball"));
  BallFigures figures;
  figures.points = TestedPoints(joint, joint.bodies[ball]);

  // the hand presses the ball into the cup and turns it as fast as it goes
  World world(*loaded);
  StepInputs inputs = ParkedInputs(joint);
  const FrameCapacity capacity = MeasureCapacity(joint, kFrameBudget);
  CapacityFollower follower(capacity.tests, capacity.query_price, kFrameBudget);
  inputs.query_price = capacity.query_price;
  inputs.instances[ball].drive = BodyDrive::kSimulated;
  inputs.hand.body = static_cast<int>(ball);
  inputs.hand.gains = DefaultHandGains(joint.bodies[ball].inertia);
  const Pose X_WB0 = joint.bodies[ball].X_WB0;
  const Vec3 axis = Vec3(1, 0.3, 0.2).normalized();
  const auto pressed = [&](double turn) {
    return Pose{RotationBy(turn * axis) * X_WB0.q, X_WB0.p + Vec3(0, 0, -0.002)};
  };
  inputs.hand.goal.X_WA = pressed(0);
  double contacts = 0;
  const auto step = [&](TimesOfFrames& times) {
    inputs.capacity = follower.tests();
    const TimedFrame done = TimedStep(world, inputs, times);
    follower.Count(done.report, ToSeconds(done.cpu_ns));
    contacts += done.report.contact_points;
  };
  TimesOfFrames warm_up;
  for (int frame = 0; frame < 300; ++frame) step(warm_up);
  const Quat q_first = world.state(ball).X_WB.q;
  double turned = 0;
  double last = 0;
  contacts = 0;
  int frames = 0;
  TimesOfFrames times;
  while (turned < 2 * std::numbers::pi && frames < kMostFrames) {
    const Quat q = world.state(ball).X_WB.q * q_first.conjugate();
    const double turn = 2.0 * std::atan2(q.vec().dot(axis), q.w());
    turned += std::remainder(turn - last, 2 * std::numbers::pi);
    last = turn;
    inputs.hand.goal.X_WA = pressed(turned + 1.0);
    step(times);
    ++frames;
  }
  figures.turn_s = kFrame * frames;
  figures.frames = LengthsOf(times);
  figures.turn_1khz_s = kFrame * (frames + static_cast<double>(times.stats.missed()));
  figures.contacts_mean = contacts / frames;
  return figures;
}

Result<std::size_t> CountBallPoints(ContactModel contact, const std::filesystem::path& scene_file,
                                    double voxel) {
  const Result<Scene> scene = LoadScene(scene_file);
  if (!scene) return scene.error();
  const auto loaded = LoadBall(*scene, contact, voxel);
  if (!loaded) return loaded.error();
  const auto ball = static_cast<std::size_t>((*loaded)->BodyNamed("ball"));
  return TestedPoints(**loaded, (*loaded)->bodies[ball]);
}

}  // namespace tandem
