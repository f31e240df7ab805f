#include "engine/safety/passivity_observer.h"

#include <cmath>

#include <gtest/gtest.h>

namespace tandem {
namespace {

constexpr double kH = 1e-3;

/// Returns the balance of a spring of 1,000 N/m, whose force comes `late` steps late, on a handle
/// that swings.
double BalanceOfSpring(int late, int steps, PassivityObserver& observer) {
  for (int i = 0; i < steps; ++i) {
    const double t = kH * i;
    Wrench force;
    force.f.x() = -1000 * 0.005 * std::sin(20 * (t - kH * late));
    Twist V;
    V.v.x() = 20 * 0.005 * std::cos(20 * t);
    observer.Observe(force, V, kH);
  }
  return observer.balance_J();
}

TEST(PassivityObserver, UndelayedSpringIsPassive) {
  PassivityObserver observer;
  BalanceOfSpring(0, 10'000, observer);
  EXPECT_FALSE(observer.active());
}

// over a cycle a spring that is late by T gives pi k A^2 sin(w T): 1.57 mJ at 20 ms, so 30 cycles
// give 0.9 J
TEST(PassivityObserver, DelayedSpringIsActive) {
  PassivityObserver observer;
  BalanceOfSpring(20, 9425, observer);
  const double cycles = 9.425 * 20 / (2 * M_PI);
  EXPECT_NEAR(observer.balance_J(), -cycles * M_PI * 1000 * 0.005 * 0.005 * std::sin(0.4), 0.02);
  EXPECT_TRUE(observer.active());
}

TEST(PassivityObserver, LongRestDoesNotCreditLaterShaking) {
  PassivityObserver observer;
  Wrench drag;
  drag.f.x() = -10;
  Twist V;
  V.v.x() = 0.1;
  for (int i = 0; i < 100'000; ++i) observer.Observe(drag, V, kH);
  EXPECT_EQ(observer.balance_J(), PassivityObserver::kMostCredit);
}

TEST(PassivityObserver, DissipationEndsTheDebtWithinAStepOrIsLimited) {
  PassivityObserver observer;
  Wrench push;
  push.f.x() = 10;
  Twist V;
  V.v.x() = 0.1;
  for (int i = 0; i < 60; ++i) observer.Observe(push, V, kH);  // 60 mJ given, 50 are allowed
  const Vec3 payment = observer.DampingForce(V, kH, 1e9);
  EXPECT_LT(payment.x(), 0);
  EXPECT_NEAR(-payment.x() * 0.1 * kH, 0.01, 1e-9);
  EXPECT_NEAR(observer.DampingForce(V, kH, 5).x(), -0.5, 1e-12);
}

}  // namespace
}  // namespace tandem
