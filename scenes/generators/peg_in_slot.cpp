#include "scenes/generators/generated_scene.h"
#include "scenes/generators/shapes.h"

// A block with a slot that turns a corner, and a peg in the slot's far end, seen along y:
//
//    z                          The peg has to go right, under the tooth, and then up. The hand
//    |  +-----------+     +--+  means to go up too early, through the tooth (which holds the peg
//    |  |   tooth   |  ^  |  |  down until it has come past), and then up too far to the right,
//    |  |           \  |  |  |  through the wall.
//    |  | +----------+ |  |  |
//    |  | | []  ------>   |  |  Faces lie half way between the planes of a 1 mm grid, so that
//    |  | +---------------+  |  rounding never moves one to another voxel.
//    |  +--------------------+
//    +---------------------------x
namespace tandem {
namespace {

// mm
constexpr double kOutside = 0.5;
constexpr double kRight = 100.5;
constexpr double kTop = 70.5;
constexpr double kDepth = 40;  // along y
constexpr double kPocketLeft = 10.5;
constexpr double kPocketRight = 89.5;
constexpr double kPocketFloor = 10.5;
constexpr double kToothUnderside = 42.5;
constexpr double kToothSide = 54.5;
constexpr double kChamfer = 6;
constexpr double kPegHalf = 9;  // along x and z
constexpr double kPegHalfDepth = 15;
constexpr double kPegRound = 1;
constexpr double kPegX = 26.5;  // its first centre: 7 mm of clearance left, above and below
constexpr double kPegZ = 26.5;

constexpr double kPegTravel = 100;  // up: 46 mm are needed to leave the block's box

TriangleMesh Block() {
  const std::vector<Vec2> section = {{kOutside, kOutside},
                                     {kRight, kOutside},
                                     {kRight, kTop},
                                     {kPocketRight, kTop},
                                     {kPocketRight, kPocketFloor},
                                     {kPocketLeft, kPocketFloor},
                                     {kPocketLeft, kToothUnderside},
                                     {kToothSide - kChamfer, kToothUnderside},
                                     {kToothSide, kToothUnderside + kChamfer},
                                     {kToothSide, kTop},
                                     {kOutside, kTop}};
  // drawn in (x, z), so the sheet's normal is -y
  TriangleMesh block = Prism(section, -0.5 * kDepth, 0.5 * kDepth);
  for (Vec3& v : block.vertices) v = Vec3(v.x(), -v.z(), v.y());
  return block;
}

TriangleMesh Peg() {
  const double c = kPegHalf - kPegRound;
  const std::vector<Vec2> section = {{-c, -kPegHalf}, {c, -kPegHalf}, {kPegHalf, -c},
                                     {kPegHalf, c},   {c, kPegHalf},  {-c, kPegHalf},
                                     {-kPegHalf, c},  {-kPegHalf, -c}};
  TriangleMesh peg = Prism(section, -kPegHalfDepth, kPegHalfDepth);
  for (Vec3& v : peg.vertices) v = Vec3(kPegX + v.x(), -v.z(), kPegZ + v.y());
  return peg;
}

HandScript PegHand() {
  HandScript script;
  script.impedance.damping = 12;
  script.X_BD.p = {0.004, 0.010, 0.004};
  script.waypoints = {
      {0.0, {0, 0, 0}, Quat::Identity()},
      {2.0, {0.014, 0, 0.020}, Quat::Identity()},  // up into the tooth
      {5.0, {0.060, 0, 0.026}, Quat::Identity()},  // along it, and into the wall beyond
      {7.8, {0.060, 0, 1e-3 * kPegTravel}, Quat::Identity()},
  };
  return script;
}

}  // namespace

GeneratedScene PegInSlot() {
  const HandScript left = PegHand();
  Pose right_grasp;
  right_grasp.p = {-0.004, -0.010, 0.004};
  const HandScript right = SecondHand(left, 1.06, {0, 0, 0.003}, right_grasp);
  return {"peg_in_slot",
          {{"peg_in_slot_block.stl", Block()}, {"peg_in_slot_peg.stl", Peg()}},
          {{"peg_in_slot_left.json", left}, {"peg_in_slot_right.json", right}}};
}

}  // namespace tandem
