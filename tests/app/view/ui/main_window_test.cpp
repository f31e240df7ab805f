#include "app/view/ui/main_window.h"

#include <QDir>
#include <QTemporaryFile>
#include <QTest>
#include <cmath>
#include <filesystem>

#include <gtest/gtest.h>

#include "tests/app/view/ui/window_fixture.h"
#include "tests/support/scratch_folder.h"

namespace tandem {
namespace {

TEST_F(Window, ButtonsJoinAndLeave) {
  EXPECT_TRUE(Child<QPushButton>("join")->isEnabled());
  EXPECT_FALSE(Child<QPushButton>("leave")->isEnabled());
  JoinSession();
  EXPECT_FALSE(Child<QPushButton>("join")->isEnabled());
  EXPECT_TRUE(Child<QPushButton>("leave")->isEnabled());
  EXPECT_FALSE(Child<QLineEdit>("session")->isEnabled());
  EXPECT_EQ(fake_.request.session, "bracket");
  EXPECT_EQ(fake_.request.name, "Dora");
  EXPECT_TRUE(Child<QLabel>("status_session")->text().contains("bracket"));
  Click("leave");
  EXPECT_EQ(session_.state(), SessionModel::State::kLeft);
  EXPECT_EQ(fake_.left, 1);
  EXPECT_TRUE(Child<QPushButton>("join")->isEnabled());
  EXPECT_FALSE(Child<QPushButton>("leave")->isEnabled());
  JoinSession();
}

TEST_F(Window, LabelsASessionPlainOnlyAfterHearingAPeer) {
  JoinSession();
  const auto* dock = Child<QLabel>("session_state");
  EXPECT_TRUE(dock->text().contains("Looking for \u201cbracket\u201d"));
  EXPECT_FALSE(dock->text().contains("Joined"));
  EXPECT_FALSE(dock->text().contains("plain"));
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return window_.page() != nullptr &&
           window_.page()->text().contains("is its name, network, domain or keys another one?");
  }));
  EXPECT_TRUE(window_.page()->text().contains("\nNo peer answers in session"));
  EXPECT_TRUE(Child<QLabel>("status_session")->text().startsWith("No peer answers"));
  fake_.inbox->OnPeerInfo(FakeSession::Info(5, "Anna", Role::kActive), 0);
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return dock->text().contains("plain: anyone on the network can look on");
  }));
  EXPECT_TRUE(Child<QLabel>("status_session")->text().startsWith("Joined"));
  EXPECT_TRUE(window_.page()->text().contains("has offered a scene yet"));
}

/// Hears the same sessions all the time.
class Nearby : public SessionsNearby {
 public:
  explicit Nearby(std::vector<AnnouncedSession> heard) : heard_(std::move(heard)) {}
  std::vector<AnnouncedSession> Heard() override { return heard_; }

 private:
  std::vector<AnnouncedSession> heard_;
};

TEST(WindowInAnEmptySession, OffersTheSessionsThatAreAnnounced) {
  FakeSession fake;
  SessionModel session(fake.Join(), [](const JoinRequest&) {
    return std::make_unique<Nearby>(std::vector<AnnouncedSession>{
        {"braket", false}, {"gear", true}, {std::string("braket") + "/view", false}});
  });
  SceneModel scene(LoadBlockAndBall);
  MainWindow window(session, scene, Error{"no driver"});
  window.session_dock().SetRequest({"brakett", "Dora", 42, ""});
  window.show();
  QTest::mouseClick(window.findChild<QPushButton*>("join"), Qt::LeftButton);
  auto* notices = window.findChild<NoticeBar*>();
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return !notices->Text("others").isEmpty();
  }));
  EXPECT_EQ(notices->Text("others"),
            "No session \u201cbrakett\u201d answers here. Announced: \u201cbraket\u201d.");
  EXPECT_EQ(window.windowTitle(), "Tandem");
  EXPECT_EQ(window.findChild<QPushButton*>("notice_others_1"), nullptr);
  QTest::mouseClick(window.findChild<QPushButton*>("notice_others_0"), Qt::LeftButton);
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return session.state() == SessionModel::State::kJoined && fake.request.session == "braket";
  }));
}

TEST_F(Window, FetchesAMissingSceneWhenItsButtonIsPressed) {
  std::atomic<int> fetched{0};
  scene_.SetFetch([&](const SceneManifest&, const LoadProgress&) {
    ++fetched;
    return Result<std::filesystem::path>(std::filesystem::path("block_and_ball.json"));
  });
  JoinSession();
  SceneManifest manifest;
  manifest.offered_by = 5;
  manifest.content_digest = BlockAndBall().digest;
  manifest.name = "block and ball";
  manifest.file = "/nowhere/block_and_ball.json";
  manifest.voxel_size = 0.003;
  EXPECT_FALSE(Child<QPushButton>("fetch_scene_button")->isVisible());
  fake_.inbox->OnPeerInfo(FakeSession::Info(5, "Anna", Role::kActive), 0);
  fake_.inbox->OnScene(manifest);
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return Child<QPushButton>("fetch_scene_button")->isVisible();
  }));
  EXPECT_EQ(fetched, 0);
  Click("fetch_scene_button");
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return scene_.state() == SceneModel::State::kReady;
  }));
  EXPECT_EQ(fetched, 1);
}

TEST_F(Window, ShowsItsOwnLeave) {
  JoinSession();
  fake_.inbox->OnPeerInfo(FakeSession::Info(5, "Anna", Role::kActive), 0);
  const auto* peers = Child<QTableView>("peers");
  const auto* samples = Child<QLabel>("status_samples");
  ASSERT_TRUE(ProcessEventsUntil([&] {
    fake_.inbox->OnView(FakeSession::Frame(5, kBall, Vec3::Zero(), 0), 0);
    return peers->model()->rowCount() == 1 && !samples->text().startsWith("0 ");
  }));
  Click("leave");
  EXPECT_EQ(samples->text(), "0 samples/s");
  EXPECT_TRUE(Child<QLabel>("session_state")->text().startsWith("You left"));
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return peers->model()->index(0, PeerTableModel::kPresence).data().toString() == "you left";
  }));
  EXPECT_EQ(samples->text(), "0 samples/s");
}

/// Returns how a text stands out from its ground, 1 to 21 (WCAG 2.1). From 4.5 on it is legible.
double Contrast(const QColor& a, const QColor& b) {
  const auto luminance = [](const QColor& colour) {
    const auto linear = [](double x) {
      return x <= 0.03928 ? x / 12.92 : std::pow((x + 0.055) / 1.055, 2.4);
    };
    return 0.2126 * linear(static_cast<double>(colour.redF())) +
           0.7152 * linear(static_cast<double>(colour.greenF())) +
           0.0722 * linear(static_cast<double>(colour.blueF()));
  };
  const double x = luminance(a);
  const double y = luminance(b);
  return (std::max(x, y) + 0.05) / (std::min(x, y) + 0.05);
}

TEST_F(Window, SessionAndNameStayLegibleWhileJoined) {
  JoinSession();
  for (const QLineEdit* field : window_.session_dock().findChildren<QLineEdit*>()) {
    const QPalette& palette = field->palette();
    EXPECT_GT(Contrast(palette.color(QPalette::Disabled, QPalette::Text),
                       palette.color(QPalette::Disabled, QPalette::Base)),
              4.5)
        << field->text().toStdString();
  }
}

TEST_F(Window, WarnsOfAnotherProtocolAcrossThePicture) {
  OpenScene();
  JoinSession();
  PeerInfo info = FakeSession::Info(5, "Anna", Role::kActive);
  info.protocol = kProtocol + 1;
  fake_.inbox->OnPeerInfo(info, 0);
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return view().warning().contains("Anna uses protocol");
  }));
  EXPECT_TRUE(view().warning().contains("update both to one version"));
  fake_.inbox->OnPeerLeft(5);
  EXPECT_TRUE(ProcessEventsUntil([&] {
    return view().warning().isEmpty();
  }));
}

TEST_F(Window, OpensAChosenScene) {
  const ScratchFolder folder;
  const std::filesystem::path file = folder.Write("own.json", "{}");
  window_.SetSceneFolders({folder.path()});
  QString chosen;
  QObject::connect(&window_, &MainWindow::SceneChosen, [&](const QString& one) {
    chosen = one;
  });
  ASSERT_TRUE(Child<QPushButton>("open_scene_button")->isVisible());
  Click("open_scene_button");
  auto* ask = Child<QFileDialog>("ask_for_scene");
  ASSERT_TRUE(QTest::qWaitForWindowExposed(ask));
  EXPECT_EQ(ask->directory().absolutePath().toStdString(), folder.path().string());
  ask->findChild<QLineEdit*>("fileNameEdit")->setText(QString::fromStdString(file.string()));
  QMetaObject::invokeMethod(ask, "accept");
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return scene_.state() == SceneModel::State::kReady;
  }));
  EXPECT_EQ(chosen.toStdString(), file.string());
  EXPECT_EQ(scene_.scene()->file, file);
  // also when there is a scene already
  Child<QAction>("open_scene")->trigger();
  EXPECT_TRUE(ask->isVisible());
  ask->close();
}

TEST_F(Window, ShowsTheFilesTriangleCount) {
  OpenScene();
  const auto* size = Child<QLabel>("scene_size");
  const std::size_t read = 12 + 2 * 32 * 15;  // lines of the box and the ball
  EXPECT_EQ(size->text(), QStringLiteral("2 bodies, %1 triangles").arg(read));
}

TEST_F(Window, ReportsWhyItCouldNotJoin) {
  fake_.refuse = "no interface called eth7";
  Click("join");
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return session_.state() == SessionModel::State::kFailed;
  }));
  EXPECT_TRUE(Child<QLabel>("session_state")->text().contains("no interface called eth7"));
  EXPECT_TRUE(Child<QPushButton>("join")->isEnabled());
}

TEST_F(Window, JoiningNeedsASessionName) {
  Child<QLineEdit>("session")->clear();
  EXPECT_FALSE(Child<QPushButton>("join")->isEnabled());
}

TEST_F(Window, ListsPeersWithTheirDelay) {
  JoinSession();
  fake_.inbox->OnPeerInfo(FakeSession::Info(5, "Anna", Role::kActive), 0);
  fake_.inbox->OnView(FakeSession::Frame(5, kBall, Vec3::Zero(), 103.6F), 0);
  const auto* peers = Child<QTableView>("peers");
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return peers->model()->rowCount() == 1;
  }));
  const auto text = [&](int column) {
    return peers->model()->index(0, column).data().toString();
  };
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return text(PeerTableModel::kDelay) == "104 ms";
  }));
  EXPECT_EQ(text(PeerTableModel::kName), "Anna");
  // no column is out of sight
  const int last = PeerTableModel::kColumnCount - 1;
  EXPECT_LE(peers->columnViewportPosition(last) + peers->columnWidth(last),
            peers->viewport()->width());
  EXPECT_GT(peers->columnWidth(PeerTableModel::kName), 60);
  fake_.inbox->OnPeerLost(5);
  EXPECT_TRUE(ProcessEventsUntil([&] {
    return text(PeerTableModel::kPresence) == "lost";
  }));
}

// The table and the labels in the picture show the same figures, from the first sample on.
TEST_F(Window, SceneAloneShowsNoDelay) {
  window_.ShowSceneAlone();
  JoinSession();
  fake_.inbox->OnPeerInfo(FakeSession::Info(5, "Anna", Role::kActive), 0);
  fake_.inbox->OnView(FakeSession::Frame(5, kBall, Vec3::Zero(), 103.6F), 0);
  auto* peers = window_.findChild<QTableView*>("peers");
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return peers->model()->rowCount() == 1;
  }));
  EXPECT_EQ(peers->model()->index(0, PeerTableModel::kName).data().toString(), "Anna");
  EXPECT_FALSE(peers->model()->index(0, PeerTableModel::kDelay).data().toString().contains("104"));
  EXPECT_FALSE(peers->isVisible());
  EXPECT_FALSE(window_.session_dock().isVisible());
}

TEST_F(Window, ExplainsAMissingPicture) {
  ASSERT_NE(window_.page(), nullptr);
  JoinSession();
  EXPECT_TRUE(window_.page()->text().contains("bracket"));
  SceneManifest manifest;
  manifest.content_digest = {3};
  manifest.name = "gearbox";
  manifest.file = "/nowhere/gearbox.json";
  fake_.inbox->OnScene(manifest);
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return scene_.state() == SceneModel::State::kMissing;
  }));
  EXPECT_TRUE(window_.page()->text().contains("/nowhere/gearbox.json"));
}

TEST(WindowWithoutOpenGl, ShowsWhyAndStillJoins) {
  FakeSession fake;
  SessionModel session(fake.Join());
  SceneModel scene(LoadBlockAndBall);
  MainWindow window(session, scene, Error{"no driver: install libgl1-mesa-dri"});
  window.session_dock().SetRequest({"bracket", "Dora", 42, ""});
  window.show();
  ASSERT_NE(window.page(), nullptr);
  EXPECT_TRUE(window.page()->text().contains("install libgl1-mesa-dri"));
  QTest::mouseClick(window.findChild<QPushButton*>("join"), Qt::LeftButton);
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return session.state() == SessionModel::State::kJoined;
  }));
  EXPECT_EQ(window.view(), nullptr);
  EXPECT_EQ(window.Screenshot().size(), window.size());
}

// Names and paths are others' words: an image in one would be loaded, a headline would be ours.
TEST_F(Window, ShowsReceivedTextLiterally) {
  int labels = 0;
  for (const QLabel* label : window_.findChildren<QLabel*>()) {
    if (label->buddy() != nullptr) continue;  // a field's caption
    EXPECT_EQ(label->textFormat(), Qt::PlainText) << label->objectName().toStdString();
    ++labels;
  }
  EXPECT_GE(labels, 10);
  JoinSession();
  fake_.inbox->OnPeerInfo(FakeSession::Info(5, "<b>Anna</b>", Role::kActive), 0);
  const auto* peers = Child<QTableView>("peers");
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return peers->model()->rowCount() == 1;
  }));
  const QModelIndex name = peers->model()->index(0, 0);
  EXPECT_EQ(name.data().toString(), "<b>Anna</b>");
  EXPECT_EQ(name.data(Qt::ToolTipRole).toString(), "<qt>&lt;b&gt;Anna&lt;/b&gt;</qt>");
}

TEST_F(Window, AsksBeforeLoadingTheSessionsFile) {
  QTemporaryFile here(QDir::tempPath() + "/XXXXXX.json");
  ASSERT_TRUE(here.open());
  SceneManifest manifest;
  manifest.name = "theirs";
  manifest.file = here.fileName().toStdString();
  manifest.content_digest = BlockAndBall().digest;
  manifest.voxel_size = 0.003;
  JoinSession();
  fake_.inbox->OnScene(manifest);
  const auto* load = Child<QPushButton>("load_named_button");
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return scene_.state() == SceneModel::State::kMissing && load->isVisibleTo(&window_);
  }));
  EXPECT_TRUE(window_.page()->text().contains(here.fileName()));
  Click("load_named_button");
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return scene_.state() == SceneModel::State::kReady;
  }));
  EXPECT_FALSE(load->isVisibleTo(&window_));
}

}  // namespace
}  // namespace tandem
