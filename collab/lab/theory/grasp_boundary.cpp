#include "collab/lab/theory/grasp_boundary.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>

#include <Eigen/Dense>

namespace tandem {

namespace {

using Complex = std::complex<double>;
using CMat6 = Eigen::Matrix<Complex, 6, 6>;

constexpr double kBesideTheAxis = 1e-7;  // 1/s
constexpr double kLeastStep = 1e-9;      // relative to the frequency

Mat3 Cross(const Vec3& p) {
  Mat3 cross;
  cross << 0, -p.z(), p.y(), p.z(), 0, -p.x(), -p.y(), p.x(), 0;
  return cross;
}

/// Returns the motion of a user to whom the other users' copies stand still.
Eigen::Matrix<double, 12, 12> StandingCopies(const GraspCoupling& model, const GraspedBody& user) {
  const Mat6 inverse = user.mass.inverse();
  const Mat6 springs = user.stiffness + model.stiffness * Mat6::Identity();
  const Mat6 drags = user.damping + model.relative_damping * Mat6::Identity();
  Eigen::Matrix<double, 12, 12> motion;
  motion << Mat6::Zero(), Mat6::Identity(), -inverse * springs, -inverse * drags;
  return motion;
}

/// The characteristic function divided by that of standing copies, prod det A_i, with the zeros of
/// the latter as poles. No mode of standing copies grows. So for a line left of which all poles
/// lie, the quotient turns about 0 as often as the characteristic function has roots to the right.
class Quotient {
 public:
  explicit Quotient(const GraspCoupling& model) : model_(model) {
    for (const GraspedBody& user : model.users) {
      least_mass_ =
          std::min(least_mass_, user.mass.selfadjointView<Eigen::Lower>().eigenvalues().minCoeff());
      const Eigen::EigenSolver<Eigen::Matrix<double, 12, 12>> solver(StandingCopies(model, user),
                                                                     false);
      for (int i = 0; i < 12; ++i) {
        if (solver.eigenvalues()[i].imag() >= 0) poles_.push_back(solver.eigenvalues()[i]);
      }
    }
  }

  /// Fills in the matrices whose determinants' product is the quotient at s: A_i^-1 (A_i + c) for
  /// each user, and 1 - c sum_i (A_i + c)^-1.
  void FactorsAt(Complex s, std::vector<CMat6>& factors) const {
    const double links = std::max(1.0, static_cast<double>(model_.users.size()) - 1.0);
    const Complex own = model_.stiffness + model_.relative_damping * s;
    const Complex copy = own / links * std::exp(-s * model_.delay_s);
    factors.clear();
    CMat6 rest = CMat6::Identity();
    for (const GraspedBody& user : model_.users) {
      CMat6 A = user.mass.cast<Complex>() * (s * s) + user.damping.cast<Complex>() * s +
                user.stiffness.cast<Complex>();
      A.diagonal().array() += own;
      factors.emplace_back(CMat6::Identity() + copy * A.inverse());
      A.diagonal().array() += copy;
      rest -= copy * A.inverse();
    }
    factors.push_back(rest);
  }

  /// Returns the number of roots of standing copies to the right of that line.
  int PolesRightOf(double real_part) const {
    int count = 0;
    for (const Complex& pole : poles_) {
      if (pole.real() > real_part) count += pole.imag() > 0 ? 2 : 1;
    }
    return count;
  }

  /// Returns a safe step along the line from s. The quotient changes with the distance from its
  /// poles and from the roots at 0. Its late terms also turn it once in each delay.
  double Step(Complex s) const {
    double step = kNearness * std::max(std::abs(s), kBesideTheAxis);
    for (const Complex& pole : poles_) step = std::min(step, kNearness * std::abs(s - pole));
    const double late = std::exp(std::max(0.0, -s.real() * model_.delay_s)) *
                        (model_.stiffness + model_.relative_damping * std::abs(s)) /
                        (least_mass_ * std::norm(s));
    return std::min(step, kTurnOfDelay / (model_.delay_s * std::min(1.0, late) + 1e-9));
  }

  /// Returns a frequency beyond which the late terms are negligible (rad/s).
  double Highest(double real_part) const {
    double highest = 1;
    const double late = std::exp(std::max(0.0, -real_part * model_.delay_s));
    for (const GraspedBody& user : model_.users) {
      const double inverse = user.mass.inverse().trace();
      const double more = 6.0 * late * static_cast<double>(model_.users.size());
      highest = std::max({highest, more * model_.relative_damping * inverse,
                          std::sqrt(more * model_.stiffness * inverse)});
    }
    for (const Complex& pole : poles_) highest = std::max(highest, 2.0 * std::abs(pole.imag()));
    return highest;
  }

 private:
  static constexpr double kTurnOfDelay = 0.5;  // rad
  static constexpr double kNearness = 0.5;     // share of the distance to the nearest pole

  const GraspCoupling& model_;
  double least_mass_ = std::numeric_limits<double>::infinity();
  std::vector<Complex> poles_;
};

/// Returns the angle from the determinant of `from` to that of `to`, rad, whole turns included.
/// Returns nothing where the two are too far apart to tell. Their ratio is so near the identity
/// that on the straight way to it no pivot leaves the right half plane.
std::optional<double> TurnBetween(const CMat6& from, const CMat6& to) {
  constexpr double kTellable = 0.5;
  CMat6 ratio = to * from.inverse();
  if (!((ratio - CMat6::Identity()).cwiseAbs().rowwise().sum().maxCoeff() < kTellable)) {
    return std::nullopt;
  }
  double turn = 0;
  for (int i = 0; i < 6; ++i) {
    turn += std::arg(ratio(i, i));
    for (int j = i + 1; j < 6; ++j) {
      ratio.row(j) -= ratio(j, i) / ratio(i, i) * ratio.row(i);
    }
  }
  return turn;
}

std::optional<double> TurnOf(const std::vector<CMat6>& from, const std::vector<CMat6>& to) {
  double turn = 0;
  for (std::size_t i = 0; i < from.size(); ++i) {
    const std::optional<double> one = TurnBetween(from[i], to[i]);
    if (!one) return std::nullopt;
    turn += *one;
  }
  return turn;
}

/// Returns the dimensions of a common motion that no hand's spring holds; as many roots are at 0.
int FreeDimensions(const GraspCoupling& model) {
  Mat6 springs = Mat6::Zero();
  for (const GraspedBody& user : model.users) springs += user.stiffness;
  const Eigen::Matrix<double, 6, 1> values = springs.selfadjointView<Eigen::Lower>().eigenvalues();
  return static_cast<int>((values.array() <= 1e-9).count());
}

}  // namespace

GraspedBody Grasp(const Inertia& body, const HandImpedance& hand, const Vec3& grasp_B,
                  double ground_damping) {
  // x = (p, S theta), S = (I/m)^(1/2); the grasp point moves by p + theta x grasp
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(body.I_B / body.mass);
  const Mat3 per_turn = solver.operatorInverseSqrt();
  Eigen::Matrix<double, 3, 6> place;
  place << Mat3::Identity(), -Cross(grasp_B) * per_turn;
  Eigen::Matrix<double, 3, 6> turn;
  turn << Mat3::Zero(), per_turn;
  const auto of_hand = [&](double travel, double rotation) -> Mat6 {
    return travel * place.transpose() * place + rotation * turn.transpose() * turn;
  };
  GraspedBody grasped;
  grasped.mass = body.mass * Mat6::Identity() + of_hand(hand.mass, hand.inertia);
  grasped.damping =
      ground_damping * Mat6::Identity() + of_hand(hand.damping, hand.rotation_damping);
  grasped.stiffness = of_hand(hand.stiffness, hand.rotation_stiffness);
  return grasped;
}

int RootsRightOf(const GraspCoupling& model, double real_part) {
  const Quotient quotient(model);
  const double highest = quotient.Highest(real_part);
  std::vector<CMat6> here;
  std::vector<CMat6> next;
  quotient.FactorsAt({real_part, 0}, here);
  double turned = 0;
  double w = 0;
  double last = kBesideTheAxis;
  while (w < highest) {
    double step = std::min(2.0 * last, quotient.Step({real_part, w}));
    std::optional<double> turn;
    for (;;) {
      quotient.FactorsAt({real_part, w + step}, next);
      turn = TurnOf(here, next);
      if (turn || step < kLeastStep * (1.0 + w)) break;
      step *= 0.4;
    }
    turned += turn.value_or(0);
    w += step;
    last = step;
    std::swap(here, next);
  }
  // the other half of the line mirrors this one; up the line the quotient turns backwards once for
  // each root
  return quotient.PolesRightOf(real_part) - static_cast<int>(std::lround(turned / M_PI));
}

bool IsStable(const GraspCoupling& model) {
  return RootsRightOf(model, kBesideTheAxis) == 0;
}

std::optional<double> SlowestDecay(const GraspCoupling& model) {
  if (!IsStable(model)) return std::nullopt;
  const int at_nothing = FreeDimensions(model);
  const auto all_faster = [&](double decay) {
    return RootsRightOf(model, -decay) <= at_nothing;
  };
  constexpr double kFastest = 1.0;  // 1/s: faster modes shorten no run
  double slow = 1e-4;
  double fast = kFastest;
  if (all_faster(fast)) return fast;
  if (!all_faster(slow)) return slow;
  while (fast > 1.05 * slow) {
    const double middle = std::sqrt(slow * fast);
    (all_faster(middle) ? slow : fast) = middle;
  }
  return slow;
}

double CriticalStiffness(GraspCoupling model, double stable, double most) {
  const auto stable_at = [&model](double stiffness) {
    model.stiffness = stiffness;
    return IsStable(model);
  };
  constexpr double kStep = 1.25;
  double good = stable;
  double bad = stable;
  for (;;) {
    if (!(good < most)) return std::numeric_limits<double>::infinity();
    bad = std::min(kStep * good, most);
    if (!stable_at(bad)) break;
    good = bad;
  }
  while (bad > 1.01 * good) {
    const double middle = std::sqrt(good * bad);
    (stable_at(middle) ? good : bad) = middle;
  }
  return bad;
}

}  // namespace tandem
