#pragma once

#include <cstddef>
#include <optional>

#include "app/view/model/scene/camera_model.h"
#include "app/view/model/scene/drawn_scene.h"
#include "app/view/model/scene/picture_composer.h"

namespace tandem {

/// The first point at which a line of sight meets a body.
struct PartHit {
  std::size_t body = 0;
  Vec3 p_W = Vec3::Zero();
};

/// Returns the nearest point at which `ray` meets a solid instance. A fixed body hides bodies
/// behind it, as in the picture. Nothing: the ray meets none. It tests all triangles of the bodies
/// whose box the ray meets, so it is meant for a click and not for each picture.
std::optional<PartHit> PickPart(const Ray& ray, const DrawnScene& scene, const DrawList& list);

}  // namespace tandem
