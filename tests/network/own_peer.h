#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <string>

#include "collab/dds/dds_transport.h"
#include "collab/peer_node.h"
#include "engine/realtime/periodic_thread.h"

namespace tandem::testing {

/// A whole peer over DDS with its threads in the test's own process, holding the peg of
/// peg_in_slot and keeping it where it is.
class OwnPeer {
 public:
  /// A haptic frame: what is to be called in it is the argument.
  using Frame = std::function<void(PeerNode& node, std::int64_t now_ns)>;

  OwnPeer(const std::string& session, PeerId id, Frame frame = DefaultFrame);
  /// Without threads: its frames are the caller's to step, in a time of their own.
  struct Stepped {};
  OwnPeer(const std::string& session, PeerId id, Stepped);
  /// Leaves with a goodbye.
  ~OwnPeer();
  OwnPeer(const OwnPeer&) = delete;
  OwnPeer& operator=(const OwnPeer&) = delete;

  /// Goes on with the control thread's work, on the caller's thread, until `done` or for `seconds`.
  void Run(double seconds, const std::function<bool()>& done);
  /// So many frames, at most one a millisecond: haptic, then sender, every 20th the control
  /// thread's.
  void StepFrames(int count);
  /// Steps until what is held is coupled to another's: each has heard the other, and been heard by
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
