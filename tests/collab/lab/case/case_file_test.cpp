#include "collab/lab/case/case_file.h"

#include <gmock/gmock.h>

#include "collab/lab/case/case_parts.h"
#include "collab/lab/case/prediction.h"
#include "collab/lab/theory/exact_boundary.h"
#include "tests/support/scratch_folder.h"

namespace tandem {
namespace {

using ::testing::HasSubstr;

constexpr const char* kWhole = R"({
  "name": "all of it", "scene": "wall", "users": 3, "hands": ["heavy", {"mass_kg": 0.5, "damping_Ns_m": 2}],
  "motion": "move", "delay_s": 0.3, "publish_hz": 250, "seconds": 20, "seed": 7,
  "law": {"name": "pdopt", "ratio": 0.5, "gate": false, "limits": {"damping_budget": 5}},
  "network": {"jitter_ms": 30, "loss": 0.05, "skew": 0.5,
              "schedule": [{"at_s": 2, "delay_s": 0.5}, {"at_s": 4, "cut": true}, {"at_s": 5}]}
})";

std::string ErrorOf(const std::string& text) {
  const Result<LabCase> test = ParseCase(text, "c.json");
  return test ? "" : test.error().what;
}

// Returns the inertia of a cube of 40 mm and 0.3 kg.
Inertia Cube() {
  return {0.3, 8e-5 * Mat3::Identity()};
}

TEST(CaseFile, IsReadInFull) {
  const Result<LabCase> test = ParseCase(kWhole, "c.json");
  ASSERT_TRUE(test) << test.error().what;
  EXPECT_EQ(test->name, "all of it");
  EXPECT_EQ(test->scene, "wall");
  EXPECT_EQ(test->users, 3U);
  ASSERT_EQ(test->hands.size(), 2U);
  EXPECT_DOUBLE_EQ(test->hands[0].impedance.mass, 1.2);
  EXPECT_DOUBLE_EQ(test->hands[1].impedance.damping, 2);
  EXPECT_DOUBLE_EQ(test->hands[1].impedance.stiffness, 0);
  EXPECT_EQ(test->motion, LabMotion::kMove);
  EXPECT_EQ(test->delay_s, 0.3);
  EXPECT_EQ(test->publish_hz, 250);
  EXPECT_EQ(test->seconds, 20);
  EXPECT_EQ(test->seed, 7U);
  EXPECT_EQ(test->law.name, "pdopt");
  EXPECT_EQ(test->law.ratio, 0.5);
  EXPECT_FALSE(test->law.gate);
  EXPECT_EQ(test->law.limits.damping_budget, 5);
  EXPECT_EQ(test->network.back.jitter_ms, 30);
  EXPECT_EQ(test->network.skew, 0.5);
  ASSERT_EQ(test->network.schedule.size(), 3U);
  EXPECT_EQ(test->network.schedule[1].delay_s, 0.5) << "a delay stays until another is said";
  EXPECT_TRUE(test->network.schedule[1].cut);
  EXPECT_FALSE(test->network.schedule[2].cut);
}

TEST(CaseFile, EveryKeyHasADefault) {
  const Result<LabCase> test = ParseCase("{}", "c.json");
  ASSERT_TRUE(test) << test.error().what;
  EXPECT_EQ(test->scene, "free");
  EXPECT_EQ(test->users, 2U);
  EXPECT_EQ(test->hands[0].name, "relaxed");
  EXPECT_EQ(test->law.name, DefaultLaw()->name());
}

TEST(CaseFile, ErrorsNameThePositionAndTheExpectation) {
  EXPECT_EQ(ErrorOf(R"({"hand": ["off"]})"), "c.json: hand: unknown key; did you mean hands?");
  EXPECT_EQ(ErrorOf(R"({"users": 9})"),
            "c.json: users: expected a whole number from 2 to 8, got 9");
  EXPECT_THAT(ErrorOf(R"({"hands": ["iron"]})"), HasSubstr("hands[0]: no hand of the lab"));
  EXPECT_THAT(ErrorOf(R"({"hands": [{"damping_Ns_m": 1}]})"), HasSubstr("hands[0].mass_kg"));
  EXPECT_THAT(ErrorOf(R"({"law": {"name": "p"}})"), HasSubstr("law.name: no coupling law"));
  EXPECT_THAT(ErrorOf(R"({"law": {"boundary_ratio": 1}})"),
              HasSubstr("law.boundary_ratio: only the law 'constant'"));
  EXPECT_EQ(ErrorOf(R"({"law": {"name": "p+dd", "limits": {"constant_stiffness": 120}}})"),
            "c.json: law.limits.constant_stiffness: the law 'p+dd' does not use it: it uses "
            "damping_budget, stiffness, margin and ratio");
  EXPECT_EQ(ErrorOf(R"({"name": "s", "blocks": [{}]})"),
            "c.json: blocks: this file is a sweep: 'tandem stability sweep' runs it");
  EXPECT_THAT(ErrorOf(R"({"motion": "jump"})"), HasSubstr("motion: expected still, kick"));
  EXPECT_THAT(ErrorOf(R"({"delay_s": 3})"), HasSubstr("delay_s: expected a number of at most"));
  EXPECT_THAT(ErrorOf(R"({"network": "bad"})"), HasSubstr("network: expected clean, lossy"));
  EXPECT_THAT(ErrorOf(R"({"network": {"schedule": [{"at_s": 2}, {"at_s": 1}]}})"),
              HasSubstr("network.schedule[1].at_s: must be later"));
}

// The hand file is looked for beside the case. The hand keeps its own turning, and goes its own way
// whatever the case's motion is. A case with delay begins later: the hand stands until all links
// pull.
TEST(CaseFile, HandMayComeFromAHandFile) {
  const ScratchFolder folder;
  folder.Write("left.json", R"({"hand": {"mass_kg": 2, "rotation": {"inertia_kg_m2": 0.5}},
      "grasp_B": {"p_B": [0, 0, 0.05]},
      "waypoints": [{"t_s": 0, "p_W": [0, 0, 0], "q_xyzw": [0, 0, 0, 1]},
                    {"t_s": 2, "p_W": [0, 0.04, 0], "q_xyzw": [0, 0, 0, 1]}],
      "pushes": [{"t_s": 3, "for_s": 0.5, "f_W": [5, 0, 0], "tau_W": [0, 0, 0]}]})");
  const auto file = folder.Write(
      "case.json", R"({"hands": [{"file": "left.json"}, "off"], "motion": "move", "delay_s": 1})");
  const Result<LabCase> read = LoadCase(file);
  ASSERT_TRUE(read) << read.error().what;
  const LabCase test = FittedTo(Cube(), *read);
  EXPECT_EQ(test.hands[0].name, "left");
  const HandScript script = ScriptOf(test, 0);
  EXPECT_EQ(script.impedance.mass, 2);
  EXPECT_EQ(script.impedance.inertia, 0.5);
  EXPECT_EQ(script.X_BD.p, Vec3(0, 0, 0.05));
  EXPECT_EQ(script.IntentAt(0.5).p_W, Vec3(0, 0, 0));
  EXPECT_EQ(script.IntentAt(2.5).p_W, Vec3(0, 0.04, 0));
  EXPECT_EQ(script.PushAt(3.6).f, Vec3(5, 0, 0));
  EXPECT_EQ(LastInputEnds(test), 4);
}

TEST(CaseFile, ErrorInAHandFileIsOneLineWithItsPosition) {
  const ScratchFolder folder;
  folder.Write("left.json", R"({"waypoints": []})");
  const auto file = folder.Write("case.json", R"({"hands": [{"file": "left.json"}]})");
  const std::string wrong = LoadCase(file).error().what;
  EXPECT_THAT(wrong, HasSubstr("case.json: hands[0].file: "));
  EXPECT_THAT(wrong, HasSubstr("left.json: waypoints"));
  EXPECT_THAT(ErrorOf(R"({"hands": [{"file": "nowhere.json"}]})"), HasSubstr("nowhere.json"));
  EXPECT_THAT(ErrorOf(R"({"hands": [{"file": "a.json", "mass_kg": 1}]})"), HasSubstr("mass_kg"));
}

TEST(CaseParts, AsymmetricDelayKeepsTheRoundTrip) {
  const LabCase test = *ParseCase(R"({"network": "asymmetric", "delay_s": 0.3})", "c.json");
  EXPECT_NEAR(ConditionsOf(test, 0, 1, 0.3).delay_ms, 60, 1e-9);
  EXPECT_NEAR(ConditionsOf(test, 1, 0, 0.3).delay_ms, 540, 1e-9);
  EXPECT_NEAR(LongestDelay(test), 0.54, 1e-12);
}

TEST(CaseParts, HandsOfAFittedCaseTurnAsTheyTravel) {
  const LabCase test = FittedTo(Cube(), *ParseCase(R"({"hands": [{"mass_kg": 2}]})", "c.json"));
  EXPECT_NEAR(test.hands[0].impedance.inertia, 2 * 8e-5 / 0.3, 1e-12);
}

TEST(CaseParts, HandGraspsAtItsOwnOrTheScenesPoint) {
  const LabCase test = *ParseCase(
      R"({"scene": "off_centre", "hands": [{"mass_kg": 1, "grasp_m": [0, 0.1, -0.02]}, "firm"]})",
      "c.json");
  EXPECT_EQ(ScriptOf(test, 0).X_BD.p, Vec3(0, 0.1, -0.02));
  EXPECT_EQ(ScriptOf(test, 1).X_BD.p, Vec3(0.05, 0.02, 0));
  EXPECT_THAT(ErrorOf(R"({"hands": [{"mass_kg": 1, "grasp_m": [0, 2, 0]}]})"),
              HasSubstr("hands[0].grasp_m: expected a place at most 1 m"));
}

// 0.5 kg and 10.3 N s/m, 100 ms late and 1 ms for sending and stepping: 185 N/m (closed form).
TEST(CaseParts, ShareOfTheBoundaryIsConvertedToStiffness) {
  const LabCase test = FittedTo(
      Cube(), *ParseCase(R"({"hands": ["off"], "law": {"name": "constant", "boundary_ratio": 0.5,
                             "limits": {"constant_damping": 10}}})",
                         "c.json"));
  const double critical = CriticalStiffness(0.101, 10.3, 0.5);
  EXPECT_NEAR(test.law.limits.constant_stiffness, 0.5 * critical, 0.01 * critical);
}

// A hand without a spring cannot be moved; one that has its own keeps it.
TEST(CaseParts, MovingHandHasASpring) {
  const LabCase test = *ParseCase(R"({"motion": "hold", "hands": ["relaxed", "firm"]})", "c.json");
  EXPECT_EQ(ScriptOf(test, 0).impedance.stiffness, 300);
  EXPECT_EQ(ScriptOf(test, 1).impedance.stiffness, 800);
  EXPECT_EQ(ScriptOf(test, 0).duration(), 3);
  EXPECT_EQ(ScriptOf(test, 1).duration(), 0);
  EXPECT_EQ(LastInputEnds(test), 3);
}

TEST(CaseParts, LawRatioScalesTheStiffnessOnly) {
  const LabCase test = *ParseCase(R"({"law": {"name": "p+d", "ratio": 0.5}})", "c.json");
  const auto scaled = *LawOf(test.law);
  const auto whole = *MakeLaw("p+d");
  const LawInputs at = LawInputsAt(0.2, 2, 1.5);
  const double k = whole->Link(at).stiffness;
  EXPECT_DOUBLE_EQ(scaled->Link(at).stiffness, 0.5 * k);
  EXPECT_DOUBLE_EQ(scaled->GroundDamping(at, 0.5 * k), whole->GroundDamping(at, k));
}

TEST(CaseFile, ImplausibleNumbersAreRefused) {
  const auto hand = [](const std::string& text) {
    return ErrorOf(R"({"hands": [{)" + text + "}]}");
  };
  EXPECT_THAT(hand(R"("mass_kg": 1e308, "damping_Ns_m": 1e308, "stiffness_N_m": 1e308)"),
              HasSubstr("hands[0].mass_kg: expected a number from 1e-06 to 10000, got 1e+308"));
  EXPECT_THAT(hand(R"("mass_kg": 1e-300)"), HasSubstr("hands[0].mass_kg: expected a number from"));
  EXPECT_THAT(hand(R"("mass_kg": 1, "damping_Ns_m": 1e308)"),
              HasSubstr("hands[0].damping_Ns_m: expected a number from 0 to 1e+07"));
  EXPECT_THAT(hand(R"("mass_kg": 1, "stiffness_N_m": 1e308)"),
              HasSubstr("hands[0].stiffness_N_m: expected a number from 0 to 1e+07"));
  EXPECT_THAT(ErrorOf(R"({"network": {"swing_period_s": 1e-300}})"),
              HasSubstr("network.swing_period_s: expected a number from 0.001 to 1e+06"));
}

TEST(CaseFile, NetworkMayBeATraceFileOrAModel) {
  const ScratchFolder folder;
  folder.Write("line.csv",
               "# {\"tandem_trace\": 1, \"rate_hz\": 100}\nseq,there_ms,back_ms\n0,10,30\n1,,50\n");
  const auto load = [&folder](const std::string& text) {
    Result<LabCase> test = LoadCase(folder.Write("case.json", text));
    EXPECT_TRUE(test) << test.error().what;
    return *test;
  };
  const LabCase test = load(R"({"network": {"trace": "line.csv", "stretch": 2, "start_s": 3,
                                            "loss": 0.1, "name": "ours"}, "seconds": 5})");
  ASSERT_NE(test.network.there.trace, nullptr);
  EXPECT_EQ(test.network.there.trace->facts().longest_ms, 20);
  EXPECT_EQ(test.network.back.trace->facts().longest_ms, 100);
  EXPECT_EQ(test.network.there.loss, 0.1);
  EXPECT_EQ(test.delay_s, 0) << "the trace has the delays";
  EXPECT_NEAR(test.MeanPathLength(), 0.5 * (0.020 + 0.080), 1e-9);
  EXPECT_NEAR(LongestDelay(test), 0.1, 1e-9);
  for (const std::size_t from : {0U, 1U}) {
    const LinkConditions way = ConditionsOf(test, from, 1 - from, test.delay_s);
    EXPECT_EQ(way.trace, from == 0 ? test.network.there.trace : test.network.back.trace);
    EXPECT_EQ(way.trace_start_s, 3);
  }
  EXPECT_EQ(load(R"({"network": {"trace": "line.csv"}, "delay_s": 0.2})").delay_s, 0.2);
  const LabCase model = load(R"({"network": "geo"})");
  EXPECT_EQ(model.network.name, "geo");
  EXPECT_EQ(model.delay_s, 0);
  EXPECT_GT(model.DefaultDuration(), 11.9);
  LabCase other = model;
  other.seed = 2;
  EXPECT_NE(ConditionsOf(model, 0, 1, 0).trace_start_s, ConditionsOf(other, 0, 1, 0).trace_start_s);
  EXPECT_EQ(ConditionsOf(model, 0, 1, 0).trace_start_s, ConditionsOf(model, 1, 0, 0).trace_start_s);
  EXPECT_THAT(ErrorOf(R"({"network": {"trace": "none.csv"}})"), HasSubstr("network.trace: "));
}

}  // namespace
}  // namespace tandem
