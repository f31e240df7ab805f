#include "collab/controller/control_scene.h"

namespace tandem {

int ControlScene::BodyNamed(const std::string& name) const {
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (bodies[i].name == name) return static_cast<int>(i);
  }
  return -1;
}

int ControlScene::BodyOfMoving(int moving) const {
  if (moving < 0) return -1;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    // a part of another body has that body's number too
    if (bodies[i].moving == moving && bodies[i].object == i) return static_cast<int>(i);
  }
  return -1;
}

ControlScene ControlSceneOf(const WorldModel& model) {
  ControlScene scene;
  const Scene& source = model.scene;
  scene.file = source.file.string();
  scene.clearance = source.clearance_bounds();
  for (std::size_t i = 0; i < source.bodies.size(); ++i) {
    const int moving = model.body_index[i];
    ControlScene::Body body{.name = source.bodies[i].name,
                            .fixed = moving < 0,
                            .shared = source.bodies[source.WholeOf(i)].shared,
                            .moving = moving,
                            .object = kNoObject,
                            .radius = 0,
                            .X_WB0 = source.bodies[i].X_WM};
    if (moving >= 0) {
      body.object = model.object[static_cast<std::size_t>(moving)];
      body.X_WB0 = model.bodies[static_cast<std::size_t>(moving)].X_WB0;
      body.radius = model.bodies[static_cast<std::size_t>(moving)].radius;
    }
    scene.bodies.push_back(std::move(body));
  }
  return scene;
}

}  // namespace tandem
