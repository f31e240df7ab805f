#include "scenes/generators/hand_file.h"

#include <cmath>

#include <nlohmann/json.hpp>

namespace tandem {
namespace {

using Json = nlohmann::ordered_json;

// rounds to a micrometre and a microradian, so that people can read the file too
double Rounded(double value) {
  return std::round(value * 1e6) / 1e6 + 0.0;
}

Json Row(const Vec3& p) {
  return {Rounded(p.x()), Rounded(p.y()), Rounded(p.z())};
}

Json Row(const Quat& q) {
  return {Rounded(q.x()), Rounded(q.y()), Rounded(q.z()), Rounded(q.w())};
}

}  // namespace

std::string HandFile(const HandScript& script) {
  const HandImpedance& hand = script.impedance;
  Json json;
  json["hand"] = {{"mass_kg", hand.mass},
                  {"damping_Ns_m", hand.damping},
                  {"stiffness_N_m", hand.stiffness},
                  {"rotation",
                   {{"inertia_kg_m2", hand.inertia},
                    {"damping_Nms_rad", hand.rotation_damping},
                    {"stiffness_Nm_rad", hand.rotation_stiffness}}}};
  json["grasp_B"] = {{"p_B", Row(script.X_BD.p)}, {"q_xyzw", Row(script.X_BD.q)}};
  json["waypoints"] = Json::array();
  for (const Waypoint& waypoint : script.waypoints) {
    json["waypoints"].push_back(
        {{"t_s", Rounded(waypoint.t)}, {"p_W", Row(waypoint.p_W)}, {"q_xyzw", Row(waypoint.q_W)}});
  }
  for (const Push& push : script.pushes) {
    json["pushes"].push_back({{"t_s", Rounded(push.t)},
                              {"for_s", Rounded(push.lasts)},
                              {"f_W", Row(push.F_D_W.f)},
                              {"tau_W", Row(push.F_D_W.tau)}});
  }
  return json.dump(2) + "\n";
}

}  // namespace tandem
