#include "app/peer/joined_node.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "app/common/console.h"
#include "app/common/exit_codes.h"
#include "collab/coupling/coupling_limits.h"
#include "engine/base/units.h"
#include "engine/haptics/device_loop.h"
#include "engine/haptics/passive_device.h"
#include "engine/realtime/clock.h"

namespace tandem {

namespace {

// time that present peers may take to be discovered
constexpr std::int64_t kSettleNs = 1000 * kMs;
// least part of it, in which claims reach the haptic thread
constexpr std::int64_t kLeastSettleNs = 100 * kMs;

/// Returns a line for each of a device's claims that is not taken as it is.
std::vector<std::string> DescribeClaimChanges(const std::string& device,
                                              const DeviceCapabilities& can) {
  std::vector<std::string> lines;
  if (can.freedoms_out > 0) {
    // where both limits are the same, or lack the same, one line says it
    const std::string peak = DescribeLimitChange(device, can.peak);
    const std::string continuous = DescribeLimitChange(device, can.continuous);
    lines.push_back(peak);
    if (continuous != peak) {
      lines.push_back(DescribeLimitChange(device + ", for ever", can.continuous));
    }
  }
  lines.push_back(DescribeGainChange(device, can));
  lines.push_back(DescribeRateChange(device, can.rate_hz));
  std::erase(lines, "");
  return lines;
}

/// Starts the device process, if one is to be there, and says what is in force.
int StartDevice(const PeerArguments& arguments, const Pose& X_WB0, SessionSetup& setup) {
  if (!HasDeviceProcess(arguments)) return kExitOk;
  setup.space = arguments.space;
  if (arguments.space->process() != nullptr) return kExitOk;  // that of the previous scene goes on
  Result<std::unique_ptr<DeviceProcess>> device =
      DeviceProcess::Start({.driver = arguments.device,
                            .home_W = X_WB0,
                            .users = arguments.device_most,
                            .core = arguments.device_core,
                            .passivity_control = arguments.passivity});
  if (!device) return Fail(kExitDevice, device.error().what);
  arguments.space->Keep(*std::move(device));
  const DeviceProcess& process = *arguments.space->process();
  const DeviceCapabilities can = process.capabilities();
  for (const std::string& line : DescribeClaimChanges(arguments.device, can)) Say(line);
  if (const std::string lacks = process.warning(); !lacks.empty()) {
    Say("device process: " + lacks);
  }
  const DeviceLimits limits = process.limits();
  char most[64] = "without force feedback";
  if (can.freedoms_out > 0) {
    std::snprintf(most, sizeof most, "at most %g N and %g N m", limits.force, limits.moment);
  }
  char text[280];
  std::snprintf(text, sizeof text, "device %.60s: %s, %g times a second%s",
                arguments.device.c_str(), most, 1e9 / static_cast<double>(process.period_ns()),
                can.asks_us ? "; its own thread fetches the force, one period later" : "");
  Say(text);
  return kExitOk;
}

/// Returns the limits that are not the law's own: "stiffness=80 …".
std::string GainsOf(const CouplingLimits& limits) {
  std::string text;
  for (const LimitName& limit : kLimitNames) {
    const double value = limits.*limit.value;
    if (value == CouplingLimits{}.*limit.value) continue;
    char number[32];
    std::snprintf(number, sizeof number, "%g", value);
    text += (text.empty() ? "" : " ") + std::string(limit.name) + "=" + number;
  }
  return text;
}

/// Returns the script that moves the hand, or that says where it grasps; empty: none.
std::string ScriptOf(const PeerArguments& arguments) {
  for (const std::string driver : {"scripted:", "none:"}) {
    if (arguments.device.rfind(driver, 0) == 0) return arguments.device.substr(driver.size());
  }
  return arguments.hand;
}

std::unique_ptr<Device> MakeDevice(const PeerArguments& arguments, HandScript script,
                                   const Pose& X_WB0, SessionSetup& setup) {
  if (setup.space) return setup.space->MapInto();
  if (arguments.goals) {
    auto device = std::make_unique<GoalDevice>(arguments.goals);
    setup.goal_device = device.get();
    return device;
  }
  if (arguments.device == "none") return std::make_unique<PassiveDevice>(std::move(script), X_WB0);
  return std::make_unique<ScriptedDevice>(std::move(script), X_WB0);
}

/// Returns how many frames are traced. These are the first ones, in memory that is never paged out:
/// 86 MB at the most.
std::size_t TraceFrames(const PeerArguments& arguments) {
  constexpr double kMost = 600'000;
  if (arguments.report.empty()) return 0;
  const double frames = 1000.0 * arguments.seconds;
  return static_cast<std::size_t>(frames > 0 ? std::min(frames, kMost) : kMost);
}

/// Returns the node's options, but for the hand.
NodeOptions NodeOptionsOf(const PeerArguments& arguments, const SessionSetup& setup) {
  NodeOptions options;
  options.peer.id = setup.id;
  options.peer.own_only = setup.unequal.has_value();
  options.peer.wait_for = arguments.wait_for;
  options.peer.settle_ns =
      std::max(kLeastSettleNs, kSettleNs - (MonotonicNowNs() - setup.joined_ns));
  options.peer.law = *MakeLaw(arguments.law, arguments.limits, arguments.lab);
  options.peer.experiments.energy_gate = arguments.gate;
  options.peer.experiments.contact = !arguments.no_contact;
  options.peer.trace_frames = TraceFrames(arguments);
  options.peer.capacity = setup.capacity.tests;
  options.peer.query_price = setup.capacity.query_price;
  options.name = arguments.name;
  options.terms = {.law = arguments.law,
                   .gains = GainsOf(arguments.limits),
                   .gate = arguments.gate,
                   .contact = !arguments.no_contact};
  options.manifest = setup.manifest;
  options.conditions = arguments.conditions;
  options.waiting = setup.waiting;
  options.publish_hz = arguments.publish_hz;
  options.workers = setup.workers.get();
  return options;
}

/// Begins the recording that the options ask for. Returns the exit code.
int StartRecorder(const PeerArguments& arguments, const Device& device, SessionSetup& setup,
                  PeerOptions& peer) {
  if (arguments.record.empty()) return kExitOk;
  Result<std::unique_ptr<Recorder>> recorder =
      Recorder::Create(arguments.record, {.program = TANDEM_VERSION,
                                          .name = arguments.name,
                                          .scene = std::filesystem::absolute(setup.scene.file),
                                          .scene_hash = setup.hash.content,
                                          .scene_digest = setup.hash.digest,
                                          .parameters = ParametersOf(setup.scene),
                                          .law = arguments.law,
                                          .limits = arguments.limits,
                                          .peer = peer,
                                          .device = device.capabilities(),
                                          .device_scale = setup.space ? setup.space->scale() : 1});
  if (!recorder) return Fail(kExitFile, recorder.error().what);
  setup.recorder = *std::move(recorder);
  peer.observer = setup.recorder.get();
  return kExitOk;
}

}  // namespace

int MakeNode(const PeerArguments& arguments, SessionSetup& setup) {
  const WorldModel& model = *setup.model;
  NodeOptions options = NodeOptionsOf(arguments, setup);
  HandScript script;
  Pose X_WB0;
  if (!arguments.hold.empty()) {
    const auto body = static_cast<std::size_t>(model.BodyNamed(arguments.hold));
    options.peer.held_object = static_cast<int>(model.object[body]);
    X_WB0 = model.bodies[body].X_WB0;
  }
  if (const std::string file = ScriptOf(arguments); !file.empty()) {
    Result<HandScript> loaded = LoadHandScript(file);
    if (!loaded) return Fail(kExitFile, loaded.error().what);
    script = std::move(*loaded);
    options.peer.X_BD = script.X_BD;
    if (arguments.hold.empty()) {
      Say("hand file " + file +
          ": the hand holds no body, so its script moves nothing: give --hold BODY too");
    }
  }
  if (const int failed = StartDevice(arguments, X_WB0, setup); failed != kExitOk) return failed;
  std::unique_ptr<Device> device = MakeDevice(arguments, std::move(script), X_WB0, setup);
  // the handle may have moved since it was opened
  if (setup.space && !arguments.hold.empty()) setup.space->Change({.p_WD = X_WB0.p});
  if (const int failed = StartRecorder(arguments, *device, setup, options.peer);
      failed != kExitOk) {
    return failed;
  }
  setup.node =
      std::make_unique<PeerNode>(setup.model, std::move(device), setup.hash.content, options);
  return kExitOk;
}

}  // namespace tandem
