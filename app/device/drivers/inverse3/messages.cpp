#include "app/device/drivers/inverse3/messages.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include <nlohmann/json.hpp>

namespace tandem::driver::inverse3 {
namespace {

using nlohmann::json;

constexpr double kMostPosition = 1;   // m; the arm reaches a third of that
constexpr double kMostVelocity = 50;  // m/s
constexpr double kMostForce = 1000;   // N
constexpr std::size_t kMostDevices = 16;
constexpr std::size_t kMostName = 48;
constexpr std::size_t kMostWords = 80;
constexpr std::array<const char*, 3> kKinds{"inverse3", "verse_grip", "wireless_verse_grip"};

/// Returns the member of an object; null: there is none.
const json* Member(const json* object, const char* key) {
  if (object == nullptr || !object->is_object()) return nullptr;
  const auto found = object->find(key);
  return found == object->end() ? nullptr : &*found;
}

bool ReadNumber(const json* object, const char* key, double most, double& number) {
  const json* member = Member(object, key);
  if (member == nullptr || !member->is_number()) return false;
  number = member->get<double>();
  return std::abs(number) <= most;
}

/// Reads a vector, in V.
bool ReadVector(const json* object, double most, Vec3& vector) {
  double x = 0, y = 0, z = 0;
  if (!ReadNumber(object, "x", most, x) || !ReadNumber(object, "y", most, y) ||
      !ReadNumber(object, "z", most, z)) {
    return false;
  }
  vector = Vec3(x, z, -y);
  return true;
}

/// Reads an orientation, in V: the axis of a rotation is a vector.
bool ReadOrientation(const json* object, Quat& orientation) {
  double w = 1;
  Vec3 axis;
  if (!ReadNumber(object, "w", 1.1, w) || !ReadVector(object, 1.1, axis)) return false;
  const Quat read(w, axis.x(), axis.y(), axis.z());
  if (!(std::abs(read.norm() - 1) < 0.1)) return false;
  orientation = read.normalized();
  return true;
}

void ReadFlag(const json* object, const char* key, bool& flag) {
  const json* member = Member(object, key);
  if (member != nullptr && member->is_boolean()) flag = member->get<bool>();
}

bool IsPressed(const json* object, const char* key) {
  bool pressed = false;
  ReadFlag(object, key, pressed);
  return pressed;
}

bool IsName(const std::string& name) {
  return !name.empty() && name.size() <= kMostName && std::ranges::all_of(name, [](char c) {
    return (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || c == '-' ||
           c == '_';
  });
}

/// Returns the device of that kind and name; null: it is not listed.
const json* Find(const json& message, const std::string& kind, const std::string& id) {
  const json* list = Member(&message, kind.c_str());
  if (list == nullptr || !list->is_array()) return nullptr;
  for (const json& one : *list) {
    const json* name = Member(&one, "device_id");
    if (name != nullptr && name->is_string() && name->get_ref<const std::string&>() == id) {
      return &one;
    }
  }
  return nullptr;
}

/// Reads the state of the grip.
bool ReadGrip(const json& message, const Named& grip, ReportedState& reported, std::string& why) {
  const json* device = Find(message, grip.kind, grip.id);
  reported.grip = device != nullptr;
  reported.buttons = 0;
  if (device == nullptr) return true;
  const json* status = Member(device, "status");
  for (const char* condition : {"connected", "awake"}) {
    bool is_so = true;
    ReadFlag(status, condition, is_so);
    reported.grip = reported.grip && is_so;
  }
  if (!reported.grip) return true;
  const json* state = Member(device, "state");
  if (!ReadOrientation(Member(state, "orientation"), reported.orientation)) {
    why = "the grip's orientation is missing or invalid";
    return false;
  }
  const json* buttons = Member(state, "buttons");
  if (IsPressed(state, "button") || IsPressed(state, "button_0") || IsPressed(buttons, "a") ||
      IsPressed(buttons, "button_0")) {
    reported.buttons |= TANDEM_BUTTON_CLUTCH;
  }
  if (IsPressed(state, "button_1") || IsPressed(buttons, "b") || IsPressed(buttons, "button_1")) {
    reported.buttons |= TANDEM_BUTTON_STOP;
  }
  return true;
}

void AppendNumber(double number, std::string& text) {
  std::array<char, 32> digits;
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), number,
                                 std::chars_format::fixed, 5)
                       .ptr;
  text.append(digits.data(), end);
}

}  // namespace

std::optional<std::vector<Named>> ReadInventory(std::string_view text) {
  const json message = json::parse(text, nullptr, false);
  if (!message.is_object()) return {};
  std::vector<Named> found;
  for (const char* kind : kKinds) {
    const json* list = Member(&message, kind);
    if (list == nullptr || !list->is_array()) continue;
    for (const json& one : *list) {
      const json* name = Member(&one, "device_id");
      if (name == nullptr || !name->is_string() || found.size() == kMostDevices) continue;
      if (IsName(name->get<std::string>())) found.push_back({name->get<std::string>(), kind});
    }
  }
  return found;
}

bool ReadState(std::string_view text, const Choice& choice, ReportedState& reported,
               std::string& why) {
  const json message = json::parse(text, nullptr, false);
  if (!message.is_object()) {
    why = "it is not a JSON object";
    return false;
  }
  ReportedState next = reported;
  next.force.reset();
  const json* arm = Find(message, "inverse3", choice.arm);
  next.arm = arm != nullptr;
  if (arm != nullptr) {
    const json* state = Member(arm, "state");
    if (!ReadVector(Member(state, "cursor_position"), kMostPosition, next.position)) {
      why = "the arm's position is missing or invalid";
      return false;
    }
    if (!ReadVector(Member(state, "cursor_velocity"), kMostVelocity, next.velocity)) {
      why = "the arm's velocity is missing or invalid";
      return false;
    }
    Vec3 force;
    if (ReadVector(Member(state, "current_cursor_force"), kMostForce, force)) next.force = force;
    const json* status = Member(arm, "status");
    ReadFlag(status, "calibrated", next.calibrated);
    ReadFlag(status, "ready", next.ready);
    ReadFlag(status, "power_supply", next.powered);
  }
  if (choice.grip && !ReadGrip(message, *choice.grip, next, why)) return false;
  reported = next;
  return true;
}

void WriteCommand(const Choice& choice, const Vec3& force, bool first, std::string& text) {
  text = "{";
  if (first) {
    text += R"("session":{"configure":{"profile":{"name":"Tandem"},"basis":{"permutation":"XYZ"}},)"
            R"("force_render_full_state":{}},)";
  }
  text += R"("inverse3":[{"device_id":")" + choice.arm + "\",";
  if (first && !choice.preset.empty()) {
    text += R"("configure":{"preset":")" + choice.preset + "\"},";
  }
  if (choice.form == ForceForm::kNone) {
    text += R"("commands":{"probe_position":{}}}])";
  } else {
    text += R"("commands":{"set_cursor_force":{")";
    text += choice.form == ForceForm::kVector ? "vector" : "values";
    text += R"(":{"x":)";
    AppendNumber(force.x(), text);
    text += R"(,"y":)";
    AppendNumber(-force.z(), text);
    text += R"(,"z":)";
    AppendNumber(force.y(), text);
    text += "}}}}]";
  }
  if (choice.grip) {
    text += ",\"" + choice.grip->kind + R"(":[{"device_id":")" + choice.grip->id +
            R"(","commands":{"probe_orientation":{}}}])";
  }
  text += "}";
}

Event ReadEvent(std::string_view text, const std::string& arm) {
  const json message = json::parse(text, nullptr, false);
  const json* name = Member(&message, "name");
  if (name == nullptr || !name->is_string()) return {};
  const json* device = Member(Member(&message, "data"), "device_id");
  if (device != nullptr && device->is_string() && device->get<std::string>() != arm) return {};
  static constexpr std::array<std::pair<std::string_view, Event::Kind>, 5> kNames{
      {{"device-connected", Event::Kind::kConnected},
       {"device-disconnected", Event::Kind::kDisconnected},
       {"device-busy", Event::Kind::kBusy},
       {"device-safety-triggered", Event::Kind::kSafety},
       {"device-calibration-failed", Event::Kind::kCalibration}}};
  const auto& event_name = name->get_ref<const std::string&>();
  Event event;
  for (const auto& [ending, kind] : kNames) {
    // with or without the first word, as in "safety-triggered"
    const std::string_view short_name = ending.substr(ending.find('-') + 1);
    if (event_name == ending || event_name == short_name) event.kind = kind;
  }
  const json* words = Member(&message, "message");
  if (words != nullptr && words->is_string()) {
    for (const char c : words->get<std::string>().substr(0, kMostWords)) {
      if (c >= ' ' && c <= '~') event.words += c;  // plain characters, since a terminal shows them
    }
  }
  return event;
}

}  // namespace tandem::driver::inverse3
