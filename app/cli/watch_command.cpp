#include "app/cli/watch_command.h"

#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <ctime>
#include <deque>
#include <future>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <stop_token>
#include <utility>

#include <unistd.h>

#include "app/cli/scene_files.h"
#include "app/cli/talk.h"
#include "app/exit_codes.h"
#include "app/option_checks.h"
#include "app/output_file.h"
#include "app/reach/scene_search.h"
#include "collab/dds/announcements.h"
#include "collab/dds/dds_transport.h"
#include "collab/dds/relay.h"
#include "collab/frame_limits.h"
#include "collab/scene_agreement.h"
#include "collab/viewer.h"
#include "collab/viewer_report.h"
#include "engine/realtime/clock.h"

namespace tandem {

namespace {

using Presence = ViewedPeer::Presence;

constexpr std::int64_t kTurnNs = 100'000'000;      // looks at what is new
constexpr std::int64_t kBeatNs = 250'000'000;      // says that it is here
constexpr std::int64_t kStatusNs = 1'000'000'000;  // says what it receives

std::string NameOf(const ViewedPeer& peer) {
  return peer.info.name.empty() ? "peer " + std::to_string(peer.info.peer) : peer.info.name;
}

/// What was given with --scene.
struct OwnScene {
  Scene scene;
  SceneHash hash;
};

/// Looks for one scene after the other on this machine, on a thread of its own, which takes as long
/// as the disk does.
class SceneSearches {
 public:
  ~SceneSearches() { stop_.request_stop(); }

  void Add(const SceneManifest& scene) { waiting_.push_back(scene); }

  /// What to say of a search that has come to its end; begins the next.
  std::optional<std::string> TakeNews() {
    std::optional<std::string> news;
    if (answer_.valid() && answer_.wait_for(std::chrono::seconds(0)) == std::future_status::ready) {
      news = answer_.get();
    }
    if (!answer_.valid() && !waiting_.empty()) {
      answer_ =
          std::async(std::launch::async, [scene = waiting_.front(), stop = stop_.get_token()] {
            return WhereItIs(scene, stop);
          });
      waiting_.pop_front();
    }
    return news;
  }

 private:
  static std::string WhereItIs(const SceneManifest& scene, const std::stop_token& stop) {
    const std::vector<std::filesystem::path> folders = FoldersWithScenes();
    if (const auto file = FindScene(WantedFrom(scene), folders, stop)) {
      return "this machine has it: " + file->string();
    }
    std::string searched;
    for (const std::filesystem::path& folder : folders) searched += ", " + folder.string();
    return "this machine does not have it (looked for " + scene.file + searched +
           "): get it, and name it with --scene";
  }

  std::deque<SceneManifest> waiting_;
  std::stop_source stop_;
  std::future<std::string> answer_;  // is waited for at the end
};

/// Tells the news of a session, line by line.
class Reporter {
 public:
  /// `security`: who can listen, to be said once somebody is heard. `as_part`: others are known to
  /// come.
  Reporter(std::optional<OwnScene> own, AnnouncedSession session, std::string security,
           bool as_part)
      : own_(std::move(own)),
        session_(std::move(session)),
        security_(as_part ? std::string() : std::move(security)),
        as_part_(as_part) {}

  void TellNews(const ViewerPicture& picture) {
    if (!picture.peers.empty() && !security_.empty()) Say(std::exchange(security_, {}));
    if (picture.scene && told_scene_.insert(picture.scene->content_hash).second) {
      TellScene(*picture.scene);
    }
    if (const auto news = searches_.TakeNews()) Say(*news);
    for (const ViewedPeer& peer : picture.peers) {
      if (peer.info.name.empty() && peer.presence == Presence::kHere) continue;  // about to be told
      const auto [known, is_new] = told_.try_emplace(peer.info.peer, peer.presence);
      if (!is_new && known->second == peer.presence) continue;
      known->second = peer.presence;
      const char* news = peer.presence == Presence::kHere ? peer.came_back ? " is back" : " joined"
                         : peer.presence == Presence::kLost ? " is lost"
                                                            : " left";
      Say(NameOf(peer) + news + (peer.info.role == Role::kViewer ? " (viewer)" : ""));
      const std::string other = OtherProtocol(peer.info);
      if (!other.empty() && peer.presence == Presence::kHere) {
        Say(NameOf(peer) + " " + other + "; what is told here may be wrong");
      }
    }
  }

  void TellStatus(const ViewerPicture& picture, double seconds,
                  const std::vector<AnnouncedSession>& nearby) {
    if (picture.peers.empty()) {
      if (!as_part_) Say(NobodyHeard(session_, nearby));
      return;
    }
    std::string line = std::to_string(std::lround(
                           static_cast<double>(picture.samples - samples_told_) / seconds)) +
                       " samples/s";
    samples_told_ = picture.samples;
    int active = 0;
    for (const ViewedPeer& peer : picture.peers) {
      if (peer.presence != Presence::kHere || peer.info.role != Role::kActive) continue;
      line += "; " + NameOf(peer) + " " + std::to_string(std::lround(peer.delay_ms)) + " ms";
      ++active;
      for (const ViewBody& body : peer.bodies) {
        const bool named = picture.scene && body.object < picture.scene->bodies.size();
        line += ", " +
                (named ? picture.scene->bodies[body.object].name
                       : "body " + std::to_string(body.object)) +
                " moved " + std::to_string(std::lround(1000 * body.X_W.p.norm())) + " mm";
        if ((body.flags & ViewBody::kInContact) != 0) line += " (contact)";
        if ((body.flags & ViewBody::kTrapped) != 0) line += " (trapped)";
        if ((body.flags & ViewBody::kHeld) == 0) continue;
        const std::string limits = AsText(LimitsIn(body.flags));
        if (!limits.empty()) line += " (" + limits + " of its frames)";
      }
    }
    Say(active > 0 ? line : "nobody who takes part is here");
  }

 private:
  void TellScene(const SceneManifest& scene) {
    Say("scene " + scene.name + ", " + std::to_string(scene.bodies.size()) + " bodies, from " +
        scene.file);
    Say("its force parameters: " + Describe(ParametersOf(scene)));
    if (!own_) return searches_.Add(scene);
    const std::string difference = ContentDifference(own_->scene, own_->hash, scene);
    Say(difference.empty() ? "it is the scene given with --scene"
                           : "it is NOT the scene given with --scene: " + difference);
  }

  std::optional<OwnScene> own_;
  SceneSearches searches_;
  AnnouncedSession session_;
  std::string security_;
  bool as_part_;
  std::map<PeerId, Presence> told_;
  std::set<std::uint64_t> told_scene_;
  std::uint64_t samples_told_ = 0;
};

/// Waits for SIGINT or SIGTERM, for one turn at most.
bool SignalCame(const sigset_t& signals) {
  const timespec turn{0, kTurnNs};
  return sigtimedwait(&signals, nullptr, &turn) > 0;
}

}  // namespace

int WatchCommand(const WatchOptions& asked) {
  WatchOptions options = asked;
  if (!options.report.empty()) {
    const std::string fault = WhyNotWritable(options.report);
    if (!fault.empty()) return Fail(kExitFile, fault);
  }
  const Result<PeerId> id = Identify(options.reach, Role::kViewer, options.name);
  if (!id) return Fail(kExitSecurity, id.error().what);
  std::optional<OwnScene> own;
  if (!options.scene.empty()) {
    Result<Scene> scene = LoadNamedScene(options.scene);
    if (!scene) return Fail(kExitFile, scene.error().what);
    Result<SceneHash> hash = HashScene(*scene);
    if (!hash) return Fail(kExitFile, hash.error().what);
    own.emplace(OwnScene{*std::move(scene), *std::move(hash)});
    RememberSceneFolder(own->scene.file);
  }
  // before the transport's threads start, so that none of them takes the signals
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);

  Viewer viewer;
  DdsOptions dds;
  dds.session = options.session;
  dds.peer = *id;
  dds.role = Role::kViewer;
  ApplyReach(options.reach, dds);
  if (options.from_relay) GoToRelay(dds);
  Result<std::unique_ptr<Transport>> joined = JoinOverDds(dds, viewer);
  if (!joined) {
    return Fail(options.reach.secure.empty() ? kExitNetwork : kExitSecurity, joined.error().what);
  }
  Transport& transport = **joined;
  Say("watching session " + options.session);
  std::unique_ptr<SessionsNearby> nearby;  // while nobody is heard: it takes a port of DDS

  PeerInfo info;
  info.peer = dds.peer;
  info.role = Role::kViewer;
  info.name = options.name;
  Reporter reporter(std::move(own), {dds.session, !dds.secure.empty()},
                    SecurityOf(options.reach, options.session), options.as_part);
  const std::int64_t joined_ns = MonotonicNowNs();
  std::int64_t beat_ns = joined_ns - kBeatNs;
  std::int64_t status_ns = joined_ns;
  std::int64_t now_ns = joined_ns;
  do {
    const ViewerPicture picture = viewer.Picture();
    reporter.TellNews(picture);
    if (now_ns - beat_ns >= kBeatNs) {
      if (picture.scene) info.scene_hash = picture.scene->content_hash;
      transport.Publish(info);
      ++info.beat;
      beat_ns = now_ns;
    }
    if (now_ns - status_ns >= kStatusNs) {
      if (!picture.peers.empty()) {
        nearby.reset();
      } else if (!nearby) {
        nearby = ListenForSessions(dds);
      }
      reporter.TellStatus(picture, static_cast<double>(now_ns - status_ns) * 1e-9,
                          nearby ? nearby->Heard() : std::vector<AnnouncedSession>{});
      status_ns = now_ns;
    }
    if (SignalCame(signals)) break;
    now_ns = MonotonicNowNs();
  } while (options.seconds <= 0 || static_cast<double>(now_ns - joined_ns) < 1e9 * options.seconds);
  transport.Leave();

  const ViewerReport report =
      ReportOf(&viewer, getpid(), static_cast<double>(MonotonicNowNs() - joined_ns) * 1e-9);
  if (options.json) std::printf("%s\n", AsJson(report).c_str());
  if (options.report.empty()) return kExitOk;
  const Result<bool> written = WriteReport(report, options.report);
  return written ? kExitOk : Fail(kExitFile, written.error().what);
}

void AddWatchCommand(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<WatchOptions>();
  options->name = "watch-" + std::to_string(getpid());
  CLI::App* command = app.add_subcommand("watch", "Look on at a session without a window");
  AddSessionOption(*command, options->session, "name of the session")->required();
  command->add_option("--scene", options->scene,
                      "compare this scene with the session's: its name or file");
  command->add_option("--name", options->name, "how others see you");
  AddReachOptions(*command, options->reach);
  command->add_option("--seconds", options->seconds, "leave after this; 0: on a signal")
      ->check(NumberFrom(0, kLongestRun));
  command->add_option("--report", options->report, "write what was received (JSON) there");
  command->add_flag("--as-part", options->as_part)->group("");
  command->add_flag("--from-relay", options->from_relay, "look through a relay (tandem relay)");
  command->add_flag("--json", options->json, "print the report on stdout");
  command->callback([options, &exit_code] {
    exit_code = WatchCommand(*options);
  });
}

}  // namespace tandem
