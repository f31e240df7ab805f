#include <cmath>

#include "scenes/generators/generated_scene.h"
#include "scenes/generators/shapes.h"

// A ball 25 mm across and a half cup that fits it without clearance: a joint that only its users'
// hands hold together. It has 2,048 triangles and 1,024 + 1,024 + 128.
namespace tandem {
namespace {

constexpr double kBallRadius = 12.5;  // mm
constexpr double kCupRadius = 18.8;   // mm
constexpr int kLevels = 4;            // 8 * 4^4 = 2,048

// The first hand presses the ball into the cup and turns it there, to one side, round and back.
HandScript BallHand() {
  HandScript script;
  script.impedance.damping = 12;
  const Vec3 press(0, 0, -0.004);
  const Quat tilted = RotationBy(Vec3(0.7, 0, 0));
  const Quat turned = RotationBy(Vec3(0, 0.7, 0)) * RotationBy(Vec3(0, 0, 0.9));
  script.waypoints = {{0.0, Vec3::Zero(), Quat::Identity()},
                      {1.5, press, Quat::Identity()},
                      {4.0, press, tilted},
                      {6.5, press, turned},
                      {8.5, press, Quat::Identity()}};
  return script;
}

// The second holds the cup against it, and gives a little.
HandScript SocketHand() {
  HandScript script;
  script.impedance.damping = 12;
  script.waypoints = {{0.0, Vec3::Zero(), Quat::Identity()},
                      {1.5, {0, 0, 0.002}, Quat::Identity()},
                      {5.0, {0.004, 0, 0.002}, RotationBy(Vec3(0, 0.1, 0))},
                      {8.0, {0, 0, 0.002}, Quat::Identity()}};
  return script;
}

}  // namespace

GeneratedScene BallAndSocket() {
  return {
      "ball_and_socket",
      {{"ball_and_socket_socket.stl", HalfCup(kBallRadius, kCupRadius, kLevels)},
       {"ball_and_socket_ball.stl", OctahedralSphere(kBallRadius, kLevels, false)}},
      {{"ball_and_socket_ball.json", BallHand()}, {"ball_and_socket_socket.json", SocketHand()}}};
}

}  // namespace tandem
