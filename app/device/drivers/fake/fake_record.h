#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

namespace tandem {

/// The wrenches that the motor of the driver `fake` got, in a file that outlives the process.
/// Written by the device process, read by tests.
struct FakeRecord {
  static constexpr std::size_t kRoom = 1U << 16U;  // writes; older ones are overwritten

  struct Write {
    std::int64_t ns = 0;  // monotonic
    std::array<double, 3> force_N{};
    std::array<double, 3> moment_Nm{};
  };

  std::atomic<std::uint64_t> count{0};
  std::array<Write, kRoom> writes{};
};

}  // namespace tandem
