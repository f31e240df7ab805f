#include "scenes/generators/large/clutter_parts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "scenes/generators/large/machine_parts.h"

namespace tandem {
namespace {

Outline Rectangle(double half_x, double half_y) {
  return {{{half_x, half_y}, 0},
          {{-half_x, half_y}, 0},
          {{-half_x, -half_y}, 0},
          {{half_x, -half_y}, 0}};
}

TriangleMesh UpsideDown(const TriangleMesh& mesh) {
  return Rotated(mesh, RotationBy(Vec3(std::numbers::pi, 0, 0)));
}

TriangleMesh FlangedPipe(RandomSource& rng) {
  const double bore = rng.Uniform(22, 45);
  const double wall = rng.Uniform(4, 8);
  const double half = rng.Uniform(90, 130);
  const double rim = bore + wall + 26;
  constexpr double kFlange = 14;
  TriangleMesh part = Tube(bore, bore + wall, -half, half, 64);
  const int bolts = rng.Whole(6, 10);
  for (const double side : {-1.0, 1.0}) {
    TriangleMesh flange = Tube(bore + wall + kSeam, rim, 0, kFlange, 72);
    Append(flange, Moved(BoltCircle(bolts, bore + wall + 14, 11), {0, 0, kFlange + kSeam}));
    if (side > 0) flange = UpsideDown(flange);
    Append(part, Moved(flange, {0, 0, side * (half - 4)}));
  }
  return part;
}

TriangleMesh GearTrain(RandomSource& rng) {
  TriangleMesh part;
  double z = -70;
  const double shaft = rng.Uniform(9, 14);
  while (z < 60) {
    GearShape gear;
    gear.teeth = rng.Whole(18, 40);
    gear.module = rng.Uniform(60, 150) / gear.teeth;
    gear.bore = shaft + kSeam;
    gear.width = rng.Uniform(14, 30);
    Append(part, Moved(Gear(gear), {0, 0, z}));
    z += gear.width + rng.Uniform(16, 40);
  }
  Append(
      part,
      Revolved({{shaft - 2, -110}, {shaft, -108}, {shaft, 0}, {shaft, 118}, {shaft - 2, 120}}, 48));
  return part;
}

TriangleMesh RibbedHousing(RandomSource& rng) {
  const double x = rng.Uniform(50, 80);
  const double y = rng.Uniform(40, 60);
  const double z = rng.Uniform(25, 45);
  PlateEdges edges;
  edges.outer_round = 4;
  edges.hole_round = 2;
  edges.sides = 96;
  TriangleMesh part = Plate(Rectangle(x, y), {{{0, 0}, 0.6 * y}}, -z, z, edges);
  // cooling ribs on both long sides
  for (double at = -x + 8; at < x - 8; at += 9) {
    for (const double side : {-1.0, 1.0}) {
      const double root = y + kSeam;
      Append(part, Box({at, side < 0 ? -root - 14 : root, -z + 6},
                       {at + 3, side < 0 ? -root : root + 14, z - 6}));
    }
  }
  TriangleMesh lid = Tube(0.35 * y, 0.9 * y, 0, 10, 72);
  Append(lid, Moved(BoltCircle(8, 0.75 * y, 7), {0, 0, 10 + kSeam}));
  Append(part, Moved(lid, {0, 0, z + kSeam}));
  Append(part, Moved(UpsideDown(lid), {0, 0, -z - kSeam}));
  return part;
}

TriangleMesh CornerBracket(RandomSource& rng) {
  const double half = rng.Uniform(45, 58);
  const double reach = rng.Uniform(110, 130);
  constexpr double kThick = 9;
  PlateEdges edges;
  edges.outer_round = 2;
  edges.hole_round = 2;
  edges.sides = 96;
  const TriangleMesh leaf =
      Moved(Plate(Rectangle(0.5 * reach, half), {{{0, 0}, 0.5 * half}}, 0, kThick, edges),
            {0.5 * reach, 0, 0});
  TriangleMesh part = leaf;
  // the other leaf stands on the first one's end
  Append(part, Moved(Rotated(leaf, RotationBy(Vec3(0, -0.5 * std::numbers::pi, 0))),
                     {kThick, 0, kThick + kSeam}));
  for (const double side : {-0.85, 0.85}) {
    TriangleMesh gusset = Prism(
        {{0, 0}, {0.6 * reach, 0}, {0.6 * reach, 6}, {6, 0.6 * reach}, {0, 0.6 * reach}}, -3, 3);
    Append(part, Moved(Rotated(gusset, RotationBy(Vec3(0.5 * std::numbers::pi, 0, 0))),
                       {kThick + kSeam, side * half, kThick + kSeam}));
  }
  Append(part, Moved(BoltCircle(6, 0.5 * half + 9, 10), {0.5 * reach, 0, kThick + kSeam}));
  return Moved(part, {-0.4 * reach, 0, -0.4 * reach});
}

TriangleMesh PlateStack(RandomSource& rng) {
  HoleGrid grid;
  grid.columns = rng.Whole(3, 5);
  grid.rows = rng.Whole(3, 4);
  grid.pitch = rng.Uniform(36, 46);
  grid.hole_radius = rng.Uniform(0.25, 0.38) * grid.pitch;
  grid.thickness = rng.Uniform(4, 7);
  grid.steps_per_side = 5;
  const double gap = rng.Uniform(26, 40);
  TriangleMesh part;
  for (int level = 0; level < 2; ++level) {
    Append(part, Moved(PerforatedPlate(grid), {0, 0, level * (grid.thickness + gap)}));
  }
  // distance pieces between the plates, where there are no holes
  for (const double sx : {-1.0, 1.0}) {
    for (const double sy : {-1.0, 1.0}) {
      const double at_x = sx * (0.5 * grid.columns - 1) * grid.pitch;
      const double at_y = sy * (0.5 * grid.rows - 1) * grid.pitch;
      Append(part, Moved(Tube(2, 5, grid.thickness + kSeam, grid.thickness + gap - kSeam, 32),
                         {at_x, at_y, 0}));
    }
  }
  return part;
}

TriangleMesh SpringStrut(RandomSource& rng) {
  const double radius = rng.Uniform(26, 40);
  const double wire = rng.Uniform(4, 6);
  const int turns = rng.Whole(6, 9);
  const double pitch = rng.Uniform(18, 24);
  const double half = 0.5 * pitch * turns;
  TriangleMesh part = Moved(Spring(radius, wire, pitch, turns, 12), {0, 0, -half});
  const double rod = radius - wire - 8;
  const double end = half + wire + 2;
  Append(part, Revolved({{rod - 2, -end - 20},
                         {rod, -end - 18},
                         {rod, 0},
                         {rod - 4, 2},
                         {rod - 4, end + 18},
                         {rod - 6, end + 20}},
                        56));
  for (const double side : {-1.0, 1.0}) {
    TriangleMesh seat = Tube(rod + kSeam, radius + wire + 6, 0, 9, 64);
    if (side < 0) seat = UpsideDown(seat);
    Append(part, Moved(seat, {0, 0, side * end}));
  }
  return part;
}

TriangleMesh Cylinder(RandomSource& rng) {
  const double r = rng.Uniform(24, 38);
  std::vector<Vec2> profile = {{r - 3, -110}, {r, -107}};
  for (double z = -95; z < 20; z += rng.Uniform(10, 16)) {
    for (const Vec2& p : {Vec2(r, z), Vec2(r - 3, z + 1), Vec2(r - 3, z + 4), Vec2(r, z + 5)}) {
      profile.push_back(p);
    }
  }
  const double rod = 0.45 * r;
  for (const Vec2& p : {Vec2(r, 38), Vec2(r - 4, 42), Vec2(rod, 42), Vec2(rod, 110)}) {
    profile.push_back(p);
  }
  TriangleMesh part = Revolved(profile, 64);
  const double eye = rod + 8;
  Append(part, Moved(AlongY(Tube(0.5 * eye, eye, -12, 12, 56)), {0, 0, 110 + eye + kSeam}));
  return part;
}

TriangleMesh BoltAndNut(RandomSource& rng) {
  const double radius = rng.Uniform(10, 16);
  const double length = rng.Uniform(120, 180);
  TriangleMesh part = ThreadedEnd(radius, 0.3 * radius + 3, length, 20);
  const double flats = 3.1 * radius;
  Append(part, Moved(HexHead(flats, 1.3 * radius), {0, 0, kSeam}));
  for (int k = 0; k < 3; ++k) {
    const double z = -rng.Uniform(0.2, 0.28) * length * (k + 1);
    PlateEdges edges;
    edges.sides = 48;
    Append(part,
           Moved(Plate({{{0, 0}, 2.2 * radius}}, {{{0, 0}, radius + 1}}, 0, 3, edges), {0, 0, z}));
  }
  return Moved(part, {0, 0, 0.5 * length});
}

TriangleMesh BallBearing(RandomSource& rng) {
  const int balls = rng.Whole(9, 14);
  const double pitch = rng.Uniform(60, 85);
  const double ball = 0.36 * 2 * std::numbers::pi * pitch / balls;
  const double width = 1.2 * ball;
  TriangleMesh part = Tube(pitch - 2.0 * ball, pitch - ball - kSeam, -width, width, 80);
  Append(part, Tube(pitch + ball + kSeam, pitch + 2.0 * ball, -width, width, 80));
  const TriangleMesh sphere = OctahedralSphere(ball, 2, false);
  for (int k = 0; k < balls; ++k) {
    const double angle = 2 * std::numbers::pi * k / balls;
    Append(part, Moved(sphere, {pitch * std::cos(angle), pitch * std::sin(angle), 0}));
  }
  return part;
}

TriangleMesh Tank(RandomSource& rng) {
  const double radius = rng.Uniform(45, 65);
  TriangleMesh part = OctahedralSphere(radius, 4, false);
  const double neck = 0.3 * radius;
  const double top = std::sqrt(radius * radius - neck * neck) + 2;
  Append(part, Moved(Tube(neck - 5, neck, 0, 30, 48), {0, 0, top + 2}));
  Append(part, Moved(Tube(neck + kSeam, neck + 14, 14, 24, 48), {0, 0, top}));
  Append(part, Moved(BoltCircle(6, neck + 7, 6), {0, 0, top + 24 + kSeam}));
  // a strap round its waist
  Append(part, Tube(radius + kSeam, radius + 5, -9, 9, 80));
  return part;
}

TriangleMesh RackAndPinion(RandomSource& rng) {
  RackShape rack;
  rack.length = rng.Uniform(180, 230);
  rack.tooth_pitch = rng.Uniform(8, 11);
  rack.width = rng.Uniform(16, 26);
  TriangleMesh part = Rack(rack);
  GearShape pinion;
  pinion.teeth = rng.Whole(20, 30);
  pinion.module = rack.tooth_pitch / std::numbers::pi;
  pinion.width = rack.width;
  pinion.bore = 10;
  const double clear = 0.5 * pinion.module * pinion.teeth + 1.5 * pinion.module;
  Append(part, Moved(AlongY(Moved(Gear(pinion), {0, 0, -0.5 * rack.width})), {0, 0, clear}));
  Append(part, Moved(AlongY(Tube(5, 10 - kSeam, -40, 40, 40)), {0, 0, clear}));
  return part;
}

TriangleMesh HoseBundle(RandomSource& rng) {
  const double radius = rng.Uniform(7, 11);
  TriangleMesh part;
  for (const double side : {-1.5, -0.5, 0.5, 1.5}) {
    std::vector<Vec3> points;
    const double y = side * (2 * radius + 6);
    for (int k = 0; k <= 5; ++k) {
      points.push_back({45.0 * k - 112, y + rng.Uniform(-1.5, 1.5), rng.Uniform(-28, 28)});
    }
    Append(part, Hose(points, radius, rng.Uniform(0.3, 0.8), 14, 10));
  }
  return part;
}

}  // namespace

TriangleMesh PartByChance(RandomSource& rng) {
  constexpr std::array kMakers = {FlangedPipe, GearTrain,   RibbedHousing, CornerBracket,
                                  PlateStack,  SpringStrut, Cylinder,      BoltAndNut,
                                  BallBearing, Tank,        RackAndPinion, HoseBundle};
  return kMakers[static_cast<std::size_t>(rng.Whole(0, static_cast<int>(kMakers.size()) - 1))](rng);
}

TriangleMesh Beam(double length, double height, double width, RandomSource& rng) {
  const double h = 0.5 * height;
  const double w = 0.5 * width;
  const double flange = 0.1 * height;
  const double web = 0.06 * width;
  // extruded along z, which AlongX() turns to x
  TriangleMesh beam = AlongX(Prism({{-w, -h},
                                    {w, -h},
                                    {w, -h + flange},
                                    {web, -h + flange},
                                    {web, h - flange},
                                    {w, h - flange},
                                    {w, h},
                                    {-w, h},
                                    {-w, h - flange},
                                    {-web, h - flange},
                                    {-web, -h + flange},
                                    {-w, -h + flange}},
                                   0, length));
  const double bolt = 0.16 * width;
  const double pitch = rng.Uniform(60, 90);
  TriangleMesh pair;
  for (const double side : {-0.5, 0.5}) {
    Append(pair, Moved(BoltCircle(1, 0, bolt), {0, side * w, h + kSeam}));
  }
  for (double x = 0.5 * pitch; x < length - 0.4 * pitch; x += pitch) {
    Append(beam, Moved(pair, {x, 0, 0}));
    Append(beam, Moved(UpsideDown(pair), {x, 0, 0}));
    for (const double side : {-1.0, 1.0}) {
      const double inner = web + kSeam;
      Append(beam, Box({x - 3, side < 0 ? -w + 2 : inner, -h + flange + kSeam},
                       {x + 3, side < 0 ? -inner : w - 2, h - flange - kSeam}));
    }
  }
  return beam;
}

TriangleMesh PipeRun(const std::vector<Vec3>& points, double radius, RandomSource& rng) {
  TriangleMesh run = Hose(points, radius, 0, 36, 12);
  const int bolts = rng.Whole(6, 8);
  TriangleMesh flange = Tube(radius + 1, radius + 24, kSeam, 12, 48);
  Append(flange, Moved(BoltCircle(bolts, radius + 13, 10), {0, 0, 12 + kSeam}));
  TriangleMesh joint = flange;
  Append(joint, UpsideDown(flange));
  for (std::size_t k = 1; k + 1 < points.size(); k += 2) {
    const Vec3 before = points[k] - points[k - 1];
    const Vec3 after = points[k + 1] - points[k];
    // the curve is straight about a point whose two neighbours on either side are in line
    const bool straight = (before - after).norm() < 1e-6;
    if (!straight) continue;
    const Quat along = Quat::FromTwoVectors(Vec3(0, 0, 1), before.normalized());
    Append(run, Moved(Rotated(joint, along), points[k]));
  }
  return run;
}

}  // namespace tandem
