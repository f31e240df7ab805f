#pragma once

#include <array>
#include <cstdint>

#include "engine/base/text/json_reader.h"
#include "engine/dynamics/constraint.h"

namespace tandem {

/// A body's constraint as in the scene file, in W with the body in its first pose.
struct SceneConstraint {
  enum class Kind { kNone, kHinge, kSlide, kCylinder, kPlane, kBall };

  Kind kind = Kind::kNone;
  Vec3 p_W = Vec3::Zero();      // point of a hinge, cylinder or ball
  Vec3 axis_W = Vec3::UnitZ();  // axis of all but the ball; any length but 0
  Constraint::Turn turn = Constraint::Turn::kAboutAxis;  // allowed rotation of a plane
};

/// Reads the value of a body's key "constraint"; faults are noted in the node's file.
SceneConstraint ReadConstraint(const JsonNode& node);

/// Makes the constraint of a body whose first pose is `X_WB0`. Its kind must not be kNone.
Constraint MakeConstraint(const SceneConstraint& constraint, const Pose& X_WB0);

/// Returns what affects forces, for the scene's hashes: equal for constraints that mean the same.
std::array<std::uint64_t, 8> ContentOf(const SceneConstraint& constraint);

}  // namespace tandem
