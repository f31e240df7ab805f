#include "engine/paging/slow_pages.h"

#include <algorithm>
#include <utility>

#include "engine/realtime/clock.h"

namespace tandem {

SlowPages::SlowPages(std::shared_ptr<const PageSource> source, double bytes_per_s)
    : source_(std::move(source)), bytes_per_s_(bytes_per_s) {
  outline_ = source_->outline();
  counts_ = source_->counts();
}

std::optional<Error> SlowPages::Read(std::uint32_t record, VoxelPage& page,
                                     const std::stop_token& stop) const {
  const auto takes_ns =
      static_cast<std::int64_t>(1e9 * static_cast<double>(BytesOf(record)) / bytes_per_s_);
  LoopClock& clock = MachineClock();
  const std::int64_t now_ns = clock.NowNs();
  std::int64_t free_at_ns = free_at_ns_.load();
  while (!free_at_ns_.compare_exchange_weak(free_at_ns, std::max(now_ns, free_at_ns) + takes_ns)) {
  }
  const std::int64_t until_ns = std::max(now_ns, free_at_ns) + takes_ns;
  constexpr std::int64_t kNapNs = 10'000'000;
  for (std::int64_t at_ns = now_ns; at_ns < until_ns; at_ns = clock.NowNs()) {
    if (stop.stop_requested()) return Error{"stopped while a page was read"};
    clock.SleepUntil(std::min(until_ns, at_ns + kNapNs));
  }
  return source_->Read(record, page, stop);
}

}  // namespace tandem
