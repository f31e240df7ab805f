// A peer in a process of its own, for the tests: dds_test_peer SESSION ID active|viewer CLAIMED-ID
// PORT PEER-PORT KEYS Says what happens to it line by line ("ready", "state 11", "left 11" …) and
// obeys lines: "leave" says goodbye, "drop" or the end of input does not; both end it.
#include <cstdio>
#include <iostream>
#include <string>

#include "tests/collab/dds/live_peer.h"

int main(int argc, char** argv) {
  using namespace tandem;
  using namespace tandem::testing;
  if (argc != 8) return 2;
  const PeerId id = std::stoull(argv[2]);
  const Role role = std::string(argv[3]) == "viewer" ? Role::kViewer : Role::kActive;

  Recorder recorder;
  recorder.tell = [](const char* what, std::uint64_t peer) {
    std::printf("%s %llu\n", what, static_cast<unsigned long long>(peer));
    std::fflush(stdout);
  };
  DdsOptions options = LoopbackOptions(argv[1], id, role);
  options.port = static_cast<std::uint16_t>(std::stoul(argv[5]));
  if (options.port != 0) options.peers = {std::string("127.0.0.1:") + argv[6]};
  options.secure = argv[7];
  auto transport = JoinOverDds(options, recorder);
  if (!transport) {
    std::fprintf(stderr, "%s\n", transport.error().what.c_str());
    return 5;
  }
  LivePeer peer(*std::move(transport), options, std::stoull(argv[4]));
  std::puts("ready");
  std::fflush(stdout);
  std::string command;
  while (std::getline(std::cin, command)) {
    if (command == "leave") peer.Leave();
    if (command == "leave" || command == "drop") break;
  }
  return 0;
}
