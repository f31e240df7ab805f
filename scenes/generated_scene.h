#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/result.h"
#include "engine/geometry/triangle_mesh.h"
#include "engine/haptics/hand_script.h"

namespace tandem {

/// What a scene's file names and its generator makes: shapes and the hands that work on them, so
/// that both come from the same constants.
struct GeneratedScene {
  struct Mesh {
    std::string file;   // beside the scene file
    TriangleMesh mesh;  // mm
  };
  struct Hand {
    std::string file;
    HandScript script;
  };
  std::string name;
  std::vector<Mesh> meshes;
  std::vector<Hand> hands;
};

GeneratedScene PegInSlot();
GeneratedScene BallAndSocket();
GeneratedScene BracketActuator();
GeneratedScene NutAndBolt();
/// The parts of the stability lab's scenes, which stand in a folder of their own.
GeneratedScene StabilityParts();
GeneratedScene PressBlocks();

std::vector<GeneratedScene> GeneratedScenes();

/// Writes the scene's meshes (binary STL, mm) and hand files into the folder, always the same
/// bytes.
std::optional<Error> WriteScene(const GeneratedScene& scene, const std::filesystem::path& folder);

/// The second hand on the same body: it means the same, but is slower by `pace` and off by
/// `offset_W` (m) on the way, and takes hold elsewhere; where it starts and ends is the same.
HandScript SecondHand(const HandScript& script, double pace, const Vec3& offset_W,
                      const Pose& X_BD);

}  // namespace tandem
