// The driver `forcedimension` against a library with the published interface of Force Dimension's.
// Faults that are injected (numbers: the library's error codes):
//
// | fault | test |
// |---|---|
// | no library; one without a function | SaysWhatIsMissingAndWhatMendsIt |
// | no device (5) | SaysWhatIsMissingAndWhatMendsIt, SaysWhyADeviceDoesNotOpen |
// | no right (4), busy (3), in use (20) | SaysWhyADeviceDoesNotOpen |
// | expert mode (9), and with it the watchdog, refused | SaysWhyADeviceDoesNotOpen |
// | no reference; the arm may not move itself | WithoutItsReferenceItIsUncalibrated |
// | the arm may move itself, and does not find its reference | MovesTheArmWhereThatIsAllowedAlone |
// | results 1 (time guard), 2 (saturated) | ReadsTheHandleInItsAxesAndGivesTheForce |
// | a pose that stands still | ReadsTheHandleInItsAxesAndGivesTheForce |
// | no velocity yet (fewer than two reads) | LeavesTheSpeedToTheHostWhileTheLibraryHasNone |
// | force button, over-speed, watchdog, USB, dead man | SaysWhyTheDeviceHasSwitchedItsForceOff |
// | a read that fails (12), a force that does | AFailedCallIsAFailureAndPasses |
// | a call of 60 ms, by which the watchdog ends the force | ACallThatHangsIsAFailureAndPasses |
// | communication error (2), no device (5), timeout (7) | AnUnpluggedDeviceIsFoundAgain |
// | unplugged by the status; plugged in again | AnUnpluggedDeviceIsFoundAgain |
// | plugged in again without its reference | ADeviceThatIsBackGetsNoForceBeforeItsStateIsKnown |
// | dhdStop() that fails | EndsTheForceHoweverOftenTheStopFails |
// | a force that is no number | WritesNoForceThatIsNone |
// | calls of a wrong device, order, thread or unit | counted by the fake in every test |
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <memory>
#include <new>
#include <thread>
#include <utility>

#include <dlfcn.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/app/device/driver_trial.h"
#include "tests/app/device/drivers/forcedimension/fake_dhd.h"

namespace tandem::testing {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

class ForceDimensionTest : public ::testing::Test {
 protected:
  ForceDimensionTest() {
    setenv("FDSDK", TANDEM_FAKE_SDK, 1);
    void* library = dlopen(TANDEM_FAKE_SDK "/lib/libdrd.so", RTLD_NOW | RTLD_LOCAL);
    EXPECT_NE(library, nullptr);
    const auto fake_of = reinterpret_cast<FakeDhd* (*)()>(dlsym(library, "fake_dhd"));
    fake_ = fake_of();
    fake_->~FakeDhd();
    new (fake_) FakeDhd;  // each test begins with a new device
    trial_ = std::make_unique<DriverTrial>("forcedimension");
    trial_->SetTake([this](TandemDeviceForce& force) {
      for (int i = 0; i < 3; ++i) {
        force.force[i] = wanted_[i];
        force.moment[i] = wanted_[3 + i];
      }
    });
  }
  ~ForceDimensionTest() override {
    trial_.reset();
    EXPECT_EQ(fake_->faults, 0);
    EXPECT_FALSE(fake_->opened);
  }
  void OpenAndStart(const std::string& options = "") {
    ASSERT_EQ(trial_->Open(options), TANDEM_OK) << trial_->Error();
    trial_->Capabilities();
    ASSERT_EQ(trial_->Start(), TANDEM_OK);
    ASSERT_TRUE(trial_->TicksUntil([&] {
      return trial_->state().valid != 0;
    }));
  }
  bool Reads(std::int32_t result) {
    return trial_->TicksUntil([&] {
      return trial_->read() == result;
    });
  }
  /// Returns the force that the device got last, in V's axes.
  Vec3 Given() const { return {fake_->force[1], fake_->force[2], fake_->force[0]}; }

  FakeDhd* fake_;
  std::unique_ptr<DriverTrial> trial_;
  std::array<std::atomic<double>, 6> wanted_{};
};

TEST_F(ForceDimensionTest, SaysWhatIsMissingAndWhatMendsIt) {
  auto found = trial_->List();
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].present, 1U);
  fake_->devices = 2;
  found = trial_->List();
  ASSERT_EQ(found.size(), 2U);
  EXPECT_STREQ(found[1].options, "device=1");
  fake_->devices = 0;
  found = trial_->List();
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].present, 0U);
  EXPECT_THAT(found[0].mend, HasSubstr("udev"));
  setenv("FDSDK", "/nonexistent", 1);
  found = trial_->List();
  ASSERT_EQ(found.size(), 1U);
  EXPECT_THAT(found[0].missing, HasSubstr("libdrd"));
  EXPECT_THAT(found[0].mend, HasSubstr("FDSDK"));
  EXPECT_EQ(fake_->opens, 0);
  EXPECT_EQ(trial_->Open("library=libm.so.6"), TANDEM_FAILED);
  EXPECT_THAT(trial_->Error(), HasSubstr("no function dhdGetDeviceCount"));
}

TEST_F(ForceDimensionTest, SaysWhyADeviceDoesNotOpen) {
  for (const int code : {3, 20}) {
    fake_->open_error = code;
    EXPECT_EQ(trial_->Open(""), TANDEM_FAILED);
    EXPECT_THAT(trial_->Error(), HasSubstr("end the other program"));
  }
  fake_->open_error = 4;
  EXPECT_EQ(trial_->Open(""), TANDEM_FAILED);
  EXPECT_THAT(trial_->Error(), HasSubstr("has no right"));
  fake_->open_error = 0;
  EXPECT_EQ(trial_->Open("device=7"), TANDEM_FAILED);
  EXPECT_THAT(trial_->Error(), HasSubstr("plug it in"));
  fake_->expert = -1;
  EXPECT_EQ(trial_->Open(""), TANDEM_FAILED);
  EXPECT_THAT(trial_->Error(), HasSubstr("watchdog"));
  EXPECT_EQ(trial_->Open("speed=3"), TANDEM_FAILED);
  EXPECT_THAT(trial_->Error(), HasSubstr("'speed' is none of its options"));
}

TEST_F(ForceDimensionTest, ReadsTheHandleInItsAxesAndGivesTheForce) {
  fake_->x = 0.01;  // to the person
  fake_->y = 0.02;  // right
  fake_->z = 0.03;  // up
  fake_->vy = 0.5;
  fake_->wrist = true;
  fake_->turn_z = 0.3;
  fake_->read_result = 1;  // the time guard's: no error
  OpenAndStart();
  EXPECT_LT((trial_->position() - Vec3(0.02, 0.03, 0.01)).norm(), 1e-12);
  EXPECT_EQ(trial_->state().velocity[0], 0.5);
  // a turn about the vendor's z, upwards, is one about V's y
  const double* q = trial_->state().orientation;
  EXPECT_NEAR(q[1], std::sin(0.15), 1e-9);
  EXPECT_NEAR(q[3], std::cos(0.15), 1e-9);
  wanted_[0] = 1;
  wanted_[1] = 2;
  wanted_[2] = 3;
  wanted_[3] = 0.1;  // this wrist has no motors
  EXPECT_TRUE(trial_->TicksUntil([&] {
    return Given() == Vec3(1, 2, 3);
  }));
  EXPECT_EQ(fake_->force[4], 0);
  // it stands still, and goes on when it does not
  trial_->Ticks(30);
  fake_->y = 0.05;
  EXPECT_TRUE(trial_->TicksUntil([&] {
    return trial_->position().x() == 0.05;
  }));
  trial_->Ticks(500);
  trial_->ExpectRealtime();
}

TEST_F(ForceDimensionTest, SaysWhatItCanAndSetsTheDevicesOwnGuards) {
  fake_->type = 104;
  fake_->wrist = true;
  fake_->active_wrist = true;
  OpenAndStart();
  const TandemDeviceCapabilities can = trial_->Capabilities();
  EXPECT_EQ(can.freedoms_in, 6U);
  EXPECT_EQ(can.freedoms_out, 6U);
  EXPECT_EQ(can.asks, 1U);
  EXPECT_EQ(can.peak_force, 12);
  EXPECT_EQ(can.peak_moment, 0.2);
  EXPECT_EQ(fake_->watchdog, 160);  // 20 ms
  EXPECT_EQ(fake_->most_force, 12);
  EXPECT_EQ(fake_->most_torque, 0.2);
  EXPECT_EQ(fake_->gravity, 1);
  wanted_[4] = 0.1;  // about V's y, the vendor's z
  EXPECT_TRUE(trial_->TicksUntil([&] {
    return fake_->force[5] == 0.1;
  }));
}

TEST_F(ForceDimensionTest, KnowsWhatEachModelGives) {
  const std::pair<int, double> models[] = {{34, 12}, {36, 12}, {60, 8}, {63, 20}, {109, 12}};
  for (const auto& [type, force_N] : models) {
    fake_->type = type;
    ASSERT_EQ(trial_->Open(""), TANDEM_OK);
    EXPECT_EQ(trial_->Capabilities().peak_force, force_N) << type;
    EXPECT_EQ(fake_->most_force, force_N) << type;
    EXPECT_EQ(trial_->Capabilities().freedoms_in, 3U);
    EXPECT_EQ(trial_->Capabilities().moves_by_itself, 0U);
    trial_->Close();
  }
}

TEST_F(ForceDimensionTest, LeavesTheSpeedToTheHostWhileTheLibraryHasNone) {
  fake_->velocity_result = -1;
  OpenAndStart();
  EXPECT_EQ(trial_->state().valid, std::uint32_t{TANDEM_HAS_POSE});
  fake_->velocity_result = 0;
  EXPECT_TRUE(trial_->TicksUntil([&] {
    return (trial_->state().valid & TANDEM_HAS_VELOCITY) != 0;
  }));
}

TEST_F(ForceDimensionTest, ButtonsAreTheClutchAndTheStopAsAsked) {
  OpenAndStart("clutch=1,stop=0");
  fake_->buttons = 2;
  EXPECT_TRUE(trial_->TicksUntil([&] {
    return trial_->state().buttons == TANDEM_BUTTON_CLUTCH;
  }));
  fake_->buttons = 1;
  EXPECT_TRUE(trial_->TicksUntil([&] {
    return trial_->state().buttons == TANDEM_BUTTON_STOP;
  }));
}

TEST_F(ForceDimensionTest, WithoutItsReferenceItIsUncalibrated) {
  OpenAndStart();
  EXPECT_EQ(fake_->auto_inits, 0);
  fake_->reset = 0;
  EXPECT_TRUE(Reads(TANDEM_UNCALIBRATED));
  EXPECT_THAT(trial_->Error(), HasSubstr("calibrate=yes"));
  fake_->reset = 1;
  EXPECT_TRUE(Reads(TANDEM_OK));
}

TEST_F(ForceDimensionTest, MovesTheArmWhereThatIsAllowedAlone) {
  fake_->initialised = false;
  fake_->auto_init = -1;
  ASSERT_EQ(trial_->Open("calibrate=yes"), TANDEM_OK);
  EXPECT_EQ(fake_->auto_inits, 0);  // only start() moves it
  EXPECT_EQ(trial_->Start(), TANDEM_FAILED);
  EXPECT_THAT(trial_->Error(), HasSubstr("did not find its reference"));
  EXPECT_THAT(trial_->said(), Contains(HasSubstr("the arm moves itself now")));
  trial_->Close();
  fake_->auto_init = 0;
  OpenAndStart("calibrate=yes");
  wanted_[0] = 1;
  EXPECT_TRUE(trial_->TicksUntil([&] {
    return Given() == Vec3(1, 0, 0);
  }));
  EXPECT_EQ(trial_->Capabilities().moves_by_itself, 1U);
  EXPECT_EQ(fake_->auto_inits, 2);
}

TEST_F(ForceDimensionTest, SaysWhyTheDeviceHasSwitchedItsForceOff) {
  OpenAndStart();
  wanted_[0] = 2;
  const std::pair<int, const char*> causes[] = {
      {1, "force button"}, {2, "too fast"}, {3, "20 ms"}, {5, "USB"}, {6, "take hold"}};
  for (const auto& [cause, words] : causes) {
    fake_->vx = cause == 2 ? 1.0 : 0.0;
    trial_->Ticks(5);
    const int enabled = fake_->force_enabled;
    fake_->force_off_cause = cause;
    EXPECT_TRUE(Reads(TANDEM_FAILED)) << cause;
    EXPECT_THAT(trial_->Error(), HasSubstr(words));
    EXPECT_TRUE(trial_->TicksUntil([&] {
      return Given().isZero();
    }));
    trial_->Ticks(50);
    // a person's own switch is left alone, and so is a brake while the handle is fast
    const bool waits = cause == 1 || cause == 2 || cause == 6;
    EXPECT_EQ(fake_->force_enabled > enabled, !waits) << cause;
    if (cause == 2) {
      fake_->vx = 0;
      EXPECT_TRUE(trial_->TicksUntil([&] {
        return fake_->force_enabled > enabled;
      }));
    }
    fake_->force_off_cause = 0;
    EXPECT_TRUE(Reads(TANDEM_OK)) << cause;
  }
}

TEST_F(ForceDimensionTest, AFailedCallIsAFailureAndPasses) {
  OpenAndStart();
  fake_->error = 12;
  for (std::atomic<int>* result : {&fake_->read_result, &fake_->force_result}) {
    *result = -1;
    EXPECT_TRUE(Reads(TANDEM_FAILED));
    trial_->Ticks(50);
    EXPECT_EQ(trial_->read(), TANDEM_FAILED);
    EXPECT_THAT(trial_->Error(), HasSubstr("a call to the device failed"));
    *result = 0;
    EXPECT_TRUE(Reads(TANDEM_OK));
  }
  EXPECT_EQ(fake_->closes, 0);
}

TEST_F(ForceDimensionTest, ACallThatHangsIsAFailureAndPasses) {
  OpenAndStart();
  fake_->acts_as_watchdog = true;
  fake_->hang_ms = 60;
  EXPECT_TRUE(Reads(TANDEM_FAILED));
  EXPECT_THAT(trial_->Error(), HasSubstr("hangs"));
  EXPECT_TRUE(trial_->TicksUntil([&] {
    return fake_->watchdog_trips > 0 && fake_->force_off_cause == 0;
  }));
  EXPECT_TRUE(Reads(TANDEM_OK));  // it was switched on again
  trial_->ExpectRealtime();       // read() did not wait for the call
}

TEST_F(ForceDimensionTest, AnUnpluggedDeviceIsFoundAgain) {
  OpenAndStart();
  int opens = fake_->opens;
  fake_->connected = 0;
  EXPECT_TRUE(Reads(TANDEM_UNPLUGGED));
  EXPECT_THAT(trial_->Error(), HasSubstr("plug it in"));
  fake_->connected = 1;
  fake_->y = 0.07;
  EXPECT_TRUE(Reads(TANDEM_OK));
  EXPECT_EQ(trial_->position().x(), 0.07);
  EXPECT_EQ(fake_->opens, opens + 1);
  EXPECT_EQ(fake_->closes, 1);
  // unplugged by errors alone
  fake_->status_result = -1;
  for (const int code : {2, 5, 7}) {
    opens = fake_->opens;
    fake_->error = code;
    fake_->read_result = -1;
    EXPECT_TRUE(Reads(TANDEM_UNPLUGGED)) << code;
    EXPECT_THAT(trial_->Error(), HasSubstr("does not answer"));
    fake_->read_result = 0;
    fake_->status_result = 0;
    EXPECT_TRUE(Reads(TANDEM_OK)) << code;
    EXPECT_EQ(fake_->opens, opens + 1) << code;
  }
  wanted_[1] = 1;
  EXPECT_TRUE(trial_->TicksUntil([&] {
    return Given() == Vec3(0, 1, 0);
  }));
}

TEST_F(ForceDimensionTest, ADeviceThatIsBackGetsNoForceBeforeItsStateIsKnown) {
  OpenAndStart();
  wanted_[0] = 2;
  EXPECT_TRUE(trial_->TicksUntil([&] {
    return Given().x() == 2;
  }));
  fake_->connected = 0;
  EXPECT_TRUE(Reads(TANDEM_UNPLUGGED));
  fake_->most_given = 0;
  fake_->reset = 0;  // it was switched off and on
  fake_->connected = 1;
  EXPECT_TRUE(Reads(TANDEM_UNCALIBRATED));
  trial_->Ticks(20);
  EXPECT_EQ(fake_->most_given, 0);
  fake_->reset = 1;
  EXPECT_TRUE(Reads(TANDEM_OK));
  EXPECT_TRUE(trial_->TicksUntil([&] {
    return Given().x() == 2;
  }));
}

TEST_F(ForceDimensionTest, AStopIsZeroUntilTheNextWrite) {
  OpenAndStart();
  wanted_[0] = 2;
  EXPECT_TRUE(trial_->TicksUntil([&] {
    return Given().x() == 2;
  }));
  trial_->Stop();
  for (int i = 0; i < 500 && !Given().isZero(); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_TRUE(Given().isZero());
  trial_->Ticks(1);
  EXPECT_TRUE(trial_->TicksUntil([&] {
    return Given().x() == 2;
  }));
}

TEST_F(ForceDimensionTest, WritesNoForceThatIsNone) {
  OpenAndStart();
  wanted_[0] = std::numeric_limits<double>::quiet_NaN();
  wanted_[1] = 1;
  const long forces = fake_->forces;
  EXPECT_TRUE(trial_->TicksUntil([&] {
    return fake_->forces > forces + 3;
  }));
  EXPECT_TRUE(Given().isZero());
}

TEST_F(ForceDimensionTest, EndsTheForceHoweverOftenTheStopFails) {
  OpenAndStart();
  wanted_[0] = 2;
  EXPECT_TRUE(trial_->TicksUntil([&] {
    return Given().x() == 2;
  }));
  fake_->failing_stops = 5;
  trial_->Close();
  EXPECT_EQ(fake_->stops, 6);
  EXPECT_TRUE(Given().isZero());
  EXPECT_FALSE(fake_->opened);
}

}  // namespace
}  // namespace tandem::testing
