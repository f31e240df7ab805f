#pragma once

#include <atomic>

namespace tandem::testing {

/// The controls and the memory of the fake of Force Dimension's library. A test sets how the device
/// behaves, and reads what the driver did.
struct FakeDhd {
  // the device's behaviour
  std::atomic<int> devices{1};
  std::atomic<int> type{33};
  std::atomic<bool> wrist{false};
  std::atomic<bool> active_wrist{false};
  std::atomic<bool> initialised{true};
  std::atomic<int> open_error{0};   // error of opening; 0: it opens
  std::atomic<int> auto_init{0};    // result of drdAutoInit()
  std::atomic<int> expert{0};       // result of dhdEnableExpertMode()
  std::atomic<int> read_result{0};  // result of reading the pose
  std::atomic<int> velocity_result{0};
  std::atomic<int> error{0};  // dhdErrorGetLast() after a failure
  std::atomic<int> connected{1};
  std::atomic<int> status_result{0};
  std::atomic<int> force_result{2};           // 2: a motor is at its limit, which is no error
  std::atomic<bool> acts_as_watchdog{false};  // after 20 ms without a force: force off, cause 3
  std::atomic<int> reset{1};
  std::atomic<int> force_off_cause{0};      // not 0: the device has switched its force off
  std::atomic<int> failing_stops{0};        // calls of dhdStop() that fail from now on
  std::atomic<int> hang_ms{0};              // duration of the next call for the pose
  std::atomic<double> x{0}, y{0}, z{0};     // m, in the vendor's axes
  std::atomic<double> vx{0}, vy{0}, vz{0};  // m/s
  std::atomic<double> turn_z{0};            // rad; turn about the vendor's z
  std::atomic<unsigned> buttons{0};

  // the driver's calls
  std::atomic<double> force[6]{};     // the newest, in the vendor's axes
  std::atomic<double> most_given{0};  // N, the largest component
  std::atomic<long> forces{0};
  std::atomic<long> poses{0};
  std::atomic<int> faults{0};  // number; fake_dhd.cpp lists the faults
  std::atomic<bool> opened{false};
  std::atomic<int> opens{0};
  std::atomic<int> closes{0};
  std::atomic<int> auto_inits{0};
  std::atomic<int> stops{0};
  std::atomic<bool> expert_on{false};
  std::atomic<int> watchdog{-1};  // 125 us
  std::atomic<double> most_force{-1};
  std::atomic<double> most_torque{-1};
  std::atomic<int> watchdog_trips{0};
  std::atomic<int> brakes{-1};
  std::atomic<int> gravity{-1};
  std::atomic<int> force_enabled{0};  // times
};

}  // namespace tandem::testing

extern "C" tandem::testing::FakeDhd* fake_dhd();
