#pragma once

#include <QApplication>
#include <QImage>
#include <QMouseEvent>
#include <QPushButton>
#include <QTest>
#include <filesystem>

#include <gtest/gtest.h>

#include "app/view/ui/main_window.h"
#include "tests/app/view/fake_session.h"
#include "tests/app/view/shapes.h"

namespace tandem {

inline constexpr ObjectId kBall = 1;

inline Result<DrawnScene> LoadBlockAndBall(const std::filesystem::path& file, const LoadProgress&) {
  DrawnScene scene = BlockAndBall();
  scene.file = file;
  return scene;
}

/// A window whose session has no network, with a block and a ball for a scene.
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

}  // namespace tandem
