#include "collab/lab/case/case_parts.h"

#include <algorithm>
#include <string>
#include <utility>

#include "collab/lab/case/prediction.h"

namespace tandem {

namespace {

constexpr double kFirmest = 1e4;        // N/m
constexpr double kMovingSpring = 300;   // N/m
constexpr double kHoldingSpring = 400;  // N/m
const Vec3 kOffCentre(0.05, 0.02, 0);   // m, in the scene off_centre

const LabHand& HandOf(const LabCase& test, std::size_t user) {
  return test.hands[std::min(user, test.hands.size() - 1)];
}

void GiveSpring(HandImpedance& hand, double stiffness) {
  if (hand.stiffness > 0) return;
  hand.stiffness = stiffness;
  hand.rotation_stiffness = stiffness * hand.inertia / hand.mass;
}

std::vector<Waypoint> MoveBy(double distance) {
  return {{0, Vec3::Zero(), Quat::Identity()},
          {2, Vec3::Zero(), Quat::Identity()},
          {3, Vec3(distance, 0, 0), Quat::Identity()}};
}

std::vector<Waypoint> ToAndFro(double distance, double until_s) {
  std::vector<Waypoint> waypoints{{0, Vec3::Zero(), Quat::Identity()}};
  bool out = false;
  for (double t = 2; t <= until_s || out; t += 1) {
    waypoints.push_back({t, Vec3(out ? distance : 0, 0, 0), Quat::Identity()});
    out = !out;
  }
  return waypoints;
}

void Script(const LabCase& test, std::size_t user, HandScript& script) {
  const auto push = [&script](double from, double until, double newtons) {
    script.pushes.push_back({from, until - from, {Vec3::Zero(), Vec3(newtons, 0, 0)}});
  };
  const bool first = user == 0;
  switch (test.motion) {
    case LabMotion::kStill:
      return;
    case LabMotion::kKick:
      if (first) push(1, 1.05, 5);
      return;
    case LabMotion::kMove:
      if (!first) return;
      GiveSpring(script.impedance, kMovingSpring);
      script.waypoints = MoveBy(0.2);
      return;
    case LabMotion::kHold:
      GiveSpring(script.impedance, first ? kMovingSpring : kHoldingSpring);
      if (first) script.waypoints = MoveBy(0.1);
      return;
    case LabMotion::kSwing:
      if (!first) return;
      GiveSpring(script.impedance, kMovingSpring);
      script.waypoints = ToAndFro(0.1, 2.0 / 3.0 * test.Duration());
      return;
    case LabMotion::kPress:
      push(1.5, 4, 2);
      if (first) push(2.5, 2.55, 5);
      return;
    case LabMotion::kPullOff:
      push(1.5, 5, 2);
      if (first) push(3, 3.15, -14);
      return;
  }
}

}  // namespace

LabCase FittedTo(const Inertia& body, LabCase test) {
  for (LabHand& hand : test.hands) {
    if (!hand.script) hand.impedance = Turning(hand.impedance, body);
  }
  if (test.law.boundary_ratio <= 0) return test;
  // the share is of the boundary without schedule and exchange, which the equation does not know
  LabCase plain = test;
  plain.network.schedule.clear();
  plain.law.exchange_forces = false;
  double critical = kFirmest;
  for (std::size_t user = 0; user < test.users; ++user) {
    const std::optional<LumpedCoupling> lumped = LumpedOf(plain, body, user);
    if (lumped) critical = std::min(critical, CriticalStiffness(*lumped));
  }
  test.law.limits.constant_stiffness = test.law.boundary_ratio * critical;
  return test;
}

HandScript ScriptOf(const LabCase& test, std::size_t user) {
  const LabHand& hand = HandOf(test, user);
  HandScript script;
  if (hand.script) {
    script = *hand.script;
  } else {
    script.impedance = hand.impedance;
    const Vec3 of_scene = test.scene == "off_centre" ? kOffCentre : Vec3::Zero();
    script.X_BD.p = hand.grasp_B.value_or(of_scene);
    Script(test, user, script);
  }
  // a link begins to pull one delay after its loop is closed: all links do half a second before the
  // first input at 1 s
  const double later = std::max(0.0, LongestDelay(test) - 0.5);
  for (Push& push : script.pushes) push.t += later;
  for (Waypoint& waypoint : script.waypoints) waypoint.t += waypoint.t > 0 ? later : 0.0;
  if (hand.script && later > 0 && script.waypoints.size() > 1) {
    script.waypoints.insert(script.waypoints.begin() + 1, {later, Vec3::Zero(), Quat::Identity()});
  }
  return script;
}

double LastInputEnds(const LabCase& test) {
  double last = 0;
  for (std::size_t user = 0; user < test.users; ++user) {
    const HandScript script = ScriptOf(test, user);
    last = std::max(last, script.duration());
    for (const Push& push : script.pushes) last = std::max(last, push.t + push.lasts);
  }
  return last;
}

LinkConditions ConditionsOf(const LabCase& test, std::size_t from, std::size_t to, double delay_s) {
  LinkConditions conditions = from < to ? test.network.there : test.network.back;
  const double share = from < to ? 1.0 - test.network.skew : 1.0 + test.network.skew;
  conditions.delay_ms += 1e3 * share * delay_s;
  // the sender tells apart streams to one receiver; the seed tells apart the receivers
  conditions.seed = 1000 * test.seed + to;
  // both ways of a trace begin at one place of it
  conditions.trace_start_s = test.network.traced.StartFor(test.seed);
  return conditions;
}

double LongestDelay(const LabCase& test) {
  double delay_s = test.delay_s;
  for (const LabNetwork::Step& step : test.network.schedule) {
    delay_s = std::max(delay_s, step.delay_s);
  }
  double longest = 0;
  for (const bool there : {true, false}) {
    const LinkConditions way = ConditionsOf(test, there ? 0 : 1, there ? 1 : 0, delay_s);
    longest =
        std::max(longest, 1e-3 * (way.delay_ms + way.jitter_ms + way.swing_ms +
                                  (way.reorder > 0 ? way.reorder_ms : 0.0) +
                                  (way.trace != nullptr ? way.trace->facts().longest_ms : 0.0)));
  }
  return longest;
}

Result<std::shared_ptr<const CouplingLaw>> LawOf(const LabLaw& law) {
  return MakeLaw(law.name, LimitsOf(law), true);
}

CouplingLimits LimitsOf(const LabLaw& law) {
  CouplingLimits limits = law.limits;
  limits.ratio = law.ratio;
  return limits;
}

}  // namespace tandem
