#include <cmath>
#include <numbers>

#include "scenes/generators/generated_scene.h"
#include "scenes/generators/thread.h"

// A bolt that stands on its head, and a nut that is on the last turn of its thread. The thread is
// trapezoidal, 24 mm across with a pitch of 5 mm (ISO 2904), with 0.15 mm of play on either side.
namespace tandem {
namespace {

// mm
constexpr int kSides = 48;
constexpr double kPitch = 5;
constexpr double kBoltCrest = 12;
constexpr double kBoltFoot = 9.5;
constexpr double kRadialPlay = 0.25;
constexpr double kAxialPlay = 0.15;  // either side
constexpr double kCrestWidth = 0.366 * kPitch;
constexpr double kFlank = 0.268;  // along z, of a millimetre of height
constexpr double kFootWidth = kCrestWidth + 2 * kFlank * (kBoltCrest - kBoltFoot);

constexpr double kHead = 15;
constexpr double kBoltTop = 45;
constexpr double kTipChamfer = 1.5;
constexpr double kBoltStart = 2.5;
constexpr int kBoltTurns = 8;
constexpr double kAcrossFlats = 36;

constexpr int kNutTurns = 4;
constexpr double kNutStart = 2.5;  // above its lower face
constexpr double kNutHeight = 25;
// Its ridge is in the middle of the bolt's groove there, and one turn of it is on the thread.
constexpr double kNutBottom = 22.5;

double CornerRadius(int side) {
  const double angle = 2 * std::numbers::pi * side / kSides;
  return 0.5 * kAcrossFlats / std::cos(std::remainder(angle, std::numbers::pi / 3));
}

Loop Hexagon(double z) {
  Loop loop;
  for (int i = 0; i < kSides; ++i) {
    const double angle = 2 * std::numbers::pi * i / kSides;
    const double r = CornerRadius(i);
    loop.emplace_back(r * std::cos(angle), r * std::sin(angle), z);
  }
  return loop;
}

TriangleMesh Bolt() {
  const Thread thread = {.pitch = kPitch,
                         .foot_radius = kBoltFoot,
                         .crest_radius = kBoltCrest,
                         .foot_width = kFootWidth,
                         .crest_width = kCrestWidth,
                         .start = kBoltStart,
                         .turns = kBoltTurns,
                         .sides = kSides};
  return Threaded(thread, {Hexagon(-kHead), Hexagon(0), Circle(kBoltFoot, 0, kSides)},
                  {Circle(kBoltFoot, kBoltTop, kSides),
                   Circle(kBoltFoot - kTipChamfer, kBoltTop + kTipChamfer, kSides)},
                  SkinEnds::kCapped);
}

TriangleMesh Nut() {
  // as wide as the bolt's groove at that radius, less the play
  const auto width = [](double radius) {
    const double groove = kPitch - kFootWidth + 2 * kFlank * (radius - kBoltFoot);
    return groove - 2 * kAxialPlay;
  };
  const double foot = kBoltCrest + kRadialPlay;
  const double crest = kBoltFoot + kRadialPlay;
  const Thread thread = {.pitch = kPitch,
                         .foot_radius = foot,
                         .crest_radius = crest,
                         .foot_width = width(foot),
                         .crest_width = width(crest),
                         .start = kNutBottom + kNutStart,
                         .turns = kNutTurns,
                         .sides = kSides};
  const double top = kNutBottom + kNutHeight;
  return Threaded(thread, {Hexagon(kNutBottom), Circle(foot, kNutBottom, kSides)},
                  {Circle(foot, top, kSides), Hexagon(top)}, SkinEnds::kJoined);
}

// Returns a hand that screws the nut on by a turn and presses it down, farther than the thread lets
// it come. Then it screws it off again, pulling, and lifts it away.
HandScript NutHand() {
  constexpr double kMm = 1e-3;
  constexpr double kPress = 4;
  constexpr int kPartsOfTurn = 3;
  constexpr double kPart = 0.66;  // s
  HandScript script;
  script.impedance.damping = 12;
  script.X_BD.p = {0.015, 0, 0};
  double t = 0;
  int part = 0;
  const auto turn_to = [&](int to, double press) {
    while (part != to) {
      part += part < to ? 1 : -1;
      t += kPart;
      const double turns = static_cast<double>(part) / kPartsOfTurn;
      script.waypoints.push_back({t, Vec3(0, 0, kMm * (kPitch * turns + press)),
                                  RotationBy(Vec3(0, 0, 2 * std::numbers::pi * turns))});
    }
  };
  script.waypoints.push_back({t, Vec3::Zero(), Quat::Identity()});
  turn_to(-kPartsOfTurn, -kPress);
  turn_to(5, kPress);
  Waypoint away = script.waypoints.back();
  away.t += 1.4;
  away.p_W.z() += 40 * kMm;
  script.waypoints.push_back(away);
  return script;
}

}  // namespace

GeneratedScene NutAndBolt() {
  const HandScript right = NutHand();
  Pose other_grasp;
  other_grasp.p = {-0.015, 0, 0};
  const HandScript left = SecondHand(right, 1.03, {0.001, 0, 0}, other_grasp);
  return {"nut_and_bolt",
          {{"nut_and_bolt_bolt.stl", Bolt()}, {"nut_and_bolt_nut.stl", Nut()}},
          {{"nut_and_bolt_right.json", right}, {"nut_and_bolt_left.json", left}}};
}

}  // namespace tandem
