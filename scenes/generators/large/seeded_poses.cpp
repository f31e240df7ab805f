#include "scenes/generators/large/seeded_poses.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <numbers>

#include "scenes/generators/large/clearance.h"
#include "scenes/generators/large/random_source.h"

namespace tandem {
namespace {

constexpr double kReach = 60;  // the farthest way to contact, mm
constexpr double kDegree = std::numbers::pi / 180;

Vec3 WayByChance(RandomSource& rng) {
  while (true) {
    const Vec3 v{rng.Uniform(-1, 1), rng.Uniform(-1, 1), rng.Uniform(-1, 1)};
    if (v.norm() > 0.1 && v.norm() <= 1) return v.normalized();
  }
}

/// Moves along `way` until the distance is `target`, never past it. Returns nothing if nothing
/// comes near within reach, or the mesh only slides along.
std::optional<Pose> Approach(const Clearance& clearance, Pose X, const Vec3& way, double target) {
  const Vec3 start = X.p;
  for (int step = 0; step < 40 && (X.p - start).norm() < kReach; ++step) {
    const double distance = clearance.At(X, kReach);
    if (distance < target) return std::nullopt;  // turned too near from the start
    if (distance < target + 0.01) return X;
    X.p += (distance - target) * way;
  }
  return std::nullopt;
}

struct Kind {
  const char* name;
  double least;  // voxels
  double most;
  double turn;    // degrees
  double spread;  // share of the pair's spread
};

}  // namespace

std::vector<SeededPose> SeededPoses(const PosedPair& pair, int of_each) {
  RandomSource rng(pair.seed);
  Bounds where;
  const Bounds box = BoundsOf(*pair.moving);
  for (const double sign : {-1.0, 1.0}) {
    const Vec3 edge = sign < 0 ? box.min : box.max;
    where.Add(edge + Vec3::Constant(sign * kReach));
    where.Add(edge + Vec3::Constant(sign * kReach) + pair.out);
  }
  const Clearance clearance(*pair.fixed, where, *pair.moving, 3 * pair.voxel);

  std::vector<SeededPose> poses;
  const auto turned = [&](double degrees) {
    const Vec3 axis = WayByChance(rng);
    return Pose{RotationBy(rng.Uniform(0, degrees) * kDegree * axis), Vec3::Zero()};
  };
  constexpr std::array kKinds = {Kind{"assembled", -0.5, -0.1, 0.01, 0.03},
                                 Kind{"near_1_2", 1, 2, 0.3, 1}, Kind{"near_3_8", 3, 8, 0.3, 1}};
  for (const Kind& kind : kKinds) {
    for (int made = 0; made < of_each;) {
      const double target = pair.voxel * rng.Uniform(kind.least, kind.most);
      const Pose start = turned(kind.turn);
      const Vec3 way = (pair.push + kind.spread * pair.spread * WayByChance(rng)).normalized();
      std::optional<Pose> X = Approach(clearance, start, way, std::max(target, 0.02));
      if (!X) continue;
      if (target < 0) X->p -= target * way;
      poses.push_back({kind.name, *X, target});
      ++made;
    }
  }
  for (int k = 0; k < of_each; ++k) {
    Pose X = turned(3);
    X.p = rng.Uniform(1, 1.5) * pair.out;
    poses.push_back({"far", X, clearance.At(X, kReach)});
  }
  return poses;
}

std::optional<Error> WritePoses(const PosedPair& pair, const std::vector<SeededPose>& poses,
                                const std::filesystem::path& file) {
  std::ofstream stream(file);
  stream << "fixed,moving,kind,tx,ty,tz,ax,ay,az,angle_deg,distance_mm\n";
  for (const SeededPose& pose : poses) {
    const Vec3 turn = RotationVector(pose.X.q);
    const Vec3 axis = turn.norm() > 0 ? Vec3(turn.normalized()) : Vec3(0, 0, 1);
    std::array<char, 200> line{};
    std::snprintf(line.data(), line.size(), "%s,%.6f,%.6f,%.6f,%.9f,%.9f,%.9f,%.9f,%.3f\n",
                  pose.kind.c_str(), pose.X.p.x(), pose.X.p.y(), pose.X.p.z(), axis.x(), axis.y(),
                  axis.z(), turn.norm() / kDegree, pose.distance);
    stream << pair.fixed_file << ',' << pair.moving_file << ',' << line.data();
  }
  stream.close();
  if (!stream) return Error{file.string() + ": cannot be written"};
  return std::nullopt;
}

}  // namespace tandem
