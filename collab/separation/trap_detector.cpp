#include "collab/separation/trap_detector.h"

#include <algorithm>
#include <cmath>

namespace tandem {

namespace {

constexpr double kInwardVoxels = 3.0;
/// Voxels; a point so near to the fixture touches it, so that even an open sheet stops a line.
constexpr double kAtSurface = 0.5;
constexpr double kLeastStep = 0.5;  // voxels
// crossing lines, of the points' lines, that are no accident at a corner
constexpr std::size_t kCrossings = TrapDetector::kPoints / 8;
constexpr double kTurned = 0.1;  // rad; bodies turned by less have short lines as well

/// Returns whether all instances are so near to ours that nothing separates them.
bool AllTogether(const Pose& X_WB, const InstanceView* others, std::size_t count) {
  const double least = std::cos(0.5 * kTurned);
  return std::all_of(others, others + count, [&](const InstanceView& other) {
    return (other.X_WB.p - X_WB.p).squaredNorm() <= TrapDetector::kApart * TrapDetector::kApart &&
           std::abs(other.X_WB.q.dot(X_WB.q)) >= least;
  });
}

/// Returns the body's origin, and points a little inward of its surface, evenly spread. Contact may
/// not need its pointshell, so one is made for this and not kept.
std::vector<Vec3> PointsOf(const WorldModel& model, std::size_t body) {
  const Scene& scene = model.scene;
  const SceneBody& part = scene.bodies[model.object[body]];
  const Result<Pointshell> shell =
      MakePoints(scene, MeshOfBody(model, body), model.bodies[body].X_WB0, part.inward_shift_voxels,
                 part.point_spacing_voxels);
  std::vector<Vec3> points{Vec3::Zero()};
  if (!shell) return points;
  const std::size_t size = shell->size();
  const std::size_t count = std::min(size, TrapDetector::kPoints);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t at = (2 * i + 1) * size / (2 * count);
    points.emplace_back(shell->point(at) + kInwardVoxels * scene.voxel_size * shell->normal(at));
  }
  return points;
}

}  // namespace

TrapDetector::TrapDetector(const WorldModel& model) : model_(&model) {
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    const bool shared = model.has_fixture && model.scene.bodies[model.object[b]].shared;
    points_B_.push_back(shared ? PointsOf(model, b) : std::vector<Vec3>());
  }
}

void TrapDetector::Begin(std::size_t body) noexcept {
  body_ = body;
  links_.Clear();
  sweep_ = {};
}

bool TrapDetector::trapped(PeerId peer) const noexcept {
  const Link* const link = links_.Find(peer);
  return link != nullptr && link->trapped;
}

bool TrapDetector::blocked(PeerId peer) const noexcept {
  const Link* const link = links_.Find(peer);
  return link != nullptr && link->blocked;
}

void TrapDetector::Match(const InstanceView* others, std::size_t count) noexcept {
  for (const Link& link : links_) {
    const bool here = std::any_of(others, others + count, [&link](const InstanceView& other) {
      return other.peer == link.peer;
    });
    if (!here) links_.Erase(link.peer);
  }
  for (std::size_t i = 0; i < count; ++i) links_.FindOrInsert(others[i].peer);
}

void TrapDetector::BeginSweep(const Pose& X_WB, const InstanceView* others,
                              std::size_t count) noexcept {
  std::size_t next = sweep_.slot;
  sweep_ = {};
  for (std::size_t turn = 0; turn < links_.capacity(); ++turn) {
    next = (next + 1) % links_.capacity();
    const Link* const link = links_.InSlot(next);
    if (link == nullptr) continue;
    for (std::size_t i = 0; i < count; ++i) {
      if (others[i].peer != link->peer) continue;
      sweep_.slot = next;
      sweep_.peer = others[i].peer;
      sweep_.ours = X_WB;
      sweep_.theirs = others[i].X_WB;
      sweep_.R_ours = X_WB.q.toRotationMatrix();
      sweep_.R_theirs = others[i].X_WB.q.toRotationMatrix();
      return;
    }
  }
}

double TrapDetector::FreeAlong(const Vec3& p_W, double stretch) const noexcept {
  const double voxel = model_->scene.voxel_size;
  if (model_->scene.contact == ContactModel::kRefined) {
    const DistanceField& field = model_->fixture_surface.field;
    const FieldReading reading = field.At((p_W - field.p_WVo()) / voxel);
    // a bound near 0 tells no side
    const bool met = reading.near ? reading.value < kAtSurface : reading.value < -kAtSurface;
    return met ? 0.0 : voxel * std::max(kLeastStep, reading.value);
  }
  // where not all voxels are in memory, the outline knows the chunks that are solid
  const Voxmap& map =
      model_->fixture_pages != nullptr ? model_->fixture_pages->outline() : model_->fixture;
  const Vec3 v = (p_W - map.p_WVo()) / voxel;
  // far outside, where no voxel index would fit
  const bool is_far = !(v.cwiseAbs().maxCoeff() < 1e9);
  const int mark = is_far
                       ? map.beyond()
                       : map.Value(Field::kSurface, {static_cast<std::int32_t>(std::floor(v.x())),
                                                     static_cast<std::int32_t>(std::floor(v.y())),
                                                     static_cast<std::int32_t>(std::floor(v.z()))});
  if (mark <= kSurfaceMark) return 0.0;
  // the nearest surface voxel is mark - 2 voxels away: one voxel less is certainly free
  return voxel * stretch * std::max(kLeastStep, static_cast<double>(mark - kSurfaceMark - 1));
}

bool TrapDetector::March(std::size_t most, std::size_t& reads) noexcept {
  const Vec3& p_B = points_B_[body_][sweep_.point];
  const Vec3 from = sweep_.R_ours * p_B + sweep_.ours.p;
  const Vec3 line = sweep_.R_theirs * p_B + sweep_.theirs.p - from;
  const double length = line.norm();
  if (length <= 0) return true;
  // in the chessboard metric of marks a line is shorter than its length
  const double stretch = length / line.cwiseAbs().maxCoeff();
  while (sweep_.way < length && reads < most) {
    ++reads;
    const double free = FreeAlong(from + (sweep_.way / length) * line, stretch);
    const bool first = sweep_.way == 0;
    // a point inside the fixture at either end tells nothing, as with a ring on its peg
    if (free == 0) {
      sweep_.met = !first;
      return true;
    }
    sweep_.way += free;
    if (!first || sweep_.way >= length) continue;
    ++reads;
    if (FreeAlong(from + line, stretch) == 0) return true;
  }
  return sweep_.way >= length;
}

bool TrapDetector::Decided() const noexcept {
  const std::size_t left = points_B_[body_].size() - sweep_.point;
  return sweep_.centre_crosses || sweep_.crossings >= kCrossings ||
         sweep_.crossings + left < kCrossings;
}

void TrapDetector::Update(std::int64_t now_ns, const Pose& X_WB, const InstanceView* others,
                          std::size_t count) noexcept {
  if (points_B_[body_].empty()) return;
  Match(others, count);
  // short lines take one read each
  const std::size_t most = AllTogether(X_WB, others, count) ? 2 + count : kReads;
  std::size_t reads = 0;
  while (reads < most) {
    const Link* const swept = links_.InSlot(sweep_.slot);
    if (sweep_.peer == 0 || swept == nullptr || swept->peer != sweep_.peer) {
      BeginSweep(X_WB, others, count);
      if (sweep_.peer == 0) break;
    }
    if (!March(most, reads)) break;
    if (sweep_.met) {
      ++sweep_.crossings;
      sweep_.centre_crosses = sweep_.centre_crosses || sweep_.point == 0;
    }
    sweep_.met = false;
    sweep_.way = 0;
    ++sweep_.point;
    if (!Decided()) continue;
    links_.InSlot(sweep_.slot)->blocked = sweep_.centre_crosses || sweep_.crossings >= kCrossings;
    sweep_.peer = 0;
    break;  // one look a frame is enough
  }
  for (std::size_t i = 0; i < count; ++i) {
    Link* const link = links_.Find(others[i].peer);
    if (link != nullptr) Judge(*link, now_ns, (others[i].X_WB.p - X_WB.p).norm());
  }
}

void TrapDetector::Judge(Link& link, std::int64_t now_ns, double distance) noexcept {
  if (!link.blocked) {
    link.trapped = false;
    link.since_ns = 0;
    return;
  }
  if (link.trapped) return;
  if (distance <= kApart) {
    link.since_ns = 0;
    return;
  }
  if (link.since_ns == 0 || distance < link.least - kShrinks) {
    link.since_ns = now_ns;
    link.least = distance;
  }
  link.trapped = now_ns - link.since_ns >= kLastingNs;
}

}  // namespace tandem
