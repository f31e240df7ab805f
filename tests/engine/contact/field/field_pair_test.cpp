// Tests contact by distance fields, against planes and boxes whose gaps are known in closed form,
// and against a schedule that looks up every point in every frame.
#include "engine/contact/field/field_pair.h"

#include <algorithm>
#include <random>
#include <utility>

#include <gtest/gtest.h>

#include "engine/contact/features/edge_contact.h"
#include "tests/engine/contact/refined.h"

namespace tandem {
namespace {

using testing::Box;
using testing::kGains;
using testing::kS;
using testing::LowestAlong;
using testing::Plate;
using testing::Raised;
using testing::RandomRotation;
using testing::Refined;
using testing::Sphere;
using testing::Uniform;

TEST(FieldPair, ForceBeginsAtItsClearanceFromATiltedPlane) {
  std::mt19937_64 random(2);
  const TriangleMesh body = Box(kS * Vec3(24, 18, 14));
  for (int tilt = 0; tilt < 4; ++tilt) {
    const Quat q = RandomRotation(random);
    const Vec3 n = q * Vec3::UnitZ();
    Refined met(Plate(q, Vec3::Zero()), body, RandomRotation(random));
    for (int approach = 0; approach < 10; ++approach) {
      const Quat q_WB = RandomRotation(random);
      const Vec3 along = kS * (q * Vec3(Uniform(random, -30, 30), Uniform(random, -30, 30), 0));
      const auto force_at = [&](double gap) {
        return met.ForceAt({q_WB, along + (gap * kS - LowestAlong(body, q_WB, n)) * n}).dot(n);
      };
      double gap = 2.0;  // voxels
      while (gap > -1.0 && force_at(gap) <= 0) gap -= 0.01;
      EXPECT_NEAR(gap, kRefinedClearance, 0.03);
    }
  }
}

TEST(FieldPair, GivesEqualAndOppositeForces) {
  std::mt19937_64 random(3);
  Refined met(Box(kS * Vec3(30, 30, 30)), Box(kS * Vec3(12, 12, 12)), RandomRotation(random));
  int pushing = 0;
  for (int i = 0; i < 300; ++i) {
    const Vec3 way = Vec3(Uniform(random, -1, 1), Uniform(random, -1, 1), Uniform(random, -1, 1));
    met.ForceAt({RandomRotation(random), Uniform(random, 18, 26) * kS * way.normalized()});
    const Wrench shell = AsWrench(met.on_shell.force);
    const Wrench map = AsWrench(met.on_map.force);
    pushing += shell.f.norm() > 0 ? 1 : 0;
    EXPECT_LT((shell.f + map.f).norm(), 1e-9 * (1 + shell.f.norm()));
  }
  EXPECT_GT(pushing, 50);
}

TEST(FieldPair, FeaturesOfBothBodiesAreTested) {
  // a large face over a small box: only the box below has features there
  Refined met(Box(kS * Vec3(6, 6, 6)), Box(kS * Vec3(40, 40, 10)), Quat::Identity());
  EXPECT_EQ(met.ForceAt({Quat::Identity(), kS * Vec3(0, 0, 8.5)}), Vec3(Vec3::Zero()));
  const Vec3 force = met.ForceAt({Quat::Identity(), kS * Vec3(0, 0, 8.3)});
  EXPECT_GT(force.z(), 0);
  EXPECT_LT(force.head<2>().norm(), 1e-3 * force.z());
}

TEST(FieldPair, FindsTheContactsOfAnExhaustiveSearch) {
  std::mt19937_64 random(4);
  const TriangleMesh body = Sphere(10 * kS, 3);
  const TriangleMesh wall = Box(kS * Vec3(60, 60, 20));
  const Quat made_at = RandomRotation(random);
  Refined coherent(wall, body, made_at);
  Refined all(wall, body, made_at, 1,
              {.schedule = {.experiments = {.coherence = false, .chunks = false}}});
  Pose X_WB{RandomRotation(random), kS * Vec3(0, 0, 24)};
  Vec3 way = kS * Vec3(0.2, 0.1, -0.3);
  std::size_t touching = 0;
  std::size_t looked_up = 0;
  std::size_t looked_up_by_all = 0;
  for (int frame = 0; frame < 6000; ++frame) {
    // to and fro above, along and into the wall
    if (frame % 400 == 0) {
      const Vec3 goal =
          kS * Vec3(Uniform(random, -34, 34), Uniform(random, -34, 34), Uniform(random, 18, 24));
      way = (goal - X_WB.p) / 400;
    }
    X_WB.p += way;
    X_WB.q = RotationBy(Vec3(0.001, 0.002, -0.001)) * X_WB.q;
    LinearizedForce load;
    LinearizedForce other;
    const PairReport by_due = coherent.pair.Collide({X_WB, {}}, {}, load, other);
    const PairReport by_all = all.pair.Collide({X_WB, {}}, {}, load, other);
    ASSERT_EQ(by_due.contact_points, by_all.contact_points) << frame;
    if (frame % 10 == 0) {
      ASSERT_EQ(coherent.pair.CountUnfound({X_WB, {}}, {}), 0U) << frame;
    }
    for (std::size_t i = 0; i < all.pair.contacts().size(); ++i) {
      ASSERT_EQ(coherent.pair.contacts()[i].p_V, all.pair.contacts()[i].p_V);
      ASSERT_EQ(coherent.pair.contacts()[i].depth, all.pair.contacts()[i].depth);
    }
    touching += by_all.contact_points > 0 ? 1 : 0;
    looked_up += by_due.tests.looked_up;
    looked_up_by_all += by_all.tests.looked_up;
  }
  EXPECT_GT(touching, 300U);
  EXPECT_LT(looked_up, looked_up_by_all);
}

// The pair knows for some frames which edges may cross, and must not go by that once it is no
// longer true.
TEST(FieldPair, FindsTheEdgePairsOfAnExhaustiveSearch) {
  std::mt19937_64 random(14);
  const TriangleMesh body = Box(kS * Vec3(16, 12, 10));
  const TriangleMesh block = Box(kS * Vec3(30, 24, 20));
  const Quat made_at = RandomRotation(random);
  Refined coherent(block, body, made_at);
  Refined all(block, body, made_at, 1,
              {.schedule = {.experiments = {.coherence = false, .chunks = false}}});
  const auto near_the_block = [&] {
    const Vec3 way(Uniform(random, -1, 1), Uniform(random, -1, 1), Uniform(random, -1, 1));
    return Vec3(Uniform(random, 16, 24) * kS * way.normalized());
  };
  Pose X_WB{RandomRotation(random), near_the_block()};
  Vec3 way = Vec3::Zero();
  Vec3 turn = Vec3::Zero();
  int touching = 0;
  std::size_t compared = 0;
  std::size_t compared_by_all = 0;
  for (int frame = 0; frame < 12'000; ++frame) {
    if (frame % 300 == 0) {
      way = (near_the_block() - X_WB.p) / 300;
      turn = 0.004 * Vec3(Uniform(random, -1, 1), Uniform(random, -1, 1), Uniform(random, -1, 1));
    }
    X_WB.p += way;
    X_WB.q = (RotationBy(turn) * X_WB.q).normalized();
    // it jumps now and then, and force begins elsewhere
    if (frame % 1000 == 999) X_WB = {RandomRotation(random), near_the_block()};
    const Clearance clearance{1, frame % 700 < 350 ? 0.0 : -0.3 * kS};
    if (frame % 350 == 0) {
      coherent.pair.SetClearance(clearance);
      all.pair.SetClearance(clearance);
    }
    LinearizedForce load;
    LinearizedForce other;
    const PairReport by_due = coherent.pair.Collide({X_WB, {}}, {}, load, other);
    const PairReport by_all = all.pair.Collide({X_WB, {}}, {}, load, other);
    ASSERT_EQ(by_due.contact_points, by_all.contact_points) << frame;
    for (std::size_t i = 0; i < all.pair.contacts().size(); ++i) {
      ASSERT_EQ(coherent.pair.contacts()[i].p_V, all.pair.contacts()[i].p_V) << frame;
      ASSERT_EQ(coherent.pair.contacts()[i].depth, all.pair.contacts()[i].depth) << frame;
    }
    touching += by_all.contact_points > 0 ? 1 : 0;
    compared += by_due.tests.compared;
    compared_by_all += by_all.tests.compared;
  }
  EXPECT_GT(touching, 1000);
  EXPECT_LT(compared, compared_by_all / 2);
}

// A block that comes due only because the calendar ends must not hold a body back.
TEST(FieldPair, FallingBodyIsNotSlowedInFreeSpace) {
  Refined met(Box(kS * Vec3(60, 60, 20)), Sphere(10 * kS, 3), Quat::Identity());
  double height = 2000;  // voxels, of the sphere over the box
  double speed = 0.2;    // voxels a frame
  while (speed < 6) {
    met.ForceAt({Quat::Identity(), kS * Vec3(0, 0, 20 + height)});
    ASSERT_GT(met.pair.test_demand().bound, speed * kS) << height << " voxels above";
    height -= speed;
    speed += 0.01;  // as a fall, voxels of a millimetre
  }
}

TEST(FieldPair, TravelCostIsThatOfDueBlocks) {
  std::mt19937_64 random(8);
  Refined met(Box(kS * Vec3(60, 60, 20)), Sphere(10 * kS, 3), RandomRotation(random));
  // eight voxels above the wall, blocks come due again and again, and few are near enough to be
  // looked up at their points
  const double way = 0.05 * kS;  // m a frame
  double foretold = 0;
  double came = 0;
  for (int frame = 0; frame < 600; ++frame) {
    LinearizedForce load;
    LinearizedForce other;
    const Pose X_WB{Quat::Identity(), Vec3(way * frame - 15 * kS, 0, 28 * kS)};
    const PairReport report = met.pair.Collide({X_WB, {}}, {}, load, other);
    if (frame > 0) came += report.tests.tests() + static_cast<double>(report.tests.chunks);
    foretold += met.pair.test_demand().mandatory + met.pair.test_demand().per_metre * way;
  }
  EXPECT_GT(came, 600);
  RecordProperty("foretold", std::to_string(foretold / came));
  EXPECT_GT(foretold, 0.8 * came);
  EXPECT_LT(foretold, 1.5 * came);
}

// Two edges side by side meet as wedges, whose faces have no ends. This face ends at once.
TEST(FieldPair, FacePushesOnlyWithinItsBorder) {
  // a block with a chamfer of 0.57 voxels between its top, at y = 0, and its side
  const TriangleMesh block =
      Raised({{-12, -10}, {0.4, -10}, {0.4, -0.4}, {0, 0}, {-12, 0}}, 24, kS);
  const TriangleMesh tool = Box(kS * Vec3(10, 10, 16));
  Refined met(block, tool, Quat::Identity());
  for (double beside = 0.48; beside < 1.2; beside += 0.01) {
    for (double turn = -0.1; turn < 0.11; turn += 0.05) {
      // its lower edge is level with the chamfer's, and so far beside it
      const Quat q_WB(Eigen::AngleAxisd(turn, Vec3::UnitY()));
      const Vec3 corner = q_WB * (kS * Vec3(-5, -5, 0));
      const Vec3 place = kS * Vec3(0.4 + beside, -0.4, 12) - corner;
      const double nearest = beside - 8 * std::abs(std::sin(turn));
      if (nearest < kRefinedClearance + 0.03) continue;
      EXPECT_EQ(met.ForceAt({q_WB, place}), Vec3(Vec3::Zero())) << beside << " " << turn;
    }
  }
}

TEST(FieldPair, StiffnessGrowsFromZeroWithDepth) {
  // at once, the step of a body that slides along would be held by all that it is about to touch
  Refined met(Box(kS * Vec3(40, 40, 6)), Box(kS * Vec3(12, 12, 12)), Quat::Identity());
  double before = 0;
  double largest_step = 0;
  for (int i = 0; i <= 400; ++i) {
    met.ForceAt({Quat::Identity(), kS * Vec3(0, 0, 9.5 - 0.0005 * i)});
    const double stiffness = met.on_shell.stiffness(5, 5);
    largest_step = std::max(largest_step, stiffness - before);
    before = stiffness;
  }
  // 0.15 voxels deep: the whole rim of 48 voxels, each in full
  EXPECT_GT(before, 30 * kGains.stiffness);
  EXPECT_LT(largest_step, before / 50);
}

TEST(FieldPair, InwardShiftMovesTheForceOnset) {
  // half a voxel: a twentieth of a voxel inside the surface, and no deeper push comes first
  Refined met(Box(kS * Vec3(40, 40, 6)), Box(kS * Vec3(12, 12, 12)), Quat::Identity(), 1,
              {.inward_shift = 0.5});
  for (double gap = 0.2; gap > -0.4; gap -= 0.001) {
    const double depth = kRefinedClearance - 0.5 - gap;
    const double force = met.ForceAt({Quat::Identity(), kS * Vec3(0, 0, 9 + gap)}).z();
    // 4 corners and 4 edges of 12 voxels at a newton a voxel
    const double most = 52 * std::max(0.0, depth + 0.01);
    EXPECT_GE(force, 0) << gap;
    EXPECT_LE(force, most * 1.6) << gap;
    if (depth > 0.02) {
      EXPECT_GT(force, 0) << gap;
    }
  }
}

/// Returns a box of 12 voxels in a slot with walls at x = -8 and 8, and so many voxels of play
/// between them.
Refined InSlot(double play) {
  TriangleMesh slot =
      Transformed(Box(kS * Vec3(20, 40, 40)), {Quat::Identity(), kS * Vec3(-18, 0, 0)});
  Append(slot, Transformed(Box(kS * Vec3(20, 40, 40)), {Quat::Identity(), kS * Vec3(18, 0, 0)}));
  return Refined(slot, Box(kS * Vec3(16 - play, 12, 12)), Quat::Identity());
}

TEST(FieldPair, OppositeSidesOfATightFitAreNearlyDisjoint) {
  Refined met = InSlot(0.3);
  for (int frame = 0; frame < 50; ++frame) {
    EXPECT_LT(met.ForceAt({Quat::Identity(), Vec3::Zero()}).norm(), 1e-5);  // rounding
  }
  ASSERT_FALSE(met.pair.contacts().empty());
  for (const Contact& contact : met.pair.contacts()) EXPECT_LT(contact.depth, 0.01 * kS);
  // off the middle the nearer side alone pushes back
  double force = 0;
  for (int frame = 0; frame < 50; ++frame) {
    force = met.ForceAt({Quat::Identity(), kS * Vec3(0.1, 0, 0)}).x();
  }
  EXPECT_LT(force, 0);
  for (const Contact& contact : met.pair.contacts()) {
    EXPECT_TRUE(contact.nhat_V.x() < 0 || contact.depth < 0.01 * kS);
  }
}

// Past its middle the far side of a thin wall is nearer. It must not push on a corner that has come
// so far.
TEST(FieldPair, CornerInAThinWallIsPushedBackOut) {
  std::mt19937_64 random(9);
  const TriangleMesh body = Box(kS * Vec3(24, 18, 14));
  for (int attitude = 0; attitude < 30; ++attitude) {
    const double thick =
        std::array{0.1, 0.3, 1.0}[static_cast<std::size_t>(attitude) % 3];  // voxels
    Refined met(Box(kS * Vec3(60, 60, thick)), body, RandomRotation(random));
    const Quat q = RandomRotation(random);
    const double low = LowestAlong(body, q, Vec3::UnitZ());
    double most = 0;
    for (double gap = 0.44; gap > -thick - 0.3; gap -= 0.01) {  // voxels, over the near side
      const Vec3 p(0, 0, kS * (0.5 * thick + gap) - low);
      const double force = met.ForceAt({q, p}).z();
      EXPECT_GT(force, 0.8 * most) << "attitude " << attitude << ", " << gap << " voxels";
      most = std::max(most, force);
    }
  }
}

// Contacts that bear a load in a tight fit are hardly deeper than those on the far side. If they
// lost their force for a frame, a light body would fall across its play.
TEST(FieldPair, TightFitCarriesALoadInEveryFrame) {
  Refined met = InSlot(0.82);
  std::vector<double> forces;
  for (int frame = 0; frame < 100; ++frame) {
    forces.push_back(-met.ForceAt({Quat::Identity(), kS * Vec3(0.005, 0, 0)}).x());
    const double before = forces[forces.size() > 1 ? forces.size() - 2 : 0];
    EXPECT_GT(forces.back(), 0.5 * before) << "frame " << frame;
    EXPECT_GT(forces.back(), 0.1 * forces[0]) << "frame " << frame;
  }
  // and it comes to rest
  const auto [least, most] = std::minmax_element(forces.begin() + 50, forces.end());
  EXPECT_LT(*most - *least, 0.01 * *most);
}

TEST(FieldPair, WideClearanceInATightFitDoesNotSqueeze) {
  Refined met = InSlot(0.3);
  for (int frame = 0; frame < 100; ++frame) {
    // from half of the frames on as fast as a hand may ask for it
    const double wider = 0.1 * std::clamp(frame - 49, 0, 8);
    met.pair.SetClearance({1.0, -wider * kS});
    met.ForceAt({Quat::Identity(), Vec3::Zero()});
    if (frame < 40) continue;
    for (const Contact& contact : met.pair.contacts()) {
      EXPECT_LT(contact.depth, 0.01 * kS) << "frame " << frame;
    }
  }
}

}  // namespace
}  // namespace tandem
