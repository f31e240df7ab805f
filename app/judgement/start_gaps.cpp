#include "app/judgement/start_gaps.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <optional>
#include <utility>

#include "app/common/console.h"
#include "app/judgement/penetration_oracle.h"
#include "engine/base/two_digits.h"
#include "engine/base/units.h"
#include "engine/contact/features/edge_contact.h"
#include "engine/geometry/exact/mesh_tree.h"
#include "engine/geometry/exact/winding_number.h"
#include "engine/realtime/clock.h"

namespace tandem {

namespace {

constexpr double kTouching = 0.01;                      // voxels; a smaller distance is no gap
constexpr std::size_t kMostTrianglesForDepth = 50'000;  // limit for both bodies together
constexpr double kMostDepthSamples = 1e5;               // samples of each body
constexpr double kNearlyAll = 0.99;  // share of the gap needed; such a gap is enough
/// Voxels; gap that refined contact needs in a narrow fit. Its force then begins 0.02 from the
/// surface, and the field tells the surface to within 0.02.
constexpr double kRefinedNeeds = 0.05;
constexpr std::size_t kMostLines = 8;

Bounds GrownBox(const Bounds& box, double by) {
  return {box.min - Vec3::Constant(by), box.max + Vec3::Constant(by)};
}

bool LiesWithin(const Bounds& inner, const Bounds& outer) {
  return (outer.min.array() <= inner.min.array()).all() &&
         (inner.max.array() <= outer.max.array()).all();
}

/// Returns the triangles that come into the box, each with vertices of its own.
TriangleMesh PartIn(const Bounds& box, const TriangleMesh& mesh) {
  TriangleMesh part;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    Bounds triangle;
    for (std::size_t k = 0; k < 3; ++k) triangle.Add(mesh.corner(t, k));
    if (!triangle.Overlaps(box)) continue;
    const auto first = static_cast<std::uint32_t>(part.vertices.size());
    for (std::size_t k = 0; k < 3; ++k) part.vertices.push_back(mesh.corner(t, k));
    part.triangles.push_back({first, first + 1, first + 2});
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

/// Returns how deep either lies in the other, m.
double DepthOf(const TriangleMesh& a_W, const TriangleMesh& b_W, double voxel_size) {
  const auto depth_in = [voxel_size](const TriangleMesh& outer_W, const TriangleMesh& inner_W) {
    const double voxel = SampledVoxel(inner_W, voxel_size, kMostDepthSamples);
    return voxel * PenetrationOracle(outer_W, inner_W, voxel).PenetrationVoxels(Pose{});
  };
  return std::max(depth_in(a_W, b_W), depth_in(b_W, a_W));
}

/// One body of a pair.
struct PlacedMesh {
  const TriangleMesh& mesh_W;
  const Bounds& box;  // box of the mesh
};

/// Measures the depth of a pair that touches or crosses, and sets whether that is an overlap.
/// `meet`: one lies in the other, or their surfaces have a point in common.
void MeasureDepth(const Scene& scene, const PlacedMesh& moving, const PlacedMesh& other, bool meet,
                  StartGap& gap) {
  gap.distance = 0;
  const std::size_t size = moving.mesh_W.triangles.size() + other.mesh_W.triangles.size();
  if (size > kMostTrianglesForDepth) {
    // it would take long to find the deepest point
    gap.overlap = meet;
    return;
  }
  gap.depth = DepthOf(moving.mesh_W, other.mesh_W, scene.voxel_size);
  gap.overlap = gap.depth > kTouching * scene.voxel_size;
  if (!gap.overlap) gap.depth = 0;
}

/// The gap that a pair needs, m.
struct Needs {
  double gap = 0;      // GapNeeded()
  double pressed = 0;  // the yield's PressedDepth(); 0: not looked at
  ContactYield yield;

  double Most() const { return std::max(gap, pressed); }
};

/// Returns the gap of a pair; nothing: the bodies stand as far apart as they need. `tree`: tree of
/// the moving body.
std::optional<StartGap> GapOf(const Scene& scene, const PlacedMesh& moving, const MeshTree& tree,
                              const PlacedMesh& other, const Needs& needs) {
  StartGap gap;
  const double needed = needs.gap;
  gap.needed = needed;
  gap.pressed = needs.pressed;
  const double least = kTouching * scene.voxel_size;
  const double reach = std::max(needs.Most(), least);
  const MeshTree near(PartIn(GrownBox(moving.box, reach), other.mesh_W));
  gap.distance = FindClosestPoints(tree, Pose{}, near,
                                   {.at_most = reach, .tolerance = 1e-3 * scene.voxel_size})
                     .distance;
  const bool touch = gap.distance <= least;
  const bool within =
      !touch && (LiesIn(moving.mesh_W, other.mesh_W) || LiesIn(other.mesh_W, moving.mesh_W));
  if (!touch && !within && !(gap.distance < kNearlyAll * needs.Most())) return std::nullopt;
  if (touch || within) {
    MeasureDepth(scene, moving, other, within || gap.distance <= 0, gap);
    // a body shifted inward may lie in the other as deep as its shift
    if (gap.depth <= -needed) return std::nullopt;
  }
  if (gap.distance > 0) {
    gap.voxel_fits = DownToTwoDigits(gap.distance * scene.voxel_size / needed);
    if (needs.pressed > 0) gap.voxel_decides = needs.yield.VoxelThatDecides(gap.distance);
  }
  return gap;
}

/// Examines the pairs of a scene, as long as there is time.
class PairSearch {
 public:
  PairSearch(const Scene& scene, const std::vector<TriangleMesh>& meshes_W,
             const std::vector<double>& points, const std::function<bool()>& out_of_time)
      : scene_(scene), meshes_W_(meshes_W), points_(points), out_of_time_(out_of_time) {
    for (const TriangleMesh& mesh_W : meshes_W) boxes_.push_back(BoundsOf(mesh_W));
  }

  /// Examines a moving body against all fixed bodies and all bodies after it in the scene.
  void Look(std::size_t moving) {
    TriangleMesh whole_W;
    for (std::size_t j = 0; j < scene_.bodies.size(); ++j) {
      if (scene_.WholeOf(j) == moving) Append(whole_W, meshes_W_[j]);
    }
    const Bounds box = BoundsOf(whole_W);
    const double shift = scene_.bodies[moving].inward_shift_voxels;
    std::optional<MeshTree> tree;
    for (std::size_t j = 0; j < scene_.bodies.size(); ++j) {
      const std::size_t other = scene_.WholeOf(j);
      const bool fixed = scene_.bodies[other].fixed;
      if (!fixed && other <= moving) continue;
      const double other_shift = scene_.bodies[other].inward_shift_voxels;
      const bool points_of_other =
          !fixed && scene_.IsPointshell(other, points_[other], moving, points_[moving]);
      const double of_points = points_of_other ? other_shift : shift;
      // a part that is shifted inwards is meant to lie in others
      const ContactYield yield = YieldOf(scene_, of_points);
      const Needs needs{GapNeeded(scene_, of_points), of_points > 0 ? 0 : yield.PressedDepth(),
                        yield};
      const double reach = std::max(needs.Most(), kTouching * scene_.voxel_size);
      if (!GrownBox(box, reach).Overlaps(boxes_[j])) continue;
      if (out_of_time_()) {
        ++found_.unseen;
        continue;
      }
      if (!tree) tree.emplace(whole_W);
      auto gap = GapOf(scene_, {whole_W, box}, *tree, {meshes_W_[j], boxes_[j]}, needs);
      if (!gap) continue;
      gap->moving = scene_.bodies[moving].name;
      gap->other = scene_.bodies[j].name;
      found_.gaps.push_back(*std::move(gap));
    }
  }

  StartGaps Take() {
    std::ranges::stable_sort(found_.gaps, {}, [](const StartGap& gap) {
      return gap.distance - gap.depth;
    });
    return std::move(found_);
  }

 private:
  const Scene& scene_;
  const std::vector<TriangleMesh>& meshes_W_;
  const std::vector<double>& points_;
  const std::function<bool()>& out_of_time_;
  std::vector<Bounds> boxes_;
  StartGaps found_;
};

/// Returns a function that is true once the time for all pairs is over.
std::function<bool()> UntilTimeIsUp() {
  return [begin_ns = MonotonicNowNs()] {
    return ToSeconds(MonotonicNowNs() - begin_ns) > kStartGapSeconds;
  };
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

ContactYield YieldOf(const Scene& scene, double inward_shift_voxels) noexcept {
  return {.contact = scene.contact,
          .force_layer = scene.force_layer,
          .inward_shift_voxels = inward_shift_voxels,
          .voxel_size = scene.voxel_size};
}

double GapNeeded(const Scene& scene, double inward_shift_voxels) noexcept {
  const double begins = ContactBegins(scene, inward_shift_voxels);
  if (scene.contact == ContactModel::kPlain) return begins;
  return std::min(begins, kRefinedNeeds * scene.voxel_size);
}

StartGaps FindStartGaps(const Scene& scene, const std::vector<TriangleMesh>& meshes_W,
                        const std::vector<double>& points,
                        const std::function<bool()>& out_of_time) {
  PairSearch search(scene, meshes_W, points, out_of_time);
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    if (!scene.bodies[i].fixed && scene.WholeOf(i) == i) search.Look(i);
  }
  return search.Take();
}

StartGaps FindStartGaps(const Scene& scene, const std::vector<TriangleMesh>& meshes_W) {
  const std::function<bool()> out_of_time = UntilTimeIsUp();
  std::vector<double> points(scene.bodies.size(), 0.0);
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const std::size_t whole = scene.WholeOf(i);
    if (scene.bodies[whole].fixed) continue;
    const double spacing = scene.bodies[whole].point_spacing_voxels * scene.voxel_size;
    points[whole] += SurfaceArea(meshes_W[i]) / (spacing * spacing);
  }
  return FindStartGaps(scene, meshes_W, points, out_of_time);
}

StartGaps FindStartGaps(const WorldModel& model) {
  std::vector<double> points(model.scene.bodies.size(), 0.0);
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    points[model.object[b]] = model.bodies[b].surface_points;
  }
  return FindStartGaps(model.scene, model.meshes_W, points, UntilTimeIsUp());
}

std::string Describe(const StartGap& gap) {
  const std::string pair = gap.moving + "-" + gap.other + ": ";
  const std::string needed = "contact needs a gap of " + InMillimetres(gap.needed);
  if (gap.overlap) {
    const std::string depth = gap.depth > 0 ? " by " + InMillimetres(gap.depth) : "";
    return pair + (gap.depth > 0 ? "they overlap" : "they touch or overlap") + depth +
           " at the start, so contact throws them apart or jams them: move one by its \"pose\", or "
           "check its \"scale\"";
  }
  if (gap.distance <= 0) {
    return pair + "they touch at the start, " + needed +
           ", so they push one another apart: leave a gap, or give the moving one an "
           "\"inward_shift_voxels\"";
  }
  if (gap.distance >= kNearlyAll * gap.needed) {
    return pair + InMillimetres(gap.distance) + " apart, and a hand may press them up to " +
           InMillimetres(gap.pressed) +
           " into one another at this voxel: the part passes, but only a voxel_m of " +
           InMetres(gap.voxel_decides) + " or less decides whether it fits";
  }
  return pair + InMillimetres(gap.distance) + " apart, " + needed + ": a voxel_m of " +
         InMetres(gap.voxel_fits) +
         " or less fits; with larger voxels the part may jam, or be pressed through a wall";
}

nlohmann::ordered_json AsJson(const StartGaps& found) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (const StartGap& gap : found.gaps) {
    rows.push_back({{"moving", gap.moving},
                    {"other", gap.other},
                    {"distance_mm", 1e3 * gap.distance},
                    {"overlap", gap.overlap},
                    {"depth_mm", 1e3 * gap.depth},
                    {"contact_begins_mm", 1e3 * gap.needed},
                    {"voxel_m_fits", nullptr},
                    {"pressed_mm", 1e3 * gap.pressed},
                    {"voxel_m_decides", nullptr}});
    if (gap.voxel_fits > 0) rows.back()["voxel_m_fits"] = gap.voxel_fits;
    if (gap.voxel_decides > 0) rows.back()["voxel_m_decides"] = gap.voxel_decides;
  }
  return rows;
}

std::vector<std::string> Describe(const StartGaps& found) {
  std::vector<std::string> lines;
  const std::vector<StartGap>& gaps = found.gaps;
  for (std::size_t i = 0; i < std::min(gaps.size(), kMostLines); ++i) {
    lines.push_back(Describe(gaps[i]));
  }
  if (gaps.size() > kMostLines) {
    lines.push_back("and " + WithPlural(gaps.size() - kMostLines, "more pair") + " like these");
  }
  if (found.unseen > 0) {
    lines.push_back("the gaps between bodies at the start were not checked for " +
                    WithPlural(found.unseen, "pair") + ": the time was up");
  }
  return lines;
}

void TellStart(const StartGaps& found) {
  for (const std::string& line : Describe(found)) Say(line);
}

}  // namespace tandem
