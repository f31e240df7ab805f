#pragma once

#include <array>
#include <cstddef>

#include "engine/base/spatial.h"

namespace tandem {

/// What a vertex stands before: pieces of another body's surface near it, gathered into the faces
/// that they belong to. Each face keeps the mean of its pieces' planes, by how squarely the vertex
/// stands over each piece: exact over a plane, continuous as the vertex slides along.
///
/// Two faces that meet in a convex edge hold the vertex off together, so only the one that it is
/// farther above counts; in a concave corner each pushes by itself. Lengths in voxels.
class PlaneMean {
 public:
  /// One face's word: push the vertex along `normal`, which is the face's outward one.
  struct Push {
    Vec3 normal = Vec3::Zero();
    double gap = 0;    // of the vertex above the face; negative below
    double share = 0;  // 0 to 1: how much of the push counts
  };
  static constexpr std::size_t kMostFaces = 4;

  /// A piece of surface: a place on it, its outward normal, the vertex's height above its plane.
  void Add(const Vec3& place, const Vec3& normal, double height, double weight) noexcept;

  /// The pushes of the faces; gives how many.
  std::size_t Resolve(std::array<Push, kMostFaces>& pushes) const noexcept;

 private:
  struct Face {
    Vec3 first = Vec3::Zero();  // normal of its first piece
    Vec3 normal = Vec3::Zero();
    Vec3 place = Vec3::Zero();
    double height = 0;
    double weight = 0;
  };
  std::array<Face, kMostFaces> faces_;
  std::size_t count_ = 0;
};

}  // namespace tandem
