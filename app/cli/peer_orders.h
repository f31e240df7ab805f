#pragma once

#include <string>
#include <vector>

#include "collab/command.h"
#include "collab/peer_directory.h"
#include "engine/base/result.h"
#include "engine/world/world_model.h"

namespace tandem {

/// What a line of a user's asks for: `grab BODY`, `release`, `give BODY PEER`, `heal`. An error
/// says what is not understood, or not there; with `own_only`, that a shared body is not taken.
Result<Command> ParseOrder(const std::string& line, const WorldModel& model,
                           const PeerDirectory& directory, bool own_only = false);

/// The lines of standard input, as they come; never waits. Where we run in the background of a
/// terminal nothing is read, which would stop the program.
class OrderReader {
 public:
  std::vector<std::string> TakeLines();

 private:
  bool ended_ = false;
  std::string pending_;
};

}  // namespace tandem
