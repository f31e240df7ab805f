#include "engine/geometry/mesh/polygon_growth.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numeric>
#include <span>

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include "engine/base/huge_vector.h"

namespace tandem {

namespace {

/// A triangle: twice its area along its normal, and the length of that vector.
struct Facet {
  Vec3 area;
  double norm;
  std::uint32_t polygon;   // number in its body
  std::uint32_t tried_by;  // last polygon that met it
};

/// Data of the whole mesh for growing polygons. Bodies share neither triangles nor vertices, so
/// they can be grown at the same time.
struct Ground {
  const TriangleMesh& mesh;
  const MeshSides& sides;
  double tolerance;
  HugeVector<std::uint32_t> place_of;     // per triangle: its number in its body
  HugeVector<std::uint32_t> holds;        // per vertex: the last polygon that has it
  std::vector<std::uint32_t> polygon_of;  // number in its body
};

/// Sorts numbers by falling size, the lesser number first among equals, by digits of the size's
/// bits. For numbers of one sign these have the same order.
class BySize {
 public:
  void Sort(const HugeVector<Facet>& facets, HugeVector<std::uint32_t>& triangles) {
    entries_.clear();
    std::uint64_t differ = 0;
    for (const std::uint32_t t : triangles) {
      const double size = facets[t].area.squaredNorm();
      entries_.push_back({~std::bit_cast<std::uint64_t>(size), t});
      differ |= entries_.back().key ^ entries_.front().key;
    }
    constexpr unsigned kDigit = 11;
    constexpr std::size_t kFew = 512;
    if (entries_.size() < kFew) {
      std::sort(entries_.begin(), entries_.end(), [](const Entry& a, const Entry& b) {
        return a.key != b.key ? a.key < b.key : a.triangle < b.triangle;
      });
    } else {
      spare_.resize(entries_.size());
      for (unsigned shift = 0; shift < 64; shift += kDigit) {
        constexpr std::uint64_t kMask = (1U << kDigit) - 1;
        if ((differ >> shift & kMask) == 0) continue;
        std::array<std::uint32_t, kMask + 2> first{};
        for (const Entry& e : entries_) ++first[(e.key >> shift & kMask) + 1];
        for (std::size_t d = 1; d < first.size(); ++d) first[d] += first[d - 1];
        for (const Entry& e : entries_) spare_[first[e.key >> shift & kMask]++] = e;
        entries_.swap(spare_);
      }
    }
    for (std::size_t i = 0; i < triangles.size(); ++i) triangles[i] = entries_[i].triangle;
  }

 private:
  struct Entry {
    std::uint64_t key;
    std::uint32_t triangle;
  };
  HugeVector<Entry> entries_;
  HugeVector<Entry> spare_;
};

/// Grows the polygons of one body at a time, one polygon at a time.
class Grower {
 public:
  explicit Grower(Ground& ground) : ground_(ground), tolerance_(ground.tolerance) {}

  /// Grows the polygons of the body's triangles, in rising order. Returns their number.
  std::uint32_t Grow(std::span<const std::uint32_t> triangles) {
    polygons_ = 0;
    triangles_ = triangles;
    together_ = triangles.back() - triangles.front() + 1 == triangles.size();
    facets_.resize(triangles.size());
    seeds_.resize(triangles.size());
    for (std::uint32_t i = 0; i < triangles.size(); ++i) {
      const Corners c = CornersOf(i);
      const Vec3 area = (*c[1] - *c[0]).cross(*c[2] - *c[0]);
      facets_[i] = {.area = area,
                    .norm = area.norm(),
                    .polygon = MeshSides::kNone,
                    .tried_by = MeshSides::kNone};
      seeds_[i] = i;
    }
    by_size_.Sort(facets_, seeds_);
    for (const std::uint32_t seed : seeds_) {
      if (facets_[seed].polygon == MeshSides::kNone) GrowFrom(seed);
    }
    for (std::size_t i = 0; i < triangles.size(); ++i) {
      ground_.polygon_of[triangles[i]] = facets_[i].polygon;
    }
    return polygons_;
  }

 private:
  // triangles are numbered in their body
  using Corners = std::array<const Vec3*, 3>;
  struct Candidate {
    double turn;  // 1 - cos of the angle to the polygon's normal when it was met
    std::uint32_t triangle;
    bool operator<(const Candidate& o) const {  // the queue returns the greatest first
      return turn != o.turn ? turn > o.turn : triangle > o.triangle;
    }
  };

  /// A body's triangles mostly stand together.
  std::uint32_t InMesh(std::uint32_t triangle) const {
    return together_ ? triangles_[0] + triangle : triangles_[triangle];
  }
  std::uint32_t InBody(std::uint32_t triangle) const {
    return together_ ? triangle - triangles_[0] : ground_.place_of[triangle];
  }
  Corners CornersOf(std::uint32_t triangle) const {
    const auto& [a, b, c] = ground_.mesh.triangles[InMesh(triangle)];
    const std::vector<Vec3>& vertices = ground_.mesh.vertices;
    return {&vertices[a], &vertices[b], &vertices[c]};
  }

  void GrowFrom(std::uint32_t seed) {
    area_ = Vec3::Zero();
    moment_ = Vec3::Zero();
    weight_ = 0;
    vertices_.clear();
    members_.clear();
    queue_.clear();
    const Facet& facet = facets_[seed];
    const Corners c = CornersOf(seed);
    flat_n_ = facing_n_ = Normal(facet.area);
    flat_centre_ = *c[0];
    height_ = 0;
    reach_ = 0;
    least_cosine_ = 1;
    Join(seed, facet.area, Moment(facet, c), flat_n_);
    while (!queue_.empty()) {
      const std::uint32_t triangle = queue_.front().triangle;
      std::pop_heap(queue_.begin(), queue_.end());
      queue_.pop_back();
      if (facets_[triangle].polygon == MeshSides::kNone) TryToJoin(triangle);
    }
    ++polygons_;
  }

  static Vec3 Normal(const Vec3& area) {
    const double norm = area.norm();
    return norm > 0 ? Vec3(area / norm) : Vec3::Zero();
  }
  /// Returns centre times area, so that the mean plane goes through the centre of the polygon's
  /// area.
  static Vec3 Moment(const Facet& facet, const Corners& c) {
    return facet.norm / 3.0 * (*c[0] + *c[1] + *c[2]);
  }

  void TryToJoin(std::uint32_t triangle) {
    const Facet& facet = facets_[triangle];
    const Corners c = CornersOf(triangle);
    const Vec3 area = area_ + facet.area;
    const Vec3 moment = moment_ + Moment(facet, c);
    const double weight = weight_ + facet.norm;
    const Vec3 n = Normal(area);
    const Vec3 centre = weight > 0 ? Vec3(moment / weight) : *c[0];
    if (facet.norm > 0 && !(facet.area.dot(n) > 0)) return;
    for (const Vec3* corner : c) {
      if (std::abs((*corner - centre).dot(n)) > tolerance_) return;
    }
    if (!StillFlat(n, centre) || !StillFacing(n)) return;
    Join(triangle, area, moment, n);
  }

  /// Tells whether all vertices so far lie within tolerance of the new plane. While the plane has
  /// hardly moved, the result of the last full check decides.
  bool StillFlat(const Vec3& n, const Vec3& centre) {
    const double turn = (n - flat_n_).norm();
    const double shift = std::abs((centre - flat_centre_).dot(n));
    const double reach = reach_ + (centre - flat_centre_).norm();
    if (height_ + shift + turn * reach <= tolerance_) return true;
    double height = 0;
    double reach_squared = 0;
    for (std::size_t i = 0; i < vertices_.size(); ++i) {
      const Vec3 from_centre = vertices_[i] - centre;
      const double here = std::abs(from_centre.dot(n));
      if (here > tolerance_) {
        // a vertex that is out will likely be out at the next try
        std::swap(vertices_[i], vertices_[i / 2]);
        return false;
      }
      height = std::max(height, here);
      reach_squared = std::max(reach_squared, from_centre.squaredNorm());
    }
    flat_n_ = n;
    flat_centre_ = centre;
    height_ = height;
    reach_ = std::sqrt(reach_squared);
    return true;
  }

  /// Tells whether all triangles so far face with the new normal.
  bool StillFacing(const Vec3& n) {
    if (least_cosine_ - (n - facing_n_).norm() > 0) return true;
    double least = 1;
    for (const std::uint32_t t : members_) {
      const Facet& facet = facets_[t];
      if (facet.norm > 0) least = std::min(least, facet.area.dot(n) / facet.norm);
    }
    if (least <= 0) return false;
    facing_n_ = n;
    least_cosine_ = least;
    return true;
  }

  void Join(std::uint32_t triangle, const Vec3& area, const Vec3& moment, const Vec3& n) {
    Facet& facet = facets_[triangle];
    area_ = area;
    moment_ = moment;
    weight_ += facet.norm;
    facet.polygon = polygons_;
    members_.push_back(triangle);
    if (facet.norm > 0) {
      least_cosine_ = std::min(least_cosine_, facet.area.dot(facing_n_) / facet.norm);
    }
    const std::uint32_t in_mesh = InMesh(triangle);
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t v = ground_.mesh.triangles[in_mesh][k];
      if (ground_.holds[v] != polygons_) {
        ground_.holds[v] = polygons_;
        vertices_.push_back(ground_.mesh.vertices[v]);
        const Vec3 from_centre = vertices_.back() - flat_centre_;
        height_ = std::max(height_, std::abs(from_centre.dot(flat_n_)));
        reach_ = std::max(reach_, from_centre.norm());
      }
      const std::uint32_t across = ground_.sides.NeighborAcross(in_mesh, k);
      if (across == MeshSides::kNone) continue;
      const std::uint32_t other = InBody(across);
      Facet& theirs = facets_[other];
      if (theirs.polygon != MeshSides::kNone || theirs.tried_by == polygons_) continue;
      theirs.tried_by = polygons_;
      const double turn = theirs.norm > 0 ? 1.0 - theirs.area.dot(n) / theirs.norm : 0.0;
      if (turn >= 1.0) continue;
      queue_.push_back({turn, other});
      std::push_heap(queue_.begin(), queue_.end());
    }
  }

  Ground& ground_;
  double tolerance_;
  std::span<const std::uint32_t> triangles_;  // triangles of the body, in the mesh
  bool together_ = false;
  HugeVector<Facet> facets_;
  HugeVector<std::uint32_t> seeds_;
  BySize by_size_;
  std::uint32_t polygons_ = 0;

  // the polygon that grows
  Vec3 area_ = Vec3::Zero();
  Vec3 moment_ = Vec3::Zero();
  double weight_ = 0;
  std::vector<Vec3> vertices_;
  std::vector<std::uint32_t> members_;
  std::vector<Candidate> queue_;  // a heap
  // results of the last full check, and bounds since: for a plane with normal flat_n_ through
  // flat_centre_, and for a normal facing_n_
  Vec3 flat_n_ = Vec3::Zero();
  Vec3 flat_centre_ = Vec3::Zero();
  double height_ = 0;
  double reach_ = 0;
  Vec3 facing_n_ = Vec3::Zero();
  double least_cosine_ = 1;
};

}  // namespace

std::uint32_t GrowPolygons(const TriangleMesh& mesh, const MeshSides& sides, double tolerance,
                           std::vector<std::uint32_t>& polygon_of) {
  std::vector<std::uint32_t> first(sides.bodies() + 1, 0);
  const std::size_t count = mesh.triangles.size();
  for (std::size_t t = 0; t < count; ++t) ++first[sides.BodyOf(t) + 1];
  std::partial_sum(first.begin(), first.end(), first.begin());
  HugeVector<std::uint32_t> by_body(count);
  std::vector<std::uint32_t> next(first.begin(), first.end() - 1);
  Ground ground{.mesh = mesh,
                .sides = sides,
                .tolerance = tolerance,
                .place_of = HugeVector<std::uint32_t>(count),
                .holds = HugeVector<std::uint32_t>(mesh.vertices.size(), MeshSides::kNone),
                .polygon_of = std::vector<std::uint32_t>(count)};
  for (std::uint32_t t = 0; t < count; ++t) {
    const std::uint32_t body = sides.BodyOf(t);
    ground.place_of[t] = next[body] - first[body];
    by_body[next[body]++] = t;
  }
  std::vector<std::uint32_t> polygons(sides.bodies() + 1, 0);
  tbb::enumerable_thread_specific<Grower> growers([&] {
    return Grower(ground);
  });
  tbb::parallel_for(std::size_t{0}, sides.bodies(), [&](std::size_t b) {
    polygons[b + 1] =
        growers.local().Grow(std::span(by_body).subspan(first[b], first[b + 1] - first[b]));
  });
  std::partial_sum(polygons.begin(), polygons.end(), polygons.begin());
  polygon_of = std::move(ground.polygon_of);
  for (std::size_t t = 0; t < count; ++t) polygon_of[t] += polygons[sides.BodyOf(t)];
  return polygons.back();
}

}  // namespace tandem
