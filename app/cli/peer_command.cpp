#include "app/cli/peer_command.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <thread>
#include <utility>

#include <unistd.h>

#include "app/cli/commands.h"
#include "app/cli/joining.h"
#include "app/cli/judged_frames.h"
#include "app/cli/network_plan.h"
#include "app/cli/news_limiter.h"
#include "app/cli/peer_control.h"
#include "app/cli/peer_orders.h"
#include "app/cli/peer_report.h"
#include "app/cli/peer_table_text.h"
#include "app/cli/refusal_news.h"
#include "app/cli/talk.h"
#include "app/cli/trace_file.h"
#include "app/cli/verdict.h"
#include "app/cli/watch_command.h"
#include "app/exit_codes.h"
#include "app/output_file.h"
#include "app/stop_signal.h"
#include "collab/dds/packet_filter.h"
#include "collab/dds/socket_drops.h"
#include "collab/dds/waiting_instances.h"
#include "engine/base/json_text.h"
#include "engine/base/whole_file.h"
#include "engine/realtime/clock.h"
#include "engine/realtime/periodic_thread.h"
#include "engine/world/capacity_follower.h"

namespace tandem {

namespace {

/// Counts the points that contact tests, and the voxels that it tests them against.
void CountShapes(const Joining& joining, PeerReport& report) {
  report.capacity = joining.capacity.tests;
  report.look_price = joining.capacity.look_price;
  const WorldModel& world = *joining.model;
  report.voxels = world.has_fixture ? FixtureVoxels(world) : 0;
  for (const BodyModel& body : world.bodies) {
    report.points += TestedPoints(world, body);
    if (!world.has_fixture) report.voxels += ReadVoxels(world, body.voxmap, body.surface);
  }
}

int WriteReport(const PeerArguments& arguments, const PeerReport& report, const FrameStats& all,
                const JudgedFrames& judged, TraceFile& trace) {
  const auto failed =
      WriteWholeFile(arguments.report, JsonText(AsJson(report, all, judged), 2) + '\n');
  if (failed) return Fail(kExitFile, failed->what);
  const Result<bool> written = trace.Close();
  return written ? kExitOk : Fail(kExitFile, written.error().what);
}

// no ExitCode: the session's force parameters came too late, so the peer joins anew
constexpr int kJoinAgain = -1;

/// Returns how many samples the network, as it is to be from the start, holds back in the largest
/// session.
std::size_t RoomFor(NetworkPlan plan, const LinkConditions& conditions) {
  plan.links.push_back({.from = {}, .steps = {{.at_s = 0, .conditions = conditions}}});
  return std::max(PeerInbox::kDefaultWaiting, MostWaiting(plan, kMaxPeers - 1));
}

/// Returns the verdicts on the bodies that the hand held; none if it held none or the options want
/// none.
std::vector<BodyVerdict> VerdictsOfPeer(const PeerArguments& arguments, const Joining& joining,
                                        const HeldPoses& poses, const BodiesMet& met,
                                        double seconds) {
  if (arguments.brief) return {};
  return Judge(*joining.model, poses, met, LastPlaces(joining.node->world()), arguments.no_contact,
               seconds);
}

std::string Seconds(double seconds) {
  char text[32];
  std::snprintf(text, sizeof text, "%g s", seconds);
  return text;
}

/// Returns a line for a user whose hand is empty at the start.
std::string WhatThereIsToHold(const WorldModel& model) {
  std::string line = "your hand is empty: --hold BODY, or 'grab BODY' as a line here, of: ";
  for (std::size_t b = 0; b < model.object.size(); ++b) {
    if (b == 8) return line + ", and " + std::to_string(model.object.size() - b) + " more";
    line += (b == 0 ? "" : ", ") + model.scene.bodies[model.object[b]].name;
  }
  return line;
}

/// Returns a line for each peer here with its force terms.
std::vector<std::string> TermsOf(const PeerDirectory& directory) {
  std::vector<std::string> lines;
  for (const PeerDirectory::Entry& entry : directory.Entries()) {
    const bool counts = entry.presence == PeerDirectory::Presence::kHere &&
                        entry.info.role == Role::kActive && entry.refused.empty();
    if (!counts || entry.info.terms.law.empty()) continue;
    lines.push_back(entry.info.name + ": " + Describe(entry.info.terms) +
                    (entry.terms_told.empty() ? "" : "; not as yours: " + entry.terms_told));
  }
  return lines;
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

std::size_t ActiveIn(const PeerDirectory& directory) {
  const std::vector<PeerDirectory::Entry> entries = directory.Entries();
  return static_cast<std::size_t>(
      std::ranges::count_if(entries, [](const PeerDirectory::Entry& entry) {
        return entry.presence == PeerDirectory::Presence::kHere &&
               entry.info.role == Role::kActive && entry.refused.empty();
      }));
}

/// Returns whether the device is in an emergency stop, by an order or by its own button.
bool StoppedAtDevice(const DeviceProcess& device) {
  const std::optional<DeviceTick> tick = device.Newest();
  return tick && static_cast<SafetyState>(tick->state) == SafetyState::kStopped;
}

std::vector<std::string> NamesOfPeers(const PeerDirectory& directory) {
  std::vector<std::string> names;
  for (const PeerDirectory::Entry& entry : directory.Entries()) {
    names.push_back(directory.NameOf(entry.info.peer));
  }
  return names;
}

/// Returns how the ticks of the device process went; nothing: there is none.
std::optional<DeviceTimes> TimesOf(const Joining& joining) {
  if (joining.device() == nullptr) return std::nullopt;
  return joining.device()->times();
}

std::optional<PassivityAccount> PassivityOf(const Joining& joining) {
  if (joining.device() == nullptr) return std::nullopt;
  return joining.device()->Newest().value_or(DeviceTick{}).passivity;
}

/// Lets the handle go from what it leads, or takes it up again. Returns what to say of that.
std::string Clutch(const PeerArguments& arguments, bool pressed) {
  if (!arguments.space->Change({.clutch = pressed})) {
    return "clutch: only a device in a process of its own has one";
  }
  return pressed ? "the handle moves alone, until 'clutch off'" : "the handle leads again";
}

/// Takes part in a session once. Returns the exit code or kJoinAgain. `may_join_again`: other force
/// parameters, offered at the same time, still count.
int RunOnce(PeerArguments& arguments, PeerControl* control, bool may_join_again) {
  if (!arguments.report.empty()) {
    std::string fault = WhyNotWritable(arguments.report);
    if (fault.empty()) fault = WhyNoTrace(arguments.report + ".trace");
    if (!fault.empty()) return Fail(kExitFile, fault);
  }
  Result<NetworkPlan> plan = NetworkPlan{};
  if (!arguments.network.empty()) plan = LoadNetworkPlan(arguments.network);
  if (!plan) return Fail(kExitFile, plan.error().what);
  Joining joining;
  joining.waiting = RoomFor(*plan, arguments.conditions);
  if (const int failed = Join(arguments, joining); failed != kExitOk) return failed;
  // asked while there is no haptic thread, because it runs other programs to look at keys
  const std::string security =
      arguments.repeats ? "" : SecurityOf(arguments.reach, arguments.session);
  PeerNode& node = *joining.node;
  Transport& transport = *joining.transport;
  if (control != nullptr) control->Begin(arguments, joining);
  const std::atomic<bool>& stop_asked = StopOnSignals();

  // The haptic thread says when it has begun and when it has done its frames. It goes on until it
  // is stopped, because other peers still feel its instance.
  std::atomic<bool> begun{false};
  std::atomic<bool> done{false};
  std::atomic<bool> holds{false};  // the hand holds a body
  const auto frames = static_cast<std::int64_t>(arguments.seconds * 1000.0);
  std::int64_t frames_since_start = 0;
  bool hand_moves = false;  // in the present frame of the haptic thread
  // follows the frames' times; nothing: the capacity stays as given
  std::optional<CapacityFollower> capacity;
  if (arguments.capacity == 0) {
    capacity.emplace(joining.capacity.tests, joining.capacity.look_price, kFrameBudget);
  }
  SpscQueue<HeldPose> held_poses(256);  // to the control thread, which takes them 50 times a second
  constexpr std::int64_t kPoseFrames = 5;
  BodiesMet met(joining.model->bodies.size());
  // a device's ticks and our frames begin together
  const std::int64_t origin_ns =
      joining.device() != nullptr ? joining.device()->origin_ns() : MonotonicNowNs();
  constexpr std::int64_t kHapticPeriodNs = 1'000'000;
  JudgedFrames judged(origin_ns, kHapticPeriodNs);
  PeriodicThread haptic(
      {.period_ns = kHapticPeriodNs,
       .origin_ns = origin_ns,
       .core = arguments.core,
       .name = "haptic"},
      [&](std::int64_t, std::int64_t now_ns) {
        kHapticThread.Enter();
        if (capacity) node.peer().SetCapacity(capacity->tests());
        if (control != nullptr) control->BeforeFrame();
        node.HapticFrame(now_ns);
        if (control != nullptr) control->AfterFrame(now_ns);
        hand_moves = node.peer().started_ns() && (frames == 0 || frames_since_start < frames);
        if (node.peer().started_ns()) {
          if (const RigidState* held = node.peer().held_state(); held != nullptr) {
            const int body = HeldBody(node);
            met.See(node.world(), body);
            holds.store(true, std::memory_order_relaxed);
            // a full queue loses the pose: then fewer poses judge the run
            if (frames_since_start % kPoseFrames == 0) {
              static_cast<void>(held_poses.TryPush({.body = body, .X_WB = held->X_WB}));
            }
          }
          begun.store(true, std::memory_order_relaxed);
          if (++frames_since_start == frames) done.store(true, std::memory_order_release);
        }
        return true;
      },
      [&](std::int64_t start_ns, std::int64_t end_ns, std::int64_t cpu_ns) {
        const StepReport& report = node.peer().report();
        if (capacity && report.waited == 0) {
          capacity->Count(report, 1e-9 * static_cast<double>(cpu_ns));
        }
        judged.Add(hand_moves, start_ns, end_ns, cpu_ns);
      });
  // stops the haptic thread at a forced end, whatever this thread is in; `joining` says goodbye
  const AtForcedEnd no_more_force([&haptic] {
    haptic.Stop();
  });
  PeriodicThread sender({.origin_ns = origin_ns + kSenderPhaseNs, .priority = 20, .name = "sender"},
                        [&](std::int64_t, std::int64_t) {
                          kSenderThread.Enter();
                          SendWhenDone(node, transport, MachineClock());
                          return true;
                        });
  const RealtimeStatus& realtime = haptic.realtime();
  if (!realtime.warning.empty()) Say(realtime.warning);
  if (arguments.require_rt && !realtime.fifo) {
    haptic.Stop();
    haptic.Join();
    if (control != nullptr) control->End();
    transport.Leave();
    return Fail(kExitNotRealTime, "not real-time, and --require-rt was given");
  }
  Say((Speaker().empty() ? arguments.name + " is in session " : "in session ") + arguments.session +
      " (" + realtime.scheduler() + ")");
  if (!arguments.repeats) Say(security);
  if (arguments.hold.empty()) Say(WhatThereIsToHold(*joining.model));

  std::optional<TraceFile> trace;
  if (!arguments.report.empty()) {
    trace.emplace(arguments.report + ".trace", [&node] {
      return node.peer().trace();
    });
  }
  kControlThread.Enter();
  constexpr std::int64_t kControlPeriodNs = 20'000'000;
  constexpr std::int64_t kWaitingNs = 2'000'000'000;
  constexpr std::int64_t kAloneNs = 5'000'000'000;
  constexpr std::int64_t kNewcomerNs = 10'000'000'000;  // no peer is sent away after this
  const std::int64_t opened_ns = MonotonicNowNs();
  std::int64_t next_ns = opened_ns;
  std::int64_t done_ns = 0;
  OrderReader orders;
  NewsLimiter news;  // news about other programs
  RefusalNews refusals;
  PlannedNetwork network(joining.waiting);
  if (!arguments.network.empty()) network.Start(*std::move(plan), opened_ns);
  const NameFunction name = [&node](PeerId peer) {
    return node.directory().NameOf(peer);
  };
  PeerTable table;  // last table with a peer in it
  HeldPoses poses;
  HeldPose pose;
  bool waiting_told = false;  // user knows that the hand waits for others
  bool hand_told = false;     // hand has begun
  bool stop_seen = false;     // stop at the device
  bool quit = false;
  const auto give_order = [&](const Command& command) {
    return control != nullptr ? control->Order(command) : node.peer().commands().TryPush(command);
  };
  const PeerNode::OnHand on_hand = control != nullptr ? control->on_hand() : PeerNode::OnHand();
  int exit_code = kExitOk;
  while (!stop_asked.load()) {
    const std::int64_t now_ns = MonotonicNowNs();
    node.ControlFrame(now_ns, transport);
    if (const std::vector<std::string> fresh = node.TakeNews(on_hand); !fresh.empty()) {
      const std::vector<std::string> names = NamesOfPeers(node.directory());
      for (const std::string& line : fresh) news.Add(AboutWhom(line, names), line);
    }
    for (const std::string& line : refusals.Look(PacketsJudged())) news.Add("", line);
    if (joining.files) {
      if (const std::string line = joining.files->TakeNews(); !line.empty()) news.Add("", line);
    }
    for (const std::string& line : news.Due(now_ns)) Say(line);
    if (DeviceProcess* device = joining.device(); device != nullptr) {
      if (const std::string line = device->News(); !line.empty()) {
        Say(line);
        if (control != nullptr) control->OnLine(line);
      }
      // a stop by the device's button stops the hand, too
      const bool stopped = StoppedAtDevice(*device);
      if (stopped && !std::exchange(stop_seen, stopped)) give_order({.kind = Command::Kind::kStop});
      stop_seen = stopped;
    }
    while (held_poses.TryPop(pose)) poses.Add(pose);
    if (begun.load(std::memory_order_relaxed) && !std::exchange(hand_told, true)) {
      network.HandBegins(now_ns);
    }
    if (arguments.on_entered && hand_told && (arguments.hold.empty() || holds.load())) {
      const auto tell = std::exchange(arguments.on_entered, nullptr);
      tell({.peer = joining.id, .name = arguments.name, .holding = arguments.hold});
    }
    for (const std::string& line : network.Apply(now_ns, node.directory(), node.inbox())) Say(line);
    if (const PeerTable& now = node.peer().table().Read(); now.count > 0) table = now;
    if (joining.recorder) {
      if (const std::string line = joining.recorder->News(); !line.empty()) Say(line);
      for (const PeerDirectory::Entry& entry : node.directory().Entries()) {
        joining.recorder->Named(entry.info.peer, name(entry.info.peer));
      }
    }
    for (const Result<std::string>& taken : orders.TakeLines()) {
      if (!taken) {
        Say(taken.error().what);
        continue;
      }
      const std::string& line = *taken;
      if (line == "quit") {
        quit = true;
        continue;
      }
      if (line == "help") {
        for (const std::string& row : HelpOnOrders()) Say(row);
        continue;
      }
      if (line == "peers") {
        for (const std::string& row : AsLines(node.peer().table().Read(), name)) Say(row);
        for (const std::string& row : TermsOf(node.directory())) Say(row);
        continue;
      }
      if (line == "clutch" || line == "clutch off") {
        Say(Clutch(arguments, line == "clutch"));
        continue;
      }
      if (PlannedNetwork::IsOrder(line)) {
        const std::size_t senders = ActiveIn(node.directory());
        if (const auto wrong = network.Obey(line, now_ns, senders)) Say(wrong->what);
        continue;
      }
      const Result<Command> order =
          ParseOrder(line, *joining.model, node.directory(), joining.unequal.has_value());
      if (!order) {
        Say(order.error().what);
      } else if (!give_order(*order)) {
        Say("too many orders at once: '" + line + "' is not obeyed");
      } else if (const std::string answer = AnswerTo(*order, *joining.model); !answer.empty()) {
        Say(answer);
      }
    }
    if (control != nullptr) {
      const PeerControl::Wish wish = control->Turn(table);
      quit = quit || wish == PeerControl::Wish::kQuit;
      if (wish == PeerControl::Wish::kJoinAgain) exit_code = kJoinAgain;
    }
    if (quit || exit_code == kJoinAgain) break;
    if (now_ns - opened_ns < kNewcomerNs && node.OneTooMany()) {
      exit_code =
          Fail(kExitNetwork, "session " + arguments.session + " has " + std::to_string(kMaxPeers) +
                                 " active peers, the most there can be: look on with "
                                 "'tandem watch'");
      break;
    }
    if (now_ns - opened_ns < kNewcomerNs && node.IsTwin()) {
      exit_code = Fail(kExitSecurity, arguments.reach.secure +
                                          ": these keys are in use in this session already: end "
                                          "the other program, or take keys of your own");
      break;
    }
    if (node.peer().voxels_lack()) {
      exit_code = Fail(kExitFile, node.world().WhyVoxelsLack());
      break;
    }
    if (const std::string ended = transport.KeysEnd(); !ended.empty()) {
      exit_code = Fail(kExitSecurity, ended);
      break;
    }
    if (!begun.load(std::memory_order_relaxed) && may_join_again && Superseded(joining)) {
      Say("other force parameters were offered to the session at the same time: joining anew by "
          "those");
      exit_code = kJoinAgain;
      break;
    }
    if (!begun.load(std::memory_order_relaxed) &&
        static_cast<double>(now_ns - opened_ns) > 1e9 * arguments.wait_seconds) {
      exit_code =
          Fail(kExitNetwork, "nobody to begin with came within " + Seconds(arguments.wait_seconds) +
                                 ": --wait-for counts others who hold a body");
      for (const PeerDirectory::Entry& entry : node.directory().Entries()) {
        if (!entry.refused.empty()) exit_code = kExitIncompatiblePeer;
      }
      break;
    }
    if (!arguments.alone.empty() && now_ns - opened_ns > kAloneNs) {
      if (node.directory().Entries().empty()) Say(arguments.alone);
      arguments.alone.clear();
    }
    if (!waiting_told && !begun.load(std::memory_order_relaxed) && arguments.wait_for > 0 &&
        now_ns - opened_ns > kWaitingNs) {
      waiting_told = true;
      Say("your hand waits for others who hold a body, of a shared one the same: --wait-for " +
          std::to_string(arguments.wait_for) + ", given up after " +
          Seconds(arguments.wait_seconds));
    }
    // other peers' last frames still need ours: one more second
    if (done.load(std::memory_order_acquire) && done_ns == 0) done_ns = now_ns;
    if (done_ns != 0 && now_ns - done_ns > 1'000'000'000) break;
    next_ns += kControlPeriodNs;
    MachineClock().SleepUntil(next_ns);
  }
  for (const std::string& line : news.Rest()) Say(line);
  haptic.Stop();
  haptic.Join();
  StillEnding();
  if (control != nullptr) control->End();
  sender.Stop();
  sender.Join();
  if (joining.device() != nullptr && exit_code != kJoinAgain) joining.device()->End();
  const std::uint64_t socket_dropped = PacketsDroppedAtSockets();
  node.Leave(MonotonicNowNs(), transport);
  StillEnding();
  if (joining.recorder) {
    // frames before a new join are no part of the session
    if (exit_code == kJoinAgain && !begun.load()) joining.recorder->Discard();
  }
  if (joining.recorder && (exit_code != kJoinAgain || begun.load())) {
    const Result<std::uint64_t> recorded = joining.recorder->Close();
    if (!recorded) {
      const int failed = Fail(kExitFile, recorded.error().what);
      if (exit_code == kExitOk) exit_code = failed;
    }
    if (recorded) Say(arguments.record + ": " + Counted(*recorded, "frame") + " recorded");
  }
  StillEnding();
  for (const std::string& line : Explain(node.peer().hand_figures().limits)) Say(line);
  if (exit_code == kJoinAgain || (exit_code != kExitOk && arguments.report.empty())) {
    return exit_code;
  }
  while (held_poses.TryPop(pose)) poses.Add(pose);
  const std::vector<BodyVerdict> verdicts = VerdictsOfPeer(
      arguments, joining, poses, met, stop_asked.load() ? kHurriedVerdictSeconds : kVerdictSeconds);
  StillEnding();
  for (const BodyVerdict& verdict : verdicts) {
    if (exit_code == kExitOk) Say(Describe(verdict));
  }
  if (arguments.report.empty()) return exit_code;

  const ResidentVoxels* voxels = node.world().resident_voxels();
  PeerReport report{
      .name = arguments.name,
      .pid = getpid(),
      .scheduler = realtime.scheduler(),
      .mean_delay_s = node.peer().mean_delay_s(),
      .hand = node.peer().hand_figures(),
      .traced_frames = node.peer().trace().size(),
      .device = arguments.device,
      .device_times = TimesOf(joining),
      .device_scheduler = joining.device() != nullptr ? joining.device()->scheduler() : "",
      .passivity = PassivityOf(joining),
      .safety_state = node.peer().safety_state(),
      .safety = node.peer().safety_counts(),
      .guarded_share = node.peer().guard().guarded_share(),
      .felt = node.peer().felt(),
      .crowded_frames = node.peer().crowded_frames(),
      .waits = node.peer().voxel_waits(),
      .voxel_memory = voxels != nullptr ? voxels->bytes() : joining.model->fixture.header().bytes,
      .voxels_locked = voxels != nullptr ? voxels->locked() : realtime.memory_locked,
      .paged = voxels != nullptr ? voxels->counts() : ResidentCounts{},
      .own_states = node.sent_states()};
  CountShapes(joining, report);
  report.drops = node.inbox().drops().Total();
  report.drops[static_cast<std::size_t>(Drop::kManyKeys)] += InstancesRefused();
  AddDelivery(node.inbox().delivery(), report);
  report.peers = AsJson(table, name);
  report.force_terms = TermsAsJson(node.directory());
  report.start_gaps = AsJson(joining.start_gaps);
  report.verdicts = AsJson(verdicts);
  report.socket_dropped = socket_dropped;
  report.packets = PacketsJudged();
  const int written = WriteReport(arguments, report, haptic.stats(), judged, *trace);
  return exit_code != kExitOk ? exit_code : written;
}

/// Looks on as tandem watch does.
int LookOn(const PeerArguments& arguments) {
  if (!arguments.hold.empty() || !arguments.hand.empty() || !arguments.record.empty()) {
    return Fail(kExitUsage, "--role viewer: a viewer neither holds nor records anything");
  }
  WatchOptions options;
  options.session = arguments.session;
  options.scene = arguments.scene;
  options.scene_from_session = arguments.scene_from_session;
  options.fetch = {.accept = arguments.accept_scene, .limit_mb = arguments.scene_limit_mb};
  options.name = arguments.name;
  options.reach = arguments.reach;
  options.seconds = arguments.seconds;
  options.report = arguments.report;
  options.on_entered = arguments.on_entered;
  return WatchCommand(options);
}

bool HoldsBytes(const std::string& file) {
  std::error_code not_there;
  return std::filesystem::is_regular_file(file, not_there) &&
         std::filesystem::file_size(file, not_there) > 0;
}

}  // namespace

int RunPeer(PeerArguments& arguments) {
  if (arguments.role == "viewer") return LookOn(arguments);  // a viewer needs no scene
  if (arguments.scene.empty() && !arguments.scene_from_session) {
    return Fail(kExitUsage, "--scene is required, or --scene-from-session (tandem peer --help)");
  }
  if (arguments.as_part) Speaker() = arguments.name;
  if (!arguments.record.empty() && arguments.voxel_memory > 0) {
    return Fail(kExitUsage,
                "--record: what is recorded is played again with all voxels in memory, which waits "
                "for none: leave --voxel-memory away");
  }
  if (HoldsBytes(arguments.record)) {
    return Fail(kExitFile, arguments.record + " exists already: recordings are never overwritten");
  }
  arguments.space = std::make_shared<DeviceSpace>(arguments.workspace);
  std::unique_ptr<PeerControl> control;
  if (!arguments.control.empty()) {
    Result<std::unique_ptr<PeerControl>> opened = PeerControl::Open(arguments);
    if (!opened) return Fail(kExitNetwork, opened.error().what);
    control = *std::move(opened);
  }
  constexpr int kMostJoins = 3;  // limit for force parameters that others offer meanwhile
  int exit_code = kJoinAgain;
  const std::string record = arguments.record;
  int joins = 0;
  for (int run = 1; exit_code == kJoinAgain; ++run, ++joins) {
    if (control && control->TakeLoad(arguments)) joins = 0;
    // each scene that a host loads has a recording of its own
    if (HoldsBytes(arguments.record)) arguments.record = record + "." + std::to_string(run);
    exit_code = RunOnce(arguments, control.get(), joins < kMostJoins);
    if (exit_code == kEndedWhileLoading) exit_code = kExitOk;
    // if a host's scene cannot be loaded, the previous one goes on
    const bool failed = exit_code != kJoinAgain && exit_code != kExitOk;
    if (failed && control && control->RevertLoad(arguments, LastSaid())) exit_code = kJoinAgain;
  }
  return exit_code;
}

void AddPeerCommand(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<PeerArguments>();
  arguments->name = "peer-" + std::to_string(getpid());
  CLI::App* command = app.add_subcommand(
      "peer", "Take part in a session: simulation, device and network, no window");
  AddPeerOptions(*command, *arguments);
  command->callback([arguments, &exit_code] {
    exit_code = RunPeer(*arguments);
  });
}

}  // namespace tandem
