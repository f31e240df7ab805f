#include <QApplication>
#include <QDropEvent>
#include <QMimeData>
#include <QTest>
#include <QToolBar>
#include <QUrl>
#include <QWheelEvent>

#include <gtest/gtest.h>

#include "tests/app/view/ui/hand_window_fixture.h"

// Tests taking part from the window, with a controller that has no physics.

namespace tandem {
namespace {

TEST_F(HandWindow, PressGrabsAndDragMovesThePart) {
  PressOnBall();
  // the grabbed point faces the eye; 4 cm beside and above it
  const Vec3 grabbed = ToPose(hand_.snapshot().hand.X_WG).p;
  const Vec3 by(0.04, 0, 0.03);
  Mouse(QEvent::MouseMove, At(grabbed + by), Qt::LeftButton);
  EXPECT_TRUE(BallComesTo(by, 1e-6)) << BallMoved().transpose();
  Mouse(QEvent::MouseButtonRelease, At(grabbed + by), Qt::NoButton);
  EXPECT_EQ(hand_.held(), kTheBall);  // still in hand
  Mouse(QEvent::MouseMove, At(grabbed), Qt::NoButton);
  EXPECT_TRUE(BallComesTo(by, 1e-6));
}

TEST_F(HandWindow, DragOnAFixedBodyOrTheBackgroundOrbits) {
  const Vec3 eye = view().camera().eye_W();
  const QPointF corner = At({0.09, -0.02, 0.09});
  Mouse(QEvent::MouseButtonPress, corner, Qt::LeftButton);
  Mouse(QEvent::MouseMove, corner + QPointF(40, 0), Qt::LeftButton);
  EXPECT_GT((view().camera().eye_W() - eye).norm(), 0.01);
  EXPECT_TRUE(controller_.Asked<GrabRequest>().empty());
}

TEST_F(HandWindow, WheelMovesInDepthDuringADragAndElseZooms) {
  PressOnBall();
  const double distance = view().camera().distance();
  const auto wheel = [&](int notches) {
    QWheelEvent event(At(ball_W_), view().mapToGlobal(At(ball_W_)), {}, {0, 120 * notches},
                      Qt::LeftButton, {}, Qt::NoScrollPhase, false);
    QApplication::sendEvent(&view(), &event);
  };
  wheel(2);
  EXPECT_TRUE(ProcessEventsUntil([&] {
    return BallMoved().y() > 0.01;
  }));
  EXPECT_DOUBLE_EQ(view().camera().distance(), distance);
  Mouse(QEvent::MouseButtonRelease, At(ball_W_), Qt::NoButton);
  wheel(2);
  EXPECT_LT(view().camera().distance(), distance);
}

TEST_F(HandWindow, CtrlTurnsAboutTheGrabbedPoint) {
  PressOnBall();
  const Vec3 grabbed = ToPose(hand_.snapshot().hand.X_WG).p;
  Mouse(QEvent::MouseMove, At(ball_W_) + QPointF(60, 0), Qt::LeftButton, Qt::ControlModifier);
  EXPECT_TRUE(ProcessEventsUntil([&] {
    return ToPose(hand_.snapshot().hand.X_WG).q.angularDistance(Quat::Identity()) > 0.4;
  }));
  EXPECT_LT((ToPose(hand_.snapshot().hand.X_WG).p - grabbed).norm(), 1e-9);
}

TEST_F(HandWindow, KeysNudgeAndLock) {
  PressOnBall();
  Mouse(QEvent::MouseButtonRelease, At(ball_W_), Qt::NoButton);
  QTest::keyClick(&view(), Qt::Key_Right);
  EXPECT_TRUE(BallComesTo({0.001, 0, 0}, 1e-9));  // a voxel
  QTest::keyClick(&view(), Qt::Key_Up, Qt::ShiftModifier);
  EXPECT_TRUE(BallComesTo({0.001, 0, 0.0001}, 1e-9));
  QTest::keyClick(&view(), Qt::Key_X);
  ASSERT_TRUE(window_.panel()->mouse()->lock().has_value());
  Mouse(QEvent::MouseButtonPress, At(ball_W_), Qt::LeftButton);
  Mouse(QEvent::MouseMove, At(ball_W_) + QPointF(50, 50), Qt::LeftButton);
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return BallMoved().x() > 0.005;
  }));
  EXPECT_NEAR(BallMoved().z(), 0.0001, 1e-9);
  EXPECT_TRUE(window_.panel()->StateText().contains("X"));
}

TEST_F(HandWindow, ATriadsArrowMovesAlongItsAxis) {
  PressOnBall();
  Mouse(QEvent::MouseButtonRelease, At(ball_W_), Qt::NoButton);
  Action("hand_triad")->trigger();
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return view().hand().X_WT.has_value();
  }));
  const auto triad = DrawTriad(view().camera(), *view().hand().X_WT);
  const Vec2 tip = triad->arrows[2].to;
  const QPointF at(tip.x(), tip.y());
  Mouse(QEvent::MouseMove, at, Qt::NoButton);
  EXPECT_EQ(view().hand().hot, (TriadHandle{TriadHandle::Kind::kArrow, 2}));
  Mouse(QEvent::MouseButtonPress, at, Qt::LeftButton);
  Mouse(QEvent::MouseMove, at + QPointF(25, -40), Qt::LeftButton);
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return BallMoved().z() > 0.005;
  }));
  EXPECT_NEAR(BallMoved().x(), 0, 1e-9);
}

TEST_F(HandWindow, ForceIsATetherAndContactAColour) {
  controller_.wall_x = 0.02;
  PressOnBall();
  const Vec3 grabbed = ToPose(hand_.snapshot().hand.X_WG).p;
  const Colour before = view().draw_list().solids[kTheBall].colour;
  Mouse(QEvent::MouseMove, At(grabbed + Vec3(0.07, 0, 0)), Qt::LeftButton);
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return view().hand().tether && view().hand().tether->force_N > 1;
  }));
  EXPECT_EQ(view().draw_list().ghosts.size(), 1U);
  EXPECT_EQ(view().hand().contacts.size(), 1U);
  EXPECT_NE(view().draw_list().solids[kTheBall].colour, before);
  EXPECT_NEAR(view().hand().tether->to_W.x() - view().hand().tether->from_W.x(), 0.05 + grabbed.x(),
              1e-6);
  // the cursor comes back: so does the goal, without delay
  Mouse(QEvent::MouseMove, At(grabbed), Qt::LeftButton);
  EXPECT_TRUE(BallComesTo(Vec3::Zero(), 1e-6));
}

// Buttons that drive a part back, hand it over or name a force would spoil a trial.
TEST_F(HandWindow, WithoutASessionOnlyTheStopIsEnabled) {
  window_.ShowSceneAlone();
  controller_.wall_x = 0.02;
  PressOnBall();
  Mouse(QEvent::MouseMove, At(ToPose(hand_.snapshot().hand.X_WG).p + Vec3(0.07, 0, 0)),
        Qt::LeftButton);
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return view().hand().tether && view().hand().tether->force_N > 1;
  }));
  EXPECT_FALSE(view().hand().figures);
  for (const QAction* action : window_.findChild<QToolBar*>("hand_bar")->actions()) {
    const bool stop = action->objectName() == "hand_stop" || action->objectName() == "hand_resume";
    EXPECT_EQ(action->isVisible(), stop) << action->objectName().toStdString();
  }
  for (const Qt::Key key : {Qt::Key_Escape, Qt::Key_L, Qt::Key_A, Qt::Key_H}) {
    QTest::keyClick(&view(), key);
  }
  QTest::keyClick(&view(), Qt::Key_R, Qt::ControlModifier | Qt::ShiftModifier);
  QTest::keyClick(&view(), Qt::Key_Space);
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return hand_.stopped();
  }));
  EXPECT_TRUE(controller_.Asked<RetraceRequest>().empty());
  EXPECT_TRUE(controller_.Asked<ReleaseRequest>().empty());
  EXPECT_TRUE(Action("hand_resume")->isEnabled());
}

TEST_F(HandWindow, RefusalsAreShownInThePicture) {
  controller_.refuse = "ben holds it: ask for it";
  Mouse(QEvent::MouseButtonPress, At(ball_W_), Qt::LeftButton);
  EXPECT_TRUE(ProcessEventsUntil([&] {
    return view().warning().contains("ben holds it: ask for it");
  }));
}

TEST_F(HandWindow, EscapeReturnsThePartAndIgnoresTheMouse) {
  PressOnBall();
  Mouse(QEvent::MouseMove, At(ball_W_) + QPointF(50, 0), Qt::LeftButton);
  QTest::keyClick(&view(), Qt::Key_Escape);
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return !controller_.Asked<RetraceRequest>().empty();
  }));
  EXPECT_EQ(controller_.Asked<RetraceRequest>()[0].to, RetraceRequest::To::kGrasp);
  EXPECT_FALSE(window_.panel()->mouse()->dragging());
  const PlainPose goal = controller_.now.hand.goal;
  Mouse(QEvent::MouseMove, At(ball_W_) + QPointF(90, 0), Qt::LeftButton);
  EXPECT_EQ(controller_.now.hand.goal.p_W, goal.p_W);
}

TEST_F(HandWindow, StopByKeyOrButtonHoldsUntilResumed) {
  PressOnBall();
  QTest::keyClick(&view(), Qt::Key_Space);
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return hand_.stopped() && view().warning().contains("Emergency stop");
  }));
  EXPECT_FALSE(Action("hand_grab")->isEnabled());
  EXPECT_FALSE(Action("hand_stop")->isEnabled());
  const std::size_t grabs = controller_.Asked<GrabRequest>().size();
  Mouse(QEvent::MouseButtonPress, At(ball_W_), Qt::LeftButton);
  EXPECT_EQ(controller_.Asked<GrabRequest>().size(), grabs);
  Action("hand_resume")->trigger();
  EXPECT_TRUE(ProcessEventsUntil([&] {
    return !hand_.stopped();
  }));
}

TEST_F(HandWindow, DeviceFollowsTheViewThatTheMouseMoves) {
  EXPECT_FALSE(Action("hand_clutch")->isEnabled());
  controller_.now.hand.input = SnapshotHand::Input::kDevice;
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return Action("hand_clutch")->isEnabled() && !controller_.Asked<SetViewRequest>().empty();
  }));
  // from the front, the axes of the view are those of the world
  EXPECT_NEAR(std::abs(controller_.Asked<SetViewRequest>().back().q_WV[3]), 1, 1e-9);
  Mouse(QEvent::MouseButtonPress, At(ball_W_), Qt::LeftButton);
  Mouse(QEvent::MouseMove, At(ball_W_) + QPointF(90, 0), Qt::LeftButton);
  Mouse(QEvent::MouseButtonRelease, At(ball_W_), Qt::NoButton);
  EXPECT_TRUE(controller_.Asked<GrabRequest>().empty());
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return controller_.Asked<SetViewRequest>().size() >= 2;
  }));
  const auto q = controller_.Asked<SetViewRequest>().back().q_WV;
  const Vec3 right_W = Quat(q[3], q[0], q[1], q[2]) * Vec3::UnitX();
  EXPECT_LT((right_W - view().camera().R_WC().col(0)).norm(), 1e-6);
  QTest::keyClick(&view(), Qt::Key_C);
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return controller_.Asked<SetParameterRequest>().size() == 1;
  }));
  EXPECT_EQ(controller_.Asked<SetParameterRequest>()[0].name, "device_clutch");
  EXPECT_EQ(controller_.Asked<SetParameterRequest>()[0].value, 1);
}

TEST_F(HandWindow, ExplainsMissingDeviceForceAndItsRemedy) {
  controller_.now.hand.input = SnapshotHand::Input::kDevice;
  EXPECT_FALSE(Action("hand_resume")->isEnabled());
  for (const auto state : {SnapshotSafety::State::kFault, SnapshotSafety::State::kStopped}) {
    controller_.now.safety.state = state;
    EXPECT_TRUE(ProcessEventsUntil([&] {
      return Action("hand_resume")->isEnabled() &&
             window_.panel()->StateText().contains("Resume (Ctrl+Space)");
    }));
    controller_.now.safety.state = SnapshotSafety::State::kOn;
    EXPECT_TRUE(ProcessEventsUntil([&] {
      return !Action("hand_resume")->isEnabled() &&
             !window_.panel()->StateText().contains("Device");
    }));
  }
  controller_.now.safety.state = SnapshotSafety::State::kTooFast;
  EXPECT_TRUE(ProcessEventsUntil([&] {
    return window_.panel()->StateText().contains("too fast");
  }));
  EXPECT_FALSE(Action("hand_resume")->isEnabled());
}

TEST_F(HandWindow, ActionsThatCannotBeDoneAreGrey) {
  EXPECT_TRUE(Action("hand_grab")->isEnabled());
  for (const char* name : {"hand_release", "hand_give", "hand_back", "hand_resume"}) {
    EXPECT_FALSE(Action(name)->isEnabled()) << name;
  }
  PressOnBall();
  EXPECT_TRUE(ProcessEventsUntil([&] {
    return Action("hand_release")->isEnabled() && Action("hand_back")->isEnabled();
  }));
}

TEST_F(HandWindow, LostControllerIsReportedAndThePartStops) {
  PressOnBall();
  controller_.received = false;
  EXPECT_TRUE(ProcessEventsUntil([&] {
    return view().warning().contains("does not answer");
  }));
  EXPECT_TRUE(Action("hand_stop")->isEnabled()) << "it may hear";
  EXPECT_FALSE(window_.panel()->mouse()->dragging());
}

TEST_F(HandWindow, StartAgainGivesAHandInPlaceOfADeadOne) {
  PressOnBall();
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return hand_.held().has_value();
  }));
  const std::size_t launched = controller_.launched.size();
  controller_.ended = "the program behind your hand was killed: your hand has let go";
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return window_.findChild<QPushButton*>("notice_again_0") != nullptr;
  }));
  EXPECT_EQ(window_.findChild<QPushButton*>("join")->text(), "Start &again");
  EXPECT_TRUE(window_.findChild<QPushButton*>("join")->isEnabled());
  controller_.ended.clear();
  QTest::mouseClick(window_.findChild<QPushButton*>("notice_again_0"), Qt::LeftButton);
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return hand_.ready();
  }));
  EXPECT_EQ(controller_.launched.size(), launched + 1);
  EXPECT_EQ(controller_.launched.back().scene, "block_and_ball.json");
  EXPECT_TRUE(ProcessEventsUntil([&] {
    return window_.findChild<QPushButton*>("notice_again_0") == nullptr;
  }));
  EXPECT_EQ(window_.findChild<QPushButton*>("join")->text(), "&Join");
}

TEST_F(HandWindow, RequestForThePartInHandHasTwoButtons) {
  SnapshotPeer ben;
  ben.id = 0xbe;
  ben.name = "ben";
  controller_.now.peers = {ben};
  PressOnBall();
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return hand_.held().has_value();
  }));
  const auto ask = [&] {
    controller_.now.asked = {ben.id, kTheBall};
    controller_.now.news = "ben asks for ball, which you hold";
    ++controller_.now.news_count;
    return ProcessEventsUntil([&] {
      return window_.findChild<QPushButton*>("notice_asked_1") != nullptr;
    });
  };
  ASSERT_TRUE(ask());
  auto* notices = window_.findChild<NoticeBar*>();
  EXPECT_EQ(notices->Text("asked"), "ben asks for ball, which you hold.");
  EXPECT_TRUE(notices->isVisible());
  QTest::mouseClick(window_.findChild<QPushButton*>("notice_asked_1"), Qt::LeftButton);  // Keep
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return notices->Text("asked").isEmpty();
  }));
  EXPECT_TRUE(controller_.Asked<GiveRequest>().empty());
  ASSERT_TRUE(ask());
  QTest::mouseClick(window_.findChild<QPushButton*>("notice_asked_0"), Qt::LeftButton);
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return controller_.Asked<GiveRequest>().size() == 1;
  }));
}

TEST_F(HandWindow, ShowsWarningsOfTheStartAndVerdictsOfTheEnd) {
  controller_.now.warnings = {"ball and block overlap at the start", "block has open edges"};
  auto* notices = window_.findChild<NoticeBar*>();
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return !notices->Text("scene").isEmpty();
  }));
  EXPECT_EQ(notices->Text("scene"), "ball and block overlap at the start\nblock has open edges");
  QTest::mouseClick(window_.findChild<QPushButton*>("notice_scene_0"), Qt::LeftButton);
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return notices->Text("scene").isEmpty();
  }));
  controller_.last_words = {"ball stands 60.0 mm from its first place and is out"};
  Action("leave_action")->trigger();
  EXPECT_EQ(notices->Text("verdict"), "ball stands 60.0 mm from its first place and is out");
}

TEST_F(HandWindow, DroppedSceneOpensWithItsOwnController) {
  QMimeData data;
  data.setUrls({QUrl::fromLocalFile("/tmp/other.json")});
  QDragEnterEvent enter(QPoint(10, 10), Qt::CopyAction, &data, Qt::LeftButton, {});
  QApplication::sendEvent(&window_, &enter);
  EXPECT_TRUE(enter.isAccepted());
  QDropEvent drop(QPointF(10, 10), Qt::CopyAction, &data, Qt::LeftButton, {});
  QApplication::sendEvent(&window_, &drop);
  ASSERT_EQ(controller_.launched.size(), 2U);
  EXPECT_EQ(controller_.launched[1].scene, "/tmp/other.json");
  EXPECT_EQ(controller_.processes, 1);
}

TEST_F(HandWindow, ChosenDeviceReplacesTheMouse) {
  const std::size_t launched = controller_.launched.size();
  window_.panel()->UseDevice("spacemouse");
  ASSERT_EQ(controller_.launched.size(), launched + 1);
  EXPECT_EQ(controller_.launched.back().device, "spacemouse");
  EXPECT_EQ(controller_.launched.back().scene, "block_and_ball.json");
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return hand_.ready();
  }));
  window_.panel()->UseDevice("spacemouse");  // it is in use
  EXPECT_EQ(controller_.launched.size(), launched + 1);
  window_.panel()->UseDevice("");
  EXPECT_EQ(controller_.launched.back().device, "");
}

}  // namespace
}  // namespace tandem
