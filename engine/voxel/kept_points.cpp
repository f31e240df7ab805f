#include "engine/voxel/kept_points.h"

#include <algorithm>

#include "engine/base/byte_archive.h"
#include "engine/base/hash.h"
#include "engine/geometry/mesh_hash.h"

namespace tandem {

namespace {

/// Calls visit(part) for every part of a pointshell, in the order of the file.
template <typename Points, typename Values, typename Arrays>
void Visit(Points& points, const Values& value, const Arrays& array) {
  value(points.spacing);
  array(points.x);
  array(points.y);
  array(points.z);
  array(points.nx);
  array(points.ny);
  array(points.nz);
  array(points.labels);
  array(points.edges);
  array(points.chunks);
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

Result<Pointshell> Read(const BlockFile& mapped, const std::filesystem::path& file) {
  Pointshell points;
  ByteReader reader(mapped.blocks[0].bytes);
  Visit(
      points,
      [&reader](auto& value) {
        reader.Read(value);
      },
      [&reader](auto& array) {
        reader.ReadArray(array);
      });
  if (!reader.good() || !reader.at_end() || !IsSound(points)) {
    return DamagedFile(kKeptPointsFile, file.string());
  }
  return points;
}

}  // namespace

MadeOf KeyOf(const TriangleMesh& mesh_W, const Pose& X_WB, const PointshellOptions& options) {
  Hash64 settings;
  for (const double x : X_WB.q.coeffs()) settings.Add(x);
  for (const double x : X_WB.p) settings.Add(x);
  settings.Add(options.spacing);
  settings.Add(options.inward_shift);
  settings.Add(static_cast<std::int64_t>(options.place));
  settings.Add(options.flatness_voxels);
  settings.Add(options.most_displacement);
  settings.Add(std::int64_t{options.free_layer});
  return {HashOf(mesh_W), settings.value()};
}

std::optional<Error> KeepPoints(const Pointshell& points, const MadeOf& made_of,
                                const std::filesystem::path& file) {
  ByteWriter writer;
  Visit(
      points,
      [&writer](const auto& value) {
        writer.Add(value);
      },
      [&writer](const auto& array) {
        writer.AddArray(array);
      });
  return SaveBlocks(kKeptPointsFile, made_of, points.spacing, {writer.bytes(), {}}, file);
}

Result<Pointshell> LoadKeptPoints(const std::filesystem::path& file, const MadeOf& made_of) {
  const Result<BlockFile> mapped = MapBlocks(kKeptPointsFile, file);
  if (!mapped) return mapped.error();
  if (mapped->made_of != made_of) {
    return Error{file.string() + ": points of another mesh, or made with other options"};
  }
  return Read(*mapped, file);
}

std::optional<Error> KeptPointsFault(const std::filesystem::path& file) {
  const Result<BlockFile> mapped = MapBlocks(kKeptPointsFile, file);
  if (!mapped) return mapped.error();
  const Result<Pointshell> points = Read(*mapped, file);
  if (!points) return points.error();
  return std::nullopt;
}

}  // namespace tandem
