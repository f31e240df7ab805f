// Haply Inverse3 with a VerseGrip, through Haply's Inverse Service on this machine.
#include <algorithm>
#include <atomic>
#include <cctype>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/device/drivers/driver_support.h"
#include "app/device/drivers/driver_table.h"
#include "app/device/drivers/inverse3/exchange.h"
#include "app/device/drivers/inverse3/messages.h"
#include "app/device/drivers/inverse3/websocket.h"
#include "engine/realtime/clock.h"

namespace tandem::driver::inverse3 {
namespace {

constexpr std::int64_t kLookNs = 700'000'000;    // patience for the service in list()
constexpr std::int64_t kOpenNs = 3'000'000'000;  // patience for the inventory
constexpr std::int64_t kStaleNs = 100'000'000;   // age from which a state is not used
constexpr double kPeakForce = 10;                // N
constexpr double kStiffness = 1000;              // N/m
constexpr double kDamping = 6;                   // N s/m
constexpr const char* kStart =
    "install Haply's Inverse Service (docs.haply.co) and start it: systemctl start "
    "haply-inverse-service";

const std::atomic<bool> kNeverEnding{false};

std::optional<std::vector<Named>> Inventory(int port, std::int64_t limit_ns) {
  WebSocket socket(kNeverEnding);
  std::string text;
  if (!socket.Connect(port, limit_ns) || !socket.Receive(text, limit_ns)) return {};
  socket.Close(kLookNs / 8);
  return ReadInventory(text);
}

/// Returns the service's version, reduced to a short plain text.
std::string VersionOn(int port) {
  std::string version;
  for (const char c : HttpGet(port, "/version", kLookNs).value_or("")) {
    if (std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '.' || c == '-') version += c;
  }
  return version.substr(0, 40);
}

/// Chooses the grip that is asked for: by its identity, by its kind, or any. False: it is not
/// there.
bool ChooseGrip(const std::vector<Named>& found, const std::string& requested,
                std::optional<Named>& grip) {
  if (requested == "none") return true;
  for (const Named& one : found) {
    if (one.kind == "inverse3" || grip) continue;
    const bool wireless = one.kind == "wireless_verse_grip";
    if (requested.empty() || requested == one.id || requested == (wireless ? "wireless" : "wired"))
      grip = one;
  }
  return grip.has_value() || requested.empty();
}

class Inverse3 {
 public:
  static constexpr const char* kName = "inverse3";
  static constexpr const char* kKind =
      "Haply Inverse3 with VerseGrip, by Haply's Inverse Service on this machine";
  static constexpr const char* kOptions =
      "device=ID,grip=ID|wired|wireless|none,force=vector|values|none,preset=NAME,port=10001,"
      "events=10020,rate=1000";

  static std::int32_t List(TandemDeviceFound* found, std::int32_t room);
  static std::unique_ptr<Inverse3> Open(const char* options, const TandemDeviceHost& host,
                                        std::string& fault);

  std::string Capabilities(TandemDeviceCapabilities& can) const;
  std::string Start() {
    exchange_->Start();
    return {};
  }
  std::string Trouble() const;
  std::int32_t Read(TandemDeviceState& state) noexcept;
  std::int32_t Write(const TandemDeviceForce&) noexcept {
    exchange_->Allow();
    return TANDEM_OK;
  }
  void Stop() noexcept { exchange_->Stop(); }

 private:
  Place place_;
  Choice choice_;
  std::unique_ptr<Exchange> exchange_;
  std::uint64_t read_ = 0;  // number of the newest reading that Read() returned
};

std::int32_t Inverse3::List(TandemDeviceFound* found, std::int32_t room) {
  if (room < 1) return 0;
  const Place place;
  const auto there = Inventory(place.port, kLookNs);
  if (!there) {
    const std::string version = VersionOn(place.port);
    found->present = 0;
    Put(found->name, "Inverse3");
    if (version.empty()) {
      Put(found->missing, "the Inverse Service, which should listen on 127.0.0.1:10001");
      Put(found->mend, kStart);
    } else {
      Put(found->missing, "the WebSocket of the Inverse Service (version " + version + ")");
      Put(found->mend, "restart it: systemctl restart haply-inverse-service");
    }
    return 1;
  }
  std::int32_t count = 0;
  std::optional<Named> grip;
  ChooseGrip(*there, "", grip);
  for (const Named& one : *there) {
    if (one.kind != "inverse3" || count == room) continue;
    TandemDeviceFound& arm = found[count++];
    arm.present = 1;
    Put(arm.name, std::string("Inverse3") + (grip ? " with VerseGrip" : ""));
    Put(arm.options, "device=" + one.id);
    if (!grip) {
      Put(arm.missing, "a VerseGrip: without it the handle does not rotate");
      Put(arm.mend, "pair a wireless VerseGrip in Haply Hub, or plug in a wired one");
    }
  }
  if (count > 0) return count;
  found->present = 0;
  Put(found->name, "Inverse3");
  Put(found->missing, "an Inverse3: the Inverse Service runs but sees none");
  Put(found->mend, "plug in its power supply and its USB cable");
  return 1;
}

std::unique_ptr<Inverse3> Inverse3::Open(const char* text, const TandemDeviceHost& host,
                                         std::string& fault) {
  auto device = std::make_unique<Inverse3>();
  Options options(text);
  Place& place = device->place_;
  Choice& choice = device->choice_;
  choice.arm = options.Text("device");
  const std::string grip = options.Text("grip");
  const std::string form = options.Text("force", "vector");
  choice.preset = options.Text("preset");
  place.port = static_cast<int>(options.Number("port", place.port, 1, 65535));
  place.events_port = static_cast<int>(options.Number("events", place.events_port, 0, 65535));
  place.rate_hz = options.Number("rate", place.rate_hz, 100, 4000);
  fault = options.Fault();
  if (fault.empty() && form != "vector" && form != "values" && form != "none") {
    fault = "force: expected vector, values or none, got '" + form + "'";
  }
  if (fault.empty() && !std::ranges::all_of(choice.preset, [](char c) {
        return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '-';
      })) {
    fault = "preset: expected letters, digits, '_' and '-', as in arm_front_centered";
  }
  if (!fault.empty()) return nullptr;
  choice.form = form == "vector"   ? ForceForm::kVector
                : form == "values" ? ForceForm::kValues
                                   : ForceForm::kNone;

  const auto there = Inventory(place.port, kOpenNs);
  if (!there) {
    fault = "no Inverse Service answers on 127.0.0.1:" + std::to_string(place.port) + ": " + kStart;
    return nullptr;
  }
  std::string arms;
  bool found = false;
  for (const Named& one : *there) {
    if (one.kind != "inverse3") continue;
    arms += " " + one.id;
    if (choice.arm.empty()) choice.arm = one.id;
    found = found || one.id == choice.arm;
  }
  if (arms.empty()) {
    fault = "the Inverse Service sees no Inverse3: plug in its power supply and its USB cable";
  } else if (!found) {
    fault = "the Inverse Service sees no Inverse3 '" + choice.arm + "'; there are" + arms;
  } else if (!ChooseGrip(*there, grip, choice.grip)) {
    fault = "the Inverse Service sees no VerseGrip '" + grip +
            "': connect it, or give grip=none for a handle that does not rotate";
  }
  if (!fault.empty()) return nullptr;
  device->exchange_ = std::make_unique<Exchange>(place, choice, host);
  return device;
}

std::string Inverse3::Capabilities(TandemDeviceCapabilities& can) const {
  const bool forceless = choice_.form == ForceForm::kNone;
  can.freedoms_in = choice_.grip ? 6 : 3;
  can.freedoms_out = forceless ? 0 : 3;
  can.asks = forceless ? 0 : 1;
  can.rate_hz = place_.rate_hz;
  can.peak_force = forceless ? 0 : kPeakForce;
  can.stiffness = kStiffness;
  can.damping = kDamping;
  return {};
}

std::string Inverse3::Trouble() const {
  const std::string trouble = exchange_->trouble();
  Reading reading;
  if (!trouble.empty() || !exchange_->Newest(reading)) return trouble;
  const std::int64_t age_ns = MonotonicNowNs() - reading.time_ns;
  if (reading.number == 0) return "the Inverse Service has sent no state yet: wait";
  if (age_ns <= kStaleNs) return {};
  return "the Inverse Service has been silent for " + std::to_string(age_ns / 1'000'000) +
         " ms: wait, or restart it: systemctl restart haply-inverse-service";
}

std::int32_t Inverse3::Read(TandemDeviceState& state) noexcept {
  Reading reading;
  if (!exchange_->Newest(reading)) return TANDEM_REPEATED;
  if (reading.condition < 0) return reading.condition;
  if (MonotonicNowNs() - reading.time_ns > kStaleNs) return TANDEM_UNPLUGGED;
  const bool repeated = reading.number == read_;
  read_ = reading.number;
  state.valid = TANDEM_HAS_POSE | TANDEM_HAS_VELOCITY;
  state.time_ns = reading.time_ns;
  std::copy_n(reading.position, 3, state.position);
  std::copy_n(reading.orientation, 4, state.orientation);
  std::copy_n(reading.velocity, 3, state.velocity);
  std::copy_n(reading.angular_velocity, 3, state.angular_velocity);
  state.buttons = reading.buttons;
  return repeated ? TANDEM_REPEATED : TANDEM_OK;
}

}  // namespace
}  // namespace tandem::driver::inverse3

const TandemDriver tandem_driver =
    tandem::driver::DriverTable<tandem::driver::inverse3::Inverse3>::Table();
