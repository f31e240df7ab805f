#pragma once

#include <filesystem>
#include <string>

#include "collab/dds/cyclone/dds_api.h"
#include "collab/dds/transport/rate_limited_reader.h"
#include "engine/base/result.h"

namespace tandem {

/// The base of both ends of a controller's command interface: a DDS domain on loopback and a
/// participant in it, with or without keys.
struct ControlDomain {
  Entity domain;
  Entity participant;
};

/// Enters the domain. `keys` is a member's folder; empty: no keys.
Result<ControlDomain> EnterControlDomain(const std::string& name, std::uint32_t id,
                                         const std::filesystem::path& keys);

/// Returns the user's folder for files that this machine's controllers keep while they run: below
/// $XDG_RUNTIME_DIR, else in /tmp. It is made if missing. Error: other users can use it too.
Result<std::filesystem::path> ControlFolder();

/// Returns the folder, in ControlFolder(), for the scenes that a controller of that name makes. The
/// controller makes it. It goes with the controller, or with the next one that starts on this
/// machine.
std::string ScenesFolderOf(const std::string& controller);

enum class ControlTopic : std::uint8_t { kRequest, kAnswer, kGoal, kScene, kSnapshot };

/// Returns the samples that a writer of the topic may send to a reader.
WriterLimits LimitsOf(ControlTopic topic);

/// Makes a reader of a topic, in the partition of the program that writes it. A WriterRateLimiter
/// stands before the reader, as in a session, because any program of the machine may write to it.
/// Negative: Cyclone's error code.
dds_entity_t ControlReader(dds_entity_t participant, ControlTopic topic, OnRefused on_refused);
/// Makes a writer of a topic, in this program's partition. Negative: Cyclone's error code.
dds_entity_t ControlWriter(dds_entity_t participant, ControlTopic topic);

}  // namespace tandem
