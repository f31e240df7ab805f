#include "app/bench/measure/field_bench.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include <tbb/global_control.h>

#include "app/bench/measure/bench_scene.h"
#include "engine/field/build/field_builder.h"
#include "engine/geometry/exact/exact_surface.h"
#include "engine/voxel/build/voxelize.h"

namespace tandem {

namespace {

constexpr std::size_t kJudged = 20000;  // places whose error is measured
constexpr std::size_t kBatch = 256;     // places in one look-up

/// Some places near one another, voxels from `base`.
struct Batch {
  GridIndex base;
  std::array<float, kBatch> x{}, y{}, z{};
};

/// Returns the places in batches, in their order. The last place fills the last batch up.
std::vector<Batch> InBatches(const std::vector<Vec3>& places_V) {
  std::vector<Batch> batches;
  for (std::size_t first = 0; first < places_V.size(); first += kBatch) {
    Batch& batch = batches.emplace_back();
    const Vec3 base = places_V[first].array().floor();
    batch.base = {static_cast<std::int32_t>(base.x()), static_cast<std::int32_t>(base.y()),
                  static_cast<std::int32_t>(base.z())};
    for (std::size_t i = 0; i < kBatch; ++i) {
      const Vec3f from = (places_V[std::min(first + i, places_V.size() - 1)] - base).cast<float>();
      batch.x[i] = from.x();
      batch.y[i] = from.y();
      batch.z[i] = from.z();
    }
  }
  return batches;
}

/// Returns places in W within half a voxel of the body's points, along their normals.
std::vector<Vec3> PlacesOf(const BodyModel& body, double voxel_size) {
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> half(-0.5, 0.5);
  std::vector<Vec3> places;
  for (std::size_t i = 0; i < body.points.size(); ++i) {
    const Vec3 aside = half(random) * body.points.normal(i);
    places.push_back(body.X_WB0 * (body.points.point(i) + voxel_size * aside));
  }
  return places;
}

FieldFigures::Errors ErrorsOf(const DistanceField& field, const TriangleMesh& mesh_W,
                              const std::vector<Vec3>& places_W) {
  const ExactSurface exact(mesh_W);
  const std::size_t stride = std::max<std::size_t>(1, places_W.size() / kJudged);
  std::vector<double> errors;
  for (std::size_t i = 0; i < places_W.size(); i += stride) {
    const double distance = -exact.Depth(places_W[i]) / field.voxel_size();
    if (std::abs(distance) >= field.band()) continue;
    const Vec3 place_V = (places_W[i] - field.p_WVo()) / field.voxel_size();
    errors.push_back(std::abs(field.At(place_V).value - distance));
  }
  if (errors.empty()) return {};
  std::sort(errors.begin(), errors.end());
  return {errors[errors.size() / 2], errors[errors.size() * 99 / 100], errors.back()};
}

}  // namespace

Result<FieldFigures> MeasureField(const WorldModel& world, std::size_t body, int rounds) {
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  const double voxel_size = world.scene.voxel_size;
  const TriangleMesh mesh_W = MeshOfBody(world, body);
  FieldFigures figures;
  Result<Voxmap> voxmap = Error{};
  figures.voxelize_cpu_s = 1e-9 * CpuNs([&] {
                             voxmap = Voxelize(mesh_W, {.voxel_size = voxel_size});
                           });
  if (!voxmap) return voxmap.error();
  Result<DistanceField> field = Error{};
  figures.build_cpu_s = 1e-9 * CpuNs([&] {
                          field = BuildField(mesh_W, {.voxel_size = voxel_size});
                        });
  if (!field) return field.error();
  figures.bytes_per_band_voxel =
      static_cast<double>(field->Count().bytes()) /
      static_cast<double>(std::max<std::size_t>(1, voxmap->Count().band));

  const std::vector<Vec3> places_W = PlacesOf(world.bodies[body], voxel_size);
  figures.error_voxels = ErrorsOf(*field, mesh_W, places_W);
  std::vector<Vec3> places_V;
  for (const Vec3& p_W : places_W) places_V.push_back((p_W - field->p_WVo()) / voxel_size);
  const std::vector<Batch> batches = InBatches(places_V);
  std::array<float, kBatch> values;
  std::array<std::int32_t, kBatch> kinds;
  std::vector<FieldGradient> gradients(places_V.size());
  const auto count = static_cast<double>(places_V.size());
  std::vector<double> value_ns;
  std::vector<double> gradient_ns;
  for (int round = 0; round < rounds; ++round) {
    value_ns.push_back(CpuNs([&] {
                         for (const Batch& batch : batches) {
                           field->Values(batch.base,
                                         {batch.x.data(), batch.y.data(), batch.z.data()}, kBatch,
                                         values.data(), kinds.data());
                         }
                       }) /
                       static_cast<double>(batches.size() * kBatch));
    gradient_ns.push_back(CpuNs([&] {
                            field->WithGradients(places_V, gradients.data());
                          }) /
                          count);
  }
  figures.field_ns = Median(value_ns);
  figures.field_with_gradient_ns = Median(gradient_ns);
  return figures;
}

}  // namespace tandem
