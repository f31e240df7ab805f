#include "engine/geometry/exact/winding_number.h"

#include <array>
#include <cmath>

namespace tandem {
namespace {

constexpr double kPi = 3.14159265358979323846;
// A node is a dipole beyond this many radii.
constexpr double kFar = 2.5;

}  // namespace

double WindingOf(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& p) {
  const Vec3 pa = a - p;
  const Vec3 pb = b - p;
  const Vec3 pc = c - p;
  const double la = pa.norm();
  const double lb = pb.norm();
  const double lc = pc.norm();
  const double over = pa.dot(pb.cross(pc));
  const double under = la * lb * lc + pa.dot(pb) * lc + pb.dot(pc) * la + pc.dot(pa) * lb;
  return std::atan2(over, under) / (2.0 * kPi);
}

WindingNumber::WindingNumber(const TriangleMesh& mesh) {
  std::vector<Bounds> boxes(mesh.triangles.size());
  for (std::size_t t = 0; t < boxes.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) boxes[t].Add(mesh.corner(t, k));
  }
  tree_ = BuildBoxTree(boxes, 4);
  triangles_.reserve(boxes.size());
  for (const std::uint32_t t : tree_.order) {
    triangles_.push_back({mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2)});
  }
  // children come after their parents, so a backward loop finds each node's children done
  dipoles_.resize(tree_.nodes.size());
  std::vector<double> areas(tree_.nodes.size(), 0.0);
  for (std::size_t i = tree_.nodes.size(); i-- > 0;) {
    const BoxTree::Node& node = tree_.nodes[i];
    Dipole& dipole = dipoles_[i];
    Vec3 moment = Vec3::Zero();
    const auto add = [&](const Vec3& area_vector, double area, const Vec3& centre) {
      dipole.area += area_vector;
      areas[i] += area;
      moment += area * centre;
    };
    if (node.leaf()) {
      for (std::uint32_t k = node.first; k < node.first + node.count; ++k) {
        const Corners& t = triangles_[k];
        const Vec3 area_vector = 0.5 * (t.b - t.a).cross(t.c - t.a);
        add(area_vector, area_vector.norm(), (t.a + t.b + t.c) / 3.0);
      }
    } else {
      add(dipoles_[i + 1].area, areas[i + 1], dipoles_[i + 1].p);
      add(dipoles_[node.right].area, areas[node.right], dipoles_[node.right].p);
    }
    dipole.p = areas[i] > 0 ? Vec3(moment / areas[i]) : node.box.centre();
    const double radius = (node.box.max - dipole.p).cwiseMax(dipole.p - node.box.min).norm();
    dipole.near_squared = kFar * kFar * radius * radius;
  }
}

double WindingNumber::At(const Vec3& p, std::size_t& steps) const {
  if (tree_.nodes.empty()) return 0;
  double winding = 0;
  std::array<std::uint32_t, BoxTree::kMaxDepth + 1> stack;
  std::size_t depth = 0;
  stack[depth++] = 0;
  while (depth > 0) {
    const std::uint32_t i = stack[--depth];
    const Dipole& dipole = dipoles_[i];
    const Vec3 away = dipole.p - p;
    const double squared = away.squaredNorm();
    if (squared > dipole.near_squared) {
      ++steps;
      winding += dipole.area.dot(away) / (4.0 * kPi * squared * std::sqrt(squared));
      continue;
    }
    const BoxTree::Node& node = tree_.nodes[i];
    if (node.leaf()) {
      steps += node.count;
      for (std::uint32_t k = node.first; k < node.first + node.count; ++k) {
        winding += WindingOf(triangles_[k].a, triangles_[k].b, triangles_[k].c, p);
      }
    } else {
      stack[depth++] = node.right;
      stack[depth++] = i + 1;
    }
  }
  return winding;
}

}  // namespace tandem
