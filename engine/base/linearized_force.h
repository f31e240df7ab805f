#pragma once

#include "engine/base/spatial.h"

namespace tandem {

/// The load on a body in a frame, and how it changes as the body moves: the terms of a linearly
/// implicit step. It is in W about the body's centre of mass, moments first. stiffness = -dF/dx and
/// damping = -dF/dv are symmetric and never negative.
struct LinearizedForce {
  Vec6 force = Vec6::Zero();
  Mat6 stiffness = Mat6::Zero();
  Mat6 damping = Mat6::Zero();

  LinearizedForce& operator+=(const LinearizedForce& other) {
    force += other.force;
    stiffness += other.stiffness;
    damping += other.damping;
    return *this;
  }
};

/// The change of the load on one body as another moves: dF/dx and dF/dv. Rows belong to the first
/// body and columns to the other, each about its centre of mass in W, moments first.
struct CrossJacobian {
  Mat6 stiffness = Mat6::Zero();
  Mat6 damping = Mat6::Zero();
};

inline Vec6 Stacked(const Twist& V) {
  Vec6 stacked;
  stacked << V.w, V.v;
  return stacked;
}

inline Wrench AsWrench(const Vec6& force) {
  return {force.head<3>(), force.tail<3>()};
}

}  // namespace tandem
