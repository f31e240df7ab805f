#pragma once

#include <algorithm>
#include <utility>

#include "engine/contact/field/field_pair.h"
#include "engine/contact/pair/contact_kind.h"
#include "engine/field/build/field_builder.h"
#include "tests/support/shapes.h"

namespace tandem::testing {

inline constexpr double kS = 0.001;  // m, a voxel
inline constexpr ContactGains kGains{1000.0,
                                     20};  // 1 N a voxel: forces are depths, hardening apart

/// Returns a solid as refined contact meets it, made where it stands turned by `made_at`, with its
/// edges in parts of at most `spacing` voxels.
inline BodySurface SurfaceOf(const TriangleMesh& mesh_B, const Quat& made_at, double spacing = 1) {
  const Pose X_WB{made_at, Vec3::Zero()};
  const TriangleMesh mesh_W = Transformed(mesh_B, X_WB);
  BodySurface surface;
  surface.field = std::move(*BuildField(mesh_W, {.voxel_size = kS}));
  const Pose X_WV{Quat::Identity(), surface.field.p_WVo()};
  const double flatness = FlatnessVoxels(ContactModel::kRefined) * kS;
  const std::vector<FeaturePoint> points =
      FindFeaturePoints(mesh_W, FindFeatures(mesh_W, flatness), kS, spacing);
  surface.X_BV = X_WB.Inverse() * X_WV;
  surface.features = BodyFeatures(points, {Quat::Identity(), -X_WV.p / kS});
  for (const Vec3& v : mesh_B.vertices) surface.radius = std::max(surface.radius, v.norm());
  return surface;
}

/// A fixed solid and a moving one: the moving mesh is given in its body's frame.
struct Refined {
  Refined(const TriangleMesh& fixed_W, const TriangleMesh& moving_B, const Quat& made_at,
          double spacing = 1, const FieldPair::Options& options = {})
      : map(SurfaceOf(fixed_W, Quat::Identity())),
        shell(SurfaceOf(moving_B, made_at, spacing)),
        pair(shell, map, options, kGains) {}

  LinearizedForce LoadAt(const Pose& X_WB, const Twist& V_WB = {}) {
    on_shell = {};
    on_map = {};
    pair.Collide({X_WB, V_WB}, {}, on_shell, on_map);
    return on_shell;
  }
  Vec3 ForceAt(const Pose& X_WB) { return AsWrench(LoadAt(X_WB).force).f; }
  /// Stays until force begins as far off as it may: after opposite sides have pushed, it begins
  /// nearer for some frames.
  Vec3 SettledForceAt(const Pose& X_WB) {
    for (int frame = 0; frame < 60; ++frame) ForceAt(X_WB);
    return ForceAt(X_WB);
  }
  /// Returns the force where nothing was before.
  Vec3 FirstForceAt(const Pose& X_WB) {
    return AsWrench(pair.Read({X_WB, {}}, {}).on_shell.force).f;
  }

  BodySurface map;
  BodySurface shell;
  FieldPair pair;
  LinearizedForce on_shell;  // load of the last LoadAt()
  LinearizedForce on_map;
};

/// Returns the least height of a mesh's vertices along `normal`, turned by q.
inline double LowestAlong(const TriangleMesh& mesh, const Quat& q, const Vec3& normal) {
  double lowest = 1e300;
  for (const Vec3& v : mesh.vertices) lowest = std::min(lowest, normal.dot(q * v));
  return lowest;
}

/// Returns a plate whose upper face is the plane through `place` with the normal q z.
inline TriangleMesh Plate(const Quat& q, const Vec3& place) {
  return Transformed(Box(kS * Vec3(120, 120, 14)), {q, place - q * Vec3(0, 0, 7 * kS)});
}

}  // namespace tandem::testing
