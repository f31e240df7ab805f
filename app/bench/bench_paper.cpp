#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>
#include <tbb/global_control.h>

#include "app/bench/bench_commands.h"
#include "app/bench/measure/voxelize_times.h"
#include "app/common/console.h"
#include "app/common/exit_codes.h"
#include "app/common/option_checks.h"
#include "app/common/scene_files.h"
#include "app/picture/svg.h"
#include "engine/base/files/whole_file.h"
#include "engine/base/text/json_text.h"

// This file measures the paper's table 1 and figure 10 (section 7) on this machine.

namespace tandem {

namespace {

std::string Short(double value, const char* format) {
  char text[32];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

/// A row of the table as the paper printed it.
struct PrintedRow {
  const char* scene;
  double points_mm;
  double voxel_mm;
  double voxelize_s;
  double load_s;
  double moving_triangles;
  double points;
  double fixed_triangles;
  double voxels;
};
constexpr std::array<PrintedRow, 4> kTable1{
    {{"ball_and_socket", 0.35, 0.35, 5.8, 1.7, 2048, 23960, 2176, 5.91e5},
     {"ball_and_socket", 0.15, 0.15, 21.5, 7.0, 2048, 130688, 2176, 3.11e6},
     {"landing_gear", 1.0, 2.5, 1353, 333, 40476, 528653, 2.76e6, 4.59e8},
     {"landing_gear", 0.7, 1.25, 5861, 1355, 40476, 1.14e6, 2.76e6, 1.78e9}}};

struct Table1Arguments {
  std::vector<std::string> scenes{"ball_and_socket", "landing_gear"};
  std::size_t threads = 2;
  bool json = false;
};

int RunTable1(const Table1Arguments& arguments) {
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, arguments.threads);
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  if (!arguments.json) {
    std::printf("%-24s %7s %7s %9s %9s | %9s %9s %10s %11s\n", "", "points", "voxels", "voxelize",
                "load", "triangles", "points", "triangles", "voxels");
    std::printf("%-24s %7s %7s %9s %9s | %9s %9s %10s %11s\n", "scene", "mm", "mm", "s", "s",
                "moving", "", "fixed", "");
  }
  for (const PrintedRow& paper : kTable1) {
    if (std::ranges::count(arguments.scenes, paper.scene) == 0) continue;
    const Result<SceneTimes> times =
        TimeScene(paper.scene, 1e-3 * paper.voxel_mm, 1e-3 * paper.points_mm);
    if (!times) return Fail(kExitFile, times.error().what);
    const VoxelCounts& voxels = times->voxels;
    if (arguments.json) {
      rows.push_back(
          {{"name", paper.scene},
           {"points_mm", paper.points_mm},
           {"voxel_mm", paper.voxel_mm},
           {"triangles", {{"moving", times->moving_triangles}, {"fixed", times->fixed_triangles}}},
           {"points", times->points},
           {"voxels",
            {{"interior", voxels.interior}, {"surface", voxels.surface}, {"band", voxels.free}}},
           {"voxelize_s", times->voxelize_s},
           {"load_s", times->load_s},
           {"paper",
            {{"triangles", {{"moving", paper.moving_triangles}, {"fixed", paper.fixed_triangles}}},
             {"points", paper.points},
             {"voxels", paper.voxels},
             {"voxelize_s", paper.voxelize_s},
             {"load_s", paper.load_s}}}});
      continue;
    }
    std::printf("%-24s %7.2f %7.2f %9.4g %9.4g | %9.6g %9.6g %10.7g %11.4g\n",
                (std::string(paper.scene) + ", paper").c_str(), paper.points_mm, paper.voxel_mm,
                paper.voxelize_s, paper.load_s, paper.moving_triangles, paper.points,
                paper.fixed_triangles, paper.voxels);
    std::printf("%-24s %7s %7s %9.4g %9.4g | %9zu %9zu %10zu %11.4g\n", "  here", "", "",
                times->voxelize_s, times->load_s, times->moving_triangles, times->points,
                times->fixed_triangles, static_cast<double>(voxels.total()));
    std::printf("%-24s interior %zu, surface %zu, free %zu\n", "", voxels.interior, voxels.surface,
                voxels.free);
  }
  if (arguments.json) {
    const nlohmann::ordered_json out{{"threads", arguments.threads}, {"rows", rows}};
    std::printf("%s\n", JsonText(out, 2).c_str());
  }
  return kExitOk;
}

struct Figure10Arguments {
  std::string scene = "landing_gear";
  double smallest_mm = 1.25;
  double largest_mm = 10;
  std::string out;
  std::size_t threads = 2;
  bool json = false;
};

int RunFigure10(const Figure10Arguments& arguments) {
  if (arguments.largest_mm < 2 * arguments.smallest_mm) {
    return Fail(kExitUsage, "--largest-mm must be at least twice --smallest-mm");
  }
  if (!arguments.out.empty()) {
    std::error_code failed;
    std::filesystem::create_directories(arguments.out, failed);
    if (failed) return Fail(kExitFile, arguments.out + ": " + failed.message());
  }
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, arguments.threads);
  std::vector<VoxelizeTime> times;
  // voxel sizes go from coarse to fine by factors of the square root of two
  const int steps = static_cast<int>(
      std::floor(2 * std::log2(arguments.largest_mm / arguments.smallest_mm) + 1e-9));
  const Result<TriangleMesh> mesh = FixedMeshOf(arguments.scene);
  if (!mesh) return Fail(kExitFile, mesh.error().what);
  for (int step = steps; step >= 0; --step) {
    const double voxel_mm = arguments.smallest_mm * std::pow(2, 0.5 * step);
    const Result<VoxelizeTime> time = TimeVoxelize(*mesh, 1e-3 * voxel_mm);
    if (!time) return Fail(kExitFile, arguments.scene + ": " + time.error().what);
    times.push_back(*time);
    if (!arguments.json) {
      std::printf("%7.3f mm  %9.4f s  %.4g voxels\n", voxel_mm, time->seconds,
                  static_cast<double>(time->voxels));
    }
  }
  const PowerLaw law = FitPowerLaw(times);
  const PowerLaw finest = FitPowerLaw({times.end()[-2], times.end()[-1]});
  if (!arguments.out.empty()) {
    std::string csv = "voxel_mm,seconds,voxels\n";
    for (const VoxelizeTime& time : times) {
      csv += Short(1e3 * time.voxel_size, "%.6g") + "," + Short(time.seconds, "%.6g") + "," +
             std::to_string(time.voxels) + "\n";
    }
    const std::filesystem::path folder = arguments.out;
    auto fault = WriteWholeFile(folder / "figure10.csv", csv);
    if (!fault) {
      fault = WriteWholeFile(folder / "figure10.svg",
                             SvgOf(Figure10Picture(times, law), SvgPlace::kFile));
    }
    if (fault) return Fail(kExitFile, fault->what);
  }
  if (arguments.json) {
    nlohmann::ordered_json points = nlohmann::ordered_json::array();
    for (const VoxelizeTime& time : times) {
      points.push_back({{"voxel_mm", 1e3 * time.voxel_size},
                        {"seconds", time.seconds},
                        {"voxels", time.voxels}});
    }
    const nlohmann::ordered_json out{
        {"scene", arguments.scene}, {"threads", arguments.threads},       {"times", points},
        {"exponent", law.exponent}, {"finest_exponent", finest.exponent}, {"paper_exponent", -2}};
    std::printf("%s\n", JsonText(out, 2).c_str());
    return kExitOk;
  }
  std::printf(
      "the time is proportional to the voxel size to the power of %.3f, at the finest two of %.3f "
      "(paper: -2)\n",
      law.exponent, finest.exponent);
  return kExitOk;
}

}  // namespace

void AddBenchTable1(CLI::App& bench, int& exit_code) {
  auto arguments = std::make_shared<Table1Arguments>();
  CLI::App* command = bench.add_subcommand(
      "table1", "Print the paper's table 1 beside the same counts here, in plain contact");
  command->add_option("--scenes", arguments->scenes, "scenes, one row each")
      ->check(OneOf({"ball_and_socket", "landing_gear"}))
      ->delimiter(',');
  command->add_option("--threads", arguments->threads, "threads")
      ->check(WholeNumberFrom(1, kMostThreads))
      ->capture_default_str();
  command->add_flag("--json", arguments->json, "print one JSON object");
  command->callback([arguments, &exit_code] {
    exit_code = RunTable1(*arguments);
  });
}

void AddBenchFigure10(CLI::App& bench, int& exit_code) {
  auto arguments = std::make_shared<Figure10Arguments>();
  CLI::App* command = bench.add_subcommand(
      "figure10", "Measure the paper's figure 10: voxelization time against voxel size");
  command->add_option("--scene", arguments->scene, "name of a scene, or a scene file")
      ->capture_default_str();
  command->add_option("--smallest-mm", arguments->smallest_mm, "smallest voxel size, mm")
      ->check(NumberFrom(1e-2, 1e3))
      ->capture_default_str();
  command->add_option("--largest-mm", arguments->largest_mm, "largest voxel size, mm")
      ->check(NumberFrom(1e-2, 1e3))
      ->capture_default_str();
  command->add_option("--out", arguments->out, "folder for figure10.csv and figure10.svg");
  command->add_option("--threads", arguments->threads, "threads")
      ->check(WholeNumberFrom(1, kMostThreads))
      ->capture_default_str();
  command->add_flag("--json", arguments->json, "print one JSON object");
  command->callback([arguments, &exit_code] {
    exit_code = RunFigure10(*arguments);
  });
}

}  // namespace tandem
