#include "engine/voxel/surface_details.h"

#include <algorithm>
#include <cmath>

#include <tbb/parallel_for.h>

#include "engine/voxel/voxel_surface.h"

namespace tandem {

namespace {

/// A notch whose faces turn less than 30 degrees is a piece of curved surface.
constexpr double kShallow = -0.966;
constexpr double kDirectionScale = 32767.0;

double SignOf(double x) {
  return x < 0 ? -1.0 : 1.0;
}

SurfaceDetail Pack(const VoxelSurface& surface) {
  SurfaceDetail detail;
  for (int k = 0; k < 3; ++k) {
    detail.place[static_cast<std::size_t>(k)] =
        static_cast<std::uint8_t>(std::lround(255.0 * surface.place[k]));
  }
  detail.half_length =
      static_cast<std::uint8_t>(std::min(254L, std::lround(128.0 * surface.half_length)));
  if (surface.sides > 1) detail.half_length = SurfaceDetail::kTwoSided;
  detail.normal = PackDirection(surface.feature_normal);
  detail.tangent = PackDirection(surface.tangent);
  if (surface.label == Label::kVertex) {
    detail.SetShape(SurfaceDetail::Shape::kVertex);
  } else if (surface.label == Label::kSurface && surface.two_faces && surface.sides == 1) {
    detail.SetShape(SurfaceDetail::Shape::kNotch);
  } else if (surface.label == Label::kSurface || surface.cosine == 0 || surface.cosine < kShallow) {
    detail.SetShape(SurfaceDetail::Shape::kSmooth);
  } else if (surface.cosine < 0) {
    detail.SetShape(SurfaceDetail::Shape::kNotch);
  } else {
    detail.SetRidge(std::acos(surface.cosine));
  }
  return detail;
}

/// Whether there is an edge that another can lean on, which a notch is not. Of a thin sheet's edge
/// no length is known.
bool HasEdge(const SurfaceDetail& detail, const Voxmap& voxmap, const GridIndex& voxel_V) {
  if (detail.half_length == 0 || detail.shape() == SurfaceDetail::Shape::kNotch) return false;
  return detail.half_length != SurfaceDetail::kTwoSided ||
         voxmap.Value(Field::kEdge, voxel_V) == kSurfaceMark;
}

}  // namespace

std::array<std::int16_t, 2> PackDirection(const Vec3& unit) {
  const double sum = unit.lpNorm<1>();
  if (sum <= 0) return {};
  double u = unit.x() / sum;
  double v = unit.y() / sum;
  if (unit.z() < 0) {  // the lower half folds outward
    const double folded = (1.0 - std::abs(v)) * SignOf(u);
    v = (1.0 - std::abs(u)) * SignOf(v);
    u = folded;
  }
  return {static_cast<std::int16_t>(std::lround(kDirectionScale * u)),
          static_cast<std::int16_t>(std::lround(kDirectionScale * v))};
}

Vec3 UnpackDirection(const std::array<std::int16_t, 2>& packed) noexcept {
  constexpr auto kScale = static_cast<float>(1.0 / kDirectionScale);
  const float u = kScale * packed[0];
  const float v = kScale * packed[1];
  Vec3f unit(u, v, 1.0F - std::abs(u) - std::abs(v));
  if (unit.z() < 0) {
    unit.x() = std::copysign(1.0F - std::abs(v), u);
    unit.y() = std::copysign(1.0F - std::abs(u), v);
  }
  return (unit * (1.0F / unit.norm())).cast<double>();
}

SurfaceDetails::SurfaceDetails(const TriangleMesh& mesh_W, double flatness_voxels,
                               const Voxmap& voxmap)
    : SurfaceDetails(mesh_W, FindFeatures(mesh_W, flatness_voxels * voxmap.voxel_size()), voxmap) {}

SurfaceDetails::SurfaceDetails(const TriangleMesh& mesh_W, const Features& features,
                               const Voxmap& voxmap) {
  const double s = voxmap.voxel_size();
  const FeatureVoxels voxels = FindFeatureVoxels(mesh_W, features, s);
  const FeatureNormals normals = FindFeatureNormals(mesh_W, features);
  const std::vector<SurfaceVoxels::Chunk>& sources = voxels.surface().chunks;
  struct Made {
    std::vector<SurfaceDetail> details;
    std::vector<MoreEdge> more_edges;
    std::vector<std::uint32_t> counts;  // by forked voxel: how many of more_edges
  };
  std::vector<Made> made(sources.size());
  chunks_.resize(sources.size());
  tbb::parallel_for(std::size_t{0}, sources.size(), [&](std::size_t c) {
    const ChunkSurfaces surfaces = SurfacesOfChunk(voxels, sources[c], mesh_W, features, normals);
    const GridIndex first_V = (sources[c].place - (voxmap.origin() >> 3)) * kChunkSide;
    Chunk& chunk = chunks_[c];
    auto more_edge = surfaces.more_edges.begin();
    for (const VoxelSurface& surface : surfaces.voxels) {
      const std::size_t word = surface.cell >> 6U;
      const std::uint64_t bit = std::uint64_t{1} << (surface.cell & 63U);
      const GridIndex voxel_V = first_V + BlockCell(surface.cell);
      const SurfaceDetail detail = Pack(surface);
      chunk.bits[word] |= bit;
      made[c].details.push_back(detail);
      if (detail.shape() == SurfaceDetail::Shape::kVertex) {
        chunk.vertices[word] |= bit;
      } else if (HasEdge(detail, voxmap, voxel_V)) {
        chunk.edges[word] |= bit;
      }
      std::uint32_t count = 0;
      for (; more_edge != surfaces.more_edges.end() && more_edge->cell == surface.cell;
           ++more_edge) {
        const SurfaceDetail edge = Pack(*more_edge);
        if (!HasEdge(edge, voxmap, voxel_V)) continue;
        made[c].more_edges.push_back({edge, more_edge->ends});
        ++count;
      }
      if (count == 0) continue;
      made[c].counts.push_back(count);
      chunk.edges[word] |= bit;
      chunk.forked[word] |= bit;
    }
  });
  chunk_of_plane_.assign(voxmap.header().plane_count, 0);
  for (std::size_t c = 0; c < sources.size(); ++c) {
    Chunk& chunk = chunks_[c];
    chunk.first = static_cast<std::uint32_t>(details_.size());
    std::size_t before = 0;
    for (std::size_t word = 0; word < chunk.bits.size(); ++word) {
      chunk.before[word] = static_cast<std::uint16_t>(before);
      before += static_cast<std::size_t>(std::popcount(chunk.bits[word]));
    }
    details_.insert(details_.end(), made[c].details.begin(), made[c].details.end());
    chunk.first_forked = static_cast<std::uint32_t>(first_more_edge_.size());
    auto first = static_cast<std::uint32_t>(more_edges_.size());
    for (const std::uint32_t count : made[c].counts) {
      first_more_edge_.push_back(first);
      first += count;
    }
    more_edges_.insert(more_edges_.end(), made[c].more_edges.begin(), made[c].more_edges.end());
    const GridIndex place = sources[c].place - (voxmap.origin() >> 3);
    chunk_of_plane_[voxmap.PlaneOf(Field::kSurface, place)] = static_cast<std::uint32_t>(c + 1);
  }
  first_more_edge_.push_back(static_cast<std::uint32_t>(more_edges_.size()));
}

std::size_t SurfaceDetails::bytes() const noexcept {
  return chunk_of_plane_.size() * sizeof(chunk_of_plane_[0]) + chunks_.size() * sizeof(Chunk) +
         details_.size() * sizeof(SurfaceDetail) + more_edges_.size() * sizeof(MoreEdge) +
         first_more_edge_.size() * sizeof(first_more_edge_[0]);
}

}  // namespace tandem
