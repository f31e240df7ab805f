#pragma once

#include <cstdint>
#include <exception>
#include <memory>
#include <string>

#include "app/device/drivers/driver_support.h"
#include "app/device/tandem_device.h"

namespace tandem::driver {

/// Makes the table of a driver whose device is a class `Hand`. No exception leaves C++: where a
/// function for the main thread throws, it fails with the exception's text as the reason. Hand has
///
/// | member | thread |
/// |---|---|
/// | `kName`, `kKind`, `kOptions` | – |
/// | `static std::int32_t List(TandemDeviceFound*, std::int32_t room)` | main |
/// | `static std::unique_ptr<Hand> Open(options, host, fault)` | main |
/// | `std::string Capabilities(TandemDeviceCapabilities&)`, `Start()` | main |
/// | `std::string Trouble() const` | main |
/// | `std::int32_t Read(TandemDeviceState&) noexcept`, `Write(const TandemDeviceForce&)` | loop |
/// | `void Stop() noexcept` | any |
///
/// Open() takes a `const char*`, a `const TandemDeviceHost&` and a `std::string&`; null: it failed.
/// The texts of Capabilities() and Start() are the fault. The text of Trouble() is empty if there
/// is none.
template <typename Hand>
class DriverTable {
 public:
  static constexpr TandemDriver Table() {
    return {sizeof(TandemDriver),
            TANDEM_DEVICE_ABI_MAJOR,
            TANDEM_DEVICE_ABI_MINOR,
            0,
            Hand::kName,
            Hand::kKind,
            Hand::kOptions,
            Init,
            Deinit,
            List,
            Open,
            Close,
            Capabilities,
            Start,
            Read,
            Write,
            Stop,
            LastError,
            nullptr};
  }

 private:
  static Hand& HandOf(TandemDevice* device) { return *reinterpret_cast<Hand*>(device); }
  static std::string& Fault() {
    static std::string fault;
    return fault;
  }
  static const TandemDeviceHost*& Host() {
    static const TandemDeviceHost* host = nullptr;
    return host;
  }
  /// Runs a function for the main thread. Its text is the fault.
  template <typename Function>
  static std::int32_t Guarded(const Function& function) noexcept {
    try {
      try {
        Fault() = function();
      } catch (const std::exception& thrown) {
        Fault() = thrown.what();
      }
      return Fault().empty() ? TANDEM_OK : TANDEM_FAILED;
    } catch (...) {
      return TANDEM_FAILED;
    }
  }

  static std::int32_t Init(const TandemDeviceHost* host) noexcept {
    Host() = host;
    return TANDEM_OK;
  }
  static void Deinit() noexcept {}
  static std::int32_t List(TandemDeviceFound* found, std::int32_t room) noexcept {
    std::int32_t count = 0;
    Guarded([&] {
      count = Hand::List(found, room);
      return std::string();
    });
    return count;
  }
  static std::int32_t Open(const TandemDeviceOpen* how, TandemDevice** device) noexcept {
    *device = nullptr;
    return Guarded([&] {
      std::string fault;
      std::unique_ptr<Hand> hand = Hand::Open(how->options, *Host(), fault);
      if (hand == nullptr) return fault.empty() ? std::string("the device does not open") : fault;
      *device = reinterpret_cast<TandemDevice*>(hand.release());
      return std::string();
    });
  }
  static void Close(TandemDevice* device) noexcept { delete &HandOf(device); }
  static std::int32_t Capabilities(TandemDevice* device, TandemDeviceCapabilities* can) noexcept {
    return Guarded([&] {
      return HandOf(device).Capabilities(*can);
    });
  }
  static std::int32_t Start(TandemDevice* device) noexcept {
    return Guarded([&] {
      return HandOf(device).Start();
    });
  }
  static std::int32_t Read(TandemDevice* device, TandemDeviceState* state) noexcept {
    return HandOf(device).Read(*state);
  }
  static std::int32_t Write(TandemDevice* device, const TandemDeviceForce* force) noexcept {
    return HandOf(device).Write(*force);
  }
  static void Stop(TandemDevice* device) noexcept { HandOf(device).Stop(); }
  static std::int32_t LastError(TandemDevice* device, char* text, std::uint32_t room) noexcept {
    try {
      const std::string trouble = device == nullptr ? std::string() : HandOf(device).Trouble();
      return Put(text, room, trouble.empty() ? Fault() : trouble);
    } catch (...) {
      return TANDEM_FAILED;
    }
  }
};

}  // namespace tandem::driver
