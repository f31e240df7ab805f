#include "engine/voxel/pages/computed_pages.h"

#include <cstring>
#include <mutex>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "engine/geometry/mesh/mesh_sides.h"
#include "engine/voxel/build/inside_winding.h"
#include "engine/voxel/build/mark_source.h"

namespace tandem {

namespace {

class ComputedPages final : public PageSource {
 public:
  explicit ComputedPages(std::unique_ptr<MarkSource> source) : source_(std::move(source)) {}

  /// Computes all pages once, for the chunk-level field and the counts.
  std::optional<Error> Survey(const VoxelizeOptions& options) {
    VoxmapBuilder builder(options.voxel_size, options.range, options.bits, source_->box(),
                          source_->kinds());
    const std::size_t plane_bytes = kVoxelsPerChunk / 8 * static_cast<std::size_t>(options.bits);
    std::vector<GridIndex> with_planes;
    const auto fault = source_->MakeAll([&](const GridIndex& place, const MarkPlanes& planes) {
      builder.Add(place, planes.record(), {});
      counts_.band += planes.band_voxels();
      counts_.planes += planes.planes().size() / plane_bytes;
      Count(planes, plane_bytes, options.bits);
      if (!planes.planes().empty()) with_planes.push_back(place);
    });
    if (fault) return fault;
    outline_ = builder.FinishOutline(counts_.band);
    counts_.hyperchunks = outline_.header().record_count - 2;
    counts_.quarters = kQuarters * counts_.planes;
    counts_.bytes = outline_.header().bytes + counts_.planes * (plane_bytes + sizeof(VoxmapPlane));
    place_of_.assign(outline_.header().record_count, kNowhere);
    for (const GridIndex& place : with_planes) {
      place_of_[outline_.index()[source_->box().CellOf(place)]] = place;
    }
    return std::nullopt;
  }

  bool HasPage(std::uint32_t record) const noexcept override {
    return !(place_of_[record] == kNowhere);
  }
  std::uint64_t BytesOf(std::uint32_t /*record*/) const noexcept override { return 0; }
  std::optional<Error> Read(std::uint32_t record, VoxelPage& page,
                            const std::stop_token& /*stop*/) const override {
    std::unique_ptr<MarkPlanes> planes;
    {
      const std::lock_guard lock(returning_);
      if (!spare_.empty()) {
        planes = std::move(spare_.back());
        spare_.pop_back();
      }
    }
    if (planes == nullptr) planes = source_->MakePlanes();
    source_->Fill(place_of_[record], *planes);
    Take(*planes, page);
    const std::lock_guard lock(returning_);
    spare_.push_back(std::move(planes));
    return std::nullopt;
  }

 private:
  static constexpr GridIndex kNowhere{INT32_MIN, 0, 0};

  /// Counts the marks of the surface field, whose planes come first.
  void Count(const MarkPlanes& planes, std::size_t plane_bytes, int bits) {
    std::size_t count = 0;
    for (const VoxmapSlice& slice : planes.record().slices[0]) count += CountBits(slice.stored);
    const unsigned largest = (1U << static_cast<unsigned>(bits)) - 1;
    for (std::size_t i = 0; i < count * plane_bytes; ++i) {
      const unsigned byte = planes.planes()[i];
      if (byte == 0) continue;
      for (unsigned shift = 0; shift < 8; shift += static_cast<unsigned>(bits)) {
        const unsigned mark = byte >> shift & largest;
        counts_.interior += mark == kInteriorMark ? 1U : 0U;
        counts_.surface += mark == kSurfaceMark ? 1U : 0U;
        counts_.free += mark > kSurfaceMark ? 1U : 0U;
      }
    }
  }

  void Take(const MarkPlanes& planes, VoxelPage& page) const {
    for (std::size_t f = 0; f < kFields; ++f) {
      for (std::size_t z = 0; z < 8; ++z) {
        page.stored[f][z] = planes.record().slices[f][z].stored;
      }
    }
    const std::size_t quarter_bytes = outline_.quarter_bytes();
    const std::string_view bytes(reinterpret_cast<const char*>(planes.planes().data()),
                                 planes.planes().size());
    page.planes.resize(bytes.size() / quarter_bytes / kQuarters);
    page.quarters.clear();
    std::unordered_map<std::string_view, std::uint16_t> numbers;
    const std::string_view uniform(reinterpret_cast<const char*>(outline_.quarters()),
                                   2 * quarter_bytes);
    numbers[uniform.substr(0, quarter_bytes)] = kQuarterBeyond;
    numbers[uniform.substr(quarter_bytes)] = kQuarterInterior;
    for (std::size_t q = 0; q < bytes.size() / quarter_bytes; ++q) {
      const std::string_view quarter = bytes.substr(q * quarter_bytes, quarter_bytes);
      const auto [found, fresh] =
          numbers.try_emplace(quarter, static_cast<std::uint16_t>(numbers.size()));
      if (fresh) page.quarters.insert(page.quarters.end(), quarter.begin(), quarter.end());
      page.planes[q / kQuarters][q % kQuarters] = found->second;
    }
  }

  std::unique_ptr<MarkSource> source_;
  std::vector<GridIndex> place_of_;  // per record
  mutable std::mutex returning_;
  mutable std::vector<std::unique_ptr<MarkPlanes>> spare_;
};

}  // namespace

Result<std::shared_ptr<const PageSource>> ComputePages(const TriangleMesh& mesh_W,
                                                       const VoxelizeOptions& options) {
  if (std::optional<Error> fault = VoxelizeFault(mesh_W, options)) return *fault;
  const MeshSides sides(mesh_W);
  const Features features =
      FindFeatures(mesh_W, sides, options.flatness_voxels * options.voxel_size);
  const MeshFacing facing = FindFacing(mesh_W, sides);
  if (auto fault = WindingCostFault(mesh_W, facing, options.voxel_size)) return *std::move(fault);
  auto source = MarkSource::Make(mesh_W, features, facing, options, {}, [](double) {});
  if (!source) return source.error();
  auto pages = std::make_shared<ComputedPages>(std::move(*source));
  if (auto fault = pages->Survey(options)) return *fault;
  return std::shared_ptr<const PageSource>(std::move(pages));
}

}  // namespace tandem
