#include "engine/geometry/exact/box_tree.h"

#include <array>
#include <numeric>

namespace tandem {
namespace {

constexpr int kBins = 16;
// Below this many levels items are halved by number, so that no tree is deeper than kMaxDepth.
constexpr int kCostLevels = 60;

double HalfArea(const Bounds& box) {
  const Vec3 s = box.size();
  return s.x() * s.y() + s.y() * s.z() + s.z() * s.x();
}

void Add(Bounds& box, const Bounds& other) {
  box.min = box.min.cwiseMin(other.min);
  box.max = box.max.cwiseMax(other.max);
}

class Builder {
 public:
  Builder(const std::vector<Bounds>& items, std::uint32_t leaf_size)
      : items_(items), leaf_size_(leaf_size) {
    tree_.order.resize(items.size());
    std::iota(tree_.order.begin(), tree_.order.end(), 0U);
    tree_.nodes.reserve(2 * items.size());
    if (!items.empty()) Build(0, static_cast<std::uint32_t>(items.size()), 0);
  }
  BoxTree Take() { return std::move(tree_); }

 private:
  void Build(std::uint32_t first, std::uint32_t end, int level) {
    const std::size_t at = tree_.nodes.size();
    tree_.nodes.emplace_back();
    Bounds box;
    Bounds centres;
    for (std::uint32_t i = first; i < end; ++i) {
      Add(box, items_[tree_.order[i]]);
      centres.Add(items_[tree_.order[i]].centre());
    }
    tree_.nodes[at].box = box;
    if (end - first <= leaf_size_) {
      tree_.nodes[at].first = first;
      tree_.nodes[at].count = end - first;
      return;
    }
    const std::uint32_t middle =
        level < kCostLevels ? Split(first, end, centres) : first + (end - first) / 2;
    Build(first, middle, level + 1);
    tree_.nodes[at].right = static_cast<std::uint32_t>(tree_.nodes.size());
    Build(middle, end, level + 1);
  }

  // Orders the items so that the two halves lie before and after the returned place.
  std::uint32_t Split(std::uint32_t first, std::uint32_t end, const Bounds& centres) {
    Eigen::Index axis = 0;
    const double extent = centres.size().maxCoeff(&axis);
    const auto begin = tree_.order.begin();
    if (extent > 0) {
      const auto bin_of = [&](std::uint32_t item) {
        const double place = (items_[item].centre()[axis] - centres.min[axis]) / extent;
        return std::min(kBins - 1, static_cast<int>(place * kBins));
      };
      const int cut = CheapestCut(first, end, bin_of);
      const auto middle = std::partition(begin + first, begin + end, [&](std::uint32_t item) {
        return bin_of(item) < cut;
      });
      const auto place = static_cast<std::uint32_t>(middle - begin);
      if (place > first && place < end) return place;
    }
    return first + (end - first) / 2;
  }

  template <typename BinOf>
  int CheapestCut(std::uint32_t first, std::uint32_t end, const BinOf& bin_of) const {
    std::array<Bounds, kBins> boxes;
    std::array<int, kBins> counts{};
    for (std::uint32_t i = first; i < end; ++i) {
      const auto bin = static_cast<std::size_t>(bin_of(tree_.order[i]));
      Add(boxes[bin], items_[tree_.order[i]]);
      ++counts[bin];
    }
    std::array<double, kBins> cost{};  // cost right of each cut, then of both sides
    Bounds right;
    int n = 0;
    for (std::size_t cut = kBins - 1; cut > 0; --cut) {
      Add(right, boxes[cut]);
      n += counts[cut];
      cost[cut] = n * HalfArea(right);
    }
    Bounds left;
    n = 0;
    int best = 1;
    for (std::size_t cut = 1; cut < kBins; ++cut) {
      Add(left, boxes[cut - 1]);
      n += counts[cut - 1];
      cost[cut] += n * HalfArea(left);
      if (cost[cut] < cost[static_cast<std::size_t>(best)]) best = static_cast<int>(cut);
    }
    return best;
  }

  const std::vector<Bounds>& items_;
  std::uint32_t leaf_size_;
  BoxTree tree_;
};

}  // namespace

BoxTree BuildBoxTree(const std::vector<Bounds>& items, std::uint32_t leaf_size) {
  return Builder(items, leaf_size).Take();
}

}  // namespace tandem
