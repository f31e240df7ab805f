#include "app/recording/network_plan.h"

#include <algorithm>
#include <sstream>
#include <utility>

#include "collab/trace/trace_store.h"
#include "engine/base/text/json_reader.h"
#include "engine/base/units.h"

namespace tandem {
namespace {

constexpr const char* kOrder = "network";
constexpr std::size_t kMostLinksInPlan = 64;
constexpr std::size_t kMostSteps = 10'000;  // steps of a link
constexpr double kShortestSwing = 1e-3;     // s
constexpr double kLongestSwing = 1e6;       // s

double NumberWithin(const JsonNode& node, const char* key, double most, double otherwise) {
  if (!node.Has(key)) return otherwise;
  const double value = node[key].NumberFrom(0);
  if (value > most) {
    std::ostringstream words;
    words << "a number from 0 to " << most;
    node[key].Expected(words.str());
  }
  return value;
}

/// Reads a step's trace, and which direction of it this peer hears.
void ReadTrace(const JsonNode& node, const std::filesystem::path& folder, LinkConditions& c) {
  const TraceChoice choice = ReadTraceKeys(node, folder);
  bool back = false;
  if (node.Has("way")) {
    const std::string way = node["way"].Text("there or back");
    back = way == "back";
    if (!back && way != "there") node["way"].Expected("there or back");
    if (choice.there == nullptr)
      node["way"].Fault("give \"trace\" or \"model\" too: this key needs one of them");
  }
  c.trace = back ? choice.back : choice.there;
  c.trace_start_s = choice.StartFor(c.seed);
}

NetworkPlan::Step ReadStep(const JsonNode& node, std::uint64_t seed,
                           const std::filesystem::path& folder) {
  node.AllowKeys({kTraceKeys[0], kTraceKeys[1], kTraceKeys[2], kTraceKeys[3], kTraceKeys[4], "way",
                  "at_s", "delay_ms", "jitter_ms", "swing_ms", "swing_period_s", "loss",
                  "burst_enter", "burst_leave", "burst_loss", "reorder", "reorder_ms", "duplicate",
                  "cut"});
  NetworkPlan::Step step;
  LinkConditions& c = step.conditions;
  step.at_s = node.Has("at_s") ? node["at_s"].NumberFrom(0) : 0;
  c.delay_ms = NumberWithin(node, "delay_ms", 2000, c.delay_ms);
  c.jitter_ms = NumberWithin(node, "jitter_ms", 1000, c.jitter_ms);
  c.swing_ms = NumberWithin(node, "swing_ms", 1000, c.swing_ms);
  if (node.Has("swing_period_s")) {
    c.swing_period_s = node["swing_period_s"].NumberBetween(kShortestSwing, kLongestSwing);
  }
  c.loss = NumberWithin(node, "loss", 1, c.loss);
  c.burst_enter = NumberWithin(node, "burst_enter", 1, c.burst_enter);
  c.burst_leave = NumberWithin(node, "burst_leave", 1, c.burst_leave);
  c.burst_loss = NumberWithin(node, "burst_loss", 1, c.burst_loss);
  c.reorder = NumberWithin(node, "reorder", 1, c.reorder);
  c.reorder_ms = NumberWithin(node, "reorder_ms", 1000, c.reorder_ms);
  c.duplicate = NumberWithin(node, "duplicate", 1, c.duplicate);
  if (node.Has("cut")) c.cut = node["cut"].TrueOrFalse();
  c.seed = seed;
  ReadTrace(node, folder, c);
  return step;
}

std::string ReasonText(const LinkConditions& c) {
  if (c.cut) return "no more";
  std::ostringstream words;
  if (c.trace != nullptr) {
    const LinkTrace::Source& source = c.trace->source;
    words << "as in " << (source.model.empty() ? source.file : "the model " + source.model)
          << (source.back ? ", way back, " : ", ");
  }
  words << c.delay_ms << " ms late";
  if (c.jitter_ms > 0) words << ", up to " << c.jitter_ms << " ms more";
  if (c.swing_ms > 0) words << ", swinging by " << c.swing_ms << " ms";
  if (c.loss > 0) words << ", " << 100 * c.loss << " % lost";
  if (c.burst_enter > 0) words << ", lost in bursts";
  if (c.reorder > 0) words << ", " << 100 * c.reorder << " % overtaken";
  if (c.duplicate > 0) words << ", " << 100 * c.duplicate << " % duplicated";
  return words.str();
}

}  // namespace

Result<NetworkPlan> LoadNetworkPlan(const std::filesystem::path& file) {
  const Result<JsonFile> json = JsonFile::Read(file);
  if (!json) return json.error();
  const JsonNode root = json->root();
  root.AllowKeys({"seed", "begins", "links"});
  const int seed = root.Has("seed") ? root["seed"].WholeNumber(0, 1'000'000'000) : 1;
  NetworkPlan plan;
  plan.seed = static_cast<std::uint64_t>(seed);
  if (root.Has("begins")) {
    const std::string begins = root["begins"].Text("at_once or hand");
    plan.from_hand = begins == "hand";
    if (!plan.from_hand && begins != "at_once") root["begins"].Expected("at_once or hand");
  }
  const std::vector<JsonNode> links = root["links"].Items();
  if (links.size() > kMostLinksInPlan) {
    root["links"].Fault("more than " + std::to_string(kMostLinksInPlan) + " links");
    return *json->fault();
  }
  for (const JsonNode& node : links) {
    node.AllowKeys({"from", "steps"});
    NetworkPlan::Link link;
    if (node.Has("from")) link.from = node["from"].Text("a peer's name");
    for (const NetworkPlan::Link& other : plan.links) {
      if (other.from == link.from) node.Fault("another link has the same sender");
    }
    const std::vector<JsonNode> steps = node["steps"].Items();
    if (steps.size() > kMostSteps) {
      node["steps"].Fault("more than " + std::to_string(kMostSteps) + " steps");
      return *json->fault();
    }
    for (const JsonNode& item : steps) {
      const NetworkPlan::Step step = ReadStep(item, plan.seed, file.parent_path());
      if (!link.steps.empty() && step.at_s <= link.steps.back().at_s) {
        item["at_s"].Fault("must be later than the step before");
      }
      link.steps.push_back(step);
    }
    plan.links.push_back(std::move(link));
  }
  if (json->fault()) return *json->fault();
  return plan;
}

std::size_t MostWaiting(const NetworkPlan& plan, std::size_t senders) {
  constexpr double kHapticDelayMs = 100;  // time until a due sample is taken
  double most = 0;
  for (const NetworkPlan::Link& link : plan.links) {
    for (const NetworkPlan::Step& step : link.steps) {
      const LinkConditions& c = step.conditions;
      const double held_ms =
          c.delay_ms + c.jitter_ms + c.swing_ms + (c.reorder > 0 ? c.reorder_ms : 0) +
          (c.trace != nullptr ? c.trace->facts().longest_ms : 0) + kHapticDelayMs;
      // a sample comes every millisecond
      if (!c.cut) most = std::max(most, c.duplicate > 0 ? 2 * held_ms : held_ms);
    }
  }
  return static_cast<std::size_t>(most * static_cast<double>(senders)) + 1;
}

void PlannedNetwork::Start(NetworkPlan plan, std::int64_t now_ns) {
  begin_ns_ = now_ns;
  waits_ = plan.from_hand && !hand_begun_;
  links_.clear();
  // samples that no link names are treated as without a plan, from the beginning on
  links_.push_back({});
  links_[0].link.steps.push_back({.at_s = 0, .conditions = {.seed = plan.seed}});
  for (NetworkPlan::Link& link : plan.links) {
    if (!link.from.empty()) {
      links_.push_back({.link = std::move(link)});
    } else {
      if (!link.steps.empty() && link.steps[0].at_s <= 0) links_[0].link.steps.clear();
      std::move(link.steps.begin(), link.steps.end(), std::back_inserter(links_[0].link.steps));
    }
  }
}

void PlannedNetwork::HandBegins(std::int64_t now_ns) {
  if (waits_) begin_ns_ = now_ns;
  waits_ = false;
  hand_begun_ = true;
}

bool PlannedNetwork::IsOrder(const std::string& line) {
  return line == kOrder || line.rfind(std::string(kOrder) + " ", 0) == 0;
}

std::optional<Error> PlannedNetwork::Obey(const std::string& order, std::int64_t now_ns,
                                          std::size_t senders) {
  std::istringstream words(order.substr(std::string_view(kOrder).size()));
  std::string file;
  std::getline(words >> std::ws, file);
  if (file.empty()) return Error{"network: give a plan file, or off"};
  if (file == "off") {
    Start({}, now_ns);
    return std::nullopt;
  }
  Result<NetworkPlan> plan = LoadNetworkPlan(file);
  if (!plan) return plan.error();
  if (const std::size_t most = MostWaiting(*plan, senders); most > room_) {
    return Error{file + ": delays up to " + std::to_string(most) + " samples of " +
                 std::to_string(senders) + " senders, but there is room for " +
                 std::to_string(room_) + ": start the peer with it, by --network"};
  }
  Start(*std::move(plan), now_ns);
  return std::nullopt;
}

std::vector<std::string> PlannedNetwork::Apply(std::int64_t now_ns, const PeerDirectory& directory,
                                               PeerInbox& inbox) {
  std::vector<std::string> lines;
  const double at_s = waits_ ? 0.0 : ToSeconds(now_ns - begin_ns_);
  for (Running& running : links_) {
    const std::vector<NetworkPlan::Step>& steps = running.link.steps;
    const bool everybody = running.link.from.empty();
    const auto due =
        static_cast<std::size_t>(std::ranges::count_if(steps, [at_s](const NetworkPlan::Step& s) {
          return s.at_s <= at_s;
        }));
    const PeerId peer = everybody ? 0 : directory.PeerNamed(running.link.from);
    if (due == 0 || (peer == 0 && !everybody)) continue;
    const bool news = due != running.done || peer != running.peer;
    if (!news && !running.stale) continue;
    const LinkConditions& conditions = steps[due - 1].conditions;
    if (!inbox.Switch(peer, conditions)) break;  // the next turn does it
    if (everybody) {
      for (Running& other : links_) other.stale = &other != &running;
    }
    running.done = due;
    running.peer = peer;
    running.stale = false;
    if (!news) continue;
    std::string line("network: samples of ");
    line.append(everybody ? "all peers" : running.link.from).append(" come ");
    lines.push_back(line.append(ReasonText(conditions)));
  }
  return lines;
}

}  // namespace tandem
