#include "app/recording/recording_trace.h"

#include <algorithm>
#include <map>
#include <optional>

#include "collab/recording/recording.h"
#include "collab/trace/path_estimator.h"

namespace tandem {

namespace {

/// Holds what a recording heard of one other peer.
struct HeardInstance {
  explicit HeardInstance(PeerId self) : line(self) {}

  PathEstimator line;
  std::vector<TraceSample> poses;  // times by the peer's clock
};

}  // namespace

Result<std::vector<TraceSample>> TraceOfRecording(const std::filesystem::path& recording,
                                                  ObjectId object) {
  Result<RecordingReader> reader = RecordingReader::Open(recording);
  if (!reader) return reader.error();
  const PeerId self = reader->header().peer.id;
  std::map<PeerId, HeardInstance> received;
  while (const std::optional<RecordedFrame> frame = reader->Next()) {
    for (const ObjectState& state : frame->states) {
      if (state.object != object) continue;
      HeardInstance& instance = received.try_emplace(state.peer, self).first->second;
      instance.line.Add(state, frame->now_ns);
      TraceSample sample;
      sample.time_ns = state.sample_ns;
      sample.X_WB = state.X_WB;
      instance.poses.push_back(sample);
    }
    for (const CouplingLinks& links : frame->links) {
      if (links.object == object) {
        received.try_emplace(links.from, self).first->second.line.Add(links);
      }
    }
  }
  const auto most = std::ranges::max_element(received, {}, [](const auto& of) {
    return of.second.poses.size();
  });
  if (most == received.end()) return std::vector<TraceSample>{};
  const std::optional<PathEstimator::Estimate> found = most->second.line.EstimatePath();
  if (!found || !found->has_echoes) return std::vector<TraceSample>{};
  const ClockEstimate clocks = EstimateClocks(found->record);
  std::vector<TraceSample> poses = std::move(most->second.poses);
  for (TraceSample& sample : poses) sample.time_ns -= clocks.offset_ns;
  std::ranges::sort(poses, {}, &TraceSample::time_ns);
  return poses;
}

}  // namespace tandem
