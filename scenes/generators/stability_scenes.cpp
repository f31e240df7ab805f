#include <cmath>

#include "scenes/generators/generated_scene.h"
#include "scenes/generators/shapes.h"

// Makes the scenes of the stability lab; hands knock and pull along x.
//
//    free   a cube of 40 mm in free space
//    wall   the cube, and a wall 2 mm to its right
//    slot   the cube in a slot 6 mm wider, turned by 20 degrees, so that it strikes both its sides
//           and its end
//    ball   a ball in a socket that goes round it beyond its equator, 10 mm apart all round
namespace tandem {
namespace {

// mm
constexpr double kCubeHalf = 20;
constexpr double kToWall = 2;
constexpr double kThick = 8;
constexpr double kWide = 60;  // half the wall's width
constexpr double kSlotGap = 3;
constexpr double kSlotEnd = 6;  // distance from the cube to the slot's end
constexpr double kSlotTurn = 20 * M_PI / 180;
constexpr double kLabBallRadius = 12;
constexpr double kBallGap = 10;
constexpr double kSocketThick = 6;
/// Angle above the equator at which the socket ends.
constexpr double kSocketUpper = 35 * M_PI / 180;
constexpr double kSocketLower = 65 * M_PI / 180;  // the same below: it is open at the bottom
constexpr int kSocketSteps = 16;
constexpr int kSocketSides = 64;
constexpr int kBallLevels = 3;

TriangleMesh Rotated(TriangleMesh mesh, double angle) {
  const Mat3 R = Eigen::AngleAxisd(angle, Vec3::UnitZ()).toRotationMatrix();
  for (Vec3& v : mesh.vertices) v = R * v;
  return mesh;
}

TriangleMesh Cube() {
  return Box(Vec3::Constant(-kCubeHalf), Vec3::Constant(kCubeHalf));
}

TriangleMesh Slot() {
  const double inner = kCubeHalf + kSlotGap;
  const double outer = inner + kThick;
  const double end = kCubeHalf + kSlotEnd;
  const double open = -kWide;
  const std::vector<Vec2> section = {{open, -outer}, {end + kThick, -outer}, {end + kThick, outer},
                                     {open, outer},  {open, inner},          {end, inner},
                                     {end, -inner},  {open, -inner}};
  return Rotated(Prism(section, -kCubeHalf, kCubeHalf), kSlotTurn);
}

TriangleMesh Socket() {
  const double inner = kLabBallRadius + kBallGap;
  std::vector<Vec2> profile;
  for (const double radius : {inner, inner + kSocketThick}) {
    for (int i = 0; i <= kSocketSteps; ++i) {
      // down the inside, up the outside
      const double share =
          static_cast<double>(radius == inner ? i : kSocketSteps - i) / kSocketSteps;
      const double angle = kSocketUpper - share * (kSocketUpper + kSocketLower);
      profile.emplace_back(radius * std::cos(angle), radius * std::sin(angle));
    }
  }
  return RevolvedRing(profile, kSocketSides);
}

}  // namespace

GeneratedScene StabilityParts() {
  const double wall = kCubeHalf + kToWall;
  return {"stability",
          {{"cube.stl", Cube()},
           {"cube_in_slot.stl", Rotated(Cube(), kSlotTurn)},
           {"wall.stl", Box(Vec3(wall, -kWide, -kWide), Vec3(wall + kThick, kWide, kWide))},
           {"slot.stl", Slot()},
           {"ball.stl", OctahedralSphere(kLabBallRadius, kBallLevels, false)},
           {"socket.stl", Socket()}},
          {}};
}

}  // namespace tandem
