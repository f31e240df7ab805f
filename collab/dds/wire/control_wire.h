#pragma once

#include <optional>
#include <vector>

#include "collab/controller/control_server.h"
#include "tandem_control.h"  // idlc's

namespace tandem {

/// Converts between the messages of hosts and controllers and their wire format
/// (idl/tandem_control.idl). Text that is too long is cut at the end of a character; control
/// characters in received text become '?'. FromWire returns false, or nothing, for values that no
/// sound program sends: numbers that are not finite, an unknown kind or state. A request with a
/// file name that is too long is not sent.
inline constexpr std::uint32_t kControlVersion = tandem_control_VERSION;

/// False: a name is too long.
bool ToWire(const ControlRequest& request, tandem_control_Request& wire);
std::optional<ControlRequest> FromWire(const tandem_control_Request& wire);

void ToWire(const HostAnswer& answer, tandem_control_Answer& wire);
HostAnswer FromWire(const tandem_control_Answer& wire);

void ToWire(const HostGoal& goal, tandem_control_Goal& wire);
bool FromWire(const tandem_control_Goal& wire, HostGoal& goal);

/// The wire's lists lie in the rooms and live as long as these.
void ToWire(const ControlScene& scene, bool loading, tandem_control_Scene& wire,
            std::vector<tandem_control_SceneBody>& room);

/// A line as idlc has it in a list.
struct WarningLine {
  char text[513];
};

struct SnapshotBuffers {
  std::vector<tandem_control_Body> bodies;
  std::vector<tandem_control_Instance> instances;
  std::vector<tandem_control_Contact> contacts;
  std::vector<tandem_control_Peer> peers;
  std::vector<std::uint8_t> colours;
  std::vector<std::uint8_t> stopped;
  std::vector<WarningLine> warnings;
};
void ToWire(const ControllerSnapshot& snapshot, std::uint64_t controller,
            tandem_control_Snapshot& wire, SnapshotBuffers& room);
/// Takes the names of the bodies and of the scene from `scene`. False: the snapshot is of another
/// scene, or unsound.
bool FromWire(const tandem_control_Snapshot& wire, const tandem_control_Scene& scene,
              ControllerSnapshot& snapshot);

/// Returns a text of the wire as a person may read it.
std::string TextFromWire(const char* text);

}  // namespace tandem
