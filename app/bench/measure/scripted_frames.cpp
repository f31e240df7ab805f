#include "app/bench/measure/scripted_frames.h"

#include <functional>
#include <limits>

#include <nlohmann/json.hpp>

namespace tandem {

ScriptedHand::ScriptedHand(const World& world, const HandScript& script)
    : world_(&world), X_BD_(script.X_BD), device_(script, world.model().bodies[0].X_WB0) {
  device_.Start();
}

Anchor ScriptedHand::operator()(std::int64_t /*frame*/, const StepReport& report) {
  // the device gets what the body received, about the device's own origin
  const Wrench& on_body = report.hand_B_W;
  const Vec3 r = world_->state(0).X_WB.q * X_BD_.p;
  device_.Render({-(on_body.tau - r.cross(on_body.f)), -on_body.f});
  return device_.Read();
}

double Us(const Histogram& of, double quantile) {
  return 1e-3 * static_cast<double>(of.Quantile(quantile));
}

Histogram LeastOfPasses(const std::shared_ptr<const WorldModel>& model,
                        const ScheduleOptions& schedule, const HandScript& script,
                        const FrameCapacity& capacity, int frames, int passes) {
  Histogram least;
  if (passes == 0) return least;
  std::vector<std::int64_t> least_ns(static_cast<std::size_t>(frames),
                                     std::numeric_limits<std::int64_t>::max());
  for (int pass = 0; pass < passes; ++pass) {
    World world(model, schedule);
    ScriptedHand hand(world, script);
    RunBackToBack(world, std::ref(hand), script.X_BD, capacity, least_ns);
  }
  for (const std::int64_t ns : least_ns) least.Add(ns);
  return least;
}

nlohmann::ordered_json BackToBackJson(const Histogram& least, int passes) {
  if (passes == 0) return nullptr;
  return {{"passes", passes},
          {"cpu_p50_us", Us(least, 0.5)},
          {"cpu_p99_us", Us(least, 0.99)},
          {"cpu_p999_us", Us(least, 0.999)}};
}

}  // namespace tandem
