#include "engine/contact/contact_sieve.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <hwy/highway.h>

#include "engine/contact/edge_contact.h"
#include "engine/contact/plane_mean.h"
#include "engine/contact/surface_window.h"
#include "engine/voxel/voxelize.h"
#include "tests/support/shapes.h"

namespace tandem {
namespace {

using testing::Box;
using testing::RandomDirection;
using testing::RandomRotation;
using testing::Sphere;
using testing::Uniform;

constexpr double kS = 0.001;  // m, a voxel
constexpr double kFlatness = 0.25;

/// A plate with boxes and a ball on it, turned: edges, corners and curved surface.
struct Clutter {
  Clutter() {
    std::mt19937_64 random(5);
    TriangleMesh mesh = Box(kS * Vec3(60, 60, 8));
    for (int i = 0; i < 10; ++i) {
      const Vec3 place = kS * Vec3(Uniform(random, -25, 25), Uniform(random, -25, 25), 7);
      Append(mesh, Transformed(Box(kS * Vec3(9, 7, 12)), {RandomRotation(random), place}));
    }
    Append(mesh, Transformed(Sphere(9 * kS, 3), {Quat::Identity(), kS * Vec3(5, -8, 9)}));
    const TriangleMesh turned = Transformed(mesh, {RandomRotation(random), Vec3::Zero()});
    voxmap = std::move(*Voxelize(turned, {.voxel_size = kS, .flatness_voxels = kFlatness}));
    details = SurfaceDetails(turned, kFlatness, voxmap);
    const GridIndex size = GridIndex{static_cast<int>(voxmap.header().size[0]),
                                     static_cast<int>(voxmap.header().size[1]),
                                     static_cast<int>(voxmap.header().size[2])} *
                           kHyperchunkSide;
    for (int z = 0; z < size.z; ++z) {
      for (int y = 0; y < size.y; ++y) {
        for (int x = 0; x < size.x; ++x) {
          const GridIndex v{x, y, z};
          if (voxmap.Value(Field::kEdge, v) == kSurfaceMark) edges.push_back(v);
          if (voxmap.Value(Field::kVertex, v) == kSurfaceMark) vertices.push_back(v);
        }
      }
    }
  }
  Voxmap voxmap;
  SurfaceDetails details;
  std::vector<GridIndex> edges;     // voxels
  std::vector<GridIndex> vertices;  // as well
};

/// Points in some voxels about a source of the map.
std::vector<SievedPoint> PointsAbout(const std::vector<GridIndex>& sources,
                                     std::mt19937_64& random) {
  const auto up_to = [&](int most) {
    return static_cast<int>(random() % static_cast<unsigned>(most + 1));
  };
  const GridIndex low =
      sources[random() % sources.size()] - GridIndex{up_to(3), up_to(3), up_to(3)};
  std::vector<SievedPoint> points;
  for (int i = 0; i < 40; ++i) {
    const GridIndex v = low + GridIndex{up_to(6), up_to(6), up_to(6)};
    const Vec3 p(v.x + Uniform(random, 0, 1), v.y + Uniform(random, 0, 1),
                 v.z + Uniform(random, 0, 1));
    points.push_back({v, p, RandomDirection(random)});
  }
  return points;
}

constexpr std::size_t kCells = 256;  // that are kept

TEST(ContactSieve, LetsEveryEdgeThroughThatPushes) {
  const Clutter map;
  SurfaceWindow window(map.voxmap, map.details);
  NearPieces near(map.voxmap, map.details, kCells);
  std::mt19937_64 random(1);
  int pushed = 0, asked = 0, let_through = 0;
  for (int trial = 0; trial < 5000; ++trial) {
    for (const SievedPoint& point : PointsAbout(map.edges, random)) {
      // an eighth of them as good as flat
      const EdgeArc arc(asked % 16 < 2 ? Uniform(random, 0, 3e-3) : Uniform(random, 0.02, 1.25));
      Vec3 tangent = point.nhat.unitOrthogonal();
      tangent = RotationBy(Uniform(random, 0, 6.3) * point.nhat) * tangent;
      double depth = 0;
      for (const SurfaceWindow::Piece& piece : window.Near(point.voxel_V, Field::kEdge)) {
        // half of them as good as parallel
        if (asked % 2 == 0) {
          const Vec3 other = UnpackDirection(piece.detail->tangent);
          tangent = (other + 0.15 * RandomDirection(random)).cross(point.nhat).cross(point.nhat);
          tangent.normalize();
        }
        break;
      }
      const ShellEdge edge{point.p, tangent,          point.nhat, Uniform(random, 0.1, 0.8),
                           arc,     random() % 4 == 0};
      for (const SurfaceWindow::Piece& piece : window.Near(point.voxel_V, Field::kEdge)) {
        depth = std::max(depth,
                         Meet(edge, *piece.detail, piece.place(), piece.ends, ArcOf(*piece.detail))
                             .counted_depth());
      }
      const NearPieces::Cell& edges = near.About(point.voxel_V, Field::kEdge);
      ASSERT_FALSE(edges.too_many());
      const bool may = MayLean(edges, point, {tangent, edge.half, arc});
      ++asked;
      pushed += depth > 0;
      let_through += may;
      ASSERT_TRUE(may || depth == 0) << "trial " << trial << ", depth " << depth;
    }
  }
  EXPECT_GT(pushed, 2000);
  // most of those let through do push
  EXPECT_LT(let_through, 3 * pushed);
  std::printf("  of %d edges %d push, %d were let through\n", asked, pushed, let_through);
}

TEST(ContactSieve, KnowsWhichVerticesAFaceBearsOn) {
  const Clutter map;
  SurfaceWindow window(map.voxmap, map.details);
  NearPieces near(map.voxmap, map.details, kCells);
  std::mt19937_64 random(2);
  std::array<int, 3> said{};
  for (int trial = 0; trial < 3000; ++trial) {
    for (const SievedPoint& point : PointsAbout(map.vertices, random)) {
      auto expected = SievedBearing::kNone;
      double nearest = 1e9;  // of what is judged, to the bounds that judge it
      for (const SurfaceWindow::Piece& piece : window.Near(point.voxel_V, Field::kVertex)) {
        const Vec3 away = point.p - piece.place();
        const double height = away.dot(point.nhat);
        const double beside = (away - height * point.nhat).norm();
        nearest = std::min(
            {nearest, std::abs(beside - kVertexReach), std::abs(height - kRefinedClearance)});
        if (beside >= kVertexReach) continue;
        expected = std::max(
            expected, height < kRefinedClearance ? SievedBearing::kBears : SievedBearing::kHigh);
      }
      if (nearest < 2 * kSieveMargin) continue;
      const NearPieces::Cell& vertices = near.About(point.voxel_V, Field::kVertex);
      ASSERT_FALSE(vertices.too_many());
      const SievedBearing bearing = MayBear(vertices, point);
      ASSERT_EQ(bearing, expected) << "trial " << trial;
      ++said[static_cast<std::size_t>(bearing)];
    }
  }
  EXPECT_GT(*std::min_element(said.begin(), said.end()), 3000);
}

TEST(ContactSieve, LetsAVertexThroughThatIsWithinTheClearanceOfAPlane) {
  std::mt19937_64 random(3);
  for (int plane = 0; plane < 20; ++plane) {
    const Quat q = RandomRotation(random);
    const TriangleMesh plate =
        Transformed(Box(kS * Vec3(60, 60, 14)), {q, -(q * Vec3(0, 0, 7 * kS))});
    const Voxmap voxmap =
        std::move(*Voxelize(plate, {.voxel_size = kS, .flatness_voxels = kFlatness}));
    const SurfaceDetails details(plate, kFlatness, voxmap);
    NearPieces near(voxmap, details, kCells);
    const Vec3 normal = q * Vec3::UnitZ();
    int through = 0;
    for (int i = 0; i < 500; ++i) {
      const double height = Uniform(random, -0.4, 1.2);
      const Vec3 p_W = q * Vec3(kS * Uniform(random, -20, 20), kS * Uniform(random, -20, 20), 0) +
                       kS * height * normal;
      const Vec3 p = (p_W - voxmap.p_WVo()) / kS;
      const GridIndex v{static_cast<int>(std::floor(p.x())), static_cast<int>(std::floor(p.y())),
                        static_cast<int>(std::floor(p.z()))};
      const NearPieces::Cell& surface = near.About(v, Field::kSurface);
      ASSERT_FALSE(surface.too_many());
      const bool may = MayStand(surface, {v, p, normal});
      through += may;
      // pieces know their places to 1/255 of a voxel
      EXPECT_TRUE(may || height > kRefinedClearance - 0.01) << height;
      EXPECT_FALSE(may && height > kRefinedClearance + 0.01) << height;
      EXPECT_FALSE(MayStand(surface, {v, p, -normal})) << "the far side of a wall";
    }
    EXPECT_GT(through, 100);
  }
}

/// As a vertex of the shell is judged exactly, from the pieces about it.
bool Pushes(SurfaceWindow& window, const SievedPoint& vertex) {
  using Shape = SurfaceDetail::Shape;
  PlaneMean under;
  PlaneMean::Ridges ridges;
  const auto pieces = window.Near(vertex.voxel_V, Field::kSurface);
  const bool only_corners =
      std::all_of(pieces.begin(), pieces.end(), [](const SurfaceWindow::Piece& piece) {
        const Shape shape = piece.detail->shape();
        return shape == Shape::kVertex || shape == Shape::kNotch;
      });
  for (const SurfaceWindow::Piece& piece : pieces) {
    const Shape shape = piece.detail->shape();
    if (!only_corners && (shape == Shape::kVertex || shape == Shape::kNotch)) continue;
    const Vec3 n = UnpackDirection(piece.detail->normal);
    std::array<Vec3, 2> normals{n, n};
    if (shape == Shape::kRidge) {
      const EdgeArc& arc = ArcOf(*piece.detail);
      const Vec3 across = arc.sine * UnpackDirection(piece.detail->tangent).cross(n);
      normals = {arc.cosine * n + across, arc.cosine * n - across};
    }
    std::array<double, 2> heights{}, weights{};
    std::array<bool, 2> facing{};
    const Vec3 away = vertex.p - piece.place();
    for (std::size_t i = 0; i < 2; ++i) {
      heights[i] = away.dot(normals[i]);
      const double beside = (away - heights[i] * normals[i]).norm() / kLateralReach;
      weights[i] = beside < 1 ? (1 - beside * beside) * (1 - beside * beside) : 0.0;
      facing[i] = normals[i].dot(vertex.nhat) > kFacing;
    }
    if (shape == Shape::kRidge) {
      ridges.Add(normals);
      under.AddRidge(piece.place(), normals, heights, weights, facing);
    } else if (facing[0]) {
      under.Add(piece.place(), n, heights[0], weights[0]);
    }
  }
  std::array<PlaneMean::Push, PlaneMean::kMostPushes> pushes;
  const std::size_t count = under.Resolve(ridges, pushes);
  return std::any_of(pushes.begin(), pushes.begin() + static_cast<std::ptrdiff_t>(count),
                     [](const PlaneMean::Push& push) {
                       return push.gap < kRefinedClearance && push.share > 0;
                     });
}

TEST(ContactSieve, LetsEveryVertexThroughThatPushesAndNotManyOthers) {
  const Clutter map;
  SurfaceWindow window(map.voxmap, map.details);
  NearPieces near(map.voxmap, map.details, kCells);
  std::mt19937_64 random(6);
  int pushed = 0, asked = 0, let_through = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    for (const SievedPoint& point : PointsAbout(map.edges, random)) {
      const NearPieces::Cell& surface = near.About(point.voxel_V, Field::kSurface);
      if (surface.too_many()) continue;
      const bool may = MayStand(surface, point);
      const bool pushes = Pushes(window, point);
      ++asked;
      pushed += pushes;
      let_through += may;
      ASSERT_TRUE(may || !pushes) << "trial " << trial;
    }
  }
  EXPECT_GT(pushed, 2000);
  EXPECT_LT(let_through, 1.6 * pushed);
  std::printf("  of %d vertices %d push, %d were let through\n", asked, pushed, let_through);
}

/// What the sieve says of some points, of all kinds.
std::vector<int> Answers(const Clutter& map, NearPieces& near) {
  std::mt19937_64 random(4);
  std::vector<int> said;
  for (int trial = 0; trial < 300; ++trial) {
    const std::vector<SievedPoint> points = PointsAbout(map.edges, random);
    for (const Field field : {Field::kEdge, Field::kSurface, Field::kVertex}) {
      for (const SievedPoint& point : points) {
        const NearPieces::Cell& cell = near.About(point.voxel_V, field);
        const Vec3 tangent = point.nhat.unitOrthogonal();
        said.push_back(cell.too_many()         ? -1
                       : field == Field::kEdge ? MayLean(cell, point, {tangent, 0.6, EdgeArc(0.6)})
                       : field == Field::kSurface ? MayStand(cell, point)
                                                  : static_cast<int>(MayBear(cell, point)));
      }
    }
  }
  return said;
}

TEST(ContactSieve, SaysTheSameOnEveryProcessor) {
  const Clutter map;
  std::vector<std::vector<int>> answers;
  const std::int64_t supported = hwy::SupportedTargets();
  for (std::int64_t left = supported; left != 0; left &= left - 1) {
    hwy::SetSupportedTargetsForTest(left & -left);
    NearPieces near(map.voxmap, map.details, kCells);
    answers.push_back(Answers(map, near));
  }
  hwy::SetSupportedTargetsForTest(0);
  ASSERT_GE(answers.size(), 2U);
  EXPECT_GT(std::count(answers.front().begin(), answers.front().end(), 1), 1000);
  for (const std::vector<int>& said : answers) EXPECT_EQ(said, answers.front());
}

TEST(NearPieces, FindsAgainWhatThereWasNoRoomFor) {
  const Clutter map;
  NearPieces roomy(map.voxmap, map.details, 20000);
  const std::vector<int> expected = Answers(map, roomy);
  for (const std::size_t cells : {1U, 7U, 100U}) {
    NearPieces near(map.voxmap, map.details, cells);
    EXPECT_EQ(Answers(map, near), expected) << cells << " cells";
  }
}

TEST(NearPieces, SaysWhereThereAreMoreThanItCanKeep) {
  // sheets a third of a voxel apart: each of some 40 voxels about a cell has several edges
  TriangleMesh mesh;
  for (int i = 0; i < 40; ++i) {
    const Vec3 place = kS * Vec3(0.35 * i, 0.1 * i, 0.2 * i);
    Append(mesh,
           Transformed(Box(kS * Vec3(0.3, 30, 30)), {RotationBy(0.02 * i * Vec3::UnitX()), place}));
  }
  const Voxmap voxmap =
      std::move(*Voxelize(mesh, {.voxel_size = kS, .flatness_voxels = kFlatness}));
  const SurfaceDetails details(mesh, kFlatness, voxmap);
  NearPieces near(voxmap, details, kCells);
  int too_many = 0;
  const GridIndex size = GridIndex{static_cast<int>(voxmap.header().size[0]),
                                   static_cast<int>(voxmap.header().size[1]),
                                   static_cast<int>(voxmap.header().size[2])} *
                         kHyperchunkSide;
  for (int z = 2; z < size.z; z += NearPieces::kCellSide) {
    for (int y = 2; y < size.y; y += NearPieces::kCellSide) {
      for (int x = 2; x < size.x; x += NearPieces::kCellSide) {
        const NearPieces::Cell& cell = near.About({x, y, z}, Field::kSurface);
        std::size_t pieces = 0;
        VisitPieces<false>(voxmap, details, GridIndex{x, y, z} - GridIndex{3, 3, 3},
                           GridIndex{x, y, z} + GridIndex{2, 2, 2}, {}, Field::kSurface,
                           [&](const GridIndex&, const SurfaceDetail&, bool) {
                             ++pieces;
                           });
        EXPECT_EQ(cell.too_many(), pieces > NearPieces::kMostSources);
        EXPECT_EQ(cell.all().empty(), cell.too_many() || pieces == 0);
        too_many += cell.too_many();
      }
    }
  }
  EXPECT_GT(too_many, 0);
}

}  // namespace
}  // namespace tandem
