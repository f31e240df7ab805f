#include "engine/haptics/hand_script.h"

#include <string>

#include <gmock/gmock.h>

#include "tests/support/scratch_folder.h"

namespace tandem {
namespace {

const std::string kHand = R"({
  "hand": {"mass_kg": 0.8, "damping_Ns_m": 12, "stiffness_N_m": 250,
           "rotation": {"inertia_kg_m2": 0.002, "damping_Nms_rad": 0.03, "stiffness_Nm_rad": 4}},
  "grasp_B": {"p_B": [0, 0, 0.05], "q_xyzw": [1, 0, 0, 0]},
  "waypoints": [
    {"t_s": 0, "p_W": [0, 0, 0], "q_xyzw": [0, 0, 0, 1]},
    {"t_s": 2, "p_W": [0.04, 0, 0], "q_xyzw": [0, 0, 0, 1]},
    {"t_s": 3, "p_W": [0.04, 0, 0.1], "q_xyzw": [0, 0, 0.7071067811865476, 0.7071067811865476]}
  ],
  "pushes": [
    {"t_s": 1, "for_s": 0.05, "f_W": [5, 0, 0]},
    {"t_s": 1.02, "for_s": 2, "f_W": [0, 1, 0], "tau_W": [0, 0, 0.1]}
  ]
})";

HandScript Script() {
  const ScratchFolder folder;
  const Result<HandScript> script = LoadHandScript(folder.Write("hand.json", kHand));
  EXPECT_TRUE(script) << script.error().what;
  return *script;
}

std::string ErrorAfter(const std::string& from, const std::string& to) {
  const ScratchFolder folder;
  std::string text = kHand;
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  text.replace(at, from.size(), to);
  const Result<HandScript> script = LoadHandScript(folder.Write("hand.json", text));
  if (script) return "no error";
  const std::string start = (folder.path() / "hand.json").string() + ": ";
  EXPECT_EQ(script.error().what.substr(0, start.size()), start);
  return script.error().what.substr(start.size());
}

TEST(HandFile, IsReadInFull) {
  const HandScript script = Script();
  EXPECT_EQ(script.impedance.mass, 0.8);
  EXPECT_EQ(script.impedance.damping, 12.0);
  EXPECT_EQ(script.impedance.stiffness, 250.0);
  EXPECT_EQ(script.impedance.inertia, 0.002);
  EXPECT_EQ(script.impedance.rotation_damping, 0.03);
  EXPECT_EQ(script.impedance.rotation_stiffness, 4.0);
  EXPECT_EQ(script.X_BD.p, Vec3(0, 0, 0.05));
  EXPECT_EQ(script.X_BD.q.x(), 1.0);
  ASSERT_EQ(script.waypoints.size(), 3U);
  EXPECT_EQ(script.duration(), 3.0);
  ASSERT_EQ(script.pushes.size(), 2U);
  EXPECT_EQ(script.pushes[1].t, 1.02);
  EXPECT_EQ(script.pushes[1].lasts, 2.0);
  EXPECT_EQ(script.pushes[1].F_D_W.tau, Vec3(0, 0, 0.1));
}

TEST(HandScript, SumsSimultaneousPushes) {
  const HandScript script = Script();
  EXPECT_EQ(script.PushAt(0.99).f, Vec3::Zero());
  EXPECT_EQ(script.PushAt(1.01).f, Vec3(5, 0, 0));
  EXPECT_EQ(script.PushAt(1.03).f, Vec3(5, 1, 0));
  EXPECT_EQ(script.PushAt(1.06).f, Vec3(0, 1, 0));
  EXPECT_EQ(script.PushAt(3.03).f, Vec3::Zero());
}

TEST(HandFile, ErrorsNameThePositionAndTheExpectation) {
  EXPECT_EQ(ErrorAfter("\"for_s\": 2", "\"for_s\": 0"),
            "pushes[1].for_s: expected a number from 0.001 to 1e+06, got 0");
  EXPECT_EQ(ErrorAfter("\"t_s\": 3", "\"t_s\": 2"),
            "waypoints[2].t_s: expected a number above 2, got 2");
  EXPECT_EQ(ErrorAfter("\"t_s\": 0", "\"t_s\": 0.5"),
            "waypoints[0].t_s: expected 0, where the hand starts, got 0.5");
  EXPECT_EQ(ErrorAfter("\"p_W\": [0, 0, 0]", "\"p_W\": [0, 0, 0.1]"),
            "waypoints[0].p_W: expected [0, 0, 0], where the body is at first, got [0,0,0.1]");
  EXPECT_EQ(ErrorAfter("\"q_xyzw\": [0, 0, 0, 1]", "\"q_xyzw\": [0, 0, 1, 0]"),
            "waypoints[0].q_xyzw: expected [0, 0, 0, 1], as the body stands at first, got "
            "[0,0,1,0]");
  EXPECT_EQ(ErrorAfter("\"mass_kg\": 0.8", "\"mass_kg\": 0"),
            "hand.mass_kg: expected a number from 1e-06 to 10000, got 0");
  EXPECT_EQ(ErrorAfter("\"damping_Nms_rad\": 0.03", "\"damping_Nms_rad\": -0.03"),
            "hand.rotation.damping_Nms_rad: expected a number from 0 to 1e+07, got -0.03");
  EXPECT_EQ(ErrorAfter("\"stiffness_Nm_rad\"", "\"stiffness_N_m\""),
            "hand.rotation.stiffness_N_m: unknown key; did you mean stiffness_Nm_rad?");
  EXPECT_EQ(ErrorAfter("\"waypoints\"", "\"way_points\""),
            "way_points: unknown key; did you mean waypoints?");
}

TEST(HandFile, WaypointRotationIsOptional) {
  const ScratchFolder folder;
  const Result<HandScript> script = LoadHandScript(folder.Write(
      "hand.json",
      R"({"waypoints": [{"t_s": 0, "p_W": [0, 0, 0]}, {"t_s": 1, "p_W": [0, 0, 0.1]}]})"));
  ASSERT_TRUE(script) << script.error().what;
  EXPECT_EQ(script->waypoints[1].q_W.coeffs(), Quat::Identity().coeffs());
  EXPECT_EQ(script->IntentAt(1).p_W, Vec3(0, 0, 0.1));
}

TEST(HandFile, WithoutWaypointsIsAnError) {
  const ScratchFolder folder;
  const Result<HandScript> script =
      LoadHandScript(folder.Write("hand.json", R"({"waypoints": []})"));
  ASSERT_FALSE(script);
  EXPECT_THAT(script.error().what,
              ::testing::EndsWith("waypoints: expected at least one waypoint, got []"));
}

TEST(HandScript, PassesItsWaypointsAndStaysAtTheLast) {
  const HandScript script = Script();
  EXPECT_TRUE(script.IntentAt(0).p_W.isZero());
  EXPECT_TRUE(script.IntentAt(2).p_W.isApprox(Vec3(0.04, 0, 0), 1e-12));
  for (const double t : {3.0, 3.5, 100.0}) {
    EXPECT_TRUE(script.IntentAt(t).p_W.isApprox(Vec3(0.04, 0, 0.1), 1e-12));
    EXPECT_NEAR(RotationVector(script.IntentAt(t).q_W).z(), M_PI / 2, 1e-9);
    EXPECT_TRUE(script.IntendedTwistAt(t).v.isZero());
    EXPECT_TRUE(script.IntendedTwistAt(t).w.isZero());
  }
}

TEST(HandScript, MovesWithMinimumJerk) {
  const HandScript script = Script();
  // half way at half time, at 15/8 of the mean speed; 10/64 - 15/256 + 6/1024 = 0.103515625 at a
  // quarter
  EXPECT_NEAR(script.IntentAt(1).p_W.x(), 0.02, 1e-12);
  EXPECT_NEAR(script.IntendedTwistAt(1).v.x(), 0.02 * 15.0 / 8.0, 1e-12);
  EXPECT_NEAR(script.IntentAt(0.5).p_W.x(), 0.04 * 0.103515625, 1e-12);
  // a quarter turn has turned by an eighth at half time
  EXPECT_NEAR(RotationVector(script.IntentAt(2.5).q_W).z(), M_PI / 4, 1e-9);
  // at rest at the waypoints
  EXPECT_TRUE(script.IntendedTwistAt(0).v.isZero());
  EXPECT_TRUE(script.IntendedTwistAt(2).v.isZero(1e-12));
}

TEST(HandScript, IntendedTwistIsTheRateOfTheIntent) {
  const HandScript script = Script();
  constexpr double kStep = 1e-5;
  for (double t = 0.05; t < 3.0; t += 0.1) {
    const Waypoint before = script.IntentAt(t - kStep);
    const Waypoint after = script.IntentAt(t + kStep);
    const Twist twist = script.IntendedTwistAt(t);
    EXPECT_TRUE(twist.v.isApprox((after.p_W - before.p_W) / (2 * kStep), 1e-4) ||
                twist.v.norm() < 1e-6);
    const Vec3 w = RotationVector(after.q_W * before.q_W.conjugate()) / (2 * kStep);
    EXPECT_LT((twist.w - w).norm(), 1e-4);
  }
}

TEST(HandScript, RotatesTheShortWay) {
  HandScript script = Script();
  for (Waypoint& waypoint : script.waypoints) waypoint.q_W.coeffs() *= -1.0;
  script.waypoints[1].q_W.coeffs() *= -1.0;
  EXPECT_NEAR(RotationVector(script.IntentAt(2.5).q_W).z(), M_PI / 4, 1e-9);
}

TEST(HandFile, ImplausibleNumbersAreRefused) {
  EXPECT_EQ(ErrorAfter(R"("mass_kg": 0.8)", R"("mass_kg": 1e308)"),
            "hand.mass_kg: expected a number from 1e-06 to 10000, got 1e+308");
  EXPECT_EQ(ErrorAfter(R"("damping_Ns_m": 12)", R"("damping_Ns_m": 1e308)"),
            "hand.damping_Ns_m: expected a number from 0 to 1e+07, got 1e+308");
  EXPECT_EQ(ErrorAfter(R"("inertia_kg_m2": 0.002)", R"("inertia_kg_m2": 1e308)"),
            "hand.rotation.inertia_kg_m2: expected a number from 1e-12 to 10000, got 1e+308");
  EXPECT_EQ(ErrorAfter(R"("p_B": [0, 0, 0.05])", R"("p_B": [0, 0, 1e300])"),
            "grasp_B.p_B: expected numbers from -1000 to 1000, got [0,0,1e+300]");
  EXPECT_EQ(ErrorAfter(R"("p_W": [0.04, 0, 0])", R"("p_W": [1001, 0, 0])"),
            "waypoints[1].p_W: expected numbers from -1000 to 1000, got [1001,0,0]");
  EXPECT_EQ(ErrorAfter(R"("f_W": [5, 0, 0])", R"("f_W": [0, -1e200, 0])"),
            "pushes[0].f_W: expected numbers from -10000 to 10000, got [0,-1e+200,0]");
  EXPECT_EQ(ErrorAfter(R"("tau_W": [0, 0, 0.1])", R"("tau_W": [0, 0, 1e200])"),
            "pushes[1].tau_W: expected numbers from -10000 to 10000, got [0,0,1e+200]");
  EXPECT_EQ(ErrorAfter(R"("for_s": 0.05)", R"("for_s": 1e-300)"),
            "pushes[0].for_s: expected a number from 0.001 to 1e+06, got 1e-300");
}

}  // namespace
}  // namespace tandem
