#include "engine/voxel/points/voxel_surface.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <span>

#include "engine/voxel/build/triangles/triangle_clip.h"
#include "engine/voxel/build/triangles/triangle_rows.h"

namespace tandem {

namespace {

/// Share of the summed areas: if the mean normal is shorter, the facets face several ways
/// (docs/decisions/0008-labels.md).
constexpr double kThinSheet = 0.3;

/// A facet's area in a voxel.
struct FacetPart {
  std::int16_t voxel;  // index among those gathered
  Vec3 area;
};

/// The sums of one voxel.
struct Gathered {
  std::size_t count = 0;  // number of facets
  Vec3 moment = Vec3::Zero();
  double weight = 0;
  // place on the last triangle's plane, nearest to the voxel's middle
  Vec3 on_plane = Vec3::Zero();
};

/// Sets one outward normal, or one a side where the facets face apart.
void SetNormals(std::span<const Vec3> areas, VoxelSurface& surface) {
  Vec3 sum = Vec3::Zero();
  double total = 0;
  for (const Vec3& area : areas) {
    sum += area;
    total += area.norm();
  }
  if (total <= 0) return;
  if (sum.norm() >= kThinSheet * total) {
    surface.normals[surface.sides++] = sum.normalized();
    return;
  }
  // largest first, each to the first cluster within 90 degrees
  std::vector<Vec3> ordered(areas.begin(), areas.end());
  std::stable_sort(ordered.begin(), ordered.end(), [](const Vec3& a, const Vec3& b) {
    return a.squaredNorm() > b.squaredNorm();
  });
  for (const Vec3& area : ordered) {
    auto* const end = surface.normals.begin() + surface.sides;
    auto* const same = std::find_if(surface.normals.begin(), end, [&](const Vec3& cluster) {
      return cluster.dot(area) > 0;
    });
    if (same != end) {
      *same += area;
    } else if (surface.sides < VoxelSurface::kMostSides) {
      surface.normals[surface.sides++] = area;
    }
  }
  for (std::size_t i = 0; i < surface.sides; ++i) surface.normals[i].normalize();
}

/// Calls visit(triangle, bits) for each triangle that meets the chunk, with the cells it meets.
template <typename Visit>
void ForEachMeeting(const SurfaceVoxels& voxels, const GridIndex& place, const Visit& visit) {
  const auto found = voxels.chunk_at.find(place);
  if (found == voxels.chunk_at.end()) return;
  for (const std::uint32_t t : voxels.TrianglesOf(voxels.chunks[found->second])) {
    SurfaceVoxels::Bits met{};
    TriangleRows(voxels.snapped[t], kSnapBits).MarkChunk(place, met);
    visit(t, met);
  }
}

template <typename Visit>
void ForEachCell(const SurfaceVoxels::Bits& bits, const Visit& visit) {
  for (std::size_t word = 0; word < 8; ++word) {
    for (std::uint64_t rest = bits[word]; rest != 0; rest &= rest - 1) {
      visit(64 * word + static_cast<std::size_t>(std::countr_zero(rest)));
    }
  }
}

/// Cosine of an edge whose faces turn by 30 degrees, as FeatureNormals::edge_cosines.
constexpr double kShallow = 0.966;
/// Cosine between two mesh edges that continue as one line.
constexpr double kSameLine = 0.9;

/// A feature edge's part in a voxel.
struct EdgePart {
  std::int16_t voxel;  // index among the chunk's surfaces
  std::uint32_t edge;
  Vec3 from;
  Vec3 to;
  Vec3 tangent;
};

/// Finds the part of a line a + t (b - a), 0 <= t <= 1, within the unit cell: its ends t, or
/// nothing.
bool ClipSegment(const Vec3& a, const Vec3& b, double& from, double& to) {
  from = 0;
  to = 1;
  for (int axis = 0; axis < 3; ++axis) {
    const double d = b[axis] - a[axis];
    if (std::abs(d) < 1e-12) continue;  // the line is known to meet the cell
    const double one = (0.0 - a[axis]) / d;
    const double two = (1.0 - a[axis]) / d;
    from = std::max(from, std::min(one, two));
    to = std::min(to, std::max(one, two));
  }
  return from <= to;
}

/// Makes `surface` an edge voxel of the first of these parts, which is the longest, and of those
/// that continue it as one line. Puts them first, and returns their number.
std::size_t TakeLine(std::span<EdgePart> parts, const FeatureNormals& normals,
                     VoxelSurface& surface) {
  const EdgePart longest = parts.front();
  double low = 0;
  double high = (longest.to - longest.from).norm();
  const auto rest = std::stable_partition(parts.begin(), parts.end(), [&](const EdgePart& part) {
    return std::abs(part.tangent.dot(longest.tangent)) >= kSameLine;
  });
  for (auto part = parts.begin(); part != rest; ++part) {
    for (const Vec3& end : {part->from, part->to}) {
      const double along = (end - longest.from).dot(longest.tangent);
      low = std::min(low, along);
      high = std::max(high, along);
    }
  }
  surface.label = Label::kEdge;
  surface.tangent = longest.tangent;
  surface.half_length = 0.5 * (high - low);
  surface.place = longest.from + 0.5 * (low + high) * longest.tangent;
  if (normals.edges[longest.edge].squaredNorm() > 0) {
    surface.feature_normal = normals.edges[longest.edge];
    surface.cosine = normals.edge_cosines[longest.edge];
  }
  return static_cast<std::size_t>(rest - parts.begin());
}

/// Calls visit(parts of a voxel) for each voxel that has some.
template <typename Visit>
void ForEachVoxel(std::vector<EdgePart>& parts, const Visit& visit) {
  for (std::size_t first = 0; first < parts.size();) {
    std::size_t end = first;
    while (end < parts.size() && parts[end].voxel == parts[first].voxel) ++end;
    visit(std::span<EdgePart>(&parts[first], end - first));
    first = end;
  }
}

/// Makes the surfaces of a chunk: first those of its facets, then what edges and vertices change.
class ChunkSurfacesMaker {
 public:
  ChunkSurfacesMaker(const FeatureVoxels& voxels, const GridIndex& place,
                     const TriangleMesh& mesh_W, const Features& features,
                     const FeatureNormals& normals)
      : voxels_(voxels),
        place_(place),
        mesh_W_(mesh_W),
        features_(features),
        normals_(normals),
        voxel_size_(voxels.surface().voxel_size) {
    const GridIndex first = place * kChunkSide;
    origin_ = Vec3(first.x, first.y, first.z);
    at_.fill(-1);
  }

  ChunkSurfaces Make() {
    GatherFacets();
    AddSurfaces();
    FindEdgeParts();
    LabelEdges();
    LabelVertices();
    AddMoreEdges();
    KeepPlacesInVoxels();
    return std::move(surfaces_);
  }

 private:
  static Vec3 CornerOf(std::size_t cell) {
    const GridIndex c = BlockCell(cell);
    return Vec3(c.x, c.y, c.z);
  }
  VoxelSurface& SurfaceAt(std::int16_t voxel) {
    return surfaces_.voxels[static_cast<std::size_t>(voxel)];
  }

  /// Sums up the facets in each voxel; `at_` becomes indices in `gathered_`.
  void GatherFacets() {
    const double s = voxel_size_;
    ForEachMeeting(voxels_.surface(), place_, [&](std::uint32_t t, const auto& met) {
      const std::array<Vec3, 3> triangle{mesh_W_.corner(t, 0) / s - origin_,
                                         mesh_W_.corner(t, 1) / s - origin_,
                                         mesh_W_.corner(t, 2) / s - origin_};
      const Vec3 whole = (triangle[1] - triangle[0]).cross(triangle[2] - triangle[0]);
      if (whole.norm() <= 0) return;
      const Vec3 n = whole.normalized();
      ForEachCell(met, [&](std::size_t cell) {
        const TrianglePart part = PartInCell(triangle, CornerOf(cell));
        if (at_[cell] < 0) {
          at_[cell] = static_cast<std::int16_t>(gathered_.size());
          gathered_.emplace_back();
        }
        Gathered& g = gathered_[static_cast<std::size_t>(at_[cell])];
        // a triangle that only touches the cell still shows which way the surface faces
        facets_.push_back({at_[cell], part.area + 1e-9 * n});
        ++g.count;
        g.moment += part.moment;
        const Vec3 middle = CornerOf(cell) + Vec3::Constant(0.5);
        g.on_plane = middle - n.dot(middle - triangle[0]) * n;
        g.weight += part.area.norm();
      });
    });
  }

  /// Makes the surfaces that have a normal; `at_` becomes indices in `surfaces_.voxels`.
  void AddSurfaces() {
    std::vector<std::size_t> next(gathered_.size() + 1, 0);
    for (std::size_t i = 0; i < gathered_.size(); ++i) next[i + 1] = next[i] + gathered_[i].count;
    std::vector<Vec3> areas(facets_.size());  // voxel by voxel
    for (const FacetPart& f : facets_) areas[next[static_cast<std::size_t>(f.voxel)]++] = f.area;
    std::vector<VoxelSurface>& out = surfaces_.voxels;
    out.reserve(gathered_.size());
    for (std::size_t cell = 0; cell < kVoxelsPerChunk; ++cell) {
      if (at_[cell] < 0) continue;
      const auto i = static_cast<std::size_t>(at_[cell]);
      at_[cell] = -1;
      const Gathered& g = gathered_[i];
      VoxelSurface surface;
      surface.cell = static_cast<std::uint16_t>(cell);
      const auto areas_here = std::span(areas).subspan(next[i] - g.count, g.count);
      SetNormals(areas_here, surface);
      if (surface.sides == 0) continue;
      surface.feature_normal = surface.normals[0];
      surface.place =
          Vec3((g.weight > 1e-9 ? Vec3(g.moment / g.weight) : g.on_plane) - CornerOf(cell));
      at_[cell] = static_cast<std::int16_t>(out.size());
      out.push_back(surface);
    }
  }

  /// Finds the parts of feature edges, voxel by voxel, the longest first: it gives the direction,
  /// and parts that continue it nearly the same way (a rim of many mesh edges) make it longer.
  void FindEdgeParts() {
    const double s = voxel_size_;
    ForEachMeeting(voxels_[Field::kEdge], place_, [&](std::uint32_t e, const auto& met) {
      ForEachCell(met, [&](std::size_t cell) {
        if (at_[cell] < 0) return;
        const Vec3 corner = origin_ + CornerOf(cell);
        const Vec3 a = mesh_W_.vertices[features_.edges[e][0]] / s - corner;
        const Vec3 b = mesh_W_.vertices[features_.edges[e][1]] / s - corner;
        double from = 0;
        double to = 0;
        if (!ClipSegment(a, b, from, to)) from = to = 0.5 * (from + to);
        parts_.push_back(
            {at_[cell], e, a + from * (b - a), a + to * (b - a), (b - a).normalized()});
      });
    });
    std::stable_sort(parts_.begin(), parts_.end(), [](const EdgePart& one, const EdgePart& two) {
      if (one.voxel != two.voxel) return one.voxel < two.voxel;
      return (one.to - one.from).squaredNorm() > (two.to - two.from).squaredNorm();
    });
  }

  void LabelEdges() {
    ForEachVoxel(parts_, [&](std::span<EdgePart> here) {
      TakeLine(here, normals_, SurfaceAt(here.front().voxel));
    });
  }

  void LabelVertices() {
    ForEachMeeting(voxels_[Field::kVertex], place_, [&](std::uint32_t v, const auto& met) {
      ForEachCell(met, [&](std::size_t cell) {
        if (at_[cell] < 0) return;
        VoxelSurface& surface = SurfaceAt(at_[cell]);
        if (surface.label == Label::kVertex) return;
        surface.label = Label::kVertex;
        surface.half_length = 0;
        if (normals_.vertices[v].squaredNorm() > 0) surface.feature_normal = normals_.vertices[v];
        surface.place =
            mesh_W_.vertices[features_.vertices[v]] / voxel_size_ - origin_ - CornerOf(cell);
      });
    });
  }

  /// Lists the edges beside those that give a voxel its label. An edge of a corner continues to the
  /// corner itself, beside the edges that meet it there.
  void AddMoreEdges() {
    ForEachVoxel(parts_, [&](std::span<EdgePart> here) {
      AddMoreEdges(here, SurfaceAt(here.front().voxel));
    });
    std::stable_sort(surfaces_.more_edges.begin(), surfaces_.more_edges.end(),
                     [](const VoxelSurface& one, const VoxelSurface& two) {
                       return one.cell < two.cell;
                     });
  }

  void AddMoreEdges(std::span<EdgePart> here, const VoxelSurface& corner) {
    const bool is_vertex = corner.label == Label::kVertex;
    if (!is_vertex) {
      VoxelSurface own = corner;
      here = here.subspan(TakeLine(here, normals_, own));
    }
    for (std::size_t lines = 0; lines < VoxelSurface::kMostMoreEdges && !here.empty(); ++lines) {
      VoxelSurface edge = corner;
      edge.feature_normal = corner.normals[0];
      edge.cosine = 0;
      here = here.subspan(TakeLine(here, normals_, edge));
      // nothing leans on notches, and shallow edges are pieces of curved surface
      const bool sharp = edge.cosine >= 0 && edge.cosine < kShallow;
      if (edge.half_length <= 0 || !sharp) continue;
      const double along = (corner.place - edge.place).dot(edge.tangent);
      edge.ends = is_vertex && std::abs(along) > 0.99 * edge.half_length;
      if (edge.ends && along > 0) edge.tangent = -edge.tangent;
      surfaces_.more_edges.push_back(edge);
    }
  }

  void KeepPlacesInVoxels() {
    for (std::vector<VoxelSurface>* all : {&surfaces_.voxels, &surfaces_.more_edges}) {
      for (VoxelSurface& surface : *all) {
        surface.place = surface.place.cwiseMax(0.0).cwiseMin(1.0);
      }
    }
  }

  const FeatureVoxels& voxels_;
  GridIndex place_;
  const TriangleMesh& mesh_W_;
  const Features& features_;
  const FeatureNormals& normals_;
  double voxel_size_;
  Vec3 origin_;
  std::array<std::int16_t, kVoxelsPerChunk> at_;  // per cell: an index, or -1
  std::vector<Gathered> gathered_;
  std::vector<FacetPart> facets_;
  std::vector<EdgePart> parts_;
  ChunkSurfaces surfaces_;
};

}  // namespace

ChunkSurfaces SurfacesOfChunk(const FeatureVoxels& voxels, const SurfaceVoxels::Chunk& chunk,
                              const TriangleMesh& mesh_W, const Features& features,
                              const FeatureNormals& normals) {
  return ChunkSurfacesMaker(voxels, chunk.place, mesh_W, features, normals).Make();
}

}  // namespace tandem
