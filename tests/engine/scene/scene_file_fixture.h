#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include "engine/scene/scene.h"
#include "engine/scene/scene_hash.h"
#include "tests/support/scratch_folder.h"

namespace tandem::testing {

inline const std::string kScene = R"({
  "name": "peg",
  "voxel_m": 0.0005,
  "force_layer": 1,
  "bodies": [
    {"name": "block", "mesh": "block.stl", "fixed": true, "colour": "#ff8000"},
    {"name": "peg", "mesh": "peg.stl", "scale": 0.001, "mass_kg": 0.3, "sharing": "shared",
     "pose": {"p_W": [0.1, 0.2, 0.3], "q_xyzw": [0, 0, 0.6, 0.8]}, "inward_shift_voxels": 0.5},
    {"name": "ring", "mesh": "peg.stl", "density_kg_m3": 2700}
  ],
  "hands": [{"body": "peg", "file": "left.json"}]
})";

/// Loads scenes that a test changes from kScene.
class SceneFile : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_.Write("block.stl", "block");
    folder_.Write("peg.stl", "peg");
    folder_.Write("left.json", "{}");
  }

  std::filesystem::path File(const std::string& text) { return folder_.Write("scene.json", text); }

  /// Returns the scene with `from` replaced by `to`; `from` must be there.
  static std::string Changed(const std::string& from, const std::string& to) {
    std::string text = kScene;
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return text.replace(at, from.size(), to);
  }

  std::string ErrorAfter(const std::string& from, const std::string& to) {
    const Result<Scene> scene = LoadScene(File(Changed(from, to)));
    if (scene) return "no error";
    const std::string start = (folder_.path() / "scene.json").string() + ": ";
    EXPECT_EQ(scene.error().what.substr(0, start.size()), start);
    return scene.error().what.substr(start.size());
  }

  /// Returns the scene with more keys for the ring, and for itself.
  static std::string WithKeys(const std::string& of_ring, const std::string& of_scene = "") {
    std::string text = Changed("2700}", "2700, " + of_ring + "}");
    return text.replace(text.find("\"bodies\""), 0, of_scene + "\n  ");
  }

  /// Returns what is wrong then, less the file's name.
  std::string ErrorOf(const std::string& of_ring, const std::string& of_scene = "") {
    const Result<Scene> scene = LoadScene(File(WithKeys(of_ring, of_scene)));
    if (scene) return "no error";
    return scene.error().what.substr((folder_.path() / "scene.json: ").string().size());
  }

  SceneHash Hashes(const std::string& text) {
    const Result<Scene> scene = LoadScene(File(text));
    EXPECT_TRUE(scene) << scene.error().what;
    return HashScene(*scene).value();
  }
  std::uint64_t Hash(const std::string& text) { return Hashes(text).content; }

  ScratchFolder folder_;
};

}  // namespace tandem::testing
