#pragma once

#include <atomic>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "collab/controller/snapshot.h"
#include "engine/base/result.h"
#include "engine/proximity/scene_proximity.h"
#include "engine/world/world_model.h"

namespace tandem {

/// Measures how near the part in hand is to the others (paper §3.1), up to twenty times a second.
/// It has a thread of its own. Of the haptic loop it sees only where bodies were.
class DistanceMeter {
 public:
  using OnMeasured = std::function<void(int held, const SnapshotDistance&)>;

  /// Voxelizes the scene's parts for the meter, which takes seconds. Gives up once `stop` is true.
  static Result<std::unique_ptr<DistanceMeter>> Make(const WorldModel& model,
                                                     const std::atomic<bool>& stop,
                                                     OnMeasured on_measured);
  ~DistanceMeter();
  DistanceMeter(const DistanceMeter&) = delete;
  DistanceMeter& operator=(const DistanceMeter&) = delete;

  /// Takes the moving body in hand (-1: none) and the poses of the moving bodies.
  void See(int held, const std::vector<Pose>& X_WB);

 private:
  DistanceMeter(const WorldModel& model, std::vector<ProximityPart> parts, OnMeasured on_measured);
  void Run();
  SnapshotDistance Measure(int held, const std::vector<Pose>& X_WB);

  std::vector<int> body_index_;  // per scene body, as WorldModel::body_index
  std::vector<Pose> X_BW0_;      // inverse first poses of the moving bodies
  SceneProximity proximity_;
  std::vector<std::size_t> part_of_moving_;
  OnMeasured on_measured_;
  std::mutex mutex_;
  std::condition_variable something_;
  bool ending_ = false;
  bool seen_ = false;
  int held_ = -1;
  std::vector<Pose> X_WB_;
  std::thread thread_;
};

}  // namespace tandem
