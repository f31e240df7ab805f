#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "collab/session/messages.h"
#include "engine/world/step_inputs.h"

namespace tandem {

/// Shares of a peer's frames, 0 to 1, in which its simulation gave something up, from the bits of
/// StepReport.
struct FrameLimits {
  double travel_limited = 0;  // a body was held back to its travel limit
  double over_capacity = 0;   // point tests left room for less travel than half a voxel
  double contacts_full = 0;   // contacts beyond the room for them did not push
  double waited = 0;          // voxels were not in memory: nothing moved and no force was felt

  friend bool operator==(const FrameLimits&, const FrameLimits&) = default;
};

/// Counts limited frames, over all frames and over the last whole second. Neither allocates nor
/// locks.
class FrameLimitCount {
 public:
  /// Counts one frame by its StepReport::flags.
  void Count(std::uint32_t flags) noexcept;
  /// Shares over all frames so far.
  FrameLimits all() const noexcept { return SharesOf(all_); }
  /// Shares over the last full window of a thousand frames; all 0 until the first is full.
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

/// Packs the shares into bits that the flags of an ObjectState and of a ViewBody have to spare: in
/// whole percent, at least 1 where above 0. Of waiting only its presence is kept, as 1 %.
std::uint32_t AsFlags(const FrameLimits& limits) noexcept;
FrameLimits LimitsIn(std::uint32_t flags) noexcept;
/// Returns the limits of the holder of the body in hand; all 0 if `bodies` has none in hand.
FrameLimits LimitsOf(const std::vector<ViewBody>& bodies) noexcept;

/// Lists the limits above 0: "slowed 12 %, over capacity 3 %, contacts left out 1 %, waits for
/// voxels"; empty if there is none.
std::string AsText(const FrameLimits& limits);
/// Explains each limit above 0 in a line: the share of the frames, what it means and what helps.
std::vector<std::string> Explain(const FrameLimits& limits);

}  // namespace tandem
