#include <cmath>
#include <numbers>
#include <vector>

#include "scenes/generators/large/clutter.h"
#include "scenes/generators/large/machine_parts.h"

// The clutter's actuator lies along x; a nest holds it, seen along x:
//
//    wall |          o  tie rod        | wall
//         |=     .-----------.        =|  guide rack
//         |--   /             \      --|  bolt
//         |   o|    barrel     |o      |
//         |=    \  with fins  /       =|
//         |  //  '-----------'  \\     |
//         |   \\       o       //      |  racks, 8 mm from the fins
//         |    \\   saddle    //       |
//    =====+============================+=====  base
//
// Fin rims cross the racks' teeth, so a push downwards touches in hundreds of places at once.
namespace tandem {
namespace {

constexpr double kFinRadius = 58;
constexpr double kBarrelRadius = 52;
constexpr double kBarrelLeft = -370;
constexpr double kBarrelRight = -10;
constexpr double kFlangeRadius = 57;
constexpr double kFlangeThickness = 18;
constexpr double kTieCircle = 62.5;  // distance from the axis: a seam outside the fins
constexpr double kTieRadius = 4;
constexpr double kRodRadius = 14;
constexpr double kEyeCentre = 408;
constexpr double kEyeRadius = 40;
constexpr double kClevisPin = -418;

constexpr double kCradleClearance = 8;
constexpr double kCradleAngle = 40 * std::numbers::pi / 180;  // from straight down
constexpr double kRackDepth = 24;
constexpr double kWall = 80;
constexpr double kGuideClearance = 12;
constexpr double kBase = -136;

constexpr double kValvesLeft = -240;
constexpr double kValvesRight = -150;
constexpr double kValvesHalf = 26;  // along y
constexpr double kValvesTop = 100;
constexpr double kPortEnd = 96;  // along y

TriangleMesh AboutX(const TriangleMesh& mesh, double angle) {
  return Rotated(mesh, RotationBy(Vec3(angle, 0, 0)));
}

/// Returns the number of sides of a round part at that fineness: a multiple of 8.
int SidesAt(double fineness, int sides) {
  return 8 * static_cast<int>(std::lround(fineness * sides / 8));
}

TriangleMesh Barrel(double fineness) {
  std::vector<Vec2> profile = {{kBarrelRadius - 3, kBarrelLeft}, {kBarrelRadius, kBarrelLeft + 3}};
  constexpr double kPitch = 10;
  for (double x = kBarrelLeft + 40; x < kBarrelRight - 40; x += kPitch) {
    for (const Vec2& p : {Vec2(kBarrelRadius, x), Vec2(kFinRadius, x + 1), Vec2(kFinRadius, x + 4),
                          Vec2(kBarrelRadius, x + 5)}) {
      profile.push_back(p);
    }
  }
  profile.emplace_back(kBarrelRadius, kBarrelRight - 3);
  profile.emplace_back(kBarrelRadius - 3, kBarrelRight);
  return AlongX(Revolved(profile, SidesAt(fineness, 96)));
}

/// Returns a flange round the barrel with the ends of the tie rods: threads, nuts and washers,
/// towards -x.
TriangleMesh Flange(double fineness) {
  const Outline lobes = {{{0, 0}, kFlangeRadius},
                         {{kTieCircle, 0}, 8},
                         {{-kTieCircle, 0}, 8},
                         {{0, kTieCircle}, 8},
                         {{0, -kTieCircle}, 8}};
  PlateEdges edges;
  edges.outer_round = 3;
  edges.hole_round = 1;
  edges.sides = SidesAt(fineness, 96);
  TriangleMesh flange = Plate(lobes, {{{0, 0}, kBarrelRadius + kSeam}}, 0, kFlangeThickness, edges);
  for (int k = 0; k < 4; ++k) {
    const double angle = 0.5 * std::numbers::pi * k;
    const Vec3 at(kTieCircle * std::cos(angle), kTieCircle * std::sin(angle), 0);
    TriangleMesh end =
        Moved(Rotated(HexHead(10, 7), RotationBy(Vec3(std::numbers::pi, 0, 0))), {0, 0, -kSeam});
    Append(end, Moved(ThreadedEnd(0.9 * kTieRadius, 1.5, 8, 16), {0, 0, -7 - 2 * kSeam}));
    Append(flange, Moved(end, at));
  }
  return AlongX(flange);
}

TriangleMesh RodEnd(double fineness) {
  // rod, thread, and the eye with its ball
  TriangleMesh end = AlongX(Revolved({{kRodRadius, kBarrelRight + kSeam},
                                      {kRodRadius, 130},
                                      {kRodRadius, 270},
                                      {kRodRadius - 2, 272}},
                                     SidesAt(fineness, 72)));
  Append(end, Moved(Rotated(ThreadedEnd(kRodRadius, 4, 60, 32),
                            RotationBy(Vec3(0, -0.5 * std::numbers::pi, 0))),
                    {272 + kSeam, 0, 0}));
  const double shank = 332 + 2 * kSeam;
  Append(end, AlongX(Revolved({{20, shank},
                               {22, shank + 2},
                               {22, kEyeCentre - kEyeRadius - 2},
                               {20, kEyeCentre - kEyeRadius - kSeam}},
                              SidesAt(fineness, 72))));
  TriangleMesh eye = Tube(27, kEyeRadius, -18, 18, SidesAt(fineness, 96));
  std::vector<Vec2> ball = {{13, -22}, {13, 22}};
  for (int i = 0; i <= 12; ++i) {
    const double z = 15.0 - 2.5 * i;
    ball.emplace_back(std::sqrt(26.5 * 26.5 - z * z), z);
  }
  Append(eye, RevolvedRing(ball, SidesAt(fineness, 80)));
  Append(end, Moved(AlongY(eye), {kEyeCentre, 0, 0}));
  return end;
}

TriangleMesh Clevis(double fineness) {
  TriangleMesh clevis;
  const double root = kBarrelLeft - kSeam - kClevisPin;
  const Outline cheek = {{{0, 0}, 30}, {{root - 2, 28}, 2}, {{root - 2, -28}, 2}};
  PlateEdges edges;
  edges.outer_round = 2;
  edges.hole_round = 1;
  edges.sides = SidesAt(fineness, 96);
  for (const double start : {-32.0, 14.0}) {
    // the plate's x stays, its z becomes y
    const TriangleMesh plate = Plate(cheek, {{{0, 0}, 12 + kSeam}}, start, start + 18, edges);
    Append(clevis, Rotated(plate, RotationBy(Vec3(0.5 * std::numbers::pi, 0, 0))));
  }
  Append(clevis,
         AlongY(Revolved({{10, -38}, {12, -36}, {12, 36}, {10, 38}}, SidesAt(fineness, 56))));
  return Moved(clevis, {kClevisPin, 0, 0});
}

/// Returns a block with bolts that stands on the upper tie rod, and a hydraulic port on either
/// side.
TriangleMesh Valves(double fineness) {
  const double middle = 0.5 * (kValvesLeft + kValvesRight);
  TriangleMesh valves = Box({kValvesLeft, -kValvesHalf, kTieCircle + kTieRadius + kSeam},
                            {kValvesRight, kValvesHalf, kValvesTop});
  for (const double x : {kValvesLeft + 15, kValvesRight - 15}) {
    for (const double y : {-14.0, 14.0}) {
      Append(valves, Moved(BoltCircle(1, 0, 13), {x, y, kValvesTop + kSeam}));
    }
  }
  const TriangleMesh port =
      Revolved({{10, kValvesHalf + kSeam}, {10, kPortEnd}}, SidesAt(fineness, 96));
  for (const double side : {-1.0, 1.0}) {
    const Quat aside = RotationBy(Vec3(-side * 0.5 * std::numbers::pi, 0, 0));
    Append(valves, Moved(Rotated(port, aside), {middle + side * 22, 0, 84}));
  }
  return valves;
}

/// Adds the hoses of a side, `aside` from the middle plane.
void AddHoses(double side, double aside, TriangleMesh& nest) {
  for (int k = 0; k < 3; ++k) {
    std::vector<Vec3> points;
    for (int i = 0; i <= 8; ++i) {
      points.emplace_back(140.0 * i - 560, side * (aside + 4 * ((i + k) % 3)),
                          -70.0 + 70 * k + 8 * ((i + 2 * k) % 4));
    }
    Append(nest, Hose(points, 11, 0.6, 32, 28));
  }
}

/// Adds the saddles under the racks: a V whose sides touch their backs.
void AddSaddles(TriangleMesh& nest) {
  const double back = kFinRadius + kCradleClearance + kRackDepth + kSeam;
  const double inner = kWall - kSeam;
  const double top = (inner * std::sin(kCradleAngle) - back) / std::cos(kCradleAngle);
  const TriangleMesh saddle = AlongX(Prism({{-inner, kBase},
                                            {inner, kBase},
                                            {inner, top},
                                            {0, -back / std::cos(kCradleAngle)},
                                            {-inner, top}},
                                           0, 16));
  for (int k = 0; k < 7; ++k) Append(nest, Moved(saddle, {-430.0 + 134 * k, 0, 0}));
}

}  // namespace

TriangleMesh ClutterActuator(const ActuatorShape& shape) {
  const double fineness = shape.fineness;
  TriangleMesh actuator = Barrel(fineness);
  Append(actuator, Moved(Flange(fineness), {kBarrelLeft + 6, 0, 0}));
  Append(actuator, Moved(Rotated(Flange(fineness), RotationBy(Vec3(0, 0, std::numbers::pi))),
                         {kBarrelRight - 6, 0, 0}));
  const double left = kBarrelLeft + 6 + kFlangeThickness + kSeam;
  const double right = kBarrelRight - 6 - kFlangeThickness - kSeam;
  for (int k = 0; k < 4; ++k) {
    const double angle = 0.5 * std::numbers::pi * k;
    Append(actuator,
           Moved(AlongX(Revolved(
                     {{kTieRadius, left}, {kTieRadius, 0.5 * (left + right)}, {kTieRadius, right}},
                     SidesAt(fineness, 40))),
                 {0, kTieCircle * std::cos(angle), kTieCircle * std::sin(angle)}));
  }
  Append(actuator, RodEnd(fineness));
  Append(actuator, Clevis(fineness));
  if (shape.valves) Append(actuator, Valves(fineness));
  return actuator;
}

TriangleMesh ClutterNest(const NestShape& shape) {
  TriangleMesh nest;
  const double hoses = shape.clear_walls ? 130 : 108;  // distance from the middle plane
  RackShape rack;
  rack.length = 880;
  rack.width = 26;
  rack.depth = kRackDepth;
  rack.tooth_pitch = 10;
  const TriangleMesh cradle = Moved(Rack(rack), {-20, 0, -kFinRadius - kCradleClearance});
  RackShape guide = rack;
  guide.width = 10;
  guide.depth = kWall - kFlangeRadius - kGuideClearance - kSeam;
  HoleGrid grid;
  grid.columns = 26;
  grid.rows = 5;
  grid.pitch = 42;
  grid.hole_radius = 14;
  grid.steps_per_side = 5;
  const TriangleMesh plate = PerforatedPlate(grid);
  grid.rows = 4;
  Append(nest, Moved(PerforatedPlate(grid), {0, 0, kBase - kSeam - grid.thickness}));
  for (const double side : {-1.0, 1.0}) {
    Append(nest, AboutX(cradle, side * kCradleAngle));
    // walls, standing; their holes' grid has its corners at z = -19 and 23
    Append(nest, Moved(AboutX(plate, side * 0.5 * std::numbers::pi),
                       {0, side * (kWall + grid.thickness), -40}));
    for (const double z : {-32.0, 46.0}) {
      if (shape.clear_walls && z > 0) continue;
      const TriangleMesh turned =
          AboutX(Rack(guide), side * 0.5 * std::numbers::pi);  // teeth to -side y
      Append(nest, Moved(turned, {0, side * (kFlangeRadius + kGuideClearance), z}));
    }
    for (int k = -5; k <= 5 && !shape.clear_walls; ++k) {
      const TriangleMesh bolt = AboutX(BoltCircle(1, 0, 13), side * 0.5 * std::numbers::pi);
      Append(nest, Moved(bolt, {84.0 * k, side * (kWall - kSeam), 23}));
    }
    // stops at the ends
    const double from = side < 0 ? shape.rear_stop : 475;
    Append(nest, AlongX(Tube(16, 40, from, from + 25, 72)));
    Append(nest, Box({from, -20, kBase}, {from + 25, 20, -40 - kSeam}));
    AddHoses(side, hoses, nest);
  }
  AddSaddles(nest);
  return nest;
}

}  // namespace tandem
