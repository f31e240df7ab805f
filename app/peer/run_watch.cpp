#include "app/peer/run_watch.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <deque>
#include <future>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <stop_token>
#include <utility>

#include <unistd.h>

#include "app/common/console.h"
#include "app/common/exit_codes.h"
#include "app/common/output_file.h"
#include "app/common/scene_files.h"
#include "app/common/stop_signal.h"
#include "app/connection/scene_search.h"
#include "app/peer/peer_options.h"
#include "app/peer/text/notification_limiter.h"
#include "collab/dds/transport/announcements.h"
#include "collab/dds/transport/dds_transport.h"
#include "collab/dds/transport/relay.h"
#include "collab/session/frame_limits.h"
#include "collab/session/scene_agreement.h"
#include "collab/session/viewer.h"
#include "collab/session/viewer_report.h"
#include "engine/realtime/clock.h"

namespace tandem {

namespace {

using Presence = ViewedPeer::Presence;

constexpr std::int64_t kTurnNs = 100'000'000;      // period of looks at what is new
constexpr std::int64_t kBeatNs = 250'000'000;      // period of "I am here"
constexpr std::int64_t kStatusNs = 1'000'000'000;  // period of lines on what is received
constexpr std::size_t kBodiesTold = 12;            // bodies of each peer in a line
constexpr std::size_t kMostScenes = 16;

std::string NameOf(const ViewedPeer& peer) {
  return peer.info.name.empty() ? "peer " + std::to_string(peer.info.peer) : peer.info.name;
}

/// The scene that was given with --scene.
struct OwnScene {
  Scene scene;
  SceneHash hash;
};

/// Looks for one scene after the other on this machine. A thread of its own does it, because it
/// takes as long as the disk does.
class SceneSearches {
 public:
  /// `keys`: folder of the session's keys; empty: a plain session.
  explicit SceneSearches(std::filesystem::path keys) : keys_(std::move(keys)) {}
  ~SceneSearches() { stop_.request_stop(); }

  void Add(const SceneManifest& scene) { waiting_.push_back(scene); }

  /// Returns the result of a search that has ended, and begins the next.
  std::optional<std::string> TakeNotifications() {
    std::optional<std::string> news;
    if (answer_.valid() && answer_.wait_for(std::chrono::seconds(0)) == std::future_status::ready) {
      news = answer_.get();
    }
    if (!answer_.valid() && !waiting_.empty()) {
      answer_ = std::async(std::launch::async, [wanted = WantedFrom(waiting_.front(), keys_),
                                                stop = stop_.get_token()] {
        return WhereItIs(wanted, stop);
      });
      waiting_.pop_front();
    }
    return news;
  }

 private:
  static std::string WhereItIs(const WantedScene& wanted, const std::stop_token& stop) {
    const std::vector<std::filesystem::path> folders = FoldersWithScenes();
    if (const auto file = FindScene(wanted, folders, stop)) {
      return "this machine has it: " + file->string();
    }
    std::string searched;
    for (const std::filesystem::path& folder : folders) searched += ", " + folder.string();
    return "this machine does not have it (looked for " + wanted.file.string() + searched +
           "): get it, and name it with --scene";
  }

  std::filesystem::path keys_;
  std::deque<SceneManifest> waiting_;
  std::stop_source stop_;
  std::future<std::string> answer_;  // the destructor waits for it
};

/// Tells the news of a session, line by line.
class Reporter {
 public:
  /// `security`: who can listen, which is said once a peer is heard. `as_part`: other peers are
  /// known to come. `keys`: folder of the session's keys; empty: a plain session.
  Reporter(std::optional<OwnScene> own, AnnouncedSession session, std::string security,
           bool as_part, std::filesystem::path keys)
      : own_(std::move(own)),
        searches_(std::move(keys)),
        session_(std::move(session)),
        security_(as_part ? std::string() : std::move(security)),
        as_part_(as_part) {}

  void PrintNotifications(const ViewerPicture& picture, std::int64_t now_ns) {
    CollectNews(picture);
    for (const std::string& line : notifications_.Due(now_ns)) Say(line);
  }
  void TellRest() {
    for (const std::string& line : notifications_.Rest()) Say(line);
  }

  void CollectNews(const ViewerPicture& picture) {
    if (!picture.peers.empty() && !security_.empty()) Say(std::exchange(security_, {}));
    // a session goes by one scene; only the first kMostScenes of a peer that invents more are told
    if (picture.scene && told_scene_.size() < kMostScenes &&
        told_scene_.insert(picture.scene->content_digest).second) {
      TellScene(*picture.scene);
    }
    if (const auto found = searches_.TakeNotifications()) Note(*found);
    ForgetGone(picture);
    for (const ViewedPeer& peer : picture.peers) {
      if (peer.info.name.empty() && peer.presence == Presence::kHere) continue;  // its name follows
      TellStop(peer);
      const auto [known, is_new] = reported_.try_emplace(peer.info.peer, peer.presence);
      if (!is_new && known->second == peer.presence) continue;
      known->second = peer.presence;
      const char* what = peer.presence == Presence::kHere ? peer.came_back ? " is back" : " joined"
                         : peer.presence == Presence::kLost ? " is lost"
                                                            : " left";
      const std::string name = NameOf(peer);
      notifications_.Add(name, name + what + (peer.info.role == Role::kViewer ? " (viewer)" : ""));
      const std::string other = OtherProtocol(peer.info);
      if (!other.empty() && peer.presence == Presence::kHere) {
        notifications_.Add("", name + " " + other + "; what this program shows of it may be wrong");
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
      line += "; " + NameOf(peer) + " (" + NameOfColour(ColourOf(peer.info)) +
              (peer.info.stopped ? ", stopped) " : ") ") +
              std::to_string(std::lround(peer.delay_ms)) + " ms";
      ++active;
      for (std::size_t i = 0; i < std::min(peer.bodies.size(), kBodiesTold); ++i) {
        const ViewBody& body = peer.bodies[i];
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
      if (peer.bodies.size() > kBodiesTold) {
        line += ", and " + std::to_string(peer.bodies.size() - kBodiesTold) + " more";
      }
    }
    Say(active > 0 ? line : "no active peer is here");
  }

 private:
  /// Forgets peers that the picture no longer has, so that both stay limited.
  void ForgetGone(const ViewerPicture& picture) {
    if (reported_.size() <= 2 * Viewer::kMost) return;
    std::erase_if(reported_, [&picture](const auto& one) {
      return std::ranges::none_of(picture.peers, [&one](const ViewedPeer& peer) {
        return peer.info.peer == one.first;
      });
    });
  }

  void TellStop(const ViewedPeer& peer) {
    const bool stopped = peer.presence == Presence::kHere && peer.info.stopped;
    if (stopped == stopped_.contains(peer.info.peer) || peer.presence != Presence::kHere) return;
    if (stopped && stopped_.size() < Viewer::kMost) stopped_.insert(peer.info.peer);
    if (!stopped) stopped_.erase(peer.info.peer);
    notifications_.Add(NameOf(peer),
                       NameOf(peer) + (stopped ? " stopped its hand" : " goes on after a stop"));
  }

  void Note(const std::string& line) { notifications_.Add("", line); }

  void TellScene(const SceneManifest& scene) {
    Note("scene " + scene.name + ", " + std::to_string(scene.bodies.size()) + " bodies, from " +
         scene.file);
    Note("the session's force parameters: " + Describe(ParametersOf(scene)));
    if (!own_) return searches_.Add(scene);
    const std::string difference = ContentDifference(own_->scene, own_->hash, scene);
    Note(difference.empty() ? "it is the scene given with --scene"
                            : "it is NOT the scene given with --scene: " + difference);
  }

  std::optional<OwnScene> own_;
  SceneSearches searches_;
  NotificationLimiter notifications_;
  AnnouncedSession session_;
  std::string security_;
  bool as_part_;
  std::map<PeerId, Presence> reported_;
  std::set<PeerId> stopped_;
  std::set<Sha256> told_scene_;
  std::uint64_t samples_told_ = 0;
};

/// Reads the scene that was given with --scene, if one was. Error: it cannot be read.
Result<std::optional<OwnScene>> ReadOwnScene(const std::string& file) {
  std::optional<OwnScene> own;
  if (file.empty()) return own;
  Result<Scene> scene = LoadNamedScene(file);
  if (!scene) return scene.error();
  Result<SceneHash> hash = HashScene(*scene);
  if (!hash) return hash.error();
  own.emplace(OwnScene{*std::move(scene), *std::move(hash)});
  RememberSceneFolder(own->scene.file);
  return own;
}

/// Looks for the session's scene and puts its file into the options. Returns the exit code.
int TakeSceneOfSession(WatchOptions& options, PeerId id) {
  SessionSceneOptions sought =
      SceneSearchOptions(options.session, id, Role::kViewer, options.connection, options.fetch);
  sought.from_relay = options.from_relay;
  const SessionScene found = FindSessionScene(sought);
  if (!found.fault.empty()) return Fail(found.exit_code, found.fault);
  options.scene = found.file.string();
  return kExitOk;
}

/// Looks on at a session until a signal, the end of the keys or of the time.
class Watching {
 public:
  Watching(const WatchOptions& options, const DdsOptions& dds, const Viewer& viewer,
           Transport& transport, std::optional<OwnScene> own)
      : options_(options),
        dds_(dds),
        viewer_(viewer),
        transport_(transport),
        reporter_(std::move(own), {dds.session, !dds.secure.empty()},
                  SecurityOf(options.connection, options.session), options.as_part,
                  options.connection.secure) {
    info_.peer = dds.peer;
    info_.role = Role::kViewer;
    info_.name = options.name;
    joined_ns_ = MonotonicNowNs();
    beat_ns_ = joined_ns_ - kBeatNs;
    status_ns_ = joined_ns_;
  }

  /// Returns the exit code.
  int LookOn() {
    int exit_code = kExitOk;
    std::int64_t now_ns = joined_ns_;
    do {
      const ViewerPicture picture = viewer_.Picture();
      reporter_.PrintNotifications(picture, now_ns);
      if (now_ns - beat_ns_ >= kBeatNs) Beat(picture, now_ns);
      if (now_ns - status_ns_ >= kStatusNs) TellStatus(picture, now_ns);
      if (const std::string ended = transport_.KeysEnd(); !ended.empty()) {
        exit_code = Fail(kExitSecurity, ended);
        break;
      }
      if (StopRequestedWithin(std::chrono::nanoseconds(kTurnNs))) break;
      now_ns = MonotonicNowNs();
    } while (options_.seconds <= 0 ||
             static_cast<double>(now_ns - joined_ns_) < 1e9 * options_.seconds);
    reporter_.TellRest();
    return exit_code;
  }

  std::int64_t joined_ns() const noexcept { return joined_ns_; }

 private:
  void Beat(const ViewerPicture& picture, std::int64_t now_ns) {
    if (picture.scene) info_.scene_hash = picture.scene->content_hash;
    info_.colour = viewer_.ColourFor(info_, info_.colour);
    transport_.Publish(info_);
    ++info_.beat;
    beat_ns_ = now_ns;
  }

  void TellStatus(const ViewerPicture& picture, std::int64_t now_ns) {
    if (!picture.peers.empty()) {
      nearby_.reset();
    } else if (!nearby_) {
      nearby_ = ListenForSessions(dds_);
    }
    reporter_.TellStatus(picture, static_cast<double>(now_ns - status_ns_) * 1e-9,
                         nearby_ ? nearby_->Heard() : std::vector<AnnouncedSession>{});
    status_ns_ = now_ns;
  }

  const WatchOptions& options_;
  const DdsOptions& dds_;
  const Viewer& viewer_;
  Transport& transport_;
  std::unique_ptr<SessionsNearby> nearby_;  // only while nobody is heard: it takes a DDS port
  PeerInfo info_;
  Reporter reporter_;
  std::int64_t joined_ns_ = 0;
  std::int64_t beat_ns_ = 0;
  std::int64_t status_ns_ = 0;
};

}  // namespace

int WatchCommand(const WatchOptions& requested) {
  WatchOptions options = requested;
  if (!options.report.empty()) {
    const std::string fault = WhyNotWritable(options.report);
    if (!fault.empty()) return Fail(kExitFile, fault);
  }
  const Result<PeerId> id = Identify(options.connection, Role::kViewer, options.name);
  if (!id) return Fail(kExitSecurity, id.error().what);
  if (options.scene_from_session) {
    if (const int failed = TakeSceneOfSession(options, *id); failed != kExitOk) return failed;
  }
  Result<std::optional<OwnScene>> own = ReadOwnScene(options.scene);
  if (!own) return Fail(kExitFile, own.error().what);
  StopOnSignals();

  Viewer viewer;
  DdsOptions dds;
  dds.session = options.session;
  dds.peer = *id;
  dds.role = Role::kViewer;
  ApplyConnection(options.connection, dds);
  if (options.from_relay) GoToRelay(dds);
  Result<std::unique_ptr<Transport>> joined = JoinOverDds(dds, viewer);
  if (!joined) {
    return Fail(options.connection.secure.empty() ? kExitNetwork : kExitSecurity,
                joined.error().what);
  }
  Transport& transport = **joined;
  const AtForcedEnd goodbye([&transport] {
    transport.SayGoodbye();
  });
  Say("watching session " + options.session);
  if (options.on_entered) options.on_entered({.peer = *id, .name = options.name, .holding = {}});
  Watching watching(options, dds, viewer, transport, *std::move(own));
  const int exit_code = watching.LookOn();
  transport.Leave();
  SayStillEnding();

  const ViewerReport report = ReportOf(
      &viewer, getpid(), static_cast<double>(MonotonicNowNs() - watching.joined_ns()) * 1e-9);
  if (options.json) PrintText(AsJson(report));
  if (options.report.empty()) return exit_code;
  const Result<bool> written = WriteReport(report, options.report);
  return written ? exit_code : Fail(kExitFile, written.error().what);
}

}  // namespace tandem
