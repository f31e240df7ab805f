#include "scenes/generators/large/landing_gear.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "scenes/generators/large/clutter.h"
#include "scenes/generators/large/clutter_parts.h"
#include "scenes/generators/large/landing_gear_parts.h"
#include "scenes/generators/large/machine_parts.h"
#include "scenes/generators/large/random_source.h"

// Seen from the side; heights over the ground in mm:
//
//   4800 ====================================  beams of the bay
//        |   trunnion (o)                   |
//        |      \    | |       line o       |   the actuator goes out here,
//        |  brace \  | | strut      line o ---> between the two lines
//   2900 |          \| |  [==actuator==]    |
//        |           | |                    |  doors, equipment on both sides
//   1400 |           |_|/\ torque links     |
//              ___   |_|   ___
//    625      /   \==|o|==/   \                bogie, axles, wheels
//      0      \___/       \___/
namespace tandem {
namespace {

constexpr double kPi = std::numbers::pi;
const Vec3 kNest(1000, 0, 2900);  // the actuator over the ground, under the strut's axis

constexpr double kRearStop = -570;  // from the actuator's middle
constexpr double kKeeper = 64;      // its underside, over the actuator's axis

constexpr double kPorts = -195;  // x of the middle between them
constexpr double kHook = 110;    // underside of the hook that holds them down
constexpr double kWallTop = 65;

constexpr double kAxleHeight = 625;
constexpr double kWheelBase = 1300;
constexpr double kWheelMiddle = 620;  // from the middle plane
constexpr double kAxleRadius = 70;
constexpr double kBossRadius = 170;
constexpr double kPistonRadius = 160;
constexpr double kFittingBore = 165;
constexpr double kFittingRadius = 200;
constexpr double kTrunnionHeight = 4150;
constexpr double kDoorBottom = 1400;
constexpr double kDoorTop = 4500;
constexpr double kDoorSkin = 880;  // distance from the middle plane to the inner skin's inner face
constexpr double kSkinThickness = 4;
constexpr double kBayHalfLength = 2050;
constexpr double kEquipment = 675;  // distance of the equipment's middle from the middle plane
constexpr double kEquipmentCell = 310;

/// Returns the mesh moved to stand on `from` with its z axis towards `to`.
TriangleMesh Towards(const TriangleMesh& mesh, const Vec3& from, const Vec3& to) {
  const Quat along = Quat::FromTwoVectors(Vec3::UnitZ(), (to - from).normalized());
  return Moved(Rotated(mesh, along), from);
}

class Builder {
 public:
  std::vector<TriangleMesh> Make(LandingGearParts parts) {
    AddNest();
    if (parts == LandingGearParts::kNest) {
      AddLinesAcross();
      return std::move(parts_);
    }
    AddBogie();
    AddStrut();
    AddBraces();
    AddDoors();
    AddBay();
    AddLines();
    AddBundles();
    AddEquipment();
    return std::move(parts_);
  }

 private:
  /// Adds a part. Places of `mesh` are over the ground.
  void Add(const TriangleMesh& mesh) { parts_.push_back(Moved(mesh, -kNest)); }

  void AddNest() {
    parts_.push_back(ClutterNest({.rear_stop = kRearStop, .clear_walls = true}));
    // the keeper over the rod's eye, on a post that stands on the forward stop
    parts_.push_back(Box({475, -15, 40 + kSeam}, {500, 15, kKeeper - kSeam}));
    parts_.push_back(Box({380, -15, kKeeper}, {500, 15, kKeeper + 17}));
    // a hook over each port of the valves, on a post that stands on the wall
    for (const double side : {-1.0, 1.0}) {
      const double port = kPorts + 22 * side;
      const auto beside = [side](double x, double y, double z) {
        return Vec3(x, side * y, z);
      };
      Bounds hook;
      hook.Add(beside(port - 12, 78, kHook));
      hook.Add(beside(port + 30, 98, kHook + 8));
      parts_.push_back(Box(hook.min, hook.max));
      Bounds post;
      post.Add(beside(port + 20, 80, kWallTop + kSeam));
      post.Add(beside(port + 30, 86, kHook - kSeam));
      parts_.push_back(Box(post.min, post.max));
    }
  }

  void AddBogie() {
    const TriangleMesh wheel = AlongY(BrakedWheel(kAxleRadius));
    const TriangleMesh other = Rotated(wheel, RotationBy(Vec3(0, 0, kPi)));
    for (const double x : {-kWheelBase, 0.0, kWheelBase}) {
      const Vec3 middle(x, 0, kAxleHeight);
      // brakes inwards
      Add(Moved(other, middle + Vec3(0, kWheelMiddle, 0)));
      Add(Moved(wheel, middle - Vec3(0, kWheelMiddle, 0)));
      TriangleMesh axle = AlongY(Tube(48, kAxleRadius, -902, 902, 96));
      for (const double side : {-1.0, 1.0}) {
        Append(axle,
               Moved(Rotated(AlongY(HexHead(120, 44)), RotationBy(Vec3(0, 0, side > 0 ? 0 : kPi))),
                     {0, side * (902 + kSeam), 0}));
      }
      Add(Moved(axle, middle));
      Add(Moved(AlongY(Tube(kAxleRadius + kSeam, kBossRadius, -130, 130, 96)), middle));
    }
    for (const double from : {-kWheelBase, 0.0}) {
      Add(Moved(AlongX(Tube(100, 125, kBossRadius + kSeam, kWheelBase - kBossRadius - kSeam, 96)),
                {from, 0, kAxleHeight}));
    }
  }

  void AddStrut() {
    const double foot = kAxleHeight + kBossRadius + kSeam;
    Add(Moved(Tube(130, kPistonRadius, foot, 3600, 160), {0, 0, 0}));
    Add(Tube(kFittingBore, kFittingRadius, 1750, 4700, 160));
    Add(Tube(90, 122, foot + 40, 3500, 128));
    Add(Tube(52, 84, foot + 80, 4300, 96));
    Add(Tube(20, 46, foot + 120, 4500, 64));
    // the gland, with bolts, and rings along the fitting
    for (double z = 1770; z < 4000; z += 420) {
      TriangleMesh ring = Tube(kFittingRadius + kSeam, kFittingRadius + 45, z, z + 50, 128);
      Append(ring, Moved(BoltCircle(24, kFittingRadius + 24, 16), {0, 0, z + 50 + kSeam}));
      Add(ring);
    }
    // torque links, two plates a side, forward of the strut
    PlateEdges edges;
    edges.outer_round = 4;
    edges.hole_round = 2;
    const Vec3 knee(520, 0, 1280);
    for (const Vec3& root : {Vec3(270, 0, 1690), Vec3(270, 0, 870)}) {
      const Vec3 way = knee - root;
      const Outline outline = {{{0, 0}, 52}, {{way.norm(), 0}, 52}};
      const double turn = -std::atan2(way.z(), way.x());
      for (const double y : {-90.0, -20.0, 40.0, 110.0}) {
        const bool lower = root.z() < knee.z();
        const TriangleMesh plate = Rotated(Plate(outline, {{{0, 0}, 24}}, 0, 22, edges),
                                           RotationBy(Vec3(0.5 * kPi, 0, 0)));
        Add(Moved(Rotated(plate, RotationBy(Vec3(0, turn, 0))),
                  root + Vec3(0, y + (lower ? 30 : 0), 0)));
      }
    }
  }

  void AddBraces() {
    for (const double side : {-1.0, 1.0}) {
      const Vec3 top(-1700, side * 310, 4200);
      const Vec3 foot(-330, side * 310, 1950);
      Add(Towards(BraceLink((top - foot).norm(), 62, 80), foot, top));
      const Vec3 lock(-330, side * 310, 3900);
      const Vec3 knee(-850, side * 170, 2500);
      Add(Towards(BraceLink((lock - knee).norm(), 30, 45), knee, lock));
      // trunnion
      Add(Moved(AlongY(Tube(70, 108, 250, 860, 120)),
                {0, side > 0 ? 0.0 : -1110.0, kTrunnionHeight}));
    }
  }

  void AddDoors() {
    HoleGrid grid;
    grid.columns = 31;
    grid.rows = 24;
    grid.pitch = 130;
    grid.hole_radius = 56;
    grid.thickness = kSkinThickness;
    grid.steps_per_side = 6;
    // standing: the grid's y is the door's height
    const TriangleMesh skin = Rotated(PerforatedPlate(grid), RotationBy(Vec3(0.5 * kPi, 0, 0)));
    const double middle = 0.5 * (kDoorBottom + kDoorTop);
    TriangleMesh bolt = BoltCircle(1, 0, 10);
    for (const double side : {-1.0, 1.0}) {
      const double inner = kDoorSkin;
      const double outer = kDoorSkin + 52;
      for (const double face : {inner, outer}) {
        const double at = side > 0 ? face + kSkinThickness : -face;
        Add(Moved(skin, {0, at, middle}));
      }
      // ribs between the skins, where there are no holes
      const double from = inner + kSkinThickness + kSeam;
      const double to = outer - kSeam;
      for (int k = -8; k <= 7; ++k) {
        const double x = grid.pitch * (2 * k + 0.5);
        Add(Box({x - 3, side > 0 ? from : -to, kDoorBottom},
                {x + 3, side > 0 ? to : -from, kDoorTop}));
      }
      const Quat inward = RotationBy(Vec3(side * 0.5 * kPi, 0, 0));
      TriangleMesh bolts;
      for (int k = -15; k <= 14; ++k) {
        for (int i = 1; i < grid.rows; ++i) {
          Append(bolts,
                 Moved(Rotated(bolt, inward), {grid.pitch * (k + 0.5), side * (inner - kSeam),
                                               middle + grid.pitch * (i - 0.5 * grid.rows)}));
        }
      }
      Add(bolts);
    }
  }

  void AddBay() {
    for (int k = -3; k <= 3; ++k) {
      const TriangleMesh beam = Beam(2 * kBayHalfLength, 70, 80, rng_);
      Add(Moved(beam, {-kBayHalfLength, 260.0 * k, 4620}));
    }
    for (int k = -4; k <= 4; ++k) {
      const TriangleMesh beam = AlongX(Beam(1800, 80, 70, rng_));  // x to y
      Add(Moved(beam, {450.0 * k, -900, 4754}));
    }
  }

  void AddLines() {
    for (const double side : {-1.0, 1.0}) {
      for (int k = -9; k <= 9; ++k) {
        if (k % 2 == 0 && side > 0) continue;
        std::vector<Vec3> points;
        const double x = 205.0 * k;
        for (int i = 0; i <= 14; ++i) {
          const double bend = i % 5 == 3 ? rng_.Uniform(-30, 30) : 0.0;
          points.emplace_back(x + bend, side * 846, 1450 + 205.0 * i);
        }
        Add(Hose(points, rng_.Uniform(6, 10), 0, 20, 8));
      }
    }
    AddLinesAcross();
  }

  /// Adds two lines across the way out of the actuator, which must pass between them.
  void AddLinesAcross() {
    const Vec3 forward = kNest + Vec3(780, 0, 0);
    for (const double height : {350.0, 605.0}) {
      std::vector<Vec3> points;
      for (int i = -4; i <= 4; ++i) {
        points.emplace_back(forward + Vec3(8.0 * (i % 2), 105.0 * i, height + 6 * (i % 3)));
      }
      Add(Hose(points, 12, 0, 36, 14));
    }
  }

  void AddBundles() {
    for (const double side : {-1.0, 1.0}) {
      for (int k = -5; k <= 5; ++k) {
        const double x = 360.0 * k;
        std::vector<Vec3> path;
        for (int i = 0; i <= 13; ++i) {
          path.emplace_back(x + rng_.Uniform(-14, 14), side * (470 + rng_.Uniform(-12, 12)),
                            1480 + 215.0 * i);
        }
        TriangleMesh bundle;
        for (int row = -2; row <= 2; ++row) {
          const int count = 5 - std::abs(row);
          for (int n = 0; n < count; ++n) {
            const Vec3 aside(5.2 * (n - 0.5 * (count - 1)), 4.5 * row, 0);
            std::vector<Vec3> points;
            for (const Vec3& p : path) points.emplace_back(p + aside);
            Append(bundle, Hose(points, 2.3, 0, 8, 4));
          }
        }
        for (std::size_t i = 1; i + 1 < path.size(); i += 3) {
          Append(bundle, Moved(Tube(15, 18, -8, 8, 40), path[i]));
        }
        Add(bundle);
      }
    }
  }

  void AddEquipment() {
    for (const double side : {-1.0, 1.0}) {
      for (int row = 0; row < 9; ++row) {
        for (int column = 0; column < 12; ++column) {
          const Vec3 middle(kEquipmentCell * (column - 5.5), side * kEquipment,
                            1620 + kEquipmentCell * row);
          const bool trunnion =
              std::abs(middle.x()) < 300 && std::abs(middle.z() - kTrunnionHeight) < 280;
          if (trunnion || rng_.Uniform(0, 1) > kFilled) continue;
          const TriangleMesh part = PartByChance(rng_);
          const Bounds box = BoundsOf(part);
          const Vec3 room = Vec3::Constant(kEquipmentCell - 14);
          const double scale = room.cwiseQuotient(box.size()).minCoeff();
          Add(Moved(Scaled(part, scale), middle - 0.5 * scale * (box.min + box.max)));
        }
      }
    }
  }

  static constexpr double kFilled = 0.47;
  RandomSource rng_{20050318};
  std::vector<TriangleMesh> parts_;
};

HandScript Mechanic() {
  HandScript script;
  script.impedance.damping = 20;
  script.X_BD.p = {0.2, 0, 0};
  script.impedance.inertia = 0.02;
  script.impedance.rotation_stiffness = 60;
  script.impedance.rotation_damping = 1.5;
  // settles on the racks, is eased off them and slid back from under the keeper, up, forward and
  // out between two lines
  script.waypoints = {
      {0.0, {0, 0, 0}, Quat::Identity()},
      {1.5, {0, 0, -0.006}, Quat::Identity()},
      {2.5, {0, 0, 0.006}, Quat::Identity()},
      {6.0, {-0.102, 0.001, 0.004}, Quat::Identity()},
      {8.0, {-0.088, 0.006, 0.080}, Quat::Identity()},
      {11.0, {-0.085, 0.006, 0.300}, Quat::Identity()},
      {14.0, {0.100, 0, 0.440}, RotationBy(Vec3(0, -0.02, 0))},
      {22.0, {1.500, 0.010, 0.436}, Quat::Identity()},
      {26.0, {2.300, 0, 0.450}, Quat::Identity()},
  };
  return script;
}

/// Returns the same script without the way back from under the keeper.
HandScript HastyMechanic() {
  HandScript script = Mechanic();
  for (Waypoint& at : script.waypoints) at.p_W.x() = std::max(at.p_W.x(), 0.0);
  return script;
}

}  // namespace

std::vector<TriangleMesh> MakeLandingGear(LandingGearParts parts) {
  return Builder().Make(parts);
}

GeneratedScene LandingGear(const std::vector<TriangleMesh>& parts) {
  TriangleMesh fixed;
  for (const TriangleMesh& part : parts) Append(fixed, part);
  const HandScript rod = Mechanic();
  Pose barrel_grasp;
  barrel_grasp.p = {-0.15, 0, 0};
  return {"landing_gear",
          {{"landing_gear_fixed.stl", std::move(fixed)},
           {"landing_gear_actuator.stl", ClutterActuator({.fineness = 0.5, .valves = true})}},
          {{"landing_gear_rod.json", rod},
           {"landing_gear_barrel.json", SecondHand(rod, 1.02, {0, 0.002, 0.002}, barrel_grasp)},
           {"landing_gear_hasty.json", HastyMechanic()}}};
}

}  // namespace tandem
