#include "engine/contact/features/edge_contact.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "tests/support/shapes.h"

namespace tandem {
namespace {

using testing::Uniform;

/// Two wedges along one line: the shell's above the map's, whose arcs are `half` wide each side of
/// normals that `turn` apart.
struct Wedges {
  double half = 0;
  double other_half = 0;
  double turn = 0;
  double x = 0;  // place of the shell's edge from the map's, along the map's normal
  double y = 0;  // and square to it and to the line
};

/// Returns a voxel's length of the map's edge along z, whose faces' normals are `half` rad each
/// side of x.
OtherEdge RidgeAlongZ(double half) {
  return {Vec3::Zero(), Vec3::UnitZ(), Vec3::UnitX(), 0.5, EdgeArc::FromCosine(std::cos(half))};
}

/// Finds the depth, 0 if they do not push, by trying all directions that lie in both arcs.
double DepthByTrying(const Wedges& wedges) {
  constexpr int kSteps = 20000;
  const double low = std::max(-wedges.other_half, wedges.turn - wedges.half);
  const double high = std::min(wedges.other_half, wedges.turn + wedges.half);
  double gap = -1e9;
  for (int i = 0; i <= kSteps; ++i) {
    const double angle = low + (high - low) * i / kSteps;
    gap = std::max(gap, wedges.x * std::cos(angle) + wedges.y * std::sin(angle));
  }
  return std::max(0.0, kRefinedClearance - gap);
}

TEST(EdgeContact, ParallelEdgesPushByTheDistanceOfTheirWedges) {
  std::mt19937_64 random(1);
  int pushing = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    Wedges wedges{Uniform(random, 0.05, 1.5), 0, 0, Uniform(random, -0.5, 0.6),
                  Uniform(random, -0.5, 0.5)};
    wedges.other_half = Uniform(random, 0.05, 1.5);
    const double most = std::min(1.3, wedges.half + wedges.other_half);
    wedges.turn = Uniform(random, -most, most);
    const ShellEdge edge{Vec3(wedges.x, wedges.y, 0), Vec3::UnitZ(),
                         Vec3(std::cos(wedges.turn), std::sin(wedges.turn), 0), 0.5,
                         EdgeArc::FromCosine(std::cos(wedges.half))};
    const OtherEdge ridge = RidgeAlongZ(wedges.other_half);
    const EdgeEdgeContact meeting = FindEdgeContact(edge, ridge, kRefinedClearance);
    const double depth = DepthByTrying(wedges);
    EXPECT_NEAR(meeting.counted_depth(), depth, 2e-3) << "trial " << trial;
    pushing += depth > 0;
  }
  EXPECT_GT(pushing, 1000);
}

TEST(EdgeContact, ParallelEdgePushVanishesAtTheWindowsBorder) {
  // two roofs of 0.3 rad each side, one moved aside: the gap is along the end of an arc
  constexpr double kHalf = 0.3;
  const OtherEdge ridge = RidgeAlongZ(kHalf);
  for (const double aside : {0.5, 0.7, 0.76, 0.85, 0.95, 0.999, 1.0, 1.2}) {
    for (const double side : {-1.0, 1.0}) {
      const ShellEdge edge{Vec3(0, side * aside, 0), Vec3::UnitZ(), Vec3::UnitX(), 0.5,
                           EdgeArc::FromCosine(std::cos(kHalf))};
      const EdgeEdgeContact meeting = FindEdgeContact(edge, ridge, kRefinedClearance);
      const double whole = kRefinedClearance - aside * std::sin(kHalf);
      const double share = std::min(1.0, std::max(0.0, 1.0 - aside) / 0.25);
      EXPECT_NEAR(meeting.counted_depth(), share * whole, 2e-3) << side * aside;
      if (aside >= 1) {
        EXPECT_EQ(meeting.counted_depth(), 0);
      }
    }
  }
}

TEST(EdgeContact, PushFadesOutBetweenSeparatedArcs) {
  // a narrow wedge over a narrow one, turned away by more than both arcs
  constexpr double kHalf = 0.3;
  const OtherEdge ridge = RidgeAlongZ(kHalf);
  double before = 1;
  for (const double beyond : {0.0, 0.03, 0.06, 0.09, 0.12, 0.149}) {
    const double turn = kHalf + 0.2 + beyond;
    const ShellEdge edge{Vec3::Zero(), Vec3::UnitZ(), Vec3(std::cos(turn), std::sin(turn), 0), 0.5,
                         EdgeArc::FromCosine(std::cos(0.2))};
    const EdgeEdgeContact meeting = FindEdgeContact(edge, ridge, kRefinedClearance);
    EXPECT_NEAR(meeting.counted_depth(), kRefinedClearance * (1 - beyond / 0.15), 5e-3) << beyond;
    EXPECT_LT(meeting.counted_depth(), before);
    // along the middle between them
    EXPECT_NEAR(std::atan2(meeting.normal.y(), meeting.normal.x()), kHalf + 0.5 * beyond, 5e-3);
    before = meeting.counted_depth();
  }
}

}  // namespace
}  // namespace tandem
