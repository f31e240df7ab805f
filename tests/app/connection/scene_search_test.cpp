#include "app/connection/scene_search.h"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <stop_token>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "app/connection/recent_scenes.h"
#include "engine/scene/scene.h"
#include "engine/scene/scene_hash.h"
#include "tests/support/forged_meshes.h"
#include "tests/support/scratch_folder.h"

namespace tandem {
namespace {

namespace fs = std::filesystem;

constexpr const char* kTetrahedron =
    "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";

class SceneSearch : public ::testing::Test {
 protected:
  void SetUp() override {
    setenv("XDG_STATE_HOME", (scratch_.path() / "state").c_str(), 1);
    fs::create_directories(scratch_.path() / "work");
    fs::current_path(scratch_.path() / "work");
  }
  void TearDown() override {
    fs::current_path(before_);
    setenv("XDG_STATE_HOME", "/dev/null", 1);
  }
  /// Makes a scene of one moving body in a folder of its own. Another mass is another scene.
  fs::path MakeScene(const fs::path& file, double mass) {
    const fs::path folder = (scratch_.path() / file).parent_path();
    fs::create_directories(folder);
    scratch_.Write((file.parent_path() / "part.obj").string(), kTetrahedron);
    return scratch_.Write(file.string(),
                          R"({"name": "s", "voxel_m": 0.001, "bodies": [{"name": "part", "mesh": )"
                          R"("part.obj", "mass_kg": )" +
                              std::to_string(mass) + "}]}");
  }
  static WantedScene Wanted(const fs::path& like, const fs::path& reported) {
    const Result<Scene> scene = LoadScene(like);
    EXPECT_TRUE(scene) << scene.error().what;
    const Result<SceneHash> hash = HashScene(*scene);
    return {.digest = hash->digest,
            .content_hash = hash->content,
            .file = reported,
            .bodies = scene->bodies.size(),
            .fetched = {}};
  }
  ScratchFolder scratch_;
  const fs::path before_ = fs::current_path();
};

TEST_F(SceneSearch, FindsACopyOfAMissingScene) {
  const fs::path copy = MakeScene("own/peg.json", 0.2);
  MakeScene("own/a.json", 0.3);
  const WantedScene wanted = Wanted(copy, "/home/anna/scenes/peg.json");
  EXPECT_EQ(FindScene(wanted, {scratch_.path() / "own"}), copy);
  EXPECT_EQ(FindScene(wanted, {scratch_.path() / "nowhere", scratch_.path() / "work"}),
            std::nullopt);
}

TEST_F(SceneSearch, IdentifiesScenesByContent) {
  const fs::path other = MakeScene("own/peg.json", 0.3);
  const fs::path renamed = MakeScene("own/zzz.json", 0.2);
  const WantedScene wanted = Wanted(renamed, other);
  EXPECT_EQ(FindScene(wanted, {scratch_.path() / "own"}), renamed);
  // the file is another scene here at the path that the other machine has, and is passed over, too
  EXPECT_EQ(FindScene(Wanted(renamed, other), {}), std::nullopt);
  // a file that cannot be read is no scene
  scratch_.Write("own/aaa.json", "{");
  fs::create_directories(scratch_.path() / "own" / "folder.json");
  EXPECT_EQ(FindScene(wanted, {scratch_.path() / "own"}), renamed);
}

TEST_F(SceneSearch, UsesTheNamedFileIfItMatches) {
  const fs::path reported = MakeScene("theirs/peg.json", 0.2);
  MakeScene("own/peg.json", 0.2);
  EXPECT_EQ(FindScene(Wanted(reported, reported), {scratch_.path() / "own"}), reported);
}

TEST_F(SceneSearch, NeverOpensTheSessionsPath) {
  const fs::path reported = MakeScene("theirs/peg.json", 0.2);
  SceneManifest manifest;
  manifest.content_digest = *Wanted(reported, reported).digest;
  manifest.file = reported.string();
  manifest.bodies.resize(1);
  EXPECT_EQ(FindScene(WantedFrom(manifest, {}), {scratch_.path() / "own"}), std::nullopt);
  EXPECT_EQ(FindScene(WantedFrom(manifest, {}), {reported.parent_path()}), reported);
}

// A stranger may name any path of this machine: a log, a device, somebody's secrets.
TEST_F(SceneSearch, OpensOnlyPlausibleSceneFiles) {
  const fs::path scene = MakeScene("theirs/peg.json", 0.2);
  const fs::path log = scene.parent_path() / "peg.log";
  fs::copy_file(scene, log);
  EXPECT_EQ(FindScene(Wanted(scene, log), {}), std::nullopt);
  const fs::path large = scene.parent_path() / "large.json";
  fs::copy_file(scene, large);
  std::ofstream(large, std::ios::app) << std::string((4 << 20) + 1, ' ');
  EXPECT_EQ(FindScene(Wanted(scene, large), {}), std::nullopt);
  const fs::path pipe = scene.parent_path() / "pipe.json";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_EQ(FindScene(Wanted(scene, pipe), {scene.parent_path()}), scene);
}

// A pipe that nobody writes to would hold up its reader for ever.
TEST_F(SceneSearch, ReadsOnlyRegularMeshFiles) {
  const fs::path own = MakeScene("own/peg.json", 0.2);
  const WantedScene wanted = Wanted(own, own);
  fs::remove(own.parent_path() / "part.obj");
  ASSERT_EQ(mkfifo((own.parent_path() / "part.obj").c_str(), 0600), 0);
  EXPECT_EQ(FindScene(wanted, {own.parent_path()}), std::nullopt);
}

/// Writes a scene of one mesh with these bytes.
fs::path SceneOf(const ScratchFolder& scratch, const std::string& folder, const std::string& stl) {
  fs::create_directories(scratch.path() / folder);
  scratch.Write(folder + "/part.stl", stl);
  return scratch.Write(folder + "/peg.json",
                       R"({"name": "s", "voxel_m": 0.001, "bodies": [{"name": "part", "mesh": )"
                       R"("part.stl", "mass_kg": 1}]})");
}

SceneManifest ManifestOf(const fs::path& scene) {
  const Result<Scene> loaded = LoadScene(scene);
  const Result<SceneHash> hash = HashScene(*loaded);
  SceneManifest manifest;
  manifest.name = loaded->name;
  manifest.file = "/nowhere/peg.json";
  manifest.content_hash = hash->content;
  manifest.content_digest = hash->digest;
  manifest.bodies.resize(1);
  return manifest;
}

TEST_F(SceneSearch, ForgedSceneOfTheSameHashIsNotFound) {
  const fs::path honest = SceneOf(scratch_, "honest", testing::HonestStl());
  const fs::path forged = SceneOf(scratch_, "forged", testing::ForgedStl());
  const SceneManifest manifest = ManifestOf(honest);
  ASSERT_EQ(ManifestOf(forged).content_hash, manifest.content_hash);
  const WantedScene wanted = WantedFrom(manifest, {});
  EXPECT_EQ(FindScene(wanted, {forged.parent_path()}), std::nullopt);
  EXPECT_EQ(FindScene(wanted, {forged.parent_path(), honest.parent_path()}), honest);
  // a peer that tells no digest, as one of protocol 5, has no scene that this machine could have
  SceneManifest silent = manifest;
  silent.content_digest = {};
  EXPECT_EQ(FindScene(WantedFrom(silent, {}), {honest.parent_path()}), std::nullopt);
}

TEST_F(SceneSearch, FetchedSceneServesSessionsOfItsOwnSendersOnly) {
  setenv("TANDEM_CACHE", (scratch_.path() / "cache").c_str(), 1);
  const fs::path sent = SceneOf(scratch_, "sent", testing::HonestStl());
  const SceneManifest manifest = ManifestOf(sent);
  const auto keys = [this](const std::string& name) {
    fs::create_directories(scratch_.path() / name);
    scratch_.Write(name + "/identity_ca.pem", "the authority of " + name);
    scratch_.Write(name + "/permissions_ca.pem", "another of " + name);
    return scratch_.path() / name;
  };
  const fs::path gear = keys("gear");
  const fs::path wing = keys("wing");
  const auto put = [&](const fs::path& of) {
    const fs::path file = FetchedScenes(of)->SceneFileOf(manifest.content_digest);
    fs::create_directories(file.parent_path());
    fs::copy_file(sent, file);
    fs::copy_file(sent.parent_path() / "part.stl", file.parent_path() / "part.stl");
    return file;
  };
  const fs::path plain = put({});
  EXPECT_EQ(FindScene(WantedFrom(manifest, {}), {}), plain);
  EXPECT_EQ(FindScene(WantedFrom(manifest, gear), {}), std::nullopt);
  const fs::path of_gear = put(gear);
  EXPECT_EQ(FindScene(WantedFrom(manifest, gear), {}), of_gear);
  EXPECT_EQ(FindScene(WantedFrom(manifest, wing), {}), std::nullopt);
  // another member of gear has the same authorities in another folder
  fs::copy(gear, scratch_.path() / "anna");
  EXPECT_EQ(FindScene(WantedFrom(manifest, scratch_.path() / "anna"), {}), of_gear);
  EXPECT_FALSE(FetchedScenes(scratch_.path() / "no keys"));
  unsetenv("TANDEM_CACHE");
}

TEST_F(SceneSearch, CanBeCancelled) {
  const fs::path own = MakeScene("own/peg.json", 0.2);
  std::stop_source stop;
  stop.request_stop();
  EXPECT_EQ(FindScene(Wanted(own, "/nowhere/peg.json"), {own.parent_path()}, stop.get_token()),
            std::nullopt);
}

TEST_F(SceneSearch, RemembersRecentExistingScenesNewestFirst) {
  EXPECT_TRUE(RecentScenes().empty());
  std::vector<fs::path> made;
  for (int i = 0; i < 12; ++i) {
    made.push_back(MakeScene("own/s" + std::to_string(i) + ".json", 0.2));
    RememberScene(made.back());
  }
  RememberScene(made[5]);
  std::vector<fs::path> recent = RecentScenes();
  ASSERT_EQ(recent.size(), 10U);
  EXPECT_EQ(recent[0], made[5]);
  EXPECT_EQ(recent[1], made[11]);
  EXPECT_EQ(std::count(recent.begin(), recent.end(), made[5]), 1);
  fs::remove(made[11]);
  recent = RecentScenes();
  EXPECT_EQ(recent[1], made[10]);
}

TEST_F(SceneSearch, SearchesTheCurrentAndRecentFolders) {
  const fs::path first = MakeScene("one/peg.json", 0.2);
  const fs::path second = MakeScene("two/peg.json", 0.2);
  EXPECT_THAT(FoldersWithScenes(), ::testing::Contains(fs::current_path()));
  EXPECT_THAT(FoldersWithScenes(), ::testing::Not(::testing::Contains(first.parent_path())));
  RememberSceneFolder(first);
  RememberSceneFolder(second);
  RememberSceneFolder(first);
  const std::vector<fs::path> folders = FoldersWithScenes();
  ASSERT_GE(folders.size(), 3U);
  EXPECT_EQ(folders[0], fs::current_path());
  EXPECT_EQ(folders[1], first.parent_path());
  EXPECT_EQ(folders[2], second.parent_path());
  // a file that is gone is passed over
  fs::remove_all(first.parent_path());
  EXPECT_EQ(FoldersWithScenes()[1], second.parent_path());
}

TEST_F(SceneSearch, RemembersFewFoldersAndToleratesAnUnwritableList) {
  for (int i = 0; i < 30; ++i) {
    RememberSceneFolder(MakeScene("many" + std::to_string(i) + "/peg.json", 0.2));
  }
  EXPECT_LE(FoldersWithScenes().size(), 10U);
  setenv("XDG_STATE_HOME", "/dev/null", 1);
  RememberSceneFolder(MakeScene("other/peg.json", 0.2));
  EXPECT_THAT(FoldersWithScenes(), ::testing::Not(::testing::Contains(scratch_.path() / "other")));
}

}  // namespace
}  // namespace tandem
