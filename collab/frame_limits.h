#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "collab/messages.h"
#include "engine/world/step_inputs.h"

namespace tandem {

/// In which share of its frames a peer's simulation gave something up, 0 to 1: what the bits of
/// StepReport come to.
struct FrameLimits {
  double travel_limited = 0;  // a body was held back to its travel limit
  double over_capacity = 0;   // point tests left room for less travel than half a voxel
  double contacts_full = 0;   // contacts beyond the room for them did not push
  double waited = 0;          // voxels were not in memory: nothing moved and no force was felt

  friend bool operator==(const FrameLimits&, const FrameLimits&) = default;
};

/// Counts them, over all frames and over the last whole second. Neither allocates nor locks.
class FrameLimitCount {
 public:
  /// A frame's StepReport::flags.
  void Count(std::uint32_t flags) noexcept;
  /// Of all frames so far.
  FrameLimits all() const noexcept { return SharesOf(all_); }
  /// Of the last thousand frames that were full; none before there are as many.
  const FrameLimits& last() const noexcept { return last_; }

 private:
  static constexpr std::int64_t kWindow = 1000;  // frames
  struct Tally {
    std::int64_t frames = 0;
    std::array<std::int64_t, 4> limited{};
  };
  static FrameLimits SharesOf(const Tally& tally) noexcept;

  Tally all_;
  Tally window_;
  FrameLimits last_;
};

/// In whole percent, of which none that is above 0 becomes 0, in bits that the flags of an
/// ObjectState and of a ViewBody have to spare; of waiting only whether there was any, as 1 %.
std::uint32_t AsFlags(const FrameLimits& limits) noexcept;
FrameLimits LimitsIn(std::uint32_t flags) noexcept;
/// Of what a peer holds; nothing of one with an empty hand.
FrameLimits LimitsOf(const std::vector<ViewBody>& bodies) noexcept;

/// "slowed 12 %, over capacity 3 %, contacts left out 1 %, waits for voxels": those above 0;
/// empty if none is.
std::string AsText(const FrameLimits& limits);
/// A line for each that is above 0: what share of the frames, what it means and what helps.
std::vector<std::string> Explain(const FrameLimits& limits);

}  // namespace tandem
