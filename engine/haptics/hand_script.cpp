#include "engine/haptics/hand_script.h"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <string>

#include "engine/base/check.h"
#include "engine/base/text/json_reader.h"

namespace tandem {
namespace {

constexpr double kLatest = 1e6;              // s
constexpr double kShortestSpan = 1e-6;       // s, between two waypoints
constexpr double kShortestPush = 1e-3;       // s
constexpr double kFarthest = 1e3;            // m, along each axis
constexpr double kMostPush = 1e4;            // N and N m, along each axis
constexpr double kLeastHandMass = 1e-6;      // kg
constexpr double kMostHandMass = 1e4;        // kg
constexpr double kLeastInertia = 1e-12;      // kg m^2
constexpr double kMostInertia = 1e4;         // kg m^2
constexpr double kMostHandGain = 1e7;        // N/m, N s/m; of turns N m/rad, N m s/rad
constexpr std::size_t kMostPushes = 10'000;  // each is evaluated in each frame

// Progress and rate of a minimum-jerk movement along a segment, at u in [0, 1] of its time.
struct Progress {
  double share = 0;
  double rate = 0;  // per unit of u
};

Progress MinimumJerk(double u) {
  const double rest = 1.0 - u;
  return {u * u * u * (10.0 + u * (-15.0 + 6.0 * u)), 30.0 * u * u * rest * rest};
}

Vec3 ReadVectorWithin(const JsonNode& node, double most) {
  const Vec3 v = node.Vector();
  if (v.cwiseAbs().maxCoeff() <= most) return v;
  const std::string limit = std::to_string(static_cast<int>(most));
  node.Expected("numbers from -" + limit + " to " + limit);
  return Vec3::Zero();
}

HandImpedance ReadImpedance(const JsonNode& node) {
  node.AllowKeys({"mass_kg", "damping_Ns_m", "stiffness_N_m", "rotation"});
  HandImpedance hand;
  if (node.Has("mass_kg")) {
    hand.mass = node["mass_kg"].NumberBetween(kLeastHandMass, kMostHandMass);
  }
  if (node.Has("damping_Ns_m")) {
    hand.damping = node["damping_Ns_m"].NumberBetween(0, kMostHandGain);
  }
  if (node.Has("stiffness_N_m")) {
    hand.stiffness = node["stiffness_N_m"].NumberBetween(0, kMostHandGain);
  }
  if (!node.Has("rotation")) return hand;
  const JsonNode rotation = node["rotation"];
  rotation.AllowKeys({"inertia_kg_m2", "damping_Nms_rad", "stiffness_Nm_rad"});
  if (rotation.Has("inertia_kg_m2")) {
    hand.inertia = rotation["inertia_kg_m2"].NumberBetween(kLeastInertia, kMostInertia);
  }
  if (rotation.Has("damping_Nms_rad")) {
    hand.rotation_damping = rotation["damping_Nms_rad"].NumberBetween(0, kMostHandGain);
  }
  if (rotation.Has("stiffness_Nm_rad")) {
    hand.rotation_stiffness = rotation["stiffness_Nm_rad"].NumberBetween(0, kMostHandGain);
  }
  return hand;
}

Pose ReadGrasp(const JsonNode& node) {
  node.AllowKeys({"p_B", "q_xyzw"});
  Pose X_BD;
  if (node.Has("p_B")) X_BD.p = ReadVectorWithin(node["p_B"], kFarthest);
  if (node.Has("q_xyzw")) X_BD.q = node["q_xyzw"].Rotation();
  return X_BD;
}

Waypoint ReadWaypoint(const JsonNode& node, const std::vector<Waypoint>& before) {
  node.AllowKeys({"t_s", "p_W", "q_xyzw"});
  Waypoint waypoint;
  waypoint.p_W = ReadVectorWithin(node["p_W"], kFarthest);
  if (node.Has("q_xyzw")) waypoint.q_W = node["q_xyzw"].Rotation();
  if (before.empty()) {
    waypoint.t = node["t_s"].Number();
    if (waypoint.t != 0) node["t_s"].Expected("0, where the hand starts");
    if (!waypoint.p_W.isZero(1e-9)) node["p_W"].Expected("[0, 0, 0], where the body is at first");
    if (node.Has("q_xyzw") && RotationVector(waypoint.q_W).norm() > 1e-6) {
      node["q_xyzw"].Expected("[0, 0, 0, 1], as the body stands at first");
    }
  } else {
    waypoint.t = node["t_s"].NumberAbove(before.back().t);
    if (waypoint.t > kLatest) node["t_s"].Expected("a time within eleven days");
    if (!(waypoint.t - before.back().t >= kShortestSpan)) {
      node["t_s"].Expected("a time at least 1e-06 s after the waypoint before");
    }
  }
  return waypoint;
}

Push ReadPush(const JsonNode& node) {
  node.AllowKeys({"t_s", "for_s", "f_W", "tau_W"});
  Push push;
  push.t = node["t_s"].NumberBetween(0, kLatest);
  push.lasts = node["for_s"].NumberBetween(kShortestPush, kLatest);
  if (node.Has("f_W")) push.F_D_W.f = ReadVectorWithin(node["f_W"], kMostPush);
  if (node.Has("tau_W")) push.F_D_W.tau = ReadVectorWithin(node["tau_W"], kMostPush);
  return push;
}

}  // namespace

Waypoint HandScript::IntentAt(double t) const noexcept {
  TANDEM_ASSERT(!waypoints.empty());
  const auto next = std::find_if(waypoints.begin(), waypoints.end(), [t](const Waypoint& waypoint) {
    return waypoint.t > t;
  });
  if (next == waypoints.begin()) return waypoints.front();
  if (next == waypoints.end()) return waypoints.back();
  const Waypoint& from = *(next - 1);
  const double share = MinimumJerk((t - from.t) / (next->t - from.t)).share;
  Waypoint intent;
  intent.t = t;
  intent.p_W = from.p_W + share * (next->p_W - from.p_W);
  const Vec3 turn_W = RotationVector(next->q_W * from.q_W.conjugate());
  intent.q_W = RotationBy(share * turn_W) * from.q_W;
  return intent;
}

Twist HandScript::IntendedTwistAt(double t) const noexcept {
  TANDEM_ASSERT(!waypoints.empty());
  const auto next = std::find_if(waypoints.begin(), waypoints.end(), [t](const Waypoint& waypoint) {
    return waypoint.t > t;
  });
  if (next == waypoints.begin() || next == waypoints.end()) return {};
  const Waypoint& from = *(next - 1);
  const double span = next->t - from.t;
  const double rate = MinimumJerk((t - from.t) / span).rate / span;
  Twist twist;
  twist.v = rate * (next->p_W - from.p_W);
  // the rotation is about one axis fixed in W, so its rotation vector grows along itself
  twist.w = rate * RotationVector(next->q_W * from.q_W.conjugate());
  return twist;
}

Wrench HandScript::PushAt(double t) const noexcept {
  constexpr double kRounding = 1e-6;  // s, far below a frame: clocks add up frames
  Wrench sum;
  for (const Push& push : pushes) {
    const double since = t + kRounding - push.t;
    if (since < 0 || since >= push.lasts) continue;
    sum.f += push.F_D_W.f;
    sum.tau += push.F_D_W.tau;
  }
  return sum;
}

Result<HandScript> LoadHandScript(const std::filesystem::path& file) {
  const Result<JsonFile> json = JsonFile::Read(file);
  if (!json) return json.error();
  const JsonNode root = json->root();
  if (root.Has("bodies")) root.Fault("this is a scene, not a hand's script: --scene takes it");
  root.AllowKeys({"hand", "grasp_B", "waypoints", "pushes"});

  HandScript script;
  if (root.Has("hand")) script.impedance = ReadImpedance(root["hand"]);
  if (root.Has("grasp_B")) script.X_BD = ReadGrasp(root["grasp_B"]);
  for (const JsonNode& node : root["waypoints"].Items()) {
    script.waypoints.push_back(ReadWaypoint(node, script.waypoints));
  }
  if (script.waypoints.empty()) root["waypoints"].Expected("at least one waypoint");
  if (root.Has("pushes")) {
    const std::vector<JsonNode> pushes = root["pushes"].Items();
    if (pushes.size() > kMostPushes) {
      root["pushes"].Fault("more than " + std::to_string(kMostPushes) + " pushes");
    } else {
      for (const JsonNode& node : pushes) script.pushes.push_back(ReadPush(node));
    }
  }
  if (const std::optional<Error> fault = json->fault()) return *fault;
  return script;
}

}  // namespace tandem
