#pragma once

#include <cstdint>
#include <span>

#include "engine/voxel/map/voxmap.h"

namespace tandem {

/// Places in voxels of V, as three arrays of one length.
struct VoxelPlaces {
  std::span<const float> x;
  std::span<const float> y;
  std::span<const float> z;
};

/// Reads the marks at unrelated places, in one field; beyond outside the map. It runs through the
/// map's levels in stages and prefetches what the next stage will read, so that the waits for
/// memory overlap (paper §5.3, pre-fetching). `marks` takes one byte a place. The bits are the same
/// on every processor.
void TestScattered(const VoxelPlaces& places, const Voxmap& voxmap, Field field,
                   std::uint8_t* marks) noexcept;

}  // namespace tandem
