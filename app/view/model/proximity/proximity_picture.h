#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "app/view/model/scene/drawn_scene.h"
#include "engine/contact/field/pressed_depth.h"
#include "engine/proximity/scene_proximity.h"

namespace tandem {

/// colour of near voxels of fixed bodies
inline constexpr Colour kNearVoxelColour{0.10F, 0.66F, 0.60F};

/// The colours of a moving body's vertices, by their distance from all other bodies.
struct VertexColours {
  std::size_t body = 0;
  std::vector<std::array<std::uint8_t, 4>> rgba;  // one for each vertex of the mesh
};

/// The parts that proximity adds to a picture.
struct ProximityPicture {
  std::vector<VertexColours> bodies;
  std::vector<std::array<float, 3>> shadow_W;  // centres of the near static voxels, m
  std::size_t shadow_found = 0;                // number found; shadow_W may have room for fewer
  float voxel_size = 0;                        // m
  double range = 0;                            // m; beyond it all vertices have one colour
  SceneNearness nearest;                       // nearest pair; other == kNone: there is only one
                                               // part
  std::string part, other;                     // names of the pair
  SceneNearness of_held;                       // nearest pair of a part in hand, if `nearest` has
                                               // none in hand
  std::string held_part, held_other;
  ContactYield yield;       // how contact of `part` gives way
  ContactYield held_yield;  // that of `held_part`
};

/// Formats a distance as "3.214 mm ± 0.001 mm", with the error rounded up. Of bodies that overlap
/// it tells the depth, how far contact gives way, and which voxel decides whether the part fits.
std::string DistanceText(const SceneNearness& nearest, const ContactYield& yield);

/// Makes the bodies of a drawn scene for MakeProximityParts().
std::vector<ProximityBody> ProximityBodiesOf(const DrawnScene& scene);

/// Makes pictures of proximity for a scene. Used by one thread.
class ProximityComposer {
 public:
  static constexpr std::size_t kMostShadow = 20000;  // voxels; drawing them takes a negligible time
  static constexpr double kShadowVoxels = 4;         // voxels; distance within which fixed voxels
                                                     // are shown

  /// `parts`: made of ProximityBodiesOf(*scene).
  ProximityComposer(std::shared_ptr<const DrawnScene> scene, std::vector<ProximityPart> parts);

  /// Makes the picture. `X_W`: the displacement of each body; `held`: the bodies in hand.
  ProximityPicture Compose(std::span<const Pose> X_W, std::span<const std::size_t> held = {});

 private:
  bool IsHeld(std::size_t part, std::span<const std::size_t> held) const;
  ContactYield YieldOf(std::size_t part) const;
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
