#pragma once

#include <atomic>
#include <chrono>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "engine/voxel/pages/kept_voxmap.h"
#include "tests/support/scratch_folder.h"

namespace tandem::testing {

/// Gives a voxmap's pages when the test lets it: after a time each, or never while it is closed.
class DelayedPages final : public PageSource {
 public:
  explicit DelayedPages(const Voxmap& whole) {
    const std::filesystem::path file = folder_.path() / "kept";
    TANDEM_CHECK(!KeepVoxmap(whole, BlockFileSources{}, file));
    auto pages = OpenKeptVoxmap(file, BlockFileSources{});
    TANDEM_CHECK(pages);
    pages_ = *pages;
    outline_ = pages_->outline();
    counts_ = pages_->counts();
  }

  bool HasPage(std::uint32_t record) const noexcept override { return pages_->HasPage(record); }
  std::uint64_t BytesOf(std::uint32_t record) const noexcept override {
    return pages_->BytesOf(record);
  }
  std::optional<Error> Read(std::uint32_t record, VoxelPage& page,
                            const std::stop_token& stop) const override {
    while (closed_ && !broken_ && !stop.stop_requested()) std::this_thread::sleep_for(kNap);
    if (broken_) return Error{"the disk is broken"};
    const std::chrono::microseconds takes(takes_us_.load());
    if (takes.count() > 0) std::this_thread::sleep_for(takes);
    {
      const std::lock_guard lock(reading_);
      order_.push_back(record);
    }
    return pages_->Read(record, page);
  }

  void Close() { closed_ = true; }
  void Open() { closed_ = false; }
  void Break() { broken_ = true; }
  void Take(std::chrono::microseconds time) { takes_us_ = time.count(); }
  /// Returns the records that were read, in their order.
  std::vector<std::uint32_t> order() const {
    const std::lock_guard lock(reading_);
    return order_;
  }

 private:
  static constexpr std::chrono::microseconds kNap{200};
  ScratchFolder folder_;
  std::shared_ptr<const PageSource> pages_;
  std::atomic<bool> closed_ = false;
  std::atomic<bool> broken_ = false;
  std::atomic<std::int64_t> takes_us_ = 0;
  mutable std::mutex reading_;
  mutable std::vector<std::uint32_t> order_;
};

}  // namespace tandem::testing
