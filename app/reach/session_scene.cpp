#include "app/reach/session_scene.h"

#include <memory>
#include <optional>
#include <utility>

#include "app/exit_codes.h"
#include "app/reach/scene_search.h"
#include "collab/dds/relay.h"
#include "collab/early_inbox.h"
#include "engine/base/regular_file.h"
#include "engine/base/units.h"
#include "engine/realtime/clock.h"

namespace tandem {

namespace {

// after the first manifest, for those of others
constexpr std::int64_t kSettleNs = 400 * kMs;
// for the first one: on another network peers take a second or two to be discovered
constexpr std::int64_t kListenNs = 5000 * kMs;

/// The scene that most here go by; nothing: nobody has said any.
std::optional<SceneManifest> HearScene(const EarlyInbox& inbox, const std::stop_token& stop) {
  const std::int64_t joined_ns = MonotonicNowNs();
  std::optional<std::int64_t> first_ns;
  for (;;) {
    const std::int64_t now_ns = MonotonicNowNs();
    const std::optional<SceneManifest> scene = inbox.SessionScene();
    if (scene && !first_ns) first_ns = now_ns;
    const bool over = first_ns ? now_ns - *first_ns >= kSettleNs : now_ns - joined_ns >= kListenNs;
    if (over || stop.stop_requested()) return scene;
    MachineClock().SleepUntil(now_ns + 10 * kMs);
  }
}

}  // namespace

SessionScene FindSessionScene(const SessionSceneOptions& options) {
  EarlyInbox inbox;
  DdsOptions dds;
  dds.session = options.session;
  dds.peer = options.id;
  dds.role = options.role;
  ApplyReach(options.reach, dds);
  if (options.from_relay) GoToRelay(dds);
  Result<std::unique_ptr<Transport>> joined = JoinOverDds(dds, inbox);
  if (!joined) {
    return {.exit_code = options.reach.secure.empty() ? kExitNetwork : kExitSecurity,
            .fault = joined.error().what};
  }
  const std::unique_ptr<Transport> transport = *std::move(joined);
  const std::optional<SceneManifest> scene = HearScene(inbox, options.stop);
  if (options.stop.stop_requested()) return {};
  if (!scene) {
    return {.exit_code = kExitNetwork,
            .fault = "nobody in session " + options.session +
                     " tells of a scene: start a peer with --scene there first, or give --scene"};
  }
  const auto found = FindScene(WantedFrom(*scene), FoldersWithScenes(), options.stop);
  if (found) {
    options.say("the session's scene " + PlainLine(scene->name) +
                " is on this machine: " + found->string());
    return {.file = *found};
  }
  if (options.stop.stop_requested()) return {};
  return {.exit_code = kExitFile,
          .fault = "this machine does not have the session's scene " + PlainLine(scene->name) +
                   ": get its files, and name them with --scene"};
}

}  // namespace tandem
