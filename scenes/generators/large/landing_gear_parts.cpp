#include "scenes/generators/large/landing_gear_parts.h"

#include <numbers>
#include <vector>

#include "scenes/generators/large/clutter_parts.h"
#include "scenes/generators/large/machine_parts.h"

namespace tandem {
namespace {

TriangleMesh Tyre() {
  constexpr double kTyreWall = 18;
  constexpr double kTread = 625;
  constexpr double kHalfTread = 190;
  constexpr int kGrooves = 5;
  constexpr double kGroove = 12;
  constexpr double kGrooveDepth = 14;
  // up the inner face, then down the outer one
  std::vector<Vec2> profile = {{285, -170 + kTyreWall},
                               {300, -190 + kTyreWall},
                               {450, -235 + kTyreWall},
                               {590 - kTyreWall, -195},
                               {600 - kTyreWall, -100},
                               {602 - kTyreWall, 0},
                               {600 - kTyreWall, 100},
                               {590 - kTyreWall, 195},
                               {450, 235 - kTyreWall},
                               {300, 190 - kTyreWall},
                               {285, 170 - kTyreWall},
                               {285, 170},
                               {300, 190},
                               {450, 235},
                               {560, 222},
                               {600, 205}};
  const double pitch = 2 * kHalfTread / (kGrooves + 1);
  profile.emplace_back(kTread, kHalfTread);
  for (int k = 1; k <= kGrooves; ++k) {
    const double at = kHalfTread - pitch * k;
    for (const Vec2& p :
         {Vec2(kTread, at + kGroove), Vec2(kTread - kGrooveDepth, at + 0.7 * kGroove),
          Vec2(kTread - kGrooveDepth, at - 0.7 * kGroove), Vec2(kTread, at - kGroove)}) {
      profile.push_back(p);
    }
  }
  for (const Vec2& p : {Vec2(kTread, -kHalfTread), Vec2(600, -205), Vec2(560, -222),
                        Vec2(450, -235), Vec2(300, -190), Vec2(285, -170)}) {
    profile.push_back(p);
  }
  return RevolvedRing(profile, 240);
}

}  // namespace

TriangleMesh BrakedWheel(double axle_radius) {
  TriangleMesh wheel = Tyre();
  // rim, web with bolts, hub
  Append(wheel, Tube(262, 285 - kSeam, -168, 168, 160));
  Append(wheel, Tube(92, 262 - kSeam, -60, -36, 120));
  Append(wheel, Moved(Rotated(BoltCircle(18, 215, 24), RotationBy(Vec3(std::numbers::pi, 0, 0))),
                      {0, 0, -60 - kSeam}));
  Append(wheel, Moved(BoltCircle(18, 130, 19), {0, 0, -36 + kSeam}));
  Append(wheel, Tube(axle_radius + 2, 92 - kSeam, -150, 175, 96));
  // stators and rotors of the brake
  for (int disc = 0; disc < 9; ++disc) {
    const bool turns = disc % 2 == 0;
    const double bottom = -10 + 19.0 * disc;
    Append(wheel, Tube(turns ? 125 : 100, turns ? 250 : 232, bottom, bottom + 17, 144));
  }
  return wheel;
}

TriangleMesh BraceLink(double length, double radius, double eye) {
  TriangleMesh link = Tube(0.75 * radius, radius, eye + kSeam, length - eye - kSeam, 72);
  for (const double at : {0.0, length}) {
    Append(link, Moved(AlongY(Tube(0.55 * eye, eye, -0.8 * radius, 0.8 * radius, 72)), {0, 0, at}));
    Append(link, Moved(AlongY(Revolved({{0.5 * eye - 2, -1.3 * radius},
                                        {0.5 * eye, -1.3 * radius + 2},
                                        {0.5 * eye, 1.3 * radius - 2},
                                        {0.5 * eye - 2, 1.3 * radius}},
                                       48)),
                       {0, 0, at}));
  }
  // collars
  for (double z = 0.2 * length; z < 0.85 * length; z += 0.3 * length) {
    TriangleMesh collar = Tube(radius + kSeam, radius + 14, z, z + 30, 64);
    Append(collar, Moved(BoltCircle(8, radius + 7.5, 6), {0, 0, z + 30 + kSeam}));
    Append(link, collar);
  }
  return link;
}

}  // namespace tandem
