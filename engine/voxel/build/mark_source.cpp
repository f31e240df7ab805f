#include "engine/voxel/build/mark_source.h"

#include <algorithm>
#include <cstdlib>
#include <mutex>

#include <tbb/parallel_pipeline.h>
#include <tbb/task_arena.h>

namespace tandem {

namespace {

Error Stopped() {
  return Error{"voxelization was stopped"};
}

/// Returns the number of hyperchunks that a band of `chunks` chunks reaches into from the next.
int HyperchunksReached(int chunks) {
  return (chunks + 7) / 8;
}

/// Calls visit(offset) for the hyperchunks, by offset from this one, that have chunks within
/// `chunks` chunks of its surface.
template <typename Visit>
void VisitReached(const SurfaceBricks::Source& surface, int chunks, const Visit& visit) {
  if (surface.empty()) return;
  // by z of the chunks: bit x + 8 y
  std::array<std::uint64_t, kChunkSide> occupied{};
  for (std::size_t z = 0; z < kHyperchunkSide; ++z) {
    for (std::size_t octet = 0; octet < 8; ++octet) {
      const std::uint64_t* rows = surface.Octet(z, octet);
      if (rows == nullptr) continue;
      std::uint64_t bits = 0;
      for (std::size_t i = 0; i < 8; ++i) bits |= rows[i];
      for (std::size_t x = 0; x < 8; ++x) {
        if ((bits >> (8 * x) & 0xffU) != 0) occupied[z / 8] |= std::uint64_t{1} << (x + 8 * octet);
      }
    }
  }
  const auto side = [chunks](int offset) {  // chunks that are near enough, of eight in a row
    const unsigned all = 0xff;
    const int least = std::max(0, 8 * std::abs(offset) - chunks);
    return offset < 0 ? all >> least : (offset > 0 ? all << least & all : all);
  };
  const int far = HyperchunksReached(chunks);
  for (std::int32_t dz = -far; dz <= far; ++dz) {
    for (std::int32_t dy = -far; dy <= far; ++dy) {
      std::uint64_t rows = 0;  // rows of a layer, in y
      for (unsigned y = 0; y < 8; ++y) {
        if ((side(dy) >> y & 1U) != 0) rows |= std::uint64_t{0xff} << (8 * y);
      }
      for (std::int32_t dx = -far; dx <= far; ++dx) {
        const std::uint64_t layer = rows & (side(dx) * 0x0101010101010101ULL);
        bool any = false;
        for (unsigned z = 0; z < 8; ++z) {
          any = any || ((side(dz) >> z & 1U) != 0 && (occupied[z] & layer) != 0);
        }
        if (any) visit(GridIndex{dx, dy, dz});
      }
    }
  }
}

}  // namespace

Result<std::unique_ptr<MarkSource>> MarkSource::Make(const TriangleMesh& mesh_W,
                                                     const Features& features,
                                                     const MeshFacing& facing,
                                                     const VoxelizeOptions& options,
                                                     const HyperchunkLayers& layers,
                                                     const std::function<void(double)>& tell) {
  std::unique_ptr<MarkSource> source(new MarkSource(options));
  const int reach = (options.range + kChunkSide - 1) / kChunkSide;  // chunks
  const std::size_t rounds = MarkPlanes::Rounds(options.range);
  source->rounds_.reserve(rounds);
  const int reached = HyperchunksReached(reach);
  // the band of a layer also comes from the layers beside it
  HyperchunkLayers with_sources = layers;
  if (layers.begin != INT32_MIN) with_sources.begin -= reached;
  if (layers.end != INT32_MAX) with_sources.end += reached;
  source->rounds_.emplace_back(mesh_W, features, options.voxel_size, facing, reached, with_sources);
  if (options.stop.stop_requested()) return Stopped();
  tell(0.5);
  source->inside_.emplace(source->rounds_.front(), mesh_W, facing, options.voxel_size);
  while (source->rounds_.size() < rounds) {
    if (options.stop.stop_requested()) return Stopped();
    source->rounds_.push_back(GrownSources(source->rounds_.back()));
    tell(0.75 + 0.25 * static_cast<double>(source->rounds_.size()) / static_cast<double>(rounds));
  }
  if (options.stop.stop_requested()) return Stopped();
  tell(1.0);
  source->FindKinds(layers, reach);
  return source;
}

void MarkSource::FindKinds(const HyperchunkLayers& layers, int reach) {
  // the bricks' box holds all that the band may reach; the extra hyperchunk all round has no marks
  const SurfaceBricks& bricks = rounds_.front();
  const HyperchunkBox& inner = bricks.box();
  const GridIndex border{1, 1, 1};
  box_ = {inner.first - border, inner.size + border * 2};
  kinds_.assign(box_.cells(), VoxmapBuilder::Kind::kFar);
  for (const SurfaceBricks::Brick& brick : bricks.bricks()) {
    VisitReached(brick.sources[0], reach, [&](const GridIndex& offset) {
      const GridIndex place = brick.place + offset;
      if (layers.Hold(place)) kinds_[box_.CellOf(place)] = VoxmapBuilder::Kind::kMarked;
    });
  }
  for (std::int32_t z = 0; z < inner.size.z; ++z) {
    for (std::int32_t y = 0; y < inner.size.y; ++y) {
      for (std::int32_t x = 0; x < inner.size.x; ++x) {
        const GridIndex place = inner.first + GridIndex{x, y, z};
        if (!layers.Hold(place)) continue;
        VoxmapBuilder::Kind& kind = kinds_[box_.CellOf(place)];
        if (kind == VoxmapBuilder::Kind::kMarked) {
          marked_.push_back(place);
        } else if (inside_->Solid(inner.CellOf(place))) {
          kind = VoxmapBuilder::Kind::kSolid;
        }
      }
    }
  }
  std::sort(marked_.begin(), marked_.end(), [](const GridIndex& a, const GridIndex& b) {
    return MortonCode(a) < MortonCode(b);
  });
}

std::unique_ptr<MarkPlanes> MarkSource::MakePlanes() const {
  return std::make_unique<MarkPlanes>(rounds_, options_.range, options_.bits);
}

void MarkSource::Fill(const GridIndex& place, MarkPlanes& planes) const {
  const std::size_t cell = rounds_.front().box().CellOf(place);
  planes.Begin(place);
  for (const Field field : kAllFields) {
    const bool first = field == Field::kSurface;
    planes.Add(field, first ? inside_->RowsOf(cell) : nullptr, first && inside_->Solid(cell));
  }
}

std::optional<Error> MarkSource::MakeAll(
    const std::function<void(const GridIndex& place, const MarkPlanes& planes)>& take) const {
  struct Filled {
    GridIndex place;
    std::unique_ptr<MarkPlanes> planes;
  };
  std::size_t next = 0;
  std::size_t done = 0;
  std::mutex returning;
  std::vector<std::unique_ptr<MarkPlanes>> spare;
  const auto give = [&](tbb::flow_control& flow) {
    if (next == marked_.size() || options_.stop.stop_requested()) {
      flow.stop();
      return GridIndex{};
    }
    return marked_[next++];
  };
  const auto fill = [&](const GridIndex& place) {
    auto filled = std::make_shared<Filled>();
    filled->place = place;
    {
      const std::lock_guard lock(returning);
      if (!spare.empty()) {
        filled->planes = std::move(spare.back());
        spare.pop_back();
      }
    }
    if (filled->planes == nullptr) filled->planes = MakePlanes();
    Fill(place, *filled->planes);
    return filled;
  };
  const auto hand_on = [&](const std::shared_ptr<Filled>& filled) {
    take(filled->place, *filled->planes);
    ++done;
    const std::lock_guard lock(returning);
    spare.push_back(std::move(filled->planes));
  };
  const std::size_t tokens = 2 * static_cast<std::size_t>(tbb::this_task_arena::max_concurrency());
  tbb::parallel_pipeline(
      tokens,
      tbb::make_filter<void, GridIndex>(tbb::filter_mode::serial_in_order, give) &
          tbb::make_filter<GridIndex, std::shared_ptr<Filled>>(tbb::filter_mode::parallel, fill) &
          tbb::make_filter<std::shared_ptr<Filled>, void>(tbb::filter_mode::serial_in_order,
                                                          hand_on));
  if (done < marked_.size()) return Stopped();
  return std::nullopt;
}

}  // namespace tandem
