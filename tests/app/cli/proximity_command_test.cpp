#include <cstdio>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/common/exit_codes.h"
#include "tests/app/cli/program_run.h"
#include "tests/support/obj_text.h"
#include "tests/support/scratch_folder.h"

namespace tandem {
namespace {

using nlohmann::json;
using testing::BoxObjText;
using testing::ExpectRefused;
using ::testing::HasSubstr;
using testing::ProgramOutput;
using testing::RunTandem;

/// A plate whose top is at z = 5 mm, and a cube of 2 cm whose centre is at first 4 cm above z = 0.
class ProximityCommand : public ::testing::Test {
 protected:
  ProximityCommand() {
    folder_.Write("plate.obj", BoxObjText(0.1, 0.08, 0.005));
    folder_.Write("cube.obj", BoxObjText(0.01, 0.01, 0.01));
    scene_ = folder_.Write("scene.json", R"({"name": "plate and cube", "voxel_m": 0.001, "bodies": [
      {"name": "plate", "mesh": "plate.obj", "fixed": true},
      {"name": "cube", "mesh": "cube.obj", "mass_kg": 0.2, "pose": {"p_W": [0, 0, 0.04]}}]})");
  }
  std::string Poses(const std::string& rows) {
    return folder_.Write("poses.csv", "moving,tx,ty,tz,ax,ay,az,angle_deg\n" + rows).string();
  }
  static ProgramOutput Run(const std::string& arguments) {
    return RunTandem("proximity " + arguments);
  }

  ScratchFolder folder_;
  std::filesystem::path scene_;
};

TEST_F(ProximityCommand, WithoutPosesReportsInitialDistances) {
  const ProgramOutput output = Run(scene_.string());
  ASSERT_EQ(output.exit_code, kExitOk) << output.err;
  EXPECT_THAT(output.out, HasSubstr("cube to plate: 25.0000 mm"));
}

TEST_F(ProximityCommand, AnswersEachPoseWithDistanceTwoPointsErrorAndGradient) {
  // 3 mm above the plate; beside its edge at x = 0.1 by 4 mm, turned by a quarter; across its top
  const std::string poses =
      Poses("cube,0,0,0.018,0,0,1,0\ncube,0.114,0,0,0,0,1,90\ncube,0,0,0.01,0,0,1,0\n");
  const ProgramOutput output = Run(scene_.string() + " --json --poses " + poses);
  ASSERT_EQ(output.exit_code, kExitOk) << output.err;
  const json out = json::parse(output.out);
  EXPECT_EQ(out.at("voxel_m"), 0.001);
  ASSERT_EQ(out.at("rows").size(), 3U);
  const json& above = out.at("rows")[0];
  EXPECT_EQ(above.at("body"), "cube");
  EXPECT_EQ(above.at("other"), "plate");
  EXPECT_NEAR(above.at("distance_m").get<double>(), 0.003, 1e-8);
  EXPECT_LE(above.at("error_bound_m").get<double>(), 2e-6);
  EXPECT_NEAR(above.at("point_of_body")[2].get<double>(), 0.008, 1e-8);
  EXPECT_NEAR(above.at("point_of_other")[2].get<double>(), 0.005, 1e-8);
  EXPECT_NEAR(above.at("gradient")[2].get<double>(), 1, 1e-9);
  const json& beside = out.at("rows")[1];
  EXPECT_NEAR(beside.at("distance_m").get<double>(), 0.004, 1e-8);
  EXPECT_NEAR(beside.at("gradient")[0].get<double>(), 1, 1e-9);
  EXPECT_FALSE(beside.at("overlap").get<bool>());
  EXPECT_TRUE(out.at("rows")[2].at("overlap").get<bool>());
  EXPECT_EQ(out.at("rows")[2].at("distance_m"), 0);
}

TEST_F(ProximityCommand, TakesMeshFilesNamesAndOtherUnits) {
  const std::string poses = Poses("cube.obj,0,0,18,0,0,1,0\n");
  const ProgramOutput output = Run(scene_.string() + " --scale 0.001 --poses " + poses);
  ASSERT_EQ(output.exit_code, kExitOk) << output.err;
  EXPECT_THAT(output.out, HasSubstr("cube to plate: 3.0000 mm"));
}

TEST_F(ProximityCommand, VoxelDistanceIsWithinItsStatedError) {
  const std::string poses = Poses("cube,0,0,0.0184,1,1,0,0\n");
  const ProgramOutput output = Run(scene_.string() + " --coarse --csv --poses " + poses);
  ASSERT_EQ(output.exit_code, kExitOk) << output.err;
  EXPECT_EQ(output.out.substr(0, output.out.find('\n')),
            "row,body,other,distance_m,error_bound_m,overlap,refined,px,py,pz,qx,qy,qz,gx,gy,gz");
  double distance = 0;
  double error = 0;
  ASSERT_EQ(std::sscanf(output.out.c_str() + output.out.find('\n'), " 0,cube,plate,%lf,%lf,0,0,",
                        &distance, &error),
            2)
      << output.out;
  EXPECT_NEAR(distance, 0.0034, error);
  EXPECT_LE(error, 1.7331e-3);  // sqrt(3) voxels and the rounding of single precision
}

TEST_F(ProximityCommand, ReportsErrorsInOneLine) {
  const auto line = [&](const std::string& arguments, int code) {
    const ProgramOutput output = Run(arguments);
    ExpectRefused(output, code, "");
    EXPECT_EQ(output.out, "") << arguments;
    return output.err;
  };
  EXPECT_THAT(line("/nowhere/scene.json", kExitFile), HasSubstr("/nowhere/scene.json"));
  EXPECT_THAT(line(scene_.string() + " --poses " + Poses("ball,0,0,0,0,0,1,0\n"), kExitFile),
              HasSubstr("pose 0: the scene has no body 'ball'"));
  EXPECT_THAT(line(scene_.string() + " --poses " + Poses("plate,0,0,0,0,0,1,0\n"), kExitFile),
              HasSubstr("'plate' is fixed"));
  EXPECT_THAT(line(scene_.string() + " --poses " + Poses("cube,0,0,high,0,0,1,0\n"), kExitFile),
              HasSubstr("poses.csv:2: tz: expected a number, got \"high\""));
  EXPECT_THAT(line(scene_.string() + " --poses " + Poses(""), kExitFile), HasSubstr("has no pose"));
  EXPECT_THAT(line(scene_.string() + " --csv --json", kExitUsage), HasSubstr("--csv or --json"));
  EXPECT_THAT(line(scene_.string() + " --voxel -1", kExitUsage), HasSubstr("--voxel"));
  EXPECT_THAT(line(scene_.string() + " --scale 0", kExitUsage), HasSubstr("--scale"));
}

}  // namespace
}  // namespace tandem
