// Tests how far parts of sharp edges are said to be from pushing against others, beside every pair
// of parts met as a frame meets them.
#include "engine/contact/features/edge_parts.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "engine/contact/features/edge_contact.h"
#include "tests/engine/contact/refined.h"

namespace tandem {
namespace {

using testing::Box;
using testing::kS;
using testing::RandomRotation;
using testing::SurfaceOf;
using testing::Uniform;

constexpr double kReach = kRefinedClearance;

/// Calls visit(block, lane, edge) for all sharp edge parts of a body.
template <class Visit>
void VisitEdges(const BodyFeatures& features, const Visit& visit) {
  for (std::size_t b = 0; b < features.blocks().size(); ++b) {
    for (unsigned rest = features.blocks()[b].sharp; rest != 0; rest &= rest - 1) {
      const auto lane = static_cast<std::size_t>(std::countr_zero(rest));
      const auto block = static_cast<std::uint32_t>(b);
      visit(block, lane, features.edge(features.point(block, lane).edge));
    }
  }
}

/// Two boxes, of which the one's edges stand in the frame of the other's field at `X_VF`, voxels.
class TwoBoxes {
 public:
  TwoBoxes()
      : map_(SurfaceOf(Box(kS * Vec3(16, 14, 12)), Quat::Identity())),
        shell_(SurfaceOf(Box(kS * Vec3(10, 12, 14)), Quat::Identity())) {}

  /// Returns where the field of the moving box is when its middle stands at `place`, voxels.
  Pose Placed(const Quat& q, const Vec3& place) const {
    const Pose X_VB{q, place + Pose(map_.X_BV).Inverse().p / kS};
    return {X_VB.q, X_VB * Vec3(shell_.X_BV.p / kS)};
  }
  /// Returns the parts of each block of the moving box, judged as a schedule does.
  std::vector<std::vector<EdgePart>> PartsAt(const Pose& X_VF, double enough) const {
    std::vector<std::vector<EdgePart>> parts(shell_.features.blocks().size());
    VisitEdges(shell_.features,
               [&](std::uint32_t block, std::size_t lane, const BodyFeatures::Edge& edge) {
                 const Vec3 middle = X_VF * shell_.features.place(block, lane);
                 const double bound = map_.field.At(middle).value - map_.field.error_bound();
                 parts[block].push_back({.lane = lane,
                                         .middle_V = middle,
                                         .tangent_V = X_VF.q * edge.tangent.cast<double>(),
                                         .half_length = edge.half_length,
                                         .middle_bound = bound,
                                         .gap = bound - edge.half_length - kReach});
               });
    for (std::vector<EdgePart>& of_block : parts) {
      if (of_block.empty()) continue;
      QueryAlong(map_.field, kReach, of_block);
      QueryOtherEdges(map_.features, kReach, enough, of_block);
    }
    return parts;
  }
  /// Tells whether a part pushes against any of the other box's.
  bool Pushes(const Pose& X_VF, std::uint32_t block, std::size_t lane) const {
    const BodyFeatures::Edge& edge = shell_.features.edge(shell_.features.point(block, lane).edge);
    const ShellEdge own{X_VF * edge.middle,
                        X_VF.q * edge.tangent.cast<double>(),
                        -(X_VF.q * edge.outward.cast<double>()),
                        edge.half_length,
                        EdgeArc::FromCosine(edge.cosine),
                        edge.ends != 0,
                        0.5};
    bool pushes = false;
    VisitEdges(map_.features, [&](std::uint32_t, std::size_t, const BodyFeatures::Edge& other) {
      // edges in one another's solid are met where their middles are near one another only
      const double most = kReach + edge.half_length + other.half_length;
      if ((own.p - other.middle).norm() > most) return;
      const EdgeEdgeContact meeting =
          FindEdgeContact(own,
                          {other.middle, other.tangent.cast<double>(), other.outward.cast<double>(),
                           other.half_length, EdgeArc::FromCosine(other.cosine), other.ends != 0},
                          kReach);
      if (!(meeting.share > 0)) return;
      const double depth = std::min(meeting.depth, kReach - map_.field.At(meeting.on_shell).value);
      pushes = pushes || depth > 0;
    });
    return pushes;
  }

 private:
  BodySurface map_;
  BodySurface shell_;
};

TEST(EdgeParts, PushingPartsAreWithinTheirGap) {
  const TwoBoxes boxes;
  std::mt19937_64 random(6);
  int pushing = 0;
  int apart = 0;
  for (int pose = 0; pose < 400; ++pose) {
    const Quat q = RandomRotation(random);
    const Vec3 way =
        Vec3(Uniform(random, -1, 1), Uniform(random, -1, 1), Uniform(random, -1, 1)).normalized();
    const Vec3 place = Uniform(random, 11, 17) * way;
    const Pose X_VF = boxes.Placed(q, place);
    const auto parts = boxes.PartsAt(X_VF, kEdgesEnough);
    for (std::uint32_t block = 0; block < parts.size(); ++block) {
      for (const EdgePart& part : parts[block]) {
        if (part.gap > kEdgesEnough) continue;
        const bool pushes = boxes.Pushes(X_VF, block, part.lane);
        pushing += pushes ? 1 : 0;
        if (pushes) {
          ASSERT_LT(part.gap, 0) << "pose " << pose << ", block " << block;
        }
        if (part.gap <= 0) continue;
        ++apart;
        // nearer, and whichever way
        const Vec3 aside(Uniform(random, -1, 1), Uniform(random, -1, 1), Uniform(random, -1, 1));
        for (const Vec3& to : {Vec3(-way), Vec3(aside.normalized())}) {
          ASSERT_FALSE(
              boxes.Pushes(boxes.Placed(q, place + 0.999 * part.gap * to), block, part.lane))
              << "pose " << pose << ", block " << block << ", gap " << part.gap;
        }
      }
    }
  }
  EXPECT_GT(pushing, 50);
  EXPECT_GT(apart, 500);
}

TEST(EdgeParts, AreDistinguishedFromAdjacentFaces) {
  const TwoBoxes boxes;
  // the middle of each part is 0.7 voxel above a face, and so are its ends
  const Pose X_VF = boxes.Placed(Quat::Identity(), {0, 0, 6 + 7 + 0.7});
  int above = 0;
  int apart = 0;
  for (const std::vector<EdgePart>& of_block : boxes.PartsAt(X_VF, -1)) {
    for (const EdgePart& part : of_block) {
      if (part.middle_bound > 0.71) continue;
      ++above;
      EXPECT_LE(part.gap, 0.7 - kReach);
      apart += part.gap > 0 ? 1 : 0;
    }
  }
  // an interpolated distance may be too great by more near edges and corners
  EXPECT_GT(apart, above / 3);
  EXPECT_GT(above, 30);
}

}  // namespace
}  // namespace tandem
