#pragma once

#include <optional>
#include <vector>

#include "engine/dynamics/rigid_body.h"
#include "engine/haptics/hand_script.h"

namespace tandem {

/// One user's instance in all six axes: the body and what moves with it, as one mass, one drag and
/// one spring, each a symmetric 6 x 6 matrix. Coordinates: travel of the centre of mass (m), then
/// the turn times (I/m)^(1/2) (m), I the body's inertia and m its mass. In them the body's own mass
/// matrix is m times the identity, and a link's stiffness and damping, whose rotational parts are
/// those of travel times I/m, are multiples of the identity.
struct GraspedBody {
  Mat6 mass = Mat6::Identity();   // kg
  Mat6 damping = Mat6::Zero();    // N s/m, against the ground
  Mat6 stiffness = Mat6::Zero();  // N/m, to where the hand means to be
};

/// `grasp_B`: where the hand holds the body, m from the centre of mass, axes of B.
/// `ground_damping`: of the coupling law, N s/m. The hand is taken to be rigidly at the body.
GraspedBody Grasp(const Inertia& body, const HandImpedance& hand, const Vec3& grasp_B,
                  double ground_damping);

/// N users who hold one body in free space, each with a hand and a grasp of their own; the copies
/// are constantly late. In the coordinates of GraspedBody, small motions about rest:
///
///   M_i x_i'' + D_i x_i' + S_i x_i = sum_j k (x_j(t - tau) - x_i) + bc (x_j'(t - tau) - x_i')
///
/// with K = (N-1) k and Bc = (N-1) bc. Its characteristic equation is
///
///   prod_i det(A_i + c) det(1 - c sum_i (A_i + c)^-1) = 0,
///   A_i = M_i s^2 + D_i s + S_i + K + Bc s,   c = (k + bc s) e^(-s tau).
struct GraspCoupling {
  std::vector<GraspedBody> users;
  double stiffness = 0;         // K, N/m, of all links of an instance
  double relative_damping = 0;  // Bc, N s/m, likewise
  double delay_s = 0.1;         // tau
};

/// How many roots of the characteristic equation have a real part above `real_part` (1/s), counted
/// by how often its value turns about nothing along that line (the argument principle). Exact but
/// for roots within 1e-9 of the line.
int RootsRightOf(const GraspCoupling& model, double real_part);

/// Whether every mode dies out. Modes of a common motion that no hand's spring holds may drift.
bool IsStable(const GraspCoupling& model);

/// How fast the slowest of all modes that die out does, 1/s: minus the largest real part below
/// nothing, to 5 %. Nothing where the coupling is not stable.
std::optional<double> SlowestDecay(const GraspCoupling& model);

/// The K (N/m), all else as given, at which the coupling ceases to be stable, to 1 %, looked for in
/// steps of a quarter from `stable` on, at which it is known to be: least damping over delay, which
/// is passive whatever the masses. Infinite where there is none up to `most`.
double CriticalStiffness(GraspCoupling model, double stable, double most);

}  // namespace tandem
