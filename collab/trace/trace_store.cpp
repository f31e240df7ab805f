#include "collab/trace/trace_store.h"

#include <map>
#include <memory>
#include <mutex>
#include <system_error>
#include <tuple>
#include <utility>

#include <sys/stat.h>

#include "collab/trace/trace_file.h"
#include "collab/trace/trace_models.h"

namespace tandem {

namespace {

constexpr double kModelSeconds = 120;
constexpr double kModelHz = 1000;
constexpr double kMostStretch = 100;
constexpr double kLatestStart = 1e6;           // s
constexpr std::size_t kMostKept = 32'000'000;  // samples of all traces, 8 bytes each

struct Kept {
  std::mutex mutex;
  std::map<std::string, NetworkTrace> traces;
  std::map<std::tuple<std::string, TraceDirection, double>, std::unique_ptr<const LinkTrace>> ways;
  std::size_t samples = 0;  // sum over all ways
};

Kept& AllKept() {
  static Kept kept;
  return kept;
}

/// Returns one way of the trace that `make` makes, called once for each `key`.
template <typename Make>
Result<const LinkTrace*> KeepWay(const std::string& key, LinkTrace::Source source,
                                 TraceDirection way, double stretch, Make make) {
  Kept& kept = AllKept();
  const std::lock_guard lock(kept.mutex);
  auto network = kept.traces.find(key);
  if (network == kept.traces.end()) {
    Result<NetworkTrace> made = make();
    if (!made) return made.error();
    network = kept.traces.emplace(key, *std::move(made)).first;
  }
  const bool back = way == TraceDirection::kBack;
  const auto found = kept.ways.find({key, way, stretch});
  if (found != kept.ways.end()) return found->second.get();
  const NetworkTrace& trace = network->second;
  if (kept.samples + trace.there_ms.size() > kMostKept) {
    return Error{"more traces than one program keeps: begin another"};
  }
  auto link =
      std::make_unique<LinkTrace>(trace.rate_hz, back ? trace.back_ms : trace.there_ms, stretch);
  link->source = std::move(source);
  link->source.back = back;
  link->source.stretch = stretch;
  kept.samples += link->samples().size();
  const LinkTrace* const kept_link = link.get();
  kept.ways.emplace(std::tuple(key, way, stretch), std::move(link));
  return kept_link;
}

/// Returns a key that differs between files, and between versions of a file.
std::string KeyOf(const std::filesystem::path& file) {
  struct stat found {};
  if (stat(file.c_str(), &found) != 0) return file.string();
  std::string key = "file";
  for (const auto number :
       {static_cast<long long>(found.st_dev), static_cast<long long>(found.st_ino),
        static_cast<long long>(found.st_size), static_cast<long long>(found.st_mtim.tv_sec),
        static_cast<long long>(found.st_mtim.tv_nsec)}) {
    key.append(" ").append(std::to_string(number));
  }
  return key;
}

/// Evenly distributed over [0, 1), unlike for neighbouring seeds (splitmix64).
double PlaceOf(std::uint64_t seed) {
  seed += 0x9E3779B97F4A7C15U;
  seed = (seed ^ (seed >> 30U)) * 0xBF58476D1CE4E5B9U;
  seed = (seed ^ (seed >> 27U)) * 0x94D049BB133111EBU;
  return static_cast<double>((seed ^ (seed >> 31U)) >> 11U) * 0x1p-53;
}

}  // namespace

Result<const LinkTrace*> KeepTrace(const std::filesystem::path& file, TraceDirection way,
                                   double stretch) {
  std::error_code failed;
  const std::filesystem::path whole = std::filesystem::absolute(file, failed);
  LinkTrace::Source source;
  source.file = failed ? file.string() : whole.string();
  return KeepWay(KeyOf(file), source, way, stretch, [&file] {
    return ReadNetworkTrace(file);
  });
}

Result<const LinkTrace*> KeepModel(const std::string& name, TraceDirection way, double stretch) {
  LinkTrace::Source source;
  source.model = name;
  return KeepWay("model " + name, source, way, stretch, [&name] {
    return MakeTrace(name, {.seconds = kModelSeconds, .rate_hz = kModelHz, .seed = 1});
  });
}

double TraceChoice::StartFor(std::uint64_t seed) const {
  return mix && there != nullptr ? start_s + PlaceOf(seed) * there->seconds() : start_s;
}

TraceChoice ReadTraceKeys(const JsonNode& node, const std::filesystem::path& folder) {
  TraceChoice choice;
  const bool model = node.Has("model");
  if (!model && !node.Has("trace")) {
    for (const char* key : {"stretch", "start_s", "mix"}) {
      if (node.Has(key))
        node[key].Fault("there is no trace that it is of: name 'trace' or 'model'");
    }
    return choice;
  }
  if (model && node.Has("trace")) node["model"].Fault("there is a trace already: one of both");
  const double stretch = node.Has("stretch") ? node["stretch"].NumberBetween(0, kMostStretch) : 1;
  if (node.Has("start_s")) choice.start_s = node["start_s"].NumberBetween(0, kLatestStart);
  if (node.Has("mix")) choice.mix = node["mix"].TrueOrFalse();
  const JsonNode named = node[model ? "model" : "trace"];
  const std::string name = named.Text(model ? "the name of a model" : "a trace's file");
  for (const TraceDirection way : {TraceDirection::kThere, TraceDirection::kBack}) {
    const Result<const LinkTrace*> kept =
        model ? KeepModel(name, way, stretch) : KeepTrace(folder / name, way, stretch);
    if (!kept) {
      named.Fault(kept.error().what);
      return {};
    }
    (way == TraceDirection::kThere ? choice.there : choice.back) = *kept;
    if ((*kept)->facts().longest_ms > kLongestTracedMs) {
      named.Fault("holds a sample back for more than 10 s: stretch it less");
      return {};
    }
  }
  return choice;
}

}  // namespace tandem
