// The driver `forcedimension` against a library with the published interface of Force Dimension's.
// Faults that are injected:
//
// | fault | test |
// |---|---|
// | no library; one without a function | SaysWhatIsMissingAndWhatMendsIt |
// | no device; no right (4); busy (3) | SaysWhatIsMissingAndWhatMendsIt, SaysWhyADeviceDoesNotOpen
// | | expert mode, and with it the watchdog, refused (9) | SaysWhyADeviceDoesNotOpen | | not
// initialised; the arm may not move itself, or may and fails | WithoutItsReferenceItIsUncalibrated,
// MovesTheArmWhereThatIsAllowedAlone | | results 1 (time guard) and 2 (motor saturated) |
// ReadsTheHandleInItsAxesAndGivesTheForce | | no velocity yet (fewer than two reads) |
// LeavesTheSpeedToTheHostWhileTheLibraryHasNone | | force button off, over-speed brake, watchdog,
// USB, dead-man switch | SaysWhyTheDeviceHasSwitchedItsForceOff | | a call that fails (12), a call
// of 60 ms | AFailedCallAndOneThatHangsAreFailuresAndPass | | a pose that stands still |
// ReadsTheHandleInItsAxesAndGivesTheForce | | communication error (2), unplugged, plugged in again
// | AnUnpluggedDeviceIsFoundAgain | | dhdStop() that fails | EndsTheForceHoweverOftenTheStopFails |
// | a force that is no number | WritesNoForceThatIsNone |
// | another device's id, a force before the watchdog is set | counted by the fake in every test |
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
  /// V's force that the device got last.
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
  fake_->open_error = 3;
  EXPECT_EQ(trial_->Open(""), TANDEM_FAILED);
  EXPECT_THAT(trial_->Error(), HasSubstr("end the other program"));
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
  EXPECT_EQ(trial_->Open("calibrate=yes"), TANDEM_FAILED);
  EXPECT_THAT(trial_->Error(), HasSubstr("did not find its reference"));
  fake_->auto_init = 0;
  OpenAndStart("calibrate=yes");
  EXPECT_EQ(trial_->Capabilities().moves_by_itself, 1U);
  EXPECT_EQ(fake_->auto_inits, 2);
}

TEST_F(ForceDimensionTest, SaysWhyTheDeviceHasSwitchedItsForceOff) {
  OpenAndStart();
  wanted_[0] = 2;
  const std::pair<int, const char*> causes[] = {
      {1, "force button"}, {2, "too fast"}, {3, "20 ms"}, {5, "USB"}, {6, "take hold"}};
  for (const auto& [cause, words] : causes) {
    fake_->force_off_cause = cause;
    const int enabled = fake_->force_enabled;
    EXPECT_TRUE(Reads(TANDEM_FAILED)) << cause;
    EXPECT_THAT(trial_->Error(), HasSubstr(words));
    EXPECT_TRUE(trial_->TicksUntil([&] {
      return Given().isZero() && fake_->force_enabled > enabled;
    }));
    fake_->force_off_cause = 0;
    EXPECT_TRUE(Reads(TANDEM_OK)) << cause;
  }
}

TEST_F(ForceDimensionTest, AFailedCallAndOneThatHangsAreFailuresAndPass) {
  OpenAndStart();
  fake_->error = 12;
  fake_->read_result = -1;
  EXPECT_TRUE(Reads(TANDEM_FAILED));
  trial_->Ticks(50);
  EXPECT_EQ(trial_->read(), TANDEM_FAILED);
  fake_->read_result = 0;
  EXPECT_TRUE(Reads(TANDEM_OK));
  fake_->hang_ms = 60;
  EXPECT_TRUE(Reads(TANDEM_FAILED));
  EXPECT_TRUE(Reads(TANDEM_OK));
  trial_->ExpectRealtime();  // read() did not wait for it
}

TEST_F(ForceDimensionTest, AnUnpluggedDeviceIsFoundAgain) {
  OpenAndStart();
  const int opens = fake_->opens;
  fake_->connected = 0;
  EXPECT_TRUE(Reads(TANDEM_UNPLUGGED));
  EXPECT_THAT(trial_->Error(), HasSubstr("plug it in"));
  fake_->connected = 1;
  fake_->y = 0.07;
  EXPECT_TRUE(Reads(TANDEM_OK));
  EXPECT_EQ(trial_->position().x(), 0.07);
  EXPECT_EQ(fake_->opens, opens + 1);
  EXPECT_EQ(fake_->closes, 1);
  wanted_[1] = 1;
  EXPECT_TRUE(trial_->TicksUntil([&] {
    return Given() == Vec3(0, 1, 0);
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
