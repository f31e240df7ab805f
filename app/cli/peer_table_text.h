#pragma once

#include <functional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "collab/peer_table.h"

namespace tandem {

/// How a peer is called.
using NameFunction = std::function<std::string(PeerId)>;

/// The table for a person: a heading and a line for each of the others. What is not known, or means
/// nothing now, is a dash.
std::vector<std::string> AsLines(const PeerTable& table, const NameFunction& name);

/// An object for each of the others: name, delay_ms, loop_age_ms, coupled, stiffness_N_per_m,
/// link_force_N, its_link_force_N, disagreement, mirror_lag_mm, mirror_age_ms, trapped, drops.
nlohmann::ordered_json AsJson(const PeerTable& table, const NameFunction& name);

/// The reasons and how many, of those that occurred: "replayed 3, huge 1"; or "none".
std::string AsText(const DropCounts& drops);

}  // namespace tandem
