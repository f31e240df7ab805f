#include "engine/contact/contact_model.h"

#include <algorithm>
#include <cmath>

#include "engine/base/check.h"
#include "engine/contact/tangent_plane.h"

namespace tandem {

namespace {

/// Voxels: how far beside a piece of surface its plane still counts.
constexpr double kLateralReach = 1.25;
/// Voxels: a shell's surface point says something of a vertex up to here beside itself.
constexpr double kVertexReach = 1.25;
/// Cosine between the ways two features push, at least: below, they are on far sides of thin walls,
/// or of parts that stand on one another.
constexpr double kFacing = 0.2;
/// Sine of the angle between two edges below which they are taken as parallel.
constexpr double kParallel = 0.15;
/// The half arc, rad, within which a push on an edge by a vertex or an open rim is believed.
constexpr double kLooseArc = 1.25;
/// Rad: how far beyond the arc between an edge's two faces a push fades out.
constexpr double kArcFade = 0.15;
const double kFadeCosine = std::cos(kArcFade);
const double kFadeSine = std::sin(kArcFade);
constexpr double kAgain = 1e-3;  // voxels, so that a crossing on a voxel's border is not lost

/// 1 squarely over a piece of surface, smoothly 0 at the reach.
double Weight(double square, double reach) {
  const double left = 1.0 - square / (reach * reach);
  return left > 0 ? left * left : 0.0;
}

/// An edge seen along its line: its faces' normals lie in an arc round its own.
struct Wedge {
  Vec3 normal;
  double half;  // of the arc, rad
};
struct Leaning {
  Vec3 normal = Vec3::Zero();
  double share = 0;
};

/// How an edge leans on another along the same line `t`, `away` from it: along the direction in
/// both arcs that parts them most, which is how far apart two wedges are.
Leaning LeanOnParallel(const Vec3& t, const Vec3& away, const Wedge& below, const Wedge& above) {
  const Vec3 e1 = (below.normal - below.normal.dot(t) * t).normalized();
  const Vec3 e2 = t.cross(e1);
  const double turn = std::atan2(above.normal.dot(e2), above.normal.dot(e1));
  double low = std::max(-below.half, turn - above.half);
  double high = std::min(below.half, turn + above.half);
  Leaning leaning;
  leaning.share = std::clamp(1.0 - (low - high) / kArcFade, 0.0, 1.0);
  if (low > high) low = high = 0.5 * (low + high);
  const double x = away.dot(e1);
  const double y = away.dot(e2);
  double best = std::atan2(y, x);
  if (best < low || best > high) {
    const bool lower =
        x * std::cos(low) + y * std::sin(low) > x * std::cos(high) + y * std::sin(high);
    best = lower ? low : high;
  }
  leaning.normal = std::cos(best) * e1 + std::sin(best) * e2;
  return leaning;
}

/// Voxels from a place to where other pieces of surface come into a window of one voxel all round
/// its own.
double ToNewPieces(const Vec3& p, const GridIndex& voxel) {
  const Vec3 in(p.x() - voxel.x, p.y() - voxel.y, p.z() - voxel.z);
  return std::min(in.minCoeff(), 1.0 - in.maxCoeff());
}

/// A feature comes nearer by its own way, and by its direction's turn times what it is looked at
/// from; turns are bounded by the way of the farthest point of the body that turns.
double CertaintyOf(double radius_voxels) {
  constexpr double kFarthest = 4.0;   // voxels from a point to a piece in its window
  constexpr double kSmallest = 10.0;  // voxels: smaller bodies turn far for little travel
  return radius_voxels > kSmallest ? 1.0 / (1.0 + kFarthest / radius_voxels) : 0.0;
}

std::size_t SlotOf(const GridIndex& voxel, std::size_t slots) {
  return (MortonCode(voxel) * 0x9e3779b97f4a7c15ULL >> 20U) & (slots - 1);
}

}  // namespace

std::size_t FindPlainContacts(std::span<const Candidate> candidates, const Voxmap& voxmap,
                              int layer, Contact* out) noexcept {
  const double s = voxmap.voxel_size();
  std::size_t count = 0;
  for (const Candidate& c : candidates) {
    const Vec3 centre = s * (Vec3(c.voxel_V.x, c.voxel_V.y, c.voxel_V.z) + Vec3::Constant(0.5));
    const double depth = TangentPlaneDepth(c.p_V, centre, c.nhat_V, c.mark, layer, s);
    if (depth > 0) out[count++] = {c.p_V, c.nhat_V, depth};
  }
  return count;
}

RefinedContacts::Arc::Arc(double half_angle)
    : half(half_angle),
      cosine(std::cos(half_angle)),
      sine(std::sin(half_angle)),
      last(std::cos(half_angle + kArcFade)),
      scale(1.0 / (cosine - last)) {}

RefinedContacts::Arc RefinedContacts::Arc::OfCosine(double cosine) {
  Arc arc;
  arc.cosine = cosine;
  arc.sine = std::sqrt(std::max(0.0, 1.0 - cosine * cosine));
  arc.last = cosine * kFadeCosine - arc.sine * kFadeSine;
  arc.scale = 1.0 / (arc.cosine - arc.last);
  return arc;
}

double RefinedContacts::Arc::ShareOf(double push_cosine) const noexcept {
  return std::clamp((push_cosine - last) * scale, 0.0, 1.0);
}

RefinedContacts::RefinedContacts(const Pointshell& shell, const Voxmap& voxmap,
                                 const SurfaceDetails& details, double least_radius,
                                 std::size_t most)
    : shell_(&shell),
      voxmap_(&voxmap),
      details_(&details),
      s_(voxmap.voxel_size()),
      certainty_(CertaintyOf(least_radius / voxmap.voxel_size())),
      slots_(std::bit_ceil(2 * MostVertices(most)), 0),
      met_(MostVertices(most)),
      used_slots_(met_.size()) {
  TANDEM_CHECK(!details.empty());
  for (std::size_t i = 0; i < SurfaceDetail::kAngles; ++i) {
    arcs_[i] = Arc(SurfaceDetail::kAngleStep * static_cast<double>(i));
  }
  arcs_.back() = Arc(kLooseArc);
}

std::size_t RefinedContacts::ListSources(const GridIndex& voxel, Field field) noexcept {
  std::size_t count = 0;
  // the window lies in at most two chunks an axis
  const GridIndex low = voxel - GridIndex{1, 1, 1};
  const GridIndex high = voxel + GridIndex{1, 1, 1};
  const auto& size = voxmap_->header().size;
  for (std::int32_t cz = low.z >> 3; cz <= high.z >> 3; ++cz) {
    for (std::int32_t cy = low.y >> 3; cy <= high.y >> 3; ++cy) {
      for (std::int32_t cx = low.x >> 3; cx <= high.x >> 3; ++cx) {
        if (cx < 0 || cy < 0 || cz < 0 || cx >= static_cast<std::int32_t>(8 * size[0]) ||
            cy >= static_cast<std::int32_t>(8 * size[1]) ||
            cz >= static_cast<std::int32_t>(8 * size[2])) {
          continue;
        }
        const SurfaceDetails::Chunk* chunk = details_->At(*voxmap_, {cx, cy, cz});
        if (chunk == nullptr) continue;
        const GridIndex first = GridIndex{cx, cy, cz} * kChunkSide;
        const std::int32_t x0 = std::max(low.x, first.x) - first.x;
        const std::int32_t x1 = std::min(high.x, first.x + 7) - first.x;
        const std::uint64_t row = ((std::uint64_t{2} << x1) - 1) & ~((std::uint64_t{1} << x0) - 1);
        for (std::int32_t z = std::max(low.z, first.z); z <= std::min(high.z, first.z + 7); ++z) {
          for (std::int32_t y = std::max(low.y, first.y); y <= std::min(high.y, first.y + 7); ++y) {
            const int shift = 8 * (y - first.y);
            std::uint64_t bits = chunk->bits[static_cast<std::size_t>(z - first.z)] & row << shift;
            if (bits == 0) continue;
            const std::size_t layer = 64 * static_cast<std::size_t>(z - first.z);
            // the bits of a row follow one another, and so do their details
            const SurfaceDetail* next =
                &details_->Of(*chunk, layer + static_cast<std::size_t>(std::countr_zero(bits)));
            for (; bits != 0; bits &= bits - 1) {
              const SurfaceDetail& detail = *next++;
              const std::size_t cell = layer + static_cast<std::size_t>(std::countr_zero(bits));
              if (field == Field::kVertex && detail.shape() != SurfaceDetail::Shape::kVertex) {
                continue;
              }
              if (field == Field::kEdge &&
                  (detail.half_length == 0 ||
                   (detail.half_length == SurfaceDetail::kTwoSided &&
                    voxmap_->Value(Field::kEdge, first + BlockCell(cell)) != kSurfaceMark))) {
                continue;
              }
              Source& source = sources_[count++];
              source.voxel = first + BlockCell(cell);
              source.detail = &detail;
              const auto& place = detail.place;
              source.q = Vec3(source.voxel.x + place[0] / 255.0, source.voxel.y + place[1] / 255.0,
                              source.voxel.z + place[2] / 255.0);
            }
          }
        }
      }
    }
  }
  return count;
}

std::optional<std::size_t> RefinedContacts::MeetSurface(Candidate& candidate,
                                                        Contact* out) noexcept {
  const Vec3 p = candidate.p_V / s_;
  const std::size_t count = ListSources(candidate.voxel_V, Field::kSurface);
  PlaneMean& faces = under_;
  faces.Clear();
  // a place's height above its plane, and how squarely the vertex stands over it
  double slack = candidate.mark == kInteriorMark ? 0.0 : ToNewPieces(p, candidate.voxel_V);
  const auto over = [&](const Source& source, const Vec3& n) {
    const Vec3 away = p - source.q;
    const double height = away.dot(n);
    const double square_beside = away.squaredNorm() - height * height;
    const bool two_sided = source.detail->half_length == SurfaceDetail::kTwoSided;
    const double above = two_sided ? -1.0 : height - kRefinedClearance;
    if (above < slack) {
      slack =
          std::min(slack, std::max(above, std::sqrt(std::max(0.0, square_beside)) - kLateralReach));
    }
    const bool facing = n.dot(candidate.nhat_V) > kFacing;
    return std::pair(height, facing ? Weight(square_beside, kLateralReach) : 0.0);
  };
  bool only_corners = true;
  for (std::size_t i = 0; i < count; ++i) {
    const SurfaceDetail& detail = *sources_[i].detail;
    const SurfaceDetail::Shape shape = detail.shape();
    if (shape == SurfaceDetail::Shape::kSmooth) {
      only_corners = false;
      const Vec3 n = FacingNormal(detail, candidate.nhat_V);
      const auto [height, weight] = over(sources_[i], n);
      faces.Add(sources_[i].q, n, height, weight);
    } else if (shape == SurfaceDetail::Shape::kRidge) {
      only_corners = false;
      const Vec3 n = UnpackDirection(detail.normal);
      const Arc& arc = arcs_[detail.half_angle_steps()];
      const Vec3 across = arc.sine * UnpackDirection(detail.tangent).cross(n);
      const Vec3 along = arc.cosine * n;
      const std::array<Vec3, 2> normals{along + across, along - across};
      const auto one = over(sources_[i], normals[0]);
      const auto two = over(sources_[i], normals[1]);
      faces.AddRidge(sources_[i].q, normals, {one.first, two.first}, {one.second, two.second});
    }
  }
  // where detail is so fine that no face shows, what the corners say on the whole
  for (std::size_t i = 0; only_corners && i < count; ++i) {
    const Vec3 n = FacingNormal(*sources_[i].detail, candidate.nhat_V);
    const auto [height, weight] = over(sources_[i], n);
    faces.Add(sources_[i].q, n, height, weight);
  }
  candidate.slack = slack * certainty_;
  if (slack > 0) return 0;
  std::array<PlaneMean::Push, PlaneMean::kMostPushes> pushes;
  const std::size_t pushing = faces.Resolve(pushes);
  if (pushing == 0) return std::nullopt;
  std::size_t found = 0;
  for (std::size_t i = 0; i < pushing; ++i) {
    const double depth = (kRefinedClearance - pushes[i].gap) * pushes[i].share;
    if (depth > 0) out[found++] = {candidate.p_V, pushes[i].normal, s_ * depth};
  }
  return found;
}

void RefinedContacts::MeetVertices(Candidate& candidate) noexcept {
  const Vec3 p = candidate.p_V / s_;
  const Vec3& n = candidate.nhat_V;
  const std::size_t count = ListSources(candidate.voxel_V, Field::kVertex);
  candidate.slack = ToNewPieces(p, candidate.voxel_V) * certainty_;
  for (std::size_t i = 0; i < count; ++i) {
    const Source& source = sources_[i];
    const Vec3 away = p - source.q;
    const double height = away.dot(n);  // of the vertex above the shell's surface
    const double square_beside = away.squaredNorm() - height * height;
    const double w = Weight(square_beside, kVertexReach);
    if (w <= 0) {
      const double beside = std::sqrt(square_beside) - kVertexReach;
      candidate.slack = std::min(candidate.slack, beside * certainty_);
      continue;
    }
    candidate.slack = 0;
    if (!(n.dot(FacingNormal(*source.detail, n)) > kFacing)) continue;
    std::size_t slot = SlotOf(source.voxel, slots_.size());
    while (slots_[slot] != 0 && !(met_[slots_[slot] - 1].voxel == source.voxel)) {
      slot = (slot + 1) & (slots_.size() - 1);
    }
    if (slots_[slot] == 0) {
      if (met_count_ == met_.size()) continue;  // more vertices than candidates were planned for
      used_slots_[met_count_] = static_cast<std::uint32_t>(slot);
      met_[met_count_].faces.Clear();
      met_[met_count_].voxel = source.voxel;
      met_[met_count_].q = source.q;
      slots_[slot] = static_cast<std::uint32_t>(++met_count_);
    }
    MetVertex& met = met_[slots_[slot] - 1];
    met.faces.Add(p, -n, height, w);
  }
}

std::size_t RefinedContacts::MeetEdges(Candidate& candidate, const Mat3& R_VS,
                                       Contact* out) noexcept {
  const Vec3 p = candidate.p_V / s_;
  const Pointshell::Edge& edge = shell_->edges[candidate.edge];
  const Vec3 t = R_VS * edge.tangent.cast<double>();
  double slack = ToNewPieces(p, candidate.voxel_V);
  candidate.slack = slack * certainty_;
  if (edge.cosine < 0) return 0;  // a notch: nothing leans on it
  const Arc arc = edge.cosine > 0 ? Arc::OfCosine(edge.cosine) : arcs_.back();
  const double half = edge.half_length / s_ + kAgain;
  const std::size_t count = ListSources(candidate.voxel_V, Field::kEdge);
  std::size_t found = 0;
  for (std::size_t i = 0; i < count && found < kPerPoint; ++i) {
    const Source& source = sources_[i];
    const std::uint8_t packed = source.detail->half_length;
    // of a thin sheet's edge only that it passes through the voxel is known
    const double other_half = (packed == SurfaceDetail::kTwoSided ? 0.5 : packed / 128.0) + kAgain;
    // most edges nearby are not beside this one, which takes least to tell
    const Vec3 other_t = UnpackDirection(source.detail->tangent);
    const Vec3 away = p - source.q;
    const double cosine = t.dot(other_t);
    const double square_sine = 1.0 - cosine * cosine;
    const double along = away.dot(t);
    const double other_along = away.dot(other_t);
    const double from_parallel = square_sine / (kParallel * kParallel);
    const bool parallel = from_parallel < 1.0;
    if (from_parallel > 0.5 && from_parallel < 2.0) slack = 0;  // may soon be the other
    // the places on both lines where they come closest: p + u t, q + v t'
    const double u = parallel ? 0.0 : (cosine * other_along - along) / square_sine;
    const double v = parallel ? other_along : (other_along - cosine * along) / square_sine;
    if (source.detail->shape() == SurfaceDetail::Shape::kNotch) continue;
    if (std::abs(u) > half || std::abs(v) > other_half) {
      // until the two pieces are beside each other
      const double beside =
          std::abs(other_along) - other_half - (parallel ? 0.0 : half * std::abs(cosine));
      const double before =
          std::abs(along) - half - (parallel ? other_half : other_half * std::abs(cosine));
      slack = std::min(slack, parallel ? beside : std::max(beside, before));
      continue;
    }
    const Vec3 n = FacingNormal(*source.detail, candidate.nhat_V);
    if (!(n.dot(candidate.nhat_V) > kFacing)) {
      slack = 0;
      continue;
    }
    const Arc& other_arc = ArcOf(*source.detail);
    if (parallel) {
      // side by side: each part of the shell's edge rests on the part of the map's beside it
      const Leaning leaning =
          LeanOnParallel(t, away, {n, other_arc.half}, {candidate.nhat_V, std::acos(arc.cosine)});
      const double gap = away.dot(leaning.normal);
      slack = std::min(slack, gap - kRefinedClearance);
      const double depth = (kRefinedClearance - gap) * leaning.share;
      if (depth > 0) out[found++] = {candidate.p_V, leaning.normal, s_ * depth};
      continue;
    }
    Vec3 normal = t.cross(other_t).normalized();
    if (normal.dot(n + candidate.nhat_V) < 0) normal = -normal;
    const double gap = away.dot(normal);
    slack = std::min(slack, gap - kRefinedClearance);
    if (gap >= kRefinedClearance) continue;
    // both bodies' material must lie behind the plane between the edges
    const double share =
        other_arc.ShareOf(normal.dot(n)) * arc.ShareOf(normal.dot(candidate.nhat_V));
    if (share <= 0) continue;
    const Vec3 middle = 0.5 * (p + u * t + source.q + v * other_t);
    out[found++] = {s_ * middle, normal, s_ * (kRefinedClearance - gap) * share};
  }
  candidate.slack = slack * certainty_;
  return found;
}

std::size_t RefinedContacts::TakeVertices(Contact* out) noexcept {
  std::size_t found = 0;
  for (std::size_t i = 0; i < met_count_; ++i) {
    const MetVertex& met = met_[i];
    slots_[used_slots_[i]] = 0;
    std::array<PlaneMean::Push, PlaneMean::kMostPushes> pushes;
    const std::size_t pushing = met.faces.Resolve(pushes);
    for (std::size_t k = 0; k < pushing; ++k) {
      const double depth = (kRefinedClearance - pushes[k].gap) * pushes[k].share;
      if (depth > 0) out[found++] = {s_ * met.q, -pushes[k].normal, s_ * depth};
    }
  }
  met_count_ = 0;
  return found;
}

std::size_t RefinedContacts::Find(std::span<Candidate> candidates, const Mat3& R_VS, int layer,
                                  Contact* out) noexcept {
  std::size_t found = 0;
  for (Candidate& candidate : candidates) {
    if (candidate.label == Label::kSurface) {
      MeetVertices(candidate);
    } else if (candidate.label == Label::kEdge) {
      found += MeetEdges(candidate, R_VS, out + found);
    } else {
      const std::optional<std::size_t> met = MeetSurface(candidate, out + found);
      if (met.has_value()) {
        found += *met;
      } else if (candidate.mark == kInteriorMark) {
        // deeper in than the map's surface reaches: the plain depth goes on
        found += FindPlainContacts({&candidate, 1}, *voxmap_, layer, out + found);
      }
    }
  }
  // an edge point gives at most kPerPoint, a vertex of the map comes with a surface point
  return found + TakeVertices(out + found);
}

}  // namespace tandem
