#pragma once

#include <functional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "collab/peer_table.h"

namespace tandem {

/// How a peer is called.
using NameFunction = std::function<std::string(PeerId)>;

/// The table for a person: a heading and a line for each of the others, with what their frames gave
/// up; then what ours did. What is not known, or means nothing now, is a dash.
std::vector<std::string> AsLines(const PeerTable& table, const NameFunction& name);

/// An object for each of the others: name, delay_ms, loop_age_ms, coupled, stiffness_N_per_m,
/// link_force_N, its_link_force_N, disagreement, mirror_lag_mm, mirror_age_ms, trapped, limits,
/// drops.
nlohmann::ordered_json AsJson(const PeerTable& table, const NameFunction& name);

/// travel_limited_share, over_capacity_share, contacts_full_share, waited_share.
nlohmann::ordered_json AsJson(const FrameLimits& limits);

/// The reasons and how many, of those that occurred: "replayed 3, huge 1"; or "none".
std::string AsText(const DropCounts& drops);

}  // namespace tandem
