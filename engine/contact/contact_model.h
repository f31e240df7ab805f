#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "engine/contact/contact_kind.h"
#include "engine/contact/plane_mean.h"
#include "engine/voxel/pointshell.h"
#include "engine/voxel/surface_details.h"
#include "engine/voxel/voxmap.h"

namespace tandem {

/// A point that reads contact in its own field.
struct Candidate {
  std::uint32_t point;
  std::uint32_t edge;  // of an edge point: into Pointshell::edges
  Label label;
  int mark;
  GridIndex voxel_V;
  Vec3 p_V;     // m
  Vec3 nhat_V;  // its inward normal
  /// Told by RefinedContacts: voxels that surfaces may come nearer before this point, which makes
  /// no contact and bears on none, can do so.
  double slack = 0;
};

/// Where two bodies push each other.
struct Contact {
  Vec3 p_V;      // m
  Vec3 nhat_V;   // unit: the way in which the pointshell's body is pushed
  double depth;  // m, above 0
};

/// The paper's contacts: one for each candidate below its tangent plane, along its own normal.
/// Gives how many; `out` has room for as many as there are candidates.
std::size_t FindPlainContacts(std::span<const Candidate> candidates, const Voxmap& voxmap,
                              int layer, Contact* out) noexcept;

/// Contacts between exact features, to a small part of a voxel (VPS.md §4.6):
///
///   vertex of the shell | surface of the map  | along the map's surface normal
///   edge of the shell   | edge of the map     | along the cross product of the two edges
///   surface of the shell| vertex of the map   | along the shell's surface normal
///
/// Contact begins when the exact features are kRefinedClearance apart. Features are found to a
/// quarter of a voxel, so that a smooth surface bulges less than half a voxel beyond its feature
/// vertices, and force begins before exact surfaces meet.
///
/// A vertex against surface voxels takes a mean of their planes, by how squarely it stands over
/// each: exact over a plane, continuous over edges and curves. A vertex of the map is met by
/// several points of the shell's surface, and makes one contact with the mean of their planes. Two
/// edges make one contact, in the voxels where they come closest. Features that face the same way
/// do not touch: they are on the far sides of thin walls. Deeper in than the map knows its surface,
/// the plain depth goes on.
///
/// Most points within the force layer are not in contact. For those it tells how far surfaces may
/// come nearer before they can be (slack), so that they need not be looked at until then; a lower
/// bound, so contacts are the same with and without.
///
/// Used by one thread; Find() does not allocate.
class RefinedContacts {
 public:
  /// `most` candidates at a time; `least_radius` is the lesser of the moving bodies' radii, m.
  RefinedContacts(const Pointshell& shell, const Voxmap& voxmap, const SurfaceDetails& details,
                  double least_radius, std::size_t most);

  /// `R_VS` turns from the shell's frame to V. `out` has room for RoomFor(candidates) contacts.
  std::size_t Find(std::span<Candidate> candidates, const Mat3& R_VS, int layer,
                   Contact* out) noexcept;
  static std::size_t RoomFor(std::size_t candidates) {
    return kPerPoint * (candidates + MostVertices(candidates));
  }

 private:
  static constexpr std::size_t kPerPoint = 4;  // contacts of one point, at most
  static std::size_t MostVertices(std::size_t candidates) { return 2 * candidates + 32; }

  /// Surface voxels near a place, each with its exact surface.
  struct Source {
    GridIndex voxel;
    Vec3 q;  // in voxels of V
    const SurfaceDetail* detail;
  };
  /// A vertex of the map and what the shell's surface says of it.
  struct MetVertex {
    GridIndex voxel;
    Vec3 q = Vec3::Zero();
    PlaneMean faces;  // of the shell
  };

  /// The arc about an edge's own normal in which those of its faces lie, and how a push beside it
  /// fades out.
  struct Arc {
    double half = 0;  // rad
    double cosine = 1;
    double sine = 0;
    double last = 0;   // cosine at which nothing is left of a push
    double scale = 0;  // 1 / (cosine - last)
    explicit Arc(double half_angle = 0);
    /// From its cosine, without a turn through angles.
    static Arc OfCosine(double cosine);
    /// How much of a push counts that has that cosine with the edge's normal.
    double ShareOf(double push_cosine) const noexcept;
  };
  /// The arc of a piece of the map's edge; of a vertex's or an open rim's, a wide one.
  const Arc& ArcOf(const SurfaceDetail& detail) const noexcept {
    const bool ridge = detail.shape() == SurfaceDetail::Shape::kRidge;
    return arcs_[ridge ? detail.half_angle_steps() : SurfaceDetail::kAngles];
  }

  /// The sources of a field within one voxel of a voxel, in sources_; gives how many.
  std::size_t ListSources(const GridIndex& voxel, Field field) noexcept;
  /// Nothing when no piece of surface is near.
  std::optional<std::size_t> MeetSurface(Candidate& candidate, Contact* out) noexcept;
  void MeetVertices(Candidate& candidate) noexcept;
  std::size_t MeetEdges(Candidate& candidate, const Mat3& R_VS, Contact* out) noexcept;
  std::size_t TakeVertices(Contact* out) noexcept;

  const Pointshell* shell_;
  const Voxmap* voxmap_;
  const SurfaceDetails* details_;
  double s_;
  double certainty_;                                  // share of a slack that turns leave
  std::array<Arc, SurfaceDetail::kAngles + 1> arcs_;  // by step; last, the wide one
  std::array<Source, 27> sources_;
  PlaneMean under_;                   // what a vertex stands over
  std::vector<std::uint32_t> slots_;  // a table by voxel: 1 + number in met_
  std::vector<MetVertex> met_;
  std::vector<std::uint32_t> used_slots_;
  std::size_t met_count_ = 0;
};

/// The distance between exact features at which the refined model's force begins, voxels.
inline constexpr double kRefinedClearance = 0.45;

}  // namespace tandem
