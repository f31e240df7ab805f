#include "engine/base/spatial.h"

#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

namespace tandem {
namespace {

constexpr double kPi = std::numbers::pi;

class Spatial : public ::testing::Test {
 protected:
  double Number(double low = -1, double high = 1) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  Vec3 Point() { return {Number(), Number(), Number()}; }
  Vec3 Direction() {
    std::normal_distribution<double> normal;
    return Vec3(normal(random_), normal(random_), normal(random_)).normalized();
  }
  Pose RandomPose() { return {RotationBy(Number(0, kPi) * Direction()), Point()}; }

 private:
  std::mt19937_64 random_{2};
};

double Difference(const Pose& a, const Pose& b) {
  return (a.q.toRotationMatrix() - b.q.toRotationMatrix()).norm() + (a.p - b.p).norm();
}

// Computes the matrix exponential of [a]x, by scaling and its power series: no trigonometry, no
// quaternions.
Mat3 RotationBySeries(const Vec3& angle_axis) {
  const Mat3 step = CrossMatrix(angle_axis / 1024.0);
  Mat3 rotation = Mat3::Identity();
  Mat3 term = Mat3::Identity();
  for (int k = 1; k < 12; ++k) {
    term = term * step / k;
    rotation += term;
  }
  for (int doubling = 0; doubling < 10; ++doubling) rotation = rotation * rotation;
  return rotation;
}

TEST_F(Spatial, RotationByIsTheExponentialOfTheCrossMatrix) {
  for (const double angle : {0.0, 1e-12, 1e-9, 1e-5, 0.3, 2.0, kPi, 4.0, 2 * kPi}) {
    for (int i = 0; i < 20; ++i) {
      const Vec3 a = angle * Direction();
      EXPECT_LT((RotationBy(a).toRotationMatrix() - RotationBySeries(a)).norm(), 1e-11) << angle;
    }
  }
}

TEST_F(Spatial, RotationVectorInvertsRotationByBelowHalfATurn) {
  for (const double angle :
       {0.0, 1e-300, 1e-15, 1e-9, 2e-9, 1e-6, 1e-3, 1.0, 3.0, kPi - 1e-3, kPi - 1e-6, kPi - 1e-9}) {
    for (int i = 0; i < 20; ++i) {
      const Vec3 a = angle * Direction();
      EXPECT_LT((RotationVector(RotationBy(a)) - a).norm(), 1e-15 + 1e-14 * angle) << angle;
    }
  }
}

TEST_F(Spatial, HalfATurnMayUseEitherAxis) {
  for (int i = 0; i < 20; ++i) {
    const Vec3 axis = Direction();
    const Vec3 a = RotationVector(RotationBy(kPi * axis));
    EXPECT_NEAR(a.norm(), kPi, 1e-14);
    EXPECT_NEAR(std::abs(a.dot(axis)), kPi, 1e-14);
  }
}

TEST_F(Spatial, RotationVectorIsTheSameForBothQuaternionsOfARotation) {
  for (int i = 0; i < 100; ++i) {
    const Quat q = RotationBy(Number(0, 3) * Direction());
    const Quat opposite(-q.w(), -q.x(), -q.y(), -q.z());
    EXPECT_LT((RotationVector(q) - RotationVector(opposite)).norm(), 1e-14);
  }
}

TEST_F(Spatial, RotationVectorIsTheShortRotation) {
  const Vec3 axis = Direction();
  EXPECT_LT((RotationVector(RotationBy(1.5 * kPi * axis)) + 0.5 * kPi * axis).norm(), 1e-14);
}

TEST_F(Spatial, PosesComposeAsTheirMatricesDo) {
  for (int i = 0; i < 100; ++i) {
    const Pose X_AB = RandomPose();
    const Pose X_BC = RandomPose();
    const Vec3 p_CQ = Point();
    const auto matrix = [](const Pose& X) {
      Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
      m.topLeftCorner<3, 3>() = X.q.toRotationMatrix();
      m.topRightCorner<3, 1>() = X.p;
      return m;
    };
    const Eigen::Vector4d expected = matrix(X_AB) * matrix(X_BC) * p_CQ.homogeneous();
    EXPECT_LT(((X_AB * X_BC) * p_CQ - expected.head<3>()).norm(), 1e-14);
    EXPECT_LT((X_AB * (X_BC * p_CQ) - expected.head<3>()).norm(), 1e-14);
  }
}

TEST_F(Spatial, PoseAndItsInverseCancel) {
  for (int i = 0; i < 100; ++i) {
    const Pose X = RandomPose();
    EXPECT_LT(Difference(X * X.Inverse(), Pose{}), 1e-14);
    EXPECT_LT(Difference(X.Inverse() * X, Pose{}), 1e-14);
  }
}

TEST_F(Spatial, TheCrossMatrixIsTheCrossProduct) {
  for (int i = 0; i < 20; ++i) {
    const Vec3 a = Point();
    const Vec3 b = Point();
    EXPECT_LT((CrossMatrix(a) * b - a.cross(b)).norm(), 1e-15);
  }
}

TEST_F(Spatial, BoundsContainTheirPointsAndTouchingBoundsOverlap) {
  Bounds box;
  EXPECT_TRUE(box.empty());
  EXPECT_EQ(box.size(), Vec3(0, 0, 0));
  box.Add({1, -2, 3});
  EXPECT_FALSE(box.empty());
  box.Add({-1, 2, 5});
  EXPECT_EQ(box.size(), Vec3(2, 4, 2));
  EXPECT_EQ(box.centre(), Vec3(0, 0, 4));

  Bounds touching;
  touching.Add({1, 0, 0});
  touching.Add({2, 1, 3});
  EXPECT_TRUE(box.Overlaps(touching));
  Bounds apart;
  apart.Add({1.01, 0, 0});
  apart.Add({2, 1, 4});
  EXPECT_FALSE(box.Overlaps(apart));
}

}  // namespace
}  // namespace tandem
