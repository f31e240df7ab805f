#include "app/cli/peer_orders.h"

#include <array>
#include <sstream>

#include <poll.h>
#include <unistd.h>

namespace tandem {

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

std::vector<std::string> OrderReader::TakeLines() {
  std::vector<std::string> lines;
  while (!ended_) {
    if (isatty(STDIN_FILENO) != 0 && tcgetpgrp(STDIN_FILENO) != getpgrp()) break;
    pollfd input{STDIN_FILENO, POLLIN, 0};
    if (poll(&input, 1, 0) <= 0) break;
    std::array<char, 512> buffer;
    const ssize_t size = read(STDIN_FILENO, buffer.data(), buffer.size());
    if (size <= 0) {
      ended_ = true;
      break;
    }
    pending_.append(buffer.data(), static_cast<std::size_t>(size));
  }
  for (std::size_t end = pending_.find('\n'); end != std::string::npos; end = pending_.find('\n')) {
    if (end > 0) lines.push_back(pending_.substr(0, end));
    pending_.erase(0, end + 1);
  }
  return lines;
}

}  // namespace tandem
