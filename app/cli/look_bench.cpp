#include "app/cli/look_bench.h"

#include <algorithm>
#include <bit>

namespace tandem {

namespace {

constexpr std::size_t kMost = RegionBudget::kMost;  // candidates, all of which are looked at
constexpr std::size_t kMostOfAChunk = 16;           // points that touch stand together
constexpr std::uint64_t kMostLooked = 1 << 20U;     // chunks, of a map that has few with a surface
constexpr double kAbove = 0.7;  // voxels: above the clearance at which force begins
constexpr int kLayer = 1;

/// Steps through 0 to count - 1, all over, without coming back to where it was.
std::uint64_t Scattered(std::uint64_t i, std::uint64_t count) {
  constexpr std::uint64_t kPrime = 2'147'483'647;
  return i * kPrime % count;
}

}  // namespace

LookBench::Points LookBench::SomeOfEach(const Pointshell& shell) {
  Points points;
  std::array<std::size_t, kFields> counts{};
  for (const Label label : shell.labels) ++counts[static_cast<std::size_t>(label)];
  std::array<std::size_t, kFields> seen{};
  for (std::size_t i = 0; i < shell.size(); ++i) {
    const auto label = static_cast<std::size_t>(shell.labels[i]);
    const std::size_t number = seen[label]++;
    if (number % (1 + counts[label] / kMost) != 0) continue;
    points[label].push_back({static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(number)});
  }
  return points;
}

LookBench::LookBench(const Pointshell& shell, const Voxmap& voxmap, const SurfaceDetails& details)
    : refined_(shell, voxmap, details, shell.radius, 1e-3, kMost) {
  const Points points = SomeOfEach(shell);
  const auto& size = voxmap.header().size;
  const std::uint64_t chunks = kChunksPerHyperchunk * size[0] * size[1] * size[2];
  const auto nx = static_cast<std::uint64_t>(kChunkSide) * size[0];
  const auto ny = static_cast<std::uint64_t>(kChunkSide) * size[1];
  const std::uint64_t most = std::min(chunks, kMostLooked);
  for (std::uint64_t i = 0; i < most && candidates_.size() + kMostOfAChunk <= kMost; ++i) {
    const std::uint64_t at = Scattered(i, chunks);
    LayOn(points, voxmap, details,
          {static_cast<std::int32_t>(at % nx), static_cast<std::int32_t>(at / nx % ny),
           static_cast<std::int32_t>(at / nx / ny)});
  }
  contacts_.resize(RefinedContacts::RoomFor(candidates_.size()));
}

void LookBench::LayOn(const Points& points, const Voxmap& voxmap, const SurfaceDetails& details,
                      const GridIndex& chunk_V) {
  const SurfaceDetails::Chunk* chunk = details.At(voxmap, chunk_V);
  if (chunk == nullptr) return;
  std::size_t laid = 0;
  for (std::size_t cell = 0; cell < kVoxelsPerChunk && laid < kMostOfAChunk; ++cell) {
    const auto has = [cell](const SurfaceVoxels::Bits& bits) {
      return SurfaceDetails::Has(bits, cell);
    };
    if (!has(chunk->bits)) continue;
    Label label = has(chunk->vertices) ? Label::kSurface
                                       : (has(chunk->edges) ? Label::kEdge : Label::kVertex);
    for (const Label other : {Label::kVertex, Label::kEdge, Label::kSurface}) {
      if (points[static_cast<std::size_t>(label)].empty()) label = other;
    }
    const std::vector<Point>& those = points[static_cast<std::size_t>(label)];
    const Point& one = those[candidates_.size() % those.size()];
    const SurfaceDetail& detail = details.Of(*chunk, cell);
    Candidate candidate{};
    candidate.label = label;
    candidate.point = one.point;
    candidate.edge = one.edge;
    candidate.nhat_V = UnpackDirection(detail.normal);
    const SurfaceWindow::Piece piece{chunk_V * kChunkSide + BlockCell(cell), &detail};
    const Vec3 at = piece.place() + kAbove * candidate.nhat_V;
    candidate.voxel_V = {static_cast<std::int32_t>(std::floor(at.x())),
                         static_cast<std::int32_t>(std::floor(at.y())),
                         static_cast<std::int32_t>(std::floor(at.z()))};
    candidate.p_V = voxmap.voxel_size() * at;
    candidate.mark = voxmap.Value(Field::kSurface, candidate.voxel_V);
    candidates_.push_back(candidate);
    ++laid;
  }
}

void LookBench::LookAtAll() noexcept {
  const double turned = 0;
  refined_.LookAt(candidates_, 0, candidates_.size(), Mat3::Identity(), kLayer, &turned, 0,
                  contacts_.data());
}

}  // namespace tandem
