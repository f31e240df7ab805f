#include "app/doctor/doctor_trace.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

#include <nlohmann/json.hpp>

#include "app/common/console.h"
#include "app/common/exit_codes.h"
#include "app/common/option_checks.h"
#include "app/common/output_file.h"
#include "app/common/stop_signal.h"
#include "app/recording/trace_facts.h"
#include "collab/dds/diagnostics/path_recorder.h"
#include "collab/dds/transport/domain.h"
#include "collab/trace/trace_file.h"
#include "engine/base/text/json_text.h"

namespace tandem {

namespace {

using OrderedJson = nlohmann::ordered_json;

struct Spread {
  double least = 0;
  double median = 0;
  double most_of_hundred = 0;  // 99th percentile
  double most = 0;
};

Spread SpreadOf(std::vector<double> values) {
  if (values.empty()) return {};
  std::ranges::sort(values);
  const auto at = [&values](double share) {
    return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
  };
  return {values.front(), at(0.5), at(0.99), values.back()};
}

OrderedJson AsJson(const Spread& spread) {
  return {{"least_ms", spread.least},
          {"median_ms", spread.median},
          {"in_99_of_100_ms", spread.most_of_hundred},
          {"most_ms", spread.most}};
}

void PrintSpread(const char* what, const Spread& spread) {
  PrintLine("%s %.2f ms median, %.2f ms at the least, %.2f ms in 99 %%, %.2f ms at the most", what,
            spread.median, spread.least, spread.most_of_hundred, spread.most);
}

int Tell(const RecordedPath& line, const NetworkTrace& trace, const ClockEstimate& clocks,
         const std::string& file, bool json) {
  std::vector<double> ages;
  std::vector<double> trips;
  for (std::size_t i = 0; i < line.loop_age_ns.size(); ++i) {
    ages.push_back(1e-6 * static_cast<double>(line.loop_age_ns[i]));
    trips.push_back(1e-6 * static_cast<double>(line.loop_age_ns[i] - line.held_ns[i]));
  }
  const Spread age = SpreadOf(std::move(ages));
  const Spread trip = SpreadOf(std::move(trips));
  if (json) {
    OrderedJson out = FactsAsJson(trace);
    out["file"] = file;
    out["address"] = line.address;
    out["loop_age"] = AsJson(age);
    out["round_trip"] = AsJson(trip);
    out["twice"] = line.twice;
    out["drift_ppm"] = clocks.drift_ppm;
    PrintText(JsonText(out, 2));
    return kExitOk;
  }
  PrintSpread("loop age  ", age);
  PrintSpread("round trip", trip);
  PrintText(FactsAsText(trace));
  PrintLine(
      "one-way delays: the two clocks are known within %.3f ms (half the least round trip), so "
      "delays there and back may be",
      clocks.bound_ms);
  PrintLine(
      "  that much more or less than shown. Round trips and loop ages do not depend on the "
      "clocks.");
  PrintLine("%s: %zu samples each way at %g Hz", file.c_str(), trace.there_ms.size(),
            trace.rate_hz);
  return kExitOk;
}

}  // namespace

void AddLineOptions(CLI::App& doctor, LineArguments& arguments) {
  CLI::Option* const trace =
      doctor
          .add_option("--trace", arguments.file,
                      "trace file to write (CSV): record the line to the machine of --peers, where "
                      "'tandem doctor --answer' runs (docs/network-plans.md)")
          ->check(FileEndingIn({".csv"}));
  doctor.add_option("--seconds", arguments.seconds, "with --trace: length of the recording, s")
      ->needs(trace)
      ->capture_default_str()
      ->check(NumberFrom(0.1, 600));
  doctor.add_option("--hz", arguments.rate_hz, "with --trace: samples each way, Hz")
      ->needs(trace)
      ->capture_default_str()
      ->check(WholeNumberFrom(1, kMostLineHz));
}

int RunDoctorTrace(const LineArguments& arguments, const std::vector<std::string>& peers,
                   std::uint16_t port, bool json) {
  if (peers.size() != 1) return Fail(kExitUsage, "--trace needs --peers with exactly one machine");
  const Result<PeerAddress> peer = ParsePeerAddress(peers.front());
  if (!peer) return Fail(kExitUsage, "--peers: " + peer.error().what);
  if (const std::string fault = WhyNotWritable(arguments.file); !fault.empty()) {
    return Fail(kExitFile, fault);
  }
  PathTerms terms;
  terms.rate_hz = static_cast<std::uint32_t>(arguments.rate_hz);
  terms.samples =
      static_cast<std::uint32_t>(std::max(1L, std::lround(arguments.seconds * arguments.rate_hz)));
  const Result<RecordedPath> line = RecordPath(peer->host, port, terms, StopOnSignals());
  if (!line) return Fail(kExitNetwork, line.error().what);
  const ClockEstimate clocks = EstimateClocks(line->record);
  if (clocks.bound_ms < 0) {
    return Fail(kExitNetwork,
                peer->host + ": no samples arrived in one direction, so there is no trace");
  }
  NetworkTrace trace = TraceOf(line->record, clocks);
  trace.source = "tandem doctor --trace, to " + line->address;
  if (const auto failed = WriteNetworkTrace(arguments.file, trace)) {
    return Fail(kExitFile, failed->what);
  }
  return Tell(*line, trace, clocks, arguments.file, json);
}

}  // namespace tandem
