#include "scenes/generators/large/machine_parts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <numbers>

#include "engine/base/check.h"

namespace tandem {
namespace {}  // namespace

TriangleMesh Rotated(const TriangleMesh& mesh, const Quat& by) {
  const Mat3 turn = by.toRotationMatrix();
  TriangleMesh turned = mesh;
  for (Vec3& v : turned.vertices) v = turn * v;
  return turned;
}

TriangleMesh Scaled(const TriangleMesh& mesh, double by) {
  TriangleMesh scaled = mesh;
  for (Vec3& v : scaled.vertices) v *= by;
  return scaled;
}

TriangleMesh Tube(double inner, double outer, double bottom, double top, int sides) {
  const double chamfer = 0.2 * (outer - inner);
  return RevolvedRing({{outer - chamfer, bottom},
                       {outer, bottom + chamfer},
                       {outer, top - chamfer},
                       {outer - chamfer, top},
                       {inner + chamfer, top},
                       {inner, top - chamfer},
                       {inner, bottom + chamfer},
                       {inner + chamfer, bottom}},
                      sides);
}

TriangleMesh Gear(const GearShape& shape) {
  // a tooth: root, flank, tip, flank, as parts of its share of the circle
  constexpr std::array<double, 8> kAt = {0.0, 0.12, 0.24, 0.32, 0.40, 0.60, 0.68, 0.76};
  constexpr std::array<double, 8> kHeight = {-1.2, -1.2, -1.1, 0.0, 0.9, 0.9, 0.0, -1.1};
  const double pitch_radius = 0.5 * shape.module * shape.teeth;
  const double round = 0.1 * shape.width;
  std::vector<Loop> loops;
  for (int tooth = 0; tooth < shape.teeth; ++tooth) {
    for (std::size_t k = 0; k < kAt.size(); ++k) {
      const double angle = 2 * std::numbers::pi * (tooth + kAt[k]) / shape.teeth;
      const double r = pitch_radius + shape.module * kHeight[k];
      const Vec3 out(std::cos(angle), std::sin(angle), 0);
      const auto at = [&](double radius, double z) {
        return Vec3(radius * out + Vec3(0, 0, z));
      };
      loops.push_back({at(shape.bore, 0), at(r - 0.3 * shape.module, 0), at(r, round),
                       at(r, shape.width - round), at(r - 0.3 * shape.module, shape.width),
                       at(shape.bore, shape.width)});
    }
  }
  return Skin(loops, SkinEnds::kJoined);
}

TriangleMesh PerforatedPlate(const HoleGrid& grid) {
  const int n = grid.steps_per_side;
  TANDEM_CHECK(grid.hole_radius < 0.5 * grid.pitch && n > 0);
  TriangleMesh mesh;
  const auto add = [&mesh](const Vec3& p) {
    mesh.vertices.push_back(p);
    return static_cast<std::uint32_t>(mesh.vertices.size() - 1);
  };
  // corners on the lines between cells are shared; counted in steps from the plate's corner
  std::map<std::array<int, 3>, std::uint32_t> shared;
  const double step = grid.pitch / n;
  const Vec3 corner(-0.5 * grid.columns * grid.pitch, -0.5 * grid.rows * grid.pitch, 0);
  const auto on_line = [&](int i, int j, int level) {
    const auto [found, fresh] = shared.try_emplace({i, j, level}, 0);
    if (fresh) found->second = add(corner + Vec3(i * step, j * step, level * grid.thickness));
    return found->second;
  };
  const auto quad = [&mesh](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    mesh.triangles.push_back({a, b, c});
    mesh.triangles.push_back({a, c, d});
  };
  for (int row = 0; row < grid.rows; ++row) {
    for (int column = 0; column < grid.columns; ++column) {
      const Vec3 centre = corner + Vec3(column + 0.5, row + 0.5, 0) * grid.pitch;
      std::array<std::vector<std::uint32_t>, 2> hole;
      std::array<std::vector<std::uint32_t>, 2> edge;
      for (int k = 0; k < 4 * n; ++k) {
        // round the cell's border, counter-clockwise from its lowest corner
        const int along = k % n;
        const std::array<int, 2> place = k < n       ? std::array<int, 2>{along, 0}
                                         : k < 2 * n ? std::array<int, 2>{n, along}
                                         : k < 3 * n ? std::array<int, 2>{n - along, n}
                                                     : std::array<int, 2>{0, n - along};
        const double angle =
            2 * std::numbers::pi * (k - 0.5 * n) / (4 * n) - 0.5 * std::numbers::pi;
        const Vec3 rim = centre + grid.hole_radius * Vec3(std::cos(angle), std::sin(angle), 0);
        for (const int level : {0, 1}) {
          const auto side = static_cast<std::size_t>(level);
          edge[side].push_back(on_line(column * n + place[0], row * n + place[1], level));
          hole[side].push_back(add(rim + Vec3(0, 0, level * grid.thickness)));
        }
      }
      const auto count = static_cast<std::size_t>(4 * n);
      for (std::size_t k = 0; k < count; ++k) {
        const std::size_t next = (k + 1) % count;
        quad(edge[1][k], edge[1][next], hole[1][next], hole[1][k]);
        quad(edge[0][next], edge[0][k], hole[0][k], hole[0][next]);
        quad(hole[0][k], hole[1][k], hole[1][next], hole[0][next]);
        const int side = static_cast<int>(k) / n;
        const bool outside = (side == 0 && row == 0) || (side == 1 && column == grid.columns - 1) ||
                             (side == 2 && row == grid.rows - 1) || (side == 3 && column == 0);
        if (outside) quad(edge[0][k], edge[0][next], edge[1][next], edge[1][k]);
      }
    }
  }
  return mesh;
}

TriangleMesh Spring(double radius, double wire_radius, double pitch, int turns, int sides) {
  constexpr int kPointsPerTurn = 12;
  std::vector<Vec3> points;
  for (int k = 0; k <= kPointsPerTurn * turns; ++k) {
    const double turn = static_cast<double>(k) / kPointsPerTurn;
    points.emplace_back(radius * std::cos(2 * std::numbers::pi * turn),
                        radius * std::sin(2 * std::numbers::pi * turn), pitch * turn);
  }
  return Hose(points, wire_radius, 0, sides, 2);
}

TriangleMesh Rack(const RackShape& shape) {
  const int teeth = static_cast<int>(shape.length / shape.tooth_pitch);
  const double margin = 0.5 * (shape.length - teeth * shape.tooth_pitch);
  const double half = 0.5 * shape.length;
  std::vector<Vec2> outline = {{-half, -shape.depth}, {half, -shape.depth}};
  // from the right end to the left: counter-clockwise
  for (int k = teeth - 1; k >= 0; --k) {
    const double x = -half + margin + k * shape.tooth_pitch;
    outline.emplace_back(x + 0.85 * shape.tooth_pitch, -shape.tooth_height);
    outline.emplace_back(x + 0.70 * shape.tooth_pitch, 0);
    outline.emplace_back(x + 0.30 * shape.tooth_pitch, 0);
    outline.emplace_back(x + 0.15 * shape.tooth_pitch, -shape.tooth_height);
  }
  outline.emplace(outline.begin() + 2, half, -shape.tooth_height);
  outline.emplace_back(-half, -shape.tooth_height);
  // Prism draws out along z: up becomes z, and z becomes -y
  TriangleMesh rack = Prism(outline, -0.5 * shape.width, 0.5 * shape.width);
  for (Vec3& v : rack.vertices) v = Vec3(v.x(), -v.z(), v.y());
  return rack;
}

TriangleMesh BoltCircle(int bolts, double circle_radius, double across_flats) {
  const double washer = 0.12 * across_flats;
  const double height = 0.6 * across_flats;
  // corners and the middles of the flats, which the chamfer leaves as they are
  const auto ring = [across_flats](double limit, double z) {
    Loop loop;
    for (int i = 0; i < 12; ++i) {
      const double r =
          std::min(0.5 * across_flats / (i % 2 == 0 ? std::cos(std::numbers::pi / 6) : 1), limit);
      loop.emplace_back(r * std::cos(std::numbers::pi * i / 6),
                        r * std::sin(std::numbers::pi * i / 6), z);
    }
    return loop;
  };
  TriangleMesh bolt = Skin(
      {ring(across_flats, 0), ring(across_flats, 0.85 * height), ring(0.51 * across_flats, height)},
      SkinEnds::kCapped);
  bolt = Moved(bolt, {0, 0, washer + 2 * kSeam});
  const double rim = 0.7 * across_flats;
  Append(bolt, Revolved({{rim, kSeam}, {rim, kSeam + washer}}, 20));
  TriangleMesh mesh;
  for (int k = 0; k < bolts; ++k) {
    const double angle = 2 * std::numbers::pi * k / bolts;
    Append(mesh,
           Moved(bolt, {circle_radius * std::cos(angle), circle_radius * std::sin(angle), 0}));
  }
  return mesh;
}

}  // namespace tandem
