#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "engine/contact/clear_region.h"
#include "engine/contact/contact_model.h"
#include "engine/contact/edge_contact.h"
#include "engine/contact/near_pieces.h"
#include "engine/contact/plane_mean.h"
#include "engine/contact/region_budget.h"
#include "engine/contact/surface_window.h"
#include "engine/voxel/pointshell.h"

namespace tandem {

/// Contacts between exact features, to a small part of a voxel (decision 0010):
///
///   vertex of the shell | surface of the map  | along the map's surface normal
///   edge of the shell   | edge of the map     | along the cross product of the two edges
///   surface of the shell| vertex of the map   | along the shell's surface normal
///
/// Contact begins when the exact features are kRefinedClearance apart. Features are found to a
/// quarter of a voxel, so that a smooth surface bulges less than half a voxel beyond its feature
/// vertices, and force begins before exact surfaces meet. Edges say both their faces.
///
/// A vertex against surface voxels takes a mean of their planes, by how squarely it stands over
/// each: exact over a plane, continuous over edges and curves. A vertex of the map is met by
/// several points of the shell's surface, and makes one contact with the mean of their planes. Two
/// edges make one contact, in the voxels where they come closest. Features that face the same way
/// do not touch: they are on the far sides of thin walls. Deeper in than the map knows its surface,
/// the plain depth goes on.
///
/// Most points within the force layer are not in contact. For those it finds where else they are
/// not either (ClearRegion), so that they need not be looked at while they are there, and how far
/// surfaces may come nearer before they leave (slack). A point is judged by the pieces of surface
/// within one voxel of its own; those at two voxels count as well, from when they can come within
/// one. All a lower bound, so contacts are the same with and without.
///
/// A vertex of the map that some points of the shell's surface are high above and others are not
/// is the business of all of them: points that are high are passed over unless there is one such.
///
/// Candidates are looked at each by itself, which several threads may share, and what that gave is
/// taken in their order. No call allocates.
class RefinedContacts {
 public:
  /// `most` candidates at a time, looked at by `threads`; `least_radius` is the lesser of the
  /// moving bodies' radii, m. Candidates' places and their voxels may differ by `place_error`.
  RefinedContacts(const Pointshell& shell, const Voxmap& voxmap, const SurfaceDetails& details,
                  double least_radius, double place_error, std::size_t most, int threads = 1);

  /// Looks at a frame's candidates [begin, end) that are not known to be clear, exactly or by a
  /// sieve; `R_VS` turns from the shell's frame to V. `out` is that of Take(). `turned`: how far
  /// the bodies have turned against one another in all, rad; null to look at each exactly and
  /// remember nothing. `thread`: the calling one's number.
  void LookAt(std::span<Candidate> candidates, std::size_t begin, std::size_t end, const Mat3& R_VS,
              double layers, const double* turned, int thread, Contact* out) noexcept;
  /// The contacts of a frame's candidates, all of which have been looked at; `out` has room for
  /// RoomFor(candidates) contacts. One thread.
  std::size_t Take(std::span<const Candidate> candidates, const Mat3& R_VS, Contact* out) noexcept;
  /// Of the last frame's candidates, those that were passed over; without a look.
  std::size_t clear_count() const noexcept { return clear_count_; }
  /// To be told after each frame in which something was remembered: how many points were
  /// candidates, and how many others were not, as their slack was known.
  void CountKnown(std::size_t candidates, std::size_t others) noexcept {
    budget_.Count(candidates, unknown_count_, candidates - unknown_count_ + others, made_count_);
  }
  static std::size_t RoomFor(std::size_t candidates) {
    return kPerPoint * (candidates + MostVertices(candidates));
  }

 private:
  static constexpr std::size_t kPerPoint = 4;  // contacts of one point, at most
  /// Added in found_ to a number of contacts: bears on vertices of the map, which are met in order;
  /// may do so, but is high above all of them; passed over; without a look; was given a region.
  static constexpr std::uint8_t kBears = 128;
  static constexpr std::uint8_t kHigh = 64;
  static constexpr std::uint8_t kClear = 32;
  static constexpr std::uint8_t kKnown = 16;
  static constexpr std::uint8_t kMade = 8;  // a region
  static std::size_t MostVertices(std::size_t candidates) { return 2 * candidates + 32; }

  /// A vertex of the map and what the shell's surface says of it.
  struct MetVertex {
    GridIndex voxel;
    Vec3 q = Vec3::Zero();
    PlaneMean faces;          // of the shell
    std::uint32_t ridge = 0;  // 1 + number in met_ridges_ of its last
  };
  /// The faces' normals of an edge of the shell that says something of a vertex of the map.
  struct MetRidge {
    std::array<Vec3, 2> normals;
    std::uint32_t before = 0;  // as MetVertex::ridge
  };
  /// A piece of surface under a vertex of the shell.
  struct Standing {
    std::size_t sides = 1;
    std::array<Vec3, 2> normals;  // a ridge's two; otherwise the first
    std::array<double, 2> heights{};
    std::array<double, 2> squares_beside{};
    std::array<double, 2> weights{};
    std::array<bool, 2> facing{};
  };

  /// What a thread looks at a candidate with.
  struct alignas(64) Scratch {
    SurfaceWindow window;
    PlaneMean under;  // what a vertex stands over
    PlaneMean::Ridges ridges;
    ClearRegionMaker clear;
    NearPieces pieces;
    std::vector<std::uint32_t> left;  // candidates for the sieve
  };

  ShellEdge EdgeAt(const Candidate& candidate, const Mat3& R_VS) const noexcept;
  /// The faces of the shell at a point: inward normals, of an edge two, otherwise one.
  struct Faces {
    std::array<Vec3, 2> nhat;
    std::size_t count = 1;
  };
  Faces FacesAt(const Candidate& candidate, const Mat3& R_VS) const noexcept;
  /// Whether they say something of the map's vertices: those of a surface point, and of a sharp
  /// edge.
  bool SaysFaces(const Candidate& candidate) const noexcept;
  /// A face of the shell over a vertex of the map.
  struct Over {
    Vec3 q;         // the vertex
    double height;  // of the vertex above the shell's surface
    double square_beside;
    double weight;
  };
  static Over StandUnder(const SurfaceWindow::Piece& piece, const Vec3& p,
                         const Vec3& nhat) noexcept;
  Standing StandOn(const SurfaceWindow::Piece& piece, const Vec3& p,
                   const Vec3& nhat) const noexcept;

  static bool IsHigh(double height) noexcept;
  /// How far beside the point the vertex is at least when the shell has turned by `turn`.
  static double BesideAfter(const Over& over, double turn) noexcept;
  /// Tells when a vertex can be pushed by what it stands on; not before it has gone by `way`.
  static void TellStanding(const Standing& on, bool two_sided, double way,
                           ClearRegionMaker& clear) noexcept;

  /// kMade, or 0 if it may make a contact wherever it goes.
  std::uint8_t Remember(Candidate& candidate, double turned, const Scratch& scratch,
                        ClearRegion& region) const noexcept;
  /// Looks at those of scratch.left that a sieve lets through.
  void SiftAll(std::span<Candidate> candidates, const Mat3& R_VS, double layers, Scratch& scratch,
               Contact* out) noexcept;
  /// As found_: what a sieve says of a candidate's faces.
  std::uint8_t SiftFaces(const Candidate& candidate, const Mat3& R_VS,
                         NearPieces& pieces) const noexcept;
  /// Whether a sieve lets a vertex or an edge of the shell through.
  bool MayPush(const Candidate& candidate, const Mat3& R_VS, NearPieces& pieces) const noexcept;
  /// Gives contacts into `out`, and into found_, how many.
  std::uint8_t MeetOne(Candidate& candidate, const Mat3& R_VS, double layers, Scratch& scratch,
                       Contact* out) noexcept;
  /// Nothing when no piece of surface is near.
  std::optional<std::size_t> MeetSurface(const Candidate& candidate, Scratch& scratch,
                                         Contact* out) noexcept;
  /// kBears, kHigh, or 0 if a point of the shell's surface says nothing of any vertex of the map.
  std::uint8_t BearOnVertices(const Candidate& candidate, Scratch& scratch) noexcept;
  /// The same of an edge's faces, as it stands or turns within a region's turn. One that says
  /// something is looked at in every frame.
  std::uint8_t BearFaces(const Candidate& candidate, const Faces& faces, Scratch& scratch) noexcept;
  /// What the faces at a point of the shell say of a vertex of the map.
  struct Bearing {
    Vec3 q;  // the vertex
    std::array<Vec3, 2> normals;
    std::array<double, 2> heights{};
    std::array<double, 2> weights{};
    std::array<bool, 2> facing{};
    bool high = true;
  };
  /// Calls visit(piece, bearing) for the vertices that a point of the shell bears on.
  template <class Visit>
  void BearOn(const Candidate& candidate, const Faces& faces, const Visit& visit) noexcept;
  void MeetVertices(std::span<const Candidate> candidates, const Mat3& R_VS) noexcept;
  void AddMetRidge(const std::array<Vec3, 2>& normals, MetVertex& met) noexcept;
  std::size_t MeetEdges(const Candidate& candidate, const Mat3& R_VS, Scratch& scratch,
                        Contact* out) noexcept;
  std::size_t TakeVertices(Contact* out) noexcept;
  std::size_t SlotFor(const GridIndex& voxel) const noexcept;
  void FindOrAdd(const GridIndex& voxel, const Vec3& q) noexcept;

  /// Calls tell(piece, way) for the pieces beyond one voxel that come within it when the point goes
  /// as far as the region may reach.
  template <class Tell>
  void TellRound(const Candidate& candidate, Field field, Scratch& scratch,
                 const Tell& tell) noexcept;
  /// Whether a candidate is known to make no contact where it is; then what goes into found_.
  bool StandsClear(Candidate& candidate, double turned, std::uint8_t& found) const noexcept;
  /// How far surfaces may come nearer before a candidate may leave its region, voxels.
  double SlackIn(const ClearRegion& region, const Candidate& candidate,
                 double turned) const noexcept;

  const Pointshell* shell_;
  const Voxmap* voxmap_;
  double s_;
  double turn_;                       // rad, the most that bodies turn for a voxel of travel
  double most_turn_;                  // rad that a region allows for
  double place_error_;                // voxels
  std::vector<Scratch> scratch_;      // of each thread
  std::vector<std::uint8_t> found_;   // contacts of each candidate, and what it is
  std::vector<ClearRegion> regions_;  // of each candidate, if it was found in this frame
  std::vector<ClearRegion> known_;    // by the last digits of the point
  std::size_t clear_count_ = 0;
  RegionBudget budget_;
  std::size_t unknown_count_ = 0;  // of the last frame's candidates
  std::size_t made_count_ = 0;     // regions
  std::size_t frame_ = 0;
  std::vector<std::uint32_t> slots_;  // a table by voxel: 1 + number in met_
  std::vector<MetVertex> met_;
  std::vector<std::uint32_t> used_slots_;
  std::size_t met_count_ = 0;
  std::vector<MetRidge> met_ridges_;
  std::size_t met_ridge_count_ = 0;
};

}  // namespace tandem
