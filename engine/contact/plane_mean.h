#pragma once

#include <array>
#include <cstddef>

#include "engine/base/spatial.h"

namespace tandem {

/// Voxels: how far beside a piece of surface its plane still counts.
inline constexpr double kLateralReach = 1.25;
/// Voxels: a shell's surface point says something of a vertex up to here beside itself.
inline constexpr double kVertexReach = 1.25;
/// Voxels: over this difference of height one face of a convex edge takes over from the other.
inline constexpr double kTakeOver = 0.15;

/// What a vertex stands before: pieces of another body's surface near it, gathered into the faces
/// that they belong to. Each face keeps the mean of its pieces' planes, by how squarely the vertex
/// stands over each piece: exact over a plane, continuous as the vertex slides along.
///
/// Faces that meet in a convex edge or corner are one thing to stand on: over the edge it is the
/// way from the edge that counts, beside it the face. In a concave corner each pushes by itself.
/// Lengths in voxels.
class PlaneMean {
 public:
  /// One word: push the vertex along `normal`, which points out of the body.
  struct Push {
    Vec3 normal = Vec3::Zero();
    double gap = 0;    // of the vertex above it; negative below
    double share = 0;  // 0 to 1: how much of the push counts
  };
  static constexpr std::size_t kMostPushes = 4;
  /// The faces' normals of pieces of convex edges.
  struct Ridges {
    static constexpr std::size_t kMost = 27;
    std::size_t count = 0;
    std::array<std::array<Vec3, 2>, kMost> normals;

    void Add(const std::array<Vec3, 2>& of_faces) noexcept {
      if (count < kMost) normals[count++] = of_faces;
    }
  };

  /// Forgets all pieces. Cheaper than a new one.
  void Clear() noexcept { count_ = 0; }
  /// A piece of surface: a place on it, its outward normal, the vertex's height above its plane.
  void Add(const Vec3& place, const Vec3& normal, double height, double weight) noexcept;
  /// A piece of a convex edge: a place on it, its faces' normals, the heights above their planes.
  /// `facing`: whether the vertex may stand on that face. Over the edge the other one counts too:
  /// it tells how far the vertex is from the edge.
  void AddRidge(const Vec3& place, const std::array<Vec3, 2>& normals,
                const std::array<double, 2>& heights, const std::array<double, 2>& weights,
                const std::array<bool, 2>& facing) noexcept;

  /// The pushes of what the vertex stands on; gives how many.
  std::size_t Resolve(const Ridges& ridges, std::array<Push, kMostPushes>& pushes) const noexcept;

 private:
  static constexpr std::size_t kMostFaces = 4;
  struct Face {
    Vec3 first = Vec3::Zero();  // normal of its first piece
    Vec3 normal = Vec3::Zero();
    Vec3 place = Vec3::Zero();
    double height = 0;
    double weight = 0;
  };

  std::size_t count_ = 0;
  std::array<Face, kMostFaces> faces_;
};

}  // namespace tandem
