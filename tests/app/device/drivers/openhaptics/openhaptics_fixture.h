#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <new>
#include <string>

#include <dlfcn.h>
#include <gtest/gtest.h>

#include "tests/app/device/driver_trial.h"
#include "tests/app/device/drivers/openhaptics/fake_hd.h"
#include "tests/support/scratch_folder.h"

namespace tandem::testing {

/// The driver with a device of the fake library, and the force that a vendor's thread is given.
class OpenHapticsTest : public ::testing::Test {
 protected:
  OpenHapticsTest() {
    setenv("TANDEM_LIBHD", TANDEM_FAKE_LIBHD, 1);
    setenv("GTDD_HOME", folder_.path().c_str(), 1);
    std::filesystem::create_directory(folder_.path() / "config");
    std::ofstream(folder_.path() / "config" / "Default Device.config") << "fake";
    void* library = dlopen(TANDEM_FAKE_LIBHD, RTLD_NOW | RTLD_LOCAL);
    EXPECT_NE(library, nullptr);
    fake_ = reinterpret_cast<FakeHd* (*)()>(dlsym(library, "fake_hd"))();
    reinterpret_cast<void (*)()>(dlsym(library, "fake_hd_forget"))();
    fake_->~FakeHd();
    new (fake_) FakeHd;  // each test begins with a new device
    trial_ = std::make_unique<DriverTrial>("openhaptics");
    trial_->SetTake([this](TandemDeviceForce& force) {
      for (int i = 0; i < 3; ++i) {
        force.force[i] = wanted_[static_cast<std::size_t>(i)];
        force.moment[i] = wanted_[static_cast<std::size_t>(3 + i)];
      }
    });
  }
  ~OpenHapticsTest() override {
    trial_.reset();
    EXPECT_EQ(fake_->faults, 0);
    EXPECT_FALSE(fake_->running);
  }
  void OpenAndStart(const std::string& options = "") {
    ASSERT_EQ(trial_->Open(options), TANDEM_OK) << trial_->Error();
    ASSERT_EQ(trial_->Start(), TANDEM_OK) << trial_->Error();
    ASSERT_TRUE(trial_->TicksUntil([&] {
      return trial_->state().valid != 0 || trial_->read() < 0;
    }));
  }
  bool Reads(std::int32_t result) {
    return trial_->TicksUntil([&] {
      return trial_->read() == result;
    });
  }
  bool Gives(const Vec3& force_N) {
    return trial_->TicksUntil([&] {
      return (Given() - force_N).norm() < 1e-9;
    });
  }
  Vec3 Given() const { return {fake_->force[0], fake_->force[1], fake_->force[2]}; }

  const ScratchFolder folder_;
  FakeHd* fake_;
  std::unique_ptr<DriverTrial> trial_;
  std::array<std::atomic<double>, 6> wanted_{};
};

}  // namespace tandem::testing
