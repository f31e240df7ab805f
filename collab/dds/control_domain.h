#pragma once

#include <filesystem>
#include <string>

#include "collab/dds/dds_api.h"
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

enum class ControlTopic : std::uint8_t { kRequest, kAnswer, kGoal, kScene, kSnapshot };

/// A reader or a writer of a topic, in the partition of whoever says it. Negative: why there is
/// none.
dds_entity_t ControlReader(dds_entity_t participant, ControlTopic topic);
dds_entity_t ControlWriter(dds_entity_t participant, ControlTopic topic);

}  // namespace tandem
