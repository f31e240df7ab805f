#include "engine/geometry/mesh/mass_properties.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <unordered_map>

#include <Eigen/Eigenvalues>

#include "engine/base/check.h"
#include "engine/geometry/mesh/mesh_diagnosis.h"
#include "engine/geometry/mesh/weld.h"

namespace tandem {
namespace {

// Share of the mesh's area that may be missing. A cracked seam of a tessellation stays far below,
// the smallest hole that a person would see is far above.
constexpr double kOpenShare = 1e-4;
// Volume over area^1.5: a sphere has 0.094, a foil of 0.01 mm by 1 m 3.5e-6, a folded sheet 0.
constexpr double kLeastFullness = 1e-8;
/// Share of the diagonal up to which the two sides of a crack are close.
constexpr double kSeam = 1e-5;

/// Mass and its first and second moments about the reference point.
struct Moments {
  double mass = 0;
  Vec3 first = Vec3::Zero();
  Mat3 second = Mat3::Zero();

  /// Adds the simplex of these corners, and of the reference point too if `order` is 3 (a
  /// tetrahedron). Over a simplex of n + 1 corners v_i the mean of x is sum(v_i) / (n + 1), and the
  /// mean of x x^T is (sum(v_i v_i^T) + sum(v_i) sum(v_i)^T) / ((n + 1)(n + 2)).
  void AddSimplex(int order, double amount, const Vec3& a, const Vec3& b, const Vec3& c) {
    const Vec3 sum = a + b + c;
    mass += amount;
    first += (amount / (order + 1)) * sum;
    second += (amount / ((order + 1) * (order + 2))) *
              (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose());
  }
  Vec3 centre() const { return first / mass; }
  /// Returns the mean of x x^T about the centre.
  Mat3 spread() const { return second / mass - centre() * centre().transpose(); }
};

/// Finds the area that is missing for the surface to have no border.
///
/// The border is what remains of the triangles' directed edges when opposite ones cancel. It
/// consists of closed curves. The missing area is the sum of the (vector) areas that they go round.
/// Curves that run along one another, as the two sides of a crack do, count as one.
class Border {
 public:
  explicit Border(const TriangleMesh& mesh, const Vec3& p_MR) {
    std::unordered_map<std::uint64_t, int> times;
    times.reserve(3 * mesh.triangles.size() / 2);
    for (const TriangleMesh::Triangle& t : mesh.triangles) {
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint64_t from = t[k];
        const std::uint64_t to = t[(k + 1) % 3];
        times[std::min(from, to) << 32U | std::max(from, to)] += from < to ? 1 : -1;
      }
    }
    for (const auto& [edge, count] : times) {
      const auto from = static_cast<std::uint32_t>(edge >> 32U);
      const auto to = static_cast<std::uint32_t>(edge);
      if (count != 0 && from != to) edges_.push_back({from, to, count});
    }
    // hash maps have no order in which sums could be repeated
    std::sort(edges_.begin(), edges_.end(), [](const Edge& a, const Edge& b) {
      return a.from != b.from ? a.from < b.from : a.to < b.to;
    });
    for (Edge& edge : edges_) {
      edge.p_RFrom = mesh.vertices[edge.from] - p_MR;
      edge.p_RTo = mesh.vertices[edge.to] - p_MR;
    }
  }

  double EnclosedArea(double seam) const {
    std::vector<FloatPoint> ends;
    for (const Edge& edge : edges_) {
      for (const Vec3& p : {edge.p_RFrom, edge.p_RTo}) {
        ends.push_back(
            {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())});
      }
    }
    const Weld weld = WeldNear(ends, seam);
    TriangleMesh curves;  // each edge as a collapsed triangle, for their connection
    curves.vertices.resize(weld.first_point.size(), Vec3::Zero());
    for (std::size_t i = 0; i < edges_.size(); ++i) {
      const std::uint32_t from = weld.vertex_of_point[2 * i];
      const std::uint32_t to = weld.vertex_of_point[2 * i + 1];
      curves.triangles.push_back({from, to, to});
    }
    const MeshDiagnosis connection = Diagnose(curves);
    std::vector<Vec3> area(connection.bodies, Vec3::Zero());
    for (std::size_t i = 0; i < edges_.size(); ++i) {
      const Edge& edge = edges_[i];
      area[connection.body_of_triangle[i]] += (0.5 * edge.count) * edge.p_RFrom.cross(edge.p_RTo);
    }
    double sum = 0;
    for (const Vec3& a : area) sum += a.norm();
    return sum;
  }

 private:
  struct Edge {
    std::uint32_t from, to;
    int count;  // number of runs from `from` to `to` less those back
    Vec3 p_RFrom = Vec3::Zero(), p_RTo = Vec3::Zero();
  };
  std::vector<Edge> edges_;
};

/// Tells whether all bodies face the same way, except cavities: a body that faces the other way
/// must lie in the box of one that does not. A mesh of so many of both that this takes too long
/// does not.
bool FacesOneWay(const TriangleMesh& mesh, const std::vector<double>& volume_of_triangle,
                 double whole) {
  constexpr std::size_t kMostComparisons = 200'000'000;
  std::size_t comparisons = 0;
  const MeshDiagnosis diagnosis = Diagnose(mesh);
  std::vector<double> volume(diagnosis.bodies, 0.0);
  std::vector<Bounds> bounds(diagnosis.bodies);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const std::uint32_t body = diagnosis.body_of_triangle[t];
    volume[body] += std::copysign(1.0, whole) * volume_of_triangle[t];
    for (std::size_t k = 0; k < 3; ++k) bounds[body].Add(mesh.corner(t, k));
  }
  for (std::size_t i = 0; i < volume.size(); ++i) {
    if (volume[i] >= -1e-6 * std::abs(whole)) continue;
    bool cavity = false;
    for (std::size_t j = 0; j < volume.size() && !cavity; ++j) {
      if (++comparisons > kMostComparisons) return false;
      cavity = volume[j] > 0 && (bounds[j].min.array() <= bounds[i].min.array()).all() &&
               (bounds[i].max.array() <= bounds[j].max.array()).all();
    }
    if (!cavity) return false;
  }
  return true;
}

/// Returns the area from the original corners, so that no shift rounds a small triangle away.
double AreaOf(const TriangleMesh& mesh, std::size_t t) {
  const Vec3 side = mesh.corner(t, 1) - mesh.corner(t, 0);
  return 0.5 * side.cross(mesh.corner(t, 2) - mesh.corner(t, 0)).norm();
}

bool AllPositive(const Mat3& spread) {
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(spread, Eigen::EigenvaluesOnly);
  return solver.info() == Eigen::Success && solver.eigenvalues().minCoeff() > 0;
}

void SetDistribution(const Moments& mass, const Vec3& p_MR, MassProperties& properties) {
  const Mat3 spread = mass.spread();
  properties.p_MBo = p_MR + mass.centre();
  properties.unit_inertia = spread.trace() * Mat3::Identity() - spread;
}

}  // namespace

MassProperties ComputeBoundedMass(const TriangleMesh& boundary) {
  const Vec3 p_MR = BoundsOf(boundary).centre();
  Moments volume;
  for (std::size_t t = 0; t < boundary.triangles.size(); ++t) {
    const Vec3 a = boundary.corner(t, 0) - p_MR;
    const Vec3 b = boundary.corner(t, 1) - p_MR;
    const Vec3 c = boundary.corner(t, 2) - p_MR;
    volume.AddSimplex(3, a.dot(b.cross(c)) / 6, a, b, c);
  }
  MassProperties properties;
  properties.volume = volume.mass;
  properties.solid = volume.mass > 0 && AllPositive(volume.spread());
  if (properties.solid) SetDistribution(volume, p_MR, properties);
  return properties;
}

MassProperties ComputeMassProperties(const TriangleMesh& mesh) {
  const Bounds bounds = BoundsOf(mesh);
  const Vec3 p_MR = bounds.centre();  // near the mesh, so that no large terms cancel
  Moments volume;
  Moments surface;
  std::vector<double> volume_of_triangle;
  volume_of_triangle.reserve(mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3 a = mesh.corner(t, 0) - p_MR;
    const Vec3 b = mesh.corner(t, 1) - p_MR;
    const Vec3 c = mesh.corner(t, 2) - p_MR;
    volume_of_triangle.push_back(a.dot(b.cross(c)) / 6);
    volume.AddSimplex(3, volume_of_triangle.back(), a, b, c);
    surface.AddSimplex(2, AreaOf(mesh, t), a, b, c);
  }
  TANDEM_CHECK(surface.mass > 0);

  MassProperties properties;
  properties.volume = volume.mass;
  properties.solid =
      std::abs(volume.mass) > kLeastFullness * surface.mass * std::sqrt(surface.mass) &&
      AllPositive(volume.spread()) &&
      Border(mesh, p_MR).EnclosedArea(kSeam * bounds.size().norm()) <= kOpenShare * surface.mass &&
      FacesOneWay(mesh, volume_of_triangle, volume.mass);
  SetDistribution(properties.solid ? volume : surface, p_MR, properties);
  return properties;
}

}  // namespace tandem
