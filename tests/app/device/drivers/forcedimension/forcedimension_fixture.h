#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <new>
#include <string>

#include <dlfcn.h>
#include <gtest/gtest.h>

#include "tests/app/device/driver_trial.h"
#include "tests/app/device/drivers/forcedimension/fake_dhd.h"

namespace tandem::testing {

/// The driver with a device of the fake library, and the force that a vendor's thread is given.
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

}  // namespace tandem::testing
