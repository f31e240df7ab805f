#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "engine/world/world.h"

namespace tandem {

/// Every point of a world's first pair, which is one with the fixture, read whatever the schedule.
class AllPoints {
 public:
  explicit AllPoints(const World& world);
  /// Points in contact that the last frame's schedule did not give; in the plain model also the
  /// other way round. Only after Step() and Remember().
  std::size_t Violations();
  /// Before Step(): where the bodies stand that the frame tests.
  void Remember();
  /// How many there are.
  std::size_t count() const noexcept;
  /// Tells whether nothing of the fixture is near any point of the first body at a pose.
  bool AllBeyond(const Pose& X_WB);

 private:
  bool plain() const noexcept { return world_->model().scene.contact == ContactModel::kPlain; }
  std::size_t PlainViolations();

  const World* world_;
  Pose X_WB_;  // as remembered
  std::vector<std::uint32_t> all_;
  std::vector<BlockReading> readings_;
  std::vector<std::uint16_t> tested_;
};

}  // namespace tandem
