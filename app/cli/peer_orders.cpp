#include "app/cli/peer_orders.h"

#include <array>
#include <sstream>
#include <utility>

#include <poll.h>
#include <unistd.h>

namespace tandem {

namespace {

const Error kTooLong{"a line of more than " + std::to_string(OrderReader::kLongest) +
                     " bytes is no order, and is left out"};

}  // namespace

Result<Command> ParseOrder(const std::string& line, const WorldModel& model,
                           const PeerDirectory& directory, bool own_only) {
  std::istringstream words(line);
  std::string verb;
  std::string body;
  std::string peer;
  words >> verb >> body;
  std::getline(words >> std::ws, peer);
  if (verb == "release" && body.empty()) return Command{Command::Kind::kRelease, kNoObject, 0};
  if (verb == "heal" && body.empty()) return Command{Command::Kind::kHeal, kNoObject, 0};
  const bool grab = verb == "grab" && !body.empty() && peer.empty();
  const bool give = verb == "give" && !peer.empty();
  if (!grab && !give) {
    return Error{"'" + line +
                 "' is no order: grab BODY, release, give BODY PEER, heal, peers, or network FILE"};
  }
  const int found = model.BodyNamed(body);
  if (found < 0) return Error{"the scene has no moving body '" + body + "'"};
  const ObjectId object = model.object[static_cast<std::size_t>(found)];
  if (grab && own_only && model.scene.bodies[object].shared) {
    return Error{"'" + body + "' is shared: it is not held by other force parameters (--insist)"};
  }
  if (grab) return Command{Command::Kind::kGrab, object, 0};
  const PeerId to = directory.PeerNamed(peer);
  if (to == 0) return Error{"nobody here who takes part is called '" + peer + "'"};
  return Command{Command::Kind::kGive, object, to};
}

std::size_t OrderReader::Read() {
  if (ended_ || (isatty(input_) != 0 && tcgetpgrp(input_) != getpgrp())) return 0;
  pollfd input{input_, POLLIN, 0};
  if (poll(&input, 1, 0) <= 0) return 0;
  std::array<char, 512> buffer;
  const ssize_t size = read(input_, buffer.data(), buffer.size());
  if (size > 0) {
    pending_.append(buffer.data(), static_cast<std::size_t>(size));
    return static_cast<std::size_t>(size);
  }
  ended_ = true;
  // the last line need not be ended
  if (!pending_.empty()) pending_ += '\n';
  return 0;
}

std::vector<Result<std::string>> OrderReader::TakeLines() {
  std::vector<Result<std::string>> lines;
  std::size_t taken = 0;
  while (lines.size() < kMostLines) {
    const std::size_t end = pending_.find('\n');
    if (end != std::string::npos) {
      const bool tail = std::exchange(too_long_, false);
      if (!tail && end > kLongest) {
        lines.push_back(kTooLong);
      } else if (!tail && end > 0) {
        lines.push_back(pending_.substr(0, end));
      }
      pending_.erase(0, end + 1);
      continue;
    }
    if (pending_.size() > kLongest || too_long_) {
      if (!too_long_) lines.push_back(kTooLong);
      too_long_ = true;
      pending_.clear();
    }
    if (taken >= kMostBytes) break;
    const std::size_t size = Read();
    taken += size;
    if (size == 0 && pending_.find('\n') == std::string::npos) break;
  }
  return lines;
}

}  // namespace tandem
