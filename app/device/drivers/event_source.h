#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <string>
#include <thread>

#include <linux/input.h>

#include "app/device/tandem_device.h"

namespace tandem::driver {

/// An input device of Linux, /dev/input/event*, that is read without waiting. A thread of its own
/// opens it anew where it was unplugged: opening may take long. Take() is for the loop's thread,
/// all else for the main thread.
class EventSource {
 public:
  static constexpr int kMostEvents = 64;  // that one Take() gives
  static constexpr int kReopenMs = 200;

  /// What makes a device one of the kind: whether the file that is open is one.
  using IsKind = bool (*)(int file);

  EventSource() = default;
  ~EventSource();
  EventSource(const EventSource&) = delete;
  EventSource& operator=(const EventSource&) = delete;

  static constexpr const char* kEventFolder = "/dev/input";

  /// Opens a file, or where `path` is empty the first device of the kind. Returns the fault; empty:
  /// none.
  std::string Open(const std::string& path, IsKind is_kind, const char* kind);
  void Start();
  /// Gives each event that has come to `take`, without waiting; false: the device is gone.
  template <typename Function>
  bool Take(const Function& take) noexcept {
    const int file = file_.load(std::memory_order_acquire);
    if (file < 0) return false;
    input_event event{};
    for (int i = 0; i < kMostEvents; ++i) {
      const Got got = Next(file, event);
      if (got == Got::kNothing) return true;
      if (got == Got::kGone) return false;
      take(event);
    }
    return true;
  }
  /// Whether a key is down, as the kernel says; false where it cannot be asked.
  bool IsDown(int key) const noexcept;

  /// Fills in what list() says of devices of the kind: each, with the option that opens it where
  /// there are several, or what is missing. Returns how many entries were filled in.
  static std::int32_t List(TandemDeviceFound* found, std::int32_t room, IsKind is_kind,
                           const char* kind, const std::string& folder = kEventFolder);

 private:
  enum class Got : std::uint8_t { kEvent, kNothing, kGone };
  Got Next(int file, input_event& event) noexcept;
  void Keep();

  std::string path_;  // as asked for; empty: the first of the kind
  IsKind is_kind_ = nullptr;
  std::atomic<int> file_{-1};  // below 0: gone
  std::atomic<int> gone_{-1};  // file that the keeper is to close
  std::atomic<bool> over_{false};
  std::thread keeper_;
};

/// Whether a file of /dev/input is a mouse, a keyboard.
bool IsMouse(int file);
bool IsKeyboard(int file);

}  // namespace tandem::driver
