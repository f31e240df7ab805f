#include <cmath>
#include <cstdio>
#include <ostream>
#include <random>

#include <gtest/gtest.h>

#include "tests/engine/contact/refined.h"

namespace tandem {
namespace {

using testing::Box;
using testing::kGains;
using testing::kS;
using testing::Plate;
using testing::RandomDirection;
using testing::RandomRotation;
using testing::Refined;
using testing::Sphere;
using testing::Uniform;

struct Ride {
  double turned;  // how far parts are from one another: edges at any angle, or as good as parallel
  bool changing = false;  // force layer and displacement, while they move
  double spacing = 1;     // of the points, voxels
};
/// Without it a test's name has the bytes between the two members, which change from run to run.
void PrintTo(const Ride& ride, std::ostream* out) {
  *out << "turned by " << ride.turned << (ride.changing ? ", changing" : "");
}
class StandingClear : public ::testing::TestWithParam<Ride> {};

// Points that are known to make no contact yet are left out; nothing may come of that.
TEST_P(StandingClear, ChangesNoBit) {
  std::mt19937_64 random(9);
  std::mt19937_64 changes(10);
  const auto turned = [&]() -> Quat {
    if (GetParam().turned > 1) return RandomRotation(random);
    return RotationBy(Uniform(random, 0.0, GetParam().turned) * RandomDirection(random));
  };
  TriangleMesh fixed = Plate(turned(), Vec3::Zero());
  for (int i = 0; i < 12; ++i) {
    const Vec3 place =
        kS * Vec3(Uniform(random, -30, 30), Uniform(random, -30, 30), Uniform(random, -12, 12));
    Append(fixed, Transformed(Box(kS * Vec3(9, 7, 14)), {turned(), place}));
  }
  Append(fixed, Transformed(Sphere(12 * kS, 3), {Quat::Identity(), kS * Vec3(10, -20, 16)}));
  TriangleMesh moving = Box(kS * Vec3(40, 18, 14));
  Append(moving, Transformed(Sphere(9 * kS, 3), {Quat::Identity(), kS * Vec3(24, 0, 0)}));
  const Refined made(fixed, moving, turned(), GetParam().spacing);
  const double map_radius = BoundsOf(fixed).size().norm();
  const auto pair = [&](const ScheduleOptions& schedule) {
    return ContactPair(made.shell, made.voxmap, {Quat::Identity(), made.voxmap.p_WVo()}, map_radius,
                       {.force_layer = DefaultForceLayer(ContactModel::kRefined),
                        .details = &made.details,
                        .schedule = schedule},
                       kGains);
  };
  ContactPair with = pair({});
  ContactPair without = pair({.coherence = false, .chunks = false, .drift = false});
  const Vec3 home = kS * Vec3(0, 0, 25);
  BodyMotion shell{{turned(), home}, {}};
  BodyMotion map;
  const auto move = [&](BodyMotion& body, double pace, const Vec3& to) {
    body.V_WB.v =
        0.98 * body.V_WB.v + 0.1 * pace * RandomDirection(random) - 2e-4 * (body.X_WB.p - to);
    body.V_WB.w = 0.98 * body.V_WB.w + 0.1 * pace / (25 * kS) * RandomDirection(random);
    body.X_WB.p += body.V_WB.v;
    body.X_WB.q = (RotationBy(body.V_WB.w) * body.X_WB.q).normalized();
  };
  double clear = 0;
  double looks = 0;
  double sifted = 0;
  double points = 0;
  int loaded = 0;
  int different = 0;
  const int frames = GetParam().spacing < 1 ? 1500 : 6000;  // of more points
  for (int frame = 0; frame < frames; ++frame) {
    // to a third of a voxel a frame, for a third of the time creeping; the map turns too in the
    // second half
    const bool creeping = frame / 400 % 3 == 2;
    const double pace = creeping ? 1e-3 * kS : kS * std::pow(10.0, Uniform(random, -3, -1));
    // every other while straight on, when all travel is approach
    if (frame / 200 % 2 == 0) {
      move(shell, pace, home);
    } else {
      if (frame % 200 == 0)
        shell.V_WB.v = (creeping ? 0.004 : 0.08) * kS *
                       (home - shell.X_WB.p + 20 * kS * RandomDirection(random)).normalized();
      shell.X_WB.p += shell.V_WB.v;
      shell.V_WB.w.setZero();
    }
    if (frame > frames / 2) move(map, 0.3 * pace, Vec3::Zero());
    // as good as parallel for good
    const Quat back = map.X_WB.q * shell.X_WB.q.conjugate();
    if (GetParam().turned <= 1)
      shell.X_WB.q = RotationBy(0.02 * RotationVector(back)) * shell.X_WB.q;
    if (GetParam().changing && frame % 7 == 0) {
      const int layer = static_cast<int>(Uniform(changes, 1, 5));
      const double displacement = kS * Uniform(changes, -0.3, 0.3);
      for (ContactPair* each : {&with, &without}) {
        const double before = each->clearance().displacement;
        each->SetClearance({static_cast<double>(layer), frame % 3 == 0 ? displacement : before});
      }
    }
    Load one, other, on_map;
    const PairReport report = with.Collide({shell.X_WB, {}}, {map.X_WB, {}}, one, on_map);
    const PairReport plain = without.Collide({shell.X_WB, {}}, {map.X_WB, {}}, other, on_map);
    different += one.force != other.force || one.stiffness != other.stiffness ||
                 report.contact_points != plain.contact_points;
    clear += report.clear_points;
    looks += report.looks;
    sifted += report.sifted_points;
    points += report.contact_points;
    loaded += report.loaded_points;
  }
  EXPECT_EQ(different, 0);
  EXPECT_GT(loaded, frames * 5 / 3);
  EXPECT_GT(clear, 0.1 * points);
  EXPECT_GT(sifted, 0.1 * points);
  EXPECT_LT(looks, 0.5 * points);
  std::printf("  %.0f points: %.0f %% stood clear, %.0f %% were looked at, %d loaded\n", points,
              100 * clear / points, 100 * looks / points, loaded);
}

INSTANTIATE_TEST_SUITE_P(Turned, StandingClear,
                         ::testing::Values(Ride{3.0}, Ride{0.3}, Ride{0.1}, Ride{3.0, true},
                                           Ride{0.3, true}, Ride{0.3, true, 0.4}));

}  // namespace
}  // namespace tandem
