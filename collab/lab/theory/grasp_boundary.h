#pragma once

#include <optional>
#include <vector>

#include "engine/dynamics/rigid_body.h"
#include "engine/haptics/hand_script.h"

namespace tandem {

/// One user's instance in all six axes: the body and all that moves with it, as one mass, one drag
/// and one spring, each a symmetric 6 x 6 matrix. The coordinates are the travel of the centre of
/// mass (m), then the turn times (I/m)^(1/2) (m), with I the body's inertia and m its mass. In
/// these coordinates the body's own mass matrix is m times the identity. A link's rotational
/// stiffness and damping are those of travel times I/m, so its matrices are multiples of the
/// identity too.
struct GraspedBody {
  Mat6 mass = Mat6::Identity();   // kg
  Mat6 damping = Mat6::Zero();    // N s/m, against the ground
  Mat6 stiffness = Mat6::Zero();  // N/m, towards the hand's goal
};

/// Returns the instance of a user who holds the body at `grasp_B`, m from the centre of mass, axes
/// of B. `ground_damping` is that of the coupling law, N s/m. The hand is rigidly fixed to the
/// body.
GraspedBody Grasp(const Inertia& body, const HandImpedance& hand, const Vec3& grasp_B,
                  double ground_damping);

/// N users who hold one body in free space, each with its own hand and grasp. The copies are late
/// by a constant delay. For small motions about rest, in the coordinates of GraspedBody, each
/// instance obeys
///
///   M_i x_i'' + D_i x_i' + S_i x_i = sum_j k (x_j(t - tau) - x_i) + bc (x_j'(t - tau) - x_i')
///
/// with K = (N-1) k and Bc = (N-1) bc. Its characteristic equation is
///
///   prod_i det(A_i + c) det(1 - c sum_i (A_i + c)^-1) = 0,
///   A_i = M_i s^2 + D_i s + S_i + K + Bc s,   c = (k + bc s) e^(-s tau).
struct GraspCoupling {
  std::vector<GraspedBody> users;
  double stiffness = 0;         // K, N/m, all links of an instance together
  double relative_damping = 0;  // Bc, N s/m, all links of an instance together
  double delay_s = 0.1;         // tau
};

/// Returns how many roots of the characteristic equation have a real part above `real_part` (1/s).
/// It counts how often the function's value turns about 0 along that line (the argument principle).
/// The count is exact but for roots within 1e-9 of the line.
int RootsRightOf(const GraspCoupling& model, double real_part);

/// Returns whether every mode decays. Modes of a common motion that no hand's spring holds may
/// drift.
bool IsStable(const GraspCoupling& model);

/// Returns the slowest rate of decay of all decaying modes, 1/s, to 5 %: minus the largest negative
/// real part. Rates are looked for between 1e-4 and 1 per second. Nothing where the coupling is not
/// stable.
std::optional<double> SlowestDecay(const GraspCoupling& model);

/// Returns the K (N/m), all else as given, at which the coupling becomes unstable, to 1 %. The
/// search goes up in steps of a quarter from `stable`, at which it must be stable. The least
/// damping over the delay is such a stiffness, because it is passive with any mass. Infinite where
/// there is none up to `most`.
double CriticalStiffness(GraspCoupling model, double stable, double most);

}  // namespace tandem
