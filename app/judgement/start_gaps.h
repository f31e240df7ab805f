#pragma once

#include <functional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "engine/contact/field/pressed_depth.h"
#include "engine/geometry/mesh/triangle_mesh.h"
#include "engine/scene/scene.h"
#include "engine/world/world_model.h"

namespace tandem {

/// Two bodies so near to one another at the start that they push or overlap.
struct StartGap {
  std::string moving;   // body of the scene
  std::string other;    // body of the scene, fixed or moving
  double distance = 0;  // m, between the surfaces; 0 where they touch or overlap
  double depth = 0;     // m, deepest point of one in the other; 0: none was found
  bool overlap = false;
  double needed = 0;         // m, gap that GapNeeded() tells
  double voxel_fits = 0;     // m, the largest voxel by which the two do not push; 0: none does
  double pressed = 0;        // m, how deep a hand may press the two into one another
  double voxel_decides = 0;  // m, the largest voxel at which that is at most half the gap; 0: none
};

/// The findings on all pairs of a scene.
struct StartGaps {
  std::vector<StartGap> gaps;  // the nearest first
  std::size_t unseen = 0;      // pairs for which no time was left
};

/// Returns the largest gap (m) between exact surfaces at which the scene's contact model can push,
/// for a body that is shifted inward by `inward_shift_voxels`. Below 0 it is a depth that the
/// surfaces may have in one another. In the plain model it is a bound: a point stands up to half a
/// voxel's diagonal beside its surface, and so does the surface in its voxel.
double ContactBegins(const Scene& scene, double inward_shift_voxels) noexcept;

/// Returns the gap (m) that a part needs on every side so that opposite sides do not press it.
/// Refined contact begins nearer where a fit is narrow (decision 0053), so the part needs less than
/// ContactBegins() tells.
double GapNeeded(const Scene& scene, double inward_shift_voxels) noexcept;

/// Returns how contact of a moving body of the scene gives way.
ContactYield YieldOf(const Scene& scene, double inward_shift_voxels) noexcept;

/// The time for which a program examines pairs before it starts, s.
inline constexpr double kStartGapSeconds = 1.0;

/// Finds every pair of a moving body with another body that stands nearer at the start than
/// GapNeeded(), or nearer than a hand may press the two into one another (ContactYield). The
/// distance is that of the triangles: no voxel is read. Takes kStartGapSeconds,
/// and the time of what is begun by then: a distance, or a depth of two bodies of 50,000 triangles
/// together.
StartGaps FindStartGaps(const WorldModel& model);
/// Finds the same before points are made, and takes their numbers from the bodies' surfaces.
/// `meshes_W`: every body of the scene, where it stands at first.
StartGaps FindStartGaps(const Scene& scene, const std::vector<TriangleMesh>& meshes_W);
/// Finds the same with given numbers of points of each moving body, as long as there is time.
StartGaps FindStartGaps(const Scene& scene, const std::vector<TriangleMesh>& meshes_W,
                        const std::vector<double>& points,
                        const std::function<bool()>& out_of_time);

/// Returns a line for a person: how near the bodies stand, what contact needs, what to do.
std::string Describe(const StartGap& gap);

nlohmann::ordered_json AsJson(const StartGaps& found);

/// Returns the lines of the first eight gaps, and the number of pairs for which no time was left.
std::vector<std::string> Describe(const StartGaps& found);

/// Says these lines on stderr.
void TellStart(const StartGaps& found);

}  // namespace tandem
