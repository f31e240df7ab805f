#pragma once

#include <atomic>

namespace tandem::testing {

/// The controls and the memory of the fake of 3D Systems' libHD. A test sets how the device
/// behaves, and reads what the driver did.
struct FakeHd {
  // the device's behaviour
  std::atomic<bool> plugged{true};
  std::atomic<int> opens_as{0};          // 0: "Default Device"; 1: "Default PHANToM"; 2: "arm"
  std::atomic<unsigned> init_error{0};   // error of opening
  std::atomic<unsigned> frame_error{0};  // error of the next frame, once
  std::atomic<unsigned> later_error{0};  // second error of that frame, which is told first
  std::atomic<unsigned> refused_get{0};  // figure that the device has not: error 100
  std::atomic<unsigned> schedule_error{0};
  std::atomic<bool> refuses_rate{false};
  std::atomic<bool> scheduler_fails{false};
  std::atomic<unsigned> calibration{0x5000};
  std::atomic<int> style{4};
  std::atomic<int> output_dof{3};
  std::atomic<double> x_mm{10}, y_mm{20}, z_mm{30};
  std::atomic<double> vx_mm{0};   // mm/s
  std::atomic<double> turn_y{0};  // rad
  std::atomic<double> skew{0};    // skew of the rotation's second column
  std::atomic<int> buttons{0};
  std::atomic<double> temperature{0.1};
  std::atomic<int> hang_ms{0};  // duration of the scheduler's next turn

  // the driver's calls
  std::atomic<double> force[3]{};   // N, the newest
  std::atomic<double> torque[3]{};  // mN m
  std::atomic<long> frames{0};
  std::atomic<long> forces{0};
  std::atomic<double> most_given{0};  // N, the largest component
  std::atomic<int> faults{0};         // number; fake_hd.cpp lists the faults
  std::atomic<int> inits{0};
  std::atomic<int> disabled{0};
  std::atomic<int> updates{0};  // updates of the calibration
  std::atomic<unsigned> updated_style{0};
  std::atomic<bool> force_output{false};
  std::atomic<bool> running{false};
  std::atomic<int> priority{-1};
};

}  // namespace tandem::testing

extern "C" tandem::testing::FakeHd* fake_hd();
