#pragma once

#include <string>
#include <vector>

#include "app/reach/reach_options.h"

namespace tandem {

/// These options were given to `tandem join LINE`.
struct JoinLineArguments {
  std::string line;
  std::string hold;
  std::string name;    // empty: none was given
  std::string role;    // likewise
  std::string scene;   // by name, or a file; empty: the session's
  std::string device;  // empty: none was given
  std::string keys_to;
  bool accept_scene = false;
  bool only_keys = false;  // enrols, and takes no part
  bool json = false;
  ReachOptions reach;                // beside what the line says
  std::vector<std::string> further;  // options of tandem peer
};

/// Takes part in the session of an invitation, in this process, by what `tandem peer` does. In a
/// secured session it first gets a certificate for a key that it makes here. Gives the exit code.
int JoinByLine(const JoinLineArguments& arguments);

}  // namespace tandem
