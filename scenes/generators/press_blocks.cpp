#include "scenes/generators/generated_scene.h"
#include "scenes/generators/shapes.h"

// Two cubes that face one another along x, for two users who press one another: each holds one.
namespace tandem {
namespace {

// mm
constexpr double kSide = 60;
constexpr double kHalf = 0.5 * kSide;
constexpr double kHalfGap = 30;

}  // namespace

GeneratedScene PressBlocks() {
  const auto from = [](double x) {
    return Box(Vec3(x, -kHalf, -kHalf), Vec3(x + kSide, kHalf, kHalf));
  };
  return {"press_blocks",
          {{"press_blocks_left.stl", from(-kHalfGap - kSide)},
           {"press_blocks_right.stl", from(kHalfGap)}},
          {}};
}

}  // namespace tandem
