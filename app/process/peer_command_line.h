#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "engine/scene/scene.h"

namespace tandem {

/// A `tandem peer` on this machine, as demo and benches start it.
struct LocalPeer {
  std::string session;
  std::filesystem::path scene;
  std::string name;
  std::optional<SceneHand> hand;  // body that it holds, and the script; nothing: an empty hand
  std::size_t wait_for = 0;
  double seconds = 0;
  std::filesystem::path report;
  std::string interface = "lo";
};

/// Returns the words of its command line; `more` go last. They tell the peer to be brief, because
/// the command that starts it says what there is to say of the scene and of the run.
std::vector<std::string> CommandLineOf(const LocalPeer& peer, const std::vector<std::string>& more);

}  // namespace tandem
