#include <chrono>
#include <cinttypes>
#include <cstdio>
#include <memory>

#include <nlohmann/json.hpp>

#include "app/cli/commands.h"
#include "app/cli/talk.h"
#include "app/exit_codes.h"
#include "app/reach/reach_options.h"
#include "collab/recording/replay.h"
#include "engine/realtime/clock.h"
#include "engine/world/scene.h"

namespace tandem {
namespace {

using nlohmann::ordered_json;

constexpr std::int64_t kFramesPerSecond = 1000;
constexpr std::int64_t kControlFrames = 20;  // from one ControlFrame to the next

struct ReplayArguments {
  std::string file;
  std::string scene;    // empty: the recorded file
  std::string session;  // empty: nobody looks on
  ReachOptions reach;
  double speed = 0;  // times real time; 0: as fast as it goes
  int threads = 1;
  bool json = false;
};

/// For a replay that nobody looks on at.
class Nowhere final : public Transport {
 public:
  void Publish(const ObjectState&) override {}
  void Publish(const CouplingLinks&) override {}
  void Publish(const ViewFrame&) override {}
  void Publish(const PeerInfo&) override {}
  void Publish(const Event&) override {}
  void Publish(const SceneManifest&) override {}
  void Leave() override {}
};

/// Replays are seen, not met: of what a peer says only what viewers need goes out.
class ViewersOnly final : public Transport {
 public:
  explicit ViewersOnly(std::unique_ptr<Transport> to) : to_(std::move(to)) {}
  void Publish(const ObjectState&) override {}
  void Publish(const CouplingLinks&) override {}
  void Publish(const ViewFrame& frame) override { to_->Publish(frame); }
  void Publish(const PeerInfo& info) override { to_->Publish(info); }
  void Publish(const Event&) override {}
  void Publish(const SceneManifest& manifest) override { to_->Publish(manifest); }
  void Leave() override { to_->Leave(); }

 private:
  std::unique_ptr<Transport> to_;
};

std::string Hex(std::uint64_t hash) {
  std::array<char, 17> digits{};
  std::snprintf(digits.data(), digits.size(), "%016" PRIx64, hash);
  return digits.data();
}

/// The recorded scene as it was, or why it is not to be had.
Result<std::shared_ptr<const WorldModel>> LoadRecorded(const ReplayArguments& arguments,
                                                       const RecordingHeader& header) {
  const std::string file = arguments.scene.empty() ? header.scene : arguments.scene;
  Result<Scene> scene = LoadScene(file);
  if (!scene) return Error{scene.error().what + " (--scene says where it is now)"};
  scene->voxel_size = header.voxel_size;
  const Result<std::uint64_t> hash = HashScene(*scene);
  if (!hash) return hash.error();
  if (*hash != header.scene_hash) {
    return Error{file + ": is not the scene that was recorded; it has changed since"};
  }
  return LoadWorld(*scene);
}

Result<std::unique_ptr<Transport>> JoinForViewers(const ReplayArguments& arguments,
                                                  const RecordingHeader& header, PeerNode& node) {
  if (arguments.session.empty()) return std::unique_ptr<Transport>(std::make_unique<Nowhere>());
  DdsOptions dds;
  dds.session = arguments.session;
  dds.peer = header.peer.id;
  ApplyReach(arguments.reach, dds);
  Result<std::unique_ptr<Transport>> joined = JoinOverDds(dds, node.inbox());
  if (!joined) return joined.error();
  Say(SecurityOf(arguments.reach, arguments.session));
  return std::unique_ptr<Transport>(std::make_unique<ViewersOnly>(*std::move(joined)));
}

int RunReplay(const ReplayArguments& arguments) {
  Result<RecordingReader> reader = RecordingReader::Open(arguments.file);
  if (!reader) return Fail(kExitFile, reader.error().what);
  const RecordingHeader& header = reader->header();
  const Result<std::shared_ptr<const WorldModel>> model = LoadRecorded(arguments, header);
  if (!model) return Fail(kExitFile, model.error().what);
  std::unique_ptr<FrameHelpers> helpers;
  if (arguments.threads > 1) {
    helpers = std::make_unique<FrameHelpers>(FrameHelpers::Options{.threads = arguments.threads});
  }
  Result<std::unique_ptr<Replay>> replay = Replay::Create(header, *model, helpers.get());
  if (!replay) return Fail(kExitFile, arguments.file + ": " + replay.error().what);
  PeerNode& node = (*replay)->node();
  Result<std::unique_ptr<Transport>> transport = JoinForViewers(arguments, header, node);
  if (!transport) return Fail(kExitNetwork, transport.error().what);
  Say(header.name + " as recorded by version " + header.program + ", scene " + header.scene);

  kHapticThread.Enter();
  kSenderThread.Enter();
  kControlThread.Enter();
  ordered_json golden = ordered_json::array();
  const std::int64_t begin_ns = MonotonicNowNs();
  const ReplayResult result =
      RunAll(*reader, **replay, [&](std::int64_t number, const RecordedFrame& frame) {
        node.SendFrame(frame.now_ns, **transport);
        if (number % kControlFrames == 0) node.ControlFrame(frame.now_ns, **transport);
        if ((number + 1) % kFramesPerSecond == 0) {
          golden.push_back(Hex(frame.state_hash));
          if (!arguments.json) {
            std::printf("%" PRId64 " s %s\n", (number + 1) / kFramesPerSecond,
                        Hex(frame.state_hash).c_str());
          }
        }
        if (arguments.speed > 0) {
          MachineClock().SleepUntil(
              begin_ns +
              static_cast<std::int64_t>(1e6 * static_cast<double>(number + 1) / arguments.speed));
        }
        return true;
      });
  const double wall_s = static_cast<double>(MonotonicNowNs() - begin_ns) * 1e-9;
  (*transport)->Leave();

  const bool identical = !result.first_different;
  if (reader->torn()) Say("the recording is torn off after its last whole frame");
  if (arguments.json) {
    ordered_json json{{"frames", result.frames},    {"identical", identical},
                      {"first_different", nullptr}, {"torn", reader->torn()},
                      {"wall_s", wall_s},           {"hash_each_second", golden}};
    if (!identical) json["first_different"] = *result.first_different;
    std::printf("%s\n", json.dump(2).c_str());
  }
  if (identical) {
    Say(std::to_string(result.frames) + " frames, bit for bit as recorded");
    return kExitOk;
  }
  return Fail(kExitFailed, "frame " + std::to_string(*result.first_different) +
                               " is the first that differs: recorded " + Hex(result.recorded_hash) +
                               ", replayed " + Hex(result.replayed_hash));
}

}  // namespace

void AddReplayCommand(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<ReplayArguments>();
  CLI::App* command =
      app.add_subcommand("replay", "Repeat what 'tandem peer --record' kept, bit for bit");
  command->add_option("FILE", arguments->file, "recording")->required();
  command->add_option("--scene", arguments->scene, "where the scene is now, if it was moved");
  command->add_option("--speed", arguments->speed, "times real time; default: as fast as it goes")
      ->check(CLI::NonNegativeNumber);
  command->add_option("--threads", arguments->threads, "threads that share a large frame's work")
      ->check(CLI::Range(1, FrameHelpers::kMostThreads));
  command->add_option("--session", arguments->session,
                      "show it to the viewers of this session; with --speed 1, say");
  AddReachOptions(*command, arguments->reach);
  command->add_flag("--json", arguments->json, "print the result on stdout");
  command->callback([arguments, &exit_code] {
    exit_code = RunReplay(*arguments);
  });
}

}  // namespace tandem
