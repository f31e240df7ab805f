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

std::optional<Error> SlowPages::Read(std::uint32_t record, VoxelPage& page) const {
  const auto takes_ns =
      static_cast<std::int64_t>(1e9 * static_cast<double>(BytesOf(record)) / bytes_per_s_);
  LoopClock& clock = MachineClock();
  const std::int64_t now_ns = clock.NowNs();
  std::int64_t free_at_ns = free_at_ns_.load();
  while (!free_at_ns_.compare_exchange_weak(free_at_ns, std::max(now_ns, free_at_ns) + takes_ns)) {
  }
  clock.SleepUntil(std::max(now_ns, free_at_ns) + takes_ns);
  return source_->Read(record, page);
}

}  // namespace tandem
