#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "app/cli/timed_frames.h"
#include "engine/haptics/scripted_device.h"
#include "engine/world/world.h"

namespace tandem {

/// Holds the first body of a world by a script.
class ScriptedHand {
 public:
  ScriptedHand(const World& world, const HandScript& script);
  Anchor operator()(std::int64_t frame, const StepReport& report);

 private:
  const World* world_;
  Pose X_BD_;
  ScriptedDevice device_;
};

/// A quantile of times, us.
double Us(const Histogram& of, double quantile);

/// A script's frames, run so many times back to back, each in a world of its own: the least of each
/// frame.
Histogram LeastOfPasses(const std::shared_ptr<const WorldModel>& model,
                        const ScheduleOptions& schedule, const HandScript& script,
                        const FrameCapacity& capacity, int frames, int passes);
/// {"passes", "cpu_p50_us", "cpu_p99_us", "cpu_p999_us"}; null where there were none.
nlohmann::ordered_json BackToBackJson(const Histogram& least, int passes);

}  // namespace tandem
