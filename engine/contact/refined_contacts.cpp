#include "engine/contact/refined_contacts.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "engine/base/check.h"

namespace tandem {

namespace {

/// As FeatureNormals::edge_cosines: edges whose faces turn by less are pieces of curved surface.
constexpr float kSharp = 0.966F;
/// Candidates whose regions are asked for while others are looked at.
constexpr std::size_t kAhead = 4;
constexpr double kNever = std::numeric_limits<double>::infinity();

/// 1 squarely over a piece of surface, smoothly 0 at the reach.
double Weight(double square, double reach) {
  const double left = 1.0 - square / (reach * reach);
  return left > 0 ? left * left : 0.0;
}

/// Of the most that bodies turn for a voxel of travel: a point of theirs is looked at again when
/// they have turned by more.
constexpr double kTurn = 0.6;
/// Rad: and at most by this.
constexpr double kMostTurn = 0.03;
/// Voxels: heights nearer to the clearance than this may be below it by rounding.
constexpr double kRounding = 1e-6;

/// Of a place in its voxel, voxels to each side of it, less what places err by.
struct ToSides {
  Vec3 lower;
  Vec3 upper;
  ToSides(const Vec3& p, const GridIndex& voxel, double error)
      : lower(p.x() - voxel.x, p.y() - voxel.y, p.z() - voxel.z), upper(Vec3::Ones() - lower) {
    lower.array() -= error;
    upper.array() -= error;
  }
  double least() const { return std::min(lower.minCoeff(), upper.minCoeff()); }
  /// How far the window of one voxel comes when the point goes by `way`: 1 or 2 along each axis.
  static GridIndex Within(const Vec3& sides, double way) {
    const auto along = [way](double side) {
      return side < way ? 2 : 1;
    };
    return {along(sides.x()), along(sides.y()), along(sides.z())};
  }
  /// Voxels to go until what lies `at` voxels off, two along at least one axis, lies within one.
  double Until(const GridIndex& at) const {
    const auto along = [](int d, double down, double up) {
      return d == 2 ? up : d == -2 ? down : 0.0;
    };
    return std::max({along(at.x, lower.x(), upper.x()), along(at.y, lower.y(), upper.y()),
                     along(at.z, lower.z(), upper.z())});
  }
};

}  // namespace

RefinedContacts::RefinedContacts(const Pointshell& shell, const Voxmap& voxmap,
                                 const SurfaceDetails& details, double least_radius,
                                 double place_error, std::size_t most, int threads)
    : shell_(&shell),
      voxmap_(&voxmap),
      s_(voxmap.voxel_size()),
      turn_(voxmap.voxel_size() / least_radius),
      most_turn_(std::min(kTurn * turn_, kMostTurn)),
      place_error_(place_error),
      found_(most, 0),
      regions_(most),
      known_(std::bit_ceil(2 * most)),
      slots_(std::bit_ceil(2 * MostVertices(most)), 0),
      met_(MostVertices(most)),
      used_slots_(met_.size()),
      met_ridges_(shell.edges.empty() ? 0 : met_.size()) {
  TANDEM_CHECK(!details.empty());
  scratch_.reserve(static_cast<std::size_t>(threads));
  for (int thread = 0; thread < threads; ++thread) {
    scratch_.push_back({{voxmap, details}, {}, {}, {}, NearPieces(voxmap, details, most / 8), {}});
    scratch_.back().left.reserve(most);
  }
}

template <class Tell>
void RefinedContacts::TellRound(const Candidate& candidate, Field field, Scratch& scratch,
                                const Tell& tell) noexcept {
  ClearRegionMaker& clear = scratch.clear;
  if (clear.empty()) return;
  const ToSides sides(candidate.p_V / s_, candidate.voxel_V, 2 * place_error_);
  if (sides.least() >= clear.reach()) return;
  for (const SurfaceWindow::Piece& piece :
       scratch.window.Round(candidate.voxel_V, ToSides::Within(sides.lower, clear.reach()),
                            ToSides::Within(sides.upper, clear.reach()), field)) {
    tell(piece, sides.Until(piece.voxel_V - candidate.voxel_V));
    if (clear.empty()) return;
  }
}

RefinedContacts::Standing RefinedContacts::StandOn(const SurfaceWindow::Piece& piece, const Vec3& p,
                                                   const Vec3& nhat) const noexcept {
  const SurfaceDetail& detail = *piece.detail;
  Standing standing;
  if (detail.shape() == SurfaceDetail::Shape::kRidge) {
    const Vec3 n = UnpackDirection(detail.normal);
    const EdgeArc& arc = ArcOf(detail);
    const Vec3 across = arc.sine * UnpackDirection(detail.tangent).cross(n);
    const Vec3 along = arc.cosine * n;
    standing.normals = {along + across, along - across};
    standing.sides = 2;
  } else {
    standing.normals[0] = FacingNormal(detail, nhat);
  }
  const Vec3 away = p - piece.place();
  for (std::size_t i = 0; i < standing.sides; ++i) {
    // the place's height above the plane, and how squarely the vertex stands over it
    const Vec3& n = standing.normals[i];
    const double height = away.dot(n);
    standing.heights[i] = height;
    standing.squares_beside[i] = away.squaredNorm() - height * height;
    standing.weights[i] = Weight(standing.squares_beside[i], kLateralReach);
    standing.facing[i] = n.dot(nhat) > kFacing;
  }
  return standing;
}

void RefinedContacts::TellStanding(const Standing& on, bool two_sided, double way,
                                   ClearRegionMaker& clear) noexcept {
  const auto beside = [&](std::size_t i) {
    return std::max(way, std::sqrt(std::max(0.0, on.squares_beside[i])) - kLateralReach);
  };
  const auto above = [&](std::size_t i) {
    return two_sided ? -1.0 : on.heights[i] - kRefinedClearance - kRounding;
  };
  if (on.sides == 1) {
    clear.KeepAbove(on.normals[0], above(0), 0, beside(0));
    return;
  }
  const std::size_t higher = on.heights[1] > on.heights[0] ? 1 : 0;
  const std::size_t lower = 1 - higher;
  clear.KeepAbove(on.normals[higher], above(higher), 0, beside(higher));
  // beside the edge only the face that the vertex is above has a say
  const double cosine = on.normals[0].dot(on.normals[1]);
  const Vec3 past_edge = cosine * on.normals[higher] - on.normals[lower];
  const double length = std::max(past_edge.norm(), kRounding);
  const double past = (cosine * on.heights[higher] - on.heights[lower]) / length - kRounding;
  if (past > above(lower)) {
    clear.KeepAbove(on.normals[higher], above(higher), 0, beside(lower));
    clear.KeepAbove(past_edge / length, past, 0, beside(lower));
  } else {
    clear.KeepAbove(on.normals[lower], above(lower), 0, beside(lower));
  }
}

std::optional<std::size_t> RefinedContacts::MeetSurface(const Candidate& candidate,
                                                        Scratch& scratch, Contact* out) noexcept {
  using Shape = SurfaceDetail::Shape;
  const Vec3 p = candidate.p_V / s_;
  const std::span<const SurfaceWindow::Piece> pieces =
      scratch.window.Near(candidate.voxel_V, Field::kSurface);
  PlaneMean& faces = scratch.under;
  ClearRegionMaker& clear = scratch.clear;
  faces.Clear();
  scratch.ridges.count = 0;
  if (candidate.mark == kInteriorMark) clear.KeepWithin(0);
  const auto is_corner = [](const SurfaceWindow::Piece& piece) {
    const Shape shape = piece.detail->shape();
    return shape == Shape::kVertex || shape == Shape::kNotch;
  };
  const auto tell = [&](const SurfaceWindow::Piece& piece, const Standing& on, double way) {
    TellStanding(on, piece.detail->half_length == SurfaceDetail::kTwoSided, way, clear);
  };
  // pieces that stay near wherever in the region the point goes
  const ToSides sides(p, candidate.voxel_V, 2 * place_error_);
  const GridIndex down = ToSides::Within(sides.lower, clear.reach());
  const GridIndex up = ToSides::Within(sides.upper, clear.reach());
  const auto stays = [&](const GridIndex& at) {
    return at.x >= up.x - 2 && at.y >= up.y - 2 && at.z >= up.z - 2 && at.x <= 2 - down.x &&
           at.y <= 2 - down.y && at.z <= 2 - down.z;
  };
  bool only_corners = true;
  bool a_face_stays = false;
  for (const SurfaceWindow::Piece& piece : pieces) {
    if (is_corner(piece)) continue;
    only_corners = false;
    a_face_stays = a_face_stays || stays(piece.voxel_V - candidate.voxel_V);
    const Standing on = StandOn(piece, p, candidate.nhat_V);
    tell(piece, on, 0);
    if (on.sides == 2) {
      scratch.ridges.Add(on.normals);
      faces.AddRidge(piece.place(), on.normals, on.heights, on.weights, on.facing);
    } else if (on.facing[0]) {
      faces.Add(piece.place(), on.normals[0], on.heights[0], on.weights[0]);
    }
  }
  // where detail is so fine that no face shows, what the corners say on the whole; they may be all
  // that is near as soon as other pieces come and go
  const double soonest = only_corners ? 0.0 : sides.least();
  for (const SurfaceWindow::Piece& piece : pieces) {
    if (a_face_stays || !is_corner(piece)) continue;
    const Standing on = StandOn(piece, p, candidate.nhat_V);
    tell(piece, on, soonest);
    if (only_corners && on.facing[0]) {
      faces.Add(piece.place(), on.normals[0], on.heights[0], on.weights[0]);
    }
  }
  if (!clear.empty()) {
    TellRound(candidate, Field::kSurface, scratch,
              [&](const SurfaceWindow::Piece& piece, double until) {
                if (a_face_stays && is_corner(piece)) return;
                tell(piece, StandOn(piece, p, candidate.nhat_V), until);
              });
    return 0;
  }
  std::array<PlaneMean::Push, PlaneMean::kMostPushes> pushes;
  const std::size_t pushing = faces.Resolve(scratch.ridges, pushes);
  if (pushing == 0) return std::nullopt;
  std::size_t found = 0;
  for (std::size_t i = 0; i < pushing; ++i) {
    const double depth = (kRefinedClearance - pushes[i].gap) * pushes[i].share;
    if (depth > 0) out[found++] = {candidate.p_V, pushes[i].normal, s_ * depth};
  }
  return found;
}

RefinedContacts::Over RefinedContacts::StandUnder(const SurfaceWindow::Piece& piece, const Vec3& p,
                                                  const Vec3& nhat) noexcept {
  const Vec3 q = piece.place();
  const Vec3 away = p - q;
  const double height = away.dot(nhat);
  const double square_beside = away.squaredNorm() - height * height;
  return {q, height, square_beside, Weight(square_beside, kVertexReach)};
}

bool RefinedContacts::IsHigh(double height) noexcept {
  return height >= kRefinedClearance + kRounding;
}

double RefinedContacts::BesideAfter(const Over& over, double turn) noexcept {
  const double beside = std::sqrt(std::max(0.0, over.square_beside));
  return beside - turn * (std::abs(over.height) + turn * beside);
}

std::uint8_t RefinedContacts::BearOnVertices(const Candidate& candidate,
                                             Scratch& scratch) noexcept {
  const Vec3 p = candidate.p_V / s_;
  const Vec3& n = candidate.nhat_V;
  ClearRegionMaker& clear = scratch.clear;
  const auto tell = [&](const SurfaceWindow::Piece& piece, const Over& over, double until) {
    const double beside = std::sqrt(std::max(0.0, over.square_beside));
    const double turn = clear.turn();
    const double way = std::max(until, BesideAfter(over, turn) - kVertexReach);
    if (way >= clear.reach()) return;
    const double swing = beside + clear.reach() + turn * std::abs(over.height);
    const double margin = over.height - kRefinedClearance - kRounding;
    // the far sides of thin walls do not push
    if (margin < turn * swing && n.dot(FacingNormal(*piece.detail, n)) < kFacing - turn) return;
    clear.KeepAbove(n, margin, swing, way);
  };
  std::uint8_t found = 0;
  for (const SurfaceWindow::Piece& piece : scratch.window.Near(candidate.voxel_V, Field::kVertex)) {
    const Over over = StandUnder(piece, p, n);
    tell(piece, over, 0);
    if (over.weight > 0) found = std::max(found, IsHigh(over.height) ? kHigh : kBears);
  }
  if (found == kBears) clear.KeepWithin(0);
  TellRound(candidate, Field::kVertex, scratch,
            [&](const SurfaceWindow::Piece& piece, double until) {
              tell(piece, StandUnder(piece, p, n), until);
            });
  return found;
}

RefinedContacts::Faces RefinedContacts::FacesAt(const Candidate& candidate,
                                                const Mat3& R_VS) const noexcept {
  Faces faces;
  faces.nhat[0] = candidate.nhat_V;
  if (candidate.label != Label::kEdge) return faces;
  const ShellEdge edge = EdgeAt(candidate, R_VS);
  const Vec3 across = edge.arc.sine * edge.tangent.cross(edge.nhat);
  const Vec3 along = edge.arc.cosine * edge.nhat;
  faces.nhat = {along + across, along - across};
  faces.count = 2;
  return faces;
}

bool RefinedContacts::SaysFaces(const Candidate& candidate) const noexcept {
  if (candidate.label != Label::kEdge) return candidate.label == Label::kSurface;
  const float cosine = shell_->edges[candidate.edge].cosine;
  return cosine > 0 && cosine < kSharp;
}

std::uint8_t RefinedContacts::BearFaces(const Candidate& candidate, const Faces& faces,
                                        Scratch& scratch) noexcept {
  const Vec3 p = candidate.p_V / s_;
  ClearRegionMaker& clear = scratch.clear;
  std::uint8_t found = 0;
  const auto tell = [&](const SurfaceWindow::Piece& piece, double until) {
    for (std::size_t i = 0; i < faces.count; ++i) {
      const Vec3& n = faces.nhat[i];
      const Over over = StandUnder(piece, p, n);
      const double way = std::max(until, BesideAfter(over, clear.turn()) - kVertexReach);
      if (over.weight <= 0 && way >= clear.reach()) continue;
      // what faces away cannot turn to it before the point is looked at again
      if (n.dot(FacingNormal(*piece.detail, n)) < kFacing - clear.turn()) continue;
      clear.KeepWithin(way);
      if (over.weight > 0) found = std::max(found, IsHigh(over.height) ? kHigh : kBears);
    }
  };
  for (const SurfaceWindow::Piece& piece : scratch.window.Near(candidate.voxel_V, Field::kVertex)) {
    tell(piece, 0);
  }
  const std::uint8_t near = found;
  TellRound(candidate, Field::kVertex, scratch, tell);
  return near;
}

ShellEdge RefinedContacts::EdgeAt(const Candidate& candidate, const Mat3& R_VS) const noexcept {
  const Pointshell::Edge& edge = shell_->edges[candidate.edge];
  return {candidate.p_V / s_,
          R_VS * edge.tangent.cast<double>(),
          candidate.nhat_V,
          edge.half_length / s_,
          edge.cosine > 0 ? EdgeArc::OfCosine(edge.cosine) : LooseArc(),
          edge.ends,
          0.5 * shell_->spacing / s_};
}

std::size_t RefinedContacts::MeetEdges(const Candidate& candidate, const Mat3& R_VS,
                                       Scratch& scratch, Contact* out) noexcept {
  const ShellEdge edge = EdgeAt(candidate, R_VS);
  std::size_t found = 0;
  for (const SurfaceWindow::Piece& piece : scratch.window.Near(candidate.voxel_V, Field::kEdge)) {
    const EdgeMeeting meeting = Meet(edge, *piece.detail, piece.place(), piece.ends,
                                     ArcOf(*piece.detail), &scratch.clear, 0);
    if (meeting.counted_depth() <= 0) continue;
    scratch.clear.KeepWithin(0);
    out[found++] = {s_ * meeting.place, meeting.normal, s_ * meeting.counted_depth()};
    if (found == kPerPoint) break;
  }
  TellRound(candidate, Field::kEdge, scratch, [&](const SurfaceWindow::Piece& piece, double until) {
    Meet(edge, *piece.detail, piece.place(), piece.ends, ArcOf(*piece.detail), &scratch.clear,
         until);
  });
  return found;
}

std::uint8_t RefinedContacts::MeetOne(Candidate& candidate, const Mat3& R_VS, double layers,
                                      Scratch& scratch, Contact* out) noexcept {
  if (candidate.label == Label::kSurface) return BearOnVertices(candidate, scratch);
  if (candidate.label == Label::kEdge) {
    auto found = static_cast<std::uint8_t>(MeetEdges(candidate, R_VS, scratch, out));
    if (SaysFaces(candidate)) found |= BearFaces(candidate, FacesAt(candidate, R_VS), scratch);
    return found;
  }
  const std::optional<std::size_t> met = MeetSurface(candidate, scratch, out);
  if (met.has_value()) return static_cast<std::uint8_t>(*met);
  // deeper in than the map's surface reaches: the plain depth goes on
  if (candidate.mark != kInteriorMark) return 0;
  return static_cast<std::uint8_t>(FindPlainContacts({&candidate, 1}, *voxmap_, layers, out));
}

void RefinedContacts::LookAt(std::span<Candidate> candidates, std::size_t begin, std::size_t end,
                             const Mat3& R_VS, double layers, const double* turned, int thread,
                             Contact* out) noexcept {
  Scratch& scratch = scratch_[static_cast<std::size_t>(thread)];
  scratch.left.clear();
  const std::size_t one_in = budget_.OneIn(candidates.size());
  for (std::size_t i = begin; i < end; ++i) {
    Candidate& candidate = candidates[i];
    if (i + kAhead < end && budget_.Serves(candidates[i + kAhead].point)) {
      __builtin_prefetch(&known_[candidates[i + kAhead].point & (known_.size() - 1)]);
    }
    found_[i] = 0;
    candidate.slack = 0;
    candidate.look = Candidate::Look::kPassed;
    if (candidate.label == Label::kEdge && shell_->edges[candidate.edge].cosine < 0) {
      candidate.slack = kNever;  // a notch: nothing leans on it
      found_[i] = kClear;
      continue;
    }
    if (turned == nullptr) {
      scratch.clear.BeginNone();
      candidate.look = Candidate::Look::kOpen;
      found_[i] = MeetOne(candidate, R_VS, layers, scratch, out + kPerPoint * i);
      continue;
    }
    if (budget_.Serves(candidate.point)) {
      if (StandsClear(candidate, *turned, found_[i])) continue;
      if ((i + frame_) % one_in == 0) {
        scratch.clear.Begin(most_turn_);
        candidate.look = Candidate::Look::kOpen;
        found_[i] = MeetOne(candidate, R_VS, layers, scratch, out + kPerPoint * i);
        found_[i] |= Remember(candidate, *turned, scratch, regions_[i]);
        continue;
      }
    }
    candidate.look = Candidate::Look::kSifted;
    scratch.left.push_back(static_cast<std::uint32_t>(i));
  }
  scratch.clear.BeginNone();
  SiftAll(candidates, R_VS, layers, scratch, out);
}

std::uint8_t RefinedContacts::Remember(Candidate& candidate, double turned, const Scratch& scratch,
                                       ClearRegion& region) const noexcept {
  if (scratch.clear.empty()) return 0;
  candidate.look = Candidate::Look::kKept;
  region = scratch.clear.Make(candidate.p_V / s_, turned, candidate.point);
  candidate.slack = SlackIn(region, candidate, turned);
  return kMade;
}

bool RefinedContacts::StandsClear(Candidate& candidate, double turned,
                                  std::uint8_t& found) const noexcept {
  const ClearRegion& region = known_[candidate.point & (known_.size() - 1)];
  if (region.point != candidate.point || !region.Holds(candidate.p_V / s_, turned, most_turn_))
    return false;
  // one that comes to lie inside is looked at, whatever the surface nearby
  if (candidate.label == Label::kVertex && candidate.mark == kInteriorMark) return false;
  found = kKnown | (candidate.label == Label::kSurface && !region.round() ? kHigh : kClear);
  candidate.slack = SlackIn(region, candidate, turned);
  return true;
}

double RefinedContacts::SlackIn(const ClearRegion& region, const Candidate& candidate,
                                double turned) const noexcept {
  // what is high above a vertex of the map may have a say when others are not
  if (candidate.label == Label::kSurface && !region.round()) return 0.0;
  const Vec3 p = candidate.p_V / s_;
  double slack = region.Room(p, turned, most_turn_, turn_);
  if (candidate.label == Label::kVertex) {
    slack = std::min(slack, ToSides(p, candidate.voxel_V, 2 * place_error_).least());
  }
  return slack;
}

std::size_t RefinedContacts::Take(std::span<const Candidate> candidates, const Mat3& R_VS,
                                  Contact* out) noexcept {
  std::size_t taken = 0;
  clear_count_ = 0;
  unknown_count_ = 0;
  made_count_ = 0;
  ++frame_;
  bool bears = false;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    if ((found_[i] & kMade) != 0) {
      known_[regions_[i].point & (known_.size() - 1)] = regions_[i];
      ++made_count_;
    }
    bears = bears || (found_[i] & kBears) != 0;
    clear_count_ += (found_[i] & kClear) != 0 ? 1 : 0;
    unknown_count_ += (found_[i] & kKnown) != 0 ? 0 : 1;
    const std::size_t found = found_[i] % kMade;
    for (std::size_t k = 0; k < found; ++k) out[taken++] = out[kPerPoint * i + k];
  }
  if (!bears) return taken;
  MeetVertices(candidates, R_VS);
  // a point gives at most kPerPoint, a vertex of the map comes with a surface point
  return taken + TakeVertices(out + taken);
}

}  // namespace tandem
