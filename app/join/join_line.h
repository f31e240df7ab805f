#pragma once

#include <string>
#include <vector>

#include "app/connection/connection_options.h"

namespace tandem {

/// The options of `tandem join LINE`.
struct JoinLineArguments {
  std::string line;
  std::string hold;
  std::string name;    // empty: none was given
  std::string role;    // likewise
  std::string scene;   // name or file; empty: the session's
  std::string device;  // empty: none was given
  std::string keys_to;
  bool accept_scene = false;
  bool only_keys = false;  // enrol, and take no part
  bool json = false;
  ConnectionOptions connection;      // options beside those of the line
  std::vector<std::string> further;  // options of tandem peer
};

/// Takes part in the session of an invitation, in this process, as `tandem peer` does. In a secured
/// session it first gets a certificate for a key that it makes here. Returns the exit code.
int JoinByLine(const JoinLineArguments& arguments);

}  // namespace tandem
