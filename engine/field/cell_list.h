#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/field/near_faces.h"

namespace tandem {

/// The faces that tell a cell of the field: every one that is the nearest to some place of the cell
/// within the band, and few that are not. Numbers among all faces, rising.
///
/// A face is listed that is the nearest to the middle of one of the cell's sixty-four parts, or
/// nearly as near as the nearest. Such a one is left out where the parts lie beyond its edges and
/// the surface goes on gently over these: the faces there are as near.
///
/// `candidates` are the cell's; `lowest` is the cell's lowest node from the hyperbrick's middle;
/// `band` in voxels.
std::vector<std::uint32_t> ListOfCell(const NearFaces& faces, std::span<const CellFace> candidates,
                                      const std::array<float, 3>& lowest, double band);

}  // namespace tandem
