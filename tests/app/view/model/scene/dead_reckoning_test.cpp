#include "app/view/model/scene/dead_reckoning.h"

#include <cmath>

#include <gtest/gtest.h>

namespace tandem {
namespace {

const Vec3 kMiddle(0.5, -0.2, 0.1);  // m, far from the origin that displacements are about

/// Returns the displacement of a body whose middle has gone by `p` and which has turned by `w`.
Pose Moved(const Vec3& p, const Vec3& w) {
  const Quat q = RotationBy(w);
  return {q, kMiddle + p - q * kMiddle};
}

/// Returns the twist of that displacement where the middle goes at v and the body turns at w.
Twist Going(const Pose& X_W, const Vec3& v, const Vec3& w) {
  return {w, v + w.cross(X_W.p - X_W * kMiddle)};
}

TEST(DeadReckoning, RestingBodyIsDrawnAtItsReceivedPose) {
  DeadReckoning body;
  const Pose X_W = Moved(Vec3(0.1, 0.2, 0.3), Vec3(0.4, 0.5, 0.6));
  for (int i = 0; i < 10; ++i) {
    const Pose shown = body.Show({static_cast<std::uint32_t>(i), X_W, {}}, kMiddle, 0.016 * i);
    EXPECT_EQ(shown.p, X_W.p);
    EXPECT_EQ(shown.q.coeffs(), X_W.q.coeffs());
  }
}

TEST(DeadReckoning, ExtrapolatesThenStopsAndReturns) {
  DeadReckoning body;
  const Vec3 v(0.2, 0, 0);
  const Vec3 w(0, 0, 1);
  const Pose X_W = Moved(Vec3(0.1, 0, 0), Vec3::Zero());
  const DeadReckoning::ReceivedMotion reported{1, X_W, Going(X_W, v, w)};
  body.Show(reported, kMiddle, 0);
  for (const double t : {0.01, 0.05, 0.1}) {
    const Pose shown = body.Show(reported, kMiddle, t);
    EXPECT_LT((shown * kMiddle - (kMiddle + Vec3(0.1, 0, 0) + t * v)).norm(), 1e-12) << t;
    EXPECT_LT((RotationVector(shown.q) - t * w).norm(), 1e-12) << t;
  }
  double last = 0.02;
  for (double t = 0.1; t < 0.35; t += 0.01) {
    const double ahead = (body.Show(reported, kMiddle, t) * kMiddle - X_W * kMiddle).norm();
    EXPECT_LE(ahead, last + 1e-12);
    EXPECT_GE(ahead, last - 0.0011);
    last = ahead;
  }
  EXPECT_LT((body.Show(reported, kMiddle, 0.4).p - X_W.p).norm(), 1e-12);
}

TEST(DeadReckoning, IsNeverMoreThanThirtyMillimetresAhead) {
  DeadReckoning body;
  const Pose X_W;
  const DeadReckoning::ReceivedMotion reported{1, X_W, Going(X_W, Vec3(3, 0, 0), Vec3(0, 5, 0))};
  double most = 0;
  for (double t = 0; t < 0.5; t += 0.002) {
    most = std::max(most, (body.Show(reported, kMiddle, t) * kMiddle - kMiddle).norm());
  }
  EXPECT_NEAR(most, DeadReckoning::kFarthest, 1e-9);
}

// A hand goes to and fro. Its frames come 60 times a second, each third one is lost, and the
// picture is drawn at 60 Hz. The picture is nearer to the truth than the frames are, and moves
// without jumps.
TEST(DeadReckoning, FollowsAHandSmoothlyOverLostFrames) {
  const auto place = [](double t) {
    return Vec3(0.1 * std::sin(4 * t), 0, 0);
  };
  const auto speed = [](double t) {
    return Vec3(0.4 * std::cos(4 * t), 0, 0);
  };
  DeadReckoning body;
  DeadReckoning::ReceivedMotion reported;
  double off_told = 0;
  double off_shown = 0;
  double most_jerk = 0;
  Vec3 last = Vec3::Zero();
  Vec3 last_step = Vec3::Zero();
  for (int i = 0; i < 600; ++i) {
    const double t = i / 60.0;
    if (i % 3 != 2) {
      reported.seq = static_cast<std::uint32_t>(i);
      reported.X_W =
          Moved(place(t - 0.01), Vec3::Zero());  // pose as it was when the frame was sent
      reported.V_W = Going(reported.X_W, speed(t - 0.01), Vec3::Zero());
    }
    const Vec3 shown = body.Show(reported, kMiddle, t) * kMiddle - kMiddle;
    off_told += (reported.X_W * kMiddle - kMiddle - place(t - 0.01)).squaredNorm();
    off_shown += (shown - place(t - 0.01)).squaredNorm();
    if (i > 1) most_jerk = std::max(most_jerk, (shown - last - last_step).norm());
    last_step = shown - last;
    last = shown;
  }
  EXPECT_LT(off_shown, 0.25 * off_told);  // squares: half as far off
  EXPECT_LT(most_jerk, 0.002);
}

TEST(DeadReckoning, PredictionErrorIsCorrectedOverSeveralFrames) {
  DeadReckoning body;
  const Pose X_W;
  body.Show({1, X_W, Going(X_W, Vec3(0.3, 0, 0), Vec3::Zero())}, kMiddle, 0);
  const Pose stopped = Moved(Vec3(0.005, 0, 0), Vec3::Zero());
  // the hand stopped at 5 mm, and is drawn at 30 mm
  double last = 0.03;
  for (int i = 0; i <= 60; ++i) {
    const double t = 0.1 + i / 60.0;
    const double x = (body.Show({2, stopped, {}}, kMiddle, t) * kMiddle - kMiddle).x();
    EXPECT_LE(x, last + 1e-12);
    EXPECT_LT(last - x, 0.008);
    last = x;
  }
  EXPECT_EQ(body.Show({2, stopped, {}}, kMiddle, 2).p, stopped.p);
}

TEST(DeadReckoning, DistantPoseIsTakenAtOnce) {
  DeadReckoning body;
  body.Show({1, {}, {}}, kMiddle, 0);
  const Pose far = Moved(Vec3(0.3, 0, 0), Vec3::Zero());
  EXPECT_EQ(body.Show({2, far, {}}, kMiddle, 0.01).p, far.p);
}

}  // namespace
}  // namespace tandem
