#pragma once

#include <memory>
#include <string>

#include "app/device/drivers/driver_support.h"
#include "app/device/tandem_device.h"
#include "engine/haptics/device.h"

namespace tandem::driver {

/// Makes the table of a driver whose device is a class `Hand`, a Device that reports poses in the
/// scene. `Hand::kName`, `kKind` and `kOptions` are its texts; `Hand::Open(options, X_WB0)` opens
/// it.
template <typename Hand>
class ExportedDevice {
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
            StartDevice,
            Read,
            Write,
            Stop,
            LastError,
            nullptr};
  }

 private:
  struct OpenedDevice {
    std::unique_ptr<Device> device;
    bool begun = false;
  };
  static OpenedDevice& OpenOf(TandemDevice* device) {
    return *reinterpret_cast<OpenedDevice*>(device);
  }
  static std::string& Fault() {
    static std::string fault;
    return fault;
  }

  static std::int32_t Init(const TandemDeviceHost*) { return TANDEM_OK; }
  static void Deinit() {}
  static std::int32_t List(TandemDeviceFound* found, std::int32_t room) {
    if (room < 1) return 0;
    found->present = 1;
    Put(found->name, Hand::kName);
    Put(found->options, "");
    Put(found->missing, "");
    Put(found->mend, "");
    return 1;
  }
  static std::int32_t Open(const TandemDeviceOpen* how, TandemDevice** device) {
    const double* q = how->home_orientation;
    const Pose X_WB0{Quat(q[3], q[0], q[1], q[2]), Vec3(how->home_position)};
    Result<std::unique_ptr<Device>> opened = Hand::Open(how->options, X_WB0);
    if (!opened) {
      Fault() = opened.error().what;
      return TANDEM_FAILED;
    }
    *device = reinterpret_cast<TandemDevice*>(new OpenedDevice{*std::move(opened)});
    return TANDEM_OK;
  }
  static void Close(TandemDevice* device) { delete &OpenOf(device); }
  static std::int32_t Capabilities(TandemDevice* device, TandemDeviceCapabilities* reported) {
    const DeviceCapabilities can = OpenOf(device).device->capabilities();
    const auto any_as_zero = [](double gain) {
      return gain == DeviceCapabilities::kAny ? 0.0 : gain;
    };
    reported->freedoms_in = static_cast<std::uint32_t>(can.freedoms_in);
    reported->freedoms_out = static_cast<std::uint32_t>(can.freedoms_out);
    reported->in_scene = 1;
    reported->rate_hz = can.rate_hz;
    reported->peak_force = can.peak.force;
    reported->peak_moment = can.peak.moment;
    reported->continuous_force = can.continuous.force;
    reported->continuous_moment = can.continuous.moment;
    reported->stiffness = any_as_zero(can.stiffness);
    reported->damping = any_as_zero(can.damping);
    reported->rotation_stiffness = any_as_zero(can.rotation_stiffness);
    reported->rotation_damping = any_as_zero(can.rotation_damping);
    return TANDEM_OK;
  }
  static std::int32_t StartDevice(TandemDevice*) { return TANDEM_OK; }
  static std::int32_t Read(TandemDevice* device, TandemDeviceState* state) {
    const Anchor handle = OpenOf(device).device->Read();
    state->valid = TANDEM_HAS_POSE | TANDEM_HAS_VELOCITY;
    for (int i = 0; i < 3; ++i) {
      state->position[i] = handle.X_WA.p[i];
      state->velocity[i] = handle.V_WA.v[i];
      state->angular_velocity[i] = handle.V_WA.w[i];
    }
    for (int i = 0; i < 4; ++i) state->orientation[i] = handle.X_WA.q.coeffs()[i];
    return TANDEM_OK;
  }
  static std::int32_t Write(TandemDevice* device, const TandemDeviceForce* force) {
    OpenedDevice& open = OpenOf(device);
    if (force->begun != 0 && !open.begun) {
      open.begun = true;
      open.device->Start();
    }
    open.device->Render({Vec3(force->moment), Vec3(force->force)});
    return TANDEM_OK;
  }
  static void Stop(TandemDevice* device) { OpenOf(device).device->Stop(); }
  static std::int32_t LastError(TandemDevice*, char* text, std::uint32_t room) {
    return Put(text, room, Fault());
  }
};

}  // namespace tandem::driver
