#include "app/bench/fidelity/fidelity.h"
#include "engine/realtime/clock.h"
#include "engine/world/world.h"

namespace tandem {

FrameLengths LengthsOf(const TimesOfFrames& times) {
  const auto us = [](const Histogram& ns, double quantile) {
    return 1e-3 * static_cast<double>(ns.Quantile(quantile));
  };
  return {.cpu_p50_us = us(times.stats.cpu(), 0.5),
          .cpu_p99_us = us(times.stats.cpu(), 0.99),
          .wall_p999_us = us(times.stats.wall(), 0.999),
          .frames = times.stats.frames(),
          .over_1ms = times.over_1ms,
          .missed = times.stats.missed(),
          .dropped = times.dropped};
}

TimedFrame TimedStep(World& world, const StepInputs& inputs, TimesOfFrames& times) {
  constexpr std::int64_t kPeriodNs = 1'000'000;
  LoopClock& clock = MachineClock();
  const std::int64_t wall = clock.NowNs();
  const std::int64_t cpu = clock.ThreadCpuNs();
  const StepReport& report = world.Step(inputs);
  const std::int64_t cpu_ns = clock.ThreadCpuNs() - cpu;
  const std::int64_t wall_ns = clock.NowNs() - wall;
  times.stats.Add(0, cpu_ns, wall_ns, wall_ns / kPeriodNs);
  times.over_1ms += wall_ns > kPeriodNs ? 1U : 0U;
  times.dropped += (report.flags & StepReport::kContactsFull) != 0 ? 1U : 0U;
  return {report, cpu_ns};
}

}  // namespace tandem
