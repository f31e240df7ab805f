#include <bit>
#include <cstdint>

#include <gtest/gtest.h>

#include "engine/base/text/hex.h"
#include "engine/scene/scene_hash.h"
#include "tests/engine/scene/scene_file_fixture.h"
#include "tests/support/forged_meshes.h"

namespace tandem {
namespace {

using testing::ForgedStl;
using testing::HonestStl;
using testing::kScene;
using testing::SceneFile;

TEST_F(SceneFile, ForgedMeshHasTheHashOfTheHonestOneAndAnotherDigest) {
  folder_.Write("peg.stl", HonestStl());
  const SceneHash honest = Hashes(kScene);
  folder_.Write("peg.stl", ForgedStl());
  const SceneHash forged = Hashes(kScene);
  // the forgery is one: else this test proves nothing
  ASSERT_EQ(forged.content, honest.content);
  ASSERT_EQ(forged.bodies[1].mesh, honest.bodies[1].mesh);
  EXPECT_NE(forged.digest, honest.digest);
  EXPECT_NE(forged.bodies[1].mesh_digest, honest.bodies[1].mesh_digest);
  EXPECT_EQ(forged.bodies[0].mesh_digest, honest.bodies[0].mesh_digest);
}

// sha256sum says the same of the file with the three letters peg.
TEST_F(SceneFile, DigestOfAMeshIsTheSha256OfItsFile) {
  EXPECT_EQ(HexOfBytes(Hashes(kScene).bodies[1].mesh_digest),
            "5ca1b7b104433c8e4e319bedf7678d3a07e4725b1dc8ccadd64fa4e21a8110d7");
}

// A file may be one mesh as .obj and another as .stl.
TEST_F(SceneFile, DigestCoversTheKindByWhichAMeshIsRead) {
  folder_.Write("peg.obj", "peg");
  folder_.Write("peg.STL", "peg");
  const SceneHash stl = Hashes(kScene);
  EXPECT_NE(Hashes(Changed("\"peg.stl\", \"density", "\"peg.obj\", \"density")).digest, stl.digest);
  EXPECT_EQ(Hashes(Changed("\"peg.stl\", \"density", "\"peg.STL\", \"density")).digest, stl.digest);
}

// The hash has the name of a part directly before numbers. So eight letters of a name pass for the
// first number, if each number goes one place on and the last is the optional one.
TEST_F(SceneFile, DigestKeepsTextsAndNumbersApart) {
  Scene one = *LoadScene(File(kScene));
  SceneBody& ring = one.bodies[2];
  ring.part = "a00000000";
  ring.X_WM.p = Vec3(0.25, 0.5, 0.75);
  ring.X_WM.q.coeffs() << 1, 0, 0, 0;
  ring.fixed = false;
  ring.shared = true;
  ring.mass = 2;
  ring.density = 3;
  ring.inward_shift_voxels = 0.5;
  Scene other = one;
  SceneBody& moved = other.bodies[2];
  moved.part = "a";
  constexpr std::uint64_t kZeros = 0x3030303030303030;  // the letters 00000000
  moved.X_WM.p = Vec3(std::bit_cast<double>(kZeros), 0.25, 0.5);
  moved.X_WM.q.coeffs() << 0.75, 1, 0, 0;
  moved.shared = false;
  moved.mass = 1;
  moved.density = 2;
  moved.inward_shift_voxels = 3;
  moved.point_spacing_voxels = 0.5;
  ASSERT_EQ(HashScene(other)->content, HashScene(one)->content);
  EXPECT_NE(HashScene(other)->digest, HashScene(one)->digest);
}

}  // namespace
}  // namespace tandem
