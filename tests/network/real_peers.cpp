#include "tests/network/real_peers.h"

#include <fstream>
#include <random>

#include "engine/base/check.h"

namespace tandem::testing {

RealPeers::RealPeers(const Options& options)
    : session_("test-" + std::to_string(std::random_device{}())) {
  const std::filesystem::path scenes = TANDEM_SCENES;
  for (int i = 0; i < options.count; ++i) {
    const char* hand = i % 2 == 0 ? "peg_in_slot_left.json" : "peg_in_slot_right.json";
    const std::vector<std::string> peer{
        TANDEM_PROGRAM, "peer",
        "--session",    session_,
        "--scene",      (scenes / "peg_in_slot.json").string(),
        "--interface",  "lo",
        "--name",       "peer-" + std::to_string(i),
        "--hold",       "peg",
        "--hand",       (scenes / hand).string(),
        "--wait-for",   std::to_string(options.count - 1),
        "--capacity",   "20000",
        "--law",        options.law,
        "--seconds",    std::to_string(options.seconds),
        "--report",     ReportFile(static_cast<std::size_t>(i)).string()};
    std::vector<std::string> command = peer;
    if (!options.output.empty()) {
      // through a shell that puts both streams into the file and then is the peer
      command = {"/bin/sh", "-c", R"(f="$1"; shift; exec "$@" >>"$f" 2>&1)", "sh", options.output};
      command.insert(command.end(), peer.begin(), peer.end());
    }
    Result<ChildProcess> started = ChildProcess::Start(command);
    TANDEM_CHECK(started.has_value());
    peers_.push_back(std::move(*started));
  }
}

std::vector<int> RealPeers::Wait() {
  std::vector<int> codes;
  for (ChildProcess& peer : peers_)
    codes.push_back(peer.Wait(std::chrono::seconds(60)).value_or(-1));
  return codes;
}

nlohmann::json RealPeers::Report(std::size_t i) const {
  std::ifstream stream(ReportFile(i));
  return nlohmann::json::parse(stream, nullptr, false);
}

std::filesystem::path RealPeers::ReportFile(std::size_t i) const {
  return folder_.path() / ("peer" + std::to_string(i) + ".json");
}

}  // namespace tandem::testing
