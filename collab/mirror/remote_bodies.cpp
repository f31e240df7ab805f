#include "collab/mirror/remote_bodies.h"

#include <algorithm>
#include <utility>

#include "collab/coupling/coupling_law.h"
#include "collab/coupling/energy_gate.h"
#include "collab/receive/newer.h"

namespace tandem {

RemoteBodies::RemoteBodies(const WorldModel& model, MirrorModel mirror) : mirror_(mirror) {
  for (const std::uint32_t object : model.object) {
    bodies_.push_back(
        {.object = object,
         .free = model.scene.bodies[object].free,
         .eased = model.scene.bodies[object].free && !model.scene.bodies[object].shared,
         .compliances = {},
         .instances = {},
         .loose = {},
         .told_V_WB = {}});
  }
  const std::vector<std::size_t> shapes = InstanceShapes(model);
  for (InstanceIndex i = bodies_.size(); i < shapes.size(); ++i) bodies_[shapes[i]].second = i;
}

void RemoteBodies::OnMembership(const MembershipChange& change) noexcept {
  const bool goes_on = change.kind == MembershipChange::Kind::kClaims;
  for (Body& body : bodies_) {
    // a peer that comes anew numbers its states anew
    if (!goes_on && body.loose.peer == change.peer) body.loose.peer = 0;
    const Claim* const claim = change.HeldClaim(body.object);
    if (claim == nullptr) {
      body.instances.Erase(change.peer);
      continue;
    }
    Instance* const instance = body.instances.FindOrInsert(change.peer);
    if (instance == nullptr) continue;
    // a peer that goes on holding the body is where it last said
    if (goes_on && instance->holds && instance->epoch == claim->epoch) continue;
    *instance = Instance{};
    instance->peer = change.peer;
    instance->holds = true;
    instance->epoch = claim->epoch;
  }
}

void RemoteBodies::OnState(const ObjectState& state) noexcept {
  for (Body& body : bodies_) {
    if (body.object != state.object) continue;
    Instance* const instance = body.instances.Find(state.peer);
    const auto note = [&] {
      body.told_V_WB = state.V_WB;
      body.told_frames = 0;
    };
    if ((state.flags & kStateParked) != 0) {
      body.loose = {};
      return note();
    }
    if ((state.flags & kStateLoose) != 0) {
      // the holder has let go, even if its claim has not said so yet
      if (instance != nullptr) instance->received = false;
      const bool same = body.loose.received && body.loose.peer == state.peer;
      if (same && !IsNewer(state, body.loose.state)) return;
      body.loose = {.peer = state.peer, .received = true, .state = state, .X_WB = state.X_WB};
      return note();
    }
    if (instance == nullptr || !instance->holds) return;
    if (!instance->received || IsNewer(state, instance->state)) {
      instance->state = state;
      instance->X_WB = state.X_WB;
      instance->received = true;
      body.loose = {};
      note();
    }
    return;
  }
}

std::size_t RemoteBodies::received_instances() const noexcept {
  std::size_t count = 0;
  for (const Body& body : bodies_) {
    for (const Instance& instance : body.instances) count += instance.received ? 1 : 0;
  }
  return count;
}

double RemoteBodies::LagOf(PeerId peer) const noexcept {
  double lag = 0;
  for (const Body& body : bodies_) {
    const Instance* const instance = body.instances.Find(peer);
    if (instance != nullptr && instance->received) lag = std::max(lag, body.lag);
    if (body.loose.received && body.loose.peer == peer) lag = std::max(lag, body.lag);
  }
  return lag;
}

Pose RemoteBodies::ExtrapolatedPose(const ObjectState& state, double loop_age_s) noexcept {
  const double ahead = std::min(0.5 * loop_age_s, kFarthestAhead_s);
  const auto& [w, v] = state.V_WB;
  const Vec3 way = ahead * v;
  const double share = std::min(1.0, kFarthestAhead_m / std::max(way.norm(), 1e-9));
  return {RotationBy(ahead * w) * state.X_WB.q, state.X_WB.p + share * way};
}

void RemoteBodies::Extrapolate(std::span<const RoundTripTracker::Loop> loops) noexcept {
  if (mirror_ != MirrorModel::kDeadReckoned) return;
  const auto reckon = [&loops](Instance& instance) {
    if (!instance.received) return;
    const auto loop = std::ranges::find(loops, instance.peer, &RoundTripTracker::Loop::peer);
    instance.X_WB = ExtrapolatedPose(instance.state, loop == loops.end() ? 0.0 : loop->age_s);
  };
  for (Body& body : bodies_) {
    std::ranges::for_each(body.instances, reckon);
    reckon(body.loose);
  }
}

void RemoteBodies::Place(std::size_t index, StepInputs& inputs) noexcept {
  Body& body = bodies_[index];
  StepInputs::InstanceInput& input = inputs.instances[index];
  // the two instances that are farthest apart, found in a fixed order
  const Instance* first = nullptr;
  const Instance* second = nullptr;
  double farthest = -1;
  for (const Instance& a : body.instances) {
    if (!a.received) continue;
    for (const Instance& b : body.instances) {
      if (!b.received || b.peer < a.peer) continue;
      const double apart = (a.X_WB.p - b.X_WB.p).norm();
      if (apart <= farthest) continue;
      farthest = apart;
      first = &a;
      second = &b;
    }
  }
  if (body.parted) {
    // hands tremble, so another pair may be the farthest: each instance stays on its side
    const auto from_last = [&input](const Instance* instance) {
      return (instance->X_WB.p - input.mirror_WB.p).squaredNorm();
    };
    if (from_last(second) < from_last(first)) std::swap(first, second);
  }
  body.parted = farthest > (body.parted ? kMeet : kPart);
  std::array<Vec3, 2> p{Vec3::Zero(), Vec3::Zero()};
  std::array<Eigen::Vector4d, 2> q{Eigen::Vector4d::Zero(), Eigen::Vector4d::Zero()};
  std::array<double, 2> count{};
  for (const Instance& instance : body.instances) {
    if (!instance.received) continue;
    const Pose& X_WB = instance.X_WB;
    const bool nearer_second =
        (X_WB.p - second->X_WB.p).squaredNorm() < (X_WB.p - first->X_WB.p).squaredNorm();
    const std::size_t side = body.parted && nearer_second ? 1 : 0;
    const Quat& reference = (side == 0 ? first : second)->X_WB.q;
    const double sign = reference.dot(X_WB.q) < 0 ? -1.0 : 1.0;
    p[side] += X_WB.p;
    q[side] += sign * X_WB.q.coeffs();
    count[side] += 1;
  }
  input.mirror_WB = {Quat(q[0]).normalized(), p[0] / count[0]};
  if (!body.parted || !body.second) return;
  StepInputs::InstanceInput& far = inputs.instances[*body.second];
  far.drive = BodyDrive::kMirrored;
  far.mirror_WB = {Quat(q[1]).normalized(), p[1] / count[1]};
}

void RemoteBodies::MeetAsOne(std::size_t body, StepInputs& inputs) const noexcept {
  const std::optional<InstanceIndex> second = bodies_[body].second;
  if (second) inputs.instances[*second].drive = BodyDrive::kInactive;
}

void RemoteBodies::Prepare(int held, StepInputs& inputs) noexcept {
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    StepInputs::InstanceInput& input = inputs.instances[b];
    MeetAsOne(b, inputs);
    ++bodies_[b].told_frames;
    if (static_cast<int>(b) == held) {
      TakeOver(b, inputs);
      continue;
    }
    const bool in_hand = std::ranges::any_of(bodies_[b].instances, &Instance::received);
    const bool followed = in_hand || bodies_[b].loose.received;
    input.drive = followed ? BodyDrive::kMirrored : BodyDrive::kParked;
    if (in_hand) {
      Place(b, inputs);
    } else if (followed) {
      input.mirror_WB = bodies_[b].loose.X_WB;
    }
  }
}

void RemoteBodies::TakeOver(std::size_t body, StepInputs& inputs) noexcept {
  StepInputs::InstanceInput& input = inputs.instances[body];
  const bool goes_on = bodies_[body].free && bodies_[body].told_frames <= kGoesOn;
  input.drive = BodyDrive::kSimulated;
  input.begin_V_WB = goes_on ? bodies_[body].told_V_WB : Twist{};
  bodies_[body].loose = {};
  MeetAsOne(body, inputs);
}

void RemoteBodies::HandOver(std::size_t body, PeerId peer, const RigidState& state,
                            StepInputs& inputs) noexcept {
  Body& mirror = bodies_[body];
  if (inputs.instances[body].drive != BodyDrive::kParked) return;  // its states have come already
  mirror.loose = {.peer = peer, .received = true, .state = {}, .X_WB = state.X_WB};
  mirror.loose.state.X_WB = state.X_WB;
  mirror.told_V_WB = state.V_WB;
  mirror.told_frames = 0;
  inputs.instances[body].drive = BodyDrive::kMirrored;
  inputs.instances[body].mirror_WB = state.X_WB;
}

double RemoteBodies::WorstLoop(const Body& body,
                               std::span<const RoundTripTracker::Loop> loops) noexcept {
  double worst = -1;
  const auto look = [&](const Instance& instance, double unknown_s) {
    const auto loop = std::ranges::find(loops, instance.peer, &RoundTripTracker::Loop::peer);
    worst = std::max(worst, loop == loops.end() ? unknown_s : loop->peak_s);
  };
  for (const Instance& instance : body.instances) {
    if (instance.holds) look(instance, 0);
  }
  if (body.loose.received) look(body.loose, kUnknownLoop_s);
  return worst;
}

void RemoteBodies::ReturnToRest(Body& body, bool pushed, const RigidState& state,
                                StepInputs::InstanceInput& input) noexcept {
  body.eases = body.eases || pushed || body.compliances[0].compliant();
  body.compliances[0] = MirrorCompliance{};
  if (input.drive != BodyDrive::kMirrored) return;  // it waits for its pose
  const Pose& home_WB = input.mirror_WB;
  body.lag = (home_WB.p - state.X_WB.p).norm();
  const double turn = home_WB.q.angularDistance(state.X_WB.q);
  const double frames = std::max(body.lag / kHomeStep, turn / kHomeTurn);
  body.eases = body.eases && frames > 1;
  if (body.eases) input.mirror_WB = Interpolate(state.X_WB, home_WB, 1.0 / frames);
}

void RemoteBodies::SmoothTarget(const Body& body, const RigidState& state,
                                StepInputs::InstanceInput& input) noexcept {
  if (!body.eased || input.drive != BodyDrive::kMirrored) return;
  const bool goes_on = body.told_frames <= kGoesOn;
  const Vec3 v = goes_on ? body.told_V_WB.v : Vec3::Zero();
  const Vec3 w = goes_on ? body.told_V_WB.w : Vec3::Zero();
  const Pose on{RotationBy(kFrame * w) * state.X_WB.q, state.X_WB.p + kFrame * v};
  input.mirror_WB = Interpolate(on, input.mirror_WB, kFrame / kEase_s);
}

void RemoteBodies::Yield(const World& world, InstanceIndex instance, double te_s,
                         MirrorCompliance& compliance, double& most_lag,
                         StepInputs::InstanceInput& input) const noexcept {
  if (input.drive != BodyDrive::kMirrored) {
    compliance = MirrorCompliance{};
    return;
  }
  const RigidState& state = world.state(instance);
  const Inertia& inertia = world.model().bodies[world.shape_of(instance)].inertia;
  const bool pushed = mirror_ == MirrorModel::kCompliantMirror && world.Pushed(instance);
  const double lag = (input.mirror_WB.p - state.X_WB.p).norm();
  most_lag = std::max(most_lag, lag);
  compliance.Next(pushed, te_s, lag, kFrame);
  if (!compliance.compliant()) return;
  const Mat3 R = state.X_WB.q.toRotationMatrix();
  const Mat3 per_mass = R * inertia.I_B * R.transpose() / inertia.mass;
  const double drag = compliance.Drag(inertia.mass);
  input.pull = {compliance.stiffness(), drag, compliance.stiffness() * per_mass, drag * per_mass};
  input.drive = BodyDrive::kCompliant;
}

void RemoteBodies::ApplyCompliance(const World& world,
                                   std::span<const RoundTripTracker::Loop> loops,
                                   StepInputs& inputs) noexcept {
  mirror_lag_ = 0;
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    StepInputs::InstanceInput& input = inputs.instances[b];
    Body& body = bodies_[b];
    body.lag = 0;
    const double worst_loop = WorstLoop(body, loops);
    const double te_s = DesignDelay(std::max(worst_loop, 0.0));
    if (worst_loop < 0 && input.drive != BodyDrive::kSimulated) {
      ReturnToRest(body, world.Pushed(b), world.state(b), input);
      if (!body.eases) SmoothTarget(body, world.state(b), input);
      mirror_lag_ = std::max(mirror_lag_, body.lag);
      continue;
    }
    body.eases = false;
    if (input.drive == BodyDrive::kSimulated) {
      body.told_V_WB = world.state(b).V_WB;
      body.told_frames = 0;
    }
    Yield(world, b, te_s, body.compliances[0], body.lag, input);
    SmoothTarget(body, world.state(b), input);
    if (body.second) {
      const InstanceIndex second = *body.second;
      Yield(world, second, te_s, body.compliances[1], body.lag, inputs.instances[second]);
    }
    mirror_lag_ = std::max(mirror_lag_, body.lag);
  }
}

}  // namespace tandem
