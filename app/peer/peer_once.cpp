#include "app/peer/peer_once.h"

#include <algorithm>
#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <unistd.h>

#include "app/common/console.h"
#include "app/common/exit_codes.h"
#include "app/common/output_file.h"
#include "app/common/stop_signal.h"
#include "app/judgement/verdict.h"
#include "app/peer/peer_loops.h"
#include "app/peer/peer_session.h"
#include "app/peer/session_setup.h"
#include "app/peer/text/peer_report.h"
#include "app/peer/text/peer_table_text.h"
#include "app/recording/network_plan.h"
#include "app/recording/trace_file.h"
#include "collab/dds/cyclone/socket_drops.h"
#include "collab/dds/cyclone/waiting_instances.h"
#include "collab/dds/transport/packet_filter.h"
#include "engine/base/files/whole_file.h"
#include "engine/base/text/json_text.h"
#include "engine/realtime/clock.h"

namespace tandem {

namespace {

/// Returns why the report and its trace cannot be written; empty: they can, or none is asked for.
std::string WhyNoReport(const std::string& report) {
  if (report.empty()) return "";
  std::string fault = WhyNotWritable(report);
  if (fault.empty()) fault = WhyNoTrace(report + ".trace");
  return fault;
}

/// Returns how many samples the network, as it is to be from the start, holds back in the largest
/// session.
std::size_t RoomFor(NetworkPlan plan, const LinkConditions& conditions) {
  plan.links.push_back({.from = {}, .steps = {{.at_s = 0, .conditions = conditions}}});
  return std::max(PeerInbox::kDefaultWaiting, MostWaiting(plan, kMaxPeers - 1));
}

/// Returns a line for a user whose hand is empty at the start.
std::string WhatThereIsToHold(const WorldModel& model) {
  std::string line = "your hand is empty: start with --hold BODY, or type 'grab BODY'; bodies: ";
  for (std::size_t b = 0; b < model.object.size(); ++b) {
    if (b == 8) return line + ", and " + std::to_string(model.object.size() - b) + " more";
    line += (b == 0 ? "" : ", ") + model.scene.bodies[model.object[b]].name;
  }
  return line;
}

void TellEntry(const PeerArguments& arguments, const SessionSetup& setup,
               const RealtimeStatus& realtime, const std::string& security) {
  Say((LinePrefix().empty() ? arguments.name + " is in session " : "in session ") +
      arguments.session + (realtime.fifo ? " (real-time priority)" : " (no real-time priority)"));
  if (!arguments.repeats) Say(security);
  if (arguments.hold.empty()) Say(WhatThereIsToHold(*setup.model));
}

/// Leaves a session whose haptic thread may not be real-time, where the user wants it to be.
int LeaveForLackOfRealTime(SessionSetup& setup, PeerLoops& loops, PeerControl* control) {
  loops.EndHaptic();
  if (control != nullptr) control->End();
  setup.transport->Leave();
  return Fail(
      kExitNotRealTime,
      "the system did not grant real-time priority (SCHED_FIFO), which --require-rt demands");
}

/// Ends the threads and leaves the session. Returns how many packets were dropped at the sockets.
std::uint64_t LeaveSession(SessionSetup& setup, PeerLoops& loops, PeerControl* control,
                           int exit_code) {
  loops.EndHaptic();
  SayStillEnding();
  if (control != nullptr) control->End();
  loops.EndSender();
  if (setup.device() != nullptr && exit_code != kJoinAgain) setup.device()->End();
  const std::uint64_t socket_dropped = PacketsDroppedAtSockets();
  setup.node->Leave(MonotonicNowNs(), *setup.transport);
  SayStillEnding();
  return socket_dropped;
}

/// Closes the recording, if there is one. Returns the exit code, where a fault changes it.
int EndRecording(const PeerArguments& arguments, SessionSetup& setup, bool begun, int exit_code) {
  if (!setup.recorder) return exit_code;
  // frames before a new join are no part of the session
  if (exit_code == kJoinAgain && !begun) {
    setup.recorder->Discard();
    return exit_code;
  }
  const Result<std::uint64_t> recorded = setup.recorder->Close();
  if (!recorded) {
    const int failed = Fail(kExitFile, recorded.error().what);
    return exit_code == kExitOk ? failed : exit_code;
  }
  Say(arguments.record + ": " + WithPlural(*recorded, "frame") + " recorded");
  return exit_code;
}

/// Returns the verdicts on the bodies that the hand held; none if it held none or the options want
/// none.
std::vector<BodyVerdict> VerdictsOfPeer(const PeerArguments& arguments, const SessionSetup& setup,
                                        const HeldPoses& poses, const TouchedBodies& met,
                                        double seconds) {
  if (arguments.brief) return {};
  return Judge(*setup.model, poses, met, FinalPoses(setup.node->world()), arguments.no_contact,
               setup.node->peer().telemetry().hand_figures().peak_force, seconds);
}

/// Counts the points that contact tests, and the voxels that it tests them against.
void CountShapes(const SessionSetup& setup, PeerReport& report) {
  report.capacity = setup.capacity.tests;
  report.query_price = setup.capacity.query_price;
  const WorldModel& world = *setup.model;
  report.voxels = world.has_fixture ? FixtureVoxels(world) : 0;
  for (const BodyModel& body : world.bodies) {
    report.points += TestedPoints(world, body);
    if (!world.has_fixture) report.voxels += ReadVoxels(world, body.voxmap, body.surface);
  }
}

nlohmann::ordered_json TermsAsJson(const PeerDirectory& directory) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (const PeerDirectory::Entry& entry : directory.Entries()) {
    if (entry.info.role != Role::kActive) continue;
    const ForceTerms& terms = entry.info.terms;
    rows.push_back({{"name", entry.info.name},
                    {"law", terms.law},
                    {"gains", terms.gains},
                    {"gate", terms.gate},
                    {"contact", terms.contact},
                    {"force_layer", terms.force_layer},
                    {"displacement_mm", 1e3 * terms.displacement}});
  }
  return rows;
}

/// Returns how the ticks of the device process went; nothing: there is none.
std::optional<DeviceTimes> TimesOf(const SessionSetup& setup) {
  if (setup.device() == nullptr) return std::nullopt;
  return setup.device()->times();
}

std::optional<PassivityAccount> PassivityOf(const SessionSetup& setup) {
  if (setup.device() == nullptr) return std::nullopt;
  return setup.device()->Newest().value_or(DeviceTick{}).passivity;
}

/// Reports what node, device and threads found, without what the network did.
PeerReport ReportOf(const PeerArguments& arguments, const SessionSetup& setup,
                    const RealtimeStatus& realtime) {
  const PeerNode& node = *setup.node;
  const ResidentVoxels* voxels = node.world().resident_voxels();
  PeerReport report{
      .name = arguments.name,
      .pid = getpid(),
      .scheduler = realtime.scheduler(),
      .mean_delay_s = node.peer().mean_delay_s(),
      .hand = node.peer().telemetry().hand_figures(),
      .traced_frames = node.peer().telemetry().trace().size(),
      .device = arguments.device,
      .device_times = TimesOf(setup),
      .device_scheduler = setup.device() != nullptr ? setup.device()->scheduler() : "",
      .passivity = PassivityOf(setup),
      .safety_state = node.peer().safety_state(),
      .safety = node.peer().safety_counts(),
      .guarded_share = node.peer().guard().guarded_share(),
      .felt = node.peer().telemetry().rendered(),
      .crowded_frames = node.peer().telemetry().crowded_frames(),
      .waits = node.peer().telemetry().voxel_waits(),
      .voxel_memory = voxels != nullptr ? voxels->bytes() : setup.model->fixture.header().bytes,
      .voxels_locked = voxels != nullptr ? voxels->locked() : realtime.memory_locked,
      .paged = voxels != nullptr ? voxels->counts() : ResidentCounts{},
      .own_states = node.sent_states()};
  CountShapes(setup, report);
  return report;
}

void ReportNetwork(PeerNode& node, PeerReport& report) {
  report.drops = node.inbox().drops().Total();
  report.drops[static_cast<std::size_t>(Drop::kManyKeys)] += InstancesRefused();
  AddDelivery(node.inbox().delivery(), report);
}

int WriteReport(const PeerArguments& arguments, const PeerReport& report, const FrameStats& all,
                const JudgedFrames& judged, TraceFile& trace) {
  const auto failed =
      WriteWholeFile(arguments.report, JsonText(AsJson(report, all, judged), 2) + '\n');
  if (failed) {
    trace.Discard();
    return Fail(kExitFile, failed->what);
  }
  const Result<bool> written = trace.Close();
  return written ? kExitOk : Fail(kExitFile, written.error().what);
}

}  // namespace

int RunOnce(PeerArguments& arguments, PeerControl* control, bool may_join_again) {
  if (const std::string fault = WhyNoReport(arguments.report); !fault.empty()) {
    return Fail(kExitFile, fault);
  }
  Result<NetworkPlan> plan = NetworkPlan{};
  if (!arguments.network.empty()) plan = LoadNetworkPlan(arguments.network);
  if (!plan) return Fail(kExitFile, plan.error().what);
  SessionSetup setup;
  setup.waiting = RoomFor(*plan, arguments.conditions);
  if (const int failed = Join(arguments, setup); failed != kExitOk) return failed;
  // asked while there is no haptic thread, because it runs other programs to look at keys
  const std::string security =
      arguments.repeats ? "" : SecurityOf(arguments.connection, arguments.session);
  PeerNode& node = *setup.node;
  if (control != nullptr) control->Begin(arguments, setup);
  const std::atomic<bool>& stop_asked = StopOnSignals();

  PeerLoops loops(arguments, setup, control);
  const RealtimeStatus& realtime = loops.realtime();
  if (!realtime.warning.empty()) Say(realtime.warning);
  if (arguments.require_rt && !realtime.fifo) {
    return LeaveForLackOfRealTime(setup, loops, control);
  }
  TellEntry(arguments, setup, realtime, security);

  std::optional<TraceFile> trace;
  std::optional<AtForcedEnd> no_report;
  if (!arguments.report.empty()) {
    no_report.emplace([&arguments] {
      Say("ended by force: " + arguments.report + " is not written");
    });
    trace.emplace(arguments.report + ".trace", [&node] {
      return node.peer().telemetry().trace();
    });
  }
  kControlThread.Enter();
  PeerSession stay(arguments, setup, loops, control, may_join_again, *std::move(plan));
  int exit_code = stay.RunUntil(stop_asked);

  stay.SayRest();
  const std::uint64_t socket_dropped = LeaveSession(setup, loops, control, exit_code);
  exit_code = EndRecording(arguments, setup, loops.begun(), exit_code);
  SayStillEnding();
  for (const std::string& line : Explain(node.peer().telemetry().hand_figures().limits)) Say(line);
  if (exit_code == kJoinAgain || (exit_code != kExitOk && arguments.report.empty())) {
    return exit_code;
  }
  loops.TakePoses(stay.poses());
  const std::vector<BodyVerdict> verdicts =
      VerdictsOfPeer(arguments, setup, stay.poses(), loops.met(),
                     stop_asked.load() ? kHurriedVerdictSeconds : kVerdictSeconds);
  SayStillEnding();
  for (const BodyVerdict& verdict : verdicts) {
    if (exit_code == kExitOk) Say(Describe(verdict));
  }
  if (arguments.report.empty()) return exit_code;

  PeerReport report = ReportOf(arguments, setup, realtime);
  ReportNetwork(node, report);
  report.peers = AsJson(stay.table(), stay.name());
  report.force_terms = TermsAsJson(node.directory());
  report.start_gaps = AsJson(setup.start_gaps);
  report.verdicts = AsJson(verdicts);
  report.socket_dropped = socket_dropped;
  report.packets = PacketsJudged();
  const int written = WriteReport(arguments, report, loops.stats(), loops.judged(), *trace);
  no_report.reset();
  return exit_code != kExitOk ? exit_code : written;
}

}  // namespace tandem
