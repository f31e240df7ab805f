#include "tests/scenes/generators/solid_probe.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <utility>

namespace tandem {
namespace {

constexpr double kColumn = 2;  // width of a column of triangles

std::int64_t CellOf(double x, double size) {
  return static_cast<std::int64_t>(std::floor(x / size));
}

double DistanceToSegment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 ab = b - a;
  const double u = std::clamp(ab.dot(p - a) / std::max(ab.squaredNorm(), 1e-300), 0.0, 1.0);
  return (p - a - u * ab).norm();
}

double DistanceToTriangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 normal = (b - a).cross(c - a);
  const bool above = normal.dot((b - a).cross(p - a)) >= 0 &&
                     normal.dot((c - b).cross(p - b)) >= 0 && normal.dot((a - c).cross(p - c)) >= 0;
  if (above && !normal.isZero()) return std::abs(normal.dot(p - a)) / normal.norm();
  return std::min(
      {DistanceToSegment(p, a, b), DistanceToSegment(p, b, c), DistanceToSegment(p, c, a)});
}

}  // namespace

std::uint64_t SolidProbe::Key(std::int64_t i, std::int64_t j, std::int64_t k) {
  constexpr std::int64_t kOffset = 1 << 20;
  return static_cast<std::uint64_t>(((i + kOffset) << 42) + ((j + kOffset) << 21) + (k + kOffset));
}

SolidProbe::SolidProbe(const TriangleMesh& mesh, double reach) : mesh_(mesh), reach_(reach) {
  for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t) {
    Bounds box;
    for (std::size_t k = 0; k < 3; ++k) box.Add(mesh_.corner(t, k));
    boxes_.push_back(box);
    for (std::int64_t i = CellOf(box.min.x(), kColumn); i <= CellOf(box.max.x(), kColumn); ++i) {
      for (std::int64_t j = CellOf(box.min.y(), kColumn); j <= CellOf(box.max.y(), kColumn); ++j) {
        columns_[Key(i, j, 0)].push_back(t);
      }
    }
    const Vec3 normal =
        (mesh_.corner(t, 1) - mesh_.corner(t, 0)).cross(mesh_.corner(t, 2) - mesh_.corner(t, 0));
    const auto first = [&](int axis) {
      return CellOf(box.min[axis], reach_) - 1;
    };
    const auto last = [&](int axis) {
      return CellOf(box.max[axis], reach_) + 1;
    };
    for (std::int64_t i = first(0); i <= last(0); ++i) {
      for (std::int64_t j = first(1); j <= last(1); ++j) {
        for (std::int64_t k = first(2); k <= last(2); ++k) {
          // a large slanted triangle passes far from most of its box's cells
          const Vec3 corner(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k));
          const Vec3 centre = reach_ * (corner + Vec3::Constant(0.5));
          const double off = std::abs(normal.dot(centre - mesh_.corner(t, 0)));
          if (off <= 1.9 * reach_ * normal.norm()) near_[Key(i, j, k)].push_back(t);
        }
      }
    }
  }
}

bool SolidProbe::Inside(const Vec3& at) const {
  // off the corners and edges of round numbers
  const Vec3 p = at + Vec3(1.2345e-6, 0.7654e-6, 0);
  const auto found = columns_.find(Key(CellOf(p.x(), kColumn), CellOf(p.y(), kColumn), 0));
  if (found == columns_.end()) return false;
  bool inside = false;
  for (const std::uint32_t t : found->second) {
    const Bounds& box = boxes_[t];
    if (p.x() < box.min.x() || p.x() > box.max.x() || p.y() < box.min.y() || p.y() > box.max.y() ||
        p.z() > box.max.z()) {
      continue;
    }
    const Vec3 a = mesh_.corner(t, 0) - p;
    const Vec3 b = mesh_.corner(t, 1) - p;
    const Vec3 c = mesh_.corner(t, 2) - p;
    const double ab = a.x() * b.y() - a.y() * b.x();
    const double bc = b.x() * c.y() - b.y() * c.x();
    const double ca = c.x() * a.y() - c.y() * a.x();
    if (!((ab > 0 && bc > 0 && ca > 0) || (ab < 0 && bc < 0 && ca < 0))) continue;
    if ((bc * a.z() + ca * b.z() + ab * c.z()) / (ab + bc + ca) > 0) inside = !inside;
  }
  return inside;
}

double SolidProbe::Distance(const Vec3& p) const {
  double least = reach_;
  const auto found =
      near_.find(Key(CellOf(p.x(), reach_), CellOf(p.y(), reach_), CellOf(p.z(), reach_)));
  if (found == near_.end()) return least;
  for (const std::uint32_t t : found->second) {
    const Bounds& box = boxes_[t];
    bool far = false;
    for (int k = 0; k < 3; ++k) far |= p[k] < box.min[k] - least || p[k] > box.max[k] + least;
    if (far) continue;
    least = std::min(
        least, DistanceToTriangle(p, mesh_.corner(t, 0), mesh_.corner(t, 1), mesh_.corner(t, 2)));
  }
  return least;
}

std::vector<Vec3> SurfaceSamples(const TriangleMesh& mesh, double spacing) {
  std::vector<Vec3> samples;
  std::set<std::array<std::int64_t, 3>> taken;
  const double cell = 0.5 * spacing;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3& a = mesh.corner(t, 0);
    const Vec3& b = mesh.corner(t, 1);
    const Vec3& c = mesh.corner(t, 2);
    const double longest = std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()});
    const int n = static_cast<int>(std::ceil(longest / cell));
    for (int i = 0; i <= n; ++i) {
      for (int j = 0; i + j <= n; ++j) {
        const Vec3 p = a + (b - a) * i / n + (c - a) * j / n;
        const std::array<std::int64_t, 3> place = {CellOf(p.x(), cell), CellOf(p.y(), cell),
                                                   CellOf(p.z(), cell)};
        if (taken.insert(place).second) samples.push_back(p);
      }
    }
  }
  return samples;
}

Vec3 VolumeCentre(const TriangleMesh& mesh) {
  double volume = 0;
  Vec3 moment = Vec3::Zero();
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3& a = mesh.corner(t, 0);
    const Vec3& b = mesh.corner(t, 1);
    const Vec3& c = mesh.corner(t, 2);
    const double part = a.dot(b.cross(c));
    volume += part;
    moment += part * (a + b + c) / 4;
  }
  return moment / volume;
}

bool ClosedAndTurnedOutward(const TriangleMesh& mesh) {
  std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
  double volume = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    volume += mesh.corner(t, 0).dot(mesh.corner(t, 1).cross(mesh.corner(t, 2)));
    for (std::size_t k = 0; k < 3; ++k) {
      const auto edge = std::make_pair(mesh.triangles[t][k], mesh.triangles[t][(k + 1) % 3]);
      if (!edges.insert(edge).second) return false;
    }
  }
  const bool paired = std::all_of(edges.begin(), edges.end(), [&edges](const auto& edge) {
    return edges.count({edge.second, edge.first}) == 1;
  });
  return paired && volume > 0;
}

}  // namespace tandem
