#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "collab/peer/peer_node.h"
#include "engine/haptics/scripted_device.h"

namespace tandem::testing {

/// Returns a whole peer whose hand holds a body of the scene, waits for one other, and goes that
/// way.
inline std::unique_ptr<PeerNode> ScriptedNode(const std::shared_ptr<const WorldModel>& model,
                                              PeerId id, int object, std::vector<Waypoint> way,
                                              double delay_ms) {
  HandScript script;
  script.waypoints = std::move(way);
  NodeOptions options;
  options.peer.id = id;
  options.peer.held_object = object;
  options.peer.wait_for = 1;
  options.conditions.delay_ms = delay_ms;
  const auto body = static_cast<std::size_t>(model->body_index[static_cast<std::size_t>(object)]);
  auto device = std::make_unique<ScriptedDevice>(script, model->bodies[body].X_WB0);
  return std::make_unique<PeerNode>(model, std::move(device), 42, options);
}

}  // namespace tandem::testing
