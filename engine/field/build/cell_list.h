#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/field/build/near_faces.h"

namespace tandem {

/// Finds the list of a cell of the field: every face that is the nearest to some place of the cell
/// within the band, and few others. Returns numbers among all faces, rising.
///
/// A face is in the list if it is the nearest to the middle of one of the cell's sixty-four parts,
/// or nearly as near as the nearest. It is left out where the parts lie beyond its edges and the
/// surface continues gently over these: the faces there are as near.
///
/// `candidates` are the cell's; `lowest` is the cell's lowest node, relative to the hyperbrick's
/// middle; `band` is in voxels.
std::vector<std::uint32_t> ListOfCell(const NearFaces& faces, std::span<const CellFace> candidates,
                                      const std::array<float, 3>& lowest, double band);

}  // namespace tandem
