#include "engine/field/build/face_tree.h"

#include <algorithm>
#include <cmath>

#include "engine/field/build/near_faces.h"
#include "engine/geometry/exact/tree_pair.h"
#include "engine/geometry/mesh/closest_on_triangle.h"

namespace tandem {

namespace {

Vec3 PlaceAt(const GridIndex& node) {
  return {static_cast<double>(node.x), static_cast<double>(node.y), static_cast<double>(node.z)};
}

}  // namespace

FaceTree::FaceTree(const std::vector<FieldFace>& faces) : faces_(faces) {
  std::vector<Bounds> boxes(faces.size());
  for (std::size_t i = 0; i < faces.size(); ++i) {
    for (const Vec3& corner : faces[i].corners_L) boxes[i].Add(corner);
  }
  tree_ = BuildBoxTree(boxes, 4);
}

double FaceTree::Nearest(const Vec3& place_L, double below) const {
  double nearest = below;
  VisitNearLeaves(tree_, place_L, nearest * nearest, [&](const BoxTree::Node& leaf) {
    for (std::uint32_t i = leaf.first; i < leaf.first + leaf.count; ++i) {
      const auto& [a, b, c] = faces_[tree_.order[i]].corners_L;
      nearest = std::min(nearest, (ClosestOnTriangle(a, b, c, place_L).point - place_L).norm());
    }
    return nearest * nearest;
  });
  return nearest;
}

float FarNodes::DistanceOf(const GridIndex& node) {
  if (distances_.empty()) {
    distances_.assign(static_cast<std::size_t>(kSide * kSide * kSide), kNotMeasured);
  }
  float& distance =
      distances_[static_cast<std::size_t>(node.x + kSide * (node.y + kSide * node.z))];
  if (distance == kNotMeasured) {
    // the distance grows at most as fast as the way
    constexpr double kRounding = 1e-6;
    const double most = distance_of_last_ + (PlaceAt(node) - PlaceAt(last_)).norm() + kRounding;
    distance_of_last_ = faces_.Nearest(PlaceAt(first_ + node), most);
    last_ = node;
    distance = static_cast<float>(distance_of_last_);
  }
  return distance;
}

std::array<float, kBrickNodes> FarNodes::InBrick(std::size_t brick) {
  std::array<float, kBrickNodes> values;
  values.fill(std::numeric_limits<float>::max());
  MeasureBeyond(brick, values);
  return values;
}

bool FarNodes::MeasureBeyond(std::size_t brick, std::array<float, kBrickNodes>& values) {
  constexpr float kInPlane = 1e-3F;
  const GridIndex lowest = BlockCell(brick) * kBrickCells;
  bool nearer = false;
  std::size_t node = 0;
  for (std::int32_t z = 0; z <= kBrickCells; ++z) {
    for (std::int32_t y = 0; y <= kBrickCells; ++y) {
      for (std::int32_t x = 0; x <= kBrickCells; ++x, ++node) {
        if (values[node] < HyperbrickSurvey::kReach) continue;
        const float distance = DistanceOf(lowest + GridIndex{x, y, z});
        nearer = nearer || std::abs(values[node] - distance) > kInPlane;
        values[node] = distance;
      }
    }
  }
  return nearer;
}

}  // namespace tandem
