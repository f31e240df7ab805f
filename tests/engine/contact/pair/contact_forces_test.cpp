#include "engine/contact/pair/contact_forces.h"

#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace tandem {
namespace {

constexpr double kEdge = 1e-3;  // m; edge of a voxel

ForceRule Rule(double friction) {
  ForceRule rule{.gains = DefaultContactGains(kEdge, 0.3, 1e-3), .voxel_size = kEdge};
  rule.gains.friction = friction;
  return rule;
}

/// Returns places of which the map's body stands at the origin and the shell's moves. V is W.
PairPlaces Moving(const Twist& V_WB) {
  PairPlaces at;
  at.shell_body.V_WB = V_WB;
  return at;
}

Vec3 Drawn(std::mt19937_64& random) {
  std::uniform_real_distribution<double> even(-1, 1);
  return {even(random), even(random), even(random)};
}

/// Returns how the velocity of a point of the shell's body depends on the body's, moments first.
Eigen::Matrix<double, 3, 6> PointVelocity(const Vec3& r) {
  Eigen::Matrix<double, 3, 6> J;
  J << 0, r.z(), -r.y(), 1, 0, 0, -r.z(), 0, r.x(), 0, 1, 0, r.y(), -r.x(), 0, 0, 0, 1;
  return J;
}

// By virtual work: a damper d across the normal at a point is J^T d (1 - n n^T) J.
TEST(ContactForces, FrictionDampsTangentialMotion) {
  std::mt19937_64 random(4);
  const ForceRule rule = Rule(0.4);
  const Twist V{3.0 * Drawn(random), 0.1 * Drawn(random)};
  std::vector<Contact> contacts;
  for (int i = 0; i < 20; ++i) {
    contacts.push_back({0.05 * Drawn(random), Drawn(random).normalized(), 2e-4});
  }
  const std::vector<Contact> drawn = contacts;
  LinearizedForce shell;
  LinearizedForce map;
  AddContactForces(contacts, Moving(V), rule, shell, map);
  Vec6 force = Vec6::Zero();
  Mat6 damping = Mat6::Zero();
  Vec6 twist;
  twist << V.w, V.v;
  for (const Contact& contact : drawn) {
    const Eigen::Matrix<double, 3, 6> J = PointVelocity(contact.p_V);
    const Vec3 slip = J * twist;
    const Vec3& n = contact.nhat_V;
    const double pressed = ContactForce(rule.gains.stiffness, contact.depth, kEdge);
    const double pushed = std::max(0.0, pressed - rule.gains.damping * n.dot(slip));
    const Mat3 across = Mat3::Identity() - n * n.transpose();
    const double drag = 0.4 * std::min(pressed, pushed) / (across * slip).norm();
    force += J.transpose() * (pushed * n - drag * across * slip);
    const double along = pushed > 0 ? rule.gains.damping : 0.0;
    damping += J.transpose() * (along * n * n.transpose() + drag * across) * J;
  }
  EXPECT_LT((shell.force - force).norm(), 1e-10 * force.norm());
  EXPECT_LT((shell.damping - damping).norm(), 1e-10 * damping.norm());
  EXPECT_EQ((shell.damping - shell.damping.transpose()).norm(), 0.0);
}

}  // namespace
}  // namespace tandem
