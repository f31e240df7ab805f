#pragma once

#include "collab/controller/simulation_facts.h"
#include "collab/peer/peer_node.h"
#include "engine/haptics/goal_device.h"

namespace tandem {

/// Returns the state of the part in hand for the hand's device, moved by goals; called before a
/// frame.
PartInHand SeePart(const PeerNode& node, const GoalDevice& device) noexcept
    TANDEM_RUNS_ON(kHapticThread);

/// Writes the facts of a frame, after it. `device`: null where hosts' goals do not move the hand.
/// Nothing allocates.
void FillFacts(PeerNode& node, const GoalDevice* device, std::uint64_t frame, std::int64_t now_ns,
               SimulationFacts& facts) noexcept TANDEM_RUNS_ON(kHapticThread);

}  // namespace tandem
