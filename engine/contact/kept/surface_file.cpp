#include "engine/contact/kept/surface_file.h"

#include <string>
#include <utility>

#include "engine/contact/features/feature_image.h"
#include "engine/field/build/field_builder.h"
#include "engine/field/query/field_image.h"
#include "engine/geometry/mesh/mesh_hash.h"

namespace tandem {

namespace {

/// The field and the features of a file.
struct SurfaceBlocks {
  DistanceField field;
  BodyFeatures features;
};
Result<SurfaceBlocks> ReadBlocks(Result<BlockFile> mapped, const std::filesystem::path& file) {
  if (!mapped) return mapped.error();
  std::optional<DistanceField> field = FieldImage::Read(std::move(mapped->blocks[0]));
  std::optional<BodyFeatures> features = FeatureImage::Read(std::move(mapped->blocks[1]));
  if (!field || !features || field->voxel_size() != mapped->voxel_size) {
    return DamagedFile(kSurfaceFile, file.string());
  }
  return SurfaceBlocks{std::move(*field), std::move(*features)};
}

}  // namespace

BlockFileSources KeyOf(const TriangleMesh& mesh_W, const SurfaceOptions& options) {
  RunningSha256 settings;
  settings.Add(options.voxel_size);
  settings.Add(options.flatness_voxels);
  settings.Add(options.spacing_voxels);
  settings.Add(options.band_voxels);
  settings.Add(options.range_voxels);
  return {DigestOf(mesh_W), settings.Value()};
}

std::optional<Error> SaveSurface(const BodySurface& surface, const TriangleMesh& mesh_W,
                                 const SurfaceOptions& options, const std::filesystem::path& file) {
  return SaveBlocks(kSurfaceFile, KeyOf(mesh_W, options), surface.field.voxel_size(),
                    {surface.field.bytes(), surface.features.bytes()}, file);
}

Result<BodySurface> MapSurface(const std::filesystem::path& file, const TriangleMesh& mesh_W,
                               const Pose& X_WB, const SurfaceOptions& options) {
  Result<SurfaceBlocks> blocks =
      ReadBlocks(MapBlocks(kSurfaceFile, file, KeyOf(mesh_W, options)), file);
  if (!blocks) return blocks.error();
  return SurfaceInBody(std::move(blocks->field), std::move(blocks->features), mesh_W, X_WB);
}

std::optional<Error> SurfaceFault(const std::filesystem::path& file) {
  const Result<SurfaceBlocks> blocks = ReadBlocks(MapBlocks(kSurfaceFile, file), file);
  if (!blocks) return blocks.error();
  return std::nullopt;
}

}  // namespace tandem
