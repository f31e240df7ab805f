#pragma once

#include <utility>

#include "engine/contact/contact_pair.h"
#include "engine/voxel/voxelize.h"
#include "tests/support/shapes.h"

namespace tandem::testing {

inline constexpr double kS = 0.001;  // m, a voxel
inline constexpr ContactGains kGains{1000.0,
                                     20};  // 1 N a voxel: forces are depths, hardening apart

/// A fixed solid and a moving one, refined: the moving mesh is given in its body's frame, its
/// points stand `spacing` voxels apart.
struct Refined {
  static constexpr std::size_t kMostAtCrossing = 2;  // as of MetByField
  static constexpr double kLeastOfACorner = 0.3;
  static constexpr bool kRimsPush = false;

  Refined(const TriangleMesh& fixed_W, const TriangleMesh& moving_B, const Quat& made_at,
          double spacing = 1)
      : voxmap(std::move(*Voxelize(
            fixed_W,
            {.voxel_size = kS, .flatness_voxels = FlatnessVoxels(ContactModel::kRefined)}))),
        details(fixed_W, FlatnessVoxels(ContactModel::kRefined), voxmap),
        shell(std::move(
            *MakePointshell(Transformed(moving_B, {made_at, Vec3::Zero()}), {made_at, Vec3::Zero()},
                            {.spacing = spacing * kS,
                             .place = PointPlace::kOnFeature,
                             .flatness_voxels = FlatnessVoxels(ContactModel::kRefined)}))),
        pair(shell, voxmap, {Quat::Identity(), voxmap.p_WVo()}, 1.0,
             {.force_layer = DefaultForceLayer(ContactModel::kRefined),
              .details = &details,
              .schedule = {}},
             kGains) {}

  Load LoadAt(const Pose& X_WB, const Twist& V_WB = {}) {
    Load on_shell;
    Load on_map;
    pair.Collide({X_WB, V_WB}, {}, on_shell, on_map);
    return on_shell;
  }
  Vec3 ForceAt(const Pose& X_WB) { return AsWrench(LoadAt(X_WB).force).f; }
  Vec3 SettledForceAt(const Pose& X_WB) { return ForceAt(X_WB); }
  Vec3 FirstForceAt(const Pose& X_WB) { return ForceAt(X_WB); }

  Voxmap voxmap;
  SurfaceDetails details;
  Pointshell shell;
  ContactPair pair;
};

/// The least height of a mesh's vertices along `normal`, turned by q.
inline double LowestAlong(const TriangleMesh& mesh, const Quat& q, const Vec3& normal) {
  double lowest = 1e300;
  for (const Vec3& v : mesh.vertices) lowest = std::min(lowest, normal.dot(q * v));
  return lowest;
}

/// A plate whose upper face is the plane through `place` with the normal q z.
inline TriangleMesh Plate(const Quat& q, const Vec3& place) {
  return Transformed(Box(kS * Vec3(120, 120, 14)), {q, place - q * Vec3(0, 0, 7 * kS)});
}

}  // namespace tandem::testing
