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
#include "engine/world/scene_proximity.h"
#include "engine/world/world_model.h"

namespace tandem {

/// How near the part in hand is to the others (paper §3.1), measured on a thread of its own, some
/// twenty times a second: far from the haptic loop, of which it only sees where bodies were.
class DistanceMeter {
 public:
  using OnMeasured = std::function<void(int held, const SnapshotDistance&)>;

  /// Voxelizes the scene's parts for it, which takes seconds; gives up once `stop` is true.
  static Result<std::unique_ptr<DistanceMeter>> Make(const WorldModel& model,
                                                     const std::atomic<bool>& stop,
                                                     OnMeasured on_measured);
  ~DistanceMeter();
  DistanceMeter(const DistanceMeter&) = delete;
  DistanceMeter& operator=(const DistanceMeter&) = delete;

  /// The moving body in hand (-1: none) and where the moving bodies are.
  void See(int held, const std::vector<Pose>& X_WB);

 private:
  DistanceMeter(const WorldModel& model, std::vector<ProximityPart> parts, OnMeasured on_measured);
  void Run();
  SnapshotDistance Measure(int held, const std::vector<Pose>& X_WB);

  std::vector<int> body_index_;  // per scene body, as of WorldModel
  std::vector<Pose> X_BW0_;      // of the moving bodies at first
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
