// Tests balls and cylinders that roll down planes against the textbook.
#include <array>
#include <cmath>
#include <numbers>
#include <string>

#include <gtest/gtest.h>

#include "tests/engine/world/total_energy.h"
#include "tests/support/shapes.h"

namespace tandem {
namespace {

using testing::At;
using testing::Box;
using testing::FreeInputs;
using testing::kVoxel;
using testing::MakeWorldModel;
using testing::Sphere;
using testing::TotalEnergy;

constexpr double kRollingGravity = 9.81;
/// At this speed the top of a roller goes 0.8 of half a voxel in a frame.
constexpr double kFastest = 0.8 * 0.5 * kVoxel / (2 * kFrame);

/// Returns a closed cylinder along y, of `sides` flat sides.
TriangleMesh Cylinder(double radius, double length, std::uint32_t sides) {
  TriangleMesh mesh;
  for (const double end : {-0.5, 0.5}) {
    for (std::uint32_t i = 0; i < sides; ++i) {
      const double angle = 2 * std::numbers::pi * i / sides;
      mesh.vertices.emplace_back(radius * std::cos(angle), end * length, radius * std::sin(angle));
    }
  }
  mesh.vertices.emplace_back(0, -0.5 * length, 0);
  mesh.vertices.emplace_back(0, 0.5 * length, 0);
  for (std::uint32_t i = 0; i < sides; ++i) {
    const std::uint32_t next = (i + 1) % sides;
    mesh.triangles.push_back({i, sides + i, next});
    mesh.triangles.push_back({next, sides + i, sides + next});
    mesh.triangles.push_back({2 * sides, i, next});
    mesh.triangles.push_back({2 * sides + 1, sides + next, sides + i});
  }
  return mesh;
}

struct Roller {
  std::string name;
  TriangleMesh mesh;
  double radius;
  double mass;
  double share;  // of g sin(angle) by which it accelerates: 5/7 or 2/3
};

struct Descent {
  double acceleration = 0;  // m/s^2
  double slip = 0;          // the greatest, m/s
  double risen = 0;         // TotalEnergy::risen()
};

/// A plate along the x axis of `q`, with a roller on it.
class RollersSlope {
 public:
  RollersSlope(const Roller& roller, const Quat& q)
      : radius_(roller.radius),
        q_(q),
        model_(std::make_shared<WorldModel>(
            *MakeWorldModel({{At(Box(Vec3(0.12, 0.04, 0.006)), q * Vec3(0.05, 0, -0.003), q), true},
                             {At(roller.mesh, q * Vec3(0, 0, roller.radius + 0.45 * kVoxel), q),
                              false, roller.mass}},
                            kVoxel))) {
    model_->scene.friction = 0.5;
  }

  /// Lets the roller go under gravity that leans by an angle against the plate.
  Descent Down(double degrees) {
    kHapticThread.Enter();
    const double angle = degrees * std::numbers::pi / 180;
    model_->scene.gravity_W = q_ * (RotationBy(Vec3(0, -angle, 0)) * Vec3(0, 0, -kRollingGravity));
    World world(model_);
    const StepInputs inputs = FreeInputs(*model_);
    TotalEnergy energy(*model_, world.state(0));
    Descent descent;
    int frames = -1;
    double from = 0;
    double speed = 0;
    for (int frame = 0; frame < 3000 && speed < kFastest; ++frame) {
      energy.Step(world, inputs);
      const Twist& V_WB = world.state(0).V_WB;
      speed = V_WB.v.dot(q_ * Vec3::UnitX());
      if (frames >= 0) {
        ++frames;
        const double turning = radius_ * V_WB.w.dot(q_ * Vec3::UnitY());
        descent.slip = std::max(descent.slip, std::abs(speed - turning));
      } else if (speed > 0.04) {
        frames = 0;
        from = speed;
      }
    }
    descent.acceleration = (speed - from) / (frames * kFrame);
    descent.risen = energy.risen();
    return descent;
  }

 private:
  double radius_;
  Quat q_;
  std::shared_ptr<WorldModel> model_;
};

TEST(Rolling, BallsAndCylindersAccelerateAsTheTextbookSays) {
  const Quat askew = RotationBy(Vec3(0.3, 0.7, -0.4));
  const std::array<Roller, 5> rollers{
      Roller{"ball", At(Sphere(0.010, 4), Vec3::Zero(), askew), 0.010, 0.3, 5.0 / 7},
      Roller{"light ball", At(Sphere(0.010, 4), Vec3::Zero(), askew), 0.010, 0.011, 5.0 / 7},
      Roller{"small light ball", Sphere(0.005, 4), 0.005, 0.0014, 5.0 / 7},
      Roller{"cylinder", Cylinder(0.010, 0.02, 64), 0.010, 0.017, 2.0 / 3},
      Roller{"slender cylinder", Cylinder(0.005, 0.02, 48), 0.005, 0.0043, 2.0 / 3}};
  for (const Roller& roller : rollers) {
    for (const bool tilted : {false, true}) {
      RollersSlope slope(roller, RotationBy(Vec3(0, tilted ? 0.2 : 0.0, 0)));
      for (const double degrees : {5.0, 10.0, 20.0}) {
        const double exact =
            roller.share * kRollingGravity * std::sin(degrees * std::numbers::pi / 180);
        const Descent descent = slope.Down(degrees);
        const std::string which =
            roller.name + ", " + std::to_string(degrees) + (tilted ? ", tilted" : "");
        RecordProperty(which, std::to_string(descent.acceleration / exact));
        EXPECT_NEAR(descent.acceleration / exact, 1.0, 0.03) << which;
        EXPECT_LT(descent.slip, 1e-3) << which;
        EXPECT_LT(descent.risen, 1e-3) << which;
      }
    }
  }
}

}  // namespace
}  // namespace tandem
