#include "scenes/generators/generated_scene.h"

#include <array>
#include <bit>
#include <fstream>

#include "scenes/generators/hand_file.h"

namespace tandem {
namespace {

static_assert(std::endian::native == std::endian::little);  // binary STL is

void AppendBytes(std::string& bytes, const void* data, std::size_t size) {
  bytes.append(static_cast<const char*>(data), size);
}

std::string BinaryStl(const TriangleMesh& mesh) {
  std::string bytes = "binary STL in millimetres, made by generate_scenes";
  bytes.resize(80, ' ');
  const auto count = static_cast<std::uint32_t>(mesh.triangles.size());
  AppendBytes(bytes, &count, sizeof count);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    // a corner that triangles share is rounded the same way in each, so readers weld it again
    std::array<Eigen::Vector3f, 4> normal_and_corners;
    for (std::size_t k = 0; k < 3; ++k) {
      normal_and_corners[k + 1] = mesh.corner(t, k).cast<float>();
    }
    const Vec3 normal = (mesh.corner(t, 1) - mesh.corner(t, 0))
                            .cross(mesh.corner(t, 2) - mesh.corner(t, 0))
                            .normalized();
    normal_and_corners[0] = normal.cast<float>();
    for (const Eigen::Vector3f& v : normal_and_corners) AppendBytes(bytes, v.data(), 12);
    bytes.append(2, '\0');
  }
  return bytes;
}

std::optional<Error> Write(const std::filesystem::path& file, const std::string& bytes) {
  std::ofstream stream(file, std::ios::binary);
  stream.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  stream.close();
  if (!stream) return Error{file.string() + ": cannot be written"};
  return std::nullopt;
}

}  // namespace

std::vector<GeneratedScene> GeneratedScenes() {
  return {PegInSlot(), BallAndSocket(), BracketActuator(), NutAndBolt(), PressBlocks()};
}

std::optional<Error> WriteScene(const GeneratedScene& scene, const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) return Error{folder.string() + ": " + error.message()};
  for (const GeneratedScene::Mesh& mesh : scene.meshes) {
    if (auto fault = Write(folder / mesh.file, BinaryStl(mesh.mesh))) return fault;
  }
  for (const GeneratedScene::Hand& hand : scene.hands) {
    if (auto fault = Write(folder / hand.file, HandFile(hand.script))) return fault;
  }
  return std::nullopt;
}

HandScript SecondHand(const HandScript& script, double pace, const Vec3& offset_W,
                      const Pose& X_BD) {
  HandScript partner = script;
  partner.X_BD = X_BD;
  for (std::size_t i = 0; i < partner.waypoints.size(); ++i) {
    partner.waypoints[i].t *= pace;
    if (i > 0 && i + 1 < partner.waypoints.size()) partner.waypoints[i].p_W += offset_W;
  }
  return partner;
}

}  // namespace tandem
