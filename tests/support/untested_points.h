#pragma once

#include <vector>

#include "engine/contact/schedule/schedule.h"

namespace tandem::testing {

/// Counts the points that are in contact by their own field and were not given by the schedule's
/// last Test(), or the other way round. All are read. The count shares with the schedule only where
/// a point is, not which ones are read.
inline std::size_t UntestedPoints(const PointBlocks& blocks, const Voxmap& voxmap,
                                  const Schedule& schedule) {
  std::vector<unsigned> tested(blocks.size(), 0);
  for (const Schedule::ContactBlock& c : schedule.contacts()) tested[c.block] = c.lanes;
  std::size_t missed = 0;
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    const Field field = FieldReadBy(blocks.block(b).label);
    for (std::size_t lane = 0; lane < blocks.block(b).count; ++lane) {
      const GridIndex voxel = VoxelAt(schedule.transform()(blocks, b, lane));
      const bool in_contact = voxmap.Value(field, voxel) <= 2 + schedule.force_layer();
      if (in_contact != ((tested[b] >> lane & 1) != 0)) ++missed;
    }
  }
  return missed;
}

}  // namespace tandem::testing
