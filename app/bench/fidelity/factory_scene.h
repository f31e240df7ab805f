#pragma once

#include <filesystem>
#include <string>

#include "engine/world/world.h"

namespace tandem {

/// Returns a scene of two parts of models/factory, each named by its file without ".obj": a moving
/// part `at` a place (m), and a fixed one. `mass` in kg.
Scene FactoryScene(ContactModel contact, const std::filesystem::path& models, double voxel,
                   const std::string& fixed, const std::string& moving, const Vec3& at,
                   double mass);

/// Returns inputs under which the default hand holds the first body and all bodies are simulated.
/// Every test fits into a frame, because the question is fidelity, not speed.
StepInputs HandInputs(const WorldModel& model);

}  // namespace tandem
