#include "engine/voxel/points/kept_points.h"

#include <algorithm>
#include <array>
#include <vector>

#include "engine/base/files/byte_archive.h"
#include "engine/geometry/mesh/mesh_hash.h"

namespace tandem {

namespace {

/// Pointshell::Edge and Chunk without padding, whose bytes are undefined.
struct KeptEdge {
  std::array<float, 3> tangent{};
  float half_length = 0;
  float cosine = 0;
  std::uint32_t ends = 0;
};
static_assert(sizeof(KeptEdge) == 24);
struct KeptChunk {
  std::uint32_t first = 0;
  std::uint32_t count = 0;
  std::uint32_t first_edge = 0;
  std::array<std::uint32_t, kFields> labels{};
  std::array<double, 3> p_BC{};
  double radius = 0;
};
static_assert(sizeof(KeptChunk) == 56);

struct KeptParts {
  std::vector<KeptEdge> edges;
  std::vector<KeptChunk> chunks;
};

KeptParts PartsOf(const Pointshell& points) {
  KeptParts parts;
  for (const Pointshell::Edge& edge : points.edges) {
    const Vec3f& t = edge.tangent;
    parts.edges.push_back(
        {{t.x(), t.y(), t.z()}, edge.half_length, edge.cosine, edge.ends ? 1U : 0U});
  }
  for (const Pointshell::Chunk& chunk : points.chunks) {
    const Vec3& p = chunk.p_BC;
    parts.chunks.push_back({chunk.first,
                            chunk.count,
                            chunk.first_edge,
                            chunk.labels,
                            {p.x(), p.y(), p.z()},
                            chunk.radius});
  }
  return parts;
}

void PutParts(const KeptParts& parts, Pointshell& points) {
  for (const KeptEdge& edge : parts.edges) {
    points.edges.push_back({Vec3f(edge.tangent[0], edge.tangent[1], edge.tangent[2]),
                            edge.half_length, edge.cosine, edge.ends != 0});
  }
  for (const KeptChunk& chunk : parts.chunks) {
    points.chunks.push_back({chunk.first, chunk.count, chunk.first_edge, chunk.labels,
                             Vec3(chunk.p_BC[0], chunk.p_BC[1], chunk.p_BC[2]), chunk.radius});
  }
}

/// Calls visit(part) for every part of a pointshell, in the order of the file.
template <typename Points, typename Parts, typename Values, typename Arrays>
void Visit(Points& points, Parts& parts, const Values& value, const Arrays& array) {
  value(points.spacing);
  array(points.x);
  array(points.y);
  array(points.z);
  array(points.nx);
  array(points.ny);
  array(points.nz);
  array(points.labels);
  array(parts.edges);
  array(parts.chunks);
  value(points.radius);
  value(points.gap_step);
  value(points.gaps);
}

bool IsSound(const Pointshell& points) {
  const std::size_t count = points.size();
  for (const std::vector<float>* part :
       {&points.y, &points.z, &points.nx, &points.ny, &points.nz}) {
    if (part->size() != count) return false;
  }
  std::size_t next = 0;
  for (const Pointshell::Chunk& chunk : points.chunks) {
    const std::size_t labelled = std::size_t{chunk.labels[0]} + chunk.labels[1] + chunk.labels[2];
    const std::size_t edges = points.edges.empty() ? 0 : chunk.labels[1];
    if (chunk.first != next || labelled != chunk.count ||
        chunk.first_edge + edges > points.edges.size()) {
      return false;
    }
    next += chunk.count;
  }
  const bool labels = std::all_of(points.labels.begin(), points.labels.end(), [](Label label) {
    return static_cast<std::size_t>(label) < kFields;
  });
  return labels && next == count && points.labels.size() == count && count > 0;
}

Result<Pointshell> Read(const Result<BlockFile>& mapped, const std::filesystem::path& file) {
  if (!mapped) return mapped.error();
  Pointshell points;
  KeptParts parts;
  ByteReader reader(mapped->blocks[0].bytes);
  Visit(
      points, parts,
      [&reader](auto& value) {
        reader.Read(value);
      },
      [&reader](auto& array) {
        reader.ReadArray(array);
      });
  PutParts(parts, points);
  if (!reader.good() || !reader.at_end() || !IsSound(points)) {
    return DamagedFile(kKeptPointsFile, file.string());
  }
  return points;
}

}  // namespace

BlockFileSources KeyOf(const TriangleMesh& mesh_W, const Pose& X_WB,
                       const PointshellOptions& options) {
  RunningSha256 settings;
  for (const double x : X_WB.q.coeffs()) settings.Add(x);
  for (const double x : X_WB.p) settings.Add(x);
  settings.Add(options.spacing);
  settings.Add(options.inward_shift);
  settings.Add(static_cast<std::int64_t>(options.place));
  settings.Add(options.flatness_voxels);
  settings.Add(options.most_displacement);
  settings.Add(std::int64_t{options.free_layer});
  return {DigestOf(mesh_W), settings.Value()};
}

std::optional<Error> KeepPoints(const Pointshell& points, const BlockFileSources& made_of,
                                const std::filesystem::path& file) {
  ByteWriter writer;
  const KeptParts parts = PartsOf(points);
  Visit(
      points, parts,
      [&writer](const auto& value) {
        writer.Add(value);
      },
      [&writer](const auto& array) {
        writer.AddArray(array);
      });
  return SaveBlocks(kKeptPointsFile, made_of, points.spacing, {writer.bytes(), {}}, file);
}

Result<Pointshell> LoadKeptPoints(const std::filesystem::path& file,
                                  const BlockFileSources& made_of) {
  return Read(MapBlocks(kKeptPointsFile, file, made_of), file);
}

std::optional<Error> KeptPointsFault(const std::filesystem::path& file) {
  const Result<Pointshell> points = Read(MapBlocks(kKeptPointsFile, file), file);
  if (!points) return points.error();
  return std::nullopt;
}

}  // namespace tandem
