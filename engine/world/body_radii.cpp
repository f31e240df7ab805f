#include "engine/world/body_radii.h"

#include <algorithm>

#include <Eigen/Eigenvalues>

namespace tandem {

AxisRadii AxisRadiiOf(const WorldModel& model, std::size_t body) {
  const BodyModel& of = model.bodies[body];
  AxisRadii found;
  found.radius = of.radius;
  found.radii = Vec3::Constant(of.radius);
  if (model.scene.contact != ContactModel::kRefined) return found;
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(of.inertia.I_B);
  if (solver.info() != Eigen::Success) return found;
  found.axes_B = solver.eigenvectors();
  Vec3 squares = Vec3::Zero();
  const Pose X_BW = of.X_WB0.Inverse();
  for (std::size_t i = 0; i < model.meshes_W.size(); ++i) {
    if (model.body_index[i] != static_cast<int>(body)) continue;
    for (const Vec3& vertex_W : model.meshes_W[i].vertices) {
      const Vec3 along = found.axes_B.transpose() * (X_BW * vertex_W);
      const Vec3 across = Vec3::Constant(along.squaredNorm()) - along.cwiseAbs2();
      squares = squares.cwiseMax(across);
    }
  }
  constexpr double kRounding = 1 + 1e-9;
  found.radii = kRounding * squares.cwiseSqrt();
  return found;
}

}  // namespace tandem
