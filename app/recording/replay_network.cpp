#include "app/recording/replay_network.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <map>
#include <optional>
#include <system_error>

#include "app/common/exit_codes.h"
#include "app/common/talk.h"
#include "app/recording/trace_facts.h"
#include "collab/recording/recording.h"
#include "collab/trace/heard_line.h"
#include "collab/trace/trace_file.h"
#include "engine/base/text/json_text.h"

namespace tandem {

namespace {

/// Holds the lines to other peers in a recording.
struct HeardOf {
  std::map<PeerId, HeardLine> lines;
  std::map<PeerId, std::string> names;

  std::string NameOf(PeerId peer) const {
    const auto name = names.find(peer);
    return name == names.end() ? std::to_string(peer) : name->second;
  }
};

Result<HeardOf> ReadHeard(const std::string& file) {
  Result<RecordingReader> reader = RecordingReader::Open(file);
  if (!reader) return reader.error();
  const PeerId self = reader->header().peer.id;
  HeardOf heard;
  while (const std::optional<RecordedFrame> frame = reader->Next()) {
    for (const ObjectState& state : frame->states) {
      heard.lines.try_emplace(state.peer, self).first->second.Heard(state, frame->now_ns);
    }
    for (const CouplingLinks& links : frame->links) {
      heard.lines.try_emplace(links.from, self).first->second.Heard(links);
    }
  }
  std::erase_if(heard.lines, [](const auto& line) {
    return line.second.states() == 0;
  });
  heard.names = reader->names();
  return heard;
}

/// Returns the peer whose line is asked for.
Result<PeerId> Choose(const HeardOf& heard, const std::string& from) {
  std::string names;
  for (const auto& [peer, line] : heard.lines) {
    if (!from.empty() && heard.NameOf(peer) == from) return peer;
    names += (names.empty() ? "" : ", ") + heard.NameOf(peer);
  }
  if (heard.lines.empty()) return Error{"the recording has no messages of a peer that held a body"};
  if (from.empty() && heard.lines.size() == 1) return heard.lines.begin()->first;
  if (from.empty())
    return Error{"the recording has several peers: give --from with one of " + names};
  return Error{"the recording has no peer called " + from + "; its peers: " + names};
}

/// Makes a trace without echoes. Nothing is known then of the way there, nor of the clocks. So the
/// smallest age of the way back stands for no delay, and both ways are alike.
NetworkTrace OneWay(const LineRecord& record) {
  std::int64_t least = std::numeric_limits<std::int64_t>::max();
  for (const std::int64_t ns : record.back_ns) {
    if (ns != LineRecord::kNever) least = std::min(least, ns);
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
  const Result<HeardOf> heard = ReadHeard(recording);
  if (!heard) return Fail(kExitFile, heard.error().what);
  const Result<PeerId> peer = Choose(*heard, from);
  if (!peer) return Fail(kExitFailed, recording + ": " + peer.error().what);
  const std::string name = heard->NameOf(*peer);
  const std::optional<HeardLine::Found> found = heard->lines.at(*peer).Find();
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
    std::printf("%s\n", JsonText(out, 2).c_str());
    return kExitOk;
  }
  std::printf("%s", FactsAsText(trace).c_str());
  if (found->has_echoes) {
    std::printf(
        "one-way delay: known within %.2f ms (half the least loop age, from echoes); arrivals are "
        "known to a frame of 1 ms\n",
        trace.clock_bound_ms);
  } else {
    std::printf(
        "one-way delay: no echoes came, so the smallest age counts as no delay, and both ways are "
        "alike\n");
  }
  std::printf("%s: %.1f s of messages from %s\n", file.c_str(), found->seconds, name.c_str());
  return kExitOk;
}

}  // namespace tandem
