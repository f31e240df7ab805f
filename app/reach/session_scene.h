#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <stop_token>
#include <string>

#include "app/reach/reach_options.h"
#include "collab/messages.h"

namespace tandem {

/// Whose scene is sought, and as whom.
struct SessionSceneOptions {
  std::string session;
  PeerId id = 0;
  Role role = Role::kActive;
  ReachOptions reach;
  bool from_relay = false;  // look through a relay, which has no files
  /// Says a line to the person.
  std::function<void(const std::string& line)> say;
  std::stop_token stop;
};

/// The file of a session's scene on this machine.
struct SessionScene {
  std::filesystem::path file;  // empty: there is none
  int exit_code = 0;           // of ExitCode, with `fault`; 0 and no file: it was told to stop
  std::string fault;           // one line: what happened, and what to do
};

/// Joins the session without a word, hears which scene it goes by, and looks for that scene on this
/// machine. Has left the session again when it returns.
SessionScene FindSessionScene(const SessionSceneOptions& options);

}  // namespace tandem
