#pragma once

#include <functional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "collab/session/peer_table.h"

namespace tandem {

/// A function that returns a peer's name.
using NameFunction = std::function<std::string(PeerId)>;

/// Returns the table for a person: a heading, and a line for each other peer with what its frames
/// gave up. Lines on our own frames follow. A dash stands for what is not known or means nothing.
std::vector<std::string> AsLines(const PeerTable& table, const NameFunction& name);

/// Returns an object for each other peer: name, delay_ms, loop_age_ms, coupled, stiffness_N_per_m,
/// link_force_N, its_link_force_N, disagreement, mirror_lag_mm, mirror_age_ms, trapped, limits,
/// drops.
nlohmann::ordered_json AsJson(const PeerTable& table, const NameFunction& name);

/// Returns an object: travel_limited_share, over_capacity_share, contacts_full_share, waited_share.
nlohmann::ordered_json AsJson(const FrameLimits& limits);

/// Returns the reasons that occurred, each with its count: "replayed 3, huge 1"; or "none".
std::string AsText(const DropCounts& drops);

}  // namespace tandem
