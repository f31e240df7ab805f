#include "engine/field/build/cell_list.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace tandem {

namespace {

constexpr std::size_t kParts = 64;
/// Returns the middles of a cell's sixty-four parts.
const PlaceLanes& PartsOfCell() {
  static const PlaceLanes lanes = LatticeLanes(4, 0.125, 0.25);
  return lanes;
}

/// A candidate in a cell.
struct Member {
  std::uint32_t face = 0;
  bool listed = false;
  std::uint64_t open = 0;  // parts in which it may be the nearest, if it is not listed
  std::array<float, kParts> distances;

  bool stays() const { return listed || open != 0; }
};

/// Tells whether the faces beside a member are as near in all of its open parts.
bool GoesOn(const NearFaces& faces, const Member& member, const std::vector<Member>& members,
            const PlaceLanes& parts, float half_part) {
  const auto first = static_cast<std::size_t>(std::countr_zero(member.open));
  std::array<float, 3> low{parts.x[first], parts.y[first], parts.z[first]};
  std::array<float, 3> high = low;
  for (std::uint64_t open = member.open; open != 0; open &= open - 1) {
    const auto i = static_cast<std::size_t>(std::countr_zero(open));
    const std::array<float, 3> at{parts.x[i], parts.y[i], parts.z[i]};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], at[axis]);
      high[axis] = std::max(high[axis], at[axis]);
    }
  }
  NearFaces::Box box;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    box.middle[axis] = 0.5F * (low[axis] + high[axis]);
    box.half[axis] = 0.5F * (high[axis] - low[axis]) + half_part;
  }
  const unsigned edges = faces.EdgesBefore(member.face, box);
  return faces.GoesOn(member.face, edges, box, [&](std::uint32_t face) {
    return std::ranges::any_of(members, [&](const Member& other) {
      return other.face == face && other.stays();
    });
  });
}

}  // namespace

std::vector<std::uint32_t> ListOfCell(const NearFaces& faces, std::span<const CellFace> candidates,
                                      const std::array<float, 3>& lowest, double band) {
  constexpr float kHalfPart = 0.125F;
  constexpr float kReach = 2 * 1.7321F * kHalfPart;  // greatest change of a distance within a part
  PlaceLanes parts;
  parts.count = kParts;
  for (std::size_t i = 0; i < kParts; ++i) {
    parts.x[i] = lowest[0] + PartsOfCell().x[i];
    parts.y[i] = lowest[1] + PartsOfCell().y[i];
    parts.z[i] = lowest[2] + PartsOfCell().z[i];
  }
  std::vector<Member> members(candidates.size());
  std::array<float, kParts> least;
  least.fill(std::numeric_limits<float>::max());
  for (std::size_t k = 0; k < members.size(); ++k) {
    members[k].face = candidates[k].face;
    faces.seen(candidates[k].face)
        .Measure(parts, candidates[k].edges, members[k].distances.data(), nullptr);
    for (std::size_t i = 0; i < kParts; ++i) least[i] = std::min(least[i], members[k].distances[i]);
  }
  std::array<float, kParts> within;
  within.fill(static_cast<float>(band));
  const std::uint64_t in_band = LanesWithin(least.data(), within.data(), 0);
  const std::uint64_t near_band = LanesWithin(least.data(), within.data(), kReach / 2);
  for (Member& member : members) {
    const float* distances = member.distances.data();
    member.listed = (LanesWithin(distances, least.data(), 0) & in_band) != 0;
    if (!member.listed) member.open = LanesWithin(distances, least.data(), kReach) & near_band;
  }
  // tests each against those that are left: a face that continues it stays, or is continued by
  // others that stay
  std::vector<std::uint32_t> numbers;
  for (Member& member : members) {
    if (member.open != 0 && GoesOn(faces, member, members, parts, kHalfPart)) member.open = 0;
  }
  for (const Member& member : members) {
    if (member.stays()) numbers.push_back(faces.number(member.face));
  }
  return numbers;
}

}  // namespace tandem
