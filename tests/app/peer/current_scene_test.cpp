#include "app/peer/current_scene.h"

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include <gmock/gmock.h>
#include <unistd.h>

#include "engine/base/files/regular_file.h"
#include "tests/support/scratch_folder.h"

namespace tandem {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

/// Writes a scene of two bodies into a folder of that name, and saves it beside that as it stands.
Result<bool> SavedFrom(const ScratchFolder& scratch, const std::string& name, const fs::path& saved,
                       const std::optional<AddedBody>& added = {}) {
  const fs::path folder = scratch.path() / name;
  fs::create_directories(folder);
  for (const char* mesh : {"base.stl", "part.stl"}) std::ofstream(folder / mesh) << "solid";
  const fs::path file = scratch.Write(name + "/scene.json", R"({"name": "s", "voxel_m": 0.001,
      "bodies": [{"name": "base", "mesh": "base.stl", "fixed": true},
                 {"name": "part", "mesh": "part.stl", "mass_kg": 1}]})");
  const Result<Scene> scene = LoadScene(file);
  EXPECT_TRUE(scene) << scene.error().what;
  if (!scene) return scene.error();
  return WriteCurrentScene(*scene, std::vector<Pose>(scene->bodies.size()), added, saved, false);
}

TEST(CurrentScene, NamesItsMeshesByAbsolutePaths) {
  const ScratchFolder scratch;
  const fs::path saved = scratch.path() / "saved.json";
  const Result<bool> written = SavedFrom(scratch, "b\xC3\xA9", saved);
  ASSERT_TRUE(written) << written.error().what;
  const Result<Scene> again = LoadScene(saved);
  ASSERT_TRUE(again) << again.error().what;
  EXPECT_EQ(again->bodies[1].mesh, scratch.path() / "b\xC3\xA9" / "part.stl");
}

// JSON is UTF-8. With a replacement for a byte the scene would name a mesh that does not exist.
TEST(CurrentScene, IsNotSavedWithoutMeshPaths) {
  const ScratchFolder scratch;
  const fs::path saved = scratch.path() / "saved.json";
  const Result<bool> written = SavedFrom(scratch, "b\xE9", saved);
  ASSERT_FALSE(written);
  EXPECT_THAT(written.error().what, HasSubstr("b?/base.stl: a scene cannot name this file"));
  const Result<bool> of_added =
      SavedFrom(scratch, "b", saved, AddedBody{.name = "new", .mesh = "/b\xE9.stl"});
  ASSERT_FALSE(of_added);
  EXPECT_THAT(of_added.error().what, HasSubstr("/b?.stl: a scene cannot name this file"));
  EXPECT_FALSE(fs::exists(saved));
}

// A file that a shell reads must not run what stands in a scene.
TEST(CurrentScene, SavedSceneRunsNothingWhereAShellReadsIt) {
  const ScratchFolder scratch;
  const std::string evil =
      "$(touch ran) `touch ran`; (touch ran) & ! > ran | \x7f \xC2\x9B \n 'x\"";
  const fs::path saved = scratch.path() / "saved.json";
  const Result<bool> written = SavedFrom(
      scratch, "a", saved, AddedBody{.name = evil, .mesh = scratch.path() / "a" / "part.stl"});
  ASSERT_TRUE(written) << written.error().what;
  std::ifstream stream(saved);
  const std::string text{std::istreambuf_iterator<char>(stream), {}};
  EXPECT_EQ(text.find_first_of("$`();<>&|!'\x7f"), std::string::npos) << text;
  EXPECT_EQ(text.find('\xC2'), std::string::npos);
  // the scene is the same to its reader
  const Result<Scene> again = LoadScene(saved);
  ASSERT_TRUE(again) << again.error().what;
  EXPECT_EQ(again->bodies[2].name, evil);
  // each line begins with a word that no program is called by
  const std::string command = "cd " + scratch.path().string() + " && bash -c '. ./saved.json' 2>&1";
  FILE* shell = popen(command.c_str(), "r");
  ASSERT_NE(shell, nullptr);
  std::string said;
  for (int c = std::fgetc(shell); c != EOF; c = std::fgetc(shell)) said += static_cast<char>(c);
  pclose(shell);
  EXPECT_FALSE(fs::exists(scratch.path() / "ran")) << said;
}

// The scene's file may be another one by now, and each line of a saved file begins with a key.
TEST(CurrentScene, IsNotSavedFromAFileWithStrangeKeys) {
  const ScratchFolder scratch;
  const fs::path file = scratch.Write("scene.json", R"({"name": "s", "voxel_m": 0.001,
      "bodies": [{"name": "base", "mesh": "", "fixed": true}]})");
  Scene scene;
  scene.file = file;
  scene.bodies.resize(1);
  scratch.Write("scene.json", R"({"name": "s", "voxel_m": 0.001, "/tmp/program": 1,
      "bodies": [{"name": "base", "mesh": "", "fixed": true}]})");
  const Result<bool> written =
      WriteCurrentScene(scene, {Pose()}, std::nullopt, scratch.path() / "saved.json", false);
  ASSERT_FALSE(written);
  EXPECT_THAT(written.error().what, HasSubstr("has changed since it was loaded"));
  scratch.Write("scene.json", R"({"name": "s", "voxel_m": 0.001, "layers": ["reboot"],
      "bodies": [{"name": "base", "mesh": "", "fixed": true}]})");
  EXPECT_FALSE(
      WriteCurrentScene(scene, {Pose()}, std::nullopt, scratch.path() / "saved.json", false));
}

TEST(CurrentScene, OtherUsersCannotReadASceneSavedElsewhere) {
  const ScratchFolder scratch;
  fs::create_directory(scratch.path() / "a");
  fs::create_directory(scratch.path() / "elsewhere");
  const fs::path beside = scratch.path() / "a" / "saved.json";
  const fs::path elsewhere = scratch.path() / "elsewhere" / "saved.json";
  ASSERT_TRUE(SavedFrom(scratch, "a", beside));
  ASSERT_TRUE(SavedFrom(scratch, "a", elsewhere));
  EXPECT_EQ(fs::status(beside).permissions() & fs::perms::others_read, fs::perms::others_read);
  EXPECT_EQ(fs::status(elsewhere).permissions(), fs::perms::owner_read | fs::perms::owner_write);
}

TEST(CurrentScene, HostSavesOnlyScenesWhereASceneMayBe) {
  const ScratchFolder scratch;
  const fs::path scene = scratch.Write("scene.json", "");
  fs::create_directories(scratch.path() / "plain");
  fs::create_directories(scratch.path() / ".hidden");
  const auto why = [&](const fs::path& file) {
    const std::optional<Error> fault = WhyNoPlaceForScene(file, scene);
    return fault ? fault->what : std::string();
  };
  EXPECT_EQ(why(scratch.path() / "plain" / "a.json"), "");
  EXPECT_EQ(why(scratch.path() / "b c (2).json"), "");
  EXPECT_THAT(why("a.json"), HasSubstr("expected an absolute path"));
  for (const char* name : {".bash_profile", ".json", ".a.json", "a.sh", "a", "a.json.sh", ""}) {
    EXPECT_THAT(why(scratch.path() / "plain" / name), HasSubstr("choose another name")) << name;
  }
  EXPECT_THAT(why(scratch.path() / "plain" / "a\nb.json"), HasSubstr("control characters"));
  EXPECT_THAT(why(scratch.path() / ".hidden" / "a.json"), HasSubstr("hidden folder"));
  EXPECT_THAT(why("/etc/a.json"), HasSubstr("folder of the system"));
  EXPECT_THAT(why("/etc/../etc/a.json"), HasSubstr("folder of the system"));
  EXPECT_THAT(why("/a.json"), HasSubstr("folder of the system"));
  EXPECT_THAT(why(scratch.path() / "nowhere" / "a.json"), HasSubstr("there is no such folder"));
  EXPECT_THAT(why(scene / "a.json"), HasSubstr("there is no such folder"));
  // a link to a folder of the system leads there
  fs::create_directory_symlink("/etc", scratch.path() / "plain" / "etc");
  EXPECT_THAT(why(scratch.path() / "plain" / "etc" / "a.json"), HasSubstr("folder of the system"));
  fs::create_directory_symlink(scratch.path() / "plain", scratch.path() / "link");
  EXPECT_EQ(why(scratch.path() / "link" / "a.json"), "");
  if (geteuid() != 0) GTEST_SKIP() << "only root can give a link to another user";
  ASSERT_EQ(lchown((scratch.path() / "link").c_str(), 65534, 65534), 0);
  EXPECT_THAT(why(scratch.path() / "link" / "a.json"),
              HasSubstr("another user has made this link"));
}

TEST(CurrentScene, HostIsNotToldWhatStandsInAFileThatIsNoScene) {
  const ScratchFolder scratch;
  const auto told = [](const fs::path& file) {
    const Result<Scene> loaded = LoadScene(file);
    EXPECT_FALSE(loaded);
    return ReasonWithoutContent(file, loaded.error().what);
  };
  for (const char* content : {"root:secret:1:0:99999", R"({"secret": "secret"})", R"(["secret"])",
                              R"({"name": "secret", "bodies": 1})", "secret", ""}) {
    const std::string reason = told(scratch.Write("file", content));
    EXPECT_EQ(reason.find("secret"), std::string::npos) << reason;
    EXPECT_EQ(reason.find("root"), std::string::npos) << reason;
    EXPECT_THAT(reason, HasSubstr("name another file"));
  }
  // the fault of a scene is told
  EXPECT_THAT(
      told(scratch.Write("scene.json", R"({"name": "s", "voxel_m": "small", "bodies": []})")),
      HasSubstr("got \"small\""));
  EXPECT_THAT(told(scratch.path() / "nowhere"), HasSubstr("there is no such file"));
  EXPECT_EQ(WithoutQuotedText("line 1: 'root:secret:1' is no number"),
            "line 1: '...' is no number");
  EXPECT_EQ(WithoutQuotedText("expected 3, got \"a \"b\" c\""), "expected 3, got \"...\"");
  EXPECT_EQ(WithoutQuotedText("it's larger"), "it's larger");
}

}  // namespace
}  // namespace tandem
