#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "collab/peer/peer_node.h"
#include "collab/recording/recording.h"

namespace tandem {

/// Runs a peer again on its recorded inputs. It is the product's code, and every frame must end in
/// the same bits. One thread; needs no network, clock or device.
class Replay {
 public:
  /// `model`: the recorded scene at the recorded voxel size. Errors: an unknown law, or a body that
  /// the scene does not have.
  static Result<std::unique_ptr<Replay>> Create(const RecordingHeader& header,
                                                std::shared_ptr<const WorldModel> model,
                                                WorkerPool* workers = nullptr);
  ~Replay();

  /// Runs one frame; returns the hash of its final state.
  std::uint64_t Run(const RecordedFrame& frame);

  PeerNode& node() noexcept { return *node_; }

 private:
  class Device;
  class Observer;
  Replay();

  std::unique_ptr<Observer> tap_;
  Device* device_ = nullptr;  // owned by the node
  std::unique_ptr<PeerNode> node_;
};

/// The result of a whole replay.
struct ReplayResult {
  std::int64_t frames = 0;
  std::optional<std::int64_t> first_different;  // number of the frame, from 0; the run ends there
  std::uint64_t recorded_hash = 0;              // hash of the last frame run
  std::uint64_t replayed_hash = 0;
};

/// Replays to the end, or to the first frame that differs. `after_frame` gets each frame and its
/// number; returning false ends the replay.
ReplayResult RunAll(
    RecordingReader& reader, Replay& replay,
    const std::function<bool(std::int64_t number, const RecordedFrame&)>& after_frame = {});

}  // namespace tandem
