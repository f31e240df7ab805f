#include "app/judgement/penetration_oracle.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <thread>

#include "app/judgement/exact_depth.h"
#include "engine/base/check.h"

namespace tandem {
namespace {

// Voxels; a depth below this is touching.
constexpr double kTouch = 1e-9;

struct Block {
  std::size_t series;
  std::size_t first;
  std::size_t end;
};

// Returns 0, 1, …, count - 1 in bit-reversed order, in which any first part is spread evenly.
std::vector<std::size_t> SpreadOrder(std::size_t count) {
  std::size_t size = 1;
  while (size < count) size *= 2;
  std::vector<std::size_t> order;
  std::size_t reversed = 0;
  for (std::size_t i = 0; i < size; ++i) {
    if (reversed < count) order.push_back(reversed);
    // adds one at the top bit, carrying downwards
    std::size_t bit = size / 2;
    while (bit > 0 && (reversed & bit) != 0) {
      reversed ^= bit;
      bit /= 2;
    }
    reversed |= bit;
  }
  return order;
}

bool Deeper(const PenetrationReport& a, const PenetrationReport& b) {
  if (a.max_penetration_voxels != b.max_penetration_voxels) {
    return a.max_penetration_voxels > b.max_penetration_voxels;
  }
  if (a.worst_series != b.worst_series) return a.worst_series < b.worst_series;
  return a.worst_pose < b.worst_pose;
}

}  // namespace

// Finds the deepest sample at a pose by branch and bound, with a memory over poses.
//
// Depth changes by no more than a point moves. Let a sphere of radius r have a centre that had
// depth d and has moved by s since. It holds no sample deeper than d + s + r. If that is no more
// than the depth found already (or than 0), the sphere needs no look at the geometry.
//
// The same bound tells when a look would be in vain, because the sphere has to be opened anyway. It
// also limits the search for the closest point. While s < |d|, the centre stays on its side of the
// surface. All this holds however far the next pose is; near poses only make it pay.
class PenetrationOracle::Search {
 public:
  struct Found {
    double depth;  // m; 0 if no sample is inside
    Vec3 p_F;
  };

  explicit Search(const PenetrationOracle& oracle)
      : fixture_(oracle.fixture_),
        tree_(oracle.samples_),
        touch_(kTouch * oracle.voxel_size_),
        memory_(tree_.node_count(), Memory{}) {
    if (memory_.empty()) return;
    SampleTree::Branch branch = tree_.root();
    while (!branch.leaf()) branch = branch.Left();
    worst_ = branch.node;
  }

  Found Deepest(const Pose& X_FB) {
    deepest_ = touch_;
    place_ = Vec3::Zero();
    if (memory_.empty() || fixture_.empty()) return {0, place_};
    R_FB_ = X_FB.q.normalized().toRotationMatrix();
    p_FBo_ = X_FB.p;
    Descend({worst_, 1});
    Descend(tree_.root());
    return {deepest_ > touch_ ? deepest_ : 0.0, place_};
  }

 private:
  struct Memory {
    Vec3 p_F = Vec3::Zero();
    double depth = std::numeric_limits<double>::infinity();  // infinite: never looked at
  };

  void Descend(SampleTree::Branch branch) {
    const SampleTree::Node& node = tree_[branch.node];
    Memory& memory = memory_[branch.node];
    const Vec3 p_F = R_FB_ * node.centre + p_FBo_;
    const double moved = (p_F - memory.p_F).norm();
    if (memory.depth + moved + node.radius <= deepest_) return;
    const bool known = std::isfinite(memory.depth);
    const bool in_vain = known && !branch.leaf() && memory.depth - moved + node.radius > deepest_;
    if (!in_vain) {
      ExactSurface::Hint hint;
      if (known) {
        hint.at_most = std::abs(memory.depth) + moved;
        // the factor leaves a margin for rounding
        if (moved < 0.999 * std::abs(memory.depth)) {
          hint.side = memory.depth > 0 ? ExactSurface::Side::kInside : ExactSurface::Side::kOutside;
        }
      }
      memory = {p_F, fixture_.Depth(p_F, hint)};
      if (memory.depth + node.radius <= deepest_) return;
    }
    if (branch.leaf()) {
      deepest_ = memory.depth;
      place_ = p_F;
      worst_ = branch.node;
      return;
    }
    const bool left_first = memory_[branch.Left().node].depth >= memory_[branch.Right().node].depth;
    Descend(left_first ? branch.Left() : branch.Right());
    Descend(left_first ? branch.Right() : branch.Left());
  }

  const ExactSurface& fixture_;
  const SampleTree& tree_;
  double touch_;
  std::vector<Memory> memory_;  // one for each node
  // leaf of the deepest sample at the previous pose, near which the next one is
  std::size_t worst_ = 0;
  Mat3 R_FB_ = Mat3::Identity();
  Vec3 p_FBo_ = Vec3::Zero();
  double deepest_ = 0;
  Vec3 place_ = Vec3::Zero();
};

PenetrationReport Merged(const PenetrationReport& first, const PenetrationReport& second,
                         std::size_t series_of_first) {
  PenetrationReport shifted = second;
  shifted.worst_series += series_of_first;
  PenetrationReport merged = Deeper(shifted, first) ? shifted : first;
  merged.overlapping_poses = first.overlapping_poses + second.overlapping_poses;
  merged.poses_checked = first.poses_checked + second.poses_checked;
  merged.poses_given = first.poses_given + second.poses_given;
  return merged;
}

double SampledVoxel(const TriangleMesh& mesh, double voxel_size, double most_samples) {
  return std::max(voxel_size, 2.0 * std::sqrt(SurfaceArea(mesh) / most_samples));
}

PenetrationOracle::PenetrationOracle(const TriangleMesh& fixture_F, const TriangleMesh& moving_B,
                                     double voxel_size)
    : voxel_size_(voxel_size),
      fixture_(fixture_F),
      moving_B_(moving_B),
      samples_(SampleSurface(moving_B, 0.5 * voxel_size)) {
  TANDEM_CHECK(voxel_size > 0);
}

double PenetrationOracle::PenetrationVoxels(const Pose& X_FB) const {
  return Search(*this).Deepest(X_FB).depth / voxel_size_;
}

PenetrationReport PenetrationOracle::Check(std::span<const std::vector<Pose>> series, int threads,
                                           const std::function<bool()>& out_of_time) const {
  TANDEM_CHECK(threads >= 1);
  std::vector<Block> blocks;
  PenetrationReport total;
  for (std::size_t s = 0; s < series.size(); ++s) {
    total.poses_given += series[s].size();
    for (std::size_t first = 0; first < series[s].size(); first += kBlock) {
      blocks.push_back({s, first, std::min(first + kBlock, series[s].size())});
    }
  }
  const std::vector<std::size_t> order = SpreadOrder(blocks.size());
  std::atomic<std::size_t> next{0};

  const auto work = [&](PenetrationReport& report) {
    Search search(*this);
    for (std::size_t i = next++; i < order.size(); i = next++) {
      const Block& block = blocks[order[i]];
      for (std::size_t k = block.first; k < block.end; ++k) {
        if (out_of_time()) return;
        const Search::Found found = search.Deepest(series[block.series][k]);
        ++report.poses_checked;
        if (found.depth <= 0) continue;
        ++report.overlapping_poses;
        PenetrationReport here;
        here.max_penetration_voxels = found.depth / voxel_size_;
        here.worst_series = block.series;
        here.worst_pose = k;
        if (report.overlapping_poses > 1 && !Deeper(here, report)) continue;
        report.max_penetration_voxels = here.max_penetration_voxels;
        report.worst_series = here.worst_series;
        report.worst_pose = here.worst_pose;
        report.p_FWorst = found.p_F;
      }
    }
  };
  std::vector<PenetrationReport> reports(static_cast<std::size_t>(threads));
  std::vector<std::thread> workers;
  for (std::size_t i = 1; i < reports.size(); ++i) {
    workers.emplace_back([&work, &reports, i] {
      work(reports[i]);
    });
  }
  work(reports[0]);
  for (std::thread& worker : workers) worker.join();

  const std::size_t given = total.poses_given;
  for (const PenetrationReport& report : reports) total = Merged(total, report, 0);
  total.poses_given = given;
  return total;
}

void PenetrationOracle::Refine(std::span<const std::vector<Pose>> series,
                               PenetrationReport& report) const {
  constexpr double kToVoxels = 0.005;
  if (report.overlapping_poses == 0) return;
  const BoundedDepth found =
      GreatestDepth(fixture_, moving_B_, series[report.worst_series][report.worst_pose],
                    report.max_penetration_voxels * voxel_size_, kToVoxels * voxel_size_);
  // no point of the mesh is farther from a sample than samples are apart
  report.error_voxels = std::min(report.error_voxels, found.error / voxel_size_);
  report.max_penetration_voxels = found.depth / voxel_size_;
}

}  // namespace tandem
