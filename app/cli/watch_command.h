#pragma once

#include <functional>
#include <string>

#include <CLI/CLI.hpp>

#include "app/cli/peer_options.h"
#include "app/cli/scene_consent.h"
#include "app/reach/reach_options.h"

namespace tandem {

/// What `tandem watch` was asked for.
struct WatchOptions {
  std::string session;
  std::string scene;  // to be compared with the session's; empty: no comparison
  bool scene_from_session = false;  // has the scene at hand, fetched where it is not here
  SceneFetchOptions fetch;
  std::string name;
  ReachOptions reach;
  double seconds = 0;  // 0: until a signal comes
  std::string report;
  bool json = false;
  bool from_relay = false;  // of a relay's viewers instead of the session's own
  /// Called once it is in the session. Null: nobody asks.
  std::function<void(const EnteredSession&)> on_entered;
  bool as_part = false;  // of a command that starts the session too, and says what it is
};

/// A viewer without a window: a line on stderr for each coming and going, one a second on what is
/// received, and a report at the end (in a file, and on stdout with --json). Gives the exit code.
int WatchCommand(const WatchOptions& options);

void AddWatchCommand(CLI::App& app, int& exit_code);

}  // namespace tandem
