#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "collab/peer_node.h"
#include "collab/recording/recording.h"

namespace tandem {

/// Runs a peer again from what it was recorded to have heard, felt and been asked: the product's
/// code on the recorded inputs, which must end every frame in the same bits. One thread; needs no
/// network, clock or device.
class Replay {
 public:
  /// `model`: the recorded scene at the recorded voxel size. Errors: an unknown law, a body that
  /// the scene does not have.
  static Result<std::unique_ptr<Replay>> Create(const RecordingHeader& header,
                                                std::shared_ptr<const WorldModel> model,
                                                FrameHelpers* helpers = nullptr);
  ~Replay();

  /// Does one frame; gives the hash of the state that it ended in.
  std::uint64_t Run(const RecordedFrame& frame);

  PeerNode& node() noexcept { return *node_; }

 private:
  class Device;
  class Tap;
  Replay();

  std::unique_ptr<Tap> tap_;
  Device* device_ = nullptr;  // the node's
  std::unique_ptr<PeerNode> node_;
};

/// What became of a whole recording.
struct ReplayResult {
  std::int64_t frames = 0;
  std::optional<std::int64_t> first_different;  // number of the frame, from 0; the run ends there
  std::uint64_t recorded_hash = 0;              // of the last frame done
  std::uint64_t replayed_hash = 0;
};

/// Replays to the end, or to the first frame that differs. `after_frame` is told each frame's
/// number; false ends it.
ReplayResult RunAll(
    RecordingReader& reader, Replay& replay,
    const std::function<bool(std::int64_t number, const RecordedFrame&)>& after_frame = {});

}  // namespace tandem
