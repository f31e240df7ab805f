#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "engine/contact/contact_pair.h"

namespace tandem {

/// Every point of a pair, read whatever the schedule.
class AllPoints {
 public:
  explicit AllPoints(const ContactPair& pair);
  /// Points in contact that the last frame's schedule did not give, and the other way round.
  std::size_t Violations();
  /// Whether every point reads beyond at a pose.
  bool AllBeyond(const Pose& X_VS);

 private:
  const ContactPair* pair_;
  std::vector<std::uint32_t> all_;
  std::vector<BlockReading> readings_;
  std::vector<std::uint16_t> tested_;
};

}  // namespace tandem
