#include "app/view/ui/main_window.h"

#include <QApplication>
#include <QDir>
#include <QTemporaryFile>
#include <QTest>
#include <QWheelEvent>
#include <atomic>
#include <cmath>
#include <filesystem>
#include <set>

#include <gtest/gtest.h>

#include "tests/app/view/fake_session.h"
#include "tests/app/view/shapes.h"
#include "tests/support/scratch_folder.h"

namespace tandem {
namespace {

constexpr ObjectId kBall = 1;

Result<DrawnScene> LoadBlockAndBall(const std::filesystem::path& file, const LoadProgress&) {
  DrawnScene scene = BlockAndBall();
  scene.file = file;
  return scene;
}

class Window : public ::testing::Test {
 protected:
  void SetUp() override {
    window_.session_dock().SetRequest({"bracket", "Dora", 42, ""});
    window_.show();
    ASSERT_TRUE(QTest::qWaitForWindowExposed(&window_));
  }
  template <typename T>
  T* Child(const char* name) {
    T* child = window_.findChild<T*>(name);
    EXPECT_NE(child, nullptr) << name;
    return child;
  }
  void Click(const char* button) { QTest::mouseClick(Child<QPushButton>(button), Qt::LeftButton); }
  void JoinSession() {
    Click("join");
    ASSERT_TRUE(ProcessEventsUntil([&] {
      return session_.state() == SessionModel::State::kJoined;
    }));
  }
  void OpenScene() {
    scene_.OpenNamed("block_and_ball.json");
    ASSERT_TRUE(ProcessEventsUntil([&] {
      return window_.page() == nullptr && view().frames_drawn() > 0;
    }));
  }
  ViewWidget& view() { return *window_.view(); }
  bool FrameAfter(quint64 frames) {
    return ProcessEventsUntil([&] {
      return view().frames_drawn() > frames;
    });
  }
  /// Returns the colour of the picture as it is now.
  QColor PixelAt(const Vec3& p_W) {
    const QImage image = window_.Screenshot();
    const auto px = view().camera().Project(p_W);
    const QPoint at =
        view().mapTo(&window_, QPoint(static_cast<int>(px->x()), static_cast<int>(px->y())));
    return image.pixelColor(at);
  }
  void Drag(Qt::MouseButton button, Qt::KeyboardModifiers modifiers, const QPoint& by) {
    const QPoint from = view().rect().center();
    const auto send = [&](QEvent::Type type, const QPoint& at, Qt::MouseButtons held) {
      QMouseEvent event(type, at, view().mapToGlobal(at),
                        type == QEvent::MouseMove ? Qt::NoButton : button, held, modifiers);
      QApplication::sendEvent(&view(), &event);
    };
    send(QEvent::MouseButtonPress, from, button);
    send(QEvent::MouseMove, from + by, button);
    send(QEvent::MouseButtonRelease, from + by, Qt::NoButton);
  }

  FakeSession fake_;
  SessionModel session_{fake_.Join()};
  SceneModel scene_{LoadBlockAndBall};
  MainWindow window_{session_, scene_, CheckGl()};
  const Vec3 p_WBall_{0, -0.1, 0};
};

TEST_F(Window, JoinsAndLeavesByItsButtons) {
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

TEST_F(Window, SaysPlainOnlyOfASessionThatSomebodyWasHeardIn) {
  JoinSession();
  const auto* dock = Child<QLabel>("session_state");
  EXPECT_TRUE(dock->text().contains("nobody heard"));
  EXPECT_FALSE(dock->text().contains("plain"));
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return window_.page() != nullptr &&
           window_.page()->text().contains("another name, network, domain or keys?");
  }));
  EXPECT_TRUE(window_.page()->text().contains("\nNobody heard in session"));
  EXPECT_TRUE(Child<QLabel>("status_session")->text().contains("nobody heard"));
  fake_.inbox->OnPeerInfo(FakeSession::Info(5, "Anna", Role::kActive), 0);
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return dock->text().contains("plain: anyone on the network can look on");
  }));
  EXPECT_FALSE(Child<QLabel>("status_session")->text().contains("nobody heard"));
  EXPECT_TRUE(window_.page()->text().contains("has offered a scene yet"));
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
  manifest.content_hash = BlockAndBall().hash;
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

TEST_F(Window, AfterLeavingSaysThatOneHasLeftOneselfAndThatNothingComes) {
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
    return view().warning().contains("Anna speaks protocol");
  }));
  EXPECT_TRUE(view().warning().contains("bring both to one version"));
  fake_.inbox->OnPeerLeft(5);
  EXPECT_TRUE(ProcessEventsUntil([&] {
    return view().warning().isEmpty();
  }));
}

TEST_F(Window, OpensASceneThatAPersonChooses) {
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

TEST_F(Window, KeepsABodyInThePictureThatComesOut) {
  OpenScene();
  JoinSession();
  const auto in_picture = [&](const Vec3& p_W) {
    const auto px = view().camera().Project(p_W);
    return px && px->x() > 0 && px->x() < view().width() && px->y() > 0 &&
           px->y() < view().height();
  };
  const auto move_to = [&](const Vec3& moved) {
    const quint64 frames = view().frames_drawn();
    fake_.inbox->OnView(FakeSession::Frame(5, kBall, moved, 0), 0);
    return FrameAfter(frames);
  };
  const Vec3 out(0, -0.6, 0);
  ASSERT_TRUE(move_to(out));
  EXPECT_TRUE(in_picture(p_WBall_ + out));
  EXPECT_TRUE(in_picture(Vec3::Zero()));
  // the fit comes as near again as can be
  const double followed = view().camera().distance();
  ASSERT_TRUE(move_to(Vec3::Zero()));
  view().FitScene();
  EXPECT_LT(view().camera().distance(), 0.8 * followed);
  // a person who moves the camera has it
  auto* follow = Child<QAction>("follow");
  EXPECT_TRUE(follow->isChecked());
  Drag(Qt::MiddleButton, Qt::NoModifier, {5, 0});
  EXPECT_FALSE(follow->isChecked());
  const Vec3 farther(0, -3, 0);
  ASSERT_TRUE(move_to(farther));
  EXPECT_FALSE(in_picture(p_WBall_ + farther));
  follow->trigger();
  EXPECT_TRUE(ProcessEventsUntil([&] {
    return in_picture(p_WBall_ + farther);
  }));
  // a body that flies off is let go
  const double distance = view().camera().distance();
  ASSERT_TRUE(move_to(Vec3(0, -1e4, 0)));
  EXPECT_EQ(view().camera().distance(), distance);
}

TEST_F(Window, FiguresInThePictureAndBesideItAreOfOneMoment) {
  OpenScene();
  JoinSession();
  window_.ShowProximity(true);
  const auto* peers = Child<QTableView>("peers");
  const auto* status = Child<QLabel>("status_proximity");
  std::set<QString> delays;
  std::set<QString> distances;
  QObject::connect(&view(), &ViewWidget::FrameDrawn, [&] {
    const DrawList& list = view().draw_list();
    if (list.labels.empty() || peers->model()->rowCount() == 0) return;
    const QString delay = peers->model()->index(0, PeerTableModel::kDelay).data().toString();
    EXPECT_TRUE(QString::fromStdString(list.labels[0].text).contains(delay))
        << list.labels[0].text << " beside " << delay.toStdString();
    delays.insert(delay);
    if (view().proximity() == nullptr) return;
    const std::string distance = DistanceText(view().proximity()->nearest);
    EXPECT_TRUE(status->text().contains(QString::fromStdString(distance)))
        << distance << " beside " << status->text().toStdString();
    distances.insert(status->text());
  });
  fake_.inbox->OnPeerInfo(FakeSession::Info(5, "Anna", Role::kActive), 0);
  int sent = 0;
  ASSERT_TRUE(ProcessEventsUntil([&] {
    ++sent;
    const Vec3 moved(0, 0.03 + 1e-4 * (sent % 100), 0);
    fake_.inbox->OnView(FakeSession::Frame(5, kBall, moved, static_cast<float>(100 + sent)), 0);
    return delays.size() > 2 && distances.size() > 2;
  }));
  // a person can read the digits: not each frame brings others
  EXPECT_LT(delays.size(), static_cast<std::size_t>(sent));
}

TEST_F(Window, TellsHowManyTrianglesTheFilesHave) {
  OpenScene();
  const auto* size = Child<QLabel>("scene_size");
  const std::size_t read = 12 + 2 * 32 * 15;  // lines of the box and the ball
  EXPECT_EQ(size->text(), QStringLiteral("2 bodies, %1 triangles").arg(read));
}

TEST_F(Window, SaysWhyItCouldNotJoin) {
  fake_.refuse = "no interface called eth7";
  Click("join");
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return session_.state() == SessionModel::State::kFailed;
  }));
  EXPECT_TRUE(Child<QLabel>("session_state")->text().contains("no interface called eth7"));
  EXPECT_TRUE(Child<QPushButton>("join")->isEnabled());
}

TEST_F(Window, CannotJoinASessionWithoutAName) {
  Child<QLineEdit>("session")->clear();
  EXPECT_FALSE(Child<QPushButton>("join")->isEnabled());
}

TEST_F(Window, ShowsTheSceneAndMovesABodyWhenAPoseComes) {
  OpenScene();
  JoinSession();
  const QColor at_first = PixelAt(p_WBall_);
  EXPECT_GT(at_first.green(), at_first.red() + 60);
  const quint64 frames = view().frames_drawn();
  const Vec3 moved(0.0, -0.05, -0.09);
  fake_.inbox->OnView(FakeSession::Frame(5, kBall, moved, 104), 0);
  ASSERT_TRUE(FrameAfter(frames));
  EXPECT_TRUE(window_.ShowsPoses());
  const QColor now = PixelAt(p_WBall_ + moved);
  EXPECT_GT(now.green(), now.red() + 60);
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
TEST_F(Window, OfTheSceneAloneNothingTellsTheDelay) {
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

TEST_F(Window, WritesPeersNamesBesideTheirInstances) {
  OpenScene();
  JoinSession();
  const QImage without = window_.Screenshot();
  const quint64 frames = view().frames_drawn();
  fake_.inbox->OnPeerInfo(FakeSession::Info(5, "Anna", Role::kActive), 0);
  fake_.inbox->OnView(FakeSession::Frame(5, kBall, Vec3::Zero(), 104), 0);
  ASSERT_TRUE(FrameAfter(frames));
  const QImage with = window_.Screenshot();
  // the ball has not moved: only the name is new above it in the picture
  const auto px = view().camera().Project(p_WBall_);
  const QPoint ball =
      view().mapTo(&window_, QPoint(static_cast<int>(px->x()), static_cast<int>(px->y())));
  int different = 0;
  for (int y = std::max(0, ball.y() - 250); y < ball.y() - 10; ++y) {
    for (int x = ball.x() - 40; x < ball.x() + 40; ++x) {
      different += with.pixel(x, y) != without.pixel(x, y) ? 1 : 0;
    }
  }
  EXPECT_GT(different, 500);
}

TEST_F(Window, OrbitsPansAndZoomsWithTheMouse) {
  OpenScene();
  const Vec3 eye = view().camera().eye_W();
  const Vec3 target = view().camera().target_W();
  Drag(Qt::LeftButton, Qt::NoModifier, {60, 25});
  EXPECT_GT((view().camera().eye_W() - eye).norm(), 0.01);
  EXPECT_EQ(view().camera().target_W(), target);

  Drag(Qt::MiddleButton, Qt::NoModifier, {30, 0});
  const Vec3 panned = view().camera().target_W();
  EXPECT_GT((panned - target).norm(), 0.001);
  Drag(Qt::LeftButton, Qt::ShiftModifier, {-30, 0});  // back
  EXPECT_LT((view().camera().target_W() - target).norm(), 1e-9);

  const double distance = view().camera().distance();
  const QPointF at(80, 90);
  QWheelEvent wheel(at, view().mapToGlobal(at), {}, {0, 240}, Qt::NoButton, Qt::NoModifier,
                    Qt::NoScrollPhase, false);
  QApplication::sendEvent(&view(), &wheel);
  EXPECT_LT(view().camera().distance(), distance);
}

TEST_F(Window, LooksFromTheStandardViewsAndFitsByKeys) {
  OpenScene();
  window_.activateWindow();
  ASSERT_TRUE(QTest::qWaitForWindowActive(&window_));
  view().setFocus();
  QTest::keyClick(&view(), Qt::Key_7);
  EXPECT_LT((view().camera().R_WC().col(2) - Vec3::UnitZ()).norm(), 1e-9);
  QTest::keyClick(&view(), Qt::Key_1);
  EXPECT_LT((view().camera().R_WC().col(2) + Vec3::UnitY()).norm(), 1e-9);
  const double fitted = view().camera().distance();
  Drag(Qt::MiddleButton, Qt::NoModifier, {200, 0});
  QTest::keyClick(&view(), Qt::Key_F);
  EXPECT_NEAR(view().camera().distance(), fitted, 1e-12);
  EXPECT_LT((view().camera().target_W() - scene_.scene()->BoundsOfAll().centre()).norm(), 1e-12);
}

TEST_F(Window, DrawsNothingWhenNothingChanges) {
  OpenScene();
  JoinSession();
  fake_.inbox->OnView(FakeSession::Frame(5, kBall, Vec3::Zero(), 0), 0);
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return window_.ShowsPoses();
  }));
  // the picture comes to rest: half a second passes without a frame, though the same pose is sent
  // again and again
  quint64 frames = 0;
  const QDeadlineTimer deadline(10'000);
  do {
    frames = view().frames_drawn();
    QDeadlineTimer rest(500);
    while (!rest.hasExpired()) {
      fake_.inbox->OnView(FakeSession::Frame(5, kBall, Vec3::Zero(), 0), 0);
      QCoreApplication::processEvents(QEventLoop::WaitForMoreEvents, 20);
    }
  } while (view().frames_drawn() != frames && !deadline.hasExpired());
  EXPECT_EQ(view().frames_drawn(), frames);
}

TEST_F(Window, ShowsProximityByItsKeyAndHidesItAgain) {
  OpenScene();
  JoinSession();
  const Vec3 moved(0, 0.048, 0);  // 2 mm before the block
  const quint64 frames = view().frames_drawn();
  fake_.inbox->OnView(FakeSession::Frame(5, kBall, moved, 0), 0);
  ASSERT_TRUE(FrameAfter(frames));
  view().LookFrom(StandardView::kTop);
  // on the ball, 3.5 mm from the block, and beside the line to the peer's name
  const Vec3 near_block = p_WBall_ + moved + 0.0299 * Vec3(0.12, 0.95, 0.28).normalized();
  const QColor plain = PixelAt(near_block);
  EXPECT_GT(plain.green(), plain.red() + 60);

  auto* proximity = Child<QAction>("proximity");
  auto* status = Child<QLabel>("status_proximity");
  EXPECT_FALSE(proximity->isChecked());
  EXPECT_TRUE(status->text().isEmpty());
  window_.activateWindow();
  ASSERT_TRUE(QTest::qWaitForWindowActive(&window_));
  view().setFocus();
  QTest::keyClick(&view(), Qt::Key_P);
  EXPECT_TRUE(proximity->isChecked());
  EXPECT_TRUE(status->text().contains("Voxelizing"));
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return status->text().contains("ball \u2013 block: 2.000 mm \u00b1 0.001 mm");
  })) << status->text().toStdString();
  const QColor warm = PixelAt(near_block);
  EXPECT_GT(warm.red(), warm.blue() + 40);
  EXPECT_GT(warm.red(), warm.green());
  const QColor far_side = PixelAt(p_WBall_ + moved + Vec3(0.01, -0.015, 0.024));
  EXPECT_GT(far_side.blue(), far_side.red() + 40);

  // it follows the body
  fake_.inbox->OnView(FakeSession::Frame(5, kBall, Vec3(0, 0.045, 0), 0), 0);
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return status->text().contains("5.000 mm");
  }));
  QTest::keyClick(&view(), Qt::Key_P);
  EXPECT_TRUE(status->text().isEmpty());
  fake_.inbox->OnView(FakeSession::Frame(5, kBall, moved, 0), 0);
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return PixelAt(near_block) == plain;
  }));
}

TEST_F(Window, SaysWhatIsMissingInPlaceOfThePicture) {
  ASSERT_NE(window_.page(), nullptr);
  JoinSession();
  EXPECT_TRUE(window_.page()->text().contains("bracket"));
  SceneManifest manifest;
  manifest.content_hash = 3;
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
TEST_F(Window, ShowsOthersWordsLetterByLetter) {
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

TEST_F(Window, AsksBeforeItLoadsAFileThatTheSessionNames) {
  QTemporaryFile here(QDir::tempPath() + "/XXXXXX.json");
  ASSERT_TRUE(here.open());
  SceneManifest manifest;
  manifest.name = "theirs";
  manifest.file = here.fileName().toStdString();
  manifest.content_hash = BlockAndBall().hash;
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
