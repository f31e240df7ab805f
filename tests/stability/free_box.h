#pragma once

#include <memory>
#include <string>

#include "collab/lab/case/lab_case.h"
#include "collab/lab/case/lab_scene.h"
#include "tests/support/shapes.h"
#include "tests/support/test_world.h"

namespace tandem::testing {

/// Returns one shared box of 0.3 kg, alone, which is made once.
inline const LabScene& FreeBox() {
  static const LabScene kScene = [] {
    auto model =
        std::make_shared<WorldModel>(*MakeWorldModel({{Box(Vec3(0.03, 0.02, 0.02))}}, 0.002));
    model->scene.bodies[0].shared = true;
    return LabScene{.model = model, .object = 0};
  }();
  return kScene;
}

/// Returns a hand of the lab that holds it.
inline LabHand HandOfBox(const std::string& name) {
  return *HandNamed(name, FreeBox().inertia());
}

/// Returns a network with up to 30 ms more at random, and 5 % lost.
inline LabNetwork LossyNetwork() {
  LabNetwork network;
  network.name = "lossy";
  network.there = network.back = {.jitter_ms = 30, .loss = 0.05};
  return network;
}

}  // namespace tandem::testing
