#include "app/process/peer_command_line.h"

#include "app/process/child_processes.h"

namespace tandem {

std::vector<std::string> CommandLineOf(const LocalPeer& peer,
                                       const std::vector<std::string>& more) {
  std::vector<std::string> words{(ProgramFolder() / "tandem").string(),
                                 "peer",
                                 "--session",
                                 peer.session,
                                 "--scene",
                                 peer.scene.string(),
                                 "--interface",
                                 peer.interface,
                                 "--name",
                                 peer.name,
                                 "--wait-for",
                                 std::to_string(peer.wait_for),
                                 "--seconds",
                                 std::to_string(peer.seconds),
                                 "--report",
                                 peer.report.string(),
                                 "--brief"};
  if (peer.hand) {
    words.insert(words.end(), {"--hold", peer.hand->body, "--hand", peer.hand->file.string()});
  }
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

}  // namespace tandem
