#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "app/device/tandem_device.h"
#include "engine/base/spatial.h"

/// The messages of Haply's Inverse Service, as JSON texts. Vectors and orientations in this
/// interface are in the frame V of tandem_device.h: the service's x, z and -y.
namespace tandem::driver::inverse3 {

/// The form of a force: newer services read "vector", older ones "values".
enum class ForceForm { kVector, kValues, kNone };

/// A device of the service. Its identity has only letters, digits, '-' and '_'.
struct Named {
  std::string id;
  std::string kind;  // "inverse3", "verse_grip" or "wireless_verse_grip"
};

/// Returns all devices that a message names; nothing: it is no message of the service.
std::optional<std::vector<Named>> ReadInventory(std::string_view text);

/// The devices and the form of force that the driver uses.
struct Choice {
  std::string arm;
  std::optional<Named> grip;
  ForceForm form = ForceForm::kVector;
  std::string preset;  // preset of the arm's place; empty: the service's own
};

/// The content of the messages so far. A value that a message omits stays as it was.
struct ReportedState {
  bool arm = false;  // true: the arm is listed
  Vec3 position = Vec3::Zero();
  Vec3 velocity = Vec3::Zero();
  std::optional<Vec3> force;  // force that acts, as this message reports it
  bool calibrated = true;
  bool ready = true;
  bool powered = true;
  bool grip = false;  // true: the grip is listed and awake
  Quat orientation = Quat::Identity();
  std::uint32_t buttons = 0;  // TANDEM_BUTTON_…
};

/// Updates `reported` with a message. False: the message is unsound, `reported` is unchanged, and
/// `why` says what is wrong.
bool ReadState(std::string_view text, const Choice& choice, ReportedState& reported,
               std::string& why);

/// Writes a message that asks for a force, and so for a state. The first message of a connection
/// also names this program and its axes, and asks for the whole state.
void WriteCommand(const Choice& choice, const Vec3& force, bool first, std::string& text);

/// The meaning of an event for the arm.
struct Event {
  enum class Kind { kNone, kConnected, kDisconnected, kBusy, kSafety, kCalibration };
  Kind kind = Kind::kNone;
  std::string words;  // service's words for a person; at most 80 characters
};
/// Reads an event. kNone: it concerns another device, or does not matter.
Event ReadEvent(std::string_view text, const std::string& arm);

}  // namespace tandem::driver::inverse3
