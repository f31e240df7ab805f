#include "scenes/generators/large/landing_gear.h"

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "app/bench/measure/scripted_frames.h"
#include "app/judgement/demo_judgement.h"
#include "engine/world/world.h"
#include "tests/support/scratch_folder.h"

// Tests the removal of the paper's section 7, from the nest alone. `tandem bench removal` has the
// whole gear round it.

namespace tandem {
namespace {

/// The nest with the actuator, at the scene's own sizes.
class ActuatorInItsNest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new ScratchFolder;
    const GeneratedScene scene = LandingGear(MakeLandingGear(LandingGearParts::kNest));
    ASSERT_FALSE(WriteScene(scene, folder_->path()));
    const std::filesystem::path file = folder_->path() / "landing_gear.json";
    std::filesystem::copy_file(std::filesystem::path(TANDEM_SCENE_FILES) / "landing_gear.json",
                               file);
    model_ = new std::shared_ptr<const WorldModel>(LinearizedForce({}));
    ASSERT_NE(*model_, nullptr);
  }
  static std::shared_ptr<const WorldModel> LinearizedForce(const LoadOptions& options) {
    const Result<Scene> loaded = LoadScene(folder_->path() / "landing_gear.json");
    EXPECT_TRUE(loaded) << loaded.error().what;
    const auto world = LoadWorld(*loaded, options);
    EXPECT_TRUE(world) << world.error().what;
    return world ? *world : nullptr;
  }
  static void TearDownTestSuite() {
    delete model_;
    delete folder_;
  }

  struct Removal {
    Outcome outcome;
    long in_contact = 0;  // frames
    float most_N = 0;     // in the hand
    Pose X_WB;            // at the end
    std::uint64_t pages = 0;
  };
  static Removal By(const std::string& hand) { return By(hand, *model_); }
  static Removal By(const std::string& hand, const std::shared_ptr<const WorldModel>& model) {
    const Result<HandScript> script = LoadHandScript(folder_->path() / hand);
    EXPECT_TRUE(script) << script.error().what;
    World world(model);
    ScriptedHand holds(world, *script);
    StepInputs inputs = ParkedInputs(*model);
    inputs.instances[0].drive = BodyDrive::kSimulated;
    inputs.hand = {.body = 0,
                   .X_BD = script->X_BD,
                   .goal = {},
                   .gains = DefaultHandGains(model->bodies[0].inertia)};
    Removal removal;
    StepReport report;
    const auto frames = static_cast<std::int64_t>(1e3 * (script->duration() + 2));
    for (std::int64_t frame = 0; frame < frames; ++frame) {
      inputs.hand.goal = holds(frame, report);
      report = world.Step(inputs);
      // nobody moves the hand while voxels are waited for
      for (int waits = 0; report.waited > 0 && waits < 1000; ++waits) {
        world.WaitForVoxels();
        report = world.Step(inputs);
      }
      removal.in_contact += report.contact_points > 0 ? 1 : 0;
      removal.most_N = std::max(removal.most_N, static_cast<float>(report.hand_B_W.f.norm()));
    }
    removal.X_WB = world.state(0).X_WB;
    removal.outcome = OutcomeOf(*model, 0, removal.X_WB);
    if (world.resident_voxels() != nullptr) {
      removal.pages = world.resident_voxels()->counts().pages_read;
    }
    return removal;
  }

  static constexpr std::uint64_t kVoxelMemory = std::uint64_t{6} << 20U;
  static inline ScratchFolder* folder_ = nullptr;
  static inline std::shared_ptr<const WorldModel>* model_ = nullptr;
};

TEST_F(ActuatorInItsNest, LeavesByTheIntendedPathInContact) {
  for (const char* hand : {"landing_gear_rod.json", "landing_gear_barrel.json"}) {
    const Removal removal = By(hand);
    EXPECT_TRUE(removal.outcome.out) << hand;
    EXPECT_GT(removal.in_contact, 1000) << hand;
    EXPECT_LT(removal.most_N, 30) << hand;
  }
}

TEST_F(ActuatorInItsNest, ExitIsBitIdenticalWithVoxelsComputedOnDemand) {
  const auto in_part = LinearizedForce({.voxel_memory_bytes = kVoxelMemory});
  ASSERT_NE(in_part, nullptr);
  ASSERT_NE(in_part->fixture_pages, nullptr) << "all voxels fit";
  const Removal whole = By("landing_gear_rod.json");
  const Removal paged = By("landing_gear_rod.json", in_part);
  EXPECT_TRUE(paged.outcome.out);
  EXPECT_GT(paged.pages, 20U);
  EXPECT_EQ(paged.in_contact, whole.in_contact);
  EXPECT_EQ(std::memcmp(&paged.X_WB, &whole.X_WB, sizeof(Pose)), 0);
}

TEST_F(ActuatorInItsNest, JamsWhereItIsLiftedBeforeItIsFree) {
  const Removal removal = By("landing_gear_hasty.json");
  EXPECT_FALSE(removal.outcome.out);
  EXPECT_LT(removal.outcome.travel, 0.03);
  EXPECT_GT(removal.most_N, 100);
}

}  // namespace
}  // namespace tandem
