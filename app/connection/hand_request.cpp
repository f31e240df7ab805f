#include "app/connection/hand_request.h"

namespace tandem {

std::vector<std::string> ControllerCommandLine(const HandRequest& request) {
  const bool own = request.session.empty();
  std::vector<std::string> words{"peer",
                                 "--control",
                                 request.control,
                                 "--session",
                                 own ? request.control : request.session,
                                 "--scene",
                                 request.scene,
                                 "--name",
                                 request.name,
                                 "--domain",
                                 std::to_string(request.domain)};
  const auto add = [&words](const char* option, const std::string& value) {
    if (value.empty()) return;
    words.emplace_back(option);
    words.push_back(value);
  };
  // a session without a name of its own stays on this machine
  add("--interface", own && request.interface.empty() ? "lo" : request.interface);
  std::string peers;
  for (const std::string& peer : request.peers) peers += (peers.empty() ? "" : ",") + peer;
  add("--peers", peers);
  add("--external-address", request.external_address);
  add("--port", request.port == 0 ? "" : std::to_string(request.port));
  add("--secure", request.secure);
  add("--device", request.device);
  words.insert(words.end(), request.further.begin(), request.further.end());
  return words;
}

}  // namespace tandem
