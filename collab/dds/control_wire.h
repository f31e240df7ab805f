#pragma once

#include <optional>
#include <vector>

#include "collab/controller/control_server.h"
#include "tandem_control.h"  // idlc's

namespace tandem {

/// Between what hosts and controllers say and its form on the wire (idl/tandem_control.idl). Text
/// that is too long is cut before a character; control characters in what is read become '?'.
/// FromWire answers false, or nothing, for what no sound program sends: numbers that are not
/// finite, a kind or a state that there is none of. A file name that is too long is not sent.
inline constexpr std::uint32_t kControlVersion = tandem_control_VERSION;

/// False: a file name is too long.
bool ToWire(const ControlRequest& request, tandem_control_Request& wire);
std::optional<ControlRequest> FromWire(const tandem_control_Request& wire);

void ToWire(const HostAnswer& answer, tandem_control_Answer& wire);
HostAnswer FromWire(const tandem_control_Answer& wire);

void ToWire(const HostGoal& goal, tandem_control_Goal& wire);
bool FromWire(const tandem_control_Goal& wire, HostGoal& goal);

/// Lists lie in the rooms, and live as long as these.
void ToWire(const ControlScene& scene, bool loading, tandem_control_Scene& wire,
            std::vector<tandem_control_SceneBody>& room);

struct SnapshotRoom {
  std::vector<tandem_control_Body> bodies;
  std::vector<tandem_control_Instance> instances;
  std::vector<tandem_control_Contact> contacts;
  std::vector<tandem_control_Peer> peers;
};
void ToWire(const ControllerSnapshot& snapshot, std::uint64_t controller,
            tandem_control_Snapshot& wire, SnapshotRoom& room);
/// Names of bodies and of the scene are those of `scene`; false: it is of another scene.
bool FromWire(const tandem_control_Snapshot& wire, const tandem_control_Scene& scene,
              ControllerSnapshot& snapshot);

/// A text of the wire, as a person may read it.
std::string TextFromWire(const char* text);

}  // namespace tandem
