#pragma once

#include <QApplication>
#include <QMouseEvent>
#include <QTest>
#include <QToolBar>
#include <cstddef>
#include <filesystem>

#include <gtest/gtest.h>

#include "app/view/ui/main_window.h"
#include "tests/app/view/fake_session.h"
#include "tests/app/view/model/hand/fake_controller.h"
#include "tests/app/view/shapes.h"

namespace tandem {

inline constexpr std::size_t kTheBall = 1;

/// A window with a hand, whose controller has no physics.
class HandWindow : public ::testing::Test {
 protected:
  void SetUp() override {
    window_.resize(1000, 700);
    window_.show();
    ASSERT_TRUE(QTest::qWaitForWindowExposed(&window_));
    HandRequest defaults;
    defaults.name = "anna";
    defaults.control = "test";
    window_.panel()->SetDefaults(defaults);
    window_.OpenScene("block_and_ball.json");
    ASSERT_TRUE(ProcessEventsUntil([&] {
      return hand_.ready() && window_.page() == nullptr && view().frames_drawn() > 0;
    }));
    // the bar has come into view, and the camera knows of it
    ASSERT_TRUE(ProcessEventsUntil([&] {
      return window_.findChild<QToolBar*>("hand_bar")->isVisible() &&
             view().camera().height_px() == view().height();
    }));
    window_.activateWindow();
    ASSERT_TRUE(QTest::qWaitForWindowActive(&window_));
    view().LookFrom(StandardView::kFront);
    controller_.now.scene = "block_and_ball.json";
  }
  /// Saves a picture for a person who wants to see what the test has done.
  void TearDown() override {
    const QString folder = qEnvironmentVariable("TANDEM_KEEP_PICTURES");
    const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
    if (!folder.isEmpty()) window_.Screenshot().save(folder + "/" + test->name() + ".png");
  }
  ViewWidget& view() { return *window_.view(); }
  QPointF At(const Vec3& p_W) {
    const Vec2 px = *view().camera().Project(p_W);
    return {px.x(), px.y()};
  }
  void Mouse(QEvent::Type type, const QPointF& at, Qt::MouseButtons held,
             Qt::KeyboardModifiers modifiers = {}) {
    QMouseEvent event(type, at, view().mapToGlobal(at),
                      type == QEvent::MouseMove ? Qt::NoButton : Qt::LeftButton, held, modifiers);
    QApplication::sendEvent(&view(), &event);
  }
  void PressOnBall() {
    Mouse(QEvent::MouseButtonPress, At(ball_W_), Qt::LeftButton);
    ASSERT_TRUE(ProcessEventsUntil([&] {
      return hand_.held() == kTheBall;
    }));
  }
  Vec3 BallMoved() { return ToPose(hand_.snapshot().bodies[kTheBall].X_W).p; }
  bool BallComesTo(const Vec3& moved, double within) {
    return ProcessEventsUntil([&] {
      return (BallMoved() - moved).norm() < within;
    });
  }
  QAction* Action(const char* name) { return window_.findChild<QAction*>(name); }

  FakeController controller_;
  FakeSession fake_;
  SessionModel session_{fake_.Join()};
  SceneModel scene_{[](const std::filesystem::path& file, const LoadProgress&) {
    DrawnScene scene = BlockAndBall();
    scene.file = file;
    return Result<DrawnScene>(scene);
  }};
  HandModel hand_{controller_.Attach(), controller_.Launch()};
  MainWindow window_{session_, scene_, CheckGl(), &hand_};
  const Vec3 ball_W_{0, -0.1, 0};
};

}  // namespace tandem
