#pragma once

#include <string>
#include <vector>

#include "collab/command.h"
#include "collab/peer_directory.h"
#include "engine/base/result.h"
#include "engine/world/world_model.h"

namespace tandem {

/// What a line of a user's asks for: `grab BODY`, `release`, `give BODY PEER`, `heal`, `layer N`,
/// `displace MM`, `stop`, `resume`. An error says what is not understood, not there, or beyond what may be; with
/// `own_only`, that a shared body is not taken.
Result<Command> ParseOrder(const std::string& line, const WorldModel& model,
                           const PeerDirectory& directory, bool own_only = false);

/// Returns a line for each order, which says what the order does.
std::vector<std::string> HelpOnOrders();

/// What there is to know of an order that is obeyed, in a line; empty: nothing.
std::string AnswerTo(const Command& order, const WorldModel& model);

/// The lines of standard input, as they come; never waits. Where we run in the background of a
/// terminal nothing is read, which would stop the program.
///
/// However much comes, a turn is short: at most `kMostLines` lines and `kMostBytes` bytes of it,
/// the rest waits in the pipe. A line longer than `kLongest` bytes is an error, said once.
class OrderReader {
 public:
  static constexpr std::size_t kLongest = 512;
  static constexpr std::size_t kMostBytes = 4096;
  static constexpr std::size_t kMostLines = 16;

  /// `input`: a file descriptor, which stays its owner's.
  explicit OrderReader(int input = 0) : input_(input) {}

  std::vector<Result<std::string>> TakeLines();

 private:
  /// What can be had at once, 0 bytes or more; notes the end.
  std::size_t Read();

  int input_;
  bool ended_ = false;
  bool too_long_ = false;  // the line that we are in
  std::string pending_;    // read and not yet taken; at most kLongest and a read
};

}  // namespace tandem
