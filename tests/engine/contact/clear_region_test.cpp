// Regions in which a point is known to make no contact, against looking at it there.
#include "engine/contact/clear_region.h"

#include <numbers>

#include <gtest/gtest.h>

#include "engine/contact/edge_contact.h"
#include "tests/support/shapes.h"

namespace tandem {
namespace {

using testing::RandomDirection;
using testing::RandomRotation;
using testing::Uniform;

/// Farther than any region reaches, or just about as far as it does against its normal.
Vec3 SomewhereAbout(const ClearRegion& region, std::mt19937_64& random) {
  const Vec3 way = Uniform(random, 0, 1.1) * region.reach * RandomDirection(random);
  if (region.round() || random() % 2 == 0) return region.from + way;
  const Vec3 n = region.normal.cast<double>();
  const Vec3 along = way - n.dot(way) * n;
  const double down = region.margin - region.spread * along.norm();
  return region.from + along - Uniform(random, 0.8, 1.0) * down * n;
}

constexpr double kTurn = 0.01;  // rad

TEST(ClearRegion, HoldsOnlyAbovePlanesAndWithinWays) {
  std::mt19937_64 random(1);
  int held = 0;
  for (int trial = 0; trial < 20000; ++trial) {
    struct Plane {
      Vec3 normal;
      double margin;
      double swing;
      double way;
    };
    std::vector<Plane> planes(1 + random() % 6);
    const Vec3 up = RandomDirection(random);
    const double spread = Uniform(random, 0, 1.5);
    ClearRegionMaker maker;
    maker.Begin(kTurn);
    for (Plane& plane : planes) {
      plane = {(up + spread * RandomDirection(random)).normalized(), Uniform(random, -0.02, 0.5),
               Uniform(random, 0, 5), Uniform(random, -0.1, 0.6)};
      maker.KeepAbove(plane.normal, plane.margin, plane.swing, plane.way);
    }
    if (maker.empty()) continue;
    const Vec3 p = 100 * RandomDirection(random);
    const ClearRegion region = maker.Make(p, 3.0, 7);
    EXPECT_TRUE(region.Holds(p, 3.0, kTurn));
    EXPECT_FALSE(region.Holds(p, 3.01 + 1e-9, kTurn));
    for (int i = 0; i < 40; ++i) {
      const Vec3 q = SomewhereAbout(region, random);
      const double turned = Uniform(random, 0, kTurn);
      if (!region.Holds(q, 3.0 + turned, kTurn)) continue;
      ++held;
      for (const Plane& plane : planes) {
        EXPECT_TRUE((q - p).dot(plane.normal) > plane.swing * turned - plane.margin ||
                    (q - p).norm() < plane.way);
      }
      const double turns = Uniform(random, 0.001, 0.1);
      const double room = 0.999 * region.Room(q, 3.0 + turned, kTurn, turns);
      EXPECT_TRUE(
          region.Holds(q + room * RandomDirection(random), 3.0 + turned + turns * room, kTurn));
    }
  }
  EXPECT_GT(held, 100000);
}

// Edges at all angles, as good as parallel and about to be no longer so too.
TEST(ClearRegion, HoldsOnlyWhereEdgesDoNotPushHoweverTheyTurn) {
  std::mt19937_64 random(2);
  int held = 0;
  int pushed = 0;
  for (int trial = 0; trial < 200000; ++trial) {
    const Quat q = RandomRotation(random);
    const Vec3 up = q * Vec3::UnitZ();
    const double angle = random() % 2 == 0 ? Uniform(random, 0.1, 0.2)
                                           : Uniform(random, 0.0, 0.5 * std::numbers::pi);
    const auto leaning = [&](const Vec3& along, double by) -> Vec3 {
      return (RotationBy(Uniform(random, -by, by) * along) * up).normalized();
    };
    ShellEdge edge;
    edge.tangent =
        (random() % 2 == 0 ? 1 : -1) * (RotationBy(angle * up) * (q * Vec3::UnitX())).normalized();
    edge.nhat = leaning(edge.tangent, 0.8);
    edge.half = Uniform(random, 0.1, 0.8);
    edge.arc = EdgeArc(Uniform(random, 0.02, 1.2));
    edge.ends = random() % 4 == 0;
    SurfaceDetail detail;
    const Vec3 other = q * Vec3::UnitX();
    detail.normal = PackDirection(leaning(other, 0.8));
    detail.tangent = PackDirection(other);
    detail.half_length = static_cast<std::uint8_t>(random() % 128);
    const bool ends = random() % 4 == 0;
    const EdgeArc arc(Uniform(random, 0.02, 1.4));
    const Vec3 at = 50 * RandomDirection(random);
    edge.p =
        at + Uniform(random, 0.3, 1.2) * up + Uniform(random, 0, 1.5) * RandomDirection(random);
    ClearRegionMaker maker;
    maker.Begin(Uniform(random, 0.001, 0.03));
    const EdgeMeeting meeting = Meet(edge, detail, at, ends, arc, &maker, 0);
    EXPECT_EQ(meeting.counted_depth(), Meet(edge, detail, at, ends, arc).counted_depth());
    if (meeting.counted_depth() > 0) {
      ++pushed;
      continue;
    }
    if (maker.empty()) continue;
    const ClearRegion region = maker.Make(edge.p, 0, 7);
    for (int i = 0; i < 10; ++i) {
      ShellEdge moved = edge;
      moved.p = SomewhereAbout(region, random);
      const double turned = std::pow(Uniform(random, 0, 1), 2) * maker.turn();
      if (!region.Holds(moved.p, turned, maker.turn())) continue;
      ++held;
      const Quat turn = RotationBy(turned * RandomDirection(random));
      moved.tangent = turn * edge.tangent;
      moved.nhat = turn * edge.nhat;
      ASSERT_EQ(Meet(moved, detail, at, ends, arc).counted_depth(), 0.0)
          << "trial " << trial << ", angle " << angle;
    }
  }
  EXPECT_GT(held, 200000);
  EXPECT_GT(pushed, 5000);
}

}  // namespace
}  // namespace tandem
