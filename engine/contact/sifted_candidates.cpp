#include <algorithm>

#include "engine/contact/contact_sieve.h"
#include "engine/contact/refined_contacts.h"

// Candidates that no region says anything of: in groups, by a sieve, and exactly if it lets them
// through.

namespace tandem {

void RefinedContacts::SiftAll(std::span<Candidate> candidates, const Mat3& R_VS, double layers,
                              Scratch& scratch, Contact* out) noexcept {
  const std::span<const std::uint32_t> left = scratch.left;
  for (std::size_t first = 0; first < left.size();) {
    GridIndex low = candidates[left[first]].voxel_V;
    GridIndex high = low;
    std::size_t last = first + 1;
    for (; last < left.size(); ++last) {
      const Candidate& next = candidates[left[last]];
      const GridIndex& v = next.voxel_V;
      const GridIndex l{std::min(low.x, v.x), std::min(low.y, v.y), std::min(low.z, v.z)};
      const GridIndex h{std::max(high.x, v.x), std::max(high.y, v.y), std::max(high.z, v.z)};
      if (next.label != candidates[left[first]].label ||
          std::max({h.x - l.x, h.y - l.y, h.z - l.z}) > NearPieces::kSpread) {
        break;
      }
      low = l;
      high = h;
    }
    Sift(candidates, left.subspan(first, last - first), low, high, R_VS, layers, scratch, out);
    first = last;
  }
}

void RefinedContacts::Sift(std::span<Candidate> candidates, std::span<const std::uint32_t> group,
                           const GridIndex& low, const GridIndex& high, const Mat3& R_VS,
                           double layers, Scratch& scratch, Contact* out) noexcept {
  NearPieces& pieces = scratch.pieces;
  const Label label = candidates[group.front()].label;
  const auto bearing_of = [&](const Candidate& candidate) -> std::uint8_t {
    const Faces faces = FacesAt(candidate, R_VS);
    auto bearing = SievedBearing::kNone;
    for (std::size_t i = 0; i < faces.count; ++i) {
      bearing = std::max(bearing,
                         MayBear(pieces, {candidate.voxel_V, candidate.p_V / s_, faces.nhat[i]}));
    }
    return bearing == SievedBearing::kNone ? 0 : bearing == SievedBearing::kHigh ? kHigh : kBears;
  };
  const auto may_push = [&](const Candidate& candidate) {
    const SievedPoint point{candidate.voxel_V, candidate.p_V / s_, candidate.nhat_V};
    if (label == Label::kVertex) {
      return candidate.mark == kInteriorMark || MayStand(pieces, point);
    }
    const ShellEdge edge = EdgeAt(candidate, R_VS);
    return MayLean(pieces, point, {edge.tangent, edge.half, edge.arc.cosine, edge.arc.last});
  };

  // what faces say of the map's vertices; of edges, who has to be looked at says it then
  const bool any_face = std::any_of(group.begin(), group.end(), [&](std::uint32_t i) {
    return SaysFaces(candidates[i]);
  });
  if (any_face) {
    const bool gathered = pieces.Gather(low, high, Field::kVertex);
    for (const std::uint32_t i : group) {
      if (SaysFaces(candidates[i])) found_[i] = gathered ? bearing_of(candidates[i]) : kBears;
    }
  }
  if (label == Label::kSurface) return;
  const bool gathered =
      pieces.Gather(low, high, label == Label::kEdge ? Field::kEdge : Field::kSurface);
  for (const std::uint32_t i : group) {
    if (gathered && !may_push(candidates[i])) continue;
    candidates[i].look = Candidate::Look::kOpen;
    found_[i] = MeetOne(candidates[i], R_VS, layers, scratch, out + kPerPoint * i);
  }
}

}  // namespace tandem
