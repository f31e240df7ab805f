#include "engine/paging/resident_voxels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <utility>

#include "engine/realtime/clock.h"

namespace tandem {

namespace {

constexpr std::size_t kLeastFrames = 256;  // 1 MB
constexpr std::uint32_t kSooner = 8;  // frames; a request is repeated only if it is sooner by this

std::uint64_t InMiB(std::uint64_t bytes) {
  return (bytes + (1U << 20U) - 1) >> 20U;
}

}  // namespace

std::optional<Error> ResidentVoxels::BudgetFault(const PageSource& source,
                                                 std::uint64_t budget_bytes) {
  const std::uint64_t least =
      VoxelArena::FixedBytes(source.outline()) + kLeastFrames * VoxelArena::kFrameBytes;
  if (budget_bytes >= least) return std::nullopt;
  char text[160];
  std::snprintf(text, sizeof text,
                "a voxel memory of %lluM is too small for this scene: it needs at least %lluM",
                static_cast<unsigned long long>(budget_bytes >> 20U),
                static_cast<unsigned long long>(InMiB(least)));
  return Error{text};
}

Result<std::unique_ptr<ResidentVoxels>> ResidentVoxels::Make(
    std::shared_ptr<const PageSource> source, std::uint64_t budget_bytes) {
  if (auto fault = BudgetFault(*source, budget_bytes)) return *fault;
  const std::uint64_t fixed = VoxelArena::FixedBytes(source->outline());
  constexpr std::uint64_t kMostFrames = std::uint64_t{1} << 22U;  // 16 GiB
  const std::uint64_t frames = (budget_bytes - fixed) / VoxelArena::kFrameBytes;
  return std::unique_ptr<ResidentVoxels>(
      new ResidentVoxels(std::move(source), std::min(frames, kMostFrames)));
}

ResidentVoxels::ResidentVoxels(std::shared_ptr<const PageSource> source, std::size_t frames)
    : arena_(source->outline(), frames),
      has_page_(arena_.voxmap().header().record_count),
      there_(has_page_.size(), 0),
      requested_(has_page_.size()),
      thread_(source, arena_, mail_, boxes_) {
  for (std::uint32_t r = 0; r < has_page_.size(); ++r) has_page_[r] = source->HasPage(r) ? 1 : 0;
}

ResidentVoxels::~ResidentVoxels() = default;

VoxelReader& ResidentVoxels::AddReader(const Vec3& centre, const Vec3& half_size) {
  boxes_.push_back(std::make_unique<ShellBox>());
  boxes_.back()->centre = centre;
  boxes_.back()->half_size = half_size;
  readers_.push_back(std::make_unique<VoxelReader>(*this, *boxes_.back()));
  return *readers_.back();
}

bool ResidentVoxels::Ask(std::uint32_t record, std::uint32_t frames, bool hint) noexcept {
  const std::uint32_t due = frame_ + frames;
  RequestedPage& requested = requested_[record];
  const bool known = requested.due != 0 && (hint || !requested.hint);
  if (known && due + kSooner > requested.due) return true;
  if (!mail_.requests.TryPush({record, due, hint})) return false;
  ++requests_;
  outstanding_ += requested.due == 0 ? 1 : 0;
  requested = {due, hint && (requested.due == 0 || requested.hint)};
  return true;
}

void ResidentVoxels::TakeUpdates() noexcept {
  PageUpdate update;
  while (mail_.news.TryPop(update)) {
    there_[update.record] = update.there ? 1 : 0;
    outstanding_ -= requested_[update.record].due != 0 ? 1 : 0;
    requested_[update.record] = {};
  }
}

void ResidentVoxels::BeginFrame() noexcept {
  ++frame_;
  TakeUpdates();
  constexpr int kMostVerdicts = 32;  // greatest number in a frame
  for (int k = 0; k < kMostVerdicts; ++k) {
    const std::uint32_t* back = mail_.asked_back.Front();
    if (back == nullptr) break;
    TakeUpdates();  // the update that it has come was sent before it was asked back
    const std::uint32_t record = *back;
    const bool goes = std::all_of(readers_.begin(), readers_.end(), [record](const auto& reader) {
      return !reader->active_ ||
             reader->travelled_ - reader->announced_at_[record] > VoxelReader::kKeptTravel;
    });
    if (!mail_.verdicts.TryPush({record, goes})) break;
    if (goes) there_[record] = 0;
    mail_.asked_back.Drop();
  }
}

void ResidentVoxels::WaitUntilResident() noexcept {
  LoopClock& clock = MachineClock();
  constexpr std::int64_t kNapNs = 100'000;
  constexpr std::int64_t kPatienceNs = 2'000'000'000;  // for one page
  std::uint64_t pages = counts().pages_read;
  std::int64_t since_ns = clock.NowNs();
  for (;;) {
    const bool idle = thread_.IsIdleAfter(requests_);
    BeginFrame();
    if (outstanding_ == 0 || fault() != nullptr || idle) return;
    const std::uint64_t now = counts().pages_read;
    if (std::exchange(pages, now) != now) since_ns = clock.NowNs();
    if (clock.NowNs() - since_ns > kPatienceNs) return;
    clock.SleepUntil(clock.NowNs() + kNapNs);
  }
}

VoxelReader::VoxelReader(ResidentVoxels& voxels, ShellBox& box)
    : voxels_(&voxels),
      box_(&box),
      announced_at_(voxels.has_page_.size(), -std::numeric_limits<double>::infinity()) {}

void VoxelReader::MoveTo(const Pose& X_VS, double travel_voxels) noexcept {
  if (!active_) box_->there.store(true, std::memory_order_relaxed);
  active_ = true;
  if (std::isfinite(travel_voxels)) travelled_ += travel_voxels;
  box_->X_VS.back() = X_VS;
  box_->X_VS.Publish();
}

bool VoxelReader::Leave() noexcept {
  if (active_) box_->there.store(false, std::memory_order_relaxed);
  return std::exchange(active_, false);
}

template <typename Visit>
void VoxelReader::VisitPages(const Vec3& centre, double radius, const Visit& visit) noexcept {
  const Voxmap& map = voxels_->voxmap();
  const auto& size = map.header().size;
  std::array<std::int32_t, 3> low;
  std::array<std::int32_t, 3> high;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double at = centre[static_cast<Eigen::Index>(axis)];
    const double last = static_cast<double>(size[axis]) - 1;
    low[axis] = static_cast<std::int32_t>(
        std::clamp(std::floor((at - radius) / kHyperchunkSide), 0.0, last));
    high[axis] = static_cast<std::int32_t>(
        std::clamp(std::floor((at + radius) / kHyperchunkSide), 0.0, last));
  }
  for (std::int32_t z = low[2]; z <= high[2]; ++z) {
    for (std::int32_t y = low[1]; y <= high[1]; ++y) {
      for (std::int32_t x = low[0]; x <= high[0]; ++x) {
        const std::size_t cell = static_cast<std::size_t>(x) +
                                 size[0] * (static_cast<std::size_t>(y) +
                                            std::size_t{size[1]} * static_cast<std::size_t>(z));
        const std::uint32_t record = map.index()[cell];
        if (voxels_->has_page_[record] != 0) visit(record);
      }
    }
  }
}

bool VoxelReader::Announce(const Vec3& centre, double radius, std::uint32_t frames) noexcept {
  bool all = true;
  VisitPages(centre, radius, [&](std::uint32_t record) {
    announced_at_[record] = travelled_;
    if (voxels_->there_[record] != 0) return;
    all = false;
    voxels_->Ask(record, frames, false);
  });
  return all;
}

bool VoxelReader::Hint(const Vec3& centre, double radius, std::uint32_t frames) noexcept {
  bool all = true;
  VisitPages(centre, radius, [&](std::uint32_t record) {
    if (voxels_->there_[record] == 0) all = voxels_->Ask(record, frames, true) && all;
  });
  return all;
}

}  // namespace tandem
