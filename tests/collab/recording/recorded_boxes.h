#pragma once

#include <filesystem>
#include <functional>
#include <memory>

#include "collab/peer/peer_node.h"
#include "collab/recording/recorder.h"
#include "collab/recording/replay.h"

namespace tandem::testing {

/// Returns a shared box on a plate, and a box of one's own beside it.
std::shared_ptr<const WorldModel> Boxes();

/// Returns a header with a number of its own in every field.
RecordingHeader HeaderOf(PeerId id, int object);

/// Makes a whole peer that kneads what the header says, over a bad link.
std::unique_ptr<PeerNode> NodeOf(const std::shared_ptr<const WorldModel>& model,
                                 const RecordingHeader& header, FrameObserver* observer,
                                 double phase);

std::unique_ptr<Recorder> Record(const std::filesystem::path& file, const RecordingHeader& header);

ReplayResult ReplayFile(const std::filesystem::path& file,
                        const std::shared_ptr<const WorldModel>& model);

/// Records one peer of a session of two for so many frames. `before` each frame its peer is asked
/// something.
void RecordAlone(const std::filesystem::path& file, const std::shared_ptr<const WorldModel>& model,
                 int frames, const std::function<void(Peer&, int)>& before = {});

/// Returns whether a replay differs anywhere from its recording once each frame is altered.
bool DiffersWith(const std::filesystem::path& file, const std::shared_ptr<const WorldModel>& model,
                 const std::function<void(RecordedFrame&, int)>& alter);

}  // namespace tandem::testing
