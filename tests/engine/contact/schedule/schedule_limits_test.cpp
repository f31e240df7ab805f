#include <bit>
#include <limits>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "engine/contact/schedule/point_schedule.h"
#include "tests/engine/contact/schedule/random_walk.h"

namespace tandem {
namespace {

using testing::Bodies;
using testing::Box;
using testing::kVoxel;
using testing::RandomDirection;
using testing::RandomRotation;
using testing::Uniform;
using testing::UntestedPoints;

constexpr double kUnlimited = std::numeric_limits<double>::infinity();

double Lowest(const Bodies& bodies, const Pose& X_WB) {
  double lowest = kUnlimited;
  for (std::size_t i = 0; i < bodies.shell.size(); ++i) {
    lowest = std::min(lowest, (X_WB * bodies.shell.point(i)).z());
  }
  return lowest;
}

// The body goes from two chunks off, as fast as it may. Far from the plate that is many voxels a
// frame, but never as many as would take it into the plate unseen, as a flat 32 voxels would.
TEST(ScheduleLimits, ThrownBodyIsNeverTestedLate) {
  const double top = 0.023;           // top of the plate
  const double contact = 3 * kVoxel;  // and of the voxels that its top lies in
  const Bodies bodies(Box(Vec3(0.8, 0.8, 2 * top)), Box(Vec3(0.12, 0.07, 0.04)));
  std::mt19937_64 random(31);
  const int throws = 200;
  double fastest = 0;
  int fast = 0;
  for (int k = 0; k < throws; ++k) {
    Pose X_WS{RandomRotation(random),
              Vec3(Uniform(random, -0.1, 0.1), Uniform(random, -0.1, 0.1), 0)};
    X_WS.p.z() = top + Uniform(random, 16, 28) * kVoxel - Lowest(bodies, X_WS);
    const Vec3 way = (-Vec3::UnitZ() + 0.2 * RandomDirection(random)).normalized();
    const Vec3 turn = Uniform(random, 0, 0.3) / bodies.shell.radius * RandomDirection(random);
    const double each = TravelOf(way, turn.norm(), bodies.shell.radius);
    ASSERT_LT(Lowest(bodies, {X_WS.q, X_WS.p + 32 * kVoxel * way}), top);

    PointSchedule schedule(bodies.blocks, bodies.voxmap, 0, {});
    double travel = kUnlimited;
    double most = 0;
    int frame = 0;
    do {
      schedule.Test(bodies.X_MV().Inverse() * X_WS, travel);
      ASSERT_EQ(UntestedPoints(bodies.blocks, bodies.voxmap, schedule), 0U)
          << "throw " << k << ", frame " << frame;
      if (!schedule.contacts().empty()) break;
      travel = MaxTravel(schedule.Demand(), kUnlimited, 0, kVoxel);
      ASSERT_LE(travel, 32 * kVoxel);
      most = std::max(most, travel);
      X_WS.p += travel / each * way;
      X_WS.q = (RotationBy(travel / each * turn) * X_WS.q).normalized();
    } while (++frame < 1000);
    // seen in the first half voxel of contact
    EXPECT_LE(Lowest(bodies, X_WS), contact) << "throw " << k;
    EXPECT_GE(Lowest(bodies, X_WS), contact - 0.5 * kVoxel - 1e-6) << "throw " << k;
    fast += most > 0.5 * kVoxel ? 1 : 0;
    fastest = std::max(fastest, most);
  }
  RecordProperty("fast_throws", fast);
  RecordProperty("fastest_voxels", std::to_string(fastest / kVoxel));
  EXPECT_GT(fast, throws / 2);
  EXPECT_LT(fastest, 28 * kVoxel);
}

constexpr double kPi = 3.14159265358979323846;
constexpr double kMillimetre = 0.001;

struct EdgeFigures {
  std::size_t contacts = 0;
  std::size_t tests = 0;  // tests in a frame at rest
  TestDemand demand;
};

/// Returns the figures of two bars with edges of 200 mm: the bottom edge of one lies on the top
/// edge of the other, at an angle.
EdgeFigures OnEdge(const Bodies& bars, double angle, int layer) {
  const double across = 0.03;  // width of a bar
  const Quat q = RotationBy(Vec3(0, 0, angle));
  const Vec3 edge(0, 0.5 * across, 0.5 * across);  // its middle
  const Pose X_VS = bars.X_MV().Inverse() * Pose{q, edge + q * Vec3(0, edge.y(), edge.z())};
  PointSchedule schedule(bars.blocks, bars.voxmap, layer, {});
  schedule.Test(X_VS, kUnlimited);
  schedule.Test(X_VS, 0);
  EXPECT_EQ(UntestedPoints(bars.blocks, bars.voxmap, schedule), 0U);
  EdgeFigures figures{
      .contacts = 0, .tests = schedule.counts().looked_up, .demand = schedule.Demand()};
  for (const Schedule::ContactBlock& contact : schedule.contacts()) {
    figures.contacts += static_cast<std::size_t>(std::popcount(contact.lanes));
  }
  return figures;
}

double TravelAt(const EdgeFigures& figures, double capacity) {
  return MaxTravel(figures.demand, capacity, 0, kMillimetre) / kMillimetre;
}

// Geometrical awareness cannot help here (paper §4): edges meet edges, so two that lie along one
// another are tested point by point, at 200 mm and 1 mm voxels some 200 of them. Crossed edges meet
// in one place. The limit is felt only where a few hundred tests are too many.
TEST(ScheduleLimits, AlignedEdgesAreTestedAlongTheirWholeLength) {
  const Bodies bars(Box(Vec3(0.2, 0.03, 0.03)), Box(Vec3(0.2, 0.03, 0.03)), kMillimetre);
  for (const int layer : {0, 1, 2}) {
    const EdgeFigures aligned = OnEdge(bars, 0, layer);
    const EdgeFigures crossed = OnEdge(bars, 0.5 * kPi, layer);
    const std::string key = "layer_" + std::to_string(layer);
    for (const auto& [name, figures] :
         {std::pair(key + "_aligned", &aligned), std::pair(key + "_crossed", &crossed)}) {
      RecordProperty(name + "_contacts", static_cast<int>(figures->contacts));
      RecordProperty(name + "_tests", static_cast<int>(figures->tests));
      RecordProperty(name + "_mandatory", std::to_string(figures->demand.mandatory));
      RecordProperty(name + "_travel_at_2000", std::to_string(TravelAt(*figures, 2000)));
      RecordProperty(name + "_travel_at_400", std::to_string(TravelAt(*figures, 400)));
    }
    EXPECT_GE(aligned.contacts, 200U);
    EXPECT_LE(aligned.contacts, 250U);
    EXPECT_LE(crossed.contacts, 20U);
    EXPECT_GT(aligned.tests, 4 * crossed.tests);
    EXPECT_GT(TravelAt(crossed, 400), 10 * kTravelFloor);
    EXPECT_DOUBLE_EQ(TravelAt(aligned, 2000), 0.5);
    EXPECT_DOUBLE_EQ(TravelAt(aligned, 400), kTravelFloor);
  }
}

}  // namespace
}  // namespace tandem
