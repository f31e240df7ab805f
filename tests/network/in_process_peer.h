#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <string>

#include "collab/dds/transport/dds_transport.h"
#include "collab/peer/peer_node.h"
#include "engine/realtime/periodic_thread.h"

namespace tandem::testing {

/// A whole peer over DDS with its threads in the test's own process, holding the peg of
/// peg_in_slot and keeping it where it is.
class InProcessPeer {
 public:
  /// The work of a haptic frame, around which a test may do its own.
  using Frame = std::function<void(PeerNode& node, std::int64_t now_ns)>;

  InProcessPeer(const std::string& session, PeerId id, Frame frame = DefaultFrame);
  /// Tag of a peer without threads: its caller steps its frames, in a time of their own.
  struct Stepped {};
  InProcessPeer(const std::string& session, PeerId id, Stepped);
  /// Leaves with a goodbye.
  ~InProcessPeer();
  InProcessPeer(const InProcessPeer&) = delete;
  InProcessPeer& operator=(const InProcessPeer&) = delete;

  /// Goes on with the control thread's work, on the caller's thread, until `done` or for `seconds`.
  void Run(double seconds, const std::function<bool()>& done);
  /// Steps so many frames, at most one a millisecond: haptic, then sender, every 20th the control
  /// thread's.
  void StepFrames(int count);
  /// Steps until the held body is coupled to another's: each has heard the other, and been heard by
  /// it. False: not within a minute.
  bool StepUntilCoupled();

 private:
  void Join(const std::string& session, PeerId id);
  static void DefaultFrame(PeerNode& node, std::int64_t now_ns);

  std::unique_ptr<PeerNode> node_;
  std::unique_ptr<Transport> transport_;
  std::unique_ptr<PeriodicThread> haptic_;
  std::unique_ptr<PeriodicThread> sender_;
  std::int64_t stepped_ = 0;  // frames
  std::int64_t began_ns_ = 0;
};

}  // namespace tandem::testing
