#pragma once

#include <string>
#include <vector>

#include "collab/session/command.h"
#include "collab/session/peer_directory.h"
#include "engine/base/result.h"
#include "engine/world/world_model.h"

namespace tandem {

/// Returns the command that a user's line asks for: `grab BODY`, `release`, `give BODY PEER`,
/// `heal`, `layer N`, `displace MM`, `stop`, `resume`. An error says what is not understood, not
/// there, or beyond its bounds. With `own_only` it is an error to take a shared body.
Result<Command> ParseOrder(const std::string& line, const WorldModel& model,
                           const PeerDirectory& directory, bool own_only = false);

/// Returns the lines that tell a user what each order does.
std::vector<std::string> HelpOnOrders();

/// Returns in a line what a user must know of an order that is obeyed; empty: nothing.
std::string AnswerTo(const Command& order, const WorldModel& model);

/// Reads the lines of standard input as they come, and never waits. In the background of a terminal
/// it reads nothing, because a read would stop the program.
///
/// A turn is short, however much comes. It takes at most `kMostLines` lines and `kMostBytes` bytes,
/// and the rest waits in the pipe. A line longer than `kLongest` bytes is an error, said once.
class OrderReader {
 public:
  static constexpr std::size_t kLongest = 512;
  static constexpr std::size_t kMostBytes = 4096;
  static constexpr std::size_t kMostLines = 16;

  /// `input`: a file descriptor, which its owner closes.
  explicit OrderReader(int input = 0) : input_(input) {}

  std::vector<Result<std::string>> TakeLines();

 private:
  /// Reads the bytes that can be had at once, and returns their number. Notes the end.
  std::size_t Read();

  int input_;
  bool ended_ = false;
  bool too_long_ = false;  // the present line is too long
  std::string pending_;    // bytes read and not yet taken; at most kLongest and a read
};

}  // namespace tandem
