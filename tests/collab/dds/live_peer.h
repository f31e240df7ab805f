#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "collab/dds/transport/dds_transport.h"

namespace tandem::testing {

/// Returns a session name that no other test uses.
std::string RandomSession();

/// Returns a UDP port that is free now, and so is the next.
std::uint16_t FreePortPair();

/// Keeps what a peer has heard so far, and waits for it.
class Recorder : public Inbox {
 public:
  struct Heard {
    std::map<PeerId, ObjectState> states;  // newest of each
    std::map<PeerId, CouplingLinks> links;
    std::map<PeerId, ViewFrame> views;
    std::map<PeerId, PeerInfo> infos;
    std::vector<SceneManifest> scenes;
    std::vector<Event> events;
    std::map<PeerId, int> info_count, left, lost;
    std::map<std::pair<PeerId, Drop>, int> dropped;
    int twins = 0;
  };

  /// Called with a word and an id at the first of each kind from each peer, and at each leave, loss
  /// and return.
  std::function<void(const char* what, std::uint64_t id)> tell = [](const char*, std::uint64_t) {};

  Heard Now() const;
  /// Returns whether `holds` came true before the deadline.
  bool WaitFor(std::function<bool(const Heard&)> holds,
               std::chrono::milliseconds deadline = std::chrono::seconds(60)) const;

  void OnState(const ObjectState& state, std::int64_t arrival_ns) override;
  void OnLinks(const CouplingLinks& links, std::int64_t arrival_ns) override;
  void OnView(const ViewFrame& frame, std::int64_t arrival_ns) override;
  void OnPeerInfo(const PeerInfo& info, std::int64_t arrival_ns) override;
  void OnPeerLeft(PeerId peer) override;
  void OnPeerLost(PeerId peer) override;
  void OnEvent(const Event& event, std::int64_t arrival_ns) override;
  void OnScene(const SceneManifest& manifest) override;
  void OnTwin(const PeerInfo& info) override;
  void OnDropped(PeerId from, Drop reason) override;

  /// Arrival less the sender's stamp, of peers on this machine, whose clock is ours.
  std::vector<std::int64_t> state_ages_ns;

 private:
  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
  Heard received_;
};

/// A peer in a session over loopback that keeps saying the same: its states, links and views at 1
/// kHz / 60 Hz, its peer_info five times a second, its scene once.
class LivePeer {
 public:
  LivePeer(std::unique_ptr<Transport> transport, DdsOptions options, PeerId claimed);
  ~LivePeer();  // falls silent without a goodbye
  void Leave();

 private:
  void Run();

  std::unique_ptr<Transport> transport_;
  const DdsOptions options_;
  const PeerId claimed_;
  std::atomic<bool> stop_ = false;
  std::thread thread_;
};

DdsOptions LoopbackOptions(const std::string& session, PeerId peer, Role role);

/// Samples of the messages that the tests' peers send.
ObjectState SampleState(PeerId peer, std::uint32_t seq);
CouplingLinks SampleLinks(PeerId peer, std::uint32_t seq);
ViewFrame SampleView(PeerId peer, std::uint32_t seq);
PeerInfo SampleInfo(PeerId peer, Role role, std::uint32_t beat);
SceneManifest SampleScene(PeerId peer);

}  // namespace tandem::testing
