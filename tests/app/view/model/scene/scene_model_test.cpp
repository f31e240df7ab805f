#include "app/view/model/scene/scene_model.h"

#include <QDir>
#include <QTemporaryFile>
#include <atomic>
#include <future>

#include <gtest/gtest.h>

#include "tests/app/view/fake_session.h"
#include "tests/app/view/shapes.h"

namespace tandem {
namespace {

/// Answers every file with the block and the ball.
Result<DrawnScene> LoadBlockAndBall(const std::filesystem::path& file, const LoadProgress&) {
  DrawnScene scene = BlockAndBall();
  scene.file = file;
  return scene;
}

SceneManifest ManifestOf(const std::string& file, const Sha256& digest) {
  SceneManifest manifest;
  manifest.content_digest = digest;
  manifest.name = "session's scene";
  manifest.file = file;
  manifest.voxel_size = 0.003;
  return manifest;
}

class SceneOfASession : public ::testing::Test {
 protected:
  void SetUp() override { ASSERT_TRUE(here_.open()); }
  bool Settled(const SceneModel& model) {
    return ProcessEventsUntil([&] {
      return model.state() != SceneModel::State::kLoading;
    });
  }
  QTemporaryFile here_{QDir::tempPath() + "/XXXXXX.json"};  // a file that exists
  const Sha256 digest_ = BlockAndBall().digest;
  const Sha256 other_{8};
};

TEST_F(SceneOfASession, IsLoadedFromTheSessionsPathWithConsent) {
  int loads = 0;
  SceneModel model([&loads](const std::filesystem::path& file, const LoadProgress& progress) {
    ++loads;
    return LoadBlockAndBall(file, progress);
  });
  EXPECT_EQ(model.state(), SceneModel::State::kWaiting);
  EXPECT_FALSE(model.message().isEmpty());
  model.SetSessionScene(ManifestOf(here_.fileName().toStdString(), digest_));
  ASSERT_TRUE(Settled(model));
  // any stranger may name any path: the user is asked
  EXPECT_EQ(model.state(), SceneModel::State::kMissing);
  EXPECT_EQ(loads, 0);
  EXPECT_EQ(model.offered(), here_.fileName().toStdString());
  EXPECT_TRUE(model.message().contains("Load it only if you know what it is"));
  model.OpenOffered();
  ASSERT_TRUE(Settled(model));
  ASSERT_EQ(model.state(), SceneModel::State::kReady);
  EXPECT_EQ(model.scene()->bodies.size(), 2U);
  EXPECT_EQ(model.scene()->voxel_size, 0.003);  // the session's
  EXPECT_TRUE(model.warning().isEmpty());
}

// A session may name any path of this machine.
TEST_F(SceneOfASession, IsReadFromSceneFilesOnly) {
  QTemporaryFile log(QDir::tempPath() + "/XXXXXX.log");
  ASSERT_TRUE(log.open());
  bool loaded = false;
  SceneModel model([&loaded](const std::filesystem::path& file, const LoadProgress& progress) {
    loaded = true;
    return LoadBlockAndBall(file, progress);
  });
  model.SetSessionScene(ManifestOf(log.fileName().toStdString(), digest_));
  ASSERT_TRUE(Settled(model));
  EXPECT_EQ(model.state(), SceneModel::State::kMissing);
  EXPECT_FALSE(loaded);
}

TEST_F(SceneOfASession, LocalFileWithOtherContentIsNotShown) {
  SceneModel model(LoadBlockAndBall);
  model.SetSessionScene(ManifestOf(here_.fileName().toStdString(), other_));
  ASSERT_TRUE(Settled(model));
  model.OpenOffered();
  ASSERT_TRUE(Settled(model));
  EXPECT_EQ(model.state(), SceneModel::State::kMissing);
  EXPECT_EQ(model.scene(), nullptr);
  EXPECT_TRUE(model.message().contains(here_.fileName()));
  EXPECT_TRUE(model.message().contains("differs from the session's scene"));
}

TEST_F(SceneOfASession, IsFetchedWithTheUsersConsent) {
  SceneModel model(LoadBlockAndBall);
  std::atomic<int> fetched{0};
  std::atomic<bool> fails{true};
  model.SetFetch(
      [&](const SceneManifest&, const LoadProgress& progress) -> Result<std::filesystem::path> {
        ++fetched;
        progress(1, 2, "fetching 3 files");
        if (fails) return Error{"nobody here hands out the scene's files"};
        return std::filesystem::path("/cache/fetched/scene.json");
      });
  EXPECT_FALSE(model.can_fetch());
  model.SetSessionScene(ManifestOf("/nowhere/bracket.json", digest_));
  ASSERT_TRUE(Settled(model));
  EXPECT_TRUE(model.message().contains("A peer can send its files"));
  ASSERT_TRUE(model.can_fetch());
  EXPECT_EQ(fetched, 0);
  model.Fetch();
  ASSERT_TRUE(Settled(model));
  EXPECT_TRUE(model.message().contains("nobody here hands out the scene's files"));
  // and once more
  ASSERT_TRUE(model.can_fetch());
  fails = false;
  model.Fetch();
  ASSERT_TRUE(Settled(model));
  ASSERT_EQ(model.state(), SceneModel::State::kReady);
  EXPECT_EQ(model.scene()->file, "/cache/fetched/scene.json");
  EXPECT_FALSE(model.can_fetch());
  EXPECT_EQ(fetched, 2);
}

TEST_F(SceneOfASession, MissingSceneIsReportedByName) {
  SceneModel model(LoadBlockAndBall);
  model.SetSessionScene(ManifestOf("/nowhere/bracket.json", digest_));
  ASSERT_TRUE(Settled(model));
  EXPECT_EQ(model.state(), SceneModel::State::kMissing);
  EXPECT_TRUE(model.message().contains("/nowhere/bracket.json"));
  EXPECT_TRUE(model.message().contains("open it (Ctrl+O)"));
  EXPECT_FALSE(model.message().contains("--"));
}

TEST_F(SceneOfASession, IsFoundOnThisMachine) {
  std::vector<Sha256> wanted;
  SceneModel model(LoadBlockAndBall, [&](const SceneManifest& manifest) {
    wanted.push_back(manifest.content_digest);
    return SceneSearchResult{"/own/bracket.json", {"/own"}};
  });
  model.SetSessionScene(ManifestOf("/nowhere/bracket.json", digest_));
  ASSERT_TRUE(Settled(model));
  ASSERT_EQ(model.state(), SceneModel::State::kReady) << model.message().toStdString();
  EXPECT_EQ(model.scene()->file, "/own/bracket.json");
  EXPECT_EQ(wanted, std::vector<Sha256>{digest_});
  EXPECT_TRUE(model.warning().isEmpty());
}

TEST_F(SceneOfASession, IsSearchedAgainAndTheFoldersAreListed) {
  SceneSearchResult result{std::nullopt, {"/own/scenes", "/work"}};
  SceneModel model(LoadBlockAndBall, [&](const SceneManifest&) {
    return result;
  });
  const SceneManifest manifest = ManifestOf("/nowhere/bracket.json", digest_);
  model.SetSessionScene(manifest);
  ASSERT_TRUE(Settled(model));
  ASSERT_EQ(model.state(), SceneModel::State::kMissing);
  EXPECT_TRUE(model.message().contains("/own/scenes, /work")) << model.message().toStdString();
  EXPECT_TRUE(model.message().contains("Ctrl+O"));
  result.file = "/home/anna/bracket.json";  // somebody has brought it
  model.SetSessionScene(manifest);
  EXPECT_EQ(model.state(), SceneModel::State::kMissing);
  model.LookAgain();
  model.SetSessionScene(manifest);
  ASSERT_TRUE(Settled(model));
  EXPECT_EQ(model.state(), SceneModel::State::kReady);
}

// A scene of one body, where the session's has another.
TEST_F(SceneOfASession, IsComparedWithTheUsersSceneBodyByBody) {
  SceneModel model(
      [](const std::filesystem::path& file, const LoadProgress&) -> Result<DrawnScene> {
        DrawnScene scene = BlockAndBall();
        scene.file = file;
        scene.source.bodies.resize(2);
        scene.source.bodies[0].name = "frame";
        scene.source.bodies[1].name = "ball";
        scene.hashes.bodies.resize(2);
        return scene;
      });
  model.OpenNamed("mine.json");
  SceneManifest manifest = ManifestOf("", other_);
  manifest.name = "peg";
  manifest.bodies = {{"ball", 0, 0}};
  model.SetSessionScene(manifest);
  ASSERT_TRUE(Settled(model));
  EXPECT_TRUE(
      model.warning().contains("mine.json: body \"frame\" is not in the session's scene \"peg\""))
      << model.warning().toStdString();
}

TEST_F(SceneOfASession, UsersSceneTakesPrecedenceWithAWarning) {
  SceneModel model(LoadBlockAndBall);
  model.OpenNamed("mine.json");
  model.SetSessionScene(ManifestOf(here_.fileName().toStdString(), other_));
  ASSERT_TRUE(Settled(model));
  ASSERT_EQ(model.state(), SceneModel::State::kReady);
  EXPECT_EQ(model.scene()->file, "mine.json");
  EXPECT_TRUE(model.warning().contains("session's scene"));
  model.SetSessionScene(ManifestOf(here_.fileName().toStdString(), digest_));
  EXPECT_TRUE(model.warning().isEmpty());
}

TEST_F(SceneOfASession, ReportsWhyLoadingFailed) {
  SceneModel model([](const std::filesystem::path&, const LoadProgress&) -> Result<DrawnScene> {
    return Error{"bodies[1].mesh: no file bracket.stl"};
  });
  model.OpenNamed("broken.json");
  ASSERT_TRUE(Settled(model));
  EXPECT_EQ(model.state(), SceneModel::State::kMissing);
  EXPECT_TRUE(model.message().contains("bodies[1].mesh: no file bracket.stl"));
}

TEST(SceneModel, LoadsInAnotherThreadWithProgress) {
  std::promise<void> disk;
  SceneModel model([&](const std::filesystem::path& file, const LoadProgress& progress) {
    progress(1, 4, "part.stl");
    disk.get_future().wait();
    return LoadBlockAndBall(file, progress);
  });
  model.OpenNamed("slow.json");
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return model.percent() == 25;
  }));
  EXPECT_EQ(model.state(), SceneModel::State::kLoading);
  EXPECT_EQ(model.message(), "part.stl");
  disk.set_value();
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return model.state() == SceneModel::State::kReady;
  }));
}

TEST(SceneModel, DestructionCancelsLoading) {
  bool given_up = false;
  {
    SceneModel model(
        [&](const std::filesystem::path&, const LoadProgress& progress) -> Result<DrawnScene> {
          while (progress(0, 1, "part.stl")) std::this_thread::yield();
          given_up = true;
          return Error{"given up"};
        });
    model.OpenNamed("endless.json");
  }
  EXPECT_TRUE(given_up);
}

// A disk that does not answer holds the window up no longer than a second.
TEST(SceneModel, EndsOnAnEndlessFile) {
  const auto disk = std::make_shared<std::promise<void>>();
  const auto begun = std::make_shared<std::atomic<bool>>(false);
  const auto ended = std::make_shared<std::atomic<bool>>(false);
  const auto before = std::chrono::steady_clock::now();
  {
    SceneModel model(
        [=](const std::filesystem::path&, const LoadProgress& progress) -> Result<DrawnScene> {
          *begun = true;
          disk->get_future().wait();
          static_cast<void>(progress(1, 2, "part.stl"));
          *ended = true;
          return Error{"too late"};
        });
    model.OpenNamed("stuck.json");
    ASSERT_TRUE(ProcessEventsUntil([&] {
      return begun->load();
    }));
  }
  EXPECT_LT(std::chrono::steady_clock::now() - before, std::chrono::seconds(5));
  EXPECT_FALSE(*ended);
  disk->set_value();  // a file that comes then harms nobody
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return ended->load();
  }));
}

}  // namespace
}  // namespace tandem
