#pragma once

#include <filesystem>
#include <string>

#include "engine/world/world.h"

namespace tandem {

/// A moving part of models/factory, by its file's name without ".obj", `at` that place (m), before
/// another that is fixed. `mass` in kg.
Scene FactoryScene(ContactModel contact, const std::filesystem::path& models, double voxel,
                   const std::string& fixed, const std::string& moving, const Vec3& at,
                   double mass);

/// Inputs under which the default hand holds the first body and all bodies are simulated. Every
/// test fits into a frame: fidelity is asked for, not speed.
StepInputs HandInputs(const WorldModel& model);

}  // namespace tandem
