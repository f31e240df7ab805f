#include "app/recording/replay_network.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <map>
#include <optional>
#include <system_error>

#include "app/common/console.h"
#include "app/common/exit_codes.h"
#include "app/recording/trace_facts.h"
#include "collab/recording/recording.h"
#include "collab/trace/path_estimator.h"
#include "collab/trace/trace_file.h"
#include "engine/base/text/json_text.h"

namespace tandem {

namespace {

/// Holds the lines to other peers in a recording.
struct PathEstimates {
  std::map<PeerId, PathEstimator> lines;
  std::map<PeerId, std::string> names;

  std::string NameOf(PeerId peer) const {
    const auto name = names.find(peer);
    return name == names.end() ? std::to_string(peer) : name->second;
  }
};

Result<PathEstimates> ReadHeard(const std::string& file) {
  Result<RecordingReader> reader = RecordingReader::Open(file);
  if (!reader) return reader.error();
  const PeerId self = reader->header().peer.id;
  PathEstimates estimates;
  while (const std::optional<RecordedFrame> frame = reader->Next()) {
    for (const ObjectState& state : frame->states) {
      estimates.lines.try_emplace(state.peer, self).first->second.Add(state, frame->now_ns);
    }
    for (const CouplingLinks& links : frame->links) {
      estimates.lines.try_emplace(links.from, self).first->second.Add(links);
    }
  }
  std::erase_if(estimates.lines, [](const auto& line) {
    return line.second.states() == 0;
  });
  estimates.names = reader->names();
  return estimates;
}

/// Returns the peer whose line is asked for.
Result<PeerId> Choose(const PathEstimates& estimates, const std::string& from) {
  std::string names;
  for (const auto& [peer, line] : estimates.lines) {
    if (!from.empty() && estimates.NameOf(peer) == from) return peer;
    names += (names.empty() ? "" : ", ") + estimates.NameOf(peer);
  }
  if (estimates.lines.empty())
    return Error{"the recording has no messages of a peer that held a body"};
  if (from.empty() && estimates.lines.size() == 1) return estimates.lines.begin()->first;
  if (from.empty())
    return Error{"the recording has several peers: give --from with one of " + names};
  return Error{"the recording has no peer called " + from + "; its peers: " + names};
}

/// Makes a trace without echoes. Nothing is known then of the way there, nor of the clocks. So the
/// smallest age of the way back stands for no delay, and both ways are alike.
NetworkTrace OneWay(const PathRecord& record) {
  std::int64_t least = std::numeric_limits<std::int64_t>::max();
  for (const std::int64_t ns : record.back_ns) {
    if (ns != PathRecord::kNever) least = std::min(least, ns);
  }
  NetworkTrace trace = TraceOf({.rate_hz = record.rate_hz, .back_ns = record.back_ns},
                               {.offset_ns = -least, .bound_ms = -1});
  trace.there_ms = trace.back_ms;
  return trace;
}

}  // namespace

int RunAsNetwork(const std::string& recording, const std::string& file, const std::string& from,
                 bool json) {
  std::error_code not_there;  // set if there is no such file: then it differs
  if (std::filesystem::equivalent(recording, file, not_there)) {
    return Fail(kExitUsage, file + ": is the recording itself: name another file");
  }
  const Result<PathEstimates> estimates = ReadHeard(recording);
  if (!estimates) return Fail(kExitFile, estimates.error().what);
  const Result<PeerId> peer = Choose(*estimates, from);
  if (!peer) return Fail(kExitFailed, recording + ": " + peer.error().what);
  const std::string name = estimates->NameOf(*peer);
  const std::optional<PathEstimator::Estimate> found = estimates->lines.at(*peer).EstimatePath();
  if (!found)
    return Fail(kExitFailed, recording + ": the recording has too few messages of " + name);
  NetworkTrace trace = found->has_echoes ? TraceOf(found->record, EstimateClocks(found->record))
                                         : OneWay(found->record);
  trace.source = "tandem replay --as-network, received from " + name;
  if (const auto failed = WriteNetworkTrace(file, trace)) return Fail(kExitFile, failed->what);
  if (json) {
    nlohmann::ordered_json out = FactsAsJson(trace);
    out["from"] = name;
    out["echoes"] = found->has_echoes;
    PrintText(JsonText(out, 2));
    return kExitOk;
  }
  PrintText(FactsAsText(trace));
  if (found->has_echoes) {
    PrintLine(
        "one-way delay: known within %.2f ms (half the least loop age, from echoes); arrivals are "
        "known to a frame of 1 ms",
        trace.clock_bound_ms);
  } else {
    PrintLine(
        "one-way delay: no echoes came, so the smallest age counts as no delay, and both ways are "
        "alike");
  }
  PrintLine("%s: %.1f s of messages from %s", file.c_str(), found->seconds, name.c_str());
  return kExitOk;
}

}  // namespace tandem
