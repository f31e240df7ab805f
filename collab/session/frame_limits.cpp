#include "collab/session/frame_limits.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace tandem {

namespace {

constexpr std::array kBits{StepReport::kTravelLimited, StepReport::kOverCapacity,
                           StepReport::kContactsFull, StepReport::kWaitsForVoxels};
// seven bits for each limit but the last, above those of StateFlag and ViewBody
constexpr std::uint32_t kFirstBit = 9;
constexpr std::uint32_t kBitsEach = 7;
constexpr std::uint32_t kMostPercent = 100;
constexpr std::uint32_t kInPercent = 3;  // limits that are sent in percent
constexpr std::uint32_t kWaited = 0x80000000U;
static_assert((kStateParked >> kFirstBit) == 0 && (ViewBody::kTrapped >> kFirstBit) == 0);
constexpr std::uint32_t kLastBit = kFirstBit + kBitsEach * kInPercent;
static_assert(kLastBit <= 32 && kStateLoose >> kLastBit != 0 && kMostPercent >> kBitsEach == 0);

std::array<double, 4> Shares(const FrameLimits& limits) {
  return {limits.travel_limited, limits.over_capacity, limits.contacts_full, limits.waited};
}

std::string Percent(double share) {
  std::array<char, 32> text{};
  const double percent = 1e2 * share;
  std::snprintf(text.data(), text.size(), percent >= 1 ? "%.0f %%" : "%.1g %%", percent);
  return text.data();
}

}  // namespace

void FrameLimitCount::Count(std::uint32_t flags) noexcept {
  for (Tally* tally : {&all_, &window_}) {
    ++tally->frames;
    for (std::size_t k = 0; k < kBits.size(); ++k) {
      tally->limited[k] += (flags & kBits[k]) != 0 ? 1 : 0;
    }
  }
  if (window_.frames < kWindow) return;
  last_ = SharesOf(window_);
  window_ = {};
}

FrameLimits FrameLimitCount::SharesOf(const Tally& tally) noexcept {
  const auto frames = static_cast<double>(std::max<std::int64_t>(1, tally.frames));
  return {static_cast<double>(tally.limited[0]) / frames,
          static_cast<double>(tally.limited[1]) / frames,
          static_cast<double>(tally.limited[2]) / frames,
          static_cast<double>(tally.limited[3]) / frames};
}

std::uint32_t AsFlags(const FrameLimits& limits) noexcept {
  std::uint32_t flags = 0;
  std::uint32_t bit = kFirstBit;
  const std::array<double, 4> shares = Shares(limits);
  for (std::uint32_t k = 0; k < kInPercent; ++k) {
    const double percent = std::clamp(1e2 * shares[k], 0.0, static_cast<double>(kMostPercent));
    const double rounded = percent > 0 ? std::max(1.0, std::round(percent)) : 0.0;
    flags |= static_cast<std::uint32_t>(rounded) << bit;
    bit += kBitsEach;
  }
  if (limits.waited > 0) flags |= kWaited;
  return flags;
}

FrameLimits LimitsIn(std::uint32_t flags) noexcept {
  const auto share = [flags](std::uint32_t k) {
    const std::uint32_t percent = (flags >> (kFirstBit + k * kBitsEach)) & ((1U << kBitsEach) - 1U);
    return 1e-2 * std::min(percent, kMostPercent);
  };
  return {share(0), share(1), share(2), (flags & kWaited) != 0 ? 1e-2 : 0.0};
}

FrameLimits LimitsOf(const std::vector<ViewBody>& bodies) noexcept {
  const auto held = std::find_if(bodies.begin(), bodies.end(), [](const ViewBody& body) {
    return (body.flags & ViewBody::kHeld) != 0;
  });
  return held == bodies.end() ? FrameLimits{} : LimitsIn(held->flags);
}

std::string AsText(const FrameLimits& limits) {
  constexpr std::array kNames{"slowed ", "over capacity ", "contacts left out ",
                              "waits for voxels"};
  const std::array<double, 4> shares = Shares(limits);
  std::string text;
  for (std::size_t k = 0; k < shares.size(); ++k) {
    if (shares[k] <= 0) continue;
    text += (text.empty() ? "" : ", ") + std::string(kNames[k]);
    if (k < kInPercent) text += Percent(shares[k]);
  }
  return text;
}

std::vector<std::string> Explain(const FrameLimits& limits) {
  std::vector<std::string> lines;
  if (limits.travel_limited > 0) {
    lines.push_back("in " + Percent(limits.travel_limited) +
                    " of the frames the travel limit slowed a body near others, so that it passes "
                    "through nothing: it moved slower than it was pulled; larger voxels let it go "
                    "faster");
  }
  if (limits.over_capacity > 0) {
    lines.push_back(
        "in " + Percent(limits.over_capacity) +
        " of the frames point tests took so much time that bodies had to move slower still; "
        "larger voxels or more --threads help");
  }
  if (limits.contacts_full > 0) {
    lines.push_back("in " + Percent(limits.contacts_full) +
                    " of the frames a pair of bodies had more contacts than there is room for: the "
                    "rest did not push, so bodies may sink into one another; larger voxels help");
  }
  if (limits.waited > 0) {
    lines.push_back(
        "in some frames voxels were not in memory: nothing moved and no force was felt until they "
        "were; a larger --voxel-memory or a faster disk helps");
  }
  return lines;
}

}  // namespace tandem
