#include "scenes/generators/large/clutter.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <utility>

#include "engine/base/check.h"
#include "engine/geometry/exact/winding_number.h"
#include "scenes/generators/large/clutter_parts.h"
#include "scenes/generators/large/machine_parts.h"
#include "scenes/generators/large/random_source.h"

// The lattice stands about the origin, where the actuator does:
//
//      z
//      |  +--+--+--+  +--+--+--+
//      |  |  |  |  |  |  |  |  |      a cell holds a part, turned by chance and as large
//      |  +--+--+--+  +--+--+--+      as fits; or it is crossed by a pipe or a beam
//      |  |==beam====|  |  |  |
//      |  +--+--+--+  +--+--+--+
//      |  |  |pipe|  nest |  |  |     the nest and the cells above it are left free
//      |  +--+-||+==[====]=--+--+
//      +------------------------------ x
namespace tandem {
namespace {

const Vec3 kCell(310, 310, 300);
/// Distance of a part from its cell's walls: neighbours are 12 mm apart.
constexpr double kMargin = 6;
constexpr int kNestCells = 4;  // along x

using Place = std::array<int, 3>;

Quat TurnByChance(RandomSource& rng) {
  // evenly over all rotations, by rejection
  while (true) {
    const double x = rng.Uniform(-1, 1);
    const double y = rng.Uniform(-1, 1);
    const double z = rng.Uniform(-1, 1);
    const double w = rng.Uniform(-1, 1);
    const double square = x * x + y * y + z * z + w * w;
    if (square > 0.01 && square <= 1) return Quat(w, x, y, z).normalized();
  }
}

class Bay {
 public:
  explicit Bay(const ClutterShape& shape) : shape_(shape), rng_(shape.seed) {
    const auto& n = shape_.cells;
    TANDEM_CHECK(n[0] >= kNestCells + 2 && n[1] >= 3 && n[2] >= 3);
    taken_.resize(static_cast<std::size_t>(n[0] * n[1] * n[2]), false);
    // the actuator's cells and those above
    const int first = (n[0] - kNestCells) / 2;
    for (int x = first; x < first + kNestCells; ++x) {
      for (int z = n[2] / 2; z < n[2]; ++z) Take({x, n[1] / 2, z});
    }
    nest_ = {first, n[1] / 2, n[2] / 2};
  }

  std::vector<TriangleMesh> Fill() {
    parts_.push_back(ClutterNest());
    const auto& n = shape_.cells;
    const int cells = n[0] * n[1] * n[2];
    for (int k = 0; k < cells / 60; ++k) AddBeam();
    for (int k = 0; k < cells / 45; ++k) AddPipe();
    for (int z = 0; z < n[2]; ++z) {
      for (int y = 0; y < n[1]; ++y) {
        for (int x = 0; x < n[0]; ++x) {
          if (!Taken({x, y, z}) && rng_.Uniform(0, 1) < shape_.filled) AddPart({x, y, z});
        }
      }
    }
    return std::move(parts_);
  }

 private:
  std::size_t IndexOf(const Place& at) const {
    return static_cast<std::size_t>(at[0] + shape_.cells[0] * (at[1] + shape_.cells[1] * at[2]));
  }
  bool Taken(const Place& at) const {
    for (std::size_t k = 0; k < 3; ++k) {
      if (at[k] < 0 || at[k] >= shape_.cells[k]) return true;
    }
    return taken_[IndexOf(at)];
  }
  void Take(const Place& at) { taken_[IndexOf(at)] = true; }

  /// Returns a cell's lowest corner; the nest's cells lie about the origin.
  Vec3 Corner(const Place& at) const {
    const Vec3 steps(at[0] - nest_[0] - 0.5 * kNestCells, at[1] - nest_[1] - 0.5,
                     at[2] - nest_[2] - 0.5);
    return steps.cwiseProduct(kCell);
  }
  Vec3 Middle(const Place& at) const { return Corner(at) + 0.5 * kCell; }

  Place AnyPlace() {
    Place at{};
    for (std::size_t k = 0; k < 3; ++k) at[k] = rng_.Whole(0, shape_.cells[k] - 1);
    return at;
  }

  /// Returns the free cells from `at` along an axis, at most `most`, none when `at` is taken.
  std::vector<Place> FreeRow(Place at, std::size_t axis, int step, int most) const {
    std::vector<Place> row;
    for (int k = 0; k < most && !Taken(at); ++k) {
      row.push_back(at);
      at[axis] += step;
    }
    return row;
  }

  void AddPart(const Place& at) {
    const TriangleMesh made = PartByChance(rng_);
    const TriangleMesh part = Rotated(made, TurnByChance(rng_));
    const Bounds box = BoundsOf(part);
    const Vec3 room = kCell - Vec3::Constant(2 * kMargin);
    const double fit = room.cwiseQuotient(box.size()).minCoeff();
    const double scale = std::min(1.4, fit) * rng_.Uniform(0.6, 1.0);
    const Vec3 slack = room - scale * box.size();
    Vec3 to = Corner(at) + Vec3::Constant(kMargin) - scale * box.min;
    for (int k = 0; k < 3; ++k) to[k] += rng_.Uniform(0, slack[k]);
    parts_.push_back(Moved(Scaled(part, scale), to));
  }

  void AddBeam() {
    const auto axis = static_cast<std::size_t>(rng_.Whole(0, 2));
    const std::vector<Place> row = FreeRow(AnyPlace(), axis, 1, rng_.Whole(3, 8));
    if (row.size() < 3) return;
    for (const Place& at : row) Take(at);
    const double length =
        kCell[static_cast<int>(axis)] * static_cast<double>(row.size()) - 2 * kMargin;
    const double height = rng_.Uniform(60, 120);
    const double width = rng_.Uniform(50, 90);
    TriangleMesh beam = Moved(Beam(length, height, width, rng_), {-0.5 * length, 0, 0});
    if (axis == 1) beam = AlongX(beam);  // x to y, y to z
    if (axis == 2) beam = AlongY(beam);  // x to z, y to x
    parts_.push_back(Moved(beam, 0.5 * (Middle(row.front()) + Middle(row.back()))));
  }

  void AddPipe() {
    // rows of cells, each at a right angle to the last
    std::vector<Place> way = {AnyPlace()};
    if (Taken(way.front())) return;
    Take(way.front());
    int last_axis = -1;
    for (int leg = 0; leg < 4; ++leg) {
      const int axis = rng_.Whole(0, 2);
      if (axis == last_axis) continue;
      const int step = rng_.Whole(0, 1) == 0 ? -1 : 1;
      Place next = way.back();
      next[static_cast<std::size_t>(axis)] += step;
      for (const Place& at :
           FreeRow(next, static_cast<std::size_t>(axis), step, rng_.Whole(3, 5))) {
        way.push_back(at);
        Take(at);
      }
      last_axis = axis;
    }
    if (way.size() < 3) return;
    const double radius = rng_.Uniform(14, 32);
    const Vec3 aside{rng_.Uniform(-25, 25), rng_.Uniform(-25, 25), rng_.Uniform(-25, 25)};
    std::vector<Vec3> points;
    for (const Place& at : way) points.emplace_back(Middle(at) + aside);
    parts_.push_back(PipeRun(points, radius, rng_));
  }

  ClutterShape shape_;
  RandomSource rng_;
  Place nest_{};
  std::vector<bool> taken_;
  std::vector<TriangleMesh> parts_;
};

HandScript ClutterHand() {
  constexpr double kMm = 1e-3;
  HandScript script;
  script.impedance.damping = 20;
  script.X_BD.p = {0.2, 0, 0};
  // lightly down onto the racks, along them, to both sides, and up and out
  script.waypoints = {
      {0.0, {0, 0, 0}, Quat::Identity()},
      {1.0, {0, 0, kMm * -5}, Quat::Identity()},
      {2.5, {kMm * 9, kMm * 1.5, kMm * -5}, Quat::Identity()},
      {4.0, {kMm * -9, kMm * -7, kMm * -4.2}, RotationBy(Vec3(0.03, 0, 0))},
      {5.5, {0, kMm * 7, kMm * -4.2}, RotationBy(Vec3(0, 0.01, 0.01))},
      {7.0, {0, 0, 0}, Quat::Identity()},
      {9.0, {0, 0, kMm * 400}, Quat::Identity()},
  };
  return script;
}

}  // namespace

std::vector<TriangleMesh> ClutterParts(const ClutterShape& shape) {
  return Bay(shape).Fill();
}

double OverlapShare(const std::vector<TriangleMesh>& parts) {
  std::vector<Bounds> boxes;
  for (const TriangleMesh& part : parts) boxes.push_back(BoundsOf(part));
  std::size_t inside = 0;
  std::size_t all = 0;
  for (const TriangleMesh& part : parts) all += part.vertices.size();
  for (std::size_t a = 0; a < parts.size(); ++a) {
    std::vector<bool> counted(parts[a].vertices.size(), false);
    for (std::size_t b = 0; b < parts.size(); ++b) {
      if (a == b || !boxes[a].Overlaps(boxes[b])) continue;
      const WindingNumber other(parts[b]);
      for (std::size_t v = 0; v < counted.size(); ++v) {
        const Vec3& p = parts[a].vertices[v];
        if (counted[v] || SquaredDistance(boxes[b], p) > 0 || other.At(p) < 0.5) continue;
        counted[v] = true;
        ++inside;
      }
    }
  }
  return static_cast<double>(inside) / static_cast<double>(all);
}

double AreaOf(const TriangleMesh& mesh) {
  double area = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3& a = mesh.corner(t, 0);
    area += 0.5 * (mesh.corner(t, 1) - a).cross(mesh.corner(t, 2) - a).norm();
  }
  return area;
}

void PrintSizes(const std::vector<TriangleMesh>& parts, const GeneratedScene& scene) {
  const TriangleMesh& fixed = scene.meshes[0].mesh;
  const TriangleMesh& actuator = scene.meshes[1].mesh;
  const Vec3 size = 1e-3 * BoundsOf(fixed).size();
  std::printf(
      "%s: %zu parts, %zu triangles, %.2f x %.2f x %.2f m, %.1f m^2; actuator: %zu triangles, "
      "%.3f m^2\n",
      scene.name.c_str(), parts.size(), fixed.triangles.size(), size.x(), size.y(), size.z(),
      1e-6 * AreaOf(fixed), actuator.triangles.size(), 1e-6 * AreaOf(actuator));
  std::printf("vertices inside another part: %.4f %%\n", 100 * OverlapShare(parts));
}

GeneratedScene Clutter(const std::vector<TriangleMesh>& parts) {
  TriangleMesh fixed;
  for (const TriangleMesh& part : parts) Append(fixed, part);
  return {"clutter",
          {{"clutter_fixed.stl", std::move(fixed)}, {"clutter_actuator.stl", ClutterActuator()}},
          {{"clutter_hand.json", ClutterHand()}}};
}

}  // namespace tandem
