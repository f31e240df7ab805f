#include "engine/world/instances.h"

#include <numeric>

namespace tandem {

std::vector<std::size_t> InstanceShapes(const WorldModel& model) {
  const std::size_t bodies = model.bodies.size();
  std::vector<std::size_t> shapes(bodies);
  std::iota(shapes.begin(), shapes.end(), std::size_t{0});
  for (std::size_t b = 0; b < bodies && bodies > 1; ++b) {
    if (model.scene.bodies[model.object[b]].shared) shapes.push_back(b);
  }
  return shapes;
}

StepInputs ParkedInputs(const WorldModel& model) {
  StepInputs inputs;
  inputs.instances.resize(InstanceShapes(model).size());
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    inputs.instances[b].drive = BodyDrive::kParked;
  }
  return inputs;
}

}  // namespace tandem
