#include "engine/contact/refined_contacts.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "engine/base/check.h"

namespace tandem {

namespace {

/// Voxels: how far beside a piece of surface its plane still counts.
constexpr double kLateralReach = 1.25;
/// Voxels: a shell's surface point says something of a vertex up to here beside itself.
constexpr double kVertexReach = 1.25;
/// The half arc, rad, within which a push on an edge by a vertex or an open rim is believed.
constexpr double kLooseArc = 1.25;
constexpr double kNever = std::numeric_limits<double>::infinity();

/// 1 squarely over a piece of surface, smoothly 0 at the reach.
double Weight(double square, double reach) {
  const double left = 1.0 - square / (reach * reach);
  return left > 0 ? left * left : 0.0;
}

/// Of a place in its voxel, voxels to each side of it: its lower ones, its upper ones.
struct ToSides {
  Vec3 lower;
  Vec3 upper;
  ToSides(const Vec3& p, const GridIndex& voxel)
      : lower(p.x() - voxel.x, p.y() - voxel.y, p.z() - voxel.z), upper(Vec3::Ones() - lower) {}
  double least() const { return std::min(lower.minCoeff(), upper.minCoeff()); }
  /// Voxels to go until what lies `at` voxels off, two along at least one axis, lies within one.
  double Until(const GridIndex& at) const {
    const auto along = [](int d, double down, double up) {
      return d == 2 ? up : d == -2 ? down : 0.0;
    };
    return std::max({along(at.x, lower.x(), upper.x()), along(at.y, lower.y(), upper.y()),
                     along(at.z, lower.z(), upper.z())});
  }
};

/// A feature comes nearer by its own way, and by its direction's turn times what it is looked at
/// from; turns are bounded by the way of the farthest point of the body that turns.
double CertaintyOf(double turn) {
  constexpr double kFarthest = 6.0;   // voxels, of a piece in the window
  constexpr double kSmallest = 20.0;  // voxels: smaller bodies turn far for little travel
  return turn * kSmallest < 1 ? 1.0 / (1.0 + kFarthest * turn) : 0.0;
}

std::size_t SlotOf(const GridIndex& voxel, std::size_t slots) {
  return (MortonCode(voxel) * 0x9e3779b97f4a7c15ULL >> 20U) & (slots - 1);
}

}  // namespace

RefinedContacts::RefinedContacts(const Pointshell& shell, const Voxmap& voxmap,
                                 const SurfaceDetails& details, double least_radius,
                                 std::size_t most, int threads)
    : shell_(&shell),
      voxmap_(&voxmap),
      s_(voxmap.voxel_size()),
      turn_(voxmap.voxel_size() / least_radius),
      certainty_(CertaintyOf(turn_)),
      scratch_(static_cast<std::size_t>(threads), Scratch{{voxmap, details}, {}}),
      found_(most, 0),
      slots_(std::bit_ceil(2 * MostVertices(most)), 0),
      met_(MostVertices(most)),
      used_slots_(met_.size()) {
  TANDEM_CHECK(!details.empty());
  for (std::size_t i = 0; i < SurfaceDetail::kAngles; ++i) {
    arcs_[i] = EdgeArc(SurfaceDetail::kAngleStep * static_cast<double>(i));
  }
  arcs_.back() = EdgeArc(kLooseArc);
}

template <class PieceSlack>
double RefinedContacts::Widened(double near, const Candidate& candidate, Field field,
                                SurfaceWindow& window,
                                const PieceSlack& piece_slack) const noexcept {
  double slack = near;
  if (!(slack > 0) || certainty_ == 0) return 0.0;
  const ToSides sides(candidate.p_V / s_, candidate.voxel_V);
  const double soonest = sides.least();
  if (slack > soonest) {
    // what is three voxels off comes within one when the point is two voxels on
    slack = std::min(slack, soonest + 1.0);
    for (const SurfaceWindow::Piece& piece : window.Round(candidate.voxel_V, field)) {
      const double until = sides.Until(piece.voxel_V - candidate.voxel_V);
      if (until < slack) slack = std::min(slack, std::max(until, piece_slack(piece, slack)));
    }
  }
  return slack * certainty_;
}

RefinedContacts::Standing RefinedContacts::StandOn(const SurfaceWindow::Piece& piece, const Vec3& p,
                                                   const Vec3& nhat) const noexcept {
  const SurfaceDetail& detail = *piece.detail;
  Standing standing;
  std::size_t sides = 1;
  if (detail.shape() == SurfaceDetail::Shape::kRidge) {
    const Vec3 n = UnpackDirection(detail.normal);
    const EdgeArc& arc = arcs_[detail.half_angle_steps()];
    const Vec3 across = arc.sine * UnpackDirection(detail.tangent).cross(n);
    const Vec3 along = arc.cosine * n;
    standing.normals = {along + across, along - across};
    sides = 2;
  } else {
    standing.normals[0] = FacingNormal(detail, nhat);
  }
  const Vec3 away = p - piece.place();
  const bool two_sided = detail.half_length == SurfaceDetail::kTwoSided;
  standing.slack = kNever;
  for (std::size_t i = 0; i < sides; ++i) {
    // the place's height above the plane, and how squarely the vertex stands over it
    const Vec3& n = standing.normals[i];
    const double height = away.dot(n);
    const double square_beside = away.squaredNorm() - height * height;
    standing.heights[i] = height;
    standing.weights[i] = n.dot(nhat) > kFacing ? Weight(square_beside, kLateralReach) : 0.0;
    const double above = two_sided ? -1.0 : height - kRefinedClearance;
    const double beside = std::sqrt(std::max(0.0, square_beside)) - kLateralReach;
    standing.slack = std::min(standing.slack, std::max(above, beside));
  }
  return standing;
}

double RefinedContacts::SlackOfVertex(double near, const Candidate& candidate,
                                      SurfaceWindow& window) const noexcept {
  const Vec3 p = candidate.p_V / s_;
  return Widened(near, candidate, Field::kSurface, window,
                 [&](const SurfaceWindow::Piece& piece, double) {
                   return StandOn(piece, p, candidate.nhat_V).slack;
                 });
}

std::optional<std::size_t> RefinedContacts::MeetSurface(Candidate& candidate, Scratch& scratch,
                                                        Contact* out) noexcept {
  using Shape = SurfaceDetail::Shape;
  const Vec3 p = candidate.p_V / s_;
  const std::span<const SurfaceWindow::Piece> pieces =
      scratch.window.Near(candidate.voxel_V, Field::kSurface);
  PlaneMean& faces = scratch.under;
  faces.Clear();
  double slack = candidate.mark == kInteriorMark ? 0.0 : kNever;
  double corners_slack = kNever;
  bool only_corners = true;
  for (const SurfaceWindow::Piece& piece : pieces) {
    const Standing on = StandOn(piece, p, candidate.nhat_V);
    const Shape shape = piece.detail->shape();
    if (shape == Shape::kVertex || shape == Shape::kNotch) {
      corners_slack = std::min(corners_slack, on.slack);
      continue;
    }
    only_corners = false;
    slack = std::min(slack, on.slack);
    if (shape == Shape::kRidge) {
      faces.AddRidge(piece.place(), on.normals, on.heights, on.weights);
    } else {
      faces.Add(piece.place(), on.normals[0], on.heights[0], on.weights[0]);
    }
  }
  // where detail is so fine that no face shows, what the corners say on the whole
  for (std::size_t i = 0; only_corners && i < pieces.size(); ++i) {
    const Standing on = StandOn(pieces[i], p, candidate.nhat_V);
    faces.Add(pieces[i].place(), on.normals[0], on.heights[0], on.weights[0]);
  }
  if (only_corners) slack = std::min(slack, corners_slack);
  if (slack > 0) {
    // corners may be all that is near as soon as other pieces come and go
    const double soonest = ToSides(p, candidate.voxel_V).least();
    slack = std::min(slack, std::max(soonest, corners_slack));
    candidate.slack = SlackOfVertex(slack, candidate, scratch.window);
    return 0;
  }
  candidate.slack = 0;
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

RefinedContacts::MetVertex* RefinedContacts::FindOrAdd(const GridIndex& voxel,
                                                       const Vec3& q) noexcept {
  std::size_t slot = SlotOf(voxel, slots_.size());
  while (slots_[slot] != 0 && !(met_[slots_[slot] - 1].voxel == voxel)) {
    slot = (slot + 1) & (slots_.size() - 1);
  }
  if (slots_[slot] == 0) {
    if (met_count_ == met_.size()) return nullptr;  // more than candidates were planned for
    used_slots_[met_count_] = static_cast<std::uint32_t>(slot);
    met_[met_count_].faces.Clear();
    met_[met_count_].voxel = voxel;
    met_[met_count_].q = q;
    slots_[slot] = static_cast<std::uint32_t>(++met_count_);
  }
  return &met_[slots_[slot] - 1];
}

double RefinedContacts::SlackOfSurface(double near, const Candidate& candidate,
                                       SurfaceWindow& window) const noexcept {
  const Vec3 p = candidate.p_V / s_;
  return Widened(
      near, candidate, Field::kVertex, window, [&](const SurfaceWindow::Piece& piece, double) {
        const Vec3 away = p - piece.place();
        const double height = away.dot(candidate.nhat_V);
        return std::sqrt(std::max(0.0, away.squaredNorm() - height * height)) - kVertexReach;
      });
}

RefinedContacts::Over RefinedContacts::StandUnder(const SurfaceWindow::Piece& piece, const Vec3& p,
                                                  const Vec3& nhat) noexcept {
  const Vec3 q = piece.place();
  const Vec3 away = p - q;
  const double height = away.dot(nhat);
  const double square_beside = away.squaredNorm() - height * height;
  return {q, height, square_beside, Weight(square_beside, kVertexReach)};
}

bool RefinedContacts::BearsOnVertices(Candidate& candidate, SurfaceWindow& window) noexcept {
  const Vec3 p = candidate.p_V / s_;
  double slack = kNever;
  for (const SurfaceWindow::Piece& piece : window.Near(candidate.voxel_V, Field::kVertex)) {
    const Over over = StandUnder(piece, p, candidate.nhat_V);
    const bool bears = over.weight > 0;
    slack = std::min(slack, bears ? 0.0 : std::sqrt(over.square_beside) - kVertexReach);
  }
  candidate.slack = SlackOfSurface(slack, candidate, window);
  return slack <= 0;
}

void RefinedContacts::MeetVertices(const Candidate& candidate) noexcept {
  const Vec3 p = candidate.p_V / s_;
  const Vec3& n = candidate.nhat_V;
  SurfaceWindow& window = scratch_[0].window;
  for (const SurfaceWindow::Piece& piece : window.Near(candidate.voxel_V, Field::kVertex)) {
    const Over over = StandUnder(piece, p, n);
    if (over.weight <= 0) continue;
    if (!(n.dot(FacingNormal(*piece.detail, n)) > kFacing)) continue;
    MetVertex* met = FindOrAdd(piece.voxel_V, over.q);
    if (met != nullptr) met->faces.Add(p, -n, over.height, over.weight);
  }
}

ShellEdge RefinedContacts::EdgeAt(const Candidate& candidate, const Mat3& R_VS) const noexcept {
  const Pointshell::Edge& edge = shell_->edges[candidate.edge];
  return {candidate.p_V / s_,
          R_VS * edge.tangent.cast<double>(),
          candidate.nhat_V,
          edge.half_length / s_,
          edge.cosine > 0 ? EdgeArc::OfCosine(edge.cosine) : arcs_.back(),
          edge.ends};
}

double RefinedContacts::SlackOfEdge(double near, const Candidate& candidate, const ShellEdge& edge,
                                    SurfaceWindow& window) const noexcept {
  return Widened(near, candidate, Field::kEdge, window,
                 [&](const SurfaceWindow::Piece& piece, double enough) {
                   return Meet(edge, *piece.detail, piece.place(), piece.ends, ArcOf(*piece.detail),
                               turn_, enough)
                       .slack;
                 });
}

std::size_t RefinedContacts::MeetEdges(Candidate& candidate, const Mat3& R_VS,
                                       SurfaceWindow& window, Contact* out) noexcept {
  candidate.slack = kNever;
  if (shell_->edges[candidate.edge].cosine < 0) return 0;  // a notch: nothing leans on it
  const ShellEdge edge = EdgeAt(candidate, R_VS);
  double slack = kNever;
  std::size_t found = 0;
  for (const SurfaceWindow::Piece& piece : window.Near(candidate.voxel_V, Field::kEdge)) {
    const EdgeMeeting meeting =
        Meet(edge, *piece.detail, piece.place(), piece.ends, ArcOf(*piece.detail), turn_, slack);
    slack = std::min(slack, meeting.slack);
    if (meeting.depth <= 0) continue;
    out[found++] = {s_ * meeting.place, meeting.normal, s_ * meeting.depth};
    if (found == kPerPoint) break;
  }
  candidate.slack = SlackOfEdge(slack, candidate, edge, window);
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

void RefinedContacts::LookAt(std::span<Candidate> candidates, std::size_t begin, std::size_t end,
                             const Mat3& R_VS, int layer, int thread, Contact* out) noexcept {
  Scratch& scratch = scratch_[static_cast<std::size_t>(thread)];
  for (std::size_t i = begin; i < end; ++i) {
    Candidate& candidate = candidates[i];
    Contact* const own = out + kPerPoint * i;
    std::size_t found = 0;
    if (candidate.label == Label::kSurface) {
      found = BearsOnVertices(candidate, scratch.window) ? kBears : 0;
    } else if (candidate.label == Label::kEdge) {
      found = MeetEdges(candidate, R_VS, scratch.window, own);
    } else {
      const std::optional<std::size_t> met = MeetSurface(candidate, scratch, own);
      if (met.has_value()) {
        found = *met;
      } else if (candidate.mark == kInteriorMark) {
        // deeper in than the map's surface reaches: the plain depth goes on
        found = FindPlainContacts({&candidate, 1}, *voxmap_, layer, own);
      }
    }
    found_[i] = static_cast<std::uint8_t>(found);
  }
}

std::size_t RefinedContacts::Take(std::span<const Candidate> candidates, Contact* out) noexcept {
  std::size_t taken = 0;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    if (found_[i] == kBears) {
      MeetVertices(candidates[i]);
      continue;
    }
    for (std::size_t k = 0; k < found_[i]; ++k) out[taken++] = out[kPerPoint * i + k];
  }
  // a point gives at most kPerPoint, a vertex of the map comes with a surface point
  return taken + TakeVertices(out + taken);
}

}  // namespace tandem
