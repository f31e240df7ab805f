#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "app/bench/measure/timed_frames.h"
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

/// Returns a quantile of times, us.
double Us(const Histogram& of, double quantile);

/// Runs a script's frames `passes` times back to back, each pass in a world of its own. Returns the
/// least time of each frame.
Histogram LeastOfPasses(const std::shared_ptr<const WorldModel>& model,
                        const ScheduleOptions& schedule, const HandScript& script,
                        const FrameCapacity& capacity, int frames, int passes);
/// Returns {"passes", "cpu_p50_us", "cpu_p99_us", "cpu_p999_us"}; null without passes.
nlohmann::ordered_json BackToBackJson(const Histogram& least, int passes);

}  // namespace tandem
