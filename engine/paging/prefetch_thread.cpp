#include "engine/paging/prefetch_thread.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "engine/realtime/clock.h"

namespace tandem {

namespace {

constexpr std::int64_t kNapNs = 200'000;     // pause while there is nothing to do
constexpr std::int64_t kKeptNs = 5'000'000;  // time before a page is asked back again
constexpr double kNear = 64;  // voxels; nearer pages leave only for pages that are read

/// Tells whether the first request is less urgent than the second.
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
      kept_(place_of_.size(), 0),
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
  return {pages_read_.load(), pages_given_up_.load(), most_pages_.load()};
}

void PrefetchThread::Run(const std::stop_token& stop) {
  LoopClock& clock = MachineClock();
  while (!stop.stop_requested()) {
    TakeMail();
    for (std::size_t b = 0; b < boxes_->size(); ++b) X_SV_[b] = (*boxes_)[b]->X_VS.Read().Inverse();
    if (!failed_ && LoadNext(stop)) continue;
    // one more page may be asked back while all pages are kept
    const bool idle = !waiting_ && wanted_.empty() && asked_back_ == 0;
    if (idle || starving_ || failed_)
      idle_since_taken_.store(requests_taken_ + 1, std::memory_order_release);
    clock.SleepUntil(clock.NowNs() + kNapNs);
  }
}

void PrefetchThread::AddRequest(const PageRequest& request) {
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
      kept_[verdict.record] = 1;
      continue;
    }
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
    // a haptic thread that lets go of a page and asks for it again says so in this order
    if (state_[request.record] == State::kAskedBack) TakeVerdicts();
    // for a page in memory the news is on its way
    const bool on_its_way = state_[request.record] == State::kThere ||
                            state_[request.record] == State::kAskedBack ||
                            (waiting_ && waiting_->record == request.record && !waiting_->hint);
    if (!on_its_way) AddRequest(request);
    ++requests_taken_;
  }
  std::size_t sent = 0;
  while (sent < unsent_.size() && mail_->news.TryPush(unsent_[sent])) ++sent;
  unsent_.erase(unsent_.begin(), unsent_.begin() + static_cast<std::ptrdiff_t>(sent));
}

void PrefetchThread::Notify(const PageUpdate& news) {
  if (!unsent_.empty() || !mail_->news.TryPush(news)) unsent_.push_back(news);
}

double PrefetchThread::DistanceOf(std::uint32_t record) const {
  const double s = arena_->voxmap().voxel_size();
  const GridIndex& at = place_of_[record];
  const Vec3 centre = kHyperchunkSide * s * (Vec3(at.x, at.y, at.z) + Vec3::Constant(0.5));
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t b = 0; b < X_SV_.size(); ++b) {
    const ShellBox& box = *(*boxes_)[b];
    if (!box.there.load(std::memory_order_relaxed)) continue;
    const Vec3 beyond = ((X_SV_[b] * centre - box.centre).cwiseAbs() - box.half_size).cwiseMax(0.0);
    least = std::min(least, beyond.norm() / s);
  }
  constexpr double kBall = 0.87 * kHyperchunkSide;  // radius of a ball that holds a hyperchunk
  return least - kBall;
}

std::size_t PrefetchThread::RequestRelease(double beyond) {
  // the haptic thread must hear that a page has come before it is asked to let it go
  if (!unsent_.empty() || asked_back_ > 0) return 0;
  // pages that were kept may leave after a while, when a shell has moved
  const std::int64_t now_ns = MachineClock().NowNs();
  if (now_ns - kept_since_ns_ > kKeptNs) {
    kept_.assign(kept_.size(), 0);
    kept_since_ns_ = now_ns;
  }
  // a batch at a time, so that distances are not computed again for each page
  std::vector<std::pair<double, std::uint32_t>> far;
  for (const std::uint32_t record : there_) {
    if (state_[record] != State::kThere || kept_[record] != 0) continue;
    const double distance = DistanceOf(record);
    if (distance > beyond) far.emplace_back(distance, record);
  }
  const std::size_t count =
      std::min({PageMail::kMostAskedBack, far.size(), std::size_t{1} + there_.size() / 16});
  std::partial_sort(far.begin(), far.begin() + static_cast<std::ptrdiff_t>(count), far.end(),
                    std::greater<>());
  std::size_t requested = 0;
  while (requested < count && mail_->asked_back.TryPush(far[requested].second)) {
    state_[far[requested].second] = State::kAskedBack;
    ++requested;
  }
  asked_back_ += requested;
  return requested;
}

void PrefetchThread::EvictPages() {
  if (arena_->free_frames() >= reserve_ || asked_back_ > 0) return;
  const std::int64_t now_ns = MachineClock().NowNs();
  if (now_ns < next_room_ns_) return;
  if (RequestRelease(kNear) == 0) next_room_ns_ = now_ns + kKeptNs;
}

void PrefetchThread::Refuse(std::uint32_t record) {
  state_[record] = State::kAbsent;
  Notify({record, false});
}

bool PrefetchThread::ReadNext(const std::stop_token& stop) {
  while (!wanted_.empty() && state_[wanted_.front().record] != State::kWanted) {
    std::pop_heap(wanted_.begin(), wanted_.end(), IsLater);
    wanted_.pop_back();
  }
  if (wanted_.empty()) {
    EvictPages();
    return false;
  }
  const PageRequest next = wanted_.front();
  if (next.hint && arena_->free_frames() < reserve_) {
    // no page that is as near leaves for it
    if (asked_back_ > 0) return false;
    if (RequestRelease(std::max(kNear, DistanceOf(next.record) + kHyperchunkSide)) > 0)
      return false;
    Refuse(next.record);
    return true;
  }
  std::pop_heap(wanted_.begin(), wanted_.end(), IsLater);
  wanted_.pop_back();
  if (const auto fault = source_->Read(next.record, page_, stop)) {
    if (next.hint) {
      Refuse(next.record);
      return true;
    }
    fault_ = fault->what;
    failed_.store(true, std::memory_order_release);
    return false;
  }
  waiting_ = next;
  return true;
}

bool PrefetchThread::LoadNext(const std::stop_token& stop) {
  if (!waiting_ && !ReadNext(stop)) return false;
  if (!waiting_) return true;
  const PageRequest request = *waiting_;
  if (!arena_->Put(request.record, page_)) {
    if (request.hint) {
      waiting_.reset();
      Refuse(request.record);
      return true;
    }
    if (!wanted_.empty() && IsLater(request, wanted_.front())) {
      // a more urgent request may need less room
      waiting_.reset();
      AddRequest(request);
      return true;
    }
    const bool requested =
        asked_back_ > 0 || RequestRelease(-std::numeric_limits<double>::infinity()) > 0;
    starving_ = !requested;
    return false;
  }
  waiting_.reset();
  starving_ = false;
  state_[request.record] = State::kThere;
  there_.push_back(request.record);
  ++pages_read_;
  most_pages_ = std::max<std::uint64_t>(most_pages_, there_.size());
  Notify({request.record, true});
  EvictPages();
  return true;
}

}  // namespace tandem
