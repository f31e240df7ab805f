#include "engine/contact/pair/contact_forces.h"

#include <algorithm>

#include "engine/contact/pair/friction.h"

namespace tandem {

namespace {

/// Turns vectors and matrices about a point from V to W.
LinearizedForce Turned(const LinearizedForce& load_V, const Mat3& R_WV) {
  Mat6 R = Mat6::Zero();
  R.topLeftCorner<3, 3>() = R_WV;
  R.bottomRightCorner<3, 3>() = R_WV;
  return {R * load_V.force, R * load_V.stiffness * R.transpose(),
          R * load_V.damping * R.transpose()};
}

/// m += k v v^T, for a symmetric matrix of which only the lower triangle is kept.
void AddLower(const Vec6& v, double k, Mat6& m) {
  for (Eigen::Index column = 0; column < 6; ++column) {
    const double kv = k * v[column];
    for (Eigen::Index row = column; row < 6; ++row) m(row, column) += kv * v[row];
  }
}

void MirrorLower(Mat6& m) {
  m.triangularView<Eigen::StrictlyUpper>() = m.transpose();
}

/// Brings forces, moments first, from one point to another. The first lies at `r` from the other.
Mat6 AboutAnotherPoint(const Vec3& r) {
  Mat6 T = Mat6::Identity();
  T.topRightCorner<3, 3>() << 0, -r.z(), r.y(), r.z(), 0, -r.x(), -r.y(), r.x(), 0;
  return T;
}

CrossJacobian Turned(const CrossJacobian& cross_V, const Mat3& R_WV) {
  Mat6 R = Mat6::Zero();
  R.topLeftCorner<3, 3>() = R_WV;
  R.bottomRightCorner<3, 3>() = R_WV;
  return {R * cross_V.stiffness * R.transpose(), R * cross_V.damping * R.transpose()};
}

/// Sums dampers that hold points in all directions, about the body's centre of mass: d G G^T each,
/// with G = [[r]x; I]. A contact's friction is that without its part along the normal.
class PointDampers {
 public:
  void Add(double damping, const Vec3& r) {
    sum_ += damping;
    r_ += damping * r;
    rr_ += damping * r * r.transpose();
  }
  void AddLowerTo(Mat6& m) const {
    m.topLeftCorner<3, 3>() += rr_.trace() * Mat3::Identity() - rr_;
    m(3, 1) += r_.z();
    m(3, 2) -= r_.y();
    m(4, 0) -= r_.z();
    m(4, 2) += r_.x();
    m(5, 0) += r_.y();
    m(5, 1) -= r_.x();
    m.diagonal().tail<3>().array() += sum_;
  }

 private:
  double sum_ = 0;
  Vec3 r_ = Vec3::Zero();
  Mat3 rr_ = Mat3::Zero();
};

}  // namespace

CrossJacobian AddContactForces(std::span<Contact> contacts, const PairPlaces& at,
                               const ForceRule& rule, LinearizedForce& on_shell,
                               LinearizedForce& on_map) noexcept {
  if (contacts.empty()) return {};
  const Quat q_VW = at.X_WV.q.conjugate();
  const Vec3 p_VS = at.X_VS.p;                               // shell body's centre of mass
  const Vec3 p_VM = at.X_WV.Inverse() * at.map_body.X_WB.p;  // voxmap body's
  const Vec3 w_shell = q_VW * at.shell_body.V_WB.w;
  const Vec3 v_shell = q_VW * at.shell_body.V_WB.v;
  const Vec3 w_map = q_VW * at.map_body.V_WB.w;
  const Vec3 v_map = q_VW * at.map_body.V_WB.v;
  const double friction = rule.gains.friction;
  PointDampers rubbing;
  LinearizedForce shell_V;
  for (Contact& contact : contacts) {
    const Vec3& p = contact.p_V;
    const Vec3& n = contact.nhat_V;
    const double depth = contact.depth;
    const Vec3 r_shell = p - p_VS;
    const Vec3 slip = v_shell + w_shell.cross(r_shell) - v_map - w_map.cross(p - p_VM);
    const double approach = -n.dot(slip);
    // contact pushes and never pulls, whatever the speed at which the point leaves
    const double K = contact.share * rule.gains.stiffness;
    const double soft = rule.full_stiffness_depth * rule.voxel_size;
    const double stiffness = ContactStiffness(K, depth, rule.voxel_size, soft);
    const double pressed = ContactForce(K, depth, rule.voxel_size, soft);
    contact.force = pressed;
    const double full = rule.full_damping_depth * rule.voxel_size;
    const double damped = full > 0 ? std::min(1.0, depth / full) : 1.0;
    const double damping_there = contact.share * damped * rule.gains.damping;
    const double force = std::max(0.0, pressed + damping_there * approach);
    const double damping = force > 0 ? damping_there : 0.0;
    Vec6 along;  // the generalized direction of a unit force on the point
    along << r_shell.cross(n), n;
    shell_V.force += force * along;
    AddLower(along, stiffness, shell_V.stiffness);
    double drag = 0;
    if (friction > 0) {
      // damping that stops an approach is no pressure yet: a graze would stick
      const Vec3 sliding = slip + approach * n;
      drag = FrictionDamping(friction, std::min(pressed, force), sliding.norm());
      shell_V.force.head<3>() -= drag * r_shell.cross(sliding);
      shell_V.force.tail<3>() -= drag * sliding;
      rubbing.Add(drag, r_shell);
    }
    AddLower(along, damping - drag, shell_V.damping);
  }
  if (friction > 0) rubbing.AddLowerTo(shell_V.damping);
  MirrorLower(shell_V.stiffness);
  MirrorLower(shell_V.damping);
  // the same forces on the map's body, about its own centre of mass
  const Mat6 T = AboutAnotherPoint(p_VS - p_VM);
  const LinearizedForce map_V{-T * shell_V.force, T * shell_V.stiffness * T.transpose(),
                              T * shell_V.damping * T.transpose()};
  const Mat3 R_WV = at.X_WV.q.toRotationMatrix();
  on_shell += Turned(shell_V, R_WV);
  on_map += Turned(map_V, R_WV);
  return Turned(CrossJacobian{shell_V.stiffness * T.transpose(), shell_V.damping * T.transpose()},
                R_WV);
}

}  // namespace tandem
