#include "app/peer/joining.h"

#include <algorithm>
#include <utility>

#include "app/common/exit_codes.h"
#include "app/common/program_cache.h"
#include "app/common/scene_files.h"
#include "app/common/talk.h"
#include "app/peer/joined_node.h"
#include "app/peer/scene_consent.h"
#include "app/reach/scene_search.h"
#include "app/reach/session_scene.h"
#include "collab/coupling/coupling_limits.h"
#include "collab/dds/transport/dds_transport.h"
#include "engine/base/units.h"
#include "engine/realtime/clock.h"

namespace tandem {

namespace {

// time to hear the session's scene before anything is loaded; present peers answer in a tenth of it
constexpr std::int64_t kListenNs = 400 * kMs;
// time before we refuse to join, where another scene is heard
constexpr std::int64_t kListenToOthersNs = 2000 * kMs;
// loads for force parameters that others offer meanwhile
constexpr int kMostLoads = 3;

/// Puts the session's scene into `arguments` where they name none.
int TakeSessionScene(PeerArguments& arguments, PeerId id) {
  if (!arguments.scene_from_session || !arguments.scene.empty()) return kExitOk;
  SessionSceneOptions options =
      SceneSearchOptions(arguments.session, id, Role::kActive, arguments.reach,
                         {.accept = arguments.accept_scene, .limit_mb = arguments.scene_limit_mb});
  options.stop = arguments.stop;
  const SessionScene found = FindSessionScene(options);
  if (!found.fault.empty()) return Fail(found.exit_code, found.fault);
  if (found.file.empty()) return kEndedWhileLoading;
  arguments.scene = found.file.string();
  return kExitOk;
}

/// Reads the scene file and what it is made of.
int ReadScene(const PeerArguments& arguments, Joining& joining) {
  Result<Scene> scene = LoadNamedScene(arguments.scene);
  if (!scene) return Fail(kExitFile, scene.error().what);
  if (const std::string fault = BeyondLimits(*scene); !fault.empty()) {
    return Fail(kExitFile, fault);
  }
  Result<SceneHash> hash = HashScene(*scene);
  if (!hash) return Fail(kExitFile, hash.error().what);
  RememberSceneFolder(scene->file);
  joining.scene = *std::move(scene);
  joining.own = ParametersOf(joining.scene);
  joining.adopt_any = arguments.adopt_any;
  joining.hash = *std::move(hash);
  joining.manifest = ManifestOf(joining.scene, joining.hash, joining.id);
  return kExitOk;
}

/// Returns which bodies there are to hold, where `body` is none of them.
std::string WhyNotHeld(const std::string& body, const Scene& scene) {
  const bool fixed = scene.BodyNamed(body) >= 0;
  std::string moving;
  for (const SceneBody& other : scene.bodies) {
    if (!other.fixed) moving += (moving.empty() ? "" : ", ") + other.name;
  }
  return "--hold " + body + ": " + (fixed ? "this body is fixed; " : "") + scene.file.string() +
         " has no moving body of that name; its moving bodies: " +
         (moving.empty() ? "none at all" : moving);
}

int Connect(const PeerArguments& arguments, Joining& joining) {
  DdsOptions dds;
  dds.session = arguments.session;
  dds.peer = joining.id;
  const Scene& scene = joining.scene;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    if (scene.bodies[i].fixed || scene.WholeOf(i) != i) continue;
    dds.objects.push_back(static_cast<ObjectId>(i));
  }
  ApplyReach(arguments.reach, dds);
  if (arguments.share_scene) {
    const auto open = [file = scene.file,
                       content = joining.hash.content](const std::atomic<bool>& stop) {
      return SceneFiles::Open(file, content, stop);
    };
    joining.files =
        std::make_unique<SceneServer>(joining.id, joining.hash.content, open,
                                      static_cast<std::uint64_t>(1e6 * arguments.share_rate_mb));
    dds.files = joining.files.get();
  }
  Result<std::unique_ptr<Transport>> joined = JoinOverDds(dds, joining.inbox);
  if (!joined) {
    return Fail(arguments.reach.secure.empty() ? kExitNetwork : kExitSecurity, joined.error().what);
  }
  joining.transport = *std::move(joined);
  joining.goodbye.emplace([&transport = *joining.transport] {
    transport.SayGoodbye();
  });
  joining.joined_ns = MonotonicNowNs();
  return kExitOk;
}

/// Keeps to the scene file's force parameters beside a session that has others.
int Insist(const PeerArguments& arguments, const ForceParameters& session, Joining& joining) {
  const int held = joining.scene.BodyNamed(arguments.hold);
  if (held >= 0 &&
      joining.scene.bodies[joining.scene.WholeOf(static_cast<std::size_t>(held))].shared) {
    return Fail(kExitIncompatiblePeer,
                "--insist: " + arguments.hold + " is shared, and only peers with equal force " +
                    "parameters can hold it together; the session uses " + Describe(session) +
                    ": leave out --insist, or hold another body");
  }
  joining.unequal = session;
  joining.manifest.revision = SceneManifest::kOwnOnly;
  return kExitOk;
}

void OfferOn(const SceneManifest& session, Joining& joining) {
  joining.manifest = session;
  joining.manifest.offered_by = joining.id;
  // a peer that insisted may be the only one left: then its parameters are the session's
  joining.manifest.revision = std::max(session.revision, SceneManifest::kSession);
}

/// Returns whether force parameters may be adopted. It compares with the scene file, however often
/// others were adopted.
bool MayAdopt(const ForceParameters& theirs, const Joining& joining) {
  return joining.adopt_any || MayBeAdopted(theirs, joining.own);
}

/// Compares what we have with the session's scene and adopts its force parameters, or insists.
int Agree(const PeerArguments& arguments, const SceneManifest& session, Joining& joining) {
  const std::string difference = ContentDifference(joining.scene, joining.hash, session);
  if (!difference.empty()) {
    return Fail(kExitIncompatiblePeer,
                difference + ": get the same scene, or join another session");
  }
  const ForceParameters theirs = ParametersOf(session);
  const ForceParameters ours = ParametersOf(joining.scene);
  if (theirs == ours) {
    OfferOn(session, joining);
    return kExitOk;
  }
  if (arguments.insist) return Insist(arguments, theirs, joining);
  if (!MayAdopt(theirs, joining)) {
    return Fail(kExitIncompatiblePeer,
                "the session uses " + Describe(theirs) + ", this scene " + Describe(joining.own) +
                    ": they differ by more than a factor of 4, which needs much more memory or is "
                    "much coarser; --adopt-any takes the session's voxels, --insist keeps yours");
  }
  if (const std::string fault = LayerFault(theirs.contact, theirs.force_layer); !fault.empty()) {
    return Fail(kExitIncompatiblePeer, "the session uses " + Describe(theirs) + ", but " + fault +
                                           ": change the scene's force_layer, or give --insist");
  }
  Adopt(theirs, joining.scene);
  if (!(ParametersOf(joining.scene) == theirs)) {
    return Fail(kExitIncompatiblePeer,
                "another version of this program computes the session's contacts: update all to "
                "one version, or give --insist");
  }
  Say("the session uses " + Describe(theirs) + "; this peer adopts them (--insist keeps " +
      Describe(ours) + ")");
  joining.hash.parameters = HashOf(theirs);
  OfferOn(session, joining);
  return kExitOk;
}

/// Loads the world for the agreed scene. This is the slow part.
int LoadAgreed(const PeerArguments& arguments, Joining& joining) {
  Result<std::shared_ptr<const WorldModel>> model = LoadCached(
      joining.scene, {.stop = arguments.stop, .voxel_memory_bytes = arguments.voxel_memory});
  if (arguments.stop.stop_requested()) return kEndedWhileLoading;
  if (!model) return Fail(kExitFile, model.error().what);
  joining.model = *std::move(model);
  joining.helpers.reset();
  if (arguments.threads > 1) {
    joining.helpers =
        std::make_unique<FrameHelpers>(FrameHelpers::Options{.threads = arguments.threads});
  }
  // given tests fix the price too, so that a run can be repeated
  joining.capacity = arguments.capacity > 0
                         ? FrameCapacity{.tests = arguments.capacity}
                         : MeasureCapacity(*joining.model, kFrameBudget, joining.helpers.get());
  if (arguments.look_price > 0) joining.capacity.look_price = arguments.look_price;
  return kExitOk;
}

/// Listens for the scene that most peers here go by. The peer that is heard first may be the only
/// one that goes by another.
std::optional<SceneManifest> ListenForScene(const PeerArguments& arguments,
                                            const Joining& joining) {
  std::optional<std::int64_t> first_ns;  // time at which a scene was first heard
  for (;;) {
    const std::int64_t now_ns = MonotonicNowNs();
    const std::optional<SceneManifest> session = joining.inbox.SessionScene();
    if (session && !first_ns) first_ns = now_ns;
    const bool fits =
        !session || (ContentDifference(joining.scene, joining.hash, *session).empty() &&
                     (arguments.insist || MayAdopt(ParametersOf(*session), joining)));
    const std::int64_t from_ns = first_ns.value_or(joining.joined_ns);
    const bool is_over = now_ns - from_ns >= (fits ? kListenNs : kListenToOthersNs);
    if (is_over || arguments.stop.stop_requested()) return session;
    MachineClock().SleepUntil(now_ns + 10 * kMs);
  }
}

}  // namespace

bool Superseded(const Joining& joining) {
  if (joining.unequal) return false;
  const std::optional<SceneManifest> session =
      joining.node ? joining.node->directory().SessionScene() : joining.inbox.SessionScene();
  // the node offers a manifest of its own after a while
  const SceneManifest& ours = joining.node ? joining.node->manifest() : joining.manifest;
  return session && session->content_hash == joining.hash.content && Precedes(*session, ours) &&
         !(ParametersOf(*session) == ParametersOf(joining.scene)) &&
         MayAdopt(ParametersOf(*session), joining);
}

int Join(PeerArguments& arguments, Joining& joining) {
  const Result<PeerId> id = Identify(arguments.reach, Role::kActive, arguments.name);
  if (!id) return Fail(kExitSecurity, id.error().what);
  joining.id = *id;
  if (const auto law = MakeLaw(arguments.law, arguments.limits, arguments.lab); !law) {
    return Fail(kExitUsage, law.error().what);
  }
  for (const LimitName& limit : kLimitNames) {
    if (arguments.limits.*limit.value == CouplingLimits{}.*limit.value) continue;
    if (const std::string why = WhyUnused(limit.name, arguments.law); !why.empty()) {
      return Fail(kExitUsage, "--gain " + std::string(limit.name) + ": " + why);
    }
  }
  if (const int failed = TakeSessionScene(arguments, joining.id); failed != kExitOk) return failed;
  if (const int failed = ReadScene(arguments, joining); failed != kExitOk) return failed;
  const int held = joining.scene.BodyNamed(arguments.hold);
  if (!arguments.hold.empty() &&
      (held < 0 || joining.scene.bodies[static_cast<std::size_t>(held)].fixed)) {
    return Fail(kExitUsage, WhyNotHeld(arguments.hold, joining.scene));
  }
  if (const int failed = Connect(arguments, joining); failed != kExitOk) return failed;
  std::optional<SceneManifest> session = ListenForScene(arguments, joining);
  if (arguments.stop.stop_requested()) return kEndedWhileLoading;
  if (joining.inbox.has_twin()) {
    return Fail(kExitSecurity, arguments.reach.secure +
                                   ": another program in this session already uses these keys: end "
                                   "that program, or use keys of your own");
  }
  do {
    if (session) {
      if (const int failed = Agree(arguments, *session, joining); failed != kExitOk) return failed;
    }
    // published at once: peers that come while we load adopt what we offer
    joining.transport->Publish(joining.manifest);
    if (const int failed = LoadAgreed(arguments, joining); failed != kExitOk) return failed;
    session = joining.inbox.SessionScene();
  } while (Superseded(joining) && ++joining.times_loaded <= kMostLoads);
  if (const int failed = MakeNode(arguments, joining); failed != kExitOk) return failed;
  if (!arguments.repeats) {
    for (const std::string& remark : joining.model->remarks) Say(remark);
  }
  if (!arguments.brief && !arguments.no_contact) {
    joining.start_gaps = FindStartGaps(*joining.model);
    TellStart(joining.start_gaps);
  }
  if (joining.unequal) {
    double heaviest_kg = 0;
    for (const BodyModel& body : joining.model->bodies) {
      heaviest_kg = std::max(heaviest_kg, body.inertia.mass);
    }
    Say(PushWarning(ParametersOf(joining.scene), *joining.unequal, heaviest_kg, "the session") +
        "; this peer cannot hold shared bodies");
  }
  joining.inbox.HandOver(joining.node->inbox());
  return kExitOk;
}

}  // namespace tandem
