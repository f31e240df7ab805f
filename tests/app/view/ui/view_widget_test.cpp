#include "app/view/ui/view_widget.h"

#include <QScreen>
#include <QTest>

#include <gtest/gtest.h>

#include "tests/app/view/fake_session.h"
#include "tests/app/view/shapes.h"

namespace tandem {
namespace {

/// Tests the picture alone, where the processor draws and where it does not.
class View : public ::testing::TestWithParam<bool> {
 protected:
  void Show(const DrawnScene& scene) {
    DrawList list;
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
      list.solids.push_back({i, {}, scene.bodies[i].look.colour, 1});
    }
    view_.resize(400, 320);
    view_.SetScene(&scene);
    view_.SetDrawList(list);
    view_.show();
    ASSERT_TRUE(QTest::qWaitForWindowExposed(&view_));
  }
  /// Waits until no frame comes any more: for longer than the pause before the fine frame.
  void ComeToRest() {
    constexpr int kStillMs = 4000;  // a frame of a large scene takes long on a busy machine
    quint64 frames = 0;
    do {
      frames = view_.frames_drawn();
    } while (ProcessEventsUntil(
        [&] {
          return view_.frames_drawn() != frames;
        },
        kStillMs));
  }
  QImage OnScreen() {
    return view_.screen()
        ->grabWindow(view_.winId())
        .toImage()
        .convertToFormat(QImage::Format_RGB32);
  }
  QImage Kept() {
    view_.DrawToKeep();
    return view_.grabFramebuffer().convertToFormat(QImage::Format_RGB32);
  }

  ViewWidget view_{GlInfo{"", GetParam()}};
};

TEST_P(View, RefinesAnUnmovedLargeSceneToTheSavedPicture) {
  DrawnScene scene = BlockAndBall();
  scene.bodies.push_back(
      MakeDrawnBody("large", {true, {0.5F, 0.5F, 0.7F}}, SphereMesh(0.06, 600, 400)));
  Show(scene);
  ComeToRest();
  // a small scene takes a coarse frame and a fine one, or the fine one alone
  EXPECT_GT(view_.frames_drawn(), GetParam() ? 2U : 1U);
  const QImage at_rest = OnScreen();
  EXPECT_EQ(at_rest, Kept());
}

TEST_P(View, SavedPictureIsCompleteWhileTheEyeMoves) {
  DrawnScene scene = BlockAndBall();
  scene.bodies.push_back(
      MakeDrawnBody("large", {true, {0.5F, 0.5F, 0.7F}}, SphereMesh(0.06, 600, 400)));
  Show(scene);
  view_.LookFrom(StandardView::kRight);
  const QImage kept = Kept();
  ComeToRest();
  EXPECT_EQ(OnScreen(), kept);
}

INSTANTIATE_TEST_SUITE_P(Drawing, View, ::testing::Values(true, false));

}  // namespace
}  // namespace tandem
