#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "engine/world/scene.h"

namespace tandem {

/// A `tandem peer` on this machine, as demo and benches start them.
struct LocalPeer {
  std::string session;
  std::filesystem::path scene;
  std::string name;
  std::optional<SceneHand> hand;  // what it holds, and by which script; nothing: empty hands
  std::size_t wait_for = 0;
  double seconds = 0;
  std::filesystem::path report;
  std::string interface = "lo";
};

/// The words of its command line; `more` go last. What there is to say of the scene and of the
/// run, the command that starts it says.
std::vector<std::string> WordsOf(const LocalPeer& peer, const std::vector<std::string>& more);

}  // namespace tandem
