#include "engine/voxel/ray_parity.h"

#include <algorithm>
#include <cmath>

#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include "engine/base/int128.h"
#include "engine/geometry/mesh_diagnosis.h"

namespace tandem {

namespace {

using Wide = Int128;
constexpr std::int64_t kOne = std::int64_t{1} << kSnapBits;

std::int64_t Centre(std::int32_t voxel) {
  return voxel * kOne + kOne / 2;
}

/// Whether the ray from (u, v) towards rising u crosses the edge a-b of the triangle's shadow; the
/// end of lower v belongs to the edge, the other does not. The same for a-b and b-a.
bool CrossesEdge(std::int64_t u, std::int64_t v, std::int64_t au, std::int64_t av, std::int64_t bu,
                 std::int64_t bv) {
  if ((av > v) == (bv > v)) return false;
  if (av > bv) {
    std::swap(au, bu);
    std::swap(av, bv);
  }
  // the edge's point at height v lies beyond u
  return Wide{au - u} * (bv - av) + Wide{v - av} * (bu - au) > 0;
}

/// A body's part in the count of bodies round a point: 1, or -1 for a cavity.
std::vector<int> Signs(const TriangleMesh& mesh, const MeshDiagnosis& diagnosis) {
  std::vector<double> volumes(diagnosis.bodies, 0.0);
  std::vector<Bounds> boxes(diagnosis.bodies);
  const Vec3 reference = BoundsOf(mesh).centre();
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const std::uint32_t body = diagnosis.body_of_triangle[t];
    const Vec3 a = mesh.corner(t, 0) - reference;
    const Vec3 b = mesh.corner(t, 1) - reference;
    const Vec3 c = mesh.corner(t, 2) - reference;
    volumes[body] += a.dot(b.cross(c)) / 6.0;
    for (std::size_t k = 0; k < 3; ++k) boxes[body].Add(mesh.corner(t, k));
  }
  std::vector<int> signs(diagnosis.bodies, 1);
  for (std::size_t b = 0; b < signs.size(); ++b) {
    if (volumes[b] >= 0) continue;
    for (std::size_t outer = 0; outer < signs.size() && signs[b] > 0; ++outer) {
      if (volumes[outer] > 0 && (boxes[outer].min.array() <= boxes[b].min.array()).all() &&
          (boxes[b].max.array() <= boxes[outer].max.array()).all()) {
        signs[b] = -1;
      }
    }
  }
  return signs;
}

struct Crossing {
  std::uint64_t column;
  double place;  // along the axis, voxel sizes
  std::uint32_t body;

  bool operator<(const Crossing& o) const {
    if (column != o.column) return column < o.column;
    return place != o.place ? place < o.place : body < o.body;
  }
};

}  // namespace

RayParity::RayParity(const TriangleMesh& mesh_W, const std::vector<SnappedTriangle>& triangles) {
  const MeshDiagnosis diagnosis = Diagnose(mesh_W);
  const std::vector<int> signs = Signs(mesh_W, diagnosis);
  std::size_t rays = 0;
  std::size_t leaking = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t a = (axis + 1) % 3;  // u
    const std::size_t b = (axis + 2) % 3;  // v
    Columns& columns = columns_[axis];

    // the columns of voxel centres within the mesh's box
    std::int64_t min_u = INT64_MAX;
    std::int64_t max_u = INT64_MIN;
    std::int64_t min_v = INT64_MAX;
    std::int64_t max_v = INT64_MIN;
    for (const SnappedTriangle& t : triangles) {
      for (const SnappedPoint& p : t) {
        min_u = std::min(min_u, p[a]);
        max_u = std::max(max_u, p[a]);
        min_v = std::min(min_v, p[b]);
        max_v = std::max(max_v, p[b]);
      }
    }
    if (triangles.empty()) continue;
    columns.u0 = static_cast<std::int32_t>(min_u >> kSnapBits);
    columns.v0 = static_cast<std::int32_t>(min_v >> kSnapBits);
    columns.nu = static_cast<std::int32_t>(max_u >> kSnapBits) - columns.u0 + 1;
    columns.nv = static_cast<std::int32_t>(max_v >> kSnapBits) - columns.v0 + 1;

    std::vector<Crossing> crossings;
    for (std::size_t t = 0; t < triangles.size(); ++t) {
      const auto& [p, q, r] = triangles[t];
      const Wide normal_axis =
          Wide{q[a] - p[a]} * (r[b] - p[b]) - Wide{q[b] - p[b]} * (r[a] - p[a]);
      if (normal_axis == 0) continue;
      // slopes of the plane's height along the axis
      const auto w = static_cast<double>(normal_axis);
      const Wide normal_a =
          Wide{q[b] - p[b]} * (r[axis] - p[axis]) - Wide{q[axis] - p[axis]} * (r[b] - p[b]);
      const Wide normal_b =
          Wide{q[axis] - p[axis]} * (r[a] - p[a]) - Wide{q[a] - p[a]} * (r[axis] - p[axis]);
      const double slope_u = -static_cast<double>(normal_a) / w;
      const double slope_v = -static_cast<double>(normal_b) / w;

      const auto [lo_u, hi_u] = std::minmax({p[a], q[a], r[a]});
      const auto [lo_v, hi_v] = std::minmax({p[b], q[b], r[b]});
      for (auto v = static_cast<std::int32_t>(lo_v >> kSnapBits); Centre(v) <= hi_v; ++v) {
        const std::int64_t cv = Centre(v);
        for (auto u = static_cast<std::int32_t>(lo_u >> kSnapBits); Centre(u) <= hi_u; ++u) {
          const std::int64_t cu = Centre(u);
          const bool hit = CrossesEdge(cu, cv, p[a], p[b], q[a], q[b]) ^
                           CrossesEdge(cu, cv, q[a], q[b], r[a], r[b]) ^
                           CrossesEdge(cu, cv, r[a], r[b], p[a], p[b]);
          if (!hit) continue;
          const double place = static_cast<double>(p[axis]) +
                               slope_u * static_cast<double>(cu - p[a]) +
                               slope_v * static_cast<double>(cv - p[b]);
          const std::uint64_t column =
              static_cast<std::uint64_t>(u - columns.u0) +
              static_cast<std::uint64_t>(columns.nu) * static_cast<std::uint64_t>(v - columns.v0);
          crossings.push_back(
              {column, place / static_cast<double>(kOne), diagnosis.body_of_triangle[t]});
        }
      }
    }
    tbb::parallel_sort(crossings.begin(), crossings.end());

    // from crossings of single bodies to where the union's solid begins and ends
    columns.first.assign(
        static_cast<std::size_t>(columns.nu) * static_cast<std::size_t>(columns.nv) + 1, 0);
    std::vector<bool> in_body(diagnosis.bodies, false);
    for (std::size_t i = 0; i < crossings.size();) {
      const std::uint64_t column = crossings[i].column;
      const std::size_t begin = i;
      int round_point = 0;
      for (; i < crossings.size() && crossings[i].column == column; ++i) {
        const std::uint32_t body = crossings[i].body;
        const bool was_inside = round_point > 0;
        round_point += in_body[body] ? -signs[body] : signs[body];
        in_body[body] = !in_body[body];
        if (was_inside != (round_point > 0)) {
          columns.toggles.push_back(crossings[i].place);
          ++columns.first[column + 1];
        }
      }
      bool odd = false;
      for (std::size_t j = begin; j < i; ++j) {
        odd = odd || in_body[crossings[j].body];
        in_body[crossings[j].body] = false;
      }
      ++rays;
      leaking += odd;
      // a solid that never ends is a leak: it ends where it began
      if (round_point > 0 && columns.first[column + 1] % 2 == 1) {
        columns.toggles.pop_back();
        --columns.first[column + 1];
      }
    }
    for (std::size_t c = 1; c < columns.first.size(); ++c) columns.first[c] += columns.first[c - 1];
  }
  leaking_share_ = rays == 0 ? 0.0 : static_cast<double>(leaking) / static_cast<double>(rays);
}

std::span<const double> RayParity::Toggles(std::size_t axis, std::int32_t u, std::int32_t v) const {
  const Columns& columns = columns_[axis];
  u -= columns.u0;
  v -= columns.v0;
  if (u < 0 || v < 0 || u >= columns.nu || v >= columns.nv) return {};
  const std::size_t c = static_cast<std::size_t>(u) +
                        static_cast<std::size_t>(columns.nu) * static_cast<std::size_t>(v);
  return std::span(columns.toggles)
      .subspan(columns.first[c], columns.first[c + 1] - columns.first[c]);
}

void RayParity::AddVotes(const GridIndex& first, std::int32_t side,
                         std::vector<std::uint8_t>& votes) const {
  const std::array<std::int32_t, 3> origin{first.x, first.y, first.z};
  const std::array<std::int64_t, 3> stride{1, side, std::int64_t{side} * side};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t a = (axis + 1) % 3;
    const std::size_t b = (axis + 2) % 3;
    for (std::int32_t v = 0; v < side; ++v) {
      for (std::int32_t u = 0; u < side; ++u) {
        const std::span<const double> toggles = Toggles(axis, origin[a] + u, origin[b] + v);
        for (std::size_t k = 0; k + 1 < toggles.size(); k += 2) {
          // centres i + 1/2 with toggles[k] <= i + 1/2 < toggles[k + 1]
          const double base = origin[axis] + 0.5;
          const auto begin = std::max(0.0, std::ceil(toggles[k] - base));
          const auto end = std::min(static_cast<double>(side), std::ceil(toggles[k + 1] - base));
          for (auto i = static_cast<std::int64_t>(begin); i < static_cast<std::int64_t>(end); ++i) {
            ++votes[static_cast<std::size_t>(i * stride[axis] + u * stride[a] + v * stride[b])];
          }
        }
      }
    }
  }
}

bool RayParity::Inside(const GridIndex& voxel) const {
  const std::array<std::int32_t, 3> place{voxel.x, voxel.y, voxel.z};
  int votes = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::span<const double> toggles =
        Toggles(axis, place[(axis + 1) % 3], place[(axis + 2) % 3]);
    const auto passed = std::upper_bound(toggles.begin(), toggles.end(), place[axis] + 0.5);
    votes += static_cast<int>((passed - toggles.begin()) % 2);
  }
  return votes >= 2;
}

}  // namespace tandem
