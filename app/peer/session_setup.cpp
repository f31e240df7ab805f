#include "app/peer/session_setup.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "app/common/console.h"
#include "app/common/exit_codes.h"
#include "app/common/program_cache.h"
#include "app/common/scene_files.h"
#include "app/connection/scene_search.h"
#include "app/connection/session_scene.h"
#include "app/peer/joined_node.h"
#include "app/peer/scene_consent.h"
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
      SceneSearchOptions(arguments.session, id, Role::kActive, arguments.connection,
                         {.accept = arguments.accept_scene, .limit_mb = arguments.scene_limit_mb});
  options.stop = arguments.stop;
  const SessionScene found = FindSessionScene(options);
  if (!found.fault.empty()) return Fail(found.exit_code, found.fault);
  if (found.file.empty()) return kEndedWhileLoading;
  arguments.scene = found.file.string();
  return kExitOk;
}

/// Reads the scene file and what it is made of.
int ReadScene(const PeerArguments& arguments, SessionSetup& setup) {
  Result<Scene> scene = LoadNamedScene(arguments.scene);
  if (!scene) return Fail(kExitFile, scene.error().what);
  if (const std::string fault = BeyondLimits(*scene); !fault.empty()) {
    return Fail(kExitFile, fault);
  }
  Result<SceneHash> hash = HashScene(*scene);
  if (!hash) return Fail(kExitFile, hash.error().what);
  RememberSceneFolder(scene->file);
  setup.scene = *std::move(scene);
  setup.own = ParametersOf(setup.scene);
  setup.adopt_any = arguments.adopt_any;
  setup.hash = *std::move(hash);
  setup.manifest = ManifestOf(setup.scene, setup.hash, setup.id);
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

int Connect(const PeerArguments& arguments, SessionSetup& setup) {
  DdsOptions dds;
  dds.session = arguments.session;
  dds.peer = setup.id;
  const Scene& scene = setup.scene;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    if (scene.bodies[i].fixed || scene.WholeOf(i) != i) continue;
    dds.objects.push_back(static_cast<ObjectId>(i));
  }
  ApplyConnection(arguments.connection, dds);
  if (arguments.share_scene) {
    const auto open = [file = scene.file,
                       content = setup.hash.digest](const std::atomic<bool>& stop) {
      return SceneFiles::Open(file, content, stop);
    };
    setup.files =
        std::make_unique<SceneServer>(setup.id, setup.hash.content, open,
                                      static_cast<std::uint64_t>(1e6 * arguments.share_rate_mb));
    dds.files = setup.files.get();
  }
  Result<std::unique_ptr<Transport>> joined = JoinOverDds(dds, setup.inbox);
  if (!joined) {
    return Fail(arguments.connection.secure.empty() ? kExitNetwork : kExitSecurity,
                joined.error().what);
  }
  setup.transport = *std::move(joined);
  setup.goodbye.emplace([&transport = *setup.transport] {
    transport.SayGoodbye();
  });
  setup.joined_ns = MonotonicNowNs();
  return kExitOk;
}

/// Keeps to the scene file's force parameters beside a session that has others.
int Insist(const PeerArguments& arguments, const ForceParameters& session, SessionSetup& setup) {
  const int held = setup.scene.BodyNamed(arguments.hold);
  if (held >= 0 && setup.scene.bodies[setup.scene.WholeOf(static_cast<std::size_t>(held))].shared) {
    return Fail(kExitIncompatiblePeer,
                "--insist: " + arguments.hold + " is shared, and only peers with equal force " +
                    "parameters can hold it together; the session uses " + Describe(session) +
                    ": leave out --insist, or hold another body");
  }
  setup.unequal = session;
  setup.manifest.revision = SceneManifest::kOwnOnly;
  return kExitOk;
}

void OfferOn(const SceneManifest& session, SessionSetup& setup) {
  setup.manifest = session;
  setup.manifest.offered_by = setup.id;
  // a peer that insisted may be the only one left: then its parameters are the session's
  setup.manifest.revision = std::max(session.revision, SceneManifest::kSession);
}

/// Returns whether force parameters may be adopted. It compares with the scene file, however often
/// others were adopted.
bool MayAdopt(const ForceParameters& theirs, const SessionSetup& setup) {
  return setup.adopt_any || MayBeAdopted(theirs, setup.own);
}

/// Compares what we have with the session's scene and adopts its force parameters, or insists.
int Agree(const PeerArguments& arguments, const SceneManifest& session, SessionSetup& setup) {
  const std::string difference = ContentDifference(setup.scene, setup.hash, session);
  if (!difference.empty()) {
    return Fail(kExitIncompatiblePeer,
                difference + ": get the same scene, or join another session");
  }
  const ForceParameters theirs = ParametersOf(session);
  const ForceParameters ours = ParametersOf(setup.scene);
  if (theirs == ours) {
    OfferOn(session, setup);
    return kExitOk;
  }
  if (arguments.insist) return Insist(arguments, theirs, setup);
  if (!MayAdopt(theirs, setup)) {
    return Fail(kExitIncompatiblePeer,
                "the session uses " + Describe(theirs) + ", this scene " + Describe(setup.own) +
                    ": they differ by more than a factor of 4, which needs much more memory or is "
                    "much coarser; --adopt-any takes the session's voxels, --insist keeps yours");
  }
  if (const std::string fault = LayerFault(theirs.contact, theirs.force_layer); !fault.empty()) {
    return Fail(kExitIncompatiblePeer, "the session uses " + Describe(theirs) + ", but " + fault +
                                           ": change the scene's force_layer, or give --insist");
  }
  Adopt(theirs, setup.scene);
  if (!(ParametersOf(setup.scene) == theirs)) {
    return Fail(kExitIncompatiblePeer,
                "another version of this program computes the session's contacts: update all to "
                "one version, or give --insist");
  }
  Say("the session uses " + Describe(theirs) + "; this peer adopts them (--insist keeps " +
      Describe(ours) + ")");
  setup.hash.parameters = HashOf(theirs);
  OfferOn(session, setup);
  return kExitOk;
}

/// Loads the world for the agreed scene. This is the slow part.
int LoadAgreed(const PeerArguments& arguments, SessionSetup& setup) {
  Result<std::shared_ptr<const WorldModel>> model = LoadCached(
      setup.scene, {.stop = arguments.stop, .voxel_memory_bytes = arguments.voxel_memory});
  if (arguments.stop.stop_requested()) return kEndedWhileLoading;
  if (!model) return Fail(kExitFile, model.error().what);
  setup.model = *std::move(model);
  setup.workers.reset();
  if (arguments.threads > 1) {
    setup.workers = std::make_unique<WorkerPool>(WorkerPool::Options{.threads = arguments.threads});
  }
  // given tests fix the price too, so that a run can be repeated
  setup.capacity = arguments.capacity > 0
                       ? FrameCapacity{.tests = arguments.capacity}
                       : MeasureCapacity(*setup.model, kFrameBudget, setup.workers.get());
  if (arguments.query_price > 0) setup.capacity.query_price = arguments.query_price;
  return kExitOk;
}

/// Listens for the scene that most peers here go by. The peer that is heard first may be the only
/// one that goes by another.
std::optional<SceneManifest> ListenForScene(const PeerArguments& arguments,
                                            const SessionSetup& setup) {
  std::optional<std::int64_t> first_ns;  // time at which a scene was first heard
  for (;;) {
    const std::int64_t now_ns = MonotonicNowNs();
    const std::optional<SceneManifest> session = setup.inbox.SessionScene();
    if (session && !first_ns) first_ns = now_ns;
    const bool fits = !session || (ContentDifference(setup.scene, setup.hash, *session).empty() &&
                                   (arguments.insist || MayAdopt(ParametersOf(*session), setup)));
    const std::int64_t from_ns = first_ns.value_or(setup.joined_ns);
    const bool is_over = now_ns - from_ns >= (fits ? kListenNs : kListenToOthersNs);
    if (is_over || arguments.stop.stop_requested()) return session;
    MachineClock().SleepUntil(now_ns + 10 * kMs);
  }
}

}  // namespace

bool Superseded(const SessionSetup& setup) {
  if (setup.unequal) return false;
  const std::optional<SceneManifest> session =
      setup.node ? setup.node->directory().SessionScene() : setup.inbox.SessionScene();
  // the node offers a manifest of its own after a while
  const SceneManifest& ours = setup.node ? setup.node->manifest() : setup.manifest;
  return session && session->content_digest == setup.hash.digest && Precedes(*session, ours) &&
         !(ParametersOf(*session) == ParametersOf(setup.scene)) &&
         MayAdopt(ParametersOf(*session), setup);
}

int Join(PeerArguments& arguments, SessionSetup& setup) {
  const Result<PeerId> id = Identify(arguments.connection, Role::kActive, arguments.name);
  if (!id) return Fail(kExitSecurity, id.error().what);
  setup.id = *id;
  if (const auto law = MakeLaw(arguments.law, arguments.limits, arguments.lab); !law) {
    return Fail(kExitUsage, law.error().what);
  }
  for (const LimitName& limit : kLimitNames) {
    if (arguments.limits.*limit.value == CouplingLimits{}.*limit.value) continue;
    if (const std::string why = WhyUnused(limit.name, arguments.law); !why.empty()) {
      return Fail(kExitUsage, "--gain " + std::string(limit.name) + ": " + why);
    }
  }
  if (const int failed = TakeSessionScene(arguments, setup.id); failed != kExitOk) return failed;
  if (const int failed = ReadScene(arguments, setup); failed != kExitOk) return failed;
  const int held = setup.scene.BodyNamed(arguments.hold);
  if (!arguments.hold.empty() &&
      (held < 0 || setup.scene.bodies[static_cast<std::size_t>(held)].fixed)) {
    return Fail(kExitUsage, WhyNotHeld(arguments.hold, setup.scene));
  }
  if (const int failed = Connect(arguments, setup); failed != kExitOk) return failed;
  std::optional<SceneManifest> session = ListenForScene(arguments, setup);
  if (arguments.stop.stop_requested()) return kEndedWhileLoading;
  if (setup.inbox.has_twin()) {
    return Fail(kExitSecurity, arguments.connection.secure +
                                   ": another program in this session already uses these keys: end "
                                   "that program, or use keys of your own");
  }
  do {
    if (session) {
      if (const int failed = Agree(arguments, *session, setup); failed != kExitOk) return failed;
    }
    // published at once: peers that come while we load adopt what we offer
    setup.transport->Publish(setup.manifest);
    if (const int failed = LoadAgreed(arguments, setup); failed != kExitOk) return failed;
    session = setup.inbox.SessionScene();
  } while (Superseded(setup) && ++setup.times_loaded <= kMostLoads);
  if (const int failed = MakeNode(arguments, setup); failed != kExitOk) return failed;
  if (!arguments.repeats) {
    for (const std::string& remark : setup.model->remarks) Say(remark);
  }
  setup.warnings = setup.model->remarks;
  if (!arguments.brief && !arguments.no_contact) {
    setup.start_gaps = FindStartGaps(*setup.model);
    TellStart(setup.start_gaps);
    std::ranges::copy(Describe(setup.start_gaps), std::back_inserter(setup.warnings));
  }
  if (setup.unequal) {
    double heaviest_kg = 0;
    for (const BodyModel& body : setup.model->bodies) {
      heaviest_kg = std::max(heaviest_kg, body.inertia.mass);
    }
    Say(PushWarning(ParametersOf(setup.scene), *setup.unequal, heaviest_kg, "the session") +
        "; this peer cannot hold shared bodies");
  }
  setup.inbox.HandOver(setup.node->inbox());
  return kExitOk;
}

}  // namespace tandem
