#include "engine/field/brick_faces.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/base/bits.h"
#include "engine/geometry/closest_on_triangle.h"

namespace tandem {

namespace {

/// From a cell's centre to its corners and a little more, voxels: a face that is farther than the
/// nearest by twice as much is nowhere in the cell the nearest.
constexpr float kHalfDiagonal = 0.8662F;
constexpr std::size_t kPlacesOverFace = 4;
/// A face as wide as this is the nearest to one of a cell's places, or to next to nothing of it.
constexpr double kSlim = 1;

Vec3 Place(const GridIndex& index) {
  return {static_cast<double>(index.x), static_cast<double>(index.y), static_cast<double>(index.z)};
}

std::array<float, 3> LowestOf(std::size_t cell) {
  return {static_cast<float>(cell & 3), static_cast<float>(cell >> 2 & 3),
          static_cast<float>(cell >> 4)};
}

const PlaceLanes& NodesOfBrick() {
  static const PlaceLanes lanes = LatticeLanes(kBrickSide, 0, 1);
  return lanes;
}
const PlaceLanes& CellCentres() {
  static const PlaceLanes lanes = LatticeLanes(kBrickCells, 0.5, 1);
  return lanes;
}
/// Where a cell's error is measured.
const PlaceLanes& Samples() {
  static const PlaceLanes lanes = LatticeLanes(3, 1.0 / 6, 1.0 / 3);
  return lanes;
}
/// And where its error is measured that is nearly too large.
const PlaceLanes& FineSamples() {
  static const PlaceLanes lanes = LatticeLanes(5, 1.0 / 10, 1.0 / 5);
  return lanes;
}
/// The middles of a cube's sixty-four parts, for a cube of side 2 about the origin.
const PlaceLanes& PartsOfCube() {
  static const PlaceLanes lanes = LatticeLanes(4, -0.75, 0.5);
  return lanes;
}

/// A brick's values interpolated in one of its cells, at a place from the brick's lowest node.
float Interpolated(std::span<const float, kBrickNodes> values, std::size_t cell,
                   const std::array<float, 3>& place) {
  const auto [x, y, z] = LowestOf(cell);
  const std::size_t node = (cell & 3) + kBrickSide * ((cell >> 2 & 3) + kBrickSide * (cell >> 4));
  const auto along = [&](std::size_t from) {
    return values[from] + (place[0] - x) * (values[from + 1] - values[from]);
  };
  const auto across = [&](std::size_t from) {
    return along(from) + (place[1] - y) * (along(from + kBrickSide) - along(from));
  };
  const float low = across(node);
  return low + (place[2] - z) * (across(node + kBrickSide * kBrickSide) - low);
}

}  // namespace

BrickFaces::BrickFaces(const GridIndex& first, const std::vector<FieldFace>& all,
                       std::span<const std::uint32_t> near)
    : near_(near), all_(all), first_L_(Place(first)) {
  faces_.reserve(near.size());
  for (const std::uint32_t face : near) faces_.emplace_back(all[face], first_L_);
}

float BrickFaces::LookAtNodes() {
  for (const NearFace& face : faces_) face.MeasureInto(NodesOfBrick(), nodes_);
  return *std::min_element(nodes_.distance.begin(), nodes_.distance.begin() + kBrickNodes);
}

void BrickFaces::LookAtCells() {
  distances_.resize(faces_.size());
  heights_.resize(faces_.size());
  cell_least_.fill(std::numeric_limits<float>::max());
  float least = std::numeric_limits<float>::max();
  for (std::uint32_t i = 0; i < faces_.size(); ++i) {
    faces_[i].Measure(CellCentres(), distances_[i].data(), heights_[i].data());
    for (std::size_t cell = 0; cell < kCellsPerBrick; ++cell) {
      cell_least_[cell] = std::min(cell_least_[cell], distances_[i][cell]);
    }
    const float here = *std::min_element(distances_[i].begin(), distances_[i].end());
    if (here < least) nearest_ = i;
    least = std::min(least, here);
  }
}

std::array<float, kBrickNodes> BrickFaces::Values(
    const std::array<bool, kBrickNodes>& solid) const {
  const FieldFace& nearest = all_[near_[nearest_]];
  std::array<float, kBrickNodes> values;
  for (std::size_t node = 0; node < kBrickNodes; ++node) {
    float distance = nodes_.distance[node];
    if (distance > kReach) {
      const Vec3 place_L =
          first_L_ + Place({static_cast<std::int32_t>(node % kBrickSide),
                            static_cast<std::int32_t>(node / kBrickSide % kBrickSide),
                            static_cast<std::int32_t>(node / kBrickSide / kBrickSide)});
      const auto height = static_cast<float>(nearest.nhat.dot(place_L - nearest.corners_L[0]));
      distance = std::max(kReach, solid[node] ? -height : height);
    }
    values[node] = solid[node] ? -distance : distance;
  }
  return values;
}

std::vector<std::uint32_t> BrickFaces::CandidatesOf(std::size_t cell) const {
  const float most = cell_least_[cell] + 2 * kHalfDiagonal;
  std::vector<std::uint32_t> candidates;
  for (std::uint32_t i = 0; i < distances_.size(); ++i) {
    if (distances_[i][cell] <= most) candidates.push_back(i);
  }
  return candidates;
}

PlaceLanes BrickFaces::PlacesIn(std::size_t cell, const PlaceLanes& pattern,
                                const std::vector<std::uint32_t>& candidates) const {
  const std::array<float, 3> lowest = LowestOf(cell);
  PlaceLanes places;
  const auto add = [&](float x, float y, float z) {
    places.x[places.count] = lowest[0] + x;
    places.y[places.count] = lowest[1] + y;
    places.z[places.count] = lowest[2] + z;
    ++places.count;
  };
  for (std::size_t i = 0; i < pattern.count; ++i) add(pattern.x[i], pattern.y[i], pattern.z[i]);
  const Vec3 lowest_L = first_L_ + Vec3(lowest[0], lowest[1], lowest[2]);
  for (const std::uint32_t i : candidates) {
    if (places.count + kPlacesOverFace > PlaceLanes::kMost) break;
    const FieldFace& face = all_[near_[i]];
    if (face.width > kSlim) continue;
    const auto& [a, b, c] = face.corners_L;
    Vec3 middle = Vec3::Zero();
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3 from = lowest_L + Vec3(corner & 1, corner >> 1 & 1, corner >> 2);
      middle += ClosestOnTriangle(a, b, c, from).point / 8;
    }
    // the line over it, as far as it is in the cell
    double begin = -std::numeric_limits<double>::infinity();
    double end = std::numeric_limits<double>::infinity();
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      const double way = face.nhat[axis];
      const double low = lowest_L[axis] - middle[axis];
      if (std::abs(way) < 1e-9) {
        if (low > 0 || low < -1) end = -std::numeric_limits<double>::infinity();
        continue;
      }
      begin = std::max(begin, std::min(low / way, (low + 1) / way));
      end = std::min(end, std::max(low / way, (low + 1) / way));
    }
    if (!(begin < end)) continue;
    for (std::size_t k = 0; k < kPlacesOverFace; ++k) {
      const double share = (static_cast<double>(k) + 0.5) / kPlacesOverFace;
      const Vec3 place = middle + (begin + share * (end - begin)) * face.nhat - lowest_L;
      add(static_cast<float>(place.x()), static_cast<float>(place.y()),
          static_cast<float>(place.z()));
    }
  }
  for (const std::size_t last = places.count - 1; places.count % 16 != 0; ++places.count) {
    places.x[places.count] = places.x[last];
    places.y[places.count] = places.y[last];
    places.z[places.count] = places.z[last];
  }
  return places;
}

bool BrickFaces::ComesWithin(std::size_t cell, double distance) const noexcept {
  return cell_least_[cell] - kHalfDiagonal < distance;
}

bool BrickFaces::NearlyOnePlane(const std::vector<std::uint32_t>& candidates,
                                std::size_t cell) const {
  const Vec3& nhat = all_[near_[candidates[0]]].nhat;
  const float height = heights_[candidates[0]][cell];
  return std::all_of(candidates.begin(), candidates.end(), [&](std::uint32_t i) {
    return (all_[near_[i]].nhat - nhat).squaredNorm() < kSameNormal * kSameNormal &&
           std::abs(heights_[i][cell] - height) < kSameHeight;
  });
}

BrickFaces::CellErrors BrickFaces::ErrorsOf(std::span<const float, kBrickNodes> values,
                                            std::size_t cell, const PlaceLanes& pattern,
                                            const std::vector<std::uint32_t>& candidates,
                                            double band, double most_near) const {
  const PlaceLanes places = PlacesIn(cell, pattern, candidates);
  NearestLanes exact;
  for (const std::uint32_t i : candidates) faces_[i].MeasureInto(places, exact);
  CellErrors errors;
  for (std::size_t i = 0; i < places.count; ++i) {
    const double value = Interpolated(values, cell, {places.x[i], places.y[i], places.z[i]});
    const double over = value - exact.Signed(i);
    const double error = std::abs(over);
    // a value beyond what is near is told as that
    errors.over = std::max(errors.over, std::min(value, most_near) - exact.Signed(i));
    const double least = std::min<double>(std::abs(value), exact.distance[i]);
    if (least < band) {
      errors.within_band = std::max(errors.within_band, error);
    } else if (least <= most_near) {
      errors.beyond = std::max(errors.beyond, error);
    }
  }
  return errors;
}

BrickFaces::Errors BrickFaces::Measure(std::span<const float, kBrickNodes> values, double band,
                                       double most_near, bool open) const {
  Errors errors;
  for (std::size_t cell = 0; cell < kCellsPerBrick; ++cell) {
    if (!ComesWithin(cell, most_near)) continue;
    const std::vector<std::uint32_t> candidates = CandidatesOf(cell);
    errors.over[cell] = static_cast<float>(kLeastBound);
    if (!open && NearlyOnePlane(candidates, cell)) continue;
    CellErrors cell_errors = ErrorsOf(values, cell, Samples(), candidates, band, most_near);
    double share = kBetweenPlaces;
    if (cell_errors.within_band <= kMostCellError &&
        kBetweenPlaces * cell_errors.within_band > kMostCellError) {
      cell_errors = ErrorsOf(values, cell, FineSamples(), candidates, band, most_near);
      share = kBetweenFinePlaces;
    }
    errors.beyond = std::max(errors.beyond, share * cell_errors.beyond);
    errors.over[cell] = static_cast<float>(share * cell_errors.over + kLeastBound);
    if (share * cell_errors.within_band > kMostCellError) {
      errors.erring |= std::uint64_t{1} << cell;
    } else {
      errors.within_band = std::max(errors.within_band, share * cell_errors.within_band);
    }
  }
  return errors;
}

void BrickFaces::AddNearestIn(const std::array<float, 3>& middle, float half, double band,
                              std::span<const std::uint32_t> contenders,
                              std::vector<std::uint8_t>& listed) const {
  constexpr float kSmallest = 0.04F;  // voxels
  const PlaceLanes& parts = PartsOfCube();
  PlaceLanes places;
  places.count = parts.count;
  for (std::size_t i = 0; i < parts.count; ++i) {
    places.x[i] = middle[0] + half * parts.x[i];
    places.y[i] = middle[1] + half * parts.y[i];
    places.z[i] = middle[2] + half * parts.z[i];
  }
  std::vector<std::array<float, 64>> told(contenders.size());
  std::array<float, 64> least;
  least.fill(std::numeric_limits<float>::max());
  for (std::size_t k = 0; k < contenders.size(); ++k) {
    faces_[contenders[k]].Measure(places, told[k].data(), nullptr);
    for (std::size_t i = 0; i < least.size(); ++i) least[i] = std::min(least[i], told[k][i]);
  }
  const float part = half / 4;
  const float reach = 2 * 1.7321F * part;  // what a distance may change by within a part
  std::array<float, 64> within;
  within.fill(static_cast<float>(band));
  const std::uint64_t in_band = LanesWithin(least.data(), within.data(), 0);
  const std::uint64_t near_band = LanesWithin(least.data(), within.data(), reach / 2);
  for (std::size_t k = 0; k < contenders.size(); ++k) {
    if ((LanesWithin(told[k].data(), least.data(), 0) & in_band) != 0) listed[contenders[k]] = 1;
  }
  // parts in which a face that is not listed may be the nearest
  std::uint64_t open = 0;
  for (std::size_t k = 0; k < contenders.size(); ++k) {
    if (listed[contenders[k]] != 0) continue;
    open |= LanesWithin(told[k].data(), least.data(), reach) & near_band;
  }
  std::vector<std::uint32_t> here;
  for (; open != 0; open &= open - 1) {
    const auto i = static_cast<std::size_t>(CountBits((open & -open) - 1));
    here.clear();
    bool all_listed = true;
    for (std::size_t k = 0; k < contenders.size(); ++k) {
      if (told[k][i] > least[i] + reach) continue;
      here.push_back(contenders[k]);
      all_listed = all_listed && listed[contenders[k]] != 0;
    }
    if (all_listed) continue;
    if (here.size() > 1 && part > kSmallest) {
      AddNearestIn({places.x[i], places.y[i], places.z[i]}, part, band, here, listed);
    } else {
      for (const std::uint32_t face : here) listed[face] = 1;
    }
  }
}

std::vector<std::uint32_t> BrickFaces::ListOf(std::size_t cell, double band) const {
  const std::array<float, 3> lowest = LowestOf(cell);
  std::vector<std::uint8_t> listed(faces_.size());
  AddNearestIn({lowest[0] + 0.5F, lowest[1] + 0.5F, lowest[2] + 0.5F}, 0.5F, band,
               CandidatesOf(cell), listed);
  std::vector<std::uint32_t> list;
  for (std::uint32_t i = 0; i < listed.size(); ++i) {
    if (listed[i] != 0) list.push_back(near_[i]);
  }
  std::sort(list.begin(), list.end());
  return list;
}

}  // namespace tandem
