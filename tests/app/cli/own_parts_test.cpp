// Tests `tandem contact` on parts of our own at poses that exact geometry judges here: a peg in a
// round hole, a key in a keyway, a nut on its bolt. PosesOfRealParts has larger parts that others
// made and judged.
#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "engine/geometry/exact/exact_surface.h"
#include "scenes/generators/shapes.h"
#include "tests/app/cli/program_run.h"
#include "tests/scenes/generators/solid_probe.h"
#include "tests/support/obj_text.h"

namespace tandem {
namespace {

using testing::ObjText;
using testing::ProgramOutput;
using testing::RunTandem;

constexpr double kOwnVoxel = 0.1;        // mm, as all lengths here
constexpr double kSampleSpacing = 0.25;  // spacing of samples on a surface
constexpr double kOwnFarVoxels = 2.6;    // beyond it nothing may touch at layer 0
constexpr double kDeepVoxels = 0.1;      // depth from which parts collide for certain
constexpr int kOwnPoses = 24;

/// Two parts as they go together, and how far the moving part is moved from there.
struct OwnPair {
  const char* name;
  TriangleMesh fixed;
  TriangleMesh moving;
  double shift;      // mm, at most
  double turn_deg;   // at most, about any axis
  double pitch = 0;  // pitch of a thread about z, along which the part is also screwed
};

/// Returns a ring whose inner wall is the thread of ThreadedEnd() with this play, from z = 0 down.
TriangleMesh NutOf(double radius, double pitch, double length, double play, double outer,
                   int sides) {
  constexpr int kStepsPerTurn = 12;
  const int steps = static_cast<int>(std::ceil(kStepsPerTurn * length / pitch));
  const auto ring = [sides](double z, const auto& radius_at) {
    Loop loop;
    for (int i = 0; i < sides; ++i) {
      const double turn = static_cast<double>(i) / sides;
      const double angle = 2 * std::numbers::pi * turn;
      const double r = radius_at(turn);
      loop.emplace_back(r * std::cos(angle), r * std::sin(angle), z);
    }
    return loop;
  };
  std::vector<Loop> loops;
  for (int k = 0; k <= steps; ++k) {
    const double z = -length * k / steps;
    loops.push_back(ring(z, [&](double turn) {
      const double phase = z / pitch - turn;
      return radius + play - 0.55 * pitch * 2 * std::abs(phase - std::round(phase));
    }));
  }
  for (const double z : {-length, 0.0}) {
    loops.push_back(ring(z, [outer](double) {
      return outer;
    }));
  }
  TriangleMesh mesh = Skin(loops, SkinEnds::kJoined);
  if (!ClosedAndTurnedOutward(mesh)) {
    for (TriangleMesh::Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
  }
  return mesh;
}

std::vector<OwnPair> OwnPairs() {
  const Outline disc{{Vec2::Zero(), 7}};
  const Outline hole{{Vec2::Zero(), 3}};
  const auto rectangle = [](double x, double y) {
    return Outline{{{x, y}, 0}, {{-x, y}, 0}, {{-x, -y}, 0}, {{x, -y}, 0}};
  };
  const PlateEdges edges{.outer_round = 0.5, .hole_round = 0.3};
  return {{"round_peg", Plate(disc, hole, -2, 2, edges),
           Revolved({{2.2, -3}, {2.2, 2.5}, {1.8, 3}}, 48), 2, 10},
          {"key", Plate(rectangle(7, 5.5), rectangle(3, 2), -2, 2, edges),
           tandem::Box(Vec3(-2.2, -1.2, -3), Vec3(2.2, 1.2, 3)), 2, 10},
          {"nut", ThreadedEnd(4, 3, 14, 36), Moved(NutOf(4, 3, 5, 1.1, 6.5, 36), Vec3(0, 0, -6)),
           1.4, 2, 3}};
}

/// Judges how near two parts come, by exact distances of samples of both surfaces.
struct JudgedPose {
  bool collide = false;  // the parts collide for certain
  bool far = false;      // the parts are far for certain
};
class ExactJudge {
 public:
  ExactJudge(const TriangleMesh& fixed, const TriangleMesh& moving)
      : fixed_(fixed),
        moving_(moving),
        on_fixed_(SurfaceSamples(fixed, kSampleSpacing)),
        on_moving_(SurfaceSamples(moving, kSampleSpacing)) {}

  JudgedPose At(const Pose& X) const {
    const double deepest =
        std::max(Deepest(fixed_, on_moving_, X), Deepest(moving_, on_fixed_, X.Inverse()));
    return {deepest > kDeepVoxels * kOwnVoxel,
            -deepest > kOwnFarVoxels * kOwnVoxel + kSampleSpacing};
  }

 private:
  static double Deepest(const ExactSurface& solid, const std::vector<Vec3>& samples,
                        const Pose& X) {
    // a part that comes in by more passes through the surface, where other samples are
    constexpr double kReach = 2 * kOwnFarVoxels * kOwnVoxel + kSampleSpacing;
    double deepest = -kReach;
    for (const Vec3& p : samples) {
      const double distance = solid.Distance(X * p, kReach);
      if (distance >= kReach || distance <= deepest) continue;
      deepest = std::max(deepest, solid.Contains(X * p) ? distance : -distance);
    }
    return deepest;
  }

  ExactSurface fixed_;
  ExactSurface moving_;
  std::vector<Vec3> on_fixed_;
  std::vector<Vec3> on_moving_;
};

/// The program's answer for one pose.
struct OwnAnswer {
  int contact_points = 0;
  int touching_points = 0;
  double force = 0;  // N
};

std::vector<OwnAnswer> OwnAnswers(const std::filesystem::path& folder, const std::string& more) {
  const ProgramOutput output =
      RunTandem("contact --static " + (folder / "fixed.obj").string() + " --dynamic " +
                (folder / "moving.obj").string() + " --voxel " + std::to_string(1e-3 * kOwnVoxel) +
                " --scale 0.001 --poses " + (folder / "poses.csv").string() + " --csv " + more);
  EXPECT_EQ(output.exit_code, 0) << output.err;
  std::istringstream lines(output.out);
  std::string line;
  std::getline(lines, line);  // the names of the columns
  std::vector<OwnAnswer> answers;
  while (std::getline(lines, line)) {
    std::istringstream cells(line);
    std::vector<std::string> cell;
    for (std::string one; std::getline(cells, one, ',');) cell.push_back(one);
    answers.push_back(
        {std::stoi(cell.at(1)), std::stoi(cell.at(2)),
         std::hypot(std::stod(cell.at(3)), std::stod(cell.at(4)), std::stod(cell.at(5)))});
  }
  return answers;
}

class PosesOfOwnParts : public ::testing::TestWithParam<std::size_t> {};

TEST_P(PosesOfOwnParts, ContactOccursOnlyInCollidingPoses) {
  const OwnPair pair = OwnPairs()[GetParam()];
  ASSERT_TRUE(ClosedAndTurnedOutward(pair.fixed));
  ASSERT_TRUE(ClosedAndTurnedOutward(pair.moving));
  std::mt19937_64 random(GetParam());
  std::uniform_real_distribution<double> within(-1, 1);
  const auto vector = [&] {
    const double x = within(random);
    const double y = within(random);
    return Vec3(x, y, within(random));
  };
  std::ostringstream csv;
  csv.precision(17);
  csv << "fixed,moving,tx,ty,tz,ax,ay,az,angle_deg\n";
  std::vector<Pose> poses;
  for (int i = 0; i < kOwnPoses; ++i) {
    // from the pose in which the parts go together to the largest move
    const double share = static_cast<double>(i) / kOwnPoses;
    const double screwed = pair.pitch > 0 ? std::numbers::pi * within(random) : 0;
    const Quat askew = RotationBy(share * pair.turn_deg * std::numbers::pi / 180 * vector());
    const Quat q = askew * RotationBy(Vec3(0, 0, screwed));
    const Vec3 p =
        share * pair.shift * vector() + Vec3(0, 0, pair.pitch * screwed / (2 * std::numbers::pi));
    const Vec3 turn = RotationVector(q);
    const Vec3 axis = turn.norm() > 0 ? Vec3(turn.normalized()) : Vec3(Vec3::UnitZ());
    poses.push_back({q, p});
    csv << "fixed.obj,moving.obj," << p.x() << ',' << p.y() << ',' << p.z() << ',' << axis.x()
        << ',' << axis.y() << ',' << axis.z() << ',' << turn.norm() * 180 / std::numbers::pi
        << '\n';
  }
  const ScratchFolder folder;
  folder.Write("fixed.obj", ObjText(pair.fixed));
  folder.Write("moving.obj", ObjText(pair.moving));
  folder.Write("poses.csv", csv.str());
  // the plain model at layer 0 tells which points reach the surface itself
  const std::vector<OwnAnswer> at_surface =
      OwnAnswers(folder.path(), "--contact plain --force-layer 0");
  const std::vector<OwnAnswer> around = OwnAnswers(folder.path(), "--force-layer 1");
  ASSERT_EQ(at_surface.size(), poses.size());
  ASSERT_EQ(around.size(), poses.size());

  const ExactJudge judge(pair.fixed, pair.moving);
  int far = 0;
  int colliding = 0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const JudgedPose judged = judge.At(poses[i]);
    far += judged.far ? 1 : 0;
    colliding += judged.collide ? 1 : 0;
    if (judged.far) {
      EXPECT_EQ(at_surface[i].touching_points, 0) << pair.name << ", pose " << i;
    }
    if (judged.collide) {
      EXPECT_GT(around[i].touching_points, 0) << pair.name << ", pose " << i;
      EXPECT_GT(around[i].contact_points, 0) << pair.name << ", pose " << i;
      EXPECT_GT(around[i].force, 0) << pair.name << ", pose " << i;
    }
  }
  RecordProperty("far", far);
  RecordProperty("colliding", colliding);
  EXPECT_GE(far, 3) << pair.name;
  EXPECT_GE(colliding, 5) << pair.name;
}

INSTANTIATE_TEST_SUITE_P(All, PosesOfOwnParts, ::testing::Values(0, 1, 2), [](const auto& tested) {
  return std::string(OwnPairs()[tested.param].name);
});

}  // namespace
}  // namespace tandem
