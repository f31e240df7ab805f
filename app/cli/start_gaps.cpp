#include "app/cli/start_gaps.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "app/cli/penetration_oracle.h"
#include "app/cli/talk.h"
#include "engine/contact/edge_contact.h"
#include "engine/geometry/mesh_tree.h"
#include "engine/geometry/winding_number.h"

namespace tandem {

namespace {

constexpr double kTouching = 0.01;                       // voxels: nearer than that is no gap
constexpr std::size_t kMostTrianglesForDepth = 200'000;  // of two bodies whose depth is worked out
constexpr double kNearlyAll = 0.99;  // of where contact begins: such a gap is enough
constexpr std::size_t kMostLines = 8;

Bounds GrownBox(const Bounds& box, double by) {
  return {box.min - Vec3::Constant(by), box.max + Vec3::Constant(by)};
}

bool LiesWithin(const Bounds& inner, const Bounds& outer) {
  return (outer.min.array() <= inner.min.array()).all() &&
         (inner.max.array() <= outer.max.array()).all();
}

/// The triangles that come into the box.
TriangleMesh PartIn(const Bounds& box, const TriangleMesh& mesh) {
  TriangleMesh part;
  part.vertices = mesh.vertices;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    Bounds triangle;
    for (std::size_t k = 0; k < 3; ++k) triangle.Add(mesh.corner(t, k));
    if (triangle.Overlaps(box)) part.triangles.push_back(mesh.triangles[t]);
  }
  return part;
}

/// Returns whether `inner`, whose surface does not cross that of `outer`, lies inside `outer`.
bool LiesIn(const TriangleMesh& inner, const TriangleMesh& outer) {
  if (inner.triangles.empty() || !LiesWithin(BoundsOf(inner), BoundsOf(outer))) return false;
  const Vec3& p = inner.corner(0, 0);
  double winding = 0;
  for (std::size_t t = 0; t < outer.triangles.size(); ++t) {
    winding += WindingOf(outer.corner(t, 0), outer.corner(t, 1), outer.corner(t, 2), p);
  }
  return winding >= 0.5;
}

/// How deep either lies in the other, m.
double DepthOf(const TriangleMesh& a_W, const TriangleMesh& b_W, double voxel_size) {
  const auto depth_in = [voxel_size](const TriangleMesh& outer_W, const TriangleMesh& inner_W) {
    const double voxel = SampledVoxel(inner_W, voxel_size);
    return voxel * PenetrationOracle(outer_W, inner_W, voxel).PenetrationVoxels(Pose{});
  };
  return std::max(depth_in(a_W, b_W), depth_in(b_W, a_W));
}

/// Two digits, and no more than the value.
double RoundedDown(double value) {
  if (!(value > 0)) return 0;
  const double unit = std::pow(10.0, std::floor(std::log10(value)) - 1);
  return unit * std::floor(value / unit + 1e-3);
}

struct PlacedMesh {
  const TriangleMesh& mesh_W;
  double shift = 0;  // voxels
  bool fixed = false;
};

double AreaOf(const TriangleMesh& mesh) {
  double area = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3 side = mesh.corner(t, 1) - mesh.corner(t, 0);
    area += 0.5 * side.cross(mesh.corner(t, 2) - mesh.corner(t, 0)).norm();
  }
  return area;
}

/// Nothing: contact begins nearer than they stand.
std::optional<StartGap> GapOf(const Scene& scene, const PlacedMesh& moving,
                              const PlacedMesh& other) {
  StartGap gap;
  // of two that move, the one with fewer points, and so about the one of less surface, has them
  const bool points_of_other = !other.fixed && AreaOf(other.mesh_W) < AreaOf(moving.mesh_W);
  const double shift = points_of_other ? other.shift : moving.shift;
  gap.contact_begins = ContactBegins(scene, shift);
  const double reach = std::max(gap.contact_begins, kTouching * scene.voxel_size);
  const Bounds near = GrownBox(BoundsOf(moving.mesh_W), reach);
  if (!near.Overlaps(BoundsOf(other.mesh_W))) return std::nullopt;
  const MeshTree a(moving.mesh_W);
  const MeshTree b(PartIn(near, other.mesh_W));
  const ClosestPoints closest =
      FindClosestPoints(a, Pose{}, b, {.at_most = reach, .tolerance = 1e-3 * scene.voxel_size});
  gap.distance = closest.distance;
  if (closest.distance > kTouching * scene.voxel_size) {
    gap.overlap = LiesIn(moving.mesh_W, other.mesh_W) || LiesIn(other.mesh_W, moving.mesh_W);
    if (!gap.overlap && !(closest.distance < kNearlyAll * gap.contact_begins)) {
      return std::nullopt;
    }
  }
  if (gap.overlap || closest.distance <= kTouching * scene.voxel_size) {
    gap.distance = 0;
    const std::size_t size = moving.mesh_W.triangles.size() + other.mesh_W.triangles.size();
    if (size <= kMostTrianglesForDepth) {
      gap.depth = DepthOf(moving.mesh_W, other.mesh_W, scene.voxel_size);
      gap.overlap = gap.depth > kTouching * scene.voxel_size;
      if (!gap.overlap) gap.depth = 0;
    } else {
      // the deepest point would take long; that they cross is known
      gap.overlap = gap.overlap || closest.distance <= 0;
    }
    // what seats by its inward shift may lie in the other as far as that goes
    if (gap.depth <= -gap.contact_begins) return std::nullopt;
  }
  if (gap.distance > 0) {
    gap.voxel_fits = RoundedDown(gap.distance * scene.voxel_size / gap.contact_begins);
  }
  return gap;
}

std::string InMillimetres(double metres) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.3g mm", 1e3 * metres);
  return text.data();
}

std::string InMetres(double metres) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.2g", metres);
  return text.data();
}

}  // namespace

double ContactBegins(const Scene& scene, double inward_shift_voxels) noexcept {
  const double voxels = scene.contact == ContactModel::kRefined
                            ? kRefinedClearance
                            : std::sqrt(3.0) * (scene.force_layer + 1);
  return (voxels - inward_shift_voxels) * scene.voxel_size;
}

std::vector<StartGap> FindStartGaps(const Scene& scene, const std::vector<TriangleMesh>& meshes_W) {
  std::vector<StartGap> gaps;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    if (scene.bodies[i].fixed || scene.WholeOf(i) != i) continue;
    TriangleMesh whole_W;
    for (std::size_t j = 0; j < scene.bodies.size(); ++j) {
      if (scene.WholeOf(j) == i) Append(whole_W, meshes_W[j]);
    }
    for (std::size_t j = 0; j < scene.bodies.size(); ++j) {
      // a pair of two that move is looked at once
      const std::size_t other = scene.WholeOf(j);
      if (!scene.bodies[other].fixed && other <= i) continue;
      auto gap =
          GapOf(scene, {whole_W, scene.bodies[i].inward_shift_voxels},
                {meshes_W[j], scene.bodies[other].inward_shift_voxels, scene.bodies[other].fixed});
      if (!gap) continue;
      gap->moving = scene.bodies[i].name;
      gap->other = scene.bodies[j].name;
      gaps.push_back(*std::move(gap));
    }
  }
  std::ranges::stable_sort(gaps, {}, [](const StartGap& gap) {
    return gap.distance - gap.depth;
  });
  return gaps;
}

std::string Describe(const StartGap& gap) {
  const std::string pair = gap.moving + "-" + gap.other + ": ";
  const std::string begins = "contact begins at " + InMillimetres(gap.contact_begins);
  if (gap.overlap) {
    const std::string depth = gap.depth > 0 ? " by " + InMillimetres(gap.depth) : "";
    return pair + "they overlap" + depth +
           " at the start, so that contact throws them apart or jams them: move one by its "
           "\"pose\", "
           "or check its \"scale\"";
  }
  if (gap.distance <= 0) {
    return pair + "they touch at the start, " + begins +
           ", so that they push one another apart: leave a gap, or give the one that moves an "
           "\"inward_shift_voxels\"";
  }
  return pair + InMillimetres(gap.distance) + " apart, " + begins + ": voxel_m " +
         InMetres(gap.voxel_fits) +
         " or less fits; by larger voxels the part may jam, or be pressed through a wall";
}

nlohmann::ordered_json AsJson(const std::vector<StartGap>& gaps) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (const StartGap& gap : gaps) {
    rows.push_back({{"moving", gap.moving},
                    {"other", gap.other},
                    {"distance_mm", 1e3 * gap.distance},
                    {"overlap", gap.overlap},
                    {"depth_mm", 1e3 * gap.depth},
                    {"contact_begins_mm", 1e3 * gap.contact_begins},
                    {"voxel_m_fits", nullptr}});
    if (gap.voxel_fits > 0) rows.back()["voxel_m_fits"] = gap.voxel_fits;
  }
  return rows;
}

void TellStart(const std::vector<StartGap>& gaps) {
  for (std::size_t i = 0; i < std::min(gaps.size(), kMostLines); ++i) Say(Describe(gaps[i]));
  if (gaps.size() > kMostLines) {
    Say("and " + Counted(gaps.size() - kMostLines, "more pair") + " like these");
  }
}

}  // namespace tandem
