#include "engine/geometry/mesh/round_surfaces.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>
#include <span>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "engine/geometry/mesh/mesh_sides.h"

namespace tandem {

namespace {

constexpr std::size_t kFewestTriangles = 12;
/// The greatest sine of the angle between a cylinder's triangles and its axis.
constexpr double kAlongAxis = 1e-3;
/// The greatest ratio of a triangle's distance from the round surface to the median of all. The
/// distance goes with the square of the triangle's size.
constexpr double kMostUneven = 4.5;

/// A part of a mesh that is smooth from triangle to triangle.
struct SmoothPart {
  std::vector<std::uint32_t> triangles;
  std::vector<std::uint32_t> vertices;  // without repeats, in rising order
  std::vector<std::uint32_t> border;    // two vertices for each of its border's sides
};

/// Solves the least squares of |x - centre| = radius for points in D dimensions, by the linear
/// equations 2 c.x + k = |x|^2 about the points' mean. Nothing: the points do not tell.
template <int D>
struct FittedRound {
  Eigen::Matrix<double, D, 1> centre;
  double radius = 0;
};
template <int D>
std::optional<FittedRound<D>> FitRound(std::span<const Eigen::Matrix<double, D, 1>> points) {
  using Point = Eigen::Matrix<double, D, 1>;
  Point mean = Point::Zero();
  for (const Point& p : points) mean += p / static_cast<double>(points.size());
  double spread = 0;
  for (const Point& p : points) spread += (p - mean).squaredNorm();
  if (!(spread > 0)) return std::nullopt;
  const double scale = std::sqrt(spread / static_cast<double>(points.size()));
  Eigen::Matrix<double, D + 1, D + 1> sums = Eigen::Matrix<double, D + 1, D + 1>::Zero();
  Eigen::Matrix<double, D + 1, 1> right = Eigen::Matrix<double, D + 1, 1>::Zero();
  for (const Point& p : points) {
    Eigen::Matrix<double, D + 1, 1> row;
    row << 2 * (p - mean) / scale, 1.0;
    sums += row * row.transpose();
    right += row * ((p - mean) / scale).squaredNorm();
  }
  const Eigen::LDLT<Eigen::Matrix<double, D + 1, D + 1>> solver(sums);
  if (!(solver.rcond() > 1e-12)) return std::nullopt;
  const Eigen::Matrix<double, D + 1, 1> found = solver.solve(right);
  const Point centre = found.template head<D>();
  const double squared = found[D] + centre.squaredNorm();
  if (!(squared > 0)) return std::nullopt;
  return FittedRound<D>{mean + scale * centre, scale * std::sqrt(squared)};
}

class RoundSearch {
 public:
  RoundSearch(const TriangleMesh& mesh, const RoundSurfaceRules& rules)
      : mesh_(mesh), rules_(rules), sides_(mesh), across_(mesh.triangles.size()) {
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      across_[t] =
          (mesh.corner(t, 1) - mesh.corner(t, 0)).cross(mesh.corner(t, 2) - mesh.corner(t, 0));
    }
  }

  std::vector<RoundSurface> Find() {
    std::vector<RoundSurface> found;
    std::vector<std::uint8_t> seen(mesh_.triangles.size(), 0);
    for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t) {
      if (seen[t] != 0) continue;
      const SmoothPart part = PartFrom(t, seen);
      if (part.triangles.size() < kFewestTriangles) continue;
      std::optional<RoundSurface> round = AsCylinder(part);
      if (!round && part.border.empty()) round = AsSphere(part);
      if (round && round->radius >= rules_.least_radius) found.push_back(*round);
    }
    return found;
  }

 private:
  SmoothPart PartFrom(std::uint32_t first, std::vector<std::uint8_t>& seen) const {
    static const double kSmooth = std::cos(kMostRoundTurn * std::numbers::pi / 180);
    SmoothPart part;
    part.triangles.push_back(first);
    seen[first] = 1;
    for (std::size_t i = 0; i < part.triangles.size(); ++i) {
      const std::uint32_t t = part.triangles[i];
      for (std::uint32_t k = 0; k < 3; ++k) {
        const std::uint32_t other = sides_.NeighborAcross(t, k);
        const bool smooth =
            other != MeshSides::kNone &&
            across_[t].dot(across_[other]) >= kSmooth * across_[t].norm() * across_[other].norm();
        if (!smooth) {
          part.border.push_back(mesh_.triangles[t][k]);
          part.border.push_back(mesh_.triangles[t][(k + 1) % 3]);
        } else if (seen[other] == 0) {
          seen[other] = 1;
          part.triangles.push_back(other);
        }
      }
      for (const std::uint32_t v : mesh_.triangles[t]) part.vertices.push_back(v);
    }
    std::ranges::sort(part.vertices);
    // clang 14 does not compile std::ranges::unique of this library
    part.vertices.erase(std::unique(part.vertices.begin(), part.vertices.end()),
                        part.vertices.end());
    return part;
  }

  std::optional<RoundSurface> AsSphere(const SmoothPart& part) const {
    std::vector<Vec3> points;
    for (const std::uint32_t v : part.vertices) points.push_back(mesh_.vertices[v]);
    const auto fitted = FitRound<3>(points);
    if (!fitted) return std::nullopt;
    RoundSurface sphere{.centre = fitted->centre, .radius = fitted->radius};
    return Fits(part, sphere) ? std::optional(sphere) : std::nullopt;
  }

  std::optional<RoundSurface> AsCylinder(const SmoothPart& part) const {
    // the triangles' normals lie in a plane, across the axis, and point every way in it
    Mat3 spread = Mat3::Zero();
    for (const std::uint32_t t : part.triangles) {
      const double norm = across_[t].norm();
      if (norm > 0) spread += across_[t] * across_[t].transpose() / norm;
    }
    const Eigen::SelfAdjointEigenSolver<Mat3> solver(spread);
    if (solver.info() != Eigen::Success) return std::nullopt;
    const Vec3 shares = solver.eigenvalues() / std::max(spread.trace(), 1e-300);
    if (!(shares[0] < kAlongAxis * kAlongAxis && shares[1] > 0.4)) return std::nullopt;
    const Vec3 axis = solver.eigenvectors().col(0).normalized();
    // across the axis its vertices lie on a circle
    const Vec3 u = solver.eigenvectors().col(1).normalized();
    const Vec3 v = axis.cross(u);
    const Vec3& from = mesh_.vertices[part.vertices.front()];
    std::vector<Eigen::Vector2d> points;
    double low = 0;
    double high = 0;
    for (const std::uint32_t vertex : part.vertices) {
      const Vec3 p = mesh_.vertices[vertex] - from;
      points.emplace_back(p.dot(u), p.dot(v));
      low = std::min(low, p.dot(axis));
      high = std::max(high, p.dot(axis));
    }
    const auto fitted = FitRound<2>(points);
    if (!fitted) return std::nullopt;
    RoundSurface cylinder{.centre = from + fitted->centre.x() * u + fitted->centre.y() * v +
                                    0.5 * (low + high) * axis,
                          .axis = axis,
                          .half_length = 0.5 * (high - low),
                          .radius = fitted->radius};
    // slots, holes and the sharp sides of a flat are borders between its ends
    if (part.border.empty()) return std::nullopt;
    const double end = cylinder.half_length - rules_.most_off;
    for (std::size_t i = 0; i < part.border.size(); i += 2) {
      const double first = (mesh_.vertices[part.border[i]] - cylinder.centre).dot(axis);
      const double second = (mesh_.vertices[part.border[i + 1]] - cylinder.centre).dot(axis);
      const bool on_an_end = std::min(first, second) >= end || std::max(first, second) <= -end;
      if (!on_an_end) return std::nullopt;
    }
    return Fits(part, cylinder) ? std::optional(cylinder) : std::nullopt;
  }

  /// Returns whether the part keeps the rules as an approximation of the surface; sets its sagitta.
  bool Fits(const SmoothPart& part, RoundSurface& round) const {
    const auto from_middle = [&round](const Vec3& p) -> Vec3 {
      const Vec3 from = p - round.centre;
      return from - from.dot(round.axis) * round.axis;
    };
    for (const std::uint32_t v : part.vertices) {
      const double off = from_middle(mesh_.vertices[v]).norm() - round.radius;
      if (!(std::abs(off) <= rules_.most_off)) return false;
    }
    std::vector<double> sagittas;
    for (const std::uint32_t t : part.triangles) {
      const double norm = across_[t].norm();
      if (!(norm > 0)) continue;
      const double height = std::abs(from_middle(mesh_.corner(t, 0)).dot(across_[t])) / norm;
      sagittas.push_back(std::max(0.0, round.radius - height));
    }
    if (sagittas.empty()) return false;
    round.sagitta = std::ranges::max(sagittas);
    const auto middle = sagittas.begin() + static_cast<std::ptrdiff_t>(sagittas.size() / 2);
    std::ranges::nth_element(sagittas, middle);
    return round.sagitta <= rules_.most_sagitta &&
           round.sagitta <= kMostUneven * *middle + rules_.most_off;
  }

  const TriangleMesh& mesh_;
  const RoundSurfaceRules& rules_;
  MeshSides sides_;
  std::vector<Vec3> across_;  // per triangle: normal, as long as twice its area
};

}  // namespace

std::vector<RoundSurface> FindRoundSurfaces(const TriangleMesh& mesh,
                                            const RoundSurfaceRules& rules) {
  if (mesh.triangles.size() > rules.most_triangles) return {};
  return RoundSearch(mesh, rules).Find();
}

}  // namespace tandem
