#pragma once

#include <cstddef>
#include <optional>

#include "app/view/model/camera_model.h"
#include "app/view/model/drawn_scene.h"
#include "app/view/model/picture_composer.h"

namespace tandem {

/// The place at which a line of sight meets a body first.
struct PartHit {
  std::size_t body = 0;
  Vec3 p_W = Vec3::Zero();
};

/// Returns the nearest surface that `ray` meets of the solid instances; a fixed body hides what is
/// behind it, as in the picture. Nothing: the ray meets none. Looks at all triangles of the bodies
/// whose box the ray meets, so it is meant for a press of a button, not for each picture.
std::optional<PartHit> PickPart(const Ray& ray, const DrawnScene& scene, const DrawList& list);

}  // namespace tandem
