#include "app/view/model/scene/refined_mesh.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <utility>

namespace tandem {

namespace {

constexpr std::uint32_t kNone = ~std::uint32_t{0};

double SquaredLength(const ShadedMesh::Vertex& a, const ShadedMesh::Vertex& b) {
  double sum = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const double d = static_cast<double>(a.p[k]) - static_cast<double>(b.p[k]);
    sum += d * d;
  }
  return sum;
}

ShadedMesh::Vertex Between(const ShadedMesh::Vertex& a, const ShadedMesh::Vertex& b) {
  ShadedMesh::Vertex middle{};
  float squared = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    middle.p[k] = 0.5F * (a.p[k] + b.p[k]);
    middle.n[k] = a.n[k] + b.n[k];
    squared += middle.n[k] * middle.n[k];
  }
  if (squared <= 0) {
    middle.n = a.n;
    return middle;
  }
  for (float& x : middle.n) x /= std::sqrt(squared);
  return middle;
}

/// One round: cuts each side that is too long in its middle, in both triangles that share it.
class Round {
 public:
  Round(ShadedMesh& mesh, double longest) : mesh_(mesh), squared_(longest * longest) {}

  /// Returns whether a side was cut.
  bool Run() {
    std::vector<std::uint32_t> before = std::exchange(mesh_.triangles, {});
    mesh_.triangles.reserve(before.size());
    for (std::size_t i = 0; i < before.size(); i += 3) {
      Cut({before[i], before[i + 1], before[i + 2]});
    }
    return !middles_.empty();
  }

 private:
  std::uint32_t MiddleOf(std::uint32_t a, std::uint32_t b) {
    if (SquaredLength(mesh_.vertices[a], mesh_.vertices[b]) <= squared_) return kNone;
    const auto next = static_cast<std::uint32_t>(mesh_.vertices.size());
    const std::uint64_t key = std::uint64_t{std::min(a, b)} << 32U | std::max(a, b);
    const auto [entry, is_new] = middles_.try_emplace(key, next);
    if (is_new) {
      mesh_.vertices.push_back(
          Between(mesh_.vertices[std::min(a, b)], mesh_.vertices[std::max(a, b)]));
    }
    return entry->second;
  }

  void Add(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    mesh_.triangles.insert(mesh_.triangles.end(), {a, b, c});
  }

  void Cut(std::array<std::uint32_t, 3> v) {
    std::array<std::uint32_t, 3> m{};  // middles of the sides v0 v1, v1 v2, v2 v0
    std::size_t cuts = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      m[k] = MiddleOf(v[k], v[(k + 1) % 3]);
      cuts += m[k] != kNone ? 1 : 0;
    }
    if (cuts == 0) return Add(v[0], v[1], v[2]);
    if (cuts == 3) {
      Add(m[0], m[1], m[2]);
      for (std::size_t k = 0; k < 3; ++k) Add(v[k], m[k], m[(k + 2) % 3]);
      return;
    }
    // rotated so that the first side is cut and the third is whole
    const auto turned = [&] {
      return m[0] != kNone && m[2] == kNone;
    };
    while (!turned()) {
      std::rotate(v.begin(), v.begin() + 1, v.end());
      std::rotate(m.begin(), m.begin() + 1, m.end());
    }
    if (cuts == 1) {
      Add(v[0], m[0], v[2]);
      Add(m[0], v[1], v[2]);
      return;
    }
    Add(m[0], v[1], m[1]);
    const bool from_first = SquaredLength(mesh_.vertices[v[0]], mesh_.vertices[m[1]]) <=
                            SquaredLength(mesh_.vertices[m[0]], mesh_.vertices[v[2]]);
    if (from_first) {
      Add(v[0], m[0], m[1]);
      Add(v[0], m[1], v[2]);
    } else {
      Add(v[0], m[0], v[2]);
      Add(m[0], m[1], v[2]);
    }
  }

  ShadedMesh& mesh_;
  double squared_;
  std::unordered_map<std::uint64_t, std::uint32_t> middles_;
};

}  // namespace

void Refine(ShadedMesh& mesh, double longest, std::size_t most_vertices) {
  while (true) {
    ShadedMesh finer = mesh;
    if (!Round(finer, longest).Run() || finer.vertices.size() > most_vertices) return;
    if (finer.uncut_triangles.empty()) finer.uncut_triangles = mesh.triangles;
    mesh = std::move(finer);
  }
}

}  // namespace tandem
