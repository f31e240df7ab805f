#include "engine/realtime/frame_stats.h"

#include <array>
#include <cstdio>

namespace tandem {
namespace {

std::string InMicroseconds(const char* name, const Histogram& times) {
  std::array<char, 120> text{};
  std::snprintf(text.data(), text.size(), ", %s %.1f / %.1f / %.1f us", name,
                1e-3 * static_cast<double>(times.Quantile(0.5)),
                1e-3 * static_cast<double>(times.Quantile(0.99)),
                1e-3 * static_cast<double>(times.max()));
  return text.data();
}

}  // namespace

void FrameStats::Add(std::int64_t lateness_ns, std::int64_t cpu_ns, std::int64_t wall_ns,
                     std::int64_t skipped) noexcept {
  lateness_.Add(lateness_ns);
  cpu_.Add(cpu_ns);
  wall_.Add(wall_ns);
  missed_ += static_cast<std::uint64_t>(skipped);
}

std::string FrameStats::Summary() const {
  return std::to_string(frames()) + " frames, " + std::to_string(missed_) + " missed" +
         InMicroseconds("cpu", cpu_) + InMicroseconds("wall", wall_) +
         InMicroseconds("late", lateness_);
}

}  // namespace tandem
