#include <memory>

#include <unistd.h>

#include "app/cli/commands.h"
#include "app/peer/run_peer.h"

namespace tandem {

void AddPeerCommand(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<PeerArguments>();
  arguments->name = "peer-" + std::to_string(getpid());
  CLI::App* command = app.add_subcommand(
      "peer", "Join a session as a peer with simulation and device, without a window");
  AddPeerOptions(*command, *arguments);
  command->callback([arguments, &exit_code] {
    exit_code = RunPeer(*arguments);
  });
}

}  // namespace tandem
