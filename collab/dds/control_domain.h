#pragma once

#include <filesystem>
#include <string>

#include "collab/dds/dds_api.h"
#include "collab/dds/gated_reader.h"
#include "engine/base/result.h"

namespace tandem {

/// What both ends of a controller's command interface are made of: a DDS domain of its own on
/// loopback, a participant in it, with keys or without.
struct ControlDomain {
  Entity domain;
  Entity participant;
};

/// `keys`: a member's folder; empty: none.
Result<ControlDomain> EnterControlDomain(const std::string& name, std::uint32_t id,
                                         const std::filesystem::path& keys);

/// The user's own folder for what controllers of this machine keep while they run: below
/// $XDG_RUNTIME_DIR, else /tmp. Made if it is not there. Errors: it is not ours alone.
Result<std::filesystem::path> ControlFolder();

/// The folder, in ControlFolder(), for the scenes that a controller of that name makes. It goes
/// with the controller, or with the next one that starts on this machine. The controller makes it.
std::string ScenesFolderOf(const std::string& controller);

enum class ControlTopic : std::uint8_t { kRequest, kAnswer, kGoal, kScene, kSnapshot };

/// The samples that a writer of such a topic may send to a reader.
WriterLimits LimitsOf(ControlTopic topic);

/// Makes a reader of a topic, in the partition of the program that writes it. A WriterGate stands
/// before the reader, as it does in a session: any program of the machine may write to it.
/// Negative: Cyclone's code of what went wrong.
dds_entity_t ControlReader(dds_entity_t participant, ControlTopic topic, OnRefused on_refused);
/// Makes a writer of a topic, in this program's partition. Negative: as above.
dds_entity_t ControlWriter(dds_entity_t participant, ControlTopic topic);

}  // namespace tandem
