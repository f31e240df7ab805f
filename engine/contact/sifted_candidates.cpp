#include <algorithm>

#include "engine/contact/contact_sieve.h"
#include "engine/contact/refined_contacts.h"

// Candidates that no region says anything of: by a sieve, and exactly if it lets them through.

namespace tandem {

void RefinedContacts::SiftAll(std::span<Candidate> candidates, const Mat3& R_VS, double layers,
                              Scratch& scratch, Contact* out) noexcept {
  for (const std::uint32_t i : scratch.left) {
    Candidate& candidate = candidates[i];
    // what faces say of the map's vertices; of edges, who has to be looked at says it then
    if (SaysFaces(candidate)) found_[i] = SiftFaces(candidate, R_VS, scratch.pieces);
    if (candidate.label == Label::kSurface || !MayPush(candidate, R_VS, scratch.pieces)) continue;
    candidate.look = Candidate::Look::kOpen;
    found_[i] = MeetOne(candidate, R_VS, layers, scratch, out + kPerPoint * i);
  }
}

std::uint8_t RefinedContacts::SiftFaces(const Candidate& candidate, const Mat3& R_VS,
                                        NearPieces& pieces) const noexcept {
  const NearPieces::Cell& vertices = pieces.About(candidate.voxel_V, Field::kVertex);
  if (vertices.too_many()) return kBears;
  if (vertices.all().empty()) return 0;
  const Faces faces = FacesAt(candidate, R_VS);
  auto bearing = SievedBearing::kNone;
  for (std::size_t i = 0; i < faces.count; ++i) {
    bearing = std::max(bearing,
                       MayBear(vertices, {candidate.voxel_V, candidate.p_V / s_, faces.nhat[i]}));
  }
  return bearing == SievedBearing::kNone ? 0 : bearing == SievedBearing::kHigh ? kHigh : kBears;
}

bool RefinedContacts::MayPush(const Candidate& candidate, const Mat3& R_VS,
                              NearPieces& pieces) const noexcept {
  const SievedPoint point{candidate.voxel_V, candidate.p_V / s_, candidate.nhat_V};
  if (candidate.label == Label::kVertex) {
    if (candidate.mark == kInteriorMark) return true;
    const NearPieces::Cell& surface = pieces.About(candidate.voxel_V, Field::kSurface);
    return surface.too_many() || MayStand(surface, point);
  }
  const NearPieces::Cell& edges = pieces.About(candidate.voxel_V, Field::kEdge);
  if (edges.too_many()) return true;
  const ShellEdge edge = EdgeAt(candidate, R_VS);
  return MayLean(edges, point, {edge.tangent, edge.half, edge.arc});
}

}  // namespace tandem
