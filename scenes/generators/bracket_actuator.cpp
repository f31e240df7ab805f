#include <cmath>

#include "scenes/generators/generated_scene.h"
#include "scenes/generators/shapes.h"

// A rod-end actuator that stands in a bracket, held by a web with a slot, seen along y and from
// above:
//
//            (O)  eye                       y
//             |   rod                       |   +----------------------------------+
//     ~~~~~  [|]  ~~~~~  hoses              |   |             .--.                 |
//    ======   |   ======  web               |   |             |  |  ear            |
//      |   [=====]  |    collar with ears   |   |   .---------|--|---------.       |
//      |      |     |                       |   |  (          |()|          ) slot |
//      |     [|]    |    barrel, clevis     |   |   '---------|--|---------'       |
//    ==================  base               |   |             |  |                 |
//                                           |   |             '--'   web           |
//    The collar's ears lie across the       |   +----------------------------------+
//    slot. The only way out is to turn the  +------------------------------------------ x
//    actuator a quarter turn about its own axis, so that they lie along it, and then to slide it
//    up.
//
// The hand's intent is to go up before the ears have come round (through the web, along which the
// ears slide meanwhile). Then it is up and to one side (through the slot's wall, along which the
// barrel slides). Nothing there can trap the part: all contact is frictionless, and during contact
// the hand's next aim is always farther along the free way. Flat faces that guide lie half way
// between the planes of a 1 mm grid, so that rounding never moves one to another voxel.
namespace tandem {
namespace {

// mm
constexpr double kLength = 699;
constexpr double kWidth = 219;
constexpr double kBaseBottom = 0.5;
constexpr double kBaseTop = 12.5;
constexpr double kSeam = 0.3;  // gap between bodies that touch
constexpr double kWebBottom = 138.5;
constexpr double kWebTop = 150.5;
constexpr double kWebHalfX = 112.5;
constexpr double kWebHalfY = 97.5;
constexpr double kWall = 12;
constexpr double kSlotHalfLength = 45;
constexpr double kSlotHalfWidth = 22;

constexpr double kBarrelRadius = 13;
constexpr double kBarrelBottom = 46.5;
constexpr double kShoulder = 152.5;
constexpr double kRodRadius = 6;
constexpr double kCollarBottom = 118.5;
constexpr double kCollarTop = 130.5;  // 8 mm below the web
constexpr double kCollarHalfWidth = 16;
constexpr double kEarReach = 38;
constexpr double kEarRadius = 8;
constexpr double kEyeRadius = 15;
constexpr double kEyeCentre = 221;
constexpr double kClevisPin = 32.5;
constexpr double kClevisRadius = 12.5;

constexpr double kPressUp = 21;     // 13 mm farther than the web allows
constexpr double kPressAside = 15;  // 6 mm farther than the slot allows the barrel
constexpr double kActuatorTravel =
    190;  // up; the hoses end 152 mm above the actuator's lowest point

struct Assembly {
  TriangleMesh mesh;
  void Add(const TriangleMesh& part) { Append(mesh, part); }
};

TriangleMesh Bracket() {
  Assembly bracket;
  const double x = 0.5 * kLength;
  const double y = 0.5 * kWidth;
  bracket.Add(Box({-x, -y, kBaseBottom}, {x, y, kBaseTop}));

  // the web, and its supports
  const Outline web = {{{kWebHalfX, kWebHalfY}, 0},
                       {{-kWebHalfX, kWebHalfY}, 0},
                       {{-kWebHalfX, -kWebHalfY}, 0},
                       {{kWebHalfX, -kWebHalfY}, 0}};
  const double slot_end = kSlotHalfLength - kSlotHalfWidth;
  const Outline slot = {{{-slot_end, 0}, kSlotHalfWidth}, {{slot_end, 0}, kSlotHalfWidth}};
  PlateEdges edges;
  edges.outer_round = 1.5;
  edges.hole_round = 3;
  bracket.Add(Plate(web, slot, kWebBottom, kWebTop, edges));
  for (const double side : {-1.0, 1.0}) {
    const double inner = kWebHalfX - kWall;
    bracket.Add(Box({side < 0 ? -kWebHalfX : inner, -kWebHalfY, kBaseTop + kSeam},
                    {side < 0 ? -inner : kWebHalfX, kWebHalfY, kWebBottom - kSeam}));
    // ribs under the web, outside the ears' sweep
    const double rib = 76;
    bracket.Add(Box({-inner + kSeam, side < 0 ? -rib - 8 : rib, kWebBottom - 22},
                    {inner - kSeam, side < 0 ? -rib : rib + 8, kWebBottom - kSeam}));
    // rails along the base
    bracket.Add(Box({-x, side < 0 ? -y : y - 11, kBaseTop + kSeam},
                    {x, side < 0 ? -y + 11 : y, kBaseTop + 32}));
    // gussets against the walls, from outside
    for (const double at : {-45.0, 45.0}) {
      const double root = kWebHalfX + kSeam;
      TriangleMesh gusset = Prism({{root, kBaseTop + kSeam},
                                   {root + 90, kBaseTop + kSeam},
                                   {root + 90, kBaseTop + 10},
                                   {root + 12, kWebBottom - 14},
                                   {root, kWebBottom - 14}},
                                  -4, 4);
      for (Vec3& v : gusset.vertices) v = Vec3(side * v.x(), at - side * v.z(), v.y());
      bracket.Add(gusset);
    }
    // bearing lugs at both ends
    const Outline lug = {{{0, 0}, 28}, {{-44, -52}, 0}, {{44, -52}, 0}};
    PlateEdges lug_edges;
    lug_edges.hole_round = 2;
    bracket.Add(Moved(AlongX(Plate(lug, {{{0, 0}, 15}}, -9, 9, lug_edges)),
                      {side * 318, 0, kBaseTop + kSeam + 52}));
  }
  return bracket.mesh;
}

TriangleMesh Hoses() {
  constexpr double kRadius = 7;
  constexpr double kRipple = 0.5;
  Assembly hoses;
  for (const double side : {-1.0, 1.0}) {
    // over the web, on both sides of the slot
    const double y = side * 66;
    hoses.Add(Hose({{-296, y, 34},
                    {-235, y, 42},
                    {-165, y, 112},
                    {-108, y - side * 3, 161},
                    {0, y - side * 5, 159.5},
                    {108, y - side * 2, 161},
                    {165, y + side * 2, 112},
                    {235, y, 42},
                    {296, y, 34}},
                   kRadius, kRipple, 24, 36));
  }
  // in the bay below the web, round the actuator
  hoses.Add(Hose({{-92, 60, 30},
                  {-70, 62, 66},
                  {-20, 60, 78},
                  {30, 62, 62},
                  {66, 58, 40},
                  {76, 10, 34},
                  {72, -40, 46},
                  {40, -62, 70},
                  {-30, -60, 84},
                  {-86, -62, 60}},
                 kRadius, kRipple, 24, 28));
  return hoses.mesh;
}

TriangleMesh Bolts() {
  constexpr double kAcrossFlats = 13;
  constexpr double kHead = 8;
  constexpr double kWasher = 1.6;
  Assembly bolts;
  PlateEdges washer;
  washer.sides = 48;
  const auto bolt = [&](double x, double y, double z) {
    bolts.Add(Moved(Plate({{{0, 0}, 9}}, {{{0, 0}, 4.3}}, 0, kWasher, washer), {x, y, z + kSeam}));
    bolts.Add(Moved(HexHead(kAcrossFlats, kHead), {x, y, z + kWasher + 2 * kSeam}));
  };
  const auto end = [&](double x, double y, double z) {
    bolts.Add(Moved(ThreadedEnd(4, 1.25, 13, 24), {x, y, z - kSeam}));
  };
  for (const double side : {-1.0, 1.0}) {
    for (const double y : {-82.0, -40.0, 0.0, 40.0, 82.0}) {
      bolt(side * (kWebHalfX - 6), y < 0 ? y - 5 : y > 0 ? y + 5 : y, kWebTop);
    }
    for (const double y : {-84.0, 84.0}) {
      for (const double x : {332.0, 262.0, 212.0}) {
        bolt(side * x, y, kBaseTop);
        end(side * x, y, kBaseBottom);
      }
    }
  }
  return bolts.mesh;
}

/// Adds the barrel with grooves, the shoulder, the rod and the rod end's shank.
void AddBarrel(Assembly& actuator) {
  actuator.Add(Revolved({{11.5, kBarrelBottom},
                         {kBarrelRadius, kBarrelBottom + 1.5},
                         {kBarrelRadius, 58},
                         {12.2, 58.8},
                         {12.2, 61.2},
                         {kBarrelRadius, 62},
                         {kBarrelRadius, 80},
                         {kBarrelRadius, 100},
                         {12.2, 100.8},
                         {12.2, 103.2},
                         {kBarrelRadius, 104},
                         {kBarrelRadius, 118},
                         {kBarrelRadius, 132},
                         {kBarrelRadius, kShoulder - 2},
                         {11, kShoulder},
                         {9, kShoulder},
                         {8.5, kShoulder + 1.5},
                         {kRodRadius, kShoulder + 1.5},
                         {kRodRadius, 170},
                         {kRodRadius, 192},
                         {8, 194},
                         {8, 200},
                         {6.5, kEyeCentre - kEyeRadius - kSeam}},
                        72));
}

/// Adds the collar, whose ears point along y, across the slot.
void AddCollar(Assembly& actuator) {
  const double ear = kEarReach - kEarRadius;
  PlateEdges edges;
  edges.outer_round = 3;
  actuator.Add(Plate({{{0, 0}, kCollarHalfWidth}, {{0, ear}, kEarRadius}, {{0, -ear}, kEarRadius}},
                     {{{0, 0}, kBarrelRadius + kSeam}}, kCollarBottom, kCollarTop, edges));
}

/// Adds the rod end's eye and the ball in it.
void AddRodEnd(Assembly& actuator) {
  const double eye = kEyeRadius;
  actuator.Add(Moved(AlongY(RevolvedRing({{eye - 1, 7},
                                          {eye, 6},
                                          {eye, 0},
                                          {eye, -6},
                                          {eye - 1, -7},
                                          {10.3, -7},
                                          {9.3, -6},
                                          {9.3, 6},
                                          {10.3, 7}},
                                         72)),
                     {0, 0, kEyeCentre}));
  std::vector<Vec2> ball = {{5, -6}, {5, 6}};
  for (int i = 0; i <= 8; ++i) {
    const double z = 6.0 - 1.5 * i;
    ball.emplace_back(std::sqrt(81 - z * z), z);
  }
  actuator.Add(Moved(AlongY(RevolvedRing(ball, 60)), {0, 0, kEyeCentre}));
}

/// Adds the clevis: two cheeks and their pin.
void AddClevis(Assembly& actuator) {
  const double corner = kBarrelBottom - kSeam - kClevisPin - 1.5;
  const Outline cheek = {{{0, 0}, kClevisRadius}, {{-11, corner}, 1.5}, {{11, corner}, 1.5}};
  PlateEdges cheek_edges;
  cheek_edges.outer_round = 1;
  cheek_edges.arc_steps = 2;
  cheek_edges.sides = 64;
  for (const double start : {-12.0, 4.0}) {
    actuator.Add(Moved(AlongX(Plate(cheek, {{{0, 0}, 5 + kSeam}}, start, start + 8, cheek_edges)),
                       {0, 0, kClevisPin}));
  }
  actuator.Add(Moved(AlongX(Revolved({{4.5, -13.5}, {5, -13}, {5, 13}, {4.5, 13.5}}, 48)),
                     {0, 0, kClevisPin}));
}

TriangleMesh Actuator() {
  Assembly actuator;
  AddBarrel(actuator);
  AddCollar(actuator);
  AddRodEnd(actuator);
  AddClevis(actuator);
  return actuator.mesh;
}

HandScript ActuatorHand() {
  constexpr double kMm = 1e-3;
  const Quat quarter = RotationBy(Vec3(0, 0, 0.5 * 3.14159265358979323846));
  HandScript script;
  script.impedance.damping = 12;
  script.X_BD.p = {0, 0, 0.095};
  script.waypoints = {
      {0.0, {0, 0, 0}, Quat::Identity()},
      {1.2, {0, 0, kMm * kPressUp}, Quat::Identity()},                // up into the web
      {4.6, {0, 0, kMm * (kPressUp + 4)}, quarter},                   // turn, still pressing
      {5.8, {0, kMm * kPressAside, kMm * (kPressUp + 40)}, quarter},  // up the slot, and aside
      {8.4, {0, kMm * kPressAside, kMm * kActuatorTravel}, quarter},
  };
  return script;
}

}  // namespace

GeneratedScene BracketActuator() {
  const HandScript top = ActuatorHand();
  Pose bottom_grasp;
  bottom_grasp.p = {0, 0, -0.055};
  const HandScript bottom = SecondHand(top, 1.06, {0, 0.002, 0.002}, bottom_grasp);
  return {"bracket_actuator",
          {{"bracket_actuator_bracket.stl", Bracket()},
           {"bracket_actuator_hoses.stl", Hoses()},
           {"bracket_actuator_bolts.stl", Bolts()},
           {"bracket_actuator_actuator.stl", Actuator()}},
          {{"bracket_actuator_top.json", top}, {"bracket_actuator_bottom.json", bottom}}};
}

}  // namespace tandem
