#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <set>

#include "app/cli/commands.h"
#include "app/common/console.h"
#include "app/common/exit_codes.h"
#include "app/common/option_checks.h"
#include "app/common/poses_file.h"
#include "app/common/scene_files.h"
#include "engine/contact/pair/contact_pair.h"
#include "engine/geometry/exact/exact_surface.h"
#include "engine/geometry/import/mesh_file.h"
#include "engine/geometry/import/unit_hint.h"
#include "engine/geometry/mesh/mass_properties.h"
#include "engine/voxel/build/voxelize.h"
#include "engine/world/world.h"

namespace tandem {

namespace {

constexpr std::size_t kLongestNames = 300;  // bytes of names that a message lists

struct ContactArguments {
  std::string fixed;
  std::string moving;
  std::string poses;
  std::string body;  // name of the moving part in the poses file; empty: its mesh file's
  double voxel = 0;
  double spacing = 0;  // m; 0: the voxel's size
  std::optional<double> scale;
  int force_layer = -1;  // -1: the model's own
  std::string contact = "refined";
  ContactModel model = ContactModel::kRefined;  // the model of that name
  bool csv = false;

  double SpacingOfPoints() const { return spacing > 0 ? spacing : voxel; }
};

std::string Basename(const std::string& path) {
  return std::filesystem::path(path).filename().string();
}

/// Returns whether any part of triangle a b c may come within `reach` of the solid, or into it. It
/// cuts the triangle in two until each piece is smaller than the reach. Such a piece counts as near
/// if its centre is within the reach and the piece's radius.
bool ComesNear(const ExactSurface& solid, const Vec3& a, const Vec3& b, const Vec3& c,
               double reach) {
  const Vec3 middle = (a + b + c) / 3.0;
  const double radius = std::max({(a - middle).norm(), (b - middle).norm(), (c - middle).norm()});
  if (-solid.Depth(middle) > radius + reach) return false;
  if (radius <= reach) return true;
  const double ab = (b - a).squaredNorm();
  const double bc = (c - b).squaredNorm();
  const double ca = (a - c).squaredNorm();
  if (bc >= ab && bc >= ca) return ComesNear(solid, b, c, a, reach);
  if (ca > ab) return ComesNear(solid, c, a, b, reach);
  const Vec3 half = 0.5 * (a + b);
  return ComesNear(solid, a, half, c, reach) || ComesNear(solid, half, b, c, reach);
}

/// Returns whether no point could read anything but "beyond" at any of the poses (of the moving
/// mesh's frame). Then its surface stays farther from the fixed solid than the farthest marked
/// voxel can be.
bool StaysBeyond(const TriangleMesh& fixed, const TriangleMesh& moving,
                 const std::vector<FilePose>& poses, double voxel) {
  const ExactSurface solid(fixed);
  if (solid.empty()) return false;  // an open solid: its distance cannot be told here
  // the range, and half a diagonal each for the source voxel's own surface and the point's voxel,
  // to spare
  const double reach = std::sqrt(3.0) * (kDefaultRange + 3) * voxel;
  return std::none_of(poses.begin(), poses.end(), [&](const FilePose& pose) {
    for (std::size_t t = 0; t < moving.triangles.size(); ++t) {
      if (ComesNear(solid, pose.X_WM * moving.corner(t, 0), pose.X_WM * moving.corner(t, 1),
                    pose.X_WM * moving.corner(t, 2), reach)) {
        return true;
      }
    }
    return false;
  });
}

void PrintHeader(bool timed) {
  PrintLine("index,contact_points,touching_points,fx,fy,fz,tx,ty,tz,nearest_voxels%s",
            timed ? ",t_s" : "");
}

void PrintRow(const FilePose& pose, const PoseReading& reading) {
  const Wrench wrench = AsWrench(reading.on_shell.force);
  const bool far = reading.nearest_voxels == std::numeric_limits<int>::max();
  PrintLine("%zu,%d,%d,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%s%s", pose.row, reading.contact_points,
            reading.touching_points, wrench.f.x(), wrench.f.y(), wrench.f.z(), wrench.tau.x(),
            wrench.tau.y(), wrench.tau.z(),
            far ? "" : std::to_string(reading.nearest_voxels).c_str(),
            pose.t_s ? ("," + SecondsText(*pose.t_s)).c_str() : "");
}

/// Returns whether a row's body is the moving part: by the name of its mesh file, or of the file
/// without its ending, or by --body.
bool IsMoving(const std::string& name, const ContactArguments& arguments) {
  if (!arguments.body.empty()) return name == arguments.body;
  const std::filesystem::path mesh = arguments.moving;
  return Basename(name) == mesh.filename() || name == mesh.stem();
}

/// Returns the rows of the file that are about these two parts, with translations in metres. Rows
/// without a fixed part are of a scene, and in metres already.
std::vector<FilePose> PosesOfPair(std::vector<FilePose> poses, const ContactArguments& arguments) {
  std::erase_if(poses, [&](const FilePose& pose) {
    if (pose.fixed.empty()) return !IsMoving(pose.moving, arguments);
    return Basename(pose.fixed) != Basename(arguments.fixed) ||
           Basename(pose.moving) != Basename(arguments.moving);
  });
  for (FilePose& pose : poses) {
    if (!pose.fixed.empty()) pose.X_WM.p *= arguments.scale.value_or(1);
  }
  return poses;
}

/// Returns why the file has no pose of these parts.
std::string WhyNoPose(const std::vector<FilePose>& all, const ContactArguments& arguments) {
  if (all.empty()) return arguments.poses + ": the file has no pose";
  if (!all.front().fixed.empty()) {
    return arguments.poses + ": the file has no pose of " + Basename(arguments.moving) + " in " +
           Basename(arguments.fixed);
  }
  std::set<std::string> names;
  for (const FilePose& pose : all) names.insert(pose.moving);
  std::string known;
  for (const std::string& name : names) {
    if (known.size() < kLongestNames) known += (known.empty() ? "" : ", ") + name;
  }
  return arguments.poses + ": the file has no pose of " +
         (arguments.body.empty() ? Basename(arguments.moving) : arguments.body) +
         ": name the body with --body; it has " + known;
}

constexpr double kMass = 0.3;  // kg, for the gains of a part of this mass

/// The two parts as the contact model has them, at rest in W.
struct PosedParts {
  std::unique_ptr<BodySurface> fixed_surface;  // in the refined model
  std::unique_ptr<BodySurface> moving_surface;
  std::unique_ptr<Voxmap> voxmap;  // in the plain model
  std::unique_ptr<Pointshell> shell;
  std::unique_ptr<BodyPair> pair;
  std::size_t points = 0;  // points that are looked up
};

Result<PosedParts> MakePlainParts(const ContactArguments& arguments, const TriangleMesh& fixed,
                                  const TriangleMesh& moving, const Pose& X_MB) {
  const double flatness = FlatnessVoxels(ContactModel::kPlain);
  Result<Voxmap> voxmap =
      Voxelize(fixed, {.voxel_size = arguments.voxel, .flatness_voxels = flatness});
  if (!voxmap) return Error{arguments.fixed + ": " + voxmap.error().what};
  Result<Pointshell> shell = MakePointshell(
      moving, X_MB, {.spacing = arguments.SpacingOfPoints(), .flatness_voxels = flatness});
  if (!shell) return Error{arguments.moving + ": " + shell.error().what};
  PosedParts parts;
  parts.points = shell->size();
  parts.voxmap = std::make_unique<Voxmap>(std::move(*voxmap));
  parts.shell = std::make_unique<Pointshell>(std::move(*shell));
  parts.pair = std::make_unique<ContactPair>(
      *parts.shell, *parts.voxmap, Pose{Quat::Identity(), parts.voxmap->p_WVo()}, 0,
      PairOptions{.force_layer = arguments.force_layer, .schedule = {}},
      DefaultContactGains(arguments.voxel, kMass, kFrame));
  return parts;
}

Result<PosedParts> MakeParts(const ContactArguments& arguments, const TriangleMesh& fixed,
                             const TriangleMesh& moving, const Pose& X_MB) {
  if (arguments.model == ContactModel::kPlain) {
    return MakePlainParts(arguments, fixed, moving, X_MB);
  }
  Scene scene;
  scene.voxel_size = arguments.voxel;
  Result<BodySurface> map = MakeSurface(scene, fixed, Pose{});
  if (!map) return Error{arguments.fixed + ": " + map.error().what};
  Result<BodySurface> shell =
      MakeSurface(scene, moving, X_MB, arguments.SpacingOfPoints() / arguments.voxel);
  if (!shell) return Error{arguments.moving + ": " + shell.error().what};
  map->radius = 0;  // the fixed part never moves
  PosedParts parts;
  parts.points = shell->features.point_count();
  parts.fixed_surface = std::make_unique<BodySurface>(std::move(*map));
  parts.moving_surface = std::make_unique<BodySurface>(std::move(*shell));
  parts.pair =
      std::make_unique<FieldPair>(*parts.moving_surface, *parts.fixed_surface, FieldPair::Options{},
                                  DefaultContactGains(arguments.voxel, kMass, kFrame));
  return parts;
}

int RunContact(const ContactArguments& arguments) {
  const std::string fault = LayerFault(arguments.model, arguments.force_layer);
  if (!fault.empty()) return Fail(kExitUsage, "--force-layer: " + fault);
  if (arguments.spacing > arguments.voxel) {
    return Fail(kExitUsage,
                "--spacing: expected at most the size of --voxel, because points farther apart "
                "miss contacts");
  }
  Result<std::vector<FilePose>> all_poses = ReadPosesFile(arguments.poses);
  if (!all_poses) return Fail(kExitFile, all_poses.error().what);
  const std::vector<FilePose> poses = PosesOfPair(*all_poses, arguments);
  if (poses.empty()) return Fail(kExitFile, WhyNoPose(*all_poses, arguments));
  if (poses.front().fixed.empty()) {
    Say(arguments.poses + ": has no column fixed, so its poses are in the frame of " +
        Basename(arguments.fixed) + ", in metres");
  }
  const bool timed = poses.front().t_s.has_value();
  const ImportOptions import{.scale = arguments.scale};
  const Result<TriangleMesh> fixed = ImportAndTell(arguments.fixed, import);
  if (!fixed) return Fail(kExitFile, fixed.error().what);
  const Result<TriangleMesh> moving = ImportAndTell(arguments.moving, import);
  if (!moving) return Fail(kExitFile, moving.error().what);

  const VoxelizeOptions options{.voxel_size = arguments.voxel};
  const std::size_t need =
      std::max(EstimateVoxelizeBytes(*fixed, options), EstimateVoxelizeBytes(*moving, options));
  if (need > options.max_memory_bytes && StaysBeyond(*fixed, *moving, poses, arguments.voxel)) {
    // no pose would read a stored voxel
    if (arguments.csv) PrintHeader(timed);
    for (const FilePose& pose : poses) {
      if (arguments.csv) PrintRow(pose, PoseReading{});
    }
    Say("0 of " + WithPlural(poses.size(), "pose") +
        " touch: the parts are out of range of one another");
    return kExitOk;
  }
  const Pose X_MB{Quat::Identity(), ComputeMassProperties(*moving).p_MBo};
  const Result<PosedParts> parts = MakeParts(arguments, *fixed, *moving, X_MB);
  if (!parts) return Fail(kExitFile, parts.error().what);
  BodyPair& pair = *parts->pair;
  std::size_t touching = 0;
  if (arguments.csv) PrintHeader(timed);
  for (const FilePose& pose : poses) {
    const PoseReading reading = pair.Read({.X_WB = pose.X_WM * X_MB, .V_WB = {}}, BodyMotion{});
    touching += reading.touching_points > 0 ? 1 : 0;
    if (arguments.csv) PrintRow(pose, reading);
  }
  Say(std::to_string(touching) + " of " + WithPlural(poses.size(), "pose") + " touch; " +
      WithPlural(parts->points, "point"));
  return kExitOk;
}

}  // namespace

void AddContactCommand(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<ContactArguments>();
  CLI::App* command =
      app.add_subcommand("contact", "Compute the contact of a part with another at given poses");
  command->add_option("--static", arguments->fixed, "mesh file that is voxelized")->required();
  command->add_option("--dynamic", arguments->moving, "mesh file that gives the surface points")
      ->required();
  command->add_option("--voxel", arguments->voxel, "voxel size, m")
      ->required()
      ->check(NumberFrom(kLeastVoxel, kLargestVoxel));
  command
      ->add_option("--spacing", arguments->spacing,
                   "point spacing, m, at most the voxel size; default: the voxel size")
      ->check(NumberFrom(kLeastVoxel, kLargestVoxel));
  command->add_option("--poses", arguments->poses, "CSV file with poses of the part of --dynamic")
      ->required();
  command->add_option("--body", arguments->body,
                      "name of the moving part in a poses file without column fixed; default: the "
                      "name of its mesh file, without or with the ending");
  command->add_option("--scale", arguments->scale, kScaleHelp)
      ->check(NumberFrom(kLeastScale, kLargestScale));
  command
      ->add_option(
          "--force-layer", arguments->force_layer,
          "first layer of voxels that pushes; default: 1 with refined contact, 2 with plain")
      ->check(WholeNumberFrom(0, kDefaultRange - 2));
  command
      ->add_option("--contact", arguments->contact,
                   "contact model: refined, or plain as in the paper")
      ->check(OneOf({"refined", "plain"}))
      ->capture_default_str();
  command->add_flag("--csv", arguments->csv, "print one line for each pose");
  command->footer(
      "A poses file is CSV. Its header names at least moving,tx,ty,tz,ax,ay,az,angle_deg, and "
      "fixed where there\nare several fixed parts. These are the names of the two mesh files; the "
      "place of the moving file's frame\nin the fixed one's, in units of --scale, else in metres; "
      "and the axis and angle of its rotation. Rows of\nother files are ignored. A file without "
      "the column fixed, such as 'tandem replay --export FILE.csv' writes,\nhas poses in a scene, "
      "in metres: the fixed file's frame must be the scene's. With a column t_s, the\noutput has "
      "it too. 'tandem proximity' reads the same files.");
  command->callback([arguments, &exit_code] {
    if (arguments->contact == "plain") arguments->model = ContactModel::kPlain;
    if (arguments->force_layer < 0) arguments->force_layer = DefaultForceLayer(arguments->model);
    exit_code = RunContact(*arguments);
  });
}

}  // namespace tandem
