#include "engine/world/scene_hash.h"

#include <array>
#include <cstring>
#include <filesystem>
#include <string>

#include <gmock/gmock.h>
#include <sys/stat.h>

#include "engine/base/hash.h"
#include "engine/geometry/mesh_file.h"
#include "tests/support/scratch_folder.h"

namespace tandem {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

/// Returns the numbers of a tetrahedron of that size: corners and places.
std::string Numbers(float size) {
  const std::array<std::uint16_t, 12> corners{0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2};
  const std::array<float, 12> places{0, 0, 0, size, 0, 0, 0, size, 0, 0, 0, size};
  std::string bytes(sizeof places + sizeof corners, '\0');
  std::memcpy(bytes.data(), places.data(), sizeof places);
  std::memcpy(bytes.data() + sizeof places, corners.data(), sizeof corners);
  return bytes;
}

/// Returns a glTF file whose numbers are in a file of that name.
std::string Gltf(const std::string& uri) {
  return R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
    "meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],
    "accessors":[{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3",
                  "min":[0,0,0],"max":[1,1,1]},
                 {"bufferView":1,"componentType":5123,"count":12,"type":"SCALAR"}],
    "bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":48},
                   {"buffer":0,"byteOffset":48,"byteLength":24}],
    "images":[{"uri":"no_such.png"}],
    "buffers":[{"byteLength":72,"uri":")" +
         uri + "\"}]}";
}

class SceneHashOfGltf : public ::testing::Test {
 protected:
  Result<SceneHash> HashOf(const std::string& content, const std::string& name = "part.gltf") {
    Scene scene;
    scene.bodies.resize(1);
    scene.bodies[0].mesh = scratch_.Write(name, content);
    return HashScene(scene);
  }
  void ExpectRefused(const std::string& content, const std::string& why) {
    const Result<SceneHash> hash = HashOf(content);
    ASSERT_FALSE(hash) << content;
    EXPECT_THAT(hash.error().what, HasSubstr(why));
  }
  ScratchFolder scratch_;
};

TEST_F(SceneHashOfGltf, CoversTheFilesThatHoldItsNumbers) {
  for (const std::string name :
       {"part.bin", "sub/../part.bin", "with%20sign.bin", "two words.bin"}) {
    fs::create_directories(scratch_.path() / "sub");
    const std::string file = fs::path(name).filename().string();
    scratch_.Write(file, Numbers(1));
    const Result<SceneHash> one = HashOf(Gltf(name));
    ASSERT_TRUE(one) << one.error().what;
    EXPECT_TRUE(ImportMesh(scratch_.path() / "part.gltf")) << name << ": it stays readable";
    scratch_.Write(file, Numbers(2));
    const Result<SceneHash> other = HashOf(Gltf(name));
    ASSERT_TRUE(other) << other.error().what;
    EXPECT_NE(one->content, other->content) << name;
    EXPECT_NE(one->bodies[0].mesh, other->bodies[0].mesh);
    EXPECT_EQ(one->bodies[0].values, other->bodies[0].values);
  }
}

// The mesh library knows it by its content, and takes a key for what it says.
TEST_F(SceneHashOfGltf, CoversThemWhateverItIsCalledAndHoweverItIsWritten) {
  const auto differs = [&](const std::string& content, const std::string& name) {
    scratch_.Write("part.bin", Numbers(1));
    const Result<SceneHash> one = HashOf(content, name);
    scratch_.Write("part.bin", Numbers(2));
    const Result<SceneHash> other = HashOf(content, name);
    return one && other && one->content != other->content;
  };
  EXPECT_TRUE(differs("\n " + Gltf("part.bin"), "part.mesh"));
  std::string text = Gltf("part.bin");
  text.replace(text.rfind("uri"), 3, "\\u0075ri");
  EXPECT_TRUE(differs(text, "part.gltf"));
  EXPECT_TRUE(differs("\xEF\xBB\xBF" + Gltf("part.bin"), "part.gltf"));
  text = Gltf("data:,x");
  text.insert(text.size() - 1, R"(,"buffers":[{"byteLength":72,"uri":"part.bin"}])");
  EXPECT_TRUE(differs(text, "part.gltf")) << "the key is given twice";
  text = Gltf("part.bin");
  std::string glb = "glTF" + std::string("\2\0\0\0", 4) + std::string(12, '\0') + text;
  const auto length = static_cast<std::uint32_t>(text.size());
  std::memcpy(&glb[12], &length, sizeof length);
  EXPECT_TRUE(differs(glb, "part.glb"));
}

TEST_F(SceneHashOfGltf, RefusesBuffersThatAreNoFilesOfItsFolder) {
  ExpectRefused(Gltf("none.bin"), "none.bin: there is no such file");
  ExpectRefused(Gltf("../part.bin"), "its buffer \"../part.bin\" is no file in its folder");
  ExpectRefused(Gltf("/etc/hostname"), "its buffer \"/etc/hostname\" is no file in its folder");
  ExpectRefused(Gltf(""), "is no file in its folder");
  ASSERT_EQ(mkfifo((scratch_.path() / "pipe.bin").c_str(), 0600), 0);
  ExpectRefused(Gltf("pipe.bin"), "not a regular file");
  ExpectRefused(Gltf("part.bin") + "x", "its buffers cannot be found: ");
  std::string many;
  for (int i = 0; i < 300; ++i) many += "a.bin\"},{\"uri\":\"";
  ExpectRefused(Gltf(many), "has more than 256 values");
}

TEST_F(SceneHashOfGltf, OfOneFileIsThatOfItsBytes) {
  const Result<SceneHash> inside = HashOf(Gltf("data:application/octet-stream;base64,AAAA"));
  ASSERT_TRUE(inside) << inside.error().what;
  // recordings of such scenes have this hash
  Hash64 hash;
  const std::string text = Gltf("data:application/octet-stream;base64,AAAA");
  hash.AddBytes(text.data(), text.size());
  hash.Add(std::uint64_t{text.size()});
  EXPECT_EQ(inside->bodies[0].mesh, hash.value());
}

}  // namespace
}  // namespace tandem
