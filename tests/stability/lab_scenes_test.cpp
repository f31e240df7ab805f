#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include <gtest/gtest.h>

#include "collab/lab/case/case_file.h"
#include "collab/lab/run/case_run.h"
#include "tests/support/scratch_folder.h"

namespace tandem {
namespace {

const std::filesystem::path kFolder = std::filesystem::path(TANDEM_SCENES) / "stability";

LabScene SceneOf(const LabCase& test) {
  const Result<LabScene> scene = LoadLabScene(test, kFolder);
  EXPECT_TRUE(scene) << scene.error().what;
  return *scene;
}

LabCase Case(const std::string& scene, const std::string& motion, const std::string& law) {
  const Result<LabCase> test =
      ParseCase(R"({"hands": ["heavy"], "scene": ")" + scene + R"(", "motion": ")" + motion +
                    R"(", "law": )" + law + "}",
                "case");
  EXPECT_TRUE(test) << test.error().what;
  return *test;
}

void ExpectCalm(const CaseResult& run) {
  ASSERT_FALSE(run.fault) << run.fault->what;
  EXPECT_EQ(run.verdict, Verdict::kStable) << run.metrics.growth << " " << run.metrics.tail_rms;
  EXPECT_LT(run.metrics.tail_rms, 2e-3);
  EXPECT_LE(run.metrics.generated_J, 1e-3);
  EXPECT_EQ(run.metrics.trapped_frames, 0);
}

constexpr const char* kDefaultLaw = R"({"gate": false})";

// One user leans on what is there, and one is pulled away from it. The hands are heavy. The ball
// has no friction, so it goes on swinging in its socket for a second, across the user's push.
TEST(LabScenes, AreStableUnderTheDefaultLawInContact) {
  for (const char* name : {"wall", "slot", "ball"}) {
    const LabScene scene = SceneOf(Case(name, "press", kDefaultLaw));
    const Vec3 swings = std::string(name) == "ball" ? Vec3(0, 1, 1) : Vec3(0, 0, 0);
    for (const char* motion : {"press", "pull_off"}) {
      SCOPED_TRACE(std::string(name) + ", " + motion);
      LabCase test = Case(name, motion, kDefaultLaw);
      double leaning = 0;
      double swinging = 0;
      double last = 0;
      const CaseResult run =
          RunCase(test, scene, [&](double t_s, std::span<const UserFrame> users) {
            const Vec3& v = users[1].state.V_WB.v;
            last = v.norm();
            // both lean along x with 2 N, and the scene holds them
            if (t_s <= 2.9 || t_s >= 3) return;
            leaning = std::max(leaning, (v - swings.cwiseProduct(v)).norm());
            swinging = std::max(swinging, swings.cwiseProduct(v).norm());
          });
      ExpectCalm(run);
      EXPECT_LT(leaning, 1e-3) << "2 N would move it by 0.15 m/s";
      EXPECT_LT(swinging, 2e-3);
      EXPECT_LT(last, 1e-5);
    }
  }
}

// Voxels of 2 mm are for speed. Leaning on the ball's socket is as calm with voxels of half the
// size.
TEST(LabScenes, BallIsStableWithFinerVoxels) {
  const ScratchFolder finer;
  for (const char* mesh : {"ball.stl", "socket.stl"}) {
    std::filesystem::copy_file(kFolder / mesh, finer.path() / mesh);
  }
  std::ostringstream text;
  text << std::ifstream(kFolder / "ball.json").rdbuf();
  std::string scene = text.str();
  const std::size_t at = scene.find("\"voxel_m\": 0.002");
  ASSERT_NE(at, std::string::npos);
  finer.Write("ball.json", scene.replace(at, 16, "\"voxel_m\": 0.001"));
  for (const char* motion : {"press", "kick"}) {
    SCOPED_TRACE(motion);
    const LabCase test = Case("ball", motion, kDefaultLaw);
    const Result<LabScene> loaded = LoadLabScene(test, finer.path());
    ASSERT_TRUE(loaded) << loaded.error().what;
    ExpectCalm(RunCase(test, *loaded));
  }
}

// A knock 54 mm from the centre turns the body. Growth, tail and energy count that.
TEST(LabScenes, OffCentreGraspRotatesTheBodyStably) {
  const LabCase test = Case("off_centre", "kick", kDefaultLaw);
  const CaseResult run = RunCase(test, SceneOf(test));
  ExpectCalm(run);
  EXPECT_GT(run.metrics.peak_turn, 0.1);
}

TEST(LabScenes, FaultsNameTheFileAndTheBody) {
  LabCase test = Case("free", "kick", kDefaultLaw);
  test.body = "handle";
  const Result<LabScene> scene = LoadLabScene(test, kFolder);
  ASSERT_FALSE(scene);
  EXPECT_EQ(scene.error().what, (kFolder / "free.json").string() + ": there is no body 'handle'");
}

// The network has delays of 20, 300, 50, 1000 and 20 ms, outages of 1.5 s and 3.5 s, and jitter and
// loss at 100 Hz, while a hand goes to and fro. There is no energy, nothing for the gate to do, and
// no step of the links above 1 N in a frame.
TEST(LabScenes, DefaultLawSurvivesDelayJumpsAndOutages) {
  const Result<LabCase> test = LoadCase(kFolder / "adversarial.json");
  ASSERT_TRUE(test) << test.error().what;
  const CaseResult run = RunCase(*test, SceneOf(*test));
  ExpectCalm(run);
  EXPECT_EQ(run.metrics.clip_share, 0.0);
  EXPECT_LT(run.metrics.peak_apart, 0.3);
  EXPECT_LE(run.metrics.link_force_rate, 1000);
}

// The same network with 200 N/m and no drag blows up. The gate holds it within its credits: 0.1 J
// for every end of a link that has begun, of which there are two more after each outage.
TEST(LabScenes, FixedStiffnessNeedsTheEnergyGate) {
  Result<LabCase> test = LoadCase(kFolder / "adversarial.json");
  ASSERT_TRUE(test) << test.error().what;
  test->hands = {*HandNamed("off", Inertia{})};
  test->motion = LabMotion::kKick;
  test->law.name = "constant";
  test->law.gate = false;
  const LabScene scene = SceneOf(*test);
  const CaseResult without = RunCase(*test, scene);
  EXPECT_EQ(without.verdict, Verdict::kUnstable);
  EXPECT_GT(without.metrics.generated_J, 0.5);
  test->law.gate = true;
  std::array<std::size_t, 2> links{};
  int ends = 0;
  double made = 0;  // J
  double most_over = -1;
  const CaseResult with = RunCase(*test, scene, [&](double, std::span<const UserFrame> users) {
    for (std::size_t user = 0; user < links.size(); ++user) {
      const UserFrame& frame = users[user];
      if (frame.link_count > links[user]) ++ends;
      links[user] = frame.link_count;
      if (frame.link_count == 0) continue;
      const Twist& V = frame.state.V_WB;
      made += 1e-3 * (frame.links_B_W[0].f.dot(V.v) + frame.links_B_W[0].tau.dot(V.w));
    }
    most_over = std::max(most_over, made - 0.1 * ends);
  });
  EXPECT_EQ(ends, 3 * 2);
  EXPECT_LE(most_over, 0.0);
  EXPECT_LE(with.metrics.generated_J, 0.6);
  EXPECT_GT(with.metrics.clip_share, 0.0);
  EXPECT_FALSE(with.metrics.diverged);
}

}  // namespace
}  // namespace tandem
