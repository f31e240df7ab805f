#pragma once

#include <cstddef>
#include <memory>

#include "engine/contact/pair/body_pair.h"
#include "engine/paging/resident_voxels.h"
#include "engine/world/world_model.h"

namespace tandem {

/// Makes the pair of a moving body and the fixture. `resident`: the fixture's voxels, if they are
/// in memory in part only.
std::unique_ptr<BodyPair> MakeFixturePair(const WorldModel& model, std::size_t body,
                                          ResidentVoxels* resident,
                                          const ScheduleOptions& schedule);

/// Makes the pair of two moving bodies.
std::unique_ptr<BodyPair> MakeMovingPair(const WorldModel& model, std::size_t shell,
                                         std::size_t map, const ScheduleOptions& schedule);

}  // namespace tandem
