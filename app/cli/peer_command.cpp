#include <atomic>
#include <csignal>
#include <fstream>
#include <memory>
#include <thread>

#include <unistd.h>

#include "app/cli/capacity.h"
#include "app/cli/commands.h"
#include "app/cli/network_plan.h"
#include "app/cli/peer_orders.h"
#include "app/cli/peer_report.h"
#include "app/cli/peer_table_text.h"
#include "app/cli/talk.h"
#include "app/exit_codes.h"
#include "app/reach/reach_options.h"
#include "collab/dds/dds_transport.h"
#include "collab/dds/socket_drops.h"
#include "collab/peer_node.h"
#include "collab/recording/recorder.h"
#include "engine/haptics/scripted_device.h"
#include "engine/realtime/periodic_thread.h"

namespace tandem {

namespace {

struct PeerArguments {
  std::string session;
  std::string scene;
  std::string hold;
  std::string hand;
  std::string name;
  ReachOptions reach;
  std::size_t wait_for = 0;
  double wait_seconds = 60;
  double seconds = 0;  // after the hand's start; 0: until a signal comes
  LinkConditions conditions;
  std::string network;  // plan file
  std::string law = "p+d";
  bool lab = false;
  double publish_hz = 1000;
  double capacity = 0;  // points a frame; 0: measured
  int threads = 1;      // that share a haptic frame's work
  std::string report;
  std::string record;
  bool no_contact = false;
  bool require_rt = false;
};

std::atomic<bool> stop_asked{false};
static_assert(std::atomic<bool>::is_always_lock_free);

void AskToStop(int) {
  stop_asked.store(true);
}

// how long those who are in the session already may take to be discovered
constexpr std::int64_t kSettleNs = 1'000'000'000;

/// A scene loaded, and the node that will simulate it.
struct Prepared {
  std::shared_ptr<const WorldModel> model;
  std::unique_ptr<FrameHelpers> helpers;  // null: none
  std::unique_ptr<Recorder> recorder;     // null: none; outlives the node
  std::unique_ptr<PeerNode> node;
  PeerId id = 0;
  double capacity = 0;
};

/// Loads everything, or says why not and gives the exit code.
int Prepare(PeerArguments& arguments, Prepared& prepared) {
  const Result<PeerId> id = Identify(arguments.reach, Role::kActive, arguments.name);
  if (!id) return Fail(kExitSecurity, id.error().what);
  prepared.id = *id;
  const auto law = MakeLaw(arguments.law, {}, arguments.lab);
  if (!law) return Fail(kExitUsage, law.error().what);
  const Result<Scene> scene = LoadScene(arguments.scene);
  if (!scene) return Fail(kExitFile, scene.error().what);
  const Result<std::uint64_t> hash = HashScene(*scene);
  if (!hash) return Fail(kExitFile, hash.error().what);
  Result<std::shared_ptr<const WorldModel>> model = LoadWorld(*scene);
  if (!model) return Fail(kExitFile, model.error().what);
  prepared.model = *model;

  NodeOptions options;
  options.peer.id = prepared.id;
  options.peer.wait_for = arguments.wait_for;
  options.peer.settle_ns = kSettleNs;
  options.peer.coupling.law = *law;
  options.peer.trace_frames = static_cast<std::size_t>(arguments.seconds * 1000.0);
  options.name = arguments.name;
  options.conditions = arguments.conditions;
  options.publish_hz = arguments.publish_hz;
  HandScript script;
  Pose X_WB0;
  if (!arguments.hold.empty()) {
    const int found = (*model)->BodyNamed(arguments.hold);
    if (found < 0) {
      return Fail(kExitUsage, "--hold " + arguments.hold + ": " + scene->file.string() +
                                  " has no moving body of that name");
    }
    const auto body = static_cast<std::size_t>(found);
    const ObjectId object = (*model)->object[body];
    options.peer.held_object = static_cast<int>(object);
    X_WB0 = (*model)->bodies[body].X_WB0;
  }
  if (!arguments.hand.empty()) {
    Result<HandScript> loaded = LoadHandScript(arguments.hand);
    if (!loaded) return Fail(kExitFile, loaded.error().what);
    script = std::move(*loaded);
    options.peer.X_BD = script.X_BD;
  }
  if (arguments.threads > 1) {
    prepared.helpers =
        std::make_unique<FrameHelpers>(FrameHelpers::Options{.threads = arguments.threads});
    options.helpers = prepared.helpers.get();
  }
  options.peer.capacity = arguments.capacity > 0
                              ? arguments.capacity
                              : MeasureCapacity(**model, kTestBudget, options.helpers);
  prepared.capacity = options.peer.capacity;
  if (!arguments.record.empty()) {
    Result<std::unique_ptr<Recorder>> recorder =
        Recorder::Create(arguments.record, {.program = TANDEM_VERSION,
                                            .name = arguments.name,
                                            .scene = std::filesystem::absolute(scene->file),
                                            .scene_hash = *hash,
                                            .voxel_size = scene->voxel_size,
                                            .contact = !arguments.no_contact,
                                            .law = arguments.law,
                                            .peer = options.peer});
    if (!recorder) return Fail(kExitFile, recorder.error().what);
    prepared.recorder = *std::move(recorder);
    options.peer.tap = prepared.recorder.get();
  }
  prepared.node = std::make_unique<PeerNode>(
      prepared.model, std::make_unique<ScriptedDevice>(std::move(script), X_WB0), *hash, options);
  if (arguments.no_contact) prepared.node->world().SwitchContactOff();
  for (const std::string& remark : prepared.model->remarks) Say(remark);
  return kExitOk;
}

/// The points that are tested, and the voxels they are tested against.
void CountShapes(const Prepared& prepared, PeerReport& report) {
  report.capacity = prepared.capacity;
  report.voxels = prepared.model->has_fixture ? prepared.model->fixture.Count().total() : 0;
  for (const BodyModel& body : prepared.model->bodies) {
    report.points += body.points.size();
    if (!prepared.model->has_fixture) report.voxels += body.voxmap.Count().total();
  }
}

int WriteReport(const PeerArguments& arguments, const PeerReport& report, const FrameStats& stats,
                const std::vector<TraceSample>& trace) {
  std::ofstream stream(arguments.report);
  stream << AsJson(report, stats, trace).dump(2) << '\n';
  if (!stream.flush()) return Fail(kExitFile, arguments.report + ": cannot be written");
  const Result<bool> written = WriteTrace(arguments.report + ".trace", trace);
  return written ? kExitOk : Fail(kExitFile, written.error().what);
}

int RunPeer(PeerArguments& arguments) {
  Result<NetworkPlan> plan = NetworkPlan{};
  if (!arguments.network.empty()) plan = LoadNetworkPlan(arguments.network);
  if (!plan) return Fail(kExitFile, plan.error().what);
  Prepared prepared;
  if (const int failed = Prepare(arguments, prepared); failed != kExitOk) return failed;
  PeerNode& node = *prepared.node;
  DdsOptions dds;
  dds.session = arguments.session;
  dds.peer = prepared.id;
  dds.objects = prepared.model->object;
  ApplyReach(arguments.reach, dds);
  Result<std::unique_ptr<Transport>> joined = JoinOverDds(dds, node.inbox());
  if (!joined) {
    return Fail(arguments.reach.secure.empty() ? kExitNetwork : kExitSecurity, joined.error().what);
  }
  Transport& transport = **joined;
  std::signal(SIGINT, AskToStop);
  std::signal(SIGTERM, AskToStop);

  // the haptic thread says when it has begun and when it has done its frames; it goes on until
  // stopped, for the others still feel its instance
  std::atomic<bool> begun{false};
  std::atomic<bool> done{false};
  const auto frames = static_cast<std::int64_t>(arguments.seconds * 1000.0);
  std::int64_t frames_since_start = 0;
  PeriodicThread haptic({.name = "haptic"}, [&](std::int64_t, std::int64_t now_ns) {
    kHapticThread.Enter();
    node.HapticFrame(now_ns);
    if (node.peer().started_ns()) {
      begun.store(true, std::memory_order_relaxed);
      if (++frames_since_start == frames) done.store(true, std::memory_order_release);
    }
    return true;
  });
  PeriodicThread sender({.priority = 20, .name = "sender"}, [&](std::int64_t, std::int64_t now_ns) {
    kSenderThread.Enter();
    node.SendFrame(now_ns, transport);
    return true;
  });
  const RealtimeStatus& realtime = haptic.realtime();
  if (!realtime.warning.empty()) Say(realtime.warning);
  if (arguments.require_rt && !realtime.fifo) {
    transport.Leave();
    return Fail(kExitNotRealTime, "not real-time, and --require-rt was given");
  }
  Say(arguments.name + " is in session " + arguments.session + " (" + realtime.scheduler() + ")");

  Say(SecurityOf(arguments.reach, arguments.session));

  kControlThread.Enter();
  constexpr std::int64_t kControlPeriodNs = 20'000'000;
  const std::int64_t opened_ns = MonotonicNowNs();
  std::int64_t next_ns = opened_ns;
  std::int64_t done_ns = 0;
  OrderReader orders;
  PlannedNetwork network;
  if (!arguments.network.empty()) network.Start(*std::move(plan), opened_ns);
  const NameFunction name = [&node](PeerId peer) {
    return node.directory().NameOf(peer);
  };
  PeerTable table;  // the last one with anybody in it
  int exit_code = kExitOk;
  while (!stop_asked.load()) {
    const std::int64_t now_ns = MonotonicNowNs();
    node.ControlFrame(now_ns, transport);
    for (const std::string& news : node.TakeNews()) Say(news);
    for (const std::string& news : network.Apply(now_ns, node.directory(), node.inbox())) Say(news);
    if (const PeerTable& now = node.peer().table().Read(); now.count > 0) table = now;
    for (const std::string& line : orders.TakeLines()) {
      if (line == "peers") {
        for (const std::string& row : AsLines(node.peer().table().Read(), name)) Say(row);
        continue;
      }
      if (PlannedNetwork::IsOrder(line)) {
        if (const auto wrong = network.Obey(line, now_ns)) Say(wrong->what);
        continue;
      }
      const Result<Command> order = ParseOrder(line, *prepared.model, node.directory());
      if (!order) {
        Say(order.error().what);
      } else if (!node.peer().commands().TryPush(*order)) {
        Say("too many orders at once: '" + line + "' is not obeyed");
      }
    }
    if (!begun.load(std::memory_order_relaxed) &&
        static_cast<double>(now_ns - opened_ns) > 1e9 * arguments.wait_seconds) {
      exit_code = Fail(kExitNetwork, "nobody to begin with came within " +
                                         std::to_string(arguments.wait_seconds) + " s");
      for (const PeerDirectory::Entry& entry : node.directory().Entries()) {
        if (!entry.refused.empty()) exit_code = kExitIncompatiblePeer;
      }
      break;
    }
    // the others' last frames still need ours: one more second
    if (done.load(std::memory_order_acquire) && done_ns == 0) done_ns = now_ns;
    if (done_ns != 0 && now_ns - done_ns > 1'000'000'000) break;
    next_ns += kControlPeriodNs;
    MachineClock().SleepUntil(next_ns);
  }
  haptic.Stop();
  haptic.Join();
  sender.Stop();
  sender.Join();
  const std::uint64_t socket_dropped = PacketsDroppedAtSockets();
  node.Leave(MonotonicNowNs(), transport);
  if (prepared.recorder) {
    const Result<std::uint64_t> recorded = prepared.recorder->Close();
    if (!recorded) exit_code = Fail(kExitFile, recorded.error().what);
    if (recorded) Say(arguments.record + ": " + std::to_string(*recorded) + " frames recorded");
  }
  if (exit_code != kExitOk || arguments.report.empty()) return exit_code;

  PeerReport report{.name = arguments.name,
                    .pid = getpid(),
                    .scheduler = realtime.scheduler(),
                    .mean_delay_s = node.peer().mean_delay_s(),
                    .guarded_share = node.peer().guard().guarded_share()};
  CountShapes(prepared, report);
  report.drops = node.inbox().drops().Total();
  AddDelivery(node.inbox().delivery(), report);
  report.peers = AsJson(table, name);
  report.socket_dropped = socket_dropped;
  return WriteReport(arguments, report, haptic.stats(), node.peer().trace());
}

}  // namespace

void AddPeerCommand(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<PeerArguments>();
  arguments->name = "peer-" + std::to_string(getpid());
  CLI::App* command = app.add_subcommand(
      "peer", "Take part in a session: simulation, device and network, no window");
  command->add_option("--session", arguments->session, "name of the session to join")->required();
  command->add_option("--scene", arguments->scene, "scene file")->required();
  command->add_option("--hold", arguments->hold, "body to take in hand");
  command->add_option("--hand", arguments->hand, "hand file: a script in place of a device");
  command->add_option("--name", arguments->name, "how others see you");
  command->add_option("--wait-for", arguments->wait_for,
                      "the hand starts when that many others are there");
  command->add_option("--wait-seconds", arguments->wait_seconds, "give up waiting after this");
  command->add_option("--seconds", arguments->seconds,
                      "leave so long after the hand's start; 0: on a signal");
  command
      ->add_option("--delay-ms", arguments->conditions.delay_ms, "delay injected in what is heard")
      ->check(CLI::Range(0.0, 2000.0));
  command
      ->add_option("--jitter-ms", arguments->conditions.jitter_ms, "up to so much more, at random")
      ->check(CLI::Range(0.0, 1000.0));
  command->add_option("--loss", arguments->conditions.loss, "share of samples lost, 0 to 1")
      ->check(CLI::Range(0.0, 1.0));
  command->add_option("--seed", arguments->conditions.seed, "of jitter and loss");
  CLI::Option* network = command->add_option(
      "--network", arguments->network,
      "plan file: what is heard of whom comes late, twice or not at all, and when");
  for (const char* option : {"--delay-ms", "--jitter-ms", "--loss", "--seed"}) {
    network->excludes(option);
  }
  command->add_option("--law", arguments->law, "how stiffness follows delay")
      ->check(CLI::IsMember({"p+d", "linear", "pdopt", "constant"}));
  command->add_flag("--lab", arguments->lab, "allow the law 'constant', which can shake");
  command
      ->add_option("--capacity", arguments->capacity,
                   "points that may be tested in a frame; default: what fits 300 us here")
      ->check(CLI::PositiveNumber);
  command->add_option("--threads", arguments->threads, "threads that share a large frame's work")
      ->check(CLI::Range(1, FrameHelpers::kMostThreads))
      ->capture_default_str();
  command->add_option("--publish-hz", arguments->publish_hz, "rate of states sent")
      ->check(CLI::Range(10.0, 1000.0));
  AddReachOptions(*command, arguments->reach);
  command->add_option("--report", arguments->report, "write a report (JSON) and a trace there");
  command->add_option("--record", arguments->record,
                      "keep every input of every frame there, for 'tandem replay'");
  command->add_flag("--no-contact", arguments->no_contact, "bodies pass through one another");
  command->add_flag("--require-rt", arguments->require_rt, "fail when SCHED_FIFO is not granted");
  command->callback([arguments, &exit_code] {
    exit_code = RunPeer(*arguments);
  });
}

}  // namespace tandem
