#pragma once

#include <atomic>
#include <memory>

#include "engine/voxel/map/page_source.h"

namespace tandem {

/// Gives the pages of another source at the rate of a slow disk: each takes the time of its bytes,
/// one after another. For tests and measurements.
class SlowPages final : public PageSource {
 public:
  SlowPages(std::shared_ptr<const PageSource> source, double bytes_per_s);

  bool HasPage(std::uint32_t record) const noexcept override { return source_->HasPage(record); }
  std::uint64_t BytesOf(std::uint32_t record) const noexcept override {
    return source_->BytesOf(record);
  }
  std::optional<Error> Read(std::uint32_t record, VoxelPage& page,
                            const std::stop_token& stop) const override;

 private:
  std::shared_ptr<const PageSource> source_;
  double bytes_per_s_;
  mutable std::atomic<std::int64_t> free_at_ns_{0};
};

}  // namespace tandem
