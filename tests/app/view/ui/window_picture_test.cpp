// Tests the picture in the main window, and the camera that a person moves.
#include <QApplication>
#include <QDeadlineTimer>
#include <QTest>
#include <QWheelEvent>
#include <algorithm>
#include <cstddef>
#include <set>
#include <string>

#include <gtest/gtest.h>

#include "tests/app/view/ui/window_fixture.h"

namespace tandem {
namespace {

TEST_F(Window, KeepsARemovedBodyInView) {
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

TEST_F(Window, FiguresInAndBesideThePictureAgree) {
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
    const std::string distance =
        DistanceText(view().proximity()->nearest, view().proximity()->yield);
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
  // below the dot of its label
  const QColor now = PixelAt(p_WBall_ + moved - Vec3(0, 0, 0.008));
  EXPECT_GT(now.green(), now.red() + 60);
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

TEST_F(Window, KeysSelectStandardViewsAndFit) {
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

}  // namespace
}  // namespace tandem
