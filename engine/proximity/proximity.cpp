#include "engine/proximity/proximity.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/geometry/exact/tree_pair.h"
#include "engine/proximity/closest_place.h"

namespace tandem {

namespace {

const double kHalfDiagonal = 0.5 * std::sqrt(3.0);  // half a voxel's diagonal, voxels
// error of the float arithmetic within a chunk, as a share of the distance, and a ten-thousandth of
// a voxel
constexpr double kRounding = 1e-6;

GridIndex VoxelAt(const Vec3& p_in_voxels) {
  return {static_cast<std::int32_t>(std::floor(p_in_voxels.x())),
          static_cast<std::int32_t>(std::floor(p_in_voxels.y())),
          static_cast<std::int32_t>(std::floor(p_in_voxels.z()))};
}

}  // namespace

ProximityShape::ProximityShape(const TriangleMesh& mesh_W, Voxmap map)
    : voxmap(std::move(map)), surface(voxmap), mesh(mesh_W), winding(mesh_W) {}

ProximityPair::ProximityPair(const ProximityShape& a, const ProximityShape& b)
    : a_(&a), b_(&b), in_shadow_(b.surface.chunks().size()) {
  shaded_.reserve(b.surface.chunks().size());
}

Vec3 ProximityPair::MiddleOf(std::uint32_t chunk) const noexcept {
  const GridIndex& first = a_->surface.chunks()[chunk].first;
  return a_->surface.voxel_size() * Vec3(first.x + 4, first.y + 4, first.z + 4);
}

void ProximityPair::Load(std::uint32_t chunk, const RotatedFrame& X_BA) noexcept {
  if (loaded_ == chunk) return;
  loaded_ = chunk;
  const SurfaceTree::Chunk& points = a_->surface.chunks()[chunk];
  middle_B_ = X_BA.R * MiddleOf(chunk) + X_BA.p;
  const Eigen::Matrix3f R = (a_->surface.voxel_size() * X_BA.R).cast<float>();
  std::size_t n = 0;
  float most = 0;
  VisitCells(points.bits, [&](std::size_t cell) {
    const GridIndex i = BlockCell(cell);
    const Eigen::Vector3f p =
        R * Eigen::Vector3f(static_cast<float>(i.x) - 3.5F, static_cast<float>(i.y) - 3.5F,
                            static_cast<float>(i.z) - 3.5F);
    x_[n] = p.x();
    y_[n] = p.y();
    z_[n] = p.z();
    ++n;
    most = std::max(most, p.squaredNorm());
  });
  radius_ = (1 + kRounding) * std::sqrt(static_cast<double>(most));
  for (; n % 8 != 0; ++n) {
    x_[n] = x_[0];
    y_[n] = y_[0];
    z_[n] = z_[0];
  }
  count_ = n;
}

float ProximityPair::LeastSquared(const Eigen::Vector3f& offset) const noexcept {
  // eight at once, so that the compiler vectorizes it
  alignas(32) std::array<float, 8> least;
  least.fill(std::numeric_limits<float>::infinity());
  const float ox = offset.x();
  const float oy = offset.y();
  const float oz = offset.z();
  for (std::size_t i = 0; i < count_; i += 8) {
    for (std::size_t k = 0; k < 8; ++k) {
      const float dx = x_[i + k] - ox;
      const float dy = y_[i + k] - oy;
      const float dz = z_[i + k] - oz;
      const float squared = dx * dx + dy * dy + dz * dz;
      least[k] = squared < least[k] ? squared : least[k];
    }
  }
  return *std::min_element(least.begin(), least.end());
}

ProximityPair::VoxelPair ProximityPair::NearestVoxels(const RotatedFrame& X_BA) noexcept {
  VoxelPair best;
  const SurfaceTree& b = b_->surface;
  VisitNearPairs(
      a_->surface.tree(), b.tree(),
      [&](const BoxTree::Node& node_a, const BoxTree::Node& node_b) {
        return X_BA.Least(node_a.box, node_b.box);
      },
      [&] {
        return best.distance;
      },
      [&](const BoxTree::Node& leaf_a, const BoxTree::Node& leaf_b) {
        Load(leaf_a.first, X_BA);
        const SurfaceTree::Chunk& chunk = b.chunks()[leaf_b.first];
        VisitCells(chunk.bits, [&](std::size_t cell) {
          const Vec3 centre = b.CentreOf(chunk.first + BlockCell(cell));
          const Vec3 offset = centre - middle_B_;
          if (offset.norm() - radius_ >= best.distance) return;
          const Eigen::Vector3f at = offset.cast<float>();
          const float squared = LeastSquared(at);
          if (std::sqrt(static_cast<double>(squared)) >= best.distance) return;
          std::size_t i = 0;
          while (i + 1 < count_ && (Eigen::Vector3f(x_[i], y_[i], z_[i]) - at).squaredNorm() >
                                       squared * (1 + 1e-6F)) {
            ++i;
          }
          best.p_BA = middle_B_ + Vec3(x_[i], y_[i], z_[i]);
          best.p_BB = centre;
          best.distance = std::sqrt(static_cast<double>(squared));
        });
      });
  return best;
}

template <class Visit>
bool ProximityPair::AnyInside(const RotatedFrame& X_BA, const Visit& visit) noexcept {
  const Voxmap& map = b_->voxmap;
  if (map.empty()) return false;
  const double per_m = 1.0 / map.voxel_size();
  const Vec3 origin(map.origin().x, map.origin().y, map.origin().z);
  // the points of a chunk of A lie within this many chunks of B from the chunk's middle
  const int reach = static_cast<int>(
      std::ceil(kHalfDiagonal * 7 * a_->surface.voxel_size() * per_m / kChunkSide));
  const auto chunks = static_cast<std::uint32_t>(a_->surface.chunks().size());
  for (std::uint32_t c = 0; c < chunks; ++c) {
    const Vec3 middle = (X_BA.R * MiddleOf(c) + X_BA.p) * per_m - origin;
    if (map.ChunkValue(VoxelAt(middle) >> 3) > kSurfaceMark + reach) continue;
    Load(c, X_BA);
    for (std::size_t i = 0; i < count_; ++i) {
      const Vec3 centre = middle_B_ + Vec3(x_[i], y_[i], z_[i]);
      const GridIndex voxel = VoxelAt(centre * per_m - origin);
      if (map.Value(Field::kSurface, voxel) == kInteriorMark && visit(centre)) return true;
    }
  }
  return false;
}

bool ProximityPair::Enters(const Pose& X_BA, double apart) noexcept {
  // a voxel's centre is within half a diagonal of a place of A's surface: no surface of B that is
  // farther from A's can be between the two
  const double shallow = kHalfDiagonal * a_->surface.voxel_size();
  const Pose X_AB = X_BA.Inverse();
  return AnyInside(RotatedFrame(X_BA), [&](const Vec3& centre_B) {
    return apart > shallow || b_->winding->At(X_BA * ClosestTo(a_->mesh, X_AB * centre_B)) >= 0.5;
  });
}

Nearness ProximityPair::Nearest(const Pose& X_BA, const NearestOptions& options) noexcept {
  Nearness near;
  if (a_->surface.empty() || b_->surface.empty()) return near;
  const RotatedFrame turned(X_BA);
  loaded_ = kNone;
  const VoxelPair voxels = NearestVoxels(turned);
  const double slack = kHalfDiagonal * (a_->surface.voxel_size() + b_->surface.voxel_size()) +
                       kRounding * (voxels.distance + b_->surface.voxel_size());
  near.distance = voxels.distance;
  near.least = std::max(0.0, voxels.distance - slack);
  near.most = voxels.distance + slack;
  near.p_BA = voxels.p_BA;
  near.p_BB = voxels.p_BB;

  if (options.refine) {
    const ClosestPoints exact = FindClosestPoints(a_->mesh, X_BA, b_->mesh,
                                                  {.at_most = near.most,
                                                   .tolerance = 1e-3 * b_->surface.voxel_size(),
                                                   .most_pairs = options.most_pairs});
    near.least = std::max(near.least, std::min(exact.least, near.most));
    if (exact.distance <= near.most) {
      near.refined = true;
      near.most = exact.distance;
      // a search cut short has not excluded less: its bound is never worse than by voxels alone
      near.distance = std::min(exact.distance, near.least + slack);
      near.p_BA = exact.p_BA;
      near.p_BB = exact.p_BB;
      near.overlap = exact.distance <= 0;
    }
  }
  near.overlap = near.overlap || Enters(X_BA, near.least);
  const Vec3 apart = near.p_BA - near.p_BB;
  const bool beyond = voxels.distance > b_->voxmap.range() * b_->voxmap.voxel_size();
  const bool by_points = (near.refined || beyond) && !near.overlap && apart.norm() > 0;
  near.gradient_B = by_points ? Vec3(apart.normalized()) : VoxelGradient(*b_, near.p_BA);
  if (near.overlap) {
    if (options.depth) near.depth = DepthOfOverlap(*a_, *b_, X_BA);
    near.distance = 0;
    near.least = 0;
    near.most = 0;
  }
  return near;
}

ShadowCount ProximityPair::Shadow(const Pose& X_BA, double distance,
                                  std::span<Vec3> centres_B) noexcept {
  const SurfaceTree& b = b_->surface;
  const RotatedFrame turned(X_BA);
  const auto within = static_cast<float>(distance * distance * (1 + kRounding));
  loaded_ = kNone;
  VisitNearPairs(
      a_->surface.tree(), b.tree(),
      [&](const BoxTree::Node& node_a, const BoxTree::Node& node_b) {
        return turned.Least(node_a.box, node_b.box);
      },
      [&] {
        return distance;
      },
      [&](const BoxTree::Node& leaf_a, const BoxTree::Node& leaf_b) {
        const SurfaceTree::Chunk& chunk = b.chunks()[leaf_b.first];
        std::array<std::uint64_t, 8>& shade = in_shadow_[leaf_b.first];
        std::array<std::uint64_t, 8> open = chunk.bits;
        std::uint64_t before = 0;
        for (std::size_t z = 0; z < 8; ++z) {
          before |= shade[z];
          open[z] &= ~shade[z];
        }
        std::uint64_t after = 0;
        VisitCells(open, [&](std::size_t cell) {
          Load(leaf_a.first, turned);
          const Vec3 offset = b.CentreOf(chunk.first + BlockCell(cell)) - middle_B_;
          if (offset.norm() > distance + radius_) return;
          if (LeastSquared(offset.cast<float>()) > within) return;
          after |= std::uint64_t{1} << (cell & 63);
          shade[cell >> 6] |= std::uint64_t{1} << (cell & 63);
        });
        if (before == 0 && after != 0) shaded_.push_back(leaf_b.first);
      });
  ShadowCount count;
  for (const std::uint32_t c : shaded_) {
    VisitCells(in_shadow_[c], [&](std::size_t cell) {
      ++count.found;
      if (count.written == centres_B.size()) return;
      centres_B[count.written++] = b.CentreOf(b.chunks()[c].first + BlockCell(cell));
    });
    in_shadow_[c].fill(0);
  }
  shaded_.clear();
  return count;
}

}  // namespace tandem
