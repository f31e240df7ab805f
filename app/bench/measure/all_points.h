#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "engine/world/world.h"

namespace tandem {

/// Reads every point of a world's first pair, whatever the schedule. That pair must be one with the
/// fixture.
class AllPoints {
 public:
  explicit AllPoints(const World& world);
  /// Returns the number of points in contact that the last frame's schedule did not give. In the
  /// plain model it also counts points that the schedule gave and that are not in contact. Call it
  /// only after Step() and Remember().
  std::size_t Violations();
  /// Keeps the pose at which the coming frame tests the first body. Call it before Step().
  void Remember();
  /// Returns the number of points.
  std::size_t count() const noexcept;
  /// Returns whether nothing of the fixture is near any point of the first body at a pose.
  bool AllBeyond(const Pose& X_WB);

 private:
  bool plain() const noexcept { return world_->model().scene.contact == ContactModel::kPlain; }
  std::size_t PlainViolations();

  const World* world_;
  Pose X_WB_;  // pose that Remember() keeps
  std::vector<std::uint32_t> all_;
  std::vector<BlockReading> readings_;
  std::vector<std::uint16_t> tested_;
};

}  // namespace tandem
