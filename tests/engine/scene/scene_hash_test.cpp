#include "engine/scene/scene_hash.h"

#include <array>
#include <cstring>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <sys/stat.h>

#include "engine/base/hash.h"
#include "engine/geometry/import/mesh_file.h"
#include "tests/engine/scene/scene_file_fixture.h"
#include "tests/support/scratch_folder.h"

namespace tandem {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using testing::kScene;
using testing::SceneFile;

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
TEST_F(SceneHashOfGltf, CoversThemForAnyNameAndLayout) {
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

TEST_F(SceneHashOfGltf, RefusesBuffersOutsideItsFolder) {
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

TEST_F(SceneHashOfGltf, SingleFileHashIsThatOfItsBytes) {
  const Result<SceneHash> inside = HashOf(Gltf("data:application/octet-stream;base64,AAAA"));
  ASSERT_TRUE(inside) << inside.error().what;
  // recordings of such scenes have this hash
  Hash64 hash;
  const std::string text = Gltf("data:application/octet-stream;base64,AAAA");
  hash.AddBytes(text.data(), text.size());
  hash.Add(std::uint64_t{text.size()});
  EXPECT_EQ(inside->bodies[0].mesh, hash.value());
}

TEST_F(SceneFile, PartOfAMeshFileHasItsOwnHash) {
  const std::string part = WithKeys("\"part\": \"Object_2\"");
  const Result<Scene> scene = LoadScene(File(part));
  ASSERT_TRUE(scene) << scene.error().what;
  EXPECT_EQ(scene->bodies[2].part, "Object_2");
  EXPECT_NE(Hash(part), Hash(kScene));
  EXPECT_NE(Hash(part), Hash(WithKeys("\"part\": \"Object_3\"")));
  EXPECT_EQ(Hash(part), Hash(part));
}

// Peers must have the same hash of content. One point a voxel leaves the hash as it is without the
// key.
TEST_F(SceneFile, HashFollowsThePointSpacingUnlessItIsAVoxel) {
  const SceneHash hash = Hashes(kScene);
  EXPECT_EQ(Hash(WithKeys("\"point_spacing_voxels\": 1")), hash.content);
  const SceneHash finer = Hashes(WithKeys("\"point_spacing_voxels\": 0.4"));
  EXPECT_NE(finer.bodies[2].values, hash.bodies[2].values);
  EXPECT_EQ(finer.bodies[1], hash.bodies[1]);
  EXPECT_EQ(finer.parameters, hash.parameters);
  // the key stands once for all bodies, or for each
  const SceneHash all = Hashes(WithKeys("\"free\": false", "\"point_spacing_voxels\": 0.4,"));
  EXPECT_EQ(all.bodies[2], finer.bodies[2]);
  EXPECT_EQ(all.bodies[0], hash.bodies[0]);  // fixed: it has no points
}

TEST_F(SceneFile, HashCoversBodyContent) {
  const std::uint64_t hash = Hash(kScene);
  for (const auto& [from, to] : std::vector<std::pair<std::string, std::string>>{
           {"0.3, \"sharing\"", "0.31, \"sharing\""},
           {"\"shared\"", "\"own\""},
           {"\"scale\": 0.001", "\"scale\": 0.002"},
           {"[0.1, 0.2, 0.3]", "[0.1, 0.2, 0.4]"},
           {"0.6, 0.8", "0.8, 0.6"},
           {"\"inward_shift_voxels\": 0.5", "\"inward_shift_voxels\": 0"},
           {"2700", "2701"}}) {
    EXPECT_NE(Hash(Changed(from, to)), hash) << from;
  }
  EXPECT_NE(Hash(WithKeys("\"free\": true")), hash);
  EXPECT_NE(Hash(WithKeys("\"free\": false", "\"gravity_m_s2\": [0, 0, -1],")), hash);
  EXPECT_NE(Hash(WithKeys(R"("constraint": {"ball": {"p_W": [0, 0, 0]}})")), hash);
  EXPECT_NE(Hash(WithKeys(R"("constraint": {"ball": {"p_W": [0, 0, 0]}})")),
            Hash(WithKeys(R"("constraint": {"ball": {"p_W": [0, 0, 1]}})")));
  const std::string pair = R"("pairs": [{"pointshell": "ring", "voxmap": "peg"}],)";
  EXPECT_NE(Hash(WithKeys("\"free\": false", pair)), hash);
  EXPECT_EQ(Hash(WithKeys("\"free\": false")), hash);
  folder_.Write("peg.stl", "pegs");
  EXPECT_NE(Hash(kScene), hash);
}

// Without a scale a 3MF file's own unit counts, with one it does not: these are other bodies.
TEST_F(SceneFile, HashDistinguishesAFilesUnitFromAScaleOfOne) {
  folder_.Write("peg.3mf", "peg");
  folder_.Write("peg.stl", "peg");
  const auto hash_of = [this](const std::string& mesh, const std::string& scale) {
    return Hash(R"({"name": "s", "voxel_m": 0.001, "bodies": [{"name": "peg", "mesh": ")" + mesh +
                "\", " + scale + "\"mass_kg\": 1}]}");
  };
  EXPECT_NE(hash_of("peg.3mf", ""), hash_of("peg.3mf", "\"scale\": 1, "));
  EXPECT_NE(hash_of("peg.3mf", ""), hash_of("peg.3mf", "\"scale\": 0.001, "));
  // other files have none: a scale of one is what they are read by
  EXPECT_EQ(hash_of("peg.stl", ""), hash_of("peg.stl", "\"scale\": 1, "));
  EXPECT_EQ(hash_of("peg.stl", ""), hash_of("peg.3mf", "\"scale\": 1, "));
}

TEST_F(SceneFile, ForceParametersHaveAHashOfTheirOwn) {
  const SceneHash hash = Hashes(kScene);
  for (const auto& [from, to] : std::vector<std::pair<std::string, std::string>>{
           {"0.0005", "0.001"},
           {"\"force_layer\": 1", "\"force_layer\": 2"},
           {"\"force_layer\": 1", "\"contact\": \"plain\", \"force_layer\": 1"},
           {"\"force_layer\": 1", "\"friction\": 0.4, \"force_layer\": 1"}}) {
    const SceneHash changed = Hashes(Changed(from, to));
    EXPECT_NE(changed.parameters, hash.parameters) << to;
    EXPECT_EQ(changed.content, hash.content) << to;
    EXPECT_EQ(changed.bodies, hash.bodies) << to;
  }
  EXPECT_EQ(Hashes(WithKeys("\"free\": false", "\"friction\": 0,")).parameters, hash.parameters);
  EXPECT_EQ(Hashes(Changed("2700", "2701")).parameters, hash.parameters);
}

TEST_F(SceneFile, EveryBodyHasHashesOfItsValuesAndItsMesh) {
  const SceneHash hash = Hashes(kScene);
  ASSERT_EQ(hash.bodies.size(), 3U);
  EXPECT_EQ(hash.bodies[1].mesh, hash.bodies[2].mesh);  // both are from one file
  EXPECT_NE(hash.bodies[0].mesh, hash.bodies[1].mesh);
  const SceneHash denser = Hashes(Changed("2700", "2701"));
  EXPECT_EQ(denser.bodies[1], hash.bodies[1]);
  EXPECT_NE(denser.bodies[2].values, hash.bodies[2].values);
  EXPECT_EQ(denser.bodies[2].mesh, hash.bodies[2].mesh);
  folder_.Write("block.stl", "blocks");
  const SceneHash other = Hashes(kScene);
  EXPECT_NE(other.bodies[0].mesh, hash.bodies[0].mesh);
  EXPECT_EQ(other.bodies[0].values, hash.bodies[0].values);
  EXPECT_EQ(other.bodies[1], hash.bodies[1]);
}

TEST_F(SceneFile, HashIgnoresIrrelevantContent) {
  const std::uint64_t hash = Hash(kScene);
  EXPECT_EQ(Hash(Changed("#ff8000", "#000000")), hash);
  EXPECT_EQ(Hash(Changed("\"body\": \"peg\"", "\"body\": \"ring\"")), hash);

  // the same scene elsewhere
  const ScratchFolder other;
  other.Write("block.stl", "block");
  other.Write("peg.stl", "peg");
  other.Write("left.json", "{}");
  const Result<Scene> scene = LoadScene(other.Write("renamed.json", kScene));
  ASSERT_TRUE(scene);
  EXPECT_EQ(HashScene(*scene)->content, hash);
}

TEST_F(SceneFile, HashOfAMissingMeshIsAnError) {
  Result<Scene> scene = LoadScene(File(kScene));
  ASSERT_TRUE(scene);
  scene->bodies[0].mesh = folder_.path() / "gone.stl";
  const Result<SceneHash> hash = HashScene(*scene);
  ASSERT_FALSE(hash);
  EXPECT_THAT(hash.error().what, HasSubstr("gone.stl"));
}

}  // namespace
}  // namespace tandem
