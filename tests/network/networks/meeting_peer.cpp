// A peer of a session on the networks of its machine, for tests of networks: meeting_peer SESSION
// ID KEYS INTERFACE PEERS FILE. An argument '-' is none. It sends states at 100 Hz and keeps what
// it sees of the one other peer in FILE, until its input ends.
#include <cstdio>
#include <iostream>
#include <string>
#include <thread>

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include "collab/dds/transport/dds_transport.h"
#include "engine/realtime/clock.h"
#include "tests/network/networks/meeting_status.h"

namespace {

using namespace tandem;

class StatusInbox final : public Inbox {
 public:
  explicit StatusInbox(testing::MeetingStatus& status) : status_(status) {}
  void OnState(const ObjectState&, std::int64_t arrival_ns) override {
    status_.arrived_ns = arrival_ns;
  }
  void OnLinks(const CouplingLinks&, std::int64_t) override {}
  void OnView(const ViewFrame&, std::int64_t) override {}
  void OnPeerInfo(const PeerInfo&, std::int64_t) override { status_.here = 1; }
  void OnPeerLeft(PeerId) override { status_.here = 0; }
  void OnPeerLost(PeerId) override {
    status_.here = 0;
    ++status_.lost;
  }
  void OnEvent(const Event&, std::int64_t) override {}
  void OnScene(const SceneManifest&) override {}

 private:
  testing::MeetingStatus& status_;
};

std::string Given(const char* argument) {
  return std::string(argument) == "-" ? std::string() : std::string(argument);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 7) return 2;
  const int file = open(argv[6], O_RDWR | O_CLOEXEC);
  void* const mapped =
      mmap(nullptr, sizeof(testing::MeetingStatus), PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
  if (mapped == MAP_FAILED) return 2;
  auto& status = *static_cast<testing::MeetingStatus*>(mapped);

  StatusInbox inbox(status);
  DdsOptions options;
  options.session = argv[1];
  options.peer = std::stoull(argv[2]);
  options.secure = Given(argv[3]);
  options.interface = Given(argv[4]);
  if (!Given(argv[5]).empty()) options.peers = {argv[5]};
  options.objects = {7};
  auto transport = JoinOverDds(options, inbox);
  if (!transport) {
    std::fprintf(stderr, "%s\n", transport.error().what.c_str());
    return 5;
  }
  status.began_ns = MonotonicNowNs();
  std::jthread sender([&](const std::stop_token& stop) {
    ObjectState state;
    state.peer = options.peer;
    state.object = 7;
    PeerInfo info;
    info.peer = options.peer;
    info.name = "peer " + std::string(argv[2]);
    for (std::uint32_t i = 0; !stop.stop_requested(); ++i) {
      state.sample_ns = MonotonicNowNs();
      (*transport)->Publish(state);
      info.beat = i;
      if (i % 20 == 0) (*transport)->Publish(info);
      MachineClock().SleepUntil(MonotonicNowNs() + 10'000'000);
    }
  });
  for (std::string line; std::getline(std::cin, line);) {
  }
  sender.request_stop();
  sender.join();
  (*transport)->Leave();
  return 0;
}
