#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/result.h"
#include "engine/geometry/mesh/triangle_mesh.h"
#include "engine/haptics/hand_script.h"

namespace tandem {

/// The generated parts of a scene that its file names: shapes and the hands that work on them, so
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
/// Returns the parts of the stability lab's scenes, which stand in a separate folder.
GeneratedScene StabilityParts();
GeneratedScene PressBlocks();

std::vector<GeneratedScene> GeneratedScenes();

/// Writes the scene's meshes (binary STL, mm) and hand files into the folder. The bytes are always
/// the same.
std::optional<Error> WriteScene(const GeneratedScene& scene, const std::filesystem::path& folder);

/// Returns the second hand on the same body. It has the same intent, but is slower by `pace` and
/// off by `offset_W` (m) on the way, and takes hold at another place. Start and end are the same.
HandScript SecondHand(const HandScript& script, double pace, const Vec3& offset_W,
                      const Pose& X_BD);

}  // namespace tandem
