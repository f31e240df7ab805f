#include "engine/scene/scene_constraint.h"

#include <algorithm>
#include <array>
#include <bit>
#include <string>
#include <string_view>

#include "engine/base/check.h"

namespace tandem {

namespace {

using Kind = SceneConstraint::Kind;
using Turn = Constraint::Turn;

Vec3 ReadDirection(const JsonNode& node) {
  const Vec3 direction = node.Vector();
  // beyond these lengths, the squared length is infinite or 0
  const double length = direction.stableNorm();
  if (length >= 1e-9 && length <= 1e9) return direction;
  node.Expected("a direction [x, y, z] of a length from 1e-9 to 1e9");
  return Vec3::UnitZ();
}

Turn ReadTurn(const JsonNode& node) {
  constexpr std::string_view kExpected = "\"about_normal\", \"free\" or \"none\"";
  const std::string text = node.Text(kExpected);
  if (text == "free") return Turn::kFree;
  if (text == "none") return Turn::kNone;
  if (text != "about_normal") node.Expected(kExpected);
  return Turn::kAboutAxis;
}

SceneConstraint ReadAxis(const JsonNode& node, Kind kind) {
  node.AllowKeys({"p_W", "axis_W"});
  SceneConstraint constraint;
  constraint.kind = kind;
  constraint.p_W = node["p_W"].Vector();
  constraint.axis_W = ReadDirection(node["axis_W"]);
  return constraint;
}

SceneConstraint ReadSlide(const JsonNode& node) {
  node.AllowKeys({"axis_W"});
  SceneConstraint slide;
  slide.kind = Kind::kSlide;
  slide.axis_W = ReadDirection(node["axis_W"]);
  return slide;
}

SceneConstraint ReadPlane(const JsonNode& node) {
  node.AllowKeys({"normal_W", "turn"});
  SceneConstraint plane;
  plane.kind = Kind::kPlane;
  plane.axis_W = ReadDirection(node["normal_W"]);
  if (node.Has("turn")) plane.turn = ReadTurn(node["turn"]);
  return plane;
}

SceneConstraint ReadBall(const JsonNode& node) {
  node.AllowKeys({"p_W"});
  SceneConstraint ball;
  ball.kind = Kind::kBall;
  ball.p_W = node["p_W"].Vector();
  return ball;
}

}  // namespace

SceneConstraint ReadConstraint(const JsonNode& node) {
  node.AllowKeys({"hinge", "slide", "cylinder", "plane", "ball"});
  const std::array<std::string_view, 5> kinds{"hinge", "slide", "cylinder", "plane", "ball"};
  const auto given = std::count_if(kinds.begin(), kinds.end(), [&](std::string_view kind) {
    return node.Has(kind);
  });
  if (given != 1) {
    node.Fault("expected one of hinge, slide, cylinder, plane, ball; got " + std::to_string(given) +
               " of them");
    return {};
  }
  if (node.Has("hinge")) return ReadAxis(node["hinge"], Kind::kHinge);
  if (node.Has("slide")) return ReadSlide(node["slide"]);
  if (node.Has("cylinder")) return ReadAxis(node["cylinder"], Kind::kCylinder);
  if (node.Has("plane")) return ReadPlane(node["plane"]);
  return ReadBall(node["ball"]);
}

Constraint MakeConstraint(const SceneConstraint& constraint, const Pose& X_WB0) {
  switch (constraint.kind) {
    case Kind::kHinge:
      return HingeConstraint(X_WB0, constraint.p_W, constraint.axis_W);
    case Kind::kSlide:
      return SlideConstraint(X_WB0, constraint.axis_W);
    case Kind::kCylinder:
      return CylinderConstraint(X_WB0, constraint.p_W, constraint.axis_W);
    case Kind::kPlane:
      return PlaneConstraint(X_WB0, constraint.axis_W, constraint.turn);
    case Kind::kBall:
      return BallConstraint(X_WB0, constraint.p_W);
    case Kind::kNone:
      break;
  }
  TANDEM_CHECK(constraint.kind != Kind::kNone);
  return {};
}

std::array<std::uint64_t, 8> ContentOf(const SceneConstraint& constraint) {
  std::array<std::uint64_t, 8> content{static_cast<std::uint64_t>(constraint.kind),
                                       static_cast<std::uint64_t>(constraint.turn)};
  std::size_t at = 2;
  for (const Vec3& v : {constraint.p_W, constraint.axis_W}) {
    // adding 0 turns a negative zero, which means the same, into 0
    for (const double x : {v.x(), v.y(), v.z()}) {
      content[at++] = std::bit_cast<std::uint64_t>(x + 0.0);
    }
  }
  return content;
}

}  // namespace tandem
