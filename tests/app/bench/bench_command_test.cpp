#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/bench/measure/voxelize_times.h"
#include "app/common/exit_codes.h"
#include "tests/app/cli/program_run.h"
#include "tests/support/scratch_folder.h"

// Scripts read the benches' JSON by its names. The tests expect that the names are there and that
// their values are numbers, however large.

namespace tandem {
namespace {

using nlohmann::json;
using testing::ProgramOutput;
using testing::RunTandem;

json Bench(const std::string& arguments, const std::string& before = "") {
  const ProgramOutput output = RunTandem("bench " + arguments + " --json", before);
  EXPECT_EQ(output.exit_code, kExitOk) << output.err;
  return json::parse(output.out, nullptr, false);
}

/// Expects a number at each of `paths`, such as "/ball/turn_s".
void ExpectNumbers(const json& reported, const std::vector<std::string>& paths) {
  for (const std::string& path : paths) {
    const json::json_pointer pointer(path);
    if (!reported.contains(pointer)) {
      ADD_FAILURE() << path << " is not there";
    } else if (!reported[pointer].is_number() || !std::isfinite(reported[pointer].get<double>())) {
      ADD_FAILURE() << path << " is " << reported[pointer].dump();
    }
  }
}

const std::string kPeg = std::string(TANDEM_SCENES) + "/peg_in_slot_peg.stl";

TEST(BenchCommand, PointsReportsTheTimePerPointTest) {
  const json reported = Bench("points --scene peg_in_slot --voxel 0.004 --rounds 1");
  ExpectNumbers(reported, {"/transform_ns", "/coherent_ns", "/random_ns", "/limit_ns",
                           "/random_4t_ns", "/limit_4t_ns", "/map_bytes", "/points", "/field_ns",
                           "/field_with_gradient_ns", "/error_voxels/p50", "/error_voxels/p99",
                           "/error_voxels/max", "/field_bytes_per_band_voxel"});
  EXPECT_TRUE(reported["isa"].is_string());
  EXPECT_GT(reported["points"], 0);
}

TEST(BenchCommand, RemovalEndsWhenVoxelsArriveTooLate) {
  const ProgramOutput output = RunTandem(
      "bench removal --scene bracket_actuator --voxel-mm 0.5 --passes 1 --capacity 100000 "
      "--voxel-memory 3MiB "
      "--disk-mb-per-s 0.0001");
  EXPECT_EQ(output.exit_code, kExitFile);
  EXPECT_NE(output.err.find("voxels were not read in time"), std::string::npos) << output.err;
  const ProgramOutput small = RunTandem(
      "bench removal --scene bracket_actuator --voxel-mm 0.5 --passes 1 --voxel-memory 1MiB");
  EXPECT_EQ(small.exit_code, kExitFile);
  EXPECT_NE(small.err.find("it needs at least"), std::string::npos) << small.err;
}

TEST(BenchCommand, Table1HasThePapersRowsAndReproducesItsBall) {
  const json reported = Bench("table1 --scenes ball_and_socket --threads 1");
  ASSERT_EQ(reported["rows"].size(), 2U);
  for (const json& row : reported["rows"]) {
    ExpectNumbers(row, {"/voxel_mm", "/points_mm", "/triangles/moving", "/triangles/fixed",
                        "/points", "/voxels/interior", "/voxels/surface", "/voxels/band",
                        "/voxelize_s", "/load_s", "/paper/voxelize_s", "/paper/load_s"});
    EXPECT_EQ(row["triangles"], row["paper"]["triangles"]);
    const double points = row["paper"]["points"];
    EXPECT_NEAR(row["points"].get<double>(), points, 0.004 * points);
    const double voxels = row["paper"]["voxels"];
    const json& here = row["voxels"];
    EXPECT_NEAR(
        here["interior"].get<double>() + here["surface"].get<double>() + here["band"].get<double>(),
        voxels, 0.05 * voxels);
  }
}

TEST(BenchCommand, Figure10FitsAPowerAndDrawsIt) {
  const ScratchFolder folder;
  const json reported = Bench("figure10 --scene peg_in_slot --smallest-mm 2 --largest-mm 8 --out " +
                              folder.path().string());
  ExpectNumbers(reported, {"/exponent", "/finest_exponent", "/times/0/voxel_mm", "/times/0/seconds",
                           "/times/0/voxels"});
  ASSERT_EQ(reported["times"].size(), 5U);
  EXPECT_GT(reported["times"][4]["voxels"], reported["times"][0]["voxels"]);
  for (const char* file : {"figure10.csv", "figure10.svg"}) {
    EXPECT_TRUE(std::filesystem::exists(folder.path() / file)) << file;
  }
}

TEST(PowerLaw, IsExactForExactPowers) {
  std::vector<VoxelizeTime> times;
  for (const double size_mm : {1.0, 2.5, 4.0}) {
    times.push_back(
        {.voxel_size = 1e-3 * size_mm, .seconds = 3 / (size_mm * size_mm), .voxels = 1});
  }
  const PowerLaw law = FitPowerLaw(times);
  EXPECT_NEAR(law.exponent, -2, 1e-12);
  EXPECT_NEAR(law.factor, 3, 1e-12);
}

TEST(BenchCommand, RemovalReportsTheOutcomeAndFrameTimes) {
  const ScratchFolder folder;
  const json reported = Bench("removal --scene peg_in_slot --voxel-mm 2 --passes 1 --plots " +
                              folder.path().string());
  ExpectNumbers(reported, {"/frames", "/points", "/voxels", "/cpu_p50_us", "/cpu_p999_us",
                           "/noise_p999_us", "/back_to_back/cpu_p50_us", "/back_to_back/cpu_p99_us",
                           "/back_to_back/cpu_p999_us", "/travel_at_bound_share", "/page_faults",
                           "/peak_bytes", "/voxel_memory_bytes", "/contacts_mean", "/contacts_max",
                           "/hand_force_max_N"});
  EXPECT_EQ(reported["out"], true);
  EXPECT_GT(reported["contacts_max"], 0);
  EXPECT_GT(reported["voxel_memory_bytes"], 0);
  EXPECT_GT(reported["hand_force_max_N"], 0);
  ExpectNumbers(reported, {"/stalls", "/stall_s", "/longest_stall_ms", "/pages_read"});
  for (const char* picture : {"removal_times", "removal_contacts", "removal_force"}) {
    EXPECT_TRUE(std::filesystem::exists(folder.path() / (std::string(picture) + ".svg")))
        << picture;
  }
}

TEST(BenchCommand, VoxelizeReportsTimeAndThePolygonSaving) {
  const json reported = Bench("voxelize " + kPeg + " --scale 0.001 --voxel 0.002 --threads 1");
  ExpectNumbers(reported, {"/seconds", "/cpu_seconds", "/points_per_chunk", "/band_voxels",
                           "/bytes", "/bytes_per_band_voxel", "/polygons", "/edge_voxels",
                           "/vertex_voxels", "/edge_voxels_unmerged", "/vertex_voxels_unmerged"});
  EXPECT_LT(reported["edge_voxels"], reported["edge_voxels_unmerged"]);
  EXPECT_FALSE(reported.contains("surface"));
}

TEST(BenchCommand, VoxelizeMapsTheSurfaceThatItMade) {
  const ScratchFolder folder;
  const std::filesystem::path file = folder.path() / "peg.surface";
  const json reported = Bench(
      "voxelize " + kPeg + " --scale 0.001 --voxel 0.002 --threads 2 --surface " + file.string());
  ExpectNumbers(reported,
                {"/surface/build_s", "/surface/build_cpu_s", "/surface/save_s", "/surface/map_s",
                 "/surface/map_cpu_s", "/surface/field_bytes", "/surface/feature_bytes"});
  EXPECT_TRUE(reported["surface"]["same"]);
  EXPECT_GT(std::filesystem::file_size(file), reported["surface"]["field_bytes"]);
}

/// Returns a closed cylinder of radius 50 and length 150 whose side has this many strips.
std::string Cylinder(int sides) {
  std::ostringstream text;
  text.precision(12);
  text << "v 0 0 0\nv 0 0 150\n";
  for (const int z : {0, 150}) {
    for (int i = 0; i < sides; ++i) {
      const double angle = 2 * M_PI * i / sides;
      text << "v " << 50 * std::cos(angle) << ' ' << 50 * std::sin(angle) << ' ' << z << '\n';
    }
  }
  for (int i = 0; i < sides; ++i) {
    const int a = 3 + i;
    const int b = 3 + (i + 1) % sides;
    text << "f 1 " << b << ' ' << a << "\nf 2 " << a + sides << ' ' << b + sides << "\nf " << a
         << ' ' << b << ' ' << b + sides << "\nf " << a << ' ' << b + sides << ' ' << a + sides
         << '\n';
  }
  return text.str();
}

// Paper §4.1: fine tessellation defeats geometrical awareness. After merging, only the rims and a
// few lines along the side are left, however finely the cylinder is cut.
TEST(FineCylinder, KeepsFewOfItsEdgesWhenVoxelized) {
  const ScratchFolder folder;
  for (const int sides : {360, 720}) {
    const auto file = folder.Write("cylinder.obj", Cylinder(sides));
    const ProgramOutput output =
        RunTandem("voxelize " + file.string() + " --scale 0.001 --voxel 0.001 --json");
    ASSERT_EQ(output.exit_code, kExitOk) << output.err;
    const json reported = json::parse(output.out);
    EXPECT_LT(reported["polygons"], 40) << sides;
    EXPECT_LT(10 * reported["edge_voxels"].get<int>(), reported["edge_voxels_unmerged"]) << sides;
    // two at each rim for each strip of the side, as FindFeatures() has them
    EXPECT_LE(reported["vertex_voxels"], 4 * (reported["polygons"].get<int>() - 2)) << sides;
    EXPECT_LT(reported["vertex_voxels"], reported["vertex_voxels_unmerged"]) << sides;
  }
}

TEST(BenchCommand, FrameReportsTimesAndNoMissedContact) {
  const json reported =
      Bench("frame --scene peg_in_slot --frames 1000 --capacity 100000 --passes 2");
  ExpectNumbers(reported, {"/points",
                           "/voxels",
                           "/contacts",
                           "/cpu_p50_us",
                           "/cpu_p99_us",
                           "/cpu_p999_us",
                           "/wall_p999_us",
                           "/frames_over_1ms",
                           "/missed",
                           "/noise_p999_us",
                           "/tests_per_frame",
                           "/tests_owed_p50",
                           "/tests_owed_max",
                           "/travel_at_bound_share",
                           "/violations",
                           "/free_cpu_p99_us",
                           "/looked_up_ns",
                           "/drifted_ns",
                           "/back_to_back/cpu_p50_us",
                           "/back_to_back/cpu_p999_us"});
  EXPECT_EQ(reported["frames"], 1000);
  EXPECT_EQ(reported["violations"], 0);
  EXPECT_GT(reported["contacts"], 0);
}

TEST(BenchCommand, FrameWithoutCoherenceTestsMoreAndDriftOptionNeedsPlainContact) {
  const std::string frame = "frame --scene peg_in_slot --frames 1000 --capacity 100000";
  EXPECT_GT(Bench(frame + " --without coherence")["tests_per_frame"],
            2 * Bench(frame)["tests_per_frame"].get<double>());
  const ProgramOutput output = RunTandem("bench " + frame + " --without drift");
  EXPECT_EQ(output.exit_code, kExitUsage);
  EXPECT_NE(output.err.find("--without drift: only plain contact"), std::string::npos)
      << output.err;
}

TEST(BenchCommand, MemoryReportsBytesPerBandVoxel) {
  const json reported = Bench("memory --scene peg_in_slot");
  ExpectNumbers(reported, {"/bytes_per_band_voxel", "/scenes/0/bytes_per_band_voxel_refined",
                           "/scenes/0/resident_bytes_per_band_voxel"});
  EXPECT_EQ(reported["scenes"].size(), 1U);
}

TEST(BenchCommand, NetworkReportsTheRoundTrip) {
  const json reported = Bench("network --seconds 0.1");
  ExpectNumbers(reported, {"/udp_rtt_p50_us", "/dds_rtt_p50_us", "/ratio", "/udp_rtt_p99_us",
                           "/dds_rtt_p99_us"});
  EXPECT_GT(reported["round_trips"], 0);
  EXPECT_EQ(reported["bytes"], 916);  // a state with its links, which a peer sends at 1 kHz
}

TEST(BenchCommand, SessionReportsDeliveryAndDiscovery) {
  const json reported = Bench("session --peers 2 --hz 250 --seconds 1");
  ExpectNumbers(reported, {"/samples_sent", "/samples_delivered", "/delivered", "/least_delivered",
                           "/least_sent", "/frames", "/missed", "/judged_frames", "/judged_missed",
                           "/frames_over_1ms", "/frame_cpu_p99_us/1", "/frame_wall_p999_us/1"});
  EXPECT_EQ(reported["pairs"], 2);
  EXPECT_EQ(reported["pairs_heard"], 2);
  // frames of both peers, counted only while their hands move
  EXPECT_EQ(reported["judged_frames"], 2000);
  EXPECT_GT(reported["frames"], reported["judged_frames"]);
}

TEST(BenchCommand, SessionComparesCoupledWithIndependentPeers) {
  const json reported = Bench("session --compare 1 --rounds 1 --hz 250 --seconds 1");
  ExpectNumbers(reported, {"/sessions/0/ratio_to_apart", "/sessions/0/median_ratio_to_apart",
                           "/sessions/0/frame_wall_p999_us", "/sessions/0/frames",
                           "/sessions/0/frames_over_1ms", "/sessions/0/missed",
                           "/sessions/0/apart/frame_wall_p999_us", "/sessions/0/apart/missed"});
}

TEST(BenchCommand, SessionComparesRunsWithAndWithoutViewers) {
  const json reported = Bench("session --viewers 1 --rounds 1 --hz 250 --seconds 1");
  ASSERT_EQ(reported["sessions"].size(), 3U);
  ExpectNumbers(reported, {"/viewerless_ratio", "/sessions/1/ratio", "/sessions/1/ratio_least",
                           "/sessions/1/ratio_most", "/sessions/1/frame_wall_p999_us",
                           "/sessions/1/frames_over_1ms", "/sessions/1/missed"});
  EXPECT_GT(reported["sessions"][1]["least_pictures"], 0);
  const auto p99 = [&reported](std::size_t row) {
    return reported["sessions"][row]["frame_cpu_p99_us"].get<double>();
  };
  EXPECT_NEAR(reported["sessions"][1]["ratio"], p99(1) / (0.5 * (p99(0) + p99(2))), 1e-9);
}

const std::vector<std::string> kOnPlanes{
    "/first_force_gap_voxels/min", "/first_force_gap_voxels/mean", "/first_force_gap_voxels/max",
    "/direction_error_deg/mean",   "/direction_error_deg/max",     "/sliding_ripple"};

std::vector<std::string> Under(const std::string& top, std::vector<std::string> paths) {
  for (std::string& path : paths) path = top + path;
  return paths;
}

TEST(BenchCommand, FidelityReportsContactErrorOnPlanes) {
  const json reported =
      Bench("fidelity --approaches 1 --tilts 1 --only first-force --only pressed");
  ExpectNumbers(reported, kOnPlanes);
  ExpectNumbers(reported, Under("/plain", kOnPlanes));
  EXPECT_TRUE(reported["ball"].is_null());
  // the bars of docs/results/0041-contact-by-fields.md
  EXPECT_GT(reported["first_force_gap_voxels"]["min"], 0);
  EXPECT_LE(reported["first_force_gap_voxels"]["max"], 0.6);
  EXPECT_LE(reported["direction_error_deg"]["max"], 0.1);
  EXPECT_LE(reported["sliding_ripple_max"], 0.01);
}

// Holds exist in refined contact alone.
TEST(BenchCommand, FidelityReportsRestAndRequestedClearance) {
  const json reported = Bench(
      "fidelity --holds 2 --clearance-tilts 1 --sheet-tries 6 --only holds --only clearance "
      "--only sheets");
  ExpectNumbers(reported, {"/holds/count", "/holds/moving", "/holds/largest_force_step_N",
                           "/holds/frame_cpu_p50_us", "/holds/dropped_frames",
                           "/clearance/error_voxels_max", "/clearance/outer_error_voxels_max",
                           "/clearance/late_voxels_max", "/clearance/force_step_N",
                           "/sheets/nearest_voxels", "/dropped_frames", "/frames_over_1ms"});
  EXPECT_EQ(reported["sheets"]["tries"], 6);
  EXPECT_EQ(reported["sheets"]["crossings"], 0);
  // boxes begin at 28 voxels, and come to lie on the sheet
  EXPECT_LT(reported["sheets"]["nearest_voxels"], 24);
  EXPECT_EQ(reported["holds"]["count"], 2);
  // the bars of docs/results/0041 and 0042
  EXPECT_EQ(reported["holds"]["moving"], 0);
  EXPECT_LE(reported["holds"]["largest_force_step_N"], 0.2);
  EXPECT_LE(reported["clearance"]["error_voxels_max"], 0.05);
  EXPECT_LE(reported["clearance"]["outer_error_voxels_max"], 0.5);
  EXPECT_LE(reported["clearance"]["force_step_N"], 0.088);
  EXPECT_EQ(reported["dropped_frames"], 0);
  EXPECT_EQ(reported["frames_over_1ms"], reported["holds"]["frames_over_1ms"]);
  EXPECT_TRUE(reported["plain"]["holds"].is_null());
  EXPECT_TRUE(reported["plain"]["clearance"].is_null());
  EXPECT_TRUE(reported["plain"]["dropped_frames"].is_null());
}

const std::vector<std::string> kOfFrames{
    "/frame_cpu_p50_us", "/frame_cpu_p99_us", "/frame_wall_p999_us",
    "/frames_over_1ms",  "/missed",           "/dropped_frames"};

/// Returns `paths` under `top`, and the paths that every part has for its frames.
std::vector<std::string> OfPart(const std::string& top, std::vector<std::string> paths) {
  paths.insert(paths.end(), kOfFrames.begin(), kOfFrames.end());
  return Under(top, paths);
}

// Balls, nuts and pegs simulate many seconds, so they run on demand.
TEST(BenchCommand, FidelityReportsAssembly) {
  if (std::getenv("TANDEM_BENCHES") == nullptr) {
    GTEST_SKIP() << "runs when TANDEM_BENCHES is set";
  }
  const bool models = std::getenv("TANDEM_MODELS") != nullptr;
  const json reported = Bench(
      "fidelity --pegs 3 --contacts 2000 --only ball --only ball-015 --only nut --only nut-tight "
      "--only pegs");
  ExpectNumbers(reported, OfPart("/ball", {"/points_035", "/points_015", "/turn_s",
                                           "/contacts_mean", "/turn_1khz_s"}));
  ExpectNumbers(reported,
                OfPart("/ball_015", {"/points_015", "/turn_s", "/turn_1khz_s", "/contacts_mean"}));
  EXPECT_EQ(reported["ball"]["points_015"], reported["ball_015"]["points_015"]);
  ExpectNumbers(reported, {"/dropped_frames", "/frames_over_1ms"});
  if (!models) return;
  EXPECT_TRUE(reported["nut"]["axial_blocked"].is_boolean());
  EXPECT_TRUE(reported["plain"]["false_pushes"].is_null());
  const std::vector<std::string> of_checks{"/wrench_error_N", "/wrench_error_held_back_N"};
  for (const std::string model : {"", "/plain"}) {
    ExpectNumbers(reported, OfPart(model + "/nut", {"/helix_error_mm", "/largest_force_step_N"}));
    ExpectNumbers(reported,
                  OfPart(model + "/nut_tight", {"/turned_deg", "/helix_error_mm", "/crossing_mm"}));
    ExpectNumbers(reported, OfPart(model + "/pegs", {"/inserted_share", "/buzz"}));
    ExpectNumbers(reported, Under(model, of_checks));
  }
  ExpectNumbers(reported, Under("/false_pushes", {"/contacts", "/farther_than_0_6_voxel",
                                                  "/askew_by_10_deg", "/share_of_force"}));
  // about as many contacts as were asked for
  EXPECT_GT(reported["false_pushes"]["contacts"], 1000);
  EXPECT_LT(reported["false_pushes"]["contacts"], 3000);
}

TEST(BenchCommand, FidelityMeasuresAllModels) {
  const ProgramOutput output = RunTandem("bench fidelity --only screw");
  EXPECT_EQ(output.exit_code, kExitUsage);
  EXPECT_NE(output.err.find("first-force"), std::string::npos) << output.err;
}

TEST(BenchCommand, MissingTemporaryFolderIsRefusedInOneLine) {
  // a folder in which nobody can make one, and a folder that does not exist
  for (const std::string folder : {"/proc", "/nowhere"}) {
    const ProgramOutput output =
        RunTandem("bench session --peers 2 --seconds 1", "TMPDIR=" + folder + " timeout 60 ");
    testing::ExpectRefused(output, kExitFile, "no temporary folder can be made there");
  }
}

}  // namespace
}  // namespace tandem
