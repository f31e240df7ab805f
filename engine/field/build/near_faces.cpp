#include "engine/field/build/near_faces.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>

#include "engine/geometry/mesh/closest_on_triangle.h"

namespace tandem {

namespace {

/// From a cell's centre to its corners and a little more, voxels. A face that is farther than the
/// nearest by twice as much is nowhere in the cell the nearest.
constexpr float kHalfDiagonal = 0.8662F;
/// Distance from a cell's centre up to which a face may be within kReach of a place of the cell.
constexpr float kCellReach = HyperbrickSurvey::kReach + kHalfDiagonal;
/// Distance from a plane up to which corners count as in it, voxels.
constexpr double kInPlane = 2e-4;
constexpr double kHalfHyperbrick = 0.5 * kHyperbrickCells;

Vec3 Place(const GridIndex& index) {
  return {static_cast<double>(index.x), static_cast<double>(index.y), static_cast<double>(index.z)};
}

/// Returns the lowest node of a block of nodes, relative to the hyperbrick's middle.
std::array<float, 3> LowestNode(const GridIndex& block) {
  const auto along = [](std::int32_t n) {
    return static_cast<float>(n * kBrickCells) - static_cast<float>(kHalfHyperbrick);
  };
  return {along(block.x), along(block.y), along(block.z)};
}

/// Finds the cubes about the hyperbrick's middle that a face may come near to.
class FaceReach {
 public:
  /// `half` is half a side of the cubes, voxels.
  FaceReach(const FieldFace& face, const NearFace::View& seen, const Vec3& middle_L, float half,
            float reach)
      : seen_(seen), half_(half), reach_(reach), slab_(reach + half * Sum(seen.nhat)) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<Eigen::Index>(axis);
      const auto& [p, q, r] = face.corners_L;
      low_[axis] = static_cast<float>(std::min({p[a], q[a], r[a]}) - middle_L[a]);
      high_[axis] = static_cast<float>(std::max({p[a], q[a], r[a]}) - middle_L[a]);
    }
    for (std::size_t k = 0; k < 3; ++k) beside_[k] = reach + half * Sum(seen.edges[k].inward);
  }

  /// Calls `visit(x, y, z)` for cubes of a row of `count` along each axis. The first has its centre
  /// at `first`, and the next is kBrickCells farther on.
  template <typename Visit>
  void VisitCubes(float first, std::int32_t count, const Visit& visit) const {
    constexpr float kStep = kBrickCells;
    std::array<std::int32_t, 3> from;
    std::array<std::int32_t, 3> to;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const float more = reach_ + half_;
      from[axis] =
          std::max(0, static_cast<std::int32_t>(std::ceil((low_[axis] - more - first) / kStep)));
      to[axis] = std::min(
          count - 1, static_cast<std::int32_t>(std::floor((high_[axis] + more - first) / kStep)));
    }
    for (std::int32_t z = from[2]; z <= to[2]; ++z) {
      for (std::int32_t y = from[1]; y <= to[1]; ++y) {
        for (std::int32_t x = from[0]; x <= to[0]; ++x) {
          const auto at = [&](std::int32_t i) {
            return first + kStep * static_cast<float>(i);
          };
          if (Reaches({at(x), at(y), at(z)})) visit(GridIndex{x, y, z});
        }
      }
    }
  }

 private:
  static float Sum(const std::array<float, 3>& v) {
    return std::abs(v[0]) + std::abs(v[1]) + std::abs(v[2]);
  }
  static float Dot(const std::array<float, 3>& a, const std::array<float, 3>& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  }
  bool Reaches(const std::array<float, 3>& centre) const {
    constexpr float kRounding = 0.01F;
    if (std::abs(Dot(seen_.nhat, centre) - seen_.offset) > slab_ + kRounding) return false;
    float squared = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const float apart =
          std::max({0.0F, low_[axis] - half_ - centre[axis], centre[axis] - half_ - high_[axis]});
      squared += apart * apart;
    }
    if (squared > (reach_ + kRounding) * (reach_ + kRounding)) return false;
    for (std::size_t k = 0; k < 3; ++k) {
      const NearFace::View::Edge& edge = seen_.edges[k];
      if (edge.inward_offset == std::numeric_limits<float>::max()) continue;  // no length
      if (Dot(edge.inward, centre) - edge.inward_offset < -beside_[k] - kRounding) return false;
    }
    return true;
  }

  const NearFace::View& seen_;
  float half_;
  float reach_;
  float slab_;  // greatest distance of a cube's centre from the plane
  std::array<float, 3> low_{}, high_{};
  std::array<float, 3> beside_{};
};

bool InPlaneOf(const FieldFace& face, const FieldFace& other) {
  if (face.sheet || other.sheet || face.nhat.dot(other.nhat) < 0.9) return false;
  return std::all_of(other.corners_L.begin(), other.corners_L.end(), [&](const Vec3& corner) {
    return std::abs(face.nhat.dot(corner - face.corners_L[0])) < kInPlane;
  });
}

/// Sorts faces by the cells in which they can be the nearest. `cells`: bits of these, by face.
CellCandidates SortByCell(std::span<const std::uint32_t> faces,
                          std::span<const NearFace::CubeSides> sides,
                          std::span<const std::uint64_t> cells) {
  CellCandidates candidates;
  std::array<std::uint32_t, kCellsPerBrick + 1>& first_of = candidates.first;
  for (const std::uint64_t bits : cells) {
    for (std::uint64_t left = bits; left != 0; left &= left - 1) {
      ++first_of[static_cast<std::size_t>(std::countr_zero(left)) + 1];
    }
  }
  std::partial_sum(first_of.begin(), first_of.end(), first_of.begin());
  candidates.faces.resize(first_of.back());
  std::array<std::uint32_t, kCellsPerBrick + 1> next = first_of;
  for (std::size_t i = 0; i < faces.size(); ++i) {
    for (std::uint64_t left = cells[i]; left != 0; left &= left - 1) {
      const auto cell = static_cast<std::size_t>(std::countr_zero(left));
      unsigned edges = 0;
      for (unsigned k = 0; k < 3; ++k) {
        edges |= static_cast<unsigned>(sides[i].before[k] >> cell & 1U) << k;
      }
      candidates.faces[next[cell]++] = {faces[i], edges};
    }
  }
  return candidates;
}

}  // namespace

NearFaces::NearFaces(const GridIndex& first, const std::vector<FieldFace>& all,
                     std::span<const std::uint32_t> near)
    : all_(all), near_(near), middle_L_(Place(first) + Vec3::Constant(kHalfHyperbrick)) {
  seen_.reserve(near.size());
  beside_.reserve(near.size());
  for (const std::uint32_t face : near) {
    seen_.emplace_back(all[face], middle_L_);
    beside_.push_back(all[face].beside);
    for (std::uint32_t& beside : beside_.back()) {
      const auto at = std::lower_bound(near.begin(), near.end(), beside);
      const bool is_near = at != near.end() && *at == beside;
      beside = is_near ? static_cast<std::uint32_t>(at - near.begin()) : FieldFace::kNone;
    }
  }
}

HyperbrickSurvey::HyperbrickSurvey(const NearFaces& faces, double kept, bool closed)
    : faces_(faces) {
  FindKinds(kept, closed);
  MakeRoom();
  Measure(kept);
}

void HyperbrickSurvey::FindKinds(double kept, bool closed) {
  constexpr float kHalf = 0.5F * kBrickCells;
  constexpr auto kFirst = static_cast<float>(kHalf - kHalfHyperbrick);
  for (std::uint32_t i = 0; i < faces_.size(); ++i) {
    const FieldFace& face = faces_[i];
    const FaceReach reach(face, faces_.seen(i).view(), faces_.middle_L(), kHalf,
                          static_cast<float>(kept));
    reach.VisitCubes(kFirst, kHyperbrickBricks, [&](const GridIndex& at) {
      Brick& brick = bricks_[CellInBlock(at)];
      if (brick.kind == Kind::kMeasured) return;
      const bool first = brick.kind == Kind::kFar;
      if (first) brick.nearest = i;
      const bool flat = closed && (first ? !face.sheet : InPlaneOf(faces_[brick.nearest], face));
      brick.kind = flat ? Kind::kFlat : Kind::kMeasured;
      if (!flat || brick.sure) return;
      const Vec3 lowest_L =
          faces_.middle_L() - Vec3::Constant(kHalfHyperbrick) + Place(at * kBrickCells);
      const Vec3 centre_L = lowest_L + Vec3::Constant(0.5 * kBrickCells);
      const auto& [a, b, c] = face.corners_L;
      const Vec3 from = (ClosestOnTriangle(a, b, c, centre_L).point - centre_L).cwiseAbs() -
                        Vec3::Constant(0.5 * kBrickCells);
      brick.sure = from.cwiseMax(0.0).norm() < kept;
    });
  }
  for (Brick& brick : bricks_) {
    if (brick.kind == Kind::kFlat && !brick.sure) brick.kind = Kind::kMeasured;
  }
  DropFarPlanes(kept);
}

void HyperbrickSurvey::DropFarPlanes(double kept) {
  for (std::size_t place = 0; place < bricks_.size(); ++place) {
    if (bricks_[place].kind != Kind::kFlat) continue;
    const auto [nhat, at_lowest] = PlaneOf(place);
    const double middle = at_lowest + 0.5 * kBrickCells * nhat.sum();
    const double least = std::abs(middle) - 0.5 * kBrickCells * nhat.cwiseAbs().sum();
    if (least > kept) bricks_[place].kind = Kind::kFar;
  }
}

HyperbrickSurvey::Plane HyperbrickSurvey::PlaneOf(std::size_t brick, std::uint32_t nearest) const {
  const FieldFace& face = faces_[nearest];
  const Vec3 lowest_L =
      faces_.middle_L() - Vec3::Constant(kHalfHyperbrick) + Place(BlockCell(brick) * kBrickCells);
  return {face.nhat, face.nhat.dot(lowest_L - face.corners_L[0])};
}

void HyperbrickSurvey::MakeRoom() {
  blocks_.assign(kBlocks * kBlocks * kBlocks, -1);
  std::int32_t nodes = 0;
  for (std::size_t place = 0; place < bricks_.size(); ++place) {
    if (bricks_[place].kind != Kind::kMeasured) continue;
    for (std::int32_t i = 0; i < 8; ++i) {
      const GridIndex at = BlockCell(place) + GridIndex{i & 1, i >> 1 & 1, i >> 2};
      std::int32_t& block =
          blocks_[static_cast<std::size_t>(at.x + kBlocks * (at.y + kBlocks * at.z))];
      if (block >= 0) continue;
      block = nodes;
      nodes += static_cast<std::int32_t>(kCubePlaces);
    }
  }
  node_distances_.assign(static_cast<std::size_t>(nodes), std::numeric_limits<float>::max());
  node_heights_.assign(static_cast<std::size_t>(nodes), 0.0F);
}

void HyperbrickSurvey::Measure(double kept) {
  // cubes about four layers of nodes and four of centres
  constexpr float kHalf = 1.75F;
  constexpr auto kFirst = static_cast<float>(kHalf - kHalfHyperbrick);
  const auto node_reach = static_cast<float>(kept);
  const float farthest = std::max(kCellReach, node_reach);
  std::vector<Visit> visits;
  for (std::uint32_t i = 0; i < faces_.size(); ++i) {
    const NearFace& face = faces_.seen(i);
    const FaceReach reach(faces_[i], face.view(), faces_.middle_L(), kHalf, farthest);
    reach.VisitCubes(kFirst, kBlocks, [&](const GridIndex& at) {
      const std::int32_t block =
          blocks_[static_cast<std::size_t>(at.x + kBlocks * (at.y + kBlocks * at.z))];
      if (block < 0) return;
      face.MeasureCubeInto(LowestNode(at), &node_distances_[static_cast<std::size_t>(block)],
                           &node_heights_[static_cast<std::size_t>(block)]);
      if (std::max({at.x, at.y, at.z}) == kHyperbrickBricks) return;
      const std::size_t brick = CellInBlock(at);
      if (bricks_[brick].kind != Kind::kMeasured) return;
      visits.push_back({static_cast<std::uint32_t>(brick), i});
    });
  }
  SortByBrick(visits);
}

void HyperbrickSurvey::SortByBrick(const std::vector<Visit>& visits) {
  for (const Visit& visit : visits) ++first_faces_[visit.brick + 1];
  std::partial_sum(first_faces_.begin(), first_faces_.end(), first_faces_.begin());
  std::array<std::uint32_t, kBricksPerHyperbrick + 1> next = first_faces_;
  brick_faces_.resize(visits.size());
  for (const Visit& visit : visits) brick_faces_[next[visit.brick]++] = visit.face;
}

NearestLanes HyperbrickSurvey::NodesOf(std::size_t brick) const {
  NearestLanes nodes(kBrickNodes);
  const GridIndex first = BlockCell(brick);
  std::size_t node = 0;
  for (std::int32_t z = 0; z <= kBrickCells; ++z) {
    for (std::int32_t y = 0; y <= kBrickCells; ++y) {
      for (std::int32_t x = 0; x <= kBrickCells; ++x, ++node) {
        const GridIndex at = first + (GridIndex{x, y, z} >> 2);
        const auto in = static_cast<std::size_t>((x & 3) + 4 * ((y & 3) + 4 * (z & 3)));
        const std::int32_t block =
            blocks_[static_cast<std::size_t>(at.x + kBlocks * (at.y + kBlocks * at.z))];
        nodes.distance[node] = node_distances_[static_cast<std::size_t>(block) + in];
        nodes.height[node] = node_heights_[static_cast<std::size_t>(block) + in];
      }
    }
  }
  return nodes;
}

HyperbrickSurvey::BrickCells HyperbrickSurvey::CellsOf(std::size_t brick, double within) const {
  const std::uint32_t first = first_faces_[brick];
  const std::span<const std::uint32_t> faces =
      std::span(brick_faces_).subspan(first, first_faces_[brick + 1] - first);
  const std::array<float, 3> lowest = LowestNode(BlockCell(brick));
  const std::array<float, 3> centre{lowest[0] + 0.5F, lowest[1] + 0.5F, lowest[2] + 0.5F};
  BrickCells cells;
  cells.least.fill(std::numeric_limits<float>::max());
  std::vector<CellDistances> distances(faces.size());
  float least = std::numeric_limits<float>::max();
  std::uint32_t nearest = kNone;
  for (std::size_t i = 0; i < faces.size(); ++i) {
    faces_.seen(faces[i]).MeasureCube(centre, distances[i].data());
    const float of_face = *std::ranges::min_element(distances[i]);
    if (of_face < least) {
      least = of_face;
      nearest = faces[i];
    }
    for (std::size_t cell = 0; cell < kCellsPerBrick; ++cell) {
      cells.least[cell] = std::min(cells.least[cell], distances[i][cell]);
    }
  }
  if (nearest == kNone) return cells;
  cells.plane = PlaneOf(brick, nearest);
  // a face that is farther than the nearest one by more is nowhere in the cell the nearest
  CellDistances farthest;
  for (std::size_t cell = 0; cell < kCellsPerBrick; ++cell) {
    farthest[cell] = -1;
    if (!(cells.least[cell] < within + kHalfDiagonal)) continue;
    cells.near |= std::uint64_t{1} << cell;
    farthest[cell] = std::min(cells.least[cell] + 2 * kHalfDiagonal, kCellReach);
  }
  std::vector<std::uint32_t> near;
  std::vector<std::uint64_t> near_cells;
  std::vector<NearFace::CubeSides> sides;
  for (std::size_t i = 0; i < faces.size(); ++i) {
    const std::uint64_t bits = LanesWithin(distances[i].data(), farthest.data(), 0);
    if (bits == 0) continue;
    near.push_back(faces[i]);
    near_cells.push_back(bits);
    sides.push_back(faces_.seen(faces[i]).SidesOf(centre));
  }
  LeaveOut(near, sides, near_cells);
  cells.candidates = SortByCell(near, sides, near_cells);
  return cells;
}

void HyperbrickSurvey::LeaveOut(std::span<const std::uint32_t> faces,
                                std::span<const NearFace::CubeSides> sides,
                                std::vector<std::uint64_t>& cells) const {
  // tests each against those that are left: a face that continues it stays, or is continued by
  // others that stay
  const auto cells_of = [&](std::uint32_t face) -> std::uint64_t {
    if (face == FieldFace::kNone) return 0;
    const auto at = std::ranges::lower_bound(faces, face);
    return at != faces.end() && *at == face ? cells[static_cast<std::size_t>(at - faces.begin())]
                                            : 0;
  };
  for (std::size_t i = 0; i < faces.size(); ++i) {
    std::uint64_t beyond = 0;
    for (const std::uint64_t of_edge : sides[i].beyond) beyond |= of_edge;
    std::uint64_t gone = cells[i] & beyond;
    for (std::size_t k = 0; k < 3 && gone != 0; ++k) {
      const std::uint64_t before = gone & sides[i].before[k];
      if (before != 0) gone &= ~before | cells_of(faces_.beside(faces[i])[k]);
    }
    cells[i] &= ~gone;
  }
}

}  // namespace tandem
