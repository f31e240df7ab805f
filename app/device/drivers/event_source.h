#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <string>
#include <thread>

#include <linux/input.h>

#include "app/device/tandem_device.h"

namespace tandem::driver {

/// A Linux input device, /dev/input/event*, read without waiting. A thread of its own opens it
/// again after it was unplugged, since that may take long. Take() is for the loop's thread, the
/// others for the main thread.
class EventSource {
 public:
  static constexpr int kMostEvents = 64;  // events of one Take()
  static constexpr int kReopenMs = 200;

  /// Returns whether an open file is a device of the kind.
  using IsKind = bool (*)(int file);

  EventSource() = default;
  ~EventSource();
  EventSource(const EventSource&) = delete;
  EventSource& operator=(const EventSource&) = delete;

  static constexpr const char* kEventFolder = "/dev/input";

  /// Opens a file; where `path` is empty, the first device of the kind. Returns the fault; empty:
  /// none.
  std::string Open(const std::string& path, IsKind is_kind, const char* kind);
  void Start();
  /// Gives each event that has come to `take`, without waiting. False: the device is gone.
  template <typename Function>
  bool Take(const Function& take) noexcept {
    const int file = file_.load(std::memory_order_acquire);
    if (file < 0) return false;
    input_event event{};
    for (int i = 0; i < kMostEvents; ++i) {
      const ReadResult got = Next(file, event);
      if (got == ReadResult::kNothing) return true;
      if (got == ReadResult::kGone) return false;
      take(event);
    }
    return true;
  }
  /// Returns whether the kernel reports a key as down; false where it cannot be asked.
  bool IsDown(int key) const noexcept;

  /// Fills in list()'s entries for a kind: each device, with the option that opens it where there
  /// are several, or what is missing. Returns the number of entries.
  static std::int32_t List(TandemDeviceFound* found, std::int32_t room, IsKind is_kind,
                           const char* kind, const std::string& folder = kEventFolder);

 private:
  enum class ReadResult : std::uint8_t { kEvent, kNothing, kGone };
  ReadResult Next(int file, input_event& event) noexcept;
  void Keep();

  std::string path_;  // as asked for; empty: the first device of the kind
  IsKind is_kind_ = nullptr;
  std::atomic<int> file_{-1};  // below 0: the device is gone
  std::atomic<int> gone_{-1};  // file for the keeper to close
  std::atomic<bool> over_{false};
  std::thread keeper_;
};

/// Return whether a file of /dev/input is a mouse or a keyboard.
bool IsMouse(int file);
bool IsKeyboard(int file);

}  // namespace tandem::driver
