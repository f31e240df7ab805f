#include <csignal>
#include <fstream>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/common/exit_codes.h"
#include "app/process/child_processes.h"
#include "engine/contact/kept/surface_file.h"
#include "engine/geometry/import/mesh_file.h"
#include "engine/voxel/map/voxmap_file.h"
#include "tests/app/cli/program_run.h"
#include "tests/engine/geometry/import/mesh_file_samples.h"
#include "tests/support/scratch_folder.h"

namespace tandem {
namespace {

using ::testing::HasSubstr;
using testing::ProgramOutput;
using testing::RunTandem;

/// Returns whether the process has a handler for SIGINT, as the kernel tells it.
bool Listens(pid_t pid) {
  std::ifstream status("/proc/" + std::to_string(pid) + "/status");
  for (std::string line; std::getline(status, line);) {
    if (line.rfind("SigCgt:", 0) != 0) continue;
    return (std::stoull(line.substr(7), nullptr, 16) >> (SIGINT - 1) & 1U) != 0;
  }
  return false;
}

class VoxelizeCommand : public ::testing::Test {
 protected:
  VoxelizeCommand() {
    mesh_ = folder_
                .Write("wedge.obj",
                       "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\n"
                       "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
                .string();
  }
  ScratchFolder folder_;
  std::string mesh_;
};

TEST_F(VoxelizeCommand, WritesAMapOfTheRequestedRange) {
  const std::filesystem::path file = folder_.path() / "wedge.voxmap";
  for (const auto& [range, bits] : {std::pair{1, 2}, std::pair{8, 4}, std::pair{40, 8}}) {
    const ProgramOutput output = RunTandem("voxelize " + mesh_ + " --voxel 0.002 --json --range " +
                                           std::to_string(range) + " --out " + file.string());
    ASSERT_EQ(output.exit_code, kExitOk) << output.err;
    const auto reported = nlohmann::json::parse(output.out);
    EXPECT_EQ(reported["bits"], bits);
    const Result<Voxmap> map = MapVoxmap(file);
    ASSERT_TRUE(map) << map.error().what;
    EXPECT_EQ(map->range(), range);
    EXPECT_EQ(map->bits(), bits);
    EXPECT_EQ(map->Count().surface, reported["voxels"]["surface"]);
    EXPECT_EQ(map->Count().free, reported["voxels"]["free"]);
  }
}

TEST_F(VoxelizeCommand, WritesTheSurfaceOfRefinedContact) {
  const std::filesystem::path file = folder_.path() / "wedge.surface";
  const ProgramOutput output =
      RunTandem("voxelize " + mesh_ + " --voxel 0.002 --json --surface " + file.string());
  ASSERT_EQ(output.exit_code, kExitOk) << output.err;
  const auto reported = nlohmann::json::parse(output.out);
  const Result<TriangleMesh> mesh = ImportMesh(mesh_);
  ASSERT_TRUE(mesh);
  const Result<BodySurface> surface = MapSurface(file, *mesh, Pose{}, {.voxel_size = 0.002});
  ASSERT_TRUE(surface) << surface.error().what;
  EXPECT_EQ(surface->field.bytes().size() + surface->features.bytes().size(),
            reported["surface_bytes"]);
  // the wedge's edges are there, and a place in it is solid
  EXPECT_GT(surface->features.point_count(), 0U);
  const Vec3 inside = (Vec3(0.02, 0.02, 0.02) - surface->field.p_WVo()) / 0.002;
  EXPECT_LT(surface->field.At(inside).value, 0);
  const ProgramOutput refused = RunTandem("voxelize " + mesh_ + " --voxel 0.002 --surface " +
                                          (folder_.path() / "no" / "folder").string());
  EXPECT_EQ(refused.exit_code, kExitFile);
  EXPECT_THAT(refused.err, HasSubstr("cannot be written"));
}

TEST_F(VoxelizeCommand, SaysWhatItLeavesOutOfAFile) {
  const std::filesystem::path file = folder_.path() / "remarks.obj";
  std::ofstream(file) << "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"
                         "l 1 2\n# from C:\\parts\\\n";
  const ProgramOutput output = RunTandem("voxelize " + file.string() + " --voxel 0.1 --json");
  ASSERT_EQ(output.exit_code, kExitOk) << output.err;
  EXPECT_THAT(output.err,
              HasSubstr("remarks.obj: 1 line or point element without a surface left out"));
  const auto reported = nlohmann::json::parse(output.out);
  EXPECT_EQ(reported["remarks"].size(), 1U);
  EXPECT_NEAR(reported["volume_m3"].get<double>(), 1.0 / 6, 1e-6);
}

TEST_F(VoxelizeCommand, RefusesARangeThatItsMarksCannotHold) {
  const ProgramOutput output =
      RunTandem("voxelize " + mesh_ + " --voxel 0.002 --range 14 --bits 4");
  EXPECT_EQ(output.exit_code, kExitUsage);
  EXPECT_THAT(output.err, HasSubstr("--bits 4 holds a range of at most 13 voxels"));
}

// The wedge is 100 units long: in millimetres a hand's breadth, in metres more than fits.
TEST_F(VoxelizeCommand, AssumesMetresAndSaysSoForALargeMesh) {
  const std::filesystem::path wedge = folder_.Write("millimetres.obj",
                                                    "v 0 0 0\nv 100 0 0\nv 0 100 0\nv 0 0 100\n"
                                                    "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
  for (const std::string command : {"voxelize ", "bench voxelize "}) {
    const ProgramOutput refused = RunTandem(command + wedge.string() + " --voxel 0.002");
    EXPECT_EQ(refused.exit_code, kExitFile);
    EXPECT_THAT(refused.err, HasSubstr("read in metres, it is 100 m long"));
    EXPECT_THAT(refused.err, HasSubstr("--scale 0.001"));
  }
  const ProgramOutput output =
      RunTandem("voxelize " + wedge.string() + " --voxel 0.002 --scale 0.001 --json");
  ASSERT_EQ(output.exit_code, kExitOk) << output.err;
  EXPECT_NEAR(nlohmann::json::parse(output.out)["volume_m3"], 1e-3 / 6, 1e-9);
  EXPECT_EQ(output.err, "");
  // voxels that fit whatever the wedge measures are taken, too
  const ProgramOutput fits = RunTandem("voxelize " + wedge.string() + " --voxel auto");
  ASSERT_EQ(fits.exit_code, kExitOk) << fits.err;
  EXPECT_THAT(fits.err,
              HasSubstr("read in metres, it is 100 m long: if the file is in millimetres"));
}

TEST_F(VoxelizeCommand, TakesA3mfFileInTheUnitThatItDeclares) {
  const std::string file = folder_.Write("two.3mf", testing::ThreeMf("unit=\"inch\"")).string();
  const auto volume_of = [&file](const std::string& options) {
    const ProgramOutput output = RunTandem("voxelize " + file + " --voxel 0.001 --json" + options);
    EXPECT_EQ(output.exit_code, kExitOk) << output.err;
    EXPECT_THAT(output.err, ::testing::Not(HasSubstr("read in metres")));
    return nlohmann::json::parse(output.out).at("volume_m3").get<double>();
  };
  const double declared = volume_of("");
  EXPECT_DOUBLE_EQ(declared, volume_of(" --scale 0.0254"));
  EXPECT_NEAR(volume_of(" --scale 0.0127"), declared / 8, 1e-9 * declared);
}

TEST_F(VoxelizeCommand, CancellationLeavesNoFile) {
  const std::filesystem::path file = folder_.path() / "wedge.voxmap";
  Result<ChildProcess> child =
      ChildProcess::Start({TANDEM_PROGRAM, "voxelize", mesh_, "--voxel", "0.00015", "--range",
                           "252", "--max-memory", "64GiB", "--out", file.string()});
  ASSERT_TRUE(child);
  while (!Listens(child->pid())) {
    ASSERT_FALSE(child->Poll()) << "it was done before it could be asked";
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  std::this_thread::sleep_for(std::chrono::seconds(1));  // until it is at its voxels
  ASSERT_FALSE(child->Poll()) << "it was done before it could be asked";
  child->Signal(SIGINT);
  EXPECT_EQ(child->Wait(std::chrono::seconds(30)), kExitFile);
  EXPECT_FALSE(std::filesystem::exists(file));
}

}  // namespace
}  // namespace tandem
