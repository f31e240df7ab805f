#pragma once

#include <cstdint>
#include <string>

#include "app/reach/session_scene.h"

namespace tandem {

/// The user answers in advance whether a scene may be fetched, and how large it may be.
struct SceneFetchOptions {
  bool accept = false;            // without being asked
  std::uint64_t limit_mb = 1024;  // of its files
};

/// How the session's scene is sought from a terminal: a person there is asked before anything is
/// fetched, or has said `accept` in advance. Progress is a bar on a terminal, else a line now and
/// then.
SessionSceneOptions SceneSearchOptions(const std::string& session, PeerId id, Role role,
                                       const ReachOptions& reach, const SceneFetchOptions& fetch);

}  // namespace tandem
