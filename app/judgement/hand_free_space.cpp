#include "app/judgement/hand_free_space.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "app/common/console.h"
#include "app/judgement/demo_judgement.h"
#include "app/judgement/verdict.h"
#include "collab/recording/replay.h"
#include "engine/base/units.h"

namespace tandem {

namespace {

constexpr double kBisectedToVoxels = 0.01;
constexpr double kEndsWithin = 0.002;    // m
constexpr double kCrossesVoxels = 0.01;  // surfaces that are less deep only touch
constexpr double kDepthSeconds = 10;

/// Enlarges the hand's clearance over what a recording orders. It adds an order to the first frame
/// without orders, and changes each recorded order.
class LargerClearance {
 public:
  explicit LargerClearance(double by) : by_(by) {}

  void Apply(RecordedFrame& frame) {
    if (!begun_ && frame.commands.empty()) {
      frame.commands.push_back({.kind = Command::Kind::kDisplace, .metres = 0});
      begun_ = true;
    }
    for (Command& command : frame.commands) {
      if (command.kind != Command::Kind::kDisplace) continue;
      command.metres -= by_;
      begun_ = true;
    }
  }

 private:
  double by_;  // m
  bool begun_ = false;
};

/// A recording and its hand, as every replay needs them.
struct RecordedHand {
  std::filesystem::path file;
  std::shared_ptr<const WorldModel> model;
  std::shared_ptr<const PathMeshes> meshes;
};

/// The state of one replay, with the distances along its path.
struct HandRun {
  explicit HandRun(const std::shared_ptr<const PathMeshes>& meshes)
      : path(meshes), held(meshes->model().bodies.size(), false) {}

  PathDistance path;
  std::vector<bool> held;  // per moving body
  std::vector<Pose> last_WB;
  std::int64_t frames = 0;
  std::int64_t first_ns = 0;
  double peak_force = 0;  // N, of the hand
  double outward = 0;     // m, farthest that recorded orders displace points outwards
  bool torn = false;
  bool whole = true;  // the replay did not end because surfaces came too near
};

std::vector<Pose> PosesIn(const World& world) {
  std::vector<Pose> bodies_WB;
  for (std::size_t b = 0; b < world.model().bodies.size(); ++b) {
    bodies_WB.push_back(world.state(b).X_WB);
  }
  return bodies_WB;
}

/// Replays with a clearance that is larger by `by` (m), until surfaces come nearer than `least`
/// (m). With `by` 0 every frame must end in its recorded bits.
Result<HandRun> RunWith(const RecordedHand& hand, double by, double least) {
  const std::string name = hand.file.string();
  Result<RecordingReader> reader = RecordingReader::Open(hand.file);
  if (!reader) return reader.error();
  const Result<std::unique_ptr<Replay>> replay = Replay::Create(reader->header(), hand.model);
  if (!replay) return Error{name + ": " + replay.error().what};
  PeerNode& node = (*replay)->node();
  HandRun run(hand.meshes);
  LargerClearance larger(by);
  while (std::optional<RecordedFrame> frame = reader->Next()) {
    if (run.frames == 0) run.first_ns = frame->now_ns;
    for (const Command& command : frame->commands) {
      if (command.kind != Command::Kind::kDisplace) continue;
      run.outward = std::max(run.outward, -command.metres);
    }
    if (by > 0) larger.Apply(*frame);
    const std::uint64_t hash = (*replay)->Run(*frame);
    if (by <= 0 && hash != frame->state_hash) {
      return Error{name + ": frame " + std::to_string(run.frames) +
                   " does not end as recorded; 'tandem replay' says more"};
    }
    ++run.frames;
    const int held = HeldBody(node);
    if (held < 0) continue;
    run.held[static_cast<std::size_t>(held)] = true;
    run.path.See(static_cast<std::size_t>(held), PosesIn(node.world()), frame->now_ns);
    if (run.path.nearest().distance < least) {
      run.whole = false;
      return run;
    }
  }
  if (reader->damaged()) {
    return Error{name + ": damaged at frame " + std::to_string(run.frames) + ", " +
                 std::to_string(reader->unread_bytes()) + " bytes cannot be replayed"};
  }
  run.torn = reader->torn();
  run.peak_force = node.peer().telemetry().hand_figures().peak_force;
  run.last_WB = PosesIn(node.world());
  return run;
}

bool EndsAsRecorded(const PathMeshes& meshes, const HandRun& recorded, const HandRun& run) {
  const WorldModel& model = meshes.model();
  const double within = std::max(model.scene.voxel_size, kEndsWithin);
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    if (!recorded.held[b]) continue;
    if (model.has_fixture && OutcomeOf(model, b, recorded.last_WB[b]).out) {
      if (!OutcomeOf(model, b, run.last_WB[b]).out) return false;
    } else if (MostMoved(recorded.last_WB[b], run.last_WB[b], meshes.radius(b)) > within) {
      return false;
    }
  }
  return true;
}

/// Returns the least distance along a path; where surfaces cross it is below 0, by their depth.
/// Sets `crosses` of `room`, to nothing where surfaces meet and the depth is not judged, and the
/// error of the depth.
NearestPlace SignedNearest(const HandRun& run, double voxel_size, HandFreeSpace& room) {
  std::optional<bool>& crosses = room.crosses;
  NearestPlace nearest = run.path.nearest();
  crosses = false;
  if (nearest.distance > 0) return nearest;
  const std::optional<DeepestPlace> deepest = run.path.Deepest(kDepthSeconds);
  crosses.reset();
  if (!deepest) return nearest;
  crosses = deepest->depth > kCrossesVoxels * voxel_size;
  if (!*crosses) return nearest;
  room.depth_error = deepest->error;
  nearest = deepest->place;
  nearest.distance = -deepest->depth;
  return nearest;
}

/// Looks for the greatest clearance with which the recorded hand passes.
class ClearanceSearch {
 public:
  ClearanceSearch(const RecordedHand& hand, const HandRun& recorded,
                  const std::function<void(double, bool)>& on_trial)
      : hand_(hand),
        voxel_(hand.model->scene.voxel_size),
        recorded_(recorded),
        on_trial_(on_trial) {}

  /// Fills in the clearance that passes and what it keeps. `room` has the figures of the recorded
  /// path.
  std::optional<Error> Run(HandFreeSpace& room) {
    if (room.nearest.distance < -kKeptToVoxels * voxel_ || !room.crosses) return std::nullopt;
    room.passes_with = 0;
    room.kept = room.nearest.distance;
    // points can be displaced by a voxel at the most
    const double most = voxel_ - recorded_.outward;
    double fails = most;
    if (!(most > 0)) {
      room.at_least = true;
      return std::nullopt;
    }
    double next = most;
    while (fails - *room.passes_with > kBisectedToVoxels * voxel_) {
      const Result<std::optional<double>> kept = Try(next);
      if (!kept) return kept.error();
      if (*kept) {
        room.passes_with = next;
        room.kept = *kept;
        room.at_least = next == most;
      } else {
        fails = next;
      }
      next = 0.5 * (*room.passes_with + fails);
    }
    return std::nullopt;
  }

 private:
  /// Returns the distance that is kept with a clearance, m; nothing: it does not pass.
  Result<std::optional<double>> Try(double clearance) {
    const double least = clearance - kKeptToVoxels * voxel_;
    const Result<HandRun> run = RunWith(hand_, clearance, least);
    if (!run) return run.error();
    std::optional<double> kept;
    if (run->whole && EndsAsRecorded(*hand_.meshes, recorded_, *run)) {
      HandFreeSpace trial;
      const double distance = SignedNearest(*run, voxel_, trial).distance;
      if (trial.crosses && distance >= least) kept = distance;
    }
    if (on_trial_) on_trial_(clearance, kept.has_value());
    return kept;
  }

  const RecordedHand& hand_;
  double voxel_;  // m
  const HandRun& recorded_;
  const std::function<void(double, bool)>& on_trial_;
};

}  // namespace

Result<HandFreeSpace> MeasureHandFreeSpace(const std::filesystem::path& file,
                                           const std::shared_ptr<const WorldModel>& model,
                                           const std::function<void(double, bool)>& on_trial) {
  const Result<RecordingReader> reader = RecordingReader::Open(file);
  if (!reader) return reader.error();
  const RecordedHand hand{file, model, std::make_shared<const PathMeshes>(model)};
  const Result<HandRun> recorded = RunWith(hand, 0, -std::numeric_limits<double>::infinity());
  if (!recorded) return recorded.error();
  if (std::ranges::count(recorded->held, true) == 0) {
    return Error{file.string() + ": the hand held no body, so there is no path to measure"};
  }
  HandFreeSpace room;
  room.frames = recorded->frames;
  room.torn = recorded->torn;
  room.contact = reader->header().peer.experiments.contact;
  room.nearest = SignedNearest(*recorded, model->scene.voxel_size, room);
  room.peak_force = recorded->peak_force;
  room.at_s = ToSeconds(room.nearest.at_ns - recorded->first_ns);
  if (!room.contact) return room;
  ClearanceSearch search(hand, *recorded, on_trial);
  if (const std::optional<Error> failed = search.Run(room)) return *failed;
  return room;
}

}  // namespace tandem
