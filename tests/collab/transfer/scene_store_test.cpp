#include "collab/transfer/scene_store.h"

#include <fstream>
#include <optional>
#include <set>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include "engine/base/text/hex.h"
#include "tests/collab/transfer/transfer_bench.h"

namespace tandem {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using testing::NoiseBytes;

constexpr std::uint64_t kPlenty = 1U << 30U;
const Sha256 kContent = Sha256Of(std::string("a scene"));

std::string TextOf(const fs::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

/// A store below `cache` of a folder, and all that is in that folder.
class Store : public ::testing::Test {
 protected:
  ScratchFolder folder_;
  const SceneStore store_{folder_.path() / "cache" / "fetched"};
  const std::string mesh_ = NoiseBytes(100'000, 1);

  /// Returns the list of these files; the first is the scene file.
  static SceneList ListOf(const std::vector<std::string>& files) {
    SceneList list;
    for (const std::string& text : files) {
      ListedFile file{list.files.empty() ? ".json" : ".stl", text.size(), Sha256Of(text), {}};
      for (std::size_t at = 0; at < text.size(); at += kPieceBytes) {
        file.pieces.push_back(Sha256Of(std::string_view(text).substr(at, kPieceBytes)));
      }
      list.files.push_back(std::move(file));
    }
    return list;
  }
  Result<UnfinishedScene> Open(const SceneList& list, std::uint64_t most_bytes = kPlenty) {
    return UnfinishedScene::Open(store_, list, Sha256Of(Encode(list)),
                                 {.most_bytes = most_bytes, .spare_bytes = 0}, busy_);
  }
  static void Fill(UnfinishedScene& scene, const std::vector<std::string>& files) {
    for (std::size_t f = 0; f < files.size(); ++f) {
      for (std::size_t at = 0; at < files[f].size(); at += kPieceBytes) {
        const std::string_view piece = std::string_view(files[f]).substr(at, kPieceBytes);
        EXPECT_TRUE(scene.Write({f, 0, at, piece.size()}, piece));
      }
    }
  }
  /// Lets a scene file arrive that a stranger sent. Returns why it is refused, or its path here.
  std::string Arrives(const std::string& scene_file) {
    const std::vector<std::string> files{scene_file, mesh_};
    Result<UnfinishedScene> scene = Open(ListOf(files));
    if (!scene) return scene.error().what;
    Fill(*scene, files);
    const Result<fs::path> written = scene->WriteScene();
    const std::string answer = written ? written->string() : written.error().what;
    if (!written) scene->Remove();
    return answer;
  }
  /// Makes the folders as a first fetch leaves them.
  void MakeFolders() const {
    fs::create_directories(store_.group());
    fs::permissions(store_.folder(), fs::perms::owner_all);
    fs::permissions(store_.group(), fs::perms::owner_all);
  }
  std::set<std::string> All() const {
    std::set<std::string> all;
    for (const auto& entry : fs::recursive_directory_iterator(folder_.path())) {
      all.insert(entry.path().lexically_relative(folder_.path()).string());
    }
    return all;
  }
  /// Returns whether there is no file or folder of a scene.
  bool IsEmpty() const { return !fs::exists(store_.group()) || fs::is_empty(store_.group()); }
  static std::string SceneWith(const std::string& mesh) {
    return R"({"name": "s", "voxel_m": 0.001, "bodies": [{"name": "b", "mass_kg": 1, "mesh": )" +
           mesh + "}]}";
  }

  bool busy_ = false;
};

TEST_F(Store, StoresAScenesFilesUnderItsOwnNames) {
  const std::vector<std::string> files{SceneWith(R"("file:1")"), mesh_};
  Result<UnfinishedScene> scene = Open(ListOf(files));
  ASSERT_TRUE(scene) << scene.error().what;
  Fill(*scene, files);
  ASSERT_TRUE(scene->WriteScene());
  const Result<fs::path> placed = scene->Commit(kContent);
  ASSERT_TRUE(placed) << placed.error().what;
  EXPECT_EQ(*placed, store_.SceneFileOf(kContent));
  const Result<Scene> loaded = LoadScene(*placed);
  ASSERT_TRUE(loaded) << loaded.error().what;
  EXPECT_EQ(loaded->bodies[0].mesh.filename(), HexOfBytes(Sha256Of(mesh_)) + ".stl");
  EXPECT_EQ(TextOf(loaded->bodies[0].mesh), mesh_);
  const std::string place = "cache/fetched/plain/" + HexOfBytes(kContent);
  EXPECT_THAT(
      All(), ::testing::UnorderedElementsAre("cache", "cache/fetched", "cache/fetched/plain", place,
                                             place + "/scene.json",
                                             place + "/" + HexOfBytes(Sha256Of(mesh_)) + ".stl"));
  struct stat facts {};
  ASSERT_EQ(stat(loaded->bodies[0].mesh.c_str(), &facts), 0);
  EXPECT_EQ(facts.st_mode & 0777U, 0600U);
  ASSERT_EQ(stat(store_.folder().c_str(), &facts), 0);
  EXPECT_EQ(facts.st_mode & 0777U, 0700U);
  ASSERT_EQ(store_.Scenes().size(), 1U);
  EXPECT_TRUE(store_.Scenes()[0].whole);
  EXPECT_EQ(store_.Clear(), 1U);
  EXPECT_THAT(All(), ::testing::UnorderedElementsAre("cache", "cache/fetched"));
}

TEST_F(Store, ReceivedNamesNeverBecomePaths) {
  const fs::path secret = folder_.Write("secret.stl", "solid secret");
  MakeFolders();
  const std::set<std::string> before = All();
  for (const std::string& mesh : std::vector<std::string>{"\"" + secret.string() + "\"",
                                                          R"("../../secret.stl")",
                                                          R"("../secret.stl")",
                                                          R"("secret.stl")",
                                                          R"("/etc/passwd")",
                                                          R"("file:0")",
                                                          R"("file:2")",
                                                          R"("file:01")",
                                                          R"("file:1 ")",
                                                          R"("file:1/../../x")",
                                                          R"("file:-1")",
                                                          R"("file:99999999999999999999")",
                                                          R"("FILE:1")",
                                                          "\"file:1\\n\"",
                                                          "\"file:1\\u0000\"",
                                                          R"("scene.json")",
                                                          R"("sent")",
                                                          R"("")",
                                                          "1",
                                                          "null",
                                                          R"(["file:1"])",
                                                          R"({"a": "file:1"})"}) {
    EXPECT_THAT(Arrives(SceneWith(mesh)), HasSubstr("refused: a mesh that is none of its files"))
        << mesh;
    EXPECT_EQ(All(), before) << mesh;
  }
}

TEST_F(Store, InvalidSceneFileIsRefusedAndLeavesNothing) {
  MakeFolders();
  const std::set<std::string> before = All();
  std::string deep;
  for (int i = 0; i < 100'000; ++i) deep += "[";
  std::string many = R"({"bodies": [)";
  for (int i = 0; i < 1'500'000; ++i) many += "0,";
  for (const std::string& text :
       {std::string("{"), std::string("[]"), std::string("\"file:1\""), deep, many + "0]}",
        std::string(R"({"bodies": {}})"), std::string(R"({"bodies": [1]})"),
        std::string(R"({"bodies": [{}]})"), SceneWith("\"file:1\", \"mesh\": \"/etc/passwd\""),
        R"({"bodies": [{"mesh": "file:1"}], "hands": [{"body": "b", "file": "/etc/passwd"}]})" +
            std::string()}) {
    const std::string stated = Arrives(text);
    EXPECT_THAT(stated, HasSubstr("the scene file that was sent")) << text.substr(0, 60);
    EXPECT_EQ(std::count(stated.begin(), stated.end(), '\n'), 0);
    EXPECT_EQ(All(), before) << text.substr(0, 60);
  }
}

TEST_F(Store, MismatchedFileIsRefused) {
  const std::vector<std::string> files{SceneWith(R"("file:1")"), mesh_};
  SceneList list = ListOf(files);
  // each piece may be as its digest says, and the file be another
  list.files[1].digest[0] ^= 1;
  Result<UnfinishedScene> scene = Open(list);
  ASSERT_TRUE(scene);
  Fill(*scene, files);
  const Result<fs::path> written = scene->WriteScene();
  ASSERT_FALSE(written);
  EXPECT_THAT(written.error().what, HasSubstr("is not the one that was listed"));
}

TEST_F(Store, FollowsNoSymbolicLink) {
  const std::vector<std::string> files{SceneWith(R"("file:1")"), mesh_};
  const SceneList list = ListOf(files);
  const fs::path outside = folder_.path() / "outside";
  fs::create_directories(outside);
  MakeFolders();
  const fs::path unfinished = store_.group() / ("unfinished-" + HexOfBytes(Sha256Of(Encode(list))));
  // the folder is a link
  fs::create_directory_symlink(outside, unfinished);
  EXPECT_FALSE(Open(list));
  fs::remove(unfinished);
  // a file of it is one
  fs::create_directory(unfinished);
  fs::permissions(unfinished, fs::perms::owner_all);
  const fs::path target = folder_.Write("target", "untouched");
  const fs::path file = unfinished / (HexOfBytes(Sha256Of(mesh_)) + ".stl");
  fs::create_symlink(target, file);
  EXPECT_FALSE(Open(list));
  EXPECT_EQ(TextOf(target), "untouched");
  // or another name of a file elsewhere
  fs::create_directory(unfinished);
  fs::permissions(unfinished, fs::perms::owner_all);
  fs::create_hard_link(target, file);
  EXPECT_FALSE(Open(list));
  EXPECT_EQ(TextOf(target), "untouched");
  // or a pipe
  fs::create_directory(unfinished);
  fs::permissions(unfinished, fs::perms::owner_all);
  ASSERT_EQ(mkfifo(file.c_str(), 0600), 0);
  EXPECT_FALSE(Open(list));
  EXPECT_TRUE(fs::is_empty(outside));
  EXPECT_TRUE(IsEmpty());
  // the folder of all scenes is one
  fs::remove_all(store_.folder());
  fs::create_directory_symlink(outside, store_.folder());
  EXPECT_FALSE(Open(list));
  EXPECT_TRUE(fs::is_empty(outside));
}

TEST_F(Store, RefusesFoldersWritableByOthers) {
  fs::create_directories(store_.folder());
  fs::permissions(store_.folder(), fs::perms::all);
  const auto refused = Open(ListOf({SceneWith(R"("file:1")"), mesh_}));
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().what, HasSubstr("a folder of yours that others cannot write to"));
  EXPECT_TRUE(IsEmpty());
}

TEST_F(Store, PartialFetchSurvivesAndHasOneWriter) {
  const std::vector<std::string> files{SceneWith(R"("file:1")"), mesh_};
  const SceneList list = ListOf(files);
  std::vector<char> piece(kPieceBytes);
  {
    Result<UnfinishedScene> scene = Open(list);
    ASSERT_TRUE(scene);
    EXPECT_FALSE(scene->Read({1, 0, 0, piece.size()}, piece));
    Fill(*scene, files);
    EXPECT_FALSE(Open(list));
    EXPECT_TRUE(busy_);
    // a scene that is being written stays
    EXPECT_EQ(store_.Clear(), 0U);
  }
  Result<UnfinishedScene> scene = Open(list);
  ASSERT_TRUE(scene);
  EXPECT_FALSE(busy_);
  EXPECT_TRUE(scene->Read({1, 1, kPieceBytes, piece.size()}, piece));
  EXPECT_EQ(std::string(piece.begin(), piece.end()), mesh_.substr(kPieceBytes, kPieceBytes));
  scene->Remove();
  EXPECT_TRUE(IsEmpty());
}

TEST_F(Store, RefusesScenesLargerThanTheDisk) {
  const SceneList list = ListOf({SceneWith(R"("file:1")"), mesh_});
  const Result<UnfinishedScene> scene =
      UnfinishedScene::Open(store_, list, Sha256Of(Encode(list)),
                            {.most_bytes = kPlenty, .spare_bytes = UINT64_MAX / 2}, busy_);
  ASSERT_FALSE(scene);
  EXPECT_THAT(scene.error().what, HasSubstr("its disk has no room for 1 MB"));
  EXPECT_TRUE(IsEmpty());
}

TEST_F(Store, LeastRecentlyUsedScenesAreEvicted) {
  const auto content_of = [](std::uint32_t number) {
    return Sha256Of(std::to_string(number));
  };
  for (const std::uint32_t number : {1U, 2U, 3U}) {
    const Sha256 content = content_of(number);
    const std::vector<std::string> files{SceneWith(R"("file:1")"), NoiseBytes(100'000, number)};
    Result<UnfinishedScene> scene = Open(ListOf(files), 250'000);
    ASSERT_TRUE(scene) << scene.error().what;
    Fill(*scene, files);
    ASSERT_TRUE(scene->WriteScene());
    ASSERT_TRUE(scene->Commit(content));
    fs::last_write_time(store_.SceneFileOf(content).parent_path(),
                        fs::file_time_type::clock::now() - std::chrono::hours(number == 1 ? 1 : 2));
  }
  // the second was used before the first
  EXPECT_TRUE(fs::exists(store_.SceneFileOf(content_of(1))));
  EXPECT_FALSE(fs::exists(store_.SceneFileOf(content_of(2))));
  EXPECT_TRUE(fs::exists(store_.SceneFileOf(content_of(3))));
  const auto refused = Open(ListOf({SceneWith(R"("file:1")"), mesh_}), 50'000);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().what, HasSubstr("TANDEM_CACHE_LIMIT allows more"));
}

// Two peers have the same files under other names. One of them has a fetched scene.
TEST_F(Store, FetchedSceneReproducesItsList) {
  const fs::path scene = testing::WriteScene(folder_, "scene", {mesh_, NoiseBytes(500, 2), mesh_});
  const Sha256 content = testing::HashesOf(scene).digest;
  const std::atomic<bool> stop{false};
  Result<SceneFiles> files = SceneFiles::Open(scene, content, stop);
  ASSERT_TRUE(files) << files.error().what;
  // two bodies have one mesh, by two files of equal bytes
  EXPECT_EQ(files->list().files.size(), 3U);
  {
    Result<UnfinishedScene> arriving = Open(files->list());
    ASSERT_TRUE(arriving);
    std::vector<char> piece;
    for (std::uint32_t i = 0; i < files->list().pieces(); ++i) {
      ASSERT_TRUE(files->Read(i, piece));
      ASSERT_TRUE(arriving->Write(PlaceOf(files->list(), i), piece));
    }
    ASSERT_TRUE(arriving->WriteScene());
    ASSERT_TRUE(arriving->Commit(content));
  }
  EXPECT_EQ(testing::HashesOf(store_.SceneFileOf(content)).digest, content);
  const Result<SceneFiles> again = SceneFiles::Open(store_.SceneFileOf(content), content, stop);
  ASSERT_TRUE(again) << again.error().what;
  EXPECT_EQ(Encode(again->list()), Encode(files->list()));
}

TEST_F(Store, MeshesThatNameOtherFilesAreNotShared) {
  const fs::path scene = testing::WriteScene(folder_, "scene", {mesh_});
  std::string text = TextOf(scene);
  text.replace(text.find("mesh 0.stl"), 10, "mesh 0.xyz");
  folder_.Write("scene/mesh 0.xyz", "x");
  folder_.Write("scene/scene.json", text);
  const std::atomic<bool> stop{false};
  EXPECT_THAT(SceneFiles::Open(scene, testing::HashesOf(scene).digest, stop).error().what,
              HasSubstr("files of this kind are not handed to joiners"));
  text.replace(text.find("mesh 0.xyz"), 10, "model.gltf");
  folder_.Write("scene/scene.json", text);
  folder_.Write(
      "scene/model.gltf",
      R"({"asset": {"version": "2.0"}, "buffers": [{"uri": "numbers.bin", "byteLength": 4}]})");
  folder_.Write("scene/numbers.bin", "1234");
  EXPECT_THAT(SceneFiles::Open(scene, testing::HashesOf(scene).digest, stop).error().what,
              HasSubstr("save it as .glb"));
}

// A stranger's scene of a plain session must not serve a session with keys, nor one session's scene
// another with other authorities.
TEST_F(Store, ScenesOfOtherSendersServeNoSession) {
  const SceneStore anna(store_.folder(), Sha256Of(std::string("anna's authorities")));
  const SceneStore ben(store_.folder(), Sha256Of(std::string("ben's authorities")));
  const std::vector<std::string> files{SceneWith(R"("file:1")"), mesh_};
  const auto fetch = [&](const SceneStore& store) {
    Result<UnfinishedScene> scene =
        UnfinishedScene::Open(store, ListOf(files), Sha256Of(Encode(ListOf(files))),
                              {.most_bytes = kPlenty, .spare_bytes = 0}, busy_);
    ASSERT_TRUE(scene) << scene.error().what;
    Fill(*scene, files);
    ASSERT_TRUE(scene->WriteScene());
    ASSERT_TRUE(scene->Commit(kContent));
  };
  fetch(store_);
  EXPECT_TRUE(fs::exists(store_.SceneFileOf(kContent)));
  EXPECT_FALSE(fs::exists(anna.SceneFileOf(kContent)));
  fetch(anna);
  EXPECT_TRUE(fs::exists(anna.SceneFileOf(kContent)));
  EXPECT_FALSE(fs::exists(ben.SceneFileOf(kContent)));
  // limit and removal count all senders' scenes
  for (const SceneStore* store : {&store_, &anna, &ben}) EXPECT_EQ(store->Scenes().size(), 2U);
  EXPECT_EQ(ben.Clear(), 2U);
  EXPECT_TRUE(fs::is_empty(store_.folder()));
}

// Version 0.1 named a scene's folder by 16 digits, which anybody could forge.
TEST_F(Store, ScenesOfEarlierVersionsServeNothingAndCanBeRemoved) {
  MakeFolders();
  const fs::path earlier = store_.folder() / "d9ebb59e750f6359";
  fs::create_directory(earlier);
  fs::permissions(earlier, fs::perms::owner_all);
  std::ofstream(earlier / "scene.json") << "{}";
  ASSERT_EQ(store_.Scenes().size(), 1U);
  EXPECT_EQ(store_.Clear(), 1U);
  EXPECT_FALSE(fs::exists(earlier));
}

}  // namespace
}  // namespace tandem
