#include "engine/geometry/mesh/mesh_sides.h"

#include <algorithm>
#include <numeric>

namespace tandem {

MeshSides::MeshSides(const TriangleMesh& mesh) {
  FindSides(mesh);
  FindBodies(mesh);
}

void MeshSides::FindBodies(const TriangleMesh& mesh) {
  HugeVector<std::uint32_t> parent(mesh.vertices.size());
  std::iota(parent.begin(), parent.end(), 0U);
  const auto find = [&](std::uint32_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  for (const auto& [a, b, c] : mesh.triangles) {
    const std::uint32_t i = find(a);
    const std::uint32_t j = find(b);
    const std::uint32_t k = find(c);
    parent[i] = parent[j] = parent[k] = std::min({i, j, k});
  }
  HugeVector<std::uint32_t> number(mesh.vertices.size(), kNone);
  body_of_.resize(mesh.triangles.size());
  for (std::size_t t = 0; t < body_of_.size(); ++t) {
    std::uint32_t& body = number[find(mesh.triangles[t][0])];
    if (body == kNone) body = static_cast<std::uint32_t>(bodies_++);
    body_of_[t] = body;
  }
}

void MeshSides::FindSides(const TriangleMesh& mesh) {
  across_.assign(3 * mesh.triangles.size(), kNone);
  // sides by their lesser vertex, so that the sides of an edge stand close together
  HugeVector<std::uint32_t> first(mesh.vertices.size() + 1, 0);
  for (const auto& [a, b, c] : mesh.triangles) {
    if (a != b) ++first[std::min(a, b) + 1];
    if (b != c) ++first[std::min(b, c) + 1];
    if (c != a) ++first[std::min(c, a) + 1];
  }
  std::partial_sum(first.begin(), first.end(), first.begin());
  struct Entry {
    std::uint32_t greater;
    std::uint32_t side;
  };
  HugeVector<Entry> entries(first.back());
  HugeVector<std::uint32_t> next(first.begin(), first.end() - 1);
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t a = mesh.triangles[t][k];
      const std::uint32_t b = mesh.triangles[t][k == 2 ? 0 : k + 1];
      if (a != b) entries[next[std::min(a, b)]++] = {std::max(a, b), 3 * t + k};
    }
  }
  const auto upward = [&](std::uint32_t side) {
    const TriangleMesh::Triangle& t = mesh.triangles[side / 3];
    return t[side % 3] < t[(side % 3 + 1) % 3];
  };
  for (std::size_t v = 0; v + 1 < first.size(); ++v) {
    // a handful of entries that stand in the order of their sides
    for (std::uint32_t i = first[v] + 1; i < first[v + 1]; ++i) {
      const Entry entry = entries[i];
      std::uint32_t to = i;
      for (; to > first[v] && entries[to - 1].greater > entry.greater; --to) {
        entries[to] = entries[to - 1];
      }
      entries[to] = entry;
    }
    for (std::uint32_t i = first[v]; i < first[v + 1];) {
      std::uint32_t end = i + 1;
      while (end < first[v + 1] && entries[end].greater == entries[i].greater) ++end;
      const std::uint32_t one = entries[i].side;
      if (end - i == 2 && upward(one) != upward(entries[i + 1].side)) {
        across_[one] = entries[i + 1].side / 3;
        across_[entries[i + 1].side] = one / 3;
      } else {
        walls_.push_back({.ends = {static_cast<std::uint32_t>(v), entries[i].greater},
                          .first = static_cast<std::uint32_t>(wall_sides_.size()),
                          .count = end - i});
        for (std::uint32_t side = i; side < end; ++side) wall_sides_.push_back(entries[side].side);
      }
      i = end;
    }
  }
}

}  // namespace tandem
