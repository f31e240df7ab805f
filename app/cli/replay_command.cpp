#include <atomic>
#include <cinttypes>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>

#include <nlohmann/json.hpp>

#include "app/cli/commands.h"
#include "app/cli/replay_viewers.h"
#include "app/common/console.h"
#include "app/common/exit_codes.h"
#include "app/common/option_checks.h"
#include "app/common/stop_signal.h"
#include "app/connection/connection_options.h"
#include "app/judgement/start_gaps.h"
#include "app/judgement/verdict.h"
#include "app/recording/recorded_scene.h"
#include "app/recording/replay_network.h"
#include "collab/recording/poses_export.h"
#include "collab/recording/recording_export.h"
#include "collab/recording/replay.h"
#include "engine/base/text/json_text.h"
#include "engine/realtime/clock.h"

namespace tandem {

namespace {

using nlohmann::ordered_json;

constexpr std::int64_t kFramesPerSecond = 1000;
constexpr std::int64_t kControlFrames = 20;    // from one ControlFrame to the next
constexpr std::int64_t kReplayPoseFrames = 5;  // from one pose that is judged to the next

struct ReplayArguments {
  std::string file;
  std::string scene;     // name or file; empty: the recorded file
  std::string session;   // session in which viewers look on; empty: none
  std::string exported;  // file of the export; empty: none
  std::string network;   // file for a trace of what was heard; empty: none
  std::string from;      // peer whose trace is made
  ConnectionOptions connection;
  double speed = 0;  // times real time; 0: as fast as it goes
  int threads = 1;
  bool adopt_any = false;  // take the recorded voxels, however far from the scene file's
  bool json = false;
};

/// Writes a replay into a file, frame by frame.
class Export {
 public:
  virtual ~Export() = default;
  virtual void Add(const RecordedFrame& frame, PeerNode& node) = 0;
  /// Ends the file. Returns how much is in it, in words.
  virtual Result<std::string> Close() = 0;
};

template <typename File>
class ExportTo final : public Export {
 public:
  ExportTo(std::unique_ptr<File> file, std::string one)
      : file_(std::move(file)), one_(std::move(one)) {}
  void Add(const RecordedFrame& frame, PeerNode& node) override { file_->Add(frame, node); }
  Result<std::string> Close() override {
    const Result<std::uint64_t> count = file_->Close();
    if (!count) return count.error();
    return WithPlural(*count, one_);
  }

 private:
  std::unique_ptr<File> file_;
  std::string one_;
};

/// Makes the export by the file's ending: poses as .csv, all as .mcap.
Result<std::unique_ptr<Export>> ExportInto(const std::string& file, const RecordingHeader& header,
                                           const WorldModel& model,
                                           const std::map<PeerId, std::string>& names) {
  if (EndingOf(file) == ".csv") {
    Result<std::unique_ptr<PosesExport>> poses = PosesExport::Create(file, model);
    if (!poses) return poses.error();
    return std::unique_ptr<Export>(new ExportTo<PosesExport>(*std::move(poses), "pose"));
  }
  Result<std::unique_ptr<RecordingExport>> all =
      RecordingExport::Create(file, header, model, names);
  if (!all) return all.error();
  return std::unique_ptr<Export>(new ExportTo<RecordingExport>(*std::move(all), "message"));
}

/// Runs the replay at its speed; shows and exports it as it goes.
class Player {
 public:
  Player(const ReplayArguments& arguments, PeerNode& node, const ActivePeerInbox& active_peers,
         Transport& transport, Export* exported, const std::atomic<bool>& stop_asked)
      : arguments_(arguments),
        node_(node),
        ears_(active_peers),
        transport_(transport),
        exported_(exported),
        stop_asked_(stop_asked) {}

  /// Call it after each frame; false ends the run.
  bool After(std::int64_t number, const RecordedFrame& frame) {
    node_.SendFrame(frame.now_ns, transport_);
    if (number % kControlFrames == 0) {
      node_.ControlFrame(frame.now_ns, transport_);
      newcomer_ = ears_.Active();
    }
    if (exported_ != nullptr) exported_->Add(frame, node_);
    if (const RigidState* held = node_.peer().held_state(); held != nullptr) {
      const int body = HeldBody(node_);
      met_.See(node_.world(), body);
      if (number % kReplayPoseFrames == 0) poses_.Add({.body = body, .X_WB = held->X_WB});
    }
    if ((number + 1) % kFramesPerSecond == 0) {
      golden_.push_back(Hex(frame.state_hash));
    }
    if (arguments_.speed > 0) {
      MachineClock().SleepUntil(
          begin_ns_ +
          static_cast<std::int64_t>(1e6 * static_cast<double>(number + 1) / arguments_.speed));
    }
    return !stop_asked_.load() && !newcomer_;
  }

  double seconds() const { return static_cast<double>(MonotonicNowNs() - begin_ns_) * 1e-9; }
  const ordered_json& golden() const { return golden_; }
  const HeldPoses& poses() const { return poses_; }
  const TouchedBodies& met() const { return met_; }
  /// Returns the active peer whose arrival ended the run; nothing: none did.
  const std::optional<std::string>& newcomer() const { return newcomer_; }

 private:
  const ReplayArguments& arguments_;
  PeerNode& node_;
  const ActivePeerInbox& ears_;
  Transport& transport_;
  Export* exported_;
  const std::atomic<bool>& stop_asked_;
  ordered_json golden_ = ordered_json::array();
  HeldPoses poses_;
  TouchedBodies met_{node_.world().model().bodies.size()};
  std::optional<std::string> newcomer_;
  std::int64_t begin_ns_ = MonotonicNowNs();
};

/// Opens the file that the replay is exported to. Returns the exit code.
int OpenExport(const ReplayArguments& arguments, const RecordingHeader& header,
               const WorldModel& model, std::unique_ptr<Export>& exported) {
  std::error_code not_there;  // set if there is no such file: then it differs
  if (std::filesystem::equivalent(arguments.file, arguments.exported, not_there)) {
    return Fail(kExitUsage,
                arguments.exported + ": is the recording itself: export to another file");
  }
  auto created = ExportInto(arguments.exported, header, model, NamesIn(arguments.file));
  if (!created) return Fail(kExitFile, created.error().what);
  exported = *std::move(created);
  return kExitOk;
}

ordered_json ReplayJson(const ReplayResult& result, const RecordingReader& reader, double wall_s) {
  ordered_json json{{"frames", result.frames},
                    {"identical", !result.first_different},
                    {"first_different", nullptr},
                    {"torn", reader.torn()},
                    {"damaged", reader.damaged()},
                    {"unread_bytes", reader.unread_bytes()},
                    {"wall_s", wall_s}};
  if (result.first_different) json["first_different"] = *result.first_different;
  return json;
}

/// Says whether all frames were as recorded. Returns the exit code.
int TellWhetherSame(const std::string& file, const ReplayResult& result,
                    const RecordingReader& reader, bool stopped) {
  if (reader.damaged()) {
    return Fail(kExitFailed,
                file + ": damaged at frame " + std::to_string(result.frames) + ", " +
                    std::to_string(reader.unread_bytes()) +
                    " bytes were not replayed; the frames before are bit for bit as recorded");
  }
  if (!result.first_different) {
    Say(WithPlural(static_cast<std::uint64_t>(result.frames), "frame") +
        ", bit for bit as recorded" + (stopped ? "; stopped there" : ""));
    return kExitOk;
  }
  return Fail(kExitFailed, "frame " + std::to_string(*result.first_different) +
                               " is the first that differs: recorded " + Hex(result.recorded_hash) +
                               ", replayed " + Hex(result.replayed_hash));
}

int RunReplay(const ReplayArguments& arguments) {
  if (!arguments.network.empty()) {
    return RunAsNetwork(arguments.file, arguments.network, arguments.from, arguments.json);
  }
  Result<RecordingReader> reader = RecordingReader::Open(arguments.file);
  if (!reader) return Fail(kExitFile, reader.error().what);
  const RecordingHeader& header = reader->header();
  const Result<std::shared_ptr<const WorldModel>> model = LoadRecorded(
      header,
      {.recording = arguments.file, .scene = arguments.scene, .adopt_any = arguments.adopt_any});
  if (!model) return Fail(kExitFile, model.error().what);
  std::unique_ptr<WorkerPool> workers;
  if (arguments.threads > 1) {
    workers = std::make_unique<WorkerPool>(WorkerPool::Options{.threads = arguments.threads});
  }
  Result<std::unique_ptr<Replay>> replay = Replay::Create(header, *model, workers.get());
  if (!replay) return Fail(kExitFile, arguments.file + ": " + replay.error().what);
  std::unique_ptr<Export> exported;
  if (!arguments.exported.empty()) {
    if (const int failed = OpenExport(arguments, header, **model, exported); failed != kExitOk) {
      return failed;
    }
  }
  ActivePeerInbox active_peers;
  int exit_code = kExitOk;
  const Result<std::unique_ptr<Transport>> transport =
      JoinForViewers(arguments.session, arguments.connection, active_peers, exit_code);
  if (!transport) return Fail(exit_code, transport.error().what);
  Say(header.name + " as recorded by version " + header.program + ", scene " + header.scene);
  if (header.peer.experiments.contact) TellStart(FindStartGaps(**model));
  const std::atomic<bool>& stop_asked = StopOnSignals();

  kHapticThread.Enter();
  kSenderThread.Enter();
  kControlThread.Enter();
  Player player(arguments, (*replay)->node(), active_peers, **transport, exported.get(),
                stop_asked);
  const ReplayResult result =
      RunAll(*reader, **replay, [&](std::int64_t number, const RecordedFrame& frame) {
        return player.After(number, frame);
      });
  const double wall_s = player.seconds();
  (*transport)->Leave();
  if (exported) {
    const Result<std::string> written = exported->Close();
    if (!written) return Fail(kExitFile, written.error().what);
    Say(arguments.exported + ": " + *written);
  }

  if (player.newcomer())
    return Fail(kExitNetwork, NotBeside(*player.newcomer(), arguments.session));
  if (reader->torn())
    Say("the recording is incomplete: it ends within a frame, and the frames before are replayed");
  const std::vector<BodyVerdict> verdicts =
      Judge(**model, player.poses(), player.met(), FinalPoses((*replay)->node().world()),
            !header.peer.experiments.contact,
            (*replay)->node().peer().telemetry().hand_figures().peak_force);
  for (const BodyVerdict& verdict : verdicts) Say(Describe(verdict));
  if (arguments.json) {
    ordered_json json = ReplayJson(result, *reader, wall_s);
    json["verdicts"] = AsJson(verdicts);
    json["hash_each_second"] = player.golden();
    PrintText(JsonText(json, 2));
  }
  return TellWhetherSame(arguments.file, result, *reader, stop_asked.load());
}

}  // namespace

void AddReplayCommand(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<ReplayArguments>();
  CLI::App* command =
      app.add_subcommand("replay", "Repeat a recording of 'tandem peer --record' bit for bit");
  command->add_option("FILE", arguments->file, "recording")->required();
  command->add_option("--scene", arguments->scene,
                      "folder or file of the scene, if it was moved since the recording");
  command
      ->add_option("--speed", arguments->speed,
                   "speed as a multiple of real time; default: as fast as possible")
      ->check(NumberFrom(0, 1000));
  command
      ->add_option("--threads", arguments->threads,
                   "number of threads that share a large frame's work")
      ->check(WholeNumberFrom(1, WorkerPool::kMostThreads));
  AddSessionOption(
      *command, arguments->session,
      "name of a session in which viewers can watch the replay, for example with --speed 1");
  command
      ->add_option("--export", arguments->exported,
                   "export file: FILE.csv gets the poses of all moving bodies every 10 ms, as "
                   "'tandem proximity --poses' and 'tandem contact --poses' read them; FILE.mcap "
                   "gets poses, twists and forces")
      ->check(FileEndingIn({".csv", ".mcap"}));
  CLI::Option* const network =
      command
          ->add_option("--as-network", arguments->network,
                       "trace file (CSV): write how the network delivered messages "
                       "(docs/network-plans.md), and replay nothing")
          ->check(FileEndingIn({".csv"}));
  command
      ->add_option("--from", arguments->from,
                   "with --as-network: name of the peer whose messages count")
      ->needs(network);
  command->add_flag("--adopt-any", arguments->adopt_any,
                    "use the recorded voxel size even if it differs from the scene file's by more "
                    "than a factor of 4");
  AddConnectionOptions(*command, arguments->connection);
  command->add_flag("--json", arguments->json, "print the result as JSON on stdout");
  command->callback([arguments, &exit_code] {
    exit_code = RunReplay(*arguments);
  });
}

}  // namespace tandem
