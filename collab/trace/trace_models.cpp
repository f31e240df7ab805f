#include "collab/trace/trace_models.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <random>
#include <vector>

#include "collab/trace/trace_file.h"

namespace tandem {

namespace {

constexpr double kTwicePi = 6.283185307179586;
// CUBIC (RFC 9438): the window after a loss, and the growth of the window
constexpr double kCubicDecrease = 0.7;
constexpr double kCubicGrowth = 0.4;  // packets/s^3

/// Makes one way of a trace, sample by sample.
class MadeWay {
 public:
  /// `phase`: phase of the period and the transfers, 0 to 1, the same for both ways.
  MadeWay(const DirectionModel& model, std::uint64_t seed, double phase)
      : model_(model), random_(seed), phase_(phase) {
    level_ = Random();
    wait_ = Normal();
    NextStall(0);
  }

  /// Returns the delay of the sample sent at `t_ms`, `step_ms` after the last one.
  float Next(double t_ms, double step_ms) {
    double delay_ms = model_.base_ms + GridWait(t_ms) + QueueWait(step_ms) + Retries();
    const double boundary = Boundary(t_ms);
    delay_ms += model_.period_spread_ms * level_ + model_.boundary_ms * boundary;
    const std::optional<double> buffered = BufferWait(t_ms);
    bool lost = Lost();
    lost = (Random() < model_.boundary_loss && boundary > 0) || lost;
    lost = lost || !buffered;
    delay_ms += buffered.value_or(model_.buffer_ms);
    double arrival_ms = t_ms + delay_ms;
    while (t_ms >= stall_end_ms_) NextStall(stall_end_ms_);
    if (arrival_ms >= stall_begin_ms_ && t_ms >= stall_begin_ms_) {
      arrival_ms = std::max(arrival_ms, stall_end_ms_ + model_.base_ms);
    }
    if (lost) return NetworkTrace::kLost;
    latest_ms_ = std::max(latest_ms_, arrival_ms);  // order is kept
    return AsInFile(std::min(latest_ms_ - t_ms, kLongestTracedMs));
  }

 private:
  double Random() { return static_cast<double>(random_() >> 11U) * 0x1p-53; }
  double Exponential(double mean) { return -mean * std::log(1.0 - Random()); }
  double Normal() {
    const double radius = std::sqrt(-2.0 * std::log(1.0 - Random()));
    return radius * std::cos(kTwicePi * Random());
  }

  double GridWait(double t_ms) const {
    if (model_.grid_ms <= 0) return 0;
    const double turns = t_ms / model_.grid_ms + phase_;
    return model_.grid_ms * (std::ceil(turns) - turns);
  }

  double QueueWait(double step_ms) {
    const double keeps = std::exp(-1e-3 * step_ms / model_.queue_s);
    wait_ = keeps * wait_ + std::sqrt(1.0 - keeps * keeps) * Normal();
    const double spread = model_.queue_spread;
    return model_.queue_ms * std::exp(spread * wait_ - 0.5 * spread * spread);
  }

  double Retries() {
    double ms = 0;
    for (int i = 0; i < model_.retries && Random() < model_.retry; ++i) ms += model_.retry_ms;
    return ms;
  }

  void NextStall(double after_ms) {
    if (model_.stalls_hz <= 0) {
      stall_begin_ms_ = stall_end_ms_ = INFINITY;
      return;
    }
    stall_begin_ms_ = after_ms + Exponential(1e3 / model_.stalls_hz);
    const double lasts_ms = Exponential(model_.stall_ms);
    stall_end_ms_ = stall_begin_ms_ + (model_.stall_fixed ? model_.stall_ms : lasts_ms);
  }

  /// Returns how near a handover the sample is: 1 at the handover, 0 outside its time.
  double Boundary(double t_ms) {
    if (model_.period_s <= 0) return 0;
    const double period_ms = 1e3 * model_.period_s;
    const double turns = t_ms / period_ms + phase_;
    const double turn = std::floor(turns);
    if (turn != period_) {
      if (period_ >= 0) level_ = Random();
      period_ = turn;
    }
    const double since_ms = period_ms * (turns - turn);
    const double until_ms = period_ms - since_ms;
    if (since_ms < model_.begin_ms) return 1.0 - since_ms / model_.begin_ms;
    return until_ms < model_.end_ms ? 1.0 - until_ms / model_.end_ms : 0.0;
  }

  /// Returns the wait in the buffer that a bulk transfer fills; nullopt: the buffer is full.
  std::optional<double> BufferWait(double t_ms) {
    if (model_.buffer_ms <= 0) return 0.0;
    const double cycle_s = model_.transfer_s + model_.pause_s;
    const double at_s = std::fmod(1e-3 * t_ms + phase_ * cycle_s, cycle_s);
    // after the transfer the buffer drains at the bottleneck's rate: the wait falls with time
    if (at_s > model_.transfer_s) {
      return std::max(0.0, InBuffer(model_.transfer_s) - 1e3 * (at_s - model_.transfer_s));
    }
    const double wait_ms = InBuffer(at_s);
    // while the buffer is full, a packet now and then finds no room
    return wait_ms > 0.98 * model_.buffer_ms && Random() < 0.1 ? std::nullopt
                                                               : std::optional(wait_ms);
  }

  /// Returns the wait in the buffer in ms, `at_s` after the transfer's begin: the window less the
  /// packets on the line, between losses that come whenever the buffer is full.
  double InBuffer(double at_s) const {
    const double most = model_.packets_per_s * 1e-3 * (model_.buffer_ms + model_.round_trip_ms);
    const double rises_s = std::cbrt(most * (1.0 - kCubicDecrease) / kCubicGrowth);
    const double since_s = std::fmod(at_s, rises_s) - rises_s;
    const double window = kCubicGrowth * since_s * since_s * since_s + most;
    const double wait_ms = 1e3 * window / model_.packets_per_s - model_.round_trip_ms;
    return std::clamp(wait_ms, 0.0, model_.buffer_ms);
  }

  bool Lost() {
    const double turn = Random();
    in_burst_ = in_burst_ ? turn >= model_.burst_leave : turn < model_.burst_enter;
    const double chance = Random();
    return chance < (in_burst_ ? model_.burst_loss : model_.loss);
  }

  const DirectionModel& model_;
  std::mt19937_64 random_;
  double phase_;
  double level_ = 0;    // delay share of this period
  double period_ = -1;  // number of the period
  double wait_ = 0;     // behind other traffic, in standard deviations of its logarithm
  double stall_begin_ms_ = 0;
  double stall_end_ms_ = 0;
  double latest_ms_ = 0;  // arrival
  bool in_burst_ = false;
};

const std::array kTraceModels{
    TraceModel{"wifi",
               "home Wi-Fi, then a wired line to the same city",
               {.base_ms = 6,
                .queue_ms = 1.5,
                .retry = 0.1,
                .retry_ms = 0.5,
                .retries = 7,
                .stalls_hz = 0.12,
                .stall_ms = 80,
                .burst_enter = 1e-4,
                .burst_leave = 0.1,
                .burst_loss = 0.7},
               {.base_ms = 6,
                .queue_ms = 1,
                .retry = 0.1,
                .retry_ms = 0.5,
                .retries = 7,
                .stalls_hz = 0.12,
                .stall_ms = 80,
                .burst_enter = 1e-4,
                .burst_leave = 0.1,
                .burst_loss = 0.7}},
    TraceModel{"lte",
               "LTE, one end on the move",
               {.base_ms = 14,
                .grid_ms = 10,
                .queue_ms = 3,
                .retry = 0.1,
                .retry_ms = 8,
                .stalls_hz = 0.05,
                .stall_ms = 49.5,
                .stall_fixed = true,
                .loss = 1e-4},
               {.base_ms = 14,
                .grid_ms = 1,
                .queue_ms = 2,
                .retry = 0.1,
                .retry_ms = 8,
                .stalls_hz = 0.05,
                .stall_ms = 49.5,
                .stall_fixed = true,
                .loss = 1e-4}},
    TraceModel{"5g",
               "5G non-standalone, one end on the move",
               {.base_ms = 8,
                .grid_ms = 2.5,
                .queue_ms = 1.5,
                .retry = 0.1,
                .retry_ms = 2.5,
                .stalls_hz = 0.05,
                .stall_ms = 49.5,
                .stall_fixed = true,
                .loss = 1e-4},
               {.base_ms = 7,
                .grid_ms = 0.5,
                .queue_ms = 1,
                .retry = 0.1,
                .retry_ms = 2.5,
                .stalls_hz = 0.05,
                .stall_ms = 49.5,
                .stall_fixed = true,
                .loss = 1e-4}},
    TraceModel{"leo",
               "satellite in a low orbit (Starlink)",
               {.base_ms = 12,
                .grid_ms = 1.333,
                .queue_ms = 1.5,
                .loss = 1e-3,
                .period_s = 15,
                .period_spread_ms = 8,
                .begin_ms = 140,
                .end_ms = 75,
                .boundary_ms = 50,
                .boundary_loss = 0.1},
               {.base_ms = 9,
                .grid_ms = 1.333,
                .queue_ms = 1,
                .loss = 1e-3,
                .period_s = 15,
                .period_spread_ms = 4,
                .begin_ms = 140,
                .end_ms = 75,
                .boundary_ms = 20,
                .boundary_loss = 0.1}},
    TraceModel{"geo",
               "geostationary satellite",
               {.base_ms = 295,
                .grid_ms = 25,
                .queue_ms = 8,
                .burst_enter = 2e-5,
                .burst_leave = 0.01,
                .burst_loss = 0.5},
               {.base_ms = 285,
                .queue_ms = 4,
                .burst_enter = 2e-5,
                .burst_leave = 0.01,
                .burst_loss = 0.5}},
    TraceModel{
        "transatlantic",
        "wired, New York to London",
        {.base_ms = 37, .queue_ms = 0.5, .loss = 1e-4, .burst_enter = 1e-5, .burst_leave = 0.05},
        {.base_ms = 35, .queue_ms = 0.5, .loss = 1e-4, .burst_enter = 1e-5, .burst_leave = 0.05}},
    TraceModel{"bufferbloat",
               "uplink of 2 Mbit/s with a buffer of 120 kB that an upload fills",
               {.base_ms = 20,
                .queue_ms = 0.5,
                .buffer_ms = 480,
                .transfer_s = 20,
                .pause_s = 10,
                .round_trip_ms = 40,
                .packets_per_s = 167},
               {.base_ms = 20, .queue_ms = 0.5}}};

}  // namespace

Result<NetworkTrace> MakeTrace(const std::string& name, const TraceLength& length) {
  const std::span<const TraceModel> models = TraceModels();
  const auto model = std::ranges::find(models, name, &TraceModel::name);
  if (model == models.end()) {
    std::string names;
    for (const TraceModel& each : models) names += (names.empty() ? "" : ", ") + each.name;
    return Error{"no model of a network is called '" + name + "': there are " + names};
  }
  const double samples = std::ceil(length.seconds * length.rate_hz);
  if (!(samples >= 1 && samples <= static_cast<double>(kMostTraceSamples))) {
    return Error{"a trace has 1 to " + std::to_string(kMostTraceSamples) + " samples"};
  }
  NetworkTrace trace{.rate_hz = length.rate_hz};
  trace.source = "tandem stability trace " + name + ", seed " + std::to_string(length.seed);
  std::mt19937_64 seeds(length.seed);
  const double phase = static_cast<double>(seeds() >> 11U) * 0x1p-53;
  MadeWay there(model->there, seeds(), phase);
  MadeWay back(model->back, seeds(), phase);
  const double step_ms = 1e3 / length.rate_hz;
  for (std::size_t i = 0; i < static_cast<std::size_t>(samples); ++i) {
    const double t_ms = step_ms * static_cast<double>(i);
    trace.there_ms.push_back(there.Next(t_ms, step_ms));
    trace.back_ms.push_back(back.Next(t_ms, step_ms));
  }
  return trace;
}

std::span<const TraceModel> TraceModels() {
  return kTraceModels;
}

}  // namespace tandem
