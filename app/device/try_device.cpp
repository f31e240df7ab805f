#include "app/device/try_device.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>

#include <dlfcn.h>
#include <nlohmann/json.hpp>

#include "app/device/open_driver.h"
#include "engine/base/text/json_text.h"
#include "engine/haptics/device_loop.h"
#include "engine/realtime/clock.h"
#include "engine/realtime/histogram.h"

namespace tandem {
namespace {

nlohmann::ordered_json Microseconds(const Histogram& times) {
  const auto us = [](std::int64_t ns) {
    return 1e-3 * static_cast<double>(ns);
  };
  return {{"p50", us(times.Quantile(0.5))},
          {"p99", us(times.Quantile(0.99))},
          {"max", us(times.max())}};
}

/// Counts the loop's allocations if `count-allocations.so` was loaded with this program.
class AllocationCount {
 public:
  AllocationCount() {
    const auto find = [](const char* name) {
      return dlsym(RTLD_DEFAULT, name);
    };
    switch_ = reinterpret_cast<void (*)(int)>(find("tandem_count_allocations"));
    count_ = reinterpret_cast<long (*)()>(find("tandem_allocations"));
  }
  void Begin() const {
    if (switch_ != nullptr) switch_(1);
  }
  void End() {
    if (switch_ == nullptr || count_ == nullptr) return;
    switch_(0);
    total_ += count_();
  }
  nlohmann::json total() const {
    return count_ == nullptr ? nlohmann::json() : nlohmann::json(total_);
  }

 private:
  void (*switch_)(int) = nullptr;
  long (*count_)() = nullptr;
  long total_ = 0;
};

}  // namespace

Result<std::string> TryDevice(const std::string& requested, double seconds) {
  Result<std::unique_ptr<DriverDevice>> opened = OpenDriver(requested, Pose{});
  if (!opened) return opened.error();
  DriverDevice& device = **opened;
  const DeviceCapabilities can = device.capabilities();
  const std::int64_t period_ns = DeviceLoop::PeriodOf(can.rate_hz);
  const std::int64_t begun_ns = MonotonicNowNs();
  const auto count = static_cast<std::int64_t>(1e9 * seconds / static_cast<double>(period_ns));
  AllocationCount allocations;
  Histogram reads, writes;
  std::map<std::string, std::int64_t> troubles;
  std::int64_t repeated = 0;
  std::int64_t failed = 0;
  bool clutch = false;
  bool stop = false;
  double moved = 0;   // m; largest distance from the handle's first place
  double turned = 0;  // rad
  const Anchor first = device.Read();
  device.Start();
  for (std::int64_t tick = 1; tick <= count; ++tick) {
    MachineClock().SleepUntil(begun_ns + tick * period_ns);
    allocations.Begin();
    const std::int64_t read_ns = MonotonicNowNs();
    const Anchor handle = device.Read();
    const std::int64_t written_ns = MonotonicNowNs();
    device.Render({});
    allocations.End();
    reads.Add(written_ns - read_ns);
    writes.Add(MonotonicNowNs() - written_ns);
    repeated += device.newest_read() == TANDEM_REPEATED ? 1 : 0;
    if (device.failed()) {
      ++failed;
      if (failed % 100 == 1) ++troubles[device.Trouble()];
    }
    clutch = clutch || device.clutch_button();
    stop = stop || device.stop_button();
    moved = std::max(moved, (handle.X_WA.p - first.X_WA.p).norm());
    turned = std::max(turned, handle.X_WA.q.angularDistance(first.X_WA.q));
  }
  device.Stop();
  nlohmann::ordered_json why = nlohmann::ordered_json::array();
  for (const auto& [trouble, times] : troubles) why.push_back(trouble);
  return JsonText(nlohmann::ordered_json{{"device", requested},
                                         {"tandem", TANDEM_VERSION},
                                         {"freedoms_in", can.freedoms_in},
                                         {"freedoms_out", can.freedoms_out},
                                         {"peak_force_N", can.peak.force},
                                         {"peak_moment_Nm", can.peak.moment},
                                         {"rate_hz", can.rate_hz},
                                         {"asks", can.asks_us},
                                         {"ticks", count},
                                         {"read_us", Microseconds(reads)},
                                         {"write_us", Microseconds(writes)},
                                         {"allocations", allocations.total()},
                                         {"repeated", repeated},
                                         {"failed", failed},
                                         {"troubles", why},
                                         {"moved_mm", 1000 * moved},
                                         {"turned_deg", turned * 180 / M_PI},
                                         {"clutch_button", clutch},
                                         {"stop_button", stop}},
                  2);
}

}  // namespace tandem
