#pragma once

#include <functional>
#include <string>

#include "app/connection/connection_options.h"
#include "app/peer/peer_options.h"
#include "app/peer/scene_consent.h"

namespace tandem {

/// The options of `tandem watch`.
struct WatchOptions {
  std::string session;
  std::string scene;                // scene to compare with the session's; empty: no comparison
  bool scene_from_session = false;  // take the session's scene, wherever its files are
  SceneFetchOptions fetch;
  std::string name;
  ConnectionOptions connection;
  double seconds = 0;  // 0: until a signal comes
  std::string report;
  bool json = false;
  bool from_relay = false;  // be one of a relay's viewers instead of the session's own
  /// Called once the viewer is in the session. Null: nobody asks.
  std::function<void(const EnteredSession&)> on_entered;
  bool as_part = false;  // part of a command that starts the session too, and says what it is
};

/// Runs a viewer without a window. It says a line on stderr for each coming and going, and one a
/// second on what it receives. At the end it writes a report (to a file, and to stdout with
/// --json). Returns the exit code.
int WatchCommand(const WatchOptions& options);

}  // namespace tandem
