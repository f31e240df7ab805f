#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "app/view/model/drawn_scene.h"
#include "engine/world/scene_proximity.h"

namespace tandem {

/// Near voxels of what is fixed are drawn in it.
inline constexpr Colour kNearVoxelColour{0.10F, 0.66F, 0.60F};

/// The colours of a moving body's vertices, by their distance from everything else.
struct VertexColours {
  std::size_t body = 0;
  std::vector<std::array<std::uint8_t, 4>> rgba;  // as many as its mesh has vertices
};

/// What proximity adds to a picture.
struct ProximityPicture {
  std::vector<VertexColours> bodies;
  std::vector<std::array<float, 3>> shadow_W;  // centres of the near static voxels, m
  std::size_t shadow_found = 0;                // more than shadow_W: that has no more room
  float voxel_size = 0;                        // m
  double range = 0;                            // m, beyond which all is of one colour
  SceneNearness nearest;                       // other == kNone: there is nothing to be near to
  std::string part, other;                     // their names
  SceneNearness of_held;                       // of a part in hand, where `nearest` is of others
  std::string held_part, held_other;
};

/// "3.214 mm ± 0.001 mm"; where bodies overlap, in words. The error is rounded up.
std::string DistanceText(const SceneNearness& nearest);

/// A drawn scene's bodies for MakeProximityParts().
std::vector<ProximityBody> ProximityBodiesOf(const DrawnScene& scene);

/// Makes such pictures of a scene. Used by one thread.
class ProximityComposer {
 public:
  static constexpr std::size_t kMostShadow = 20000;  // voxels: as many as are drawn in no time
  static constexpr double kShadowVoxels = 4;         // the static voxels shown are as near as that

  /// `parts`: of ProximityBodiesOf(*scene).
  ProximityComposer(std::shared_ptr<const DrawnScene> scene, std::vector<ProximityPart> parts);

  /// `X_W`: the displacement of each of the scene's bodies; `held`: those in hand.
  ProximityPicture Compose(std::span<const Pose> X_W, std::span<const std::size_t> held = {});

 private:
  bool IsHeld(std::size_t part, std::span<const std::size_t> held) const;
  struct ColouredBody {
    std::size_t part, body;
    std::vector<std::array<float, 3>> points_W;
  };

  std::shared_ptr<const DrawnScene> scene_;
  SceneProximity proximity_;
  std::vector<ColouredBody> coloured_;
  std::vector<float> distances_;
  std::vector<Vec3> centres_;
};

}  // namespace tandem
