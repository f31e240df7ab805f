// A device in another process or on another machine, by UDP. docs/devices.md describes the packets.
#include <algorithm>
#include <array>
#include <cstdio>
#include <memory>
#include <string>

#include "app/device/drivers/driver_support.h"
#include "app/device/drivers/driver_table.h"
#include "app/device/drivers/network/address.h"
#include "app/device/drivers/network/key.h"
#include "app/device/drivers/network/link.h"
#include "app/device/drivers/network/session.h"
#include "engine/realtime/clock.h"

namespace tandem::driver::network {
namespace {

constexpr const char* kHere = "127.0.0.1:47111";

class NetworkDevice {
 public:
  static constexpr const char* kName = "network";
  static constexpr const char* kKind = "a device in another process or machine, by UDP";
  static constexpr const char* kOptions =
      "listen=127.0.0.1:47111,key=FILE,wait=10,stale_ms=100,expiry_ms=20";

  ~NetworkDevice();
  static std::int32_t List(TandemDeviceFound* found, std::int32_t room);
  static std::unique_ptr<NetworkDevice> Open(const char* options, const TandemDeviceHost& host,
                                             std::string& fault);
  std::string Capabilities(TandemDeviceCapabilities& can) const;
  std::string Start() {
    link_->Start();
    return {};
  }
  std::string Trouble() const { return link_->trouble(); }
  std::int32_t Read(TandemDeviceState& state) noexcept;
  std::int32_t Write(const TandemDeviceForce&) noexcept {
    link_->Wrote(based_on_ns_);
    return TANDEM_OK;
  }
  void Stop() noexcept { link_->Stop(); }

 private:
  const TandemDeviceHost* host_ = nullptr;
  Session::Rules rules_;
  std::unique_ptr<Link> link_;
  std::uint64_t read_ = 0;        // number of the newest reading that Read() returned
  std::int64_t based_on_ns_ = 0;  // its sending time by the device's clock
};

NetworkDevice::~NetworkDevice() {
  if (link_ == nullptr) return;
  link_->End();
  const Histogram& trips = link_->round_trips();
  if (trips.count() == 0) return;
  const std::string refusals = link_->session().Refusals();
  std::array<char, 320> line{};
  std::snprintf(line.data(), line.size(),
                "network: %llu states in %llu sessions, round trip p50 %.2f ms, p99 %.2f ms, most "
                "%.2f ms%s%s",
                static_cast<unsigned long long>(trips.count()),
                static_cast<unsigned long long>(link_->session().sessions()),
                1e-6 * static_cast<double>(trips.Quantile(0.5)),
                1e-6 * static_cast<double>(trips.Quantile(0.99)),
                1e-6 * static_cast<double>(trips.max()), refusals.empty() ? "" : "; ",
                refusals.c_str());
  host_->say(host_->context, line.data());
}

std::int32_t NetworkDevice::List(TandemDeviceFound* found, std::int32_t room) {
  if (room < 1) return 0;
  found->present = 0;
  Put(found->name, "network");
  Put(found->options, std::string("listen=") + kHere);
  Put(found->missing, "a device connects by itself, to the address of 'listen'");
  Put(found->mend,
      "start the device's program, as python3 docs/examples/device/network_device.py "
      "127.0.0.1:47111, within 'wait' seconds of Tandem's start");
  return 1;
}

std::unique_ptr<NetworkDevice> NetworkDevice::Open(const char* text, const TandemDeviceHost& host,
                                                   std::string& fault) {
  auto device = std::make_unique<NetworkDevice>();
  device->host_ = &host;
  Options options(text);
  const std::string listen = options.Text("listen", kHere);
  const std::string key_file = options.Text("key");
  const double wait = options.Number("wait", 10, 0, 3600);
  Session::Rules& rules = device->rules_;
  rules.stale_ns = static_cast<std::int64_t>(1e6 * options.Number("stale_ms", 100, 10, 2000));
  rules.expiry_ns = static_cast<std::int64_t>(1e6 * options.Number("expiry_ms", 20, 2, 1000));
  fault = options.Fault();
  Address here;
  if (fault.empty() && !ReadAddress(listen, here)) {
    fault = "listen: expected a numeric ADDRESS:PORT such as " + std::string(kHere) + ", got '" +
            listen + "'";
  }
  Key key, secret;
  if (!fault.empty() || (!key_file.empty() && !key.Read(key_file, fault))) return nullptr;
  if (key.empty() && !here.IsOfThisMachine()) {
    fault = "listen=" + listen +
            ": other machines reach this address, so the driver needs a key: (umask 077; openssl "
            "rand -hex 32 > device.key), then key=device.key";
    return nullptr;
  }
  if (!secret.Make()) {
    fault = "this machine supplies no random numbers";
    return nullptr;
  }
  device->link_ = std::make_unique<Link>(std::move(key), std::move(secret), rules, host);
  if (!device->link_->Open(here, fault)) return nullptr;
  if (!device->link_->Await(static_cast<std::int64_t>(1e9 * wait))) {
    const std::string refusals = device->link_->session().Refusals();
    fault = "no device has connected to " + listen + ": start its program, then Tandem again" +
            (refusals.empty() ? "" : " (" + refusals + ")");
    return nullptr;
  }
  return device;
}

std::string NetworkDevice::Capabilities(TandemDeviceCapabilities& can) const {
  const Hello& hello = link_->session().hello();
  can.freedoms_in = hello.freedoms_in;
  can.freedoms_out = hello.freedoms_out;
  can.asks = hello.freedoms_out == 0 ? 0 : 1;
  can.rate_hz = hello.rate_hz;
  can.peak_force = hello.peak_force;
  can.peak_moment = hello.peak_moment;
  can.continuous_force = hello.continuous_force;
  can.continuous_moment = hello.continuous_moment;
  can.stiffness = hello.stiffness;
  can.damping = hello.damping;
  can.rotation_stiffness = hello.rotation_stiffness;
  can.rotation_damping = hello.rotation_damping;
  std::ranges::copy(hello.workspace_min, can.workspace_min);
  std::ranges::copy(hello.workspace_max, can.workspace_max);
  return {};
}

std::int32_t NetworkDevice::Read(TandemDeviceState& state) noexcept {
  Reading reading;
  if (!link_->Newest(reading)) return TANDEM_REPEATED;
  if (reading.condition < 0) return reading.condition;
  if (MonotonicNowNs() - reading.came_ns > rules_.stale_ns) return TANDEM_UNPLUGGED;
  const bool repeated = reading.number == read_;
  read_ = reading.number;
  based_on_ns_ = reading.sent_ns;
  state.valid = reading.state.valid & (TANDEM_HAS_POSE | TANDEM_HAS_VELOCITY);
  state.time_ns = reading.measured_ns;
  std::ranges::copy(reading.state.position, state.position);
  std::ranges::copy(reading.state.orientation, state.orientation);
  std::ranges::copy(reading.state.velocity, state.velocity);
  std::ranges::copy(reading.state.angular_velocity, state.angular_velocity);
  state.buttons = reading.state.buttons & (TANDEM_BUTTON_CLUTCH | TANDEM_BUTTON_STOP);
  return repeated ? TANDEM_REPEATED : TANDEM_OK;
}

}  // namespace
}  // namespace tandem::driver::network

const TandemDriver tandem_driver =
    tandem::driver::DriverTable<tandem::driver::network::NetworkDevice>::Table();
