// Tests `tandem contact` on a box above a plate, and on real parts at poses that another collision
// library judged by exact triangles. The parts are not in the tree: TANDEM_MODELS names their
// folder, and without it their tests are skipped. A few small pairs run by default.
// TANDEM_ALL_POSES runs all of them (minutes).
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include "app/common/exit_codes.h"
#include "tests/app/cli/program_run.h"
#include "tests/engine/geometry/import/mesh_file_samples.h"
#include "tests/support/obj_text.h"
#include "tests/support/scratch_folder.h"

namespace tandem {
namespace {

namespace fs = std::filesystem;

using testing::BoxObjText;
using ::testing::HasSubstr;
using testing::ProgramOutput;
using testing::RunTandem;

std::vector<std::string> Cells(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream stream(line);
  for (std::string cell; std::getline(stream, cell, ',');) cells.push_back(cell);
  return cells;
}

/// A cube whose lower face is 0.3 voxels above a plate, in voxels of 1 mm.
class ContactCommand : public ::testing::Test {
 protected:
  ContactCommand() {
    folder_.Write("plate.obj", BoxObjText(0.04, 0.04, 0.005));
    folder_.Write("cube.obj", BoxObjText(0.01, 0.01, 0.01));
    folder_.Write("poses.csv",
                  "fixed,moving,tx,ty,tz,ax,ay,az,angle_deg\n"
                  "plate.obj,cube.obj,0.0001,0.0002,0.0153,0,0,1,0\n");
  }
  ProgramOutput Run(const std::string& options) const {
    const std::string folder = folder_.path().string();
    return RunTandem("contact --csv --static " + folder + "/plate.obj --dynamic " + folder +
                     "/cube.obj --voxel 0.001 --poses " + folder + "/poses.csv " + options);
  }
  /// Returns the force along z of the only pose, N.
  static double ForceOf(const ProgramOutput& output) {
    return std::stod(Cells(output.out.substr(output.out.find('\n') + 1)).at(5));
  }

  ScratchFolder folder_;
};

// A pair that presses with 45.6 N must not be answered with no force.
TEST_F(ContactCommand, RefusesAnUnsafeLayerAndSuggestsASafeOne) {
  const ProgramOutput refused = Run("--force-layer 0");
  EXPECT_EQ(refused.exit_code, kExitUsage);
  EXPECT_TRUE(refused.out.empty()) << refused.out;
  EXPECT_THAT(refused.err, HasSubstr("--force-layer: refined contact misses contacts at force "
                                     "layer 0: layer 1 finds them all"));
  EXPECT_EQ(std::count(refused.err.begin(), refused.err.end(), '\n'), 1) << refused.err;
  EXPECT_EQ(Run("--contact plain --force-layer 0").exit_code, kExitOk);
}

TEST_F(ContactCommand, UsesTheModelsDefaultLayer) {
  const ProgramOutput output = Run("");
  ASSERT_EQ(output.exit_code, kExitOk) << output.err;
  // four corners and the twenty voxels of each of four edges are 0.15 voxels within the clearance,
  // on springs of 0.25 m / h^2, which are as stiff as they can be from a tenth of a voxel on
  const double spring = 0.25 * 0.3 / 1e-6;
  const double each = spring * 1e-3 * (0.15 - 0.05 + 0.15 * 8 * std::pow(0.15, 3));
  EXPECT_NEAR(ForceOf(output), (4 + 4 * 20) * each, 0.5);
  EXPECT_EQ(output.out, Run("--force-layer 1").out);
  const ProgramOutput plain = Run("--contact plain");
  EXPECT_EQ(plain.out, Run("--contact plain --force-layer 2").out);
  EXPECT_GT(ForceOf(plain), 0);
}

// In metres the part would be too large for such voxels.
TEST_F(ContactCommand, TakesA3mfFileInTheUnitThatItDeclares) {
  const ScratchFolder folder;
  const std::string file = folder.Write("two.3mf", testing::ThreeMf("")).string();
  const std::string poses = folder
                                .Write("poses.csv",
                                       "fixed,moving,tx,ty,tz,ax,ay,az,angle_deg\n"
                                       "two.3mf,two.3mf,0.1,0,0,0,0,1,0\n")
                                .string();
  const ProgramOutput output = RunTandem("contact --voxel 0.0001 --static " + file + " --dynamic " +
                                         file + " --poses " + poses + " --csv");
  EXPECT_EQ(output.exit_code, kExitOk) << output.err;
  EXPECT_THAT(output.err, HasSubstr("0 of 1 pose touch"));
}

TEST_F(ContactCommand, TakesPointsFinerThanVoxelsAndNoneCoarser) {
  const ProgramOutput one = Run("");
  const ProgramOutput finer = Run("--spacing 0.0004");
  ASSERT_EQ(finer.exit_code, kExitOk) << finer.err;
  EXPECT_NEAR(ForceOf(finer), ForceOf(one), 0.5);  // finer parts of edges weigh less each
  const auto points = [](const ProgramOutput& output) {
    return std::stoi(output.err.substr(output.err.find("; ") + 2));
  };
  EXPECT_GT(points(finer), 2 * points(one));
  const ProgramOutput coarser = Run("--spacing 0.002");
  EXPECT_EQ(coarser.exit_code, kExitUsage);
  EXPECT_THAT(coarser.err, HasSubstr("--spacing: expected at most the size of --voxel"));
}

/// Two parts, and the voxel size at which some free poses are far and the rest are told apart.
struct Pair {
  const char* fixed;
  const char* moving;
  double voxel;  // m
  double scale;  // m per file unit
  bool quick;
  int far;          // poses farther apart than kFarVoxels
  int without = 0;  // colliding poses in which no point is in contact by the class rule
};

constexpr std::array kPairs{
    Pair{"factory/factory_bolt_m16_loose.obj", "factory/factory_nut_m16_loose_subdiv_3x.obj", 25e-6,
         1, false, 10},
    Pair{"factory/factory_bolt_m16_tight.obj", "factory/factory_nut_m16_tight_subdiv_3x.obj",
         23.09e-6, 1, false, 0},
    Pair{"factory/factory_round_hole_16mm_subdiv_3x.obj",
         "factory/factory_round_peg_16mm_loose.obj", 60e-6, 1, true, 6},
    Pair{"factory/factory_round_hole_16mm_subdiv_3x.obj",
         "factory/factory_round_peg_16mm_tight.obj", 60e-6, 1, false, 4},
    Pair{"factory/factory_round_hole_8mm_subdiv_3x.obj", "factory/factory_round_peg_8mm_tight.obj",
         13e-6, 1, false, 3},
    Pair{"factory/factory_rectangular_hole_8mm_subdiv_3x.obj",
         "factory/factory_rectangular_peg_8mm_loose_subdiv_3x.obj", 22e-6, 1, false, 4},
    Pair{"factory/factory_gear_base_loose_space_5e-4_subdiv_4x.obj",
         "factory/factory_gear_small_space_5e-4.obj", 110e-6, 1, true, 1},
    Pair{"rigid-ipc/092-piston/crank.stl", "rigid-ipc/092-piston/connecting-rod.stl", 1.2e-3, 1e-3,
         false, 1},
    Pair{"rigid-ipc/092-piston/connecting-rod.stl", "rigid-ipc/092-piston/head.stl", 1.2e-3, 1e-3,
         false, 1},
    Pair{"rigid-ipc/092-piston/head.stl", "rigid-ipc/092-piston/cylinder.stl", 0.8e-3, 1e-3, false,
         1},
    Pair{"rigid-ipc/092-piston/connecting-rod.stl", "rigid-ipc/092-piston/cylinder.stl", 40e-6,
         1e-3, true, 25},
    Pair{"rigid-ipc/140-punching-press/fixed.off", "rigid-ipc/140-punching-press/p1.off", 76.35e-6,
         1e-3, false, 0},
    Pair{"rigid-ipc/140-punching-press/fixed.off", "rigid-ipc/140-punching-press/p3.off", 53.24e-6,
         1e-3, false, 0},
    // the edge of a bar lies 3.5 voxels deep in a wall that has no vertex within the bar
    Pair{"rigid-ipc/140-punching-press/fixed.off", "rigid-ipc/140-punching-press/p5.off", 43.24e-6,
         1e-3, true, 0, 2},
    Pair{"rigid-ipc/140-punching-press/p1.off", "rigid-ipc/140-punching-press/p2.off", 50.09e-6,
         1e-3, true, 1},
    Pair{"rigid-ipc/140-punching-press/p2.off", "rigid-ipc/140-punching-press/p3.off", 53.24e-6,
         1e-3, false, 0},
    Pair{"rigid-ipc/140-punching-press/p3.off", "rigid-ipc/140-punching-press/p4.off", 53.36e-6,
         1e-3, false, 0},
    Pair{"rigid-ipc/140-punching-press/p4.off", "rigid-ipc/140-punching-press/p5.off", 43.24e-6,
         1e-3, false, 0}};

constexpr double kFarVoxels = 2.6;       // beyond it nothing may touch at layer 0
constexpr double kTouchingUnits = 1e-6;  // below it the reference is not sure

void PrintTo(const Pair& pair, std::ostream* out) {
  *out << fs::path(pair.moving).stem().string() << " in " << fs::path(pair.fixed).stem().string();
}

/// The program's answer for one pose.
struct PoseAnswer {
  int contact_points = 0;
  int touching_points = 0;
  double force = 0;  // N
};

class PosesOfRealParts : public ::testing::TestWithParam<Pair> {
 protected:
  void SetUp() override {
    const char* folder =
        std::getenv("TANDEM_MODELS");  // NOLINT(concurrency-mt-unsafe): nobody sets it
    if (folder == nullptr) GTEST_SKIP() << "TANDEM_MODELS does not name the folder of the models";
    const char* all =
        std::getenv("TANDEM_ALL_POSES");  // NOLINT(concurrency-mt-unsafe): nobody sets it
    if (all == nullptr && !GetParam().quick) GTEST_SKIP() << "runs when TANDEM_ALL_POSES is set";
    folder_ = folder;
    poses_ = folder_ / "reference_poses_fcl.csv";
    ASSERT_TRUE(fs::is_regular_file(poses_)) << poses_;
  }

  /// Returns the answers by row of the poses file.
  std::map<int, PoseAnswer> AnswersAt(int layer, const std::string& contact) const {
    const Pair& pair = GetParam();
    std::ostringstream command;
    command << TANDEM_PROGRAM << " contact --static " << (folder_ / pair.fixed) << " --dynamic "
            << (folder_ / pair.moving) << " --voxel " << pair.voxel << " --scale " << pair.scale
            << " --poses " << poses_ << " --csv --contact " << contact << " --force-layer " << layer
            << " 2>/dev/null";
    std::map<int, PoseAnswer> answers;
    FILE* pipe = popen(command.str().c_str(), "r");
    if (pipe == nullptr) return answers;
    std::string out;
    std::array<char, 4096> buffer{};
    while (const std::size_t got = fread(buffer.data(), 1, buffer.size(), pipe)) {
      out.append(buffer.data(), got);
    }
    const int status = pclose(pipe);
    EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << command.str();
    std::istringstream lines(out);
    std::string line;
    std::getline(lines, line);  // the names of the columns
    while (std::getline(lines, line)) {
      const std::vector<std::string> cells = Cells(line);
      PoseAnswer& answer = answers[std::stoi(cells.at(0))];
      answer.contact_points = std::stoi(cells.at(1));
      answer.touching_points = std::stoi(cells.at(2));
      answer.force =
          std::hypot(std::stod(cells.at(3)), std::stod(cells.at(4)), std::stod(cells.at(5)));
    }
    return answers;
  }

  fs::path folder_;
  fs::path poses_;
};

TEST_P(PosesOfRealParts, ContactOccursOnlyInCollidingPoses) {
  const Pair& pair = GetParam();
  const std::map<int, PoseAnswer> at_surface = AnswersAt(0, "plain");
  const std::map<int, PoseAnswer> around = AnswersAt(1, "refined");
  std::ifstream file(poses_);
  std::string line;
  std::getline(file, line);
  int rows = 0;
  int far = 0;
  int colliding = 0;
  int without = 0;
  for (int row = 0; std::getline(file, line); ++row) {
    // fixed,moving,kind,tx,ty,tz,ax,ay,az,angle_deg,state,min_distance
    const std::vector<std::string> cells = Cells(line);
    if (cells.at(0) != pair.fixed || cells.at(1) != pair.moving) continue;
    ++rows;
    ASSERT_TRUE(at_surface.contains(row) && around.contains(row)) << row;
    if (cells.at(10) == "collide") {
      ++colliding;
      EXPECT_GT(around.at(row).touching_points, 0) << "row " << row;
      without += around.at(row).contact_points == 0 ? 1 : 0;
      EXPECT_EQ(around.at(row).force > 0, around.at(row).contact_points > 0) << "row " << row;
      continue;
    }
    const double distance = std::stod(cells.at(11));
    if (distance <= kTouchingUnits || distance * pair.scale <= kFarVoxels * pair.voxel) continue;
    ++far;
    EXPECT_EQ(at_surface.at(row).touching_points, 0) << "row " << row;
  }
  EXPECT_EQ(static_cast<int>(around.size()), rows);
  EXPECT_GT(far + colliding, 0);
  EXPECT_EQ(far, pair.far);
  EXPECT_LE(without, pair.without);
}

INSTANTIATE_TEST_SUITE_P(All, PosesOfRealParts, ::testing::ValuesIn(kPairs));

}  // namespace
}  // namespace tandem
