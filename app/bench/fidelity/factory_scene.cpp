#include "app/bench/fidelity/factory_scene.h"

namespace tandem {

namespace {

constexpr double kCapacity = 1e9;  // these benches ask for fidelity, not speed

}  // namespace

Scene FactoryScene(ContactModel contact, const std::filesystem::path& models, double voxel,
                   const std::string& fixed, const std::string& moving, const Vec3& at,
                   double mass) {
  Scene scene;
  scene.file = models;
  scene.voxel_size = voxel;
  scene.contact = contact;
  scene.force_layer = DefaultForceLayer(contact);
  scene.bodies.resize(2);
  scene.bodies[0].name = fixed;
  scene.bodies[0].mesh = models / "factory" / (fixed + ".obj");
  scene.bodies[0].fixed = true;
  scene.bodies[1].name = moving;
  scene.bodies[1].mesh = models / "factory" / (moving + ".obj");
  scene.bodies[1].X_WM.p = at;
  scene.bodies[1].mass = mass;
  return scene;
}

StepInputs HandInputs(const WorldModel& model) {
  StepInputs inputs = ParkedInputs(model);
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    inputs.instances[b].drive = BodyDrive::kSimulated;
  }
  inputs.capacity = kCapacity;
  inputs.hand.body = 0;
  inputs.hand.gains = DefaultHandGains(model.bodies[0].inertia);
  return inputs;
}

}  // namespace tandem
