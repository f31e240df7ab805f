#include <filesystem>
#include <memory>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/common/exit_codes.h"
#include "collab/dds/transport/dds_transport.h"
#include "collab/session/early_inbox.h"
#include "collab/session/scene_agreement.h"
#include "engine/scene/scene_hash.h"
#include "tests/app/cli/peer_program.h"
#include "tests/collab/transfer/evil_server.h"
#include "tests/support/forged_meshes.h"

// Tests what `tandem peer` makes of forged scenes, and of a peer that hands out others than it
// says.

namespace tandem {
namespace {

namespace fs = std::filesystem;
using testing::EvilServer;
using ::testing::HasSubstr;
using testing::Listed;
using testing::ProgramOutput;
using testing::Running;
using testing::RunTandem;

constexpr PeerId kEvil = 6;

class EvilScene : public testing::PeerCommand {
 protected:
  EvilScene() {
    setenv("XDG_STATE_HOME", In("state").c_str(), 1);
    setenv("TANDEM_CACHE", In("cache").c_str(), 1);
    for (const auto& [name, mesh] :
         {std::pair{"honest", testing::HonestStl()}, {"forged", testing::ForgedStl()}}) {
      folder_.Write(std::string(name) + ".stl", mesh);
      folder_.Write(std::string(name) + ".json", SceneText(std::string(name) + ".stl"));
    }
  }
  static std::string SceneText(const std::string& mesh) {
    return R"({"name": "part", "voxel_m": 0.005, "bodies": [{"name": "part", "mass_kg": 1, "mesh": ")" +
           mesh + "\"}]}";
  }
  SceneManifest ManifestOfHonest() const {
    const Result<Scene> scene = LoadScene(In("honest.json"));
    EXPECT_TRUE(scene) << scene.error().what;
    SceneManifest manifest = ManifestOf(*scene, *HashScene(*scene), kEvil);
    manifest.file = "/nowhere/part.json";
    return manifest;
  }

  /// Lets a joiner without the scene meet a peer that says it has it, and hands out these files.
  ProgramOutput Joins(const Listed& listed) const {
    const SceneManifest manifest = ManifestOfHonest();
    EvilServer evil(kEvil, manifest.content_hash, [&](const FileAsk& ask, const auto& send) {
      EvilServer::Serve(listed, ask, send);
    });
    EarlyInbox others;
    DdsOptions options;
    options.session = session_;
    options.peer = kEvil;
    options.interface = "lo";
    options.files = &evil;
    auto joined = JoinOverDds(options, others);
    EXPECT_TRUE(joined) << joined.error().what;
    (*joined)->Publish(manifest);
    ProgramOutput output = RunTandem(
        "peer --interface lo --capacity 20000 --seconds 0.1 --accept-scene --scene-from-session "
        "--session " +
            session_,
        "timeout 60 ");
    (*joined)->Leave();
    return output;
  }
  void ExpectRefusedAndGone(const ProgramOutput& output, const std::string& why) const {
    EXPECT_EQ(output.exit_code, kExitFile) << output.err;
    EXPECT_THAT(output.err, HasSubstr("this machine does not have the session's scene part: "));
    EXPECT_THAT(output.err, HasSubstr(why));
    const fs::path plain = In("cache/fetched/plain");
    EXPECT_TRUE(!fs::exists(plain) || fs::is_empty(plain));
  }
};

TEST_F(EvilScene, ForgedFilesOfTheSameHashAreNotTheSessionsScene) {
  const ProgramOutput output = Joins(Listed({SceneText("file:1"), testing::ForgedStl()}));
  ExpectRefusedAndGone(output, "is not the one of the session's scene \"part\"");
}

TEST_F(EvilScene, MeshThatNamesOtherFilesIsRefused) {
  const std::string gltf =
      R"({"asset": {"version": "2.0"}, "buffers": [{"uri": "../../../../../../etc/passwd", )"
      R"("byteLength": 100}]})";
  ExpectRefusedAndGone(Joins(Listed({SceneText("file:1"), gltf}, ".gltf")), "etc/passwd");
}

TEST_F(EvilScene, SceneThatNamesAFileOfThisMachineIsRefused) {
  ExpectRefusedAndGone(Joins(Listed({SceneText("/etc/passwd"), testing::HonestStl()})),
                       "a mesh that is none of its files");
}

// Before protocol 6 the two of them met, and pushed one another's other shapes.
TEST_F(EvilScene, PeersWithAForgedAndAnHonestSceneDoNotMeet) {
  Running anna = Start("honest", "--name anna");
  ASSERT_TRUE(anna.WaitFor("anna is in session"));
  const ProgramOutput ben = Run("forged", "--name ben --seconds 0.5");
  EXPECT_EQ(ben.exit_code, kExitIncompatiblePeer) << ben.err;
  EXPECT_THAT(ben.err, HasSubstr("body \"part\": its file " + In("forged.stl") +
                                 " is not the one of the session's scene \"part\""));
  EXPECT_EQ(anna.End(), kExitOk);
}

}  // namespace
}  // namespace tandem
