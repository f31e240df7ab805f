#include "app/judgement/distance_meter.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include <pthread.h>
#include <sys/resource.h>
#include <unistd.h>

#include "collab/controller/plain.h"

namespace tandem {

namespace {

constexpr std::chrono::milliseconds kPeriod{50};
constexpr int kLowPriority = 10;  // "nice"

std::vector<ProximityBody> BodiesOf(const WorldModel& model) {
  std::vector<ProximityBody> bodies;
  for (std::size_t i = 0; i < model.scene.bodies.size(); ++i) {
    const SceneBody& body = model.scene.bodies[i];
    bodies.push_back({body.name, body.fixed, model.meshes_W[i]});
    if (model.scene.WholeOf(i) != i) bodies.back().part_of = model.scene.WholeOf(i);
  }
  return bodies;
}

}  // namespace

Result<std::unique_ptr<DistanceMeter>> DistanceMeter::Make(const WorldModel& model,
                                                           const std::atomic<bool>& stop,
                                                           OnMeasured on_measured) {
  Result<std::vector<ProximityPart>> parts =
      MakeProximityParts(BodiesOf(model), model.scene.voxel_size, model.scene.range_voxels,
                         [&stop](std::size_t, std::size_t, const std::string&) {
                           return !stop.load();
                         });
  if (!parts) return parts.error();
  return std::unique_ptr<DistanceMeter>(
      new DistanceMeter(model, *std::move(parts), std::move(on_measured)));
}

DistanceMeter::DistanceMeter(const WorldModel& model, std::vector<ProximityPart> parts,
                             OnMeasured on_measured)
    : body_index_(model.body_index),
      proximity_(std::make_shared<const std::vector<ProximityPart>>(std::move(parts))),
      part_of_moving_(model.bodies.size(), SceneNearness::kNone),
      on_measured_(std::move(on_measured)) {
  for (const BodyModel& body : model.bodies) X_BW0_.push_back(body.X_WB0.Inverse());
  for (std::size_t part = 0; part < proximity_.parts().size(); ++part) {
    const int moving = body_index_[proximity_.parts()[part].bodies.front()];
    if (moving >= 0) part_of_moving_[static_cast<std::size_t>(moving)] = part;
  }
  thread_ = std::thread([this] {
    Run();
  });
}

DistanceMeter::~DistanceMeter() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  something_.notify_all();
  thread_.join();
}

void DistanceMeter::See(int held, const std::vector<Pose>& X_WB) {
  {
    const std::lock_guard lock(mutex_);
    held_ = held;
    X_WB_ = X_WB;
    seen_ = true;
  }
  something_.notify_all();
}

void DistanceMeter::Run() {
  pthread_setname_np(pthread_self(), "distances");
  // on Linux this changes this thread alone
  setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), kLowPriority);
  auto next = std::chrono::steady_clock::now();
  std::unique_lock lock(mutex_);
  while (!ending_) {
    something_.wait(lock, [this] {
      return ending_ || seen_;
    });
    if (something_.wait_until(lock, next, [this] {
          return ending_;
        })) {
      return;
    }
    seen_ = false;
    const int held = held_;
    const std::vector<Pose> X_WB = X_WB_;
    lock.unlock();
    on_measured_(held, Measure(held, X_WB));
    next = std::chrono::steady_clock::now() + kPeriod;
    lock.lock();
  }
}

SnapshotDistance DistanceMeter::Measure(int held, const std::vector<Pose>& X_WB) {
  SnapshotDistance distance;
  const auto body = static_cast<std::size_t>(held);
  if (held < 0 || body >= part_of_moving_.size() || X_WB.size() != X_BW0_.size() ||
      part_of_moving_[body] == SceneNearness::kNone) {
    return distance;
  }
  std::vector<Pose> X_W(body_index_.size());
  for (std::size_t i = 0; i < X_W.size(); ++i) {
    if (body_index_[i] < 0) continue;
    const auto moving = static_cast<std::size_t>(body_index_[i]);
    X_W[i] = X_WB[moving] * X_BW0_[moving];
  }
  const SceneNearness near = proximity_.NearestTo(part_of_moving_[body], X_W);
  if (near.other == SceneNearness::kNone) return distance;
  distance.m = near.overlap ? 0 : near.distance;
  distance.error_m = near.error_bound();
  distance.other = static_cast<std::int64_t>(proximity_.parts()[near.other].bodies.front());
  distance.p_W = Plain(near.p_WPart);
  distance.p_other_W = Plain(near.p_WOther);
  return distance;
}

}  // namespace tandem
