#include "app/connection/session_scene.h"

#include <cstdio>
#include <memory>
#include <mutex>
#include <optional>
#include <tuple>
#include <utility>
#include <vector>

#include "app/common/exit_codes.h"
#include "app/common/program_folders.h"
#include "app/connection/scene_search.h"
#include "collab/dds/transport/relay.h"
#include "collab/session/early_inbox.h"
#include "collab/session/scene_agreement.h"
#include "collab/transfer/scene_fetch.h"
#include "collab/transfer/scene_store.h"
#include "engine/base/files/regular_file.h"
#include "engine/base/units.h"
#include "engine/realtime/clock.h"

namespace tandem {

namespace {

namespace fs = std::filesystem;

// wait after the first manifest, for those of other peers
constexpr std::int64_t kSettleNs = 400 * kMs;
// wait for the first manifest: on another network the discovery of peers takes a second or two, for
// members of a secured session on a busy machine longer
constexpr std::int64_t kListenNs = 15'000 * kMs;
constexpr std::int64_t kSayQuietNs = 4000 * kMs;
constexpr std::int64_t kLookNs = 50 * kMs;
constexpr std::int64_t kIdleNs = 200 * kMs;
constexpr std::uint64_t kMostFetchedBytes = std::uint64_t{10} << 30U;  // total over all scenes

/// Returns the scene that most peers use; nothing: no peer has announced one.
std::optional<SceneManifest> HearScene(const EarlyInbox& inbox,
                                       const SessionSceneOptions& options) {
  const std::int64_t joined_ns = MonotonicNowNs();
  bool said_quiet = false;
  std::optional<std::int64_t> first_ns;
  for (;;) {
    const std::int64_t now_ns = MonotonicNowNs();
    const std::optional<SceneManifest> scene = inbox.SessionScene();
    if (scene && !first_ns) first_ns = now_ns;
    const bool over = first_ns ? now_ns - *first_ns >= kSettleNs : now_ns - joined_ns >= kListenNs;
    if (over || options.stop.stop_requested()) return scene;
    if (!first_ns && now_ns - joined_ns >= kSayQuietNs && !std::exchange(said_quiet, true)) {
      options.say("no peer of session " + options.session +
                  " answered yet: listening for another " +
                  std::to_string((kListenNs - kSayQuietNs) / (1000 * kMs)) + " s");
    }
    MachineClock().SleepUntil(now_ns + 10 * kMs);
  }
}

SessionScene Found(const fs::path& file) {
  return {.file = file, .exit_code = kExitOk, .fault = {}};
}

SessionScene Fault(const SceneManifest& scene, const std::string& why) {
  return {.file = {},
          .exit_code = kExitFile,
          .fault = "this machine does not have the session's scene " + PlainLine(scene.name) +
                   ": " + why};
}

std::optional<fs::path> Find(const SceneManifest& scene, const SessionSceneOptions& options) {
  const auto found =
      FindScene(WantedFrom(scene, options.connection.secure), FoldersWithScenes(), options.stop);
  if (found) {
    options.say("the session's scene " + PlainLine(scene.name) +
                " is on this machine: " + found->string());
  }
  return found;
}

}  // namespace

/// The receiving side, which begins when the scene to fetch is known. Used by the transport's
/// thread and by the thread that calls Fetch().
class SceneFetcher::Party final : public TransferEndpoint {
 public:
  bool serves() const override { return false; }
  bool wants() override {
    const std::scoped_lock lock(mutex_);
    return fetch_.has_value();
  }
  void OnPiece(const FilePiece& piece, std::int64_t now_ns) override {
    const std::scoped_lock lock(mutex_);
    if (fetch_) fetch_->OnPiece(piece, now_ns);
  }
  std::int64_t Tick(std::int64_t now_ns, const Out& out) override {
    const std::scoped_lock lock(mutex_);
    return fetch_ ? fetch_->Tick(now_ns, out) : now_ns + kIdleNs;
  }

  void SetSelf(PeerId self) {
    const std::scoped_lock lock(mutex_);
    self_ = self;
  }
  void Start(std::uint64_t content_hash, std::uint64_t most_bytes) {
    const std::scoped_lock lock(mutex_);
    fetch_.emplace(self_, content_hash, most_bytes);
  }
  void End() {
    const std::scoped_lock lock(mutex_);
    fetch_.reset();
  }
  template <typename Use>
  auto With(const Use& use) {
    const std::scoped_lock lock(mutex_);
    return use(*fetch_);
  }

 private:
  std::mutex mutex_;
  PeerId self_ = 0;
  std::optional<SceneFetch> fetch_;
};

namespace {

/// Brings one scene from the peers' offers to its place in the store.
template <typename Party>
class Arrival {
 public:
  Arrival(Party& party, const SceneManifest& scene, const SessionSceneOptions& options,
          const SceneStore& store)
      : party_(party), scene_(scene), options_(options), store_(store) {
    party_.Start(scene.content_hash, options.most_bytes);
  }
  // no piece arrives after this, before the files are closed
  ~Arrival() { party_.End(); }
  Arrival(const Arrival&) = delete;
  Arrival& operator=(const Arrival&) = delete;

  SessionScene Run() {
    for (;;) {
      if (Stopped()) return {};
      const auto state = party_.With([](SceneFetch& fetch) {
        return fetch.state();
      });
      for (const std::string& line : party_.With([](SceneFetch& fetch) {
             return fetch.TakeNotifications();
           })) {
        options_.say(line);
      }
      std::optional<SessionScene> end;
      if (state == SceneFetch::State::kFailed) {
        // the files of liars are of no use to the next run
        const bool lies = party_.With([](SceneFetch& fetch) {
          return !fetch.liars().empty();
        });
        if (lies && files_) files_->Remove();
        return Fault(scene_, party_.With([](SceneFetch& fetch) {
          return fetch.fault();
        }));
      }
      if (state == SceneFetch::State::kListed) end = Begin();
      if (state == SceneFetch::State::kFetched) end = Finish();
      if (end) return *std::move(end);
      ShowProgress();
      MachineClock().SleepUntil(MonotonicNowNs() + kLookNs);
    }
  }

 private:
  bool Stopped() const { return options_.stop.stop_requested(); }

  void ShowProgress() {
    if (!options_.progress) return;
    const auto [held, of] = party_.With([](SceneFetch& fetch) {
      const bool fetches = fetch.state() == SceneFetch::State::kFetching;
      return std::pair(fetch.bytes_held(), fetches ? fetch.list().total_bytes() : 0);
    });
    options_.progress(held, of);
  }

  /// Asks the person, and creates the files. Returns a result if that ended the fetch.
  std::optional<SessionScene> Begin() {
    const auto [list, digest, from] = party_.With([](SceneFetch& fetch) {
      return std::tuple(fetch.list(), fetch.digest(), fetch.source());
    });
    const std::string name = options_.name_of ? options_.name_of(from) : "";
    const OfferedScene offered{PlainLine(scene_.name, 64),
                               name.empty() ? "a peer" : PlainLine(name, 64), list.files.size(),
                               list.total_bytes()};
    if (const std::string why = options_.refuses(offered); !why.empty()) return Fault(scene_, why);
    bool busy = true;
    bool reported = false;
    while (busy) {
      Result<UnfinishedScene> opened = UnfinishedScene::Open(
          store_, list, digest, {.most_bytes = CacheLimit().value_or(kMostFetchedBytes)}, busy);
      if (opened) {
        files_.reset();
        files_.emplace(*std::move(opened));
        break;
      }
      if (!busy) return Fault(scene_, opened.error().what);
      if (!std::exchange(reported, true))
        options_.say(opened.error().what + ": waiting until it is free");
      MachineClock().SleepUntil(MonotonicNowNs() + 4 * kLookNs);
      if (Stopped()) return SessionScene{};
      // another process may have fetched it meanwhile
      const fs::path whole = store_.SceneFileOf(scene_.content_digest);
      std::error_code unknown;
      if (!fs::exists(whole, unknown)) continue;
      if (const auto found = Find(scene_, options_)) return Found(*found);
    }
    const std::uint64_t held = party_.With([&](SceneFetch& fetch) {
      fetch.Begin(*files_, MonotonicNowNs());
      return fetch.bytes_at_start();
    });
    began_ns_ = MonotonicNowNs();
    options_.say(
        "fetching " + offered.Words() +
        (held > 0 ? "; " + std::to_string(held / 1'000'000) + " MB are here already" : ""));
    return std::nullopt;
  }

  /// Puts the fetched files into their place if they are the session's scene. Returns a result if
  /// that ended the fetch.
  std::optional<SessionScene> Finish() {
    const std::string fault = FaultOf();
    if (!fault.empty()) {
      files_->Remove();
      party_.With([&](SceneFetch& fetch) {
        fetch.Refuse(fault, MonotonicNowNs());
      });
      files_.reset();
      return std::nullopt;
    }
    const Result<fs::path> file = files_->Commit(scene_.content_digest);
    if (!file) return Fault(scene_, file.error().what);
    char seconds[32];
    std::snprintf(seconds, sizeof seconds, "%.1f s", ToSeconds(MonotonicNowNs() - began_ns_));
    options_.say("fetched scene " + PlainLine(scene_.name, 64) + " in " + seconds + " into " +
                 file->parent_path().string() + " ('tandem cache clear' removes it)");
    return Found(*file);
  }

  /// Returns why the fetched files are not the session's scene; empty: they are.
  std::string FaultOf() {
    const Result<fs::path> file = files_->WriteScene();
    if (!file) return file.error().what;
    const Result<Scene> scene = LoadScene(*file);
    if (!scene) return "the fetched scene is invalid: " + scene.error().what;
    const Result<SceneHash> hash = HashScene(*scene);
    if (!hash) return hash.error().what;
    if (hash->digest == scene_.content_digest) return {};
    return "the fetched scene is not the session's: " + ContentDifference(*scene, *hash, scene_);
  }

  Party& party_;
  const SceneManifest& scene_;
  const SessionSceneOptions& options_;
  const SceneStore& store_;
  std::optional<UnfinishedScene> files_;
  std::int64_t began_ns_ = 0;
};

}  // namespace

SceneFetcher::SceneFetcher() : party_(std::make_unique<Party>()) {}

SceneFetcher::~SceneFetcher() = default;

TransferEndpoint* SceneFetcher::PartyOf(PeerId self, const fs::path& keys) {
  {
    const std::scoped_lock lock(mutex_);
    keys_ = keys;
  }
  party_->SetSelf(self);
  return party_.get();
}

fs::path SceneFetcher::keys() const {
  const std::scoped_lock lock(mutex_);
  return keys_;
}

SessionScene SceneFetcher::Fetch(const SceneManifest& scene, const SessionSceneOptions& requested) {
  SessionSceneOptions options = requested;
  options.connection.secure = keys();
  const std::optional<SceneStore> store = FetchedScenes(options.connection.secure);
  if (!store) {
    return Fault(scene,
                 "it cannot be fetched, because there is no cache: set TANDEM_CACHE to a folder");
  }
  return Arrival<Party>(*party_, scene, options, *store).Run();
}

std::string OfferedScene::Words() const {
  return "scene " + name + ", " + std::to_string(files) + " files, " +
         (bytes < 1'000'000 ? std::to_string((bytes + 999) / 1000) + " kB"
                            : std::to_string(bytes / 1'000'000) + " MB") +
         ", from " + from;
}

SessionScene FindSessionScene(const SessionSceneOptions& requested) {
  EarlyInbox inbox;
  SceneFetcher fetcher;
  SessionSceneOptions options = requested;
  options.name_of = [&inbox](PeerId peer) {
    return inbox.NameOf(peer);
  };
  DdsOptions dds;
  dds.session = options.session;
  dds.peer = options.id;
  dds.role = options.role;
  dds.files = fetcher.PartyOf(options.id, options.connection.secure);
  ApplyConnection(options.connection, dds);
  if (options.from_relay) GoToRelay(dds);
  Result<std::unique_ptr<Transport>> joined = JoinOverDds(dds, inbox);
  if (!joined) {
    return {.file = {},
            .exit_code = options.connection.secure.empty() ? kExitNetwork : kExitSecurity,
            .fault = joined.error().what};
  }
  const std::unique_ptr<Transport> transport = *std::move(joined);
  const std::optional<SceneManifest> scene = HearScene(inbox, options);
  if (options.stop.stop_requested()) return {};
  if (!scene) {
    return {.file = {},
            .exit_code = kExitNetwork,
            .fault = "no peer of session " + options.session +
                     " offers a scene: start a peer with --scene first, or give --scene"};
  }
  if (const auto found = Find(*scene, options)) return Found(*found);
  if (options.stop.stop_requested()) return {};
  if (options.from_relay) {
    return Fault(
        *scene,
        "a relay sends no scene files: get them another way, and name the scene with --scene");
  }
  return fetcher.Fetch(*scene, options);
}

}  // namespace tandem
