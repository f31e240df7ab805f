#include "engine/field/build/brick_faces.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/field/build/cell_list.h"
#include "engine/geometry/mesh/closest_on_triangle.h"

namespace tandem {

namespace {

constexpr std::size_t kPlacesOverFace = 4;
/// A face as wide as this is the nearest to one of a cell's places, or to almost nothing of the
/// cell.
constexpr double kSlim = 1;

/// Margin over the nearest face's distance, voxels. A face within it of the middle of one of the
/// cell's 27 parts may be the nearest somewhere in the cell.
constexpr float kWithinPart = 1.7321F / 3;
/// The places where a cell's error is measured: the middles of its parts.
constexpr std::size_t kSamples = 32;
const PlaceLanes& Samples() {
  static const PlaceLanes lanes = LatticeLanes(3, 1.0 / 6, 1.0 / 3);
  return lanes;
}
/// The places where the error is measured if it is nearly too large.
const PlaceLanes& FineSamples() {
  static const PlaceLanes lanes = LatticeLanes(5, 1.0 / 10, 1.0 / 5);
  return lanes;
}
/// Returns the values at a cell's corners.
std::array<float, 8> CornersOf(std::span<const float, kBrickNodes> values, std::size_t cell) {
  std::array<float, 8> corners;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    corners[i] = values[NodeInBrick((cell & 3) + (i & 1), (cell >> 2 & 3) + (i >> 1 & 1),
                                    (cell >> 4) + (i >> 2))];
  }
  return corners;
}

/// Tells whether a face is so slim that it may lie between a cell's places, and is not part of a
/// surface that bends gently.
bool SlimAndSharp(const FieldFace& face) {
  return face.width <= kSlim && std::ranges::count(face.beside, FieldFace::kNone) > 0;
}

}  // namespace

BrickFaces::BrickFaces(const NearFaces& faces, std::size_t place, const CellCandidates& candidates)
    : faces_(faces), candidates_(candidates) {
  const GridIndex at = BlockCell(place) * kBrickCells;
  const auto from_middle = [](std::int32_t n) {
    return static_cast<float>(n - kHyperbrickCells / 2);
  };
  lowest_ = {from_middle(at.x), from_middle(at.y), from_middle(at.z)};
}

std::array<float, 3> BrickFaces::LowestOf(std::size_t cell) const {
  return {lowest_[0] + static_cast<float>(cell & 3), lowest_[1] + static_cast<float>(cell >> 2 & 3),
          lowest_[2] + static_cast<float>(cell >> 4)};
}

PlaceLanes BrickFaces::PlacesIn(std::size_t cell, const PlaceLanes& pattern) const {
  const std::array<float, 3> lowest = LowestOf(cell);
  PlaceLanes places;
  places.count = pattern.count;
  for (std::size_t i = 0; i < pattern.count; ++i) {
    places.x[i] = lowest[0] + pattern.x[i];
    places.y[i] = lowest[1] + pattern.y[i];
    places.z[i] = lowest[2] + pattern.z[i];
  }
  return places;
}

PlaceLanes BrickFaces::PlacesOverSlim(std::size_t cell, std::span<const CellFace> faces) const {
  PlaceLanes places;
  const std::array<float, 3> lowest = LowestOf(cell);
  const Vec3 lowest_L = faces_.middle_L() + Vec3(lowest[0], lowest[1], lowest[2]);
  for (const CellFace& candidate : faces) {
    if (places.count + kPlacesOverFace > PlaceLanes::kMost) break;
    const FieldFace& face = faces_[candidate.face];
    if (!SlimAndSharp(face)) continue;
    const auto& [a, b, c] = face.corners_L;
    const Vec3 middle = ClosestOnTriangle(a, b, c, lowest_L + Vec3::Constant(0.5)).point;
    // the line over it, as far as it lies in the cell
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
      places.x[places.count] = lowest[0] + static_cast<float>(place.x());
      places.y[places.count] = lowest[1] + static_cast<float>(place.y());
      places.z[places.count] = lowest[2] + static_cast<float>(place.z());
      ++places.count;
    }
  }
  for (const std::size_t last = places.count - 1; places.count % 16 != 0; ++places.count) {
    places.x[places.count] = places.x[last];
    places.y[places.count] = places.y[last];
    places.z[places.count] = places.z[last];
  }
  return places;
}

bool BrickFaces::NearlyOnePlane(std::size_t cell) const {
  const std::span<const CellFace> candidates = candidates_.FacesOf(cell);
  const FieldFace& first = faces_[candidates[0].face];
  const std::array<float, 3> lowest = LowestOf(cell);
  const Vec3 centre_L =
      faces_.middle_L() + Vec3(lowest[0], lowest[1], lowest[2]) + Vec3::Constant(0.5);
  const auto height = [&](const FieldFace& face) {
    return face.nhat.dot(centre_L - face.corners_L[0]);
  };
  return std::ranges::all_of(candidates, [&](const CellFace& candidate) {
    const FieldFace& face = faces_[candidate.face];
    return (face.nhat - first.nhat).squaredNorm() < kSameNormal * kSameNormal &&
           std::abs(height(face) - height(first)) < kSameHeight;
  });
}

CellErrors BrickFaces::ErrorsOf(const std::array<float, 8>& values, std::size_t cell,
                                std::span<const CellFace> faces, const PlaceLanes& places,
                                double band, double most_near) const {
  NearestLanes exact(places.count);
  for (const CellFace& candidate : faces) {
    faces_.seen(candidate.face).MeasureInto(places, candidate.edges, exact);
  }
  return ErrorsInCell(values, LowestOf(cell), places, exact, static_cast<float>(band),
                      static_cast<float>(most_near));
}

NearestLanes BrickFaces::NearestTo(const PlaceLanes& places, std::span<const CellFace> candidates,
                                   std::vector<CellFace>& left) const {
  NearestLanes exact(places.count);
  std::vector<std::array<float, kSamples>> distances(candidates.size());
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    faces_.seen(candidates[i].face)
        .MeasureInto(places, candidates[i].edges, exact, distances[i].data());
  }
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const float* of_face = distances[i].data();
    if (LanesWithin(of_face, exact.distance.data(), kWithinPart, kSamples) != 0) {
      left.push_back(candidates[i]);
    }
  }
  return exact;
}

BrickFaces::Errors BrickFaces::Measure(std::span<const float, kBrickNodes> values,
                                       std::uint64_t cells, double band, double most_near,
                                       bool open) const {
  const auto near = static_cast<float>(most_near);
  const auto within = static_cast<float>(band);
  Errors errors;
  std::vector<CellFace>& left = errors.left.faces;
  for (std::size_t cell = 0; cell < kCellsPerBrick; ++cell) {
    const std::size_t first = left.size();
    errors.left.first[cell] = static_cast<std::uint32_t>(first);
    const std::span<const CellFace> candidates = candidates_.FacesOf(cell);
    const bool measured = (cells >> cell & 1U) != 0;
    if (measured) errors.over[cell] = static_cast<float>(kLeastBound);
    if (!measured || (!open && NearlyOnePlane(cell))) {
      left.insert(left.end(), candidates.begin(), candidates.end());
      continue;
    }
    const std::array<float, 8> corners = CornersOf(values, cell);
    const PlaceLanes places = PlacesIn(cell, Samples());
    const NearestLanes exact = NearestTo(places, candidates, left);
    const std::span<const CellFace> faces = std::span(left).subspan(first);
    CellErrors of_cell = ErrorsInCell(corners, LowestOf(cell), places, exact, within, near);
    const PlaceLanes over_slim = PlacesOverSlim(cell, faces);
    if (over_slim.count > 0) {
      of_cell.Add(ErrorsOf(corners, cell, faces, over_slim, band, most_near));
    }
    double share = kBetweenPlaces;
    if (of_cell.within_band <= kMostCellError &&
        kBetweenPlaces * of_cell.within_band > kMostCellError) {
      of_cell.Add(ErrorsOf(corners, cell, faces, PlacesIn(cell, FineSamples()), band, most_near));
      share = kBetweenFinePlaces;
    }
    errors.beyond = std::max(errors.beyond, share * of_cell.beyond);
    errors.over[cell] = static_cast<float>(share * of_cell.over + kLeastBound);
    if (share * of_cell.within_band > kMostCellError) {
      errors.erring |= std::uint64_t{1} << cell;
    } else {
      errors.within_band = std::max(errors.within_band, share * of_cell.within_band);
    }
  }
  errors.left.first.back() = static_cast<std::uint32_t>(left.size());
  return errors;
}

std::vector<std::uint32_t> BrickFaces::ListOf(std::size_t cell, double band) const {
  return ListOfCell(faces_, candidates_.FacesOf(cell), LowestOf(cell), band);
}

}  // namespace tandem
