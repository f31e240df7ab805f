// Tests balls and cylinders that roll down planes against the textbook.
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "tests/engine/world/total_energy.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/round_shapes.h"
#include "tests/support/shapes.h"

namespace tandem {
namespace {

using testing::At;
using testing::Box;
using testing::Cylinder;
using testing::FreeInputs;
using testing::HandTo;
using testing::kVoxel;
using testing::MakeWorldModel;
using testing::RunFrames;
using testing::Sphere;
using testing::TotalEnergy;

constexpr double kRollingGravity = 9.81;
/// At this speed the top of a roller goes 0.8 of half a voxel in a frame.
constexpr double kFastest = 0.8 * 0.5 * kVoxel / (2 * kFrame);

struct Roller {
  std::string name;
  TriangleMesh mesh;
  double radius;
  double mass;
  double share;  // its acceleration as one of g sin(angle): 5/7 or 2/3
};

struct Descent {
  double acceleration = 0;  // m/s^2
  double last = 0;          // m/s^2, over the last quarter of its speed
  double slip = 0;          // the greatest, m/s
  double risen = 0;         // TotalEnergy::risen()
};

/// A plate along the x axis of `q`, with a roller at rest on it.
class RollersSlope {
 public:
  RollersSlope(const Roller& roller, const Quat& q)
      : radius_(roller.radius),
        q_(q),
        model_(std::make_shared<WorldModel>(
            *MakeWorldModel({{At(Box(Vec3(0.12, 0.04, 0.006)), q * Vec3(0.05, 0, -0.003), q), true},
                             {At(roller.mesh, q * Vec3(0, 0, roller.radius + 0.45 * kVoxel), q),
                              false, roller.mass}},
                            kVoxel))),
        inputs_(FreeInputs(*model_)) {
    model_->scene.friction = 0.5;
    Rest();
  }

  /// Puts the roller back, at rest on the level plate.
  void Rest() {
    kHapticThread.Enter();
    LeanBy(0);
    world_.emplace(model_);
    RunFrames(*world_, inputs_, 200);
  }
  /// Gravity leans by an angle against the plate.
  void LeanBy(double degrees) {
    const double angle = degrees * std::numbers::pi / 180;
    model_->scene.gravity_W = q_ * (RotationBy(Vec3(0, -angle, 0)) * Vec3(0, 0, -kRollingGravity));
  }

  /// Lets the roller go.
  Descent Down(double degrees) {
    kHapticThread.Enter();
    Rest();
    LeanBy(degrees);
    TotalEnergy energy(*model_, world_->state(0));
    Descent descent;
    Timed whole{.from = 0.04};
    Timed last{.from = 0.75 * kFastest};
    for (int frame = 0; frame < 3000 && speed() < kFastest; ++frame) {
      energy.Step(*world_, inputs_);
      const double turning = radius_ * world_->state(0).V_WB.w.dot(q_ * Vec3::UnitY());
      if (speed() > 0.04) descent.slip = std::max(descent.slip, std::abs(speed() - turning));
      whole.See(speed());
      last.See(speed());
    }
    descent.acceleration = whole.Acceleration();
    descent.last = last.Acceleration();
    descent.risen = energy.risen();
    return descent;
  }

  World& world() { return *world_; }
  StepInputs& inputs() { return inputs_; }
  const WorldModel& model() const { return *model_; }
  double speed() const { return world_->state(0).V_WB.v.dot(q_ * Vec3::UnitX()); }
  /// Returns the height of its centre over the plate.
  double height() const { return (q_.conjugate() * world_->state(0).X_WB.p).z(); }

 private:
  /// Frames from a speed on.
  struct Timed {
    double from = 0;
    double first = 0;
    double now = 0;
    int frames = -1;

    void See(double speed) {
      now = speed;
      if (frames >= 0) {
        ++frames;
      } else if (speed > from) {
        frames = 0;
        first = speed;
      }
    }
    double Acceleration() const { return (now - first) / (frames * kFrame); }
  };

  double radius_;
  Quat q_;
  std::shared_ptr<WorldModel> model_;
  StepInputs inputs_;
  std::optional<World> world_;
};

/// Returns balls and cylinders of 10 and 5 mm, of steel and of plastic.
std::array<Roller, 5> Rollers() {
  const Quat askew = RotationBy(Vec3(0.3, 0.7, -0.4));
  return {Roller{"ball", At(Sphere(0.010, 4), Vec3::Zero(), askew), 0.010, 0.3, 5.0 / 7},
          Roller{"light ball", At(Sphere(0.010, 4), Vec3::Zero(), askew), 0.010, 0.011, 5.0 / 7},
          Roller{"small light ball", Sphere(0.005, 4), 0.005, 0.0014, 5.0 / 7},
          Roller{"cylinder", Cylinder(0.010, 0.02, 64), 0.010, 0.017, 2.0 / 3},
          Roller{"slender cylinder", Cylinder(0.005, 0.02, 48), 0.005, 0.0043, 2.0 / 3}};
}

double ExactAcceleration(const Roller& roller, double degrees) {
  return roller.share * kRollingGravity * std::sin(degrees * std::numbers::pi / 180);
}

TEST(Rolling, BallsAndCylindersAccelerateAsTheTextbookSays) {
  const std::array<std::pair<std::string, Vec3>, 3> stands{
      {{"", Vec3::Zero()}, {", tilted", Vec3(0, 0.2, 0)}, {", turned", Vec3(0.1, -0.15, 0.6)}}};
  for (const Roller& roller : Rollers()) {
    for (const auto& [name, turn] : stands) {
      RollersSlope slope(roller, RotationBy(turn));
      for (const double degrees : {5.0, 10.0, 20.0}) {
        const double exact = ExactAcceleration(roller, degrees);
        const Descent descent = slope.Down(degrees);
        const std::string which =
            roller.name + ", " + std::to_string(std::lround(degrees)) + " degrees" + name;
        RecordProperty(which, std::to_string(descent.acceleration / exact));
        RecordProperty(which + ", energy risen", std::to_string(descent.risen));
        EXPECT_NEAR(descent.acceleration / exact, 1.0, 0.03) << which;
        EXPECT_NEAR(descent.last / exact, 1.0, 0.03) << which;
        EXPECT_LT(descent.slip, 1e-3) << which;
        EXPECT_LT(descent.risen, 1e-3) << which;
      }
    }
  }
}

// A hand takes hold of a rolling body and lets it go: it neither hops nor sinks, and rolls on.
TEST(Rolling, AHandMayTakeARollingBodyAndLetItGo) {
  for (const Roller& roller : Rollers()) {
    RollersSlope slope(roller, Quat::Identity());
    slope.LeanBy(10);
    RunFrames(slope.world(), slope.inputs(), 60);
    const double height = slope.height();
    slope.inputs().hand = HandTo(slope.model(), 0, slope.world().state(0).X_WB);
    double off = 0;
    for (int frame = 0; frame < 260; ++frame) {
      if (frame == 200) slope.inputs().hand.body = -1;
      slope.world().Step(slope.inputs());
      off = std::max(off, std::abs(slope.height() - height));
    }
    RecordProperty(roller.name + ", voxels off", std::to_string(off / kVoxel));
    EXPECT_LT(off, 0.1 * kVoxel) << roller.name;
    const double before = slope.speed();
    RunFrames(slope.world(), slope.inputs(), 60);
    EXPECT_NEAR(slope.speed() - before, 0.06 * ExactAcceleration(roller, 10),
                0.03 * 0.06 * ExactAcceleration(roller, 10))
        << roller.name;
  }
}

TEST(Rolling, FramesAllocateNothing) {
  RollersSlope slope(Rollers()[3], RotationBy(Vec3(0.1, -0.15, 0.6)));
  slope.LeanBy(10);
  const testing::AllocationCounter counter;
  RunFrames(slope.world(), slope.inputs(), 200);
  EXPECT_EQ(counter.count(), 0);
  EXPECT_GT(slope.speed(), 0.1);
}

}  // namespace
}  // namespace tandem
