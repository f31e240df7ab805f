#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "app/device/tandem_device.h"
#include "engine/base/spatial.h"

/// The messages of Haply's Inverse Service, as JSON texts. Vectors and orientations that come out
/// of here, and go in, are in the frame V of tandem_device.h: the service's x, z and -y.
namespace tandem::driver::inverse3 {

/// How a force is written: newer services read "vector", older ones "values".
enum class ForceForm { kVector, kValues, kNone };

/// A device of the service. Its identity has letters, digits, '-' and '_' only.
struct Named {
  std::string id;
  std::string kind;  // "inverse3", "verse_grip" or "wireless_verse_grip"
};

/// All devices that a message names; nothing: it is no message of the service.
std::optional<std::vector<Named>> ReadInventory(std::string_view text);

/// What the driver asks for.
struct Choice {
  std::string arm;
  std::optional<Named> grip;
  ForceForm form = ForceForm::kVector;
  std::string preset;  // of the arm's place; empty: as the service has it
};

/// What a message says. What it leaves out stands as in the message before.
struct Told {
  bool arm = false;  // the arm is listed
  Vec3 position = Vec3::Zero();
  Vec3 velocity = Vec3::Zero();
  std::optional<Vec3> force;  // that acts, by the service's word, in this message
  bool calibrated = true;
  bool ready = true;
  bool powered = true;
  bool grip = false;  // the grip is listed and awake
  Quat orientation = Quat::Identity();
  std::uint32_t buttons = 0;  // TANDEM_BUTTON_…
};

/// Takes a message into `told`. False: it is no sound message, `told` is as before, and `why` says
/// what is wrong with it.
bool ReadState(std::string_view text, const Choice& choice, Told& told, std::string& why);

/// Writes a message that asks for a force, and so for a state. The first one of a connection names
/// this program, its axes, and asks for the whole state.
void WriteCommand(const Choice& choice, const Vec3& force, bool first, std::string& text);

/// What an event means for the arm.
struct Event {
  enum class Kind { kNone, kConnected, kDisconnected, kBusy, kSafety, kCalibration };
  Kind kind = Kind::kNone;
  std::string words;  // of the service, for a person; at most 80 characters
};
/// An event of another device than the arm, or none that matters, is kNone.
Event ReadEvent(std::string_view text, const std::string& arm);

}  // namespace tandem::driver::inverse3
