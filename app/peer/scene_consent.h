#pragma once

#include <cstdint>
#include <string>

#include "app/connection/session_scene.h"

namespace tandem {

/// The user's answer in advance: whether a scene may be fetched, and how large it may be.
struct SceneFetchOptions {
  bool accept = false;            // fetch without asking
  std::uint64_t limit_mb = 1024;  // most for all of its files
};

/// Returns the options for seeking the session's scene from a terminal. A person there is asked
/// before anything is fetched, unless `accept` is set. Progress is a bar on a terminal, else a line
/// at intervals.
SessionSceneOptions SceneSearchOptions(const std::string& session, PeerId id, Role role,
                                       const ConnectionOptions& connection,
                                       const SceneFetchOptions& fetch);

}  // namespace tandem
