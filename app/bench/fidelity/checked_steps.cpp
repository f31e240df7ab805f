#include "app/bench/fidelity/checked_steps.h"

#include <algorithm>
#include <span>

#include "engine/base/check.h"

namespace tandem {

namespace {

constexpr std::size_t kJudgedEvery = 10;  // frames from one whose pushes are kept to the next

}  // namespace

ContactChecks& ContactChecks::operator+=(const ContactChecks& other) {
  pushes += other.pushes;
  wrench_error = std::max(wrench_error, other.wrench_error);
  wrench_error_held_back = std::max(wrench_error_held_back, other.wrench_error_held_back);
  return *this;
}

CheckedSteps::CheckedSteps(const WorldModel& model, std::size_t contacts, std::size_t frames)
    : contacts_a_frame_(static_cast<double>(contacts) / static_cast<double>(frames)) {
  if (contacts == 0 || model.scene.contact != ContactModel::kRefined) return;
  TriangleMesh fixture_W;
  TriangleMesh body_B;
  for (std::size_t i = 0; i < model.meshes_W.size(); ++i) {
    if (model.body_index[i] < 0) Append(fixture_W, model.meshes_W[i]);
    if (model.body_index[i] != 0) continue;
    Append(body_B, Transformed(model.meshes_W[i], model.bodies[0].X_WB0.Inverse()));
  }
  judge_ = std::make_unique<PushJudge>(fixture_W, body_B, model.scene.voxel_size);
}

TimedFrame CheckedSteps::Step(World& world, const StepInputs& inputs, TimesOfFrames& times) {
  const WorldModel& model = world.model();
  const RigidState before = world.state(0);
  const TimedFrame done = TimedStep(world, inputs, times);
  const double mass = model.bodies[0].inertia.mass;
  const Vec3 gained = mass / kFrame * (world.state(0).V_WB.v - before.V_WB.v);
  const Vec3 by_contact = gained - done.report.hand_B_W.f - mass * model.scene.gravity_W;
  const bool held_back = (done.report.flags & StepReport::kTravelLimited) != 0;
  double& largest = held_back ? checks_.wrench_error_held_back : checks_.wrench_error;
  largest = std::max(largest, (done.report.contact_B_W.f - by_contact).norm());
  if (judge_ != nullptr && ++frame_ % kJudgedEvery == 0) KeepPushes(world, before.X_WB);
  return done;
}

void CheckedSteps::KeepPushes(const World& world, const Pose& X_WB) {
  TANDEM_CHECK(world.shell_of(0) == 0 && world.voxmap_of(0) == kFixture);
  const BodyPair& pair = world.pair(0);
  const Pose X_WV = pair.X_BV();  // fixture's frame is W
  const std::span<const Contact> contacts = pair.contacts();
  const double due =
      contacts_a_frame_ * static_cast<double>(frame_) - static_cast<double>(pushes_.size());
  if (contacts.empty() || due < 1) return;
  // the kept pushes are spread over all contacts
  const auto share = static_cast<std::size_t>(static_cast<double>(contacts.size()) / due);
  const std::size_t stride = std::max<std::size_t>(1, share);
  for (std::size_t i = frame_ / kJudgedEvery % stride; i < contacts.size(); i += stride) {
    const Contact& contact = contacts[i];
    pushes_.push_back({X_WV * contact.p_V, X_WV.q * contact.nhat_V, X_WB, contact.force});
  }
}

ContactChecks CheckedSteps::Checks() {
  checks_.pushes = {};
  for (const Push& push : pushes_) {
    checks_.pushes.Count(judge_->Judge(push.p_W, push.nhat_W, push.X_WB), push.force);
  }
  return checks_;
}

}  // namespace tandem
