#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "engine/geometry/mesh/mass_properties.h"
#include "engine/geometry/mesh/triangle_mesh.h"

namespace tandem {

/// The mass properties of a union of solids.
struct UnionMass : MassProperties {
  /// Material that several solids share may count as often as they share it: telling it apart takes
  /// too much work, or failed.
  bool counts_twice = false;
};

/// Returns a bound on the work of ComputeUnionMass() for a mesh of that many triangles: visits of
/// boxes, pieces of triangles times the lines that cut them, clusters of winding numbers. Without
/// one, untrusted meshes take any time and memory; it lets fine meshes that cross through.
constexpr std::uint64_t MostUnionWork(std::size_t triangles) {
  constexpr std::uint64_t kLeast = 200'000'000;
  constexpr std::uint64_t kOfTriangle = 1500;
  constexpr std::uint64_t kMost = 4'000'000'000;
  return std::min(kMost, kLeast + kOfTriangle * triangles);
}

/// Computes the mass properties of a mesh as ComputeMassProperties() does, except that material
/// which several of its solids share counts once, and that bodies which are turned inside out count
/// as turned right. A solid is a set of triangles that are connected across their sides. A single
/// solid that crosses itself counts what it encloses twice as twice.
UnionMass ComputeUnionMass(const TriangleMesh& mesh, std::uint64_t most_work);
inline UnionMass ComputeUnionMass(const TriangleMesh& mesh) {
  return ComputeUnionMass(mesh, MostUnionWork(mesh.triangles.size()));
}

/// Words that follow those that name a mass, where a UnionMass counts twice.
inline constexpr const char* kCountsTwice =
    "may count what its solids share more than once, for they cross too often or not cleanly: "
    "join them in the program that made them";

}  // namespace tandem
