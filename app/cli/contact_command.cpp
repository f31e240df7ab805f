#include <cmath>

#include "app/cli/commands.h"
#include "app/cli/exit_codes.h"
#include "app/cli/poses_file.h"
#include "app/cli/talk.h"
#include "engine/contact/contact_pair.h"
#include "engine/geometry/mass_properties.h"
#include "engine/geometry/mesh_file.h"
#include "engine/voxel/voxelize.h"

namespace tandem {

namespace {

struct ContactArguments {
  std::string fixed;
  std::string moving;
  std::string poses;
  double voxel = 0;
  double scale = 1.0;
  int force_layer = 0;
  bool csv = false;
};

std::string Basename(const std::string& path) {
  return std::filesystem::path(path).filename().string();
}

int RunContact(const ContactArguments& arguments) {
  if (!(arguments.voxel > 0) || !(arguments.scale > 0)) {
    return Fail(kExitUsage, "--voxel and --scale must be above 0");
  }
  const Result<std::vector<FilePose>> poses = ReadPosesFile(arguments.poses);
  if (!poses) return Fail(kExitFile, poses.error().what);
  const ImportOptions import{.scale = arguments.scale};
  const Result<TriangleMesh> fixed = ImportMesh(arguments.fixed, import);
  if (!fixed) return Fail(kExitFile, fixed.error().what);
  const Result<TriangleMesh> moving = ImportMesh(arguments.moving, import);
  if (!moving) return Fail(kExitFile, moving.error().what);
  const Result<Voxmap> voxmap = Voxelize(*fixed, {.voxel_size = arguments.voxel});
  if (!voxmap) return Fail(kExitFile, arguments.fixed + ": " + voxmap.error().what);
  const Pose X_MB{Quat::Identity(), ComputeMassProperties(*moving).p_MBo};
  const Result<Pointshell> points = MakePointshell(*moving, X_MB, {.spacing = arguments.voxel});
  if (!points) return Fail(kExitFile, arguments.moving + ": " + points.error().what);

  const Pose X_WV{Quat::Identity(), voxmap->p_WVo()};
  ContactPair pair(*points, *voxmap, X_WV, arguments.force_layer,
                   DefaultContactGains(arguments.voxel));
  if (arguments.csv) {
    std::printf("index,contact_points,touching_points,fx,fy,fz,tx,ty,tz,nearest_voxels\n");
  }
  std::size_t read = 0;
  std::size_t touching = 0;
  for (const FilePose& pose : *poses) {
    if (Basename(pose.fixed) != Basename(arguments.fixed) ||
        Basename(pose.moving) != Basename(arguments.moving)) {
      continue;
    }
    const Pose X_WM{pose.X_WM.q, arguments.scale * pose.X_WM.p};
    const PoseReading reading = pair.Read({.X_WB = X_WM * X_MB, .V_WB = {}}, BodyMotion{});
    ++read;
    touching += reading.touching_points > 0 ? 1 : 0;
    if (!arguments.csv) continue;
    const Wrench wrench = AsWrench(reading.on_shell.force);
    std::printf("%zu,%d,%d,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,", pose.row, reading.contact_points,
                reading.touching_points, wrench.f.x(), wrench.f.y(), wrench.f.z(), wrench.tau.x(),
                wrench.tau.y(), wrench.tau.z());
    if (reading.nearest_voxels == std::numeric_limits<int>::max()) {
      std::printf("\n");
    } else {
      std::printf("%d\n", reading.nearest_voxels);
    }
  }
  if (read == 0) {
    return Fail(kExitFile, arguments.poses + ": has no pose of " + Basename(arguments.moving) +
                               " in " + Basename(arguments.fixed));
  }
  Say(std::to_string(touching) + " of " + std::to_string(read) + " poses touch; " +
      std::to_string(points->size()) + " points");
  return kExitOk;
}

}  // namespace

void AddContactCommand(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<ContactArguments>();
  CLI::App* command = app.add_subcommand("contact", "Test a part against another at given poses");
  command->add_option("--static", arguments->fixed, "mesh file that gives the voxels")->required();
  command->add_option("--dynamic", arguments->moving, "mesh file that gives the points")->required();
  command->add_option("--voxel", arguments->voxel, "voxel size in metres")->required();
  command->add_option("--poses", arguments->poses, "CSV file of poses of the moving part")->required();
  command->add_option("--scale", arguments->scale, "metres per file unit");
  command->add_option("--force-layer", arguments->force_layer, "layer that first pushes, from 0")
      ->check(CLI::Range(0, kDefaultRange - 2));
  command->add_flag("--csv", arguments->csv, "print one line a pose");
  command->callback([arguments, &exit_code] { exit_code = RunContact(*arguments); });
}

}  // namespace tandem
