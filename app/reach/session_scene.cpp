#include "app/reach/session_scene.h"

#include <cstdio>
#include <memory>
#include <mutex>
#include <optional>
#include <tuple>
#include <utility>
#include <vector>

#include "app/exit_codes.h"
#include "app/program_folders.h"
#include "app/reach/scene_search.h"
#include "collab/dds/relay.h"
#include "collab/early_inbox.h"
#include "collab/scene_agreement.h"
#include "collab/transfer/scene_fetch.h"
#include "collab/transfer/scene_store.h"
#include "engine/base/regular_file.h"
#include "engine/base/units.h"
#include "engine/realtime/clock.h"

namespace tandem {

namespace {

namespace fs = std::filesystem;

// after the first manifest, for those of others
constexpr std::int64_t kSettleNs = 400 * kMs;
// for the first one: on another network peers take a second or two to be discovered
constexpr std::int64_t kListenNs = 5000 * kMs;
constexpr std::int64_t kLookNs = 50 * kMs;
constexpr std::uint64_t kMostFetchedBytes = std::uint64_t{10} << 30U;  // of all scenes

/// The fetching side, which begins when it is known what to fetch. Used by the transport's thread
/// and by the one that decides.
class Fetching final : public FileParty {
 public:
  bool serves() const override { return false; }
  void OnPiece(const FilePiece& piece, std::int64_t now_ns) override {
    const std::scoped_lock lock(mutex_);
    if (fetch_) fetch_->OnPiece(piece, now_ns);
  }
  std::int64_t Turn(std::int64_t now_ns, const Out& out) override {
    const std::scoped_lock lock(mutex_);
    return fetch_ ? fetch_->Turn(now_ns, out) : now_ns + kLookNs;
  }

  void Start(PeerId self, std::uint64_t content_hash, std::uint64_t most_bytes) {
    const std::scoped_lock lock(mutex_);
    fetch_.emplace(self, content_hash, most_bytes);
  }
  template <typename Use>
  auto With(const Use& use) {
    const std::scoped_lock lock(mutex_);
    return use(*fetch_);
  }

 private:
  std::mutex mutex_;
  std::optional<SceneFetch> fetch_;
};

/// A visit to a session for its scene.
class Visit {
 public:
  explicit Visit(const SessionSceneOptions& options) : options_(options) {}

  SessionScene Run() {
    DdsOptions dds;
    dds.session = options_.session;
    dds.peer = options_.id;
    dds.role = options_.role;
    dds.files = &fetching_;
    ApplyReach(options_.reach, dds);
    if (options_.from_relay) GoToRelay(dds);
    Result<std::unique_ptr<Transport>> joined = JoinOverDds(dds, inbox_);
    if (!joined) {
      return {.file = {},
              .exit_code = options_.reach.secure.empty() ? kExitNetwork : kExitSecurity,
              .fault = joined.error().what};
    }
    const std::unique_ptr<Transport> transport = *std::move(joined);
    scene_ = HearScene();
    if (Stopped()) return {};
    if (!scene_) {
      return {.file = {},
              .exit_code = kExitNetwork,
              .fault = "nobody in session " + options_.session +
                       " tells of a scene: start a peer with --scene there first, or give --scene"};
    }
    if (const auto found = Find()) return Found(*found);
    if (Stopped()) return {};
    if (options_.from_relay) {
      return Fault("a relay hands out no files: get them, and name them with --scene");
    }
    fetching_.Start(options_.id, scene_->content_hash, options_.most_bytes);
    return Fetch();
  }

 private:
  bool Stopped() const { return options_.stop.stop_requested(); }

  static SessionScene Found(const fs::path& file) {
    return {.file = file, .exit_code = kExitOk, .fault = {}};
  }
  SessionScene Fault(const std::string& why) const {
    return {.file = {},
            .exit_code = kExitFile,
            .fault = "this machine does not have the session's scene " + PlainLine(scene_->name) +
                     ": " + why};
  }

  /// The scene that most here go by; nothing: nobody has said any.
  std::optional<SceneManifest> HearScene() const {
    const std::int64_t joined_ns = MonotonicNowNs();
    std::optional<std::int64_t> first_ns;
    for (;;) {
      const std::int64_t now_ns = MonotonicNowNs();
      const std::optional<SceneManifest> scene = inbox_.SessionScene();
      if (scene && !first_ns) first_ns = now_ns;
      const bool over =
          first_ns ? now_ns - *first_ns >= kSettleNs : now_ns - joined_ns >= kListenNs;
      if (over || Stopped()) return scene;
      MachineClock().SleepUntil(now_ns + 10 * kMs);
    }
  }

  std::optional<fs::path> Find() const {
    const auto found = FindScene(WantedFrom(*scene_), FoldersWithScenes(), options_.stop);
    if (found) {
      options_.say("the session's scene " + PlainLine(scene_->name) +
                   " is on this machine: " + found->string());
    }
    return found;
  }

  SessionScene Fetch() {
    const std::optional<SceneStore> store = FetchedScenes();
    if (!store) {
      return Fault(
          "it could be fetched, but there is no cache to put it: set TANDEM_CACHE to a "
          "folder");
    }
    std::optional<UnfinishedScene> files;
    for (;;) {
      if (Stopped()) return {};
      const auto state = fetching_.With([](SceneFetch& fetch) {
        return fetch.state();
      });
      for (const std::string& line : fetching_.With([](SceneFetch& fetch) {
             return fetch.TakeNews();
           })) {
        options_.say(line);
      }
      std::optional<SessionScene> end;
      if (state == SceneFetch::State::kFailed) {
        return Fault(fetching_.With([](SceneFetch& fetch) {
          return fetch.fault();
        }));
      }
      if (state == SceneFetch::State::kListed) end = Begin(*store, files);
      if (state == SceneFetch::State::kFetched) end = Finish(files);
      if (end) return *std::move(end);
      ShowProgress();
      MachineClock().SleepUntil(MonotonicNowNs() + kLookNs);
    }
  }

  void ShowProgress() {
    const auto [held, of] = fetching_.With([](SceneFetch& fetch) {
      const bool fetches = fetch.state() == SceneFetch::State::kFetching;
      return std::pair(fetch.bytes_held(), fetches ? fetch.list().total_bytes() : 0);
    });
    if (of > 0 && options_.progress) options_.progress(held, of);
  }

  /// Asks the person, and makes the files. Something: it is over.
  std::optional<SessionScene> Begin(const SceneStore& store,
                                    std::optional<UnfinishedScene>& files) {
    const auto [list, digest, from] = fetching_.With([](SceneFetch& fetch) {
      return std::tuple(fetch.list(), fetch.digest(), fetch.source());
    });
    const std::string name = inbox_.NameOf(from);
    const SceneOffered offered{PlainLine(scene_->name, 64),
                               name.empty() ? "a peer without a name" : PlainLine(name, 64),
                               list.files.size(), list.total_bytes()};
    if (const std::string why = options_.refuses(offered); !why.empty()) return Fault(why);
    bool busy = true;
    bool told = false;
    while (busy) {
      Result<UnfinishedScene> opened = UnfinishedScene::Open(
          store, list, digest, {.most_bytes = CacheLimit().value_or(kMostFetchedBytes)}, busy);
      if (opened) {
        files.reset();
        files.emplace(*std::move(opened));
        break;
      }
      if (!busy) return Fault(opened.error().what);
      if (!std::exchange(told, true)) options_.say(opened.error().what + ": waiting for it");
      MachineClock().SleepUntil(MonotonicNowNs() + 4 * kLookNs);
      if (Stopped()) return SessionScene{};
      // it may have come meanwhile
      const fs::path whole = store.SceneFileOf(scene_->content_hash);
      std::error_code unknown;
      if (!fs::exists(whole, unknown)) continue;
      if (const auto found = Find()) return Found(*found);
    }
    const std::uint64_t held = fetching_.With([&](SceneFetch& fetch) {
      fetch.Begin(*files, MonotonicNowNs());
      return fetch.bytes_at_start();
    });
    began_ns_ = MonotonicNowNs();
    options_.say(
        "fetching " + offered.Words() +
        (held > 0 ? "; " + std::to_string(held / 1'000'000) + " MB are here already" : ""));
    return std::nullopt;
  }

  /// Puts what has come into its place, if it is the session's scene. Something: it is over.
  std::optional<SessionScene> Finish(std::optional<UnfinishedScene>& files) {
    const std::string fault = FaultOf(*files);
    if (!fault.empty()) {
      files->Remove();
      files.reset();
      fetching_.With([&](SceneFetch& fetch) {
        fetch.Refuse(fault, MonotonicNowNs());
      });
      return std::nullopt;
    }
    const Result<fs::path> file = files->Commit(scene_->content_hash);
    if (!file) return Fault(file.error().what);
    char seconds[32];
    std::snprintf(seconds, sizeof seconds, "%.1f s",
                  1e-9 * static_cast<double>(MonotonicNowNs() - began_ns_));
    options_.say("fetched scene " + PlainLine(scene_->name, 64) + " in " + seconds + " into " +
                 file->parent_path().string() + " ('tandem cache clear' removes it)");
    return Found(*file);
  }

  /// Why what has come is not the session's scene; empty: it is.
  std::string FaultOf(UnfinishedScene& files) const {
    const Result<fs::path> file = files.WriteScene();
    if (!file) return file.error().what;
    const Result<Scene> scene = LoadScene(*file);
    if (!scene) return "what was sent is no sound scene: " + scene.error().what;
    const Result<SceneHash> hash = HashScene(*scene);
    if (!hash) return hash.error().what;
    if (hash->content == scene_->content_hash) return {};
    return "what was sent is not the session's scene: " + ContentDifference(*scene, *hash, *scene_);
  }

  const SessionSceneOptions& options_;
  EarlyInbox inbox_;
  Fetching fetching_;
  std::optional<SceneManifest> scene_;
  std::int64_t began_ns_ = 0;
};

}  // namespace

std::string SceneOffered::Words() const {
  return "scene " + name + ", " + std::to_string(files) + " files, " +
         (bytes < 1'000'000 ? std::to_string((bytes + 999) / 1000) + " kB"
                            : std::to_string(bytes / 1'000'000) + " MB") +
         ", from " + from;
}

SessionScene FindSessionScene(const SessionSceneOptions& options) {
  return Visit(options).Run();
}

}  // namespace tandem
