#include "engine/paging/prefetch_thread.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "engine/realtime/clock.h"

namespace tandem {

namespace {

constexpr std::int64_t kNapNs = 200'000;  // while there is nothing to do
constexpr double kNear = 64;  // voxels: what is nearer goes for nothing but what is read

/// The more urgent one of a heap's two.
bool IsLater(const PageRequest& a, const PageRequest& b) {
  if (a.hint != b.hint) return a.hint;
  return a.due != b.due ? a.due > b.due : a.record > b.record;
}

}  // namespace

PrefetchThread::PrefetchThread(std::shared_ptr<const PageSource> source, VoxelArena& arena,
                               PageMail& mail, std::vector<std::unique_ptr<ShellBox>>& boxes)
    : source_(std::move(source)),
      arena_(&arena),
      mail_(&mail),
      boxes_(&boxes),
      place_of_(arena.voxmap().header().record_count),
      state_(place_of_.size(), State::kAbsent),
      reserve_(arena.frames() / 16) {
  const VoxmapHeader& h = arena.voxmap().header();
  const std::uint32_t* record = arena.voxmap().index();
  for (std::uint32_t z = 0; z < h.size[2]; ++z) {
    for (std::uint32_t y = 0; y < h.size[1]; ++y) {
      for (std::uint32_t x = 0; x < h.size[0]; ++x, ++record) {
        place_of_[*record] = {static_cast<std::int32_t>(x), static_cast<std::int32_t>(y),
                              static_cast<std::int32_t>(z)};
      }
    }
  }
}

PrefetchThread::~PrefetchThread() = default;

void PrefetchThread::Start() {
  X_SV_.resize(boxes_->size());
  thread_ = std::jthread([this](const std::stop_token& stop) {
    Run(stop);
  });
}

ResidentCounts PrefetchThread::counts() const noexcept {
  return {pages_read_.load(), pages_given_up_.load(), most_pages_.load(), most_frames_.load()};
}

void PrefetchThread::Run(const std::stop_token& stop) {
  LoopClock& clock = MachineClock();
  while (!stop.stop_requested()) {
    TakeMail();
    for (std::size_t b = 0; b < boxes_->size(); ++b) X_SV_[b] = (*boxes_)[b]->X_VS.Read().Inverse();
    if (!failed_ && BringIn(stop)) continue;
    idle_.store(asked_back_ == 0 || starving_, std::memory_order_release);
    clock.SleepUntil(clock.NowNs() + kNapNs);
  }
}

void PrefetchThread::Want(const PageRequest& request) {
  state_[request.record] = State::kWanted;
  wanted_.push_back(request);
  std::push_heap(wanted_.begin(), wanted_.end(), IsLater);
}

void PrefetchThread::TakeVerdicts() {
  PageVerdict verdict;
  while (mail_->verdicts.TryPop(verdict)) {
    --asked_back_;
    if (!verdict.goes) {
      state_[verdict.record] = State::kThere;
      starving_ = true;
      continue;
    }
    starving_ = false;
    arena_->Remove(verdict.record);
    state_[verdict.record] = State::kAbsent;
    there_.erase(std::find(there_.begin(), there_.end(), verdict.record));
    ++pages_given_up_;
  }
}

void PrefetchThread::TakeMail() {
  TakeVerdicts();
  PageRequest request;
  while (mail_->requests.TryPop(request)) {
    idle_.store(false, std::memory_order_release);
    // who lets go of a page and asks for it again says so in this order
    if (state_[request.record] == State::kAskedBack) TakeVerdicts();
    // of what is there the news is on its way
    const bool on_its_way = state_[request.record] == State::kThere ||
                            state_[request.record] == State::kAskedBack ||
                            page_of_ == static_cast<std::int64_t>(request.record);
    if (!on_its_way) Want(request);
  }
  std::size_t said = 0;
  while (said < unsaid_.size() && mail_->news.TryPush(unsaid_[said])) ++said;
  unsaid_.erase(unsaid_.begin(), unsaid_.begin() + static_cast<std::ptrdiff_t>(said));
}

void PrefetchThread::Tell(const PageNews& news) {
  if (!unsaid_.empty() || !mail_->news.TryPush(news)) unsaid_.push_back(news);
}

double PrefetchThread::DistanceOf(std::uint32_t record) const {
  const double s = arena_->voxmap().voxel_size();
  const GridIndex& at = place_of_[record];
  const Vec3 centre = kHyperchunkSide * s * (Vec3(at.x, at.y, at.z) + Vec3::Constant(0.5));
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t b = 0; b < X_SV_.size(); ++b) {
    const ShellBox& box = *(*boxes_)[b];
    const Vec3 beyond = ((X_SV_[b] * centre - box.centre).cwiseAbs() - box.half_size).cwiseMax(0.0);
    least = std::min(least, beyond.norm() / s);
  }
  constexpr double kBall = 0.87 * kHyperchunkSide;  // that holds a hyperchunk
  return least - kBall;
}

std::size_t PrefetchThread::AskBack(double beyond) {
  // the haptic thread hears that a page is there before it is asked to let it go
  if (!unsaid_.empty()) return 0;
  // a batch at a time, so that distances are not found again for each page
  const std::size_t most = PageMail::kMostAskedBack - asked_back_;
  std::vector<std::pair<double, std::uint32_t>> far;
  for (const std::uint32_t record : there_) {
    if (state_[record] != State::kThere) continue;
    const double distance = DistanceOf(record);
    if (distance > beyond) far.emplace_back(distance, record);
  }
  const std::size_t count = std::min({most, far.size(), std::size_t{1} + there_.size() / 16});
  std::partial_sort(far.begin(), far.begin() + static_cast<std::ptrdiff_t>(count), far.end(),
                    std::greater<>());
  std::size_t asked = 0;
  while (asked < count && mail_->asked_back.TryPush(far[asked].second)) {
    state_[far[asked].second] = State::kAskedBack;
    ++asked;
  }
  asked_back_ += asked;
  return asked;
}

bool PrefetchThread::BringIn(const std::stop_token& stop) {
  if (page_of_ < 0) {
    while (!wanted_.empty() && state_[wanted_.front().record] != State::kWanted) {
      std::pop_heap(wanted_.begin(), wanted_.end(), IsLater);
      wanted_.pop_back();
    }
    if (wanted_.empty()) {
      // room for what comes next
      if (arena_->free_frames() < reserve_ && asked_back_ == 0) AskBack(kNear);
      return false;
    }
    const PageRequest next = wanted_.front();
    if (next.hint && arena_->free_frames() < reserve_) {
      if (asked_back_ > 0) return false;
      if (AskBack(std::max(kNear, DistanceOf(next.record) + kHyperchunkSide)) > 0) return false;
      state_[next.record] = State::kAbsent;
      Tell({next.record, false});
      return true;
    }
    std::pop_heap(wanted_.begin(), wanted_.end(), IsLater);
    wanted_.pop_back();
    if (const auto fault = source_->Read(next.record, page_, stop)) {
      fault_ = fault->what;
      failed_.store(true, std::memory_order_release);
      return false;
    }
    page_of_ = next.record;
  }
  const auto record = static_cast<std::uint32_t>(page_of_);
  if (!arena_->Put(record, page_)) {
    if (asked_back_ == 0) AskBack(-std::numeric_limits<double>::infinity());
    return false;
  }
  page_of_ = -1;
  state_[record] = State::kThere;
  there_.push_back(record);
  ++pages_read_;
  most_pages_ = std::max<std::uint64_t>(most_pages_, there_.size());
  most_frames_ = std::max<std::uint64_t>(most_frames_, arena_->frames() - arena_->free_frames());
  Tell({record, true});
  // ahead of time, so that nothing waits for room
  if (arena_->free_frames() < reserve_ && asked_back_ == 0) AskBack(kNear);
  return true;
}

}  // namespace tandem
