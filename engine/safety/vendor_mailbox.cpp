#include "engine/safety/vendor_mailbox.h"

#include <algorithm>

#include "engine/safety/clamp_length.h"
#include "engine/safety/motor_guard.h"

namespace tandem {
namespace {

/// Time in which a force changes by a sixth of the limit.
constexpr std::int64_t kSlewNs = 1'000'000;
constexpr int kLooks = 16;

double ShareOf(std::int64_t passed_ns, std::int64_t of_ns) {
  return std::clamp(static_cast<double>(passed_ns) / static_cast<double>(of_ns), 0.0, 1.0);
}

}  // namespace

VendorMailbox::VendorMailbox(const DeviceLimits& limits) noexcept : limits_(ValidLimits(limits)) {}

void VendorMailbox::Put(const Wrench& F_D_W, std::int64_t now_ns) noexcept {
  const std::uint64_t turn = slot_.turn.load(std::memory_order_relaxed);
  slot_.turn.store(turn + 1, std::memory_order_relaxed);
  std::atomic_thread_fence(std::memory_order_release);
  slot_.ns.store(now_ns, std::memory_order_relaxed);
  for (int i = 0; i < 3; ++i) {
    slot_.wrench[i].store(F_D_W.tau[i], std::memory_order_relaxed);
    slot_.wrench[3 + i].store(F_D_W.f[i], std::memory_order_relaxed);
  }
  slot_.turn.store(turn + 2, std::memory_order_release);
}

void VendorMailbox::TakeNewest() noexcept {
  for (int look = 0; look < kLooks; ++look) {
    const std::uint64_t before = slot_.turn.load(std::memory_order_acquire);
    if (before == turn_ || before % 2 != 0) continue;
    Wrench wrench;
    const std::int64_t ns = slot_.ns.load(std::memory_order_relaxed);
    for (int i = 0; i < 3; ++i) {
      wrench.tau[i] = slot_.wrench[i].load(std::memory_order_relaxed);
      wrench.f[i] = slot_.wrench[3 + i].load(std::memory_order_relaxed);
    }
    std::atomic_thread_fence(std::memory_order_acquire);
    if (slot_.turn.load(std::memory_order_relaxed) != before) continue;
    turn_ = before;
    newest_ = wrench;
    put_ns_ = ns;
    return;
  }
}

void VendorMailbox::SeeFresh(std::int64_t now_ns) noexcept {
  const std::int64_t age_ns = std::max<std::int64_t>(0, now_ns - put_ns_);
  sum_age_ns_.fetch_add(age_ns, std::memory_order_relaxed);
  most_age_ns_.store(std::max(most_age_ns(), age_ns), std::memory_order_relaxed);
  taken_.fetch_add(1, std::memory_order_relaxed);
}

Wrench VendorMailbox::Take(std::int64_t now_ns) noexcept {
  const std::uint64_t before = turn_;
  TakeNewest();
  if (turn_ != before) SeeFresh(now_ns);
  const std::int64_t age_ns = put_ns_ < 0 ? MotorGuard::kZeroNs : now_ns - put_ns_;
  const bool stood = last_ns_ >= 0 && now_ns - last_ns_ > MotorGuard::kMostGapNs;
  const std::int64_t since_ns = last_ns_ < 0 ? 0 : now_ns - last_ns_;
  last_ns_ = now_ns;
  const std::uint32_t cuts = cuts_.load();
  const bool cut = cuts != cuts_seen_;
  cuts_seen_ = cuts;
  const bool sound = newest_.f.allFinite() && newest_.tau.allFinite();
  if (cut) put_ns_ = -1;  // older wrenches do not count
  if (cut || stood || !sound || age_ns >= MotorGuard::kZeroNs) {
    none_ = true;
    given_ = {};
    return given_;
  }
  if (none_) {  // a fresh wrench
    none_ = old_ = false;
    ramp_begin_ns_ = now_ns;
    short_begin_ns_ = now_ns - MotorGuard::kShortRampNs;
  }
  const bool old = age_ns >= MotorGuard::kDampingNs;
  if (old && !old_) ramped_ns_ = now_ns - ramp_begin_ns_;
  if (!old && old_) {
    ramp_begin_ns_ = now_ns - ramped_ns_;
    short_begin_ns_ = now_ns;
  }
  old_ = old;
  // the loop ramps too: its wrench after a stop has grown as slowly already
  const double share = old ? 0.0
                           : std::min(ShareOf(now_ns - ramp_begin_ns_, MotorGuard::kRampNs),
                                      ShareOf(now_ns - short_begin_ns_, MotorGuard::kShortRampNs));
  const double slews = static_cast<double>(since_ns) / static_cast<double>(kSlewNs);
  bool held = false;
  given_.f = StepTowards(given_.f, ClampLength(share * newest_.f, limits_.force, held),
                         slews * limits_.force / MotorGuard::kSlewTicks, held);
  given_.tau = StepTowards(given_.tau, ClampLength(share * newest_.tau, limits_.moment, held),
                           slews * limits_.moment / MotorGuard::kSlewTicks, held);
  return given_;
}

std::int64_t VendorMailbox::mean_age_ns() const noexcept {
  const auto count = static_cast<std::int64_t>(taken());
  return count == 0 ? 0 : sum_age_ns_.load(std::memory_order_relaxed) / count;
}

}  // namespace tandem
