#include <algorithm>
#include <array>
#include <cstdio>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sys/wait.h>

#include "tests/support/scratch_folder.h"

namespace tandem {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

/// A box of these half sides in Wavefront's format.
std::string BoxFile(double x, double y, double z) {
  std::ostringstream text;
  for (unsigned corner = 0; corner < 8; ++corner) {
    text << "v " << ((corner & 1U) != 0 ? x : -x) << " " << ((corner & 2U) != 0 ? y : -y) << " "
         << ((corner & 4U) != 0 ? z : -z) << "\n";
  }
  text << "f 1 3 4\nf 1 4 2\nf 5 6 8\nf 5 8 7\nf 1 2 6\nf 1 6 5\n"
          "f 3 7 8\nf 3 8 4\nf 1 5 7\nf 1 7 3\nf 2 4 8\nf 2 8 6\n";
  return text.str();
}

/// A plate whose top is at z = 5 mm, and a cube of 2 cm whose centre is at first 4 cm above z = 0.
class ProximityCommand : public ::testing::Test {
 protected:
  ProximityCommand() {
    folder_.Write("plate.obj", BoxFile(0.1, 0.08, 0.005));
    folder_.Write("cube.obj", BoxFile(0.01, 0.01, 0.01));
    scene_ = folder_.Write("scene.json", R"({"name": "plate and cube", "voxel_m": 0.001, "bodies": [
      {"name": "plate", "mesh": "plate.obj", "fixed": true},
      {"name": "cube", "mesh": "cube.obj", "mass_kg": 0.2, "pose": {"p_W": [0, 0, 0.04]}}]})");
  }
  std::string Poses(const std::string& rows) {
    return folder_.Write("poses.csv", "moving,tx,ty,tz,ax,ay,az,angle_deg\n" + rows).string();
  }
  /// Its exit code; what it says is then in out_ and said_.
  int Run(const std::string& arguments) {
    const std::filesystem::path said = folder_.path() / "said";
    const std::string command =
        std::string(TANDEM_PROGRAM) + " proximity " + arguments + " 2>" + said.string();
    FILE* pipe = popen(command.c_str(), "r");
    if (pipe == nullptr) return -1;
    out_.clear();
    std::array<char, 4096> buffer{};
    while (const std::size_t got = fread(buffer.data(), 1, buffer.size(), pipe)) {
      out_.append(buffer.data(), got);
    }
    const int status = pclose(pipe);
    std::ostringstream text;
    text << std::ifstream(said).rdbuf();
    said_ = text.str();
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

  ScratchFolder folder_;
  std::filesystem::path scene_;
  std::string out_;
  std::string said_;
};

TEST_F(ProximityCommand, WithoutPosesSaysHowFarEachMovingBodyIsAtFirst) {
  ASSERT_EQ(Run(scene_.string()), 0) << said_;
  EXPECT_THAT(out_, HasSubstr("cube to plate: 25.0000 mm"));
}

TEST_F(ProximityCommand, AnswersEachPoseWithDistanceTwoPointsErrorAndGradient) {
  // 3 mm above the plate; beside its edge at x = 0.1 by 4 mm, turned by a quarter; across its top
  const std::string poses =
      Poses("cube,0,0,0.018,0,0,1,0\ncube,0.114,0,0,0,0,1,90\ncube,0,0,0.01,0,0,1,0\n");
  ASSERT_EQ(Run(scene_.string() + " --json --poses " + poses), 0) << said_;
  const json out = json::parse(out_);
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
  ASSERT_EQ(Run(scene_.string() + " --scale 0.001 --poses " + poses), 0) << said_;
  EXPECT_THAT(out_, HasSubstr("cube to plate: 3.0000 mm"));
}

TEST_F(ProximityCommand, ByVoxelsAloneStaysWithinTheErrorThatItStates) {
  const std::string poses = Poses("cube,0,0,0.0184,1,1,0,0\n");
  ASSERT_EQ(Run(scene_.string() + " --coarse --csv --poses " + poses), 0) << said_;
  EXPECT_EQ(out_.substr(0, out_.find('\n')),
            "row,body,other,distance_m,error_bound_m,overlap,refined,px,py,pz,qx,qy,qz,gx,gy,gz");
  double distance = 0;
  double error = 0;
  ASSERT_EQ(
      std::sscanf(out_.c_str() + out_.find('\n'), " 0,cube,plate,%lf,%lf,0,0,", &distance, &error),
      2)
      << out_;
  EXPECT_NEAR(distance, 0.0034, error);
  EXPECT_LE(error, 1.7331e-3);  // sqrt(3) voxels and the rounding of single precision
}

TEST_F(ProximityCommand, SaysInOneLineWhatIsWrong) {
  const auto line = [&](const std::string& arguments, int code) {
    EXPECT_EQ(Run(arguments), code) << arguments;
    EXPECT_EQ(std::count(said_.begin(), said_.end(), '\n'), 1) << said_;
    EXPECT_EQ(out_, "");
    return said_;
  };
  EXPECT_THAT(line("/nowhere/scene.json", 3), HasSubstr("/nowhere/scene.json"));
  EXPECT_THAT(line(scene_.string() + " --poses " + Poses("ball,0,0,0,0,0,1,0\n"), 3),
              HasSubstr("pose 0: the scene has no body 'ball'"));
  EXPECT_THAT(line(scene_.string() + " --poses " + Poses("plate,0,0,0,0,0,1,0\n"), 3),
              HasSubstr("'plate' is fixed"));
  EXPECT_THAT(line(scene_.string() + " --poses " + Poses("cube,0,0,high,0,0,1,0\n"), 3),
              HasSubstr("poses.csv:2: tz: expected a number, got \"high\""));
  EXPECT_THAT(line(scene_.string() + " --poses " + Poses(""), 3), HasSubstr("has no pose"));
  EXPECT_THAT(line(scene_.string() + " --csv --json", 2), HasSubstr("--csv or --json"));
  EXPECT_THAT(line(scene_.string() + " --voxel -1", 2), HasSubstr("--voxel"));
  EXPECT_THAT(line(scene_.string() + " --scale 0", 2), HasSubstr("--scale"));
}

}  // namespace
}  // namespace tandem
