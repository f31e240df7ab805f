#include "engine/contact/contact_pair.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "engine/base/check.h"
#include "engine/contact/friction.h"
#include "engine/contact/refined_contacts.h"

namespace tandem {

namespace {

/// No body may travel farther in a frame (paper fn. 3), so no gap need be known better.
constexpr double kEnoughVoxels = 32;
/// Voxels of depth from which a refined contact damps in full.
constexpr double kFullDampingDepth = 0.25;
/// Candidates whose places are asked for while others are placed.
constexpr std::size_t kAhead = 4;
/// Of an exact look: what it takes to place a candidate and to ask what is known of it, what the
/// plain model's look takes, and what a contact takes to be added up.
constexpr double kAskShare = 0.04;
constexpr double kPlainShare = 0.08;
constexpr double kPushShare = 0.1;

/// Vectors and matrices about a point, turned from V to W.
Load Turned(const Load& load_V, const Mat3& R_WV) {
  Mat6 R = Mat6::Zero();
  R.topLeftCorner<3, 3>() = R_WV;
  R.bottomRightCorner<3, 3>() = R_WV;
  return {R * load_V.force, R * load_V.stiffness * R.transpose(),
          R * load_V.damping * R.transpose()};
}

/// Asks for the lines that a candidate's place and normal lie in.
void Fetch(const PointBlocks& blocks, const Candidate& candidate) {
  const PointBlocks::Lanes& p = blocks.positions()[candidate.block];
  const PointBlocks::Lanes& n = blocks.normals()[candidate.block];
  for (const auto* line : {&p.x, &p.y, &p.z, &n.x, &n.y, &n.z}) __builtin_prefetch(line);
}

/// m += k v v^T, of a symmetric matrix of which only the lower triangle is kept.
void AddLower(const Vec6& v, double k, Mat6& m) {
  for (Eigen::Index column = 0; column < 6; ++column) {
    const double kv = k * v[column];
    for (Eigen::Index row = column; row < 6; ++row) m(row, column) += kv * v[row];
  }
}

void MirrorLower(Mat6& m) {
  m.triangularView<Eigen::StrictlyUpper>() = m.transpose();
}

/// Brings forces, moments first, from about a point to about another, from which it lies at `r`.
Mat6 AboutAnotherPoint(const Vec3& r) {
  Mat6 T = Mat6::Identity();
  T.topRightCorner<3, 3>() << 0, -r.z(), r.y(), r.z(), 0, -r.x(), -r.y(), r.x(), 0;
  return T;
}

CrossLoad Turned(const CrossLoad& cross_V, const Mat3& R_WV) {
  Mat6 R = Mat6::Zero();
  R.topLeftCorner<3, 3>() = R_WV;
  R.bottomRightCorner<3, 3>() = R_WV;
  return {R * cross_V.stiffness * R.transpose(), R * cross_V.damping * R.transpose()};
}

}  // namespace

ContactPair::ContactPair(const Pointshell& shell, const Voxmap& voxmap, const Pose& X_BV,
                         double map_radius, const PairOptions& options, const ContactGains& gains)
    : shell_(&shell),
      voxmap_(&voxmap),
      X_BV_(X_BV),
      map_radius_(map_radius),
      shell_extent_(ExtentOf(shell)),
      map_extent_(ExtentOf(voxmap)),
      gains_(gains),
      both_move_(options.both_move),
      helpers_(options.schedule.helpers),
      shared_from_(options.schedule.shared_from / kBlocks),
      blocks_(std::make_unique<const PointBlocks>(shell)),
      schedule_(MakeSchedule(*blocks_, voxmap, options.force_layer, options.schedule)),
      clearance_{static_cast<double>(options.force_layer), 0.0},
      candidates_(std::min(shell.size(), kMostCandidates)),
      look_counts_(helpers_ != nullptr ? static_cast<std::size_t>(helpers_->threads()) : 1) {
  if (options.details != nullptr) {
    TANDEM_CHECK(options.force_layer >= LeastForceLayer(ContactModel::kRefined));
    const double least_radius = map_radius > 0 ? std::min(shell.radius, map_radius) : shell.radius;
    refined_ = std::make_unique<RefinedContacts>(shell, voxmap, *options.details, least_radius,
                                                 schedule_->place_error(), candidates_.size(),
                                                 helpers_ != nullptr ? helpers_->threads() : 1);
    if (options.schedule.coherence) clear_until_.assign(shell.size(), 0.0);
  }
  contacts_.resize(refined_ != nullptr ? RefinedContacts::RoomFor(candidates_.size())
                                       : candidates_.size());
}

ContactPair::ContactPair(ContactPair&&) noexcept = default;
ContactPair& ContactPair::operator=(ContactPair&&) noexcept = default;
ContactPair::~ContactPair() = default;

double ContactPair::TravelSince(const Pose& shell_WB, const Pose& map_WB) noexcept {
  double travel = std::numeric_limits<double>::infinity();
  if (placed_) {
    const auto of = [](const Pose& from, const Pose& to, double radius) {
      return TravelOf(to.p - from.p, RotationVector(to.q * from.q.conjugate()).norm(), radius);
    };
    const double shell_radius = shell_->radius + std::abs(schedule_->displacement());
    travel = of(shell_WB_, shell_WB, shell_radius) + of(map_WB_, map_WB, map_radius_);
    // bodies that move together come no nearer: as seen from V the shell's points go no farther
    const auto seen = [this](const Pose& shell, const Pose& map) {
      return (map * X_BV_).Inverse() * shell;
    };
    travel = std::min(travel, of(seen(shell_WB_, map_WB_), seen(shell_WB, map_WB), shell_radius));
  }
  placed_ = true;
  shell_WB_ = shell_WB;
  map_WB_ = map_WB;
  return travel;
}

void ContactPair::CountTurns(const Quat& q_VS) noexcept {
  if (placed_) turned_ += RotationVector(q_VS * q_VS_.conjugate()).norm();
  q_VS_ = q_VS;
}

void ContactPair::AddCandidate(std::size_t block, std::uint32_t lane, PairReport& report) noexcept {
  ++report.contact_points;
  if (candidate_count_ == candidates_.size()) {
    report.over_capacity = true;
    return;
  }
  Candidate& candidate = candidates_[candidate_count_++];
  candidate.block = static_cast<std::uint32_t>(block);
  candidate.lane = lane;
}

void ContactPair::Place(const Pose& X_VS, const Mat3& R_VS, const VoxelTransform& transform,
                        Candidate& candidate) const noexcept {
  const std::size_t lane = candidate.lane;
  const PointBlocks::Block& block = blocks_->block(candidate.block);
  const PointBlocks::Lanes& p = blocks_->positions()[candidate.block];
  const PointBlocks::Lanes& n = blocks_->normals()[candidate.block];
  candidate.point = block.first + candidate.lane;
  candidate.edge = block.first_edge + candidate.lane;
  candidate.label = block.label;
  candidate.voxel_V = VoxelAt(transform(*blocks_, candidate.block, lane));
  if (refined_ == nullptr || block.label == Label::kVertex) {
    candidate.mark = voxmap_->Value(blocks_->fields()[candidate.block], candidate.voxel_V);
  }
  candidate.nhat_V = R_VS * Vec3(n.x[lane], n.y[lane], n.z[lane]);
  candidate.p_V = R_VS * Vec3(p.x[lane], p.y[lane], p.z[lane]) + X_VS.p +
                  schedule_->displacement() * candidate.nhat_V;
}

void ContactPair::FindContacts(const Pose& X_VS, const VoxelTransform& transform,
                               const double* turned) noexcept {
  const Mat3 R_VS = X_VS.q.toRotationMatrix();
  const std::span<Candidate> candidates(candidates_.data(), candidate_count_);
  look_counts_.assign(look_counts_.size(), {});
  const auto look = [&](std::size_t begin, std::size_t end, int thread) {
    for (std::size_t i = begin; i < end; ++i) {
      if (i + kAhead < candidates.size()) Fetch(*blocks_, candidates[i + kAhead]);
      Place(X_VS, R_VS, transform, candidates[i]);
    }
    if (refined_ == nullptr) return;
    refined_->LookAt(candidates, begin, end, R_VS, clearance_.layers, turned, thread,
                     contacts_.data());
    if (turned != nullptr) RememberSlack(candidates.subspan(begin, end - begin));
    Count(candidates.subspan(begin, end - begin), look_counts_[static_cast<std::size_t>(thread)]);
  };
  if (helpers_ != nullptr && candidate_count_ >= shared_from_) {
    helpers_->Summon();
    helpers_->Share(candidate_count_, kPiece, look);
  } else {
    // as many at a time as the first cache holds
    for (std::size_t begin = 0; begin < candidate_count_; begin += kPiece) {
      look(begin, std::min(begin + kPiece, candidate_count_), 0);
    }
  }
  contact_count_ = refined_ != nullptr ? refined_->Take(candidates, R_VS, contacts_.data())
                                       : FindPlainContacts(candidates, *voxmap_, clearance_.layers,
                                                           contacts_.data());
}

void ContactPair::AddForces(const Pose& X_VS, const BodyMotion& shell_body,
                            const BodyMotion& map_body, const Pose& X_WV, PairReport& report,
                            Load& on_shell, Load& on_map) noexcept {
  if (contact_count_ == 0) return;
  const Quat q_VW = X_WV.q.conjugate();
  const Vec3 p_VS = X_VS.p;                            // shell body's centre of mass
  const Vec3 p_VM = X_WV.Inverse() * map_body.X_WB.p;  // voxmap body's
  const Vec3 w_shell = q_VW * shell_body.V_WB.w;
  const Vec3 v_shell = q_VW * shell_body.V_WB.v;
  const Vec3 w_map = q_VW * map_body.V_WB.w;
  const Vec3 v_map = q_VW * map_body.V_WB.v;
  Load shell_V;
  for (std::size_t i = 0; i < contact_count_; ++i) {
    const Vec3& p = contacts_[i].p_V;
    const Vec3& n = contacts_[i].nhat_V;
    const double depth = contacts_[i].depth;
    ++report.loaded_points;
    const Vec3 r_shell = p - p_VS;
    const Vec3 slip = v_shell + w_shell.cross(r_shell) - v_map - w_map.cross(p - p_VM);
    const double approach = -n.dot(slip);
    // contact pushes and never pulls, however fast the point leaves
    const double stiffness = ContactStiffness(gains_.stiffness, depth, voxmap_->voxel_size());
    const double pressed = ContactForce(gains_.stiffness, depth, voxmap_->voxel_size());
    // refined contacts begin exactly, so their damping can grow with depth: a touch does not jerk
    const double share = refined_ != nullptr
                             ? std::min(1.0, depth / (kFullDampingDepth * voxmap_->voxel_size()))
                             : 1.0;
    const double force = std::max(0.0, pressed + share * gains_.damping * approach);
    const double damping = force > 0 ? share * gains_.damping : 0.0;
    Vec6 along;  // the generalized direction of a unit force on the point
    along << r_shell.cross(n), n;
    shell_V.force += force * along;
    AddLower(along, stiffness, shell_V.stiffness);
    AddLower(along, damping, shell_V.damping);
    if (gains_.friction == 0) continue;
    // damping that stops an approach is no pressure yet: a graze would stick
    const double normal_force = std::min(pressed, force);
    const Vec3 sliding = slip + approach * n;
    const double drag = FrictionDamping(gains_.friction, normal_force, sliding.norm());
    const Eigen::Matrix<double, 6, 3> across = AlongTangent(r_shell, n);
    shell_V.force -= drag * across * sliding;
    shell_V.damping.triangularView<Eigen::Lower>() += drag * across * across.transpose();
  }
  if (report.loaded_points == 0) return;
  MirrorLower(shell_V.stiffness);
  MirrorLower(shell_V.damping);
  // the same forces on the map's body, about its own centre of mass
  const Mat6 T = AboutAnotherPoint(p_VS - p_VM);
  const Load map_V{-T * shell_V.force, T * shell_V.stiffness * T.transpose(),
                   T * shell_V.damping * T.transpose()};
  const Mat3 R_WV = X_WV.q.toRotationMatrix();
  on_shell += Turned(shell_V, R_WV);
  on_map += Turned(map_V, R_WV);
  if (!both_move_) return;
  cross_ =
      Turned(CrossLoad{shell_V.stiffness * T.transpose(), shell_V.damping * T.transpose()}, R_WV);
}

PairReport ContactPair::Collide(const BodyMotion& shell_body, const BodyMotion& map_body,
                                Load& on_shell, Load& on_map) noexcept {
  PairReport report;
  const Pose X_WV = map_body.X_WB * X_BV_;
  const Pose X_VS = X_WV.Inverse() * shell_body.X_WB;
  CountTurns(X_VS.q);
  const double travel = TravelSince(shell_body.X_WB, map_body.X_WB);
  waiting_ += travel;
  // what was far enough is nearer by no more than the travel
  const double enough = kEnoughVoxels * voxmap_->voxel_size();
  gap_ -= travel;
  if (!(gap_ > enough)) gap_ = GapBetween(map_extent_, shell_extent_, X_VS, 2.0 * enough);
  // the broad phase: nothing can be in contact, so nothing is tested and the queues wait
  contact_count_ = 0;
  if (Gap() > 0) return report;
  const double displaced = std::abs(schedule_->displacement() - displaced_);
  schedule_->Test(X_VS, waiting_);
  if (std::isfinite(waiting_)) odometer_ += waiting_ / voxmap_->voxel_size();
  odometer_ += displaced / voxmap_->voxel_size();
  displaced_ = schedule_->displacement();
  waiting_ = 0;
  report.tests = schedule_->counts();
  candidate_count_ = 0;
  std::size_t passed = 0;
  for (const Schedule::ContactBlock& contact : schedule_->contacts()) {
    for (unsigned lanes = contact.lanes; lanes != 0; lanes &= lanes - 1) {
      const auto lane = static_cast<std::uint32_t>(std::countr_zero(lanes));
      const double slack = SlackOf(contact.block, lane);
      if (slack > 0) {
        ++report.contact_points;
        ++report.clear_points;
        passed += slack < std::numeric_limits<double>::infinity() ? 1 : 0;  // else no region's
        continue;
      }
      AddCandidate(contact.block, lane, report);
    }
  }
  FindContacts(X_VS, schedule_->transform(), clear_until_.empty() ? nullptr : &turned_);
  if (refined_ != nullptr) report.clear_points += static_cast<int>(refined_->clear_count());
  AddForces(X_VS, shell_body, map_body, X_WV, report, on_shell, on_map);
  if (!clear_until_.empty()) refined_->CountKnown(candidate_count_, passed);
  CountLooks(report);
  return report;
}

double ContactPair::SlackOf(std::uint32_t block, std::uint32_t lane) const noexcept {
  if (clear_until_.empty()) return 0;
  return clear_until_[blocks_->block(block).first + lane] - odometer_;
}

void ContactPair::RememberSlack(std::span<const Candidate> candidates) noexcept {
  for (const Candidate& candidate : candidates) {
    clear_until_[candidate.point] = odometer_ + candidate.slack - 2 * schedule_->place_error();
  }
}

void ContactPair::Count(std::span<const Candidate> candidates, LookCounts& counts) noexcept {
  using Look = Candidate::Look;
  for (const Candidate& candidate : candidates) {
    counts.looks += candidate.look == Look::kKept || candidate.look == Look::kOpen ? 1 : 0;
    counts.regions += candidate.look == Look::kKept ? 1 : 0;
    counts.sifted += candidate.look == Look::kSifted ? 1 : 0;
  }
}

void ContactPair::CountLooks(PairReport& report) noexcept {
  LookCounts sum;
  for (const LookCounts& counts : look_counts_) sum += counts;
  report.looks = sum.looks;
  report.sifted_points = sum.sifted;
  const double ask = refined_ != nullptr ? kAskShare : kPlainShare;
  report.look_work = kPushShare * static_cast<double>(contact_count_) +
                     ask * static_cast<double>(candidate_count_) + kSiftShare * sum.sifted +
                     sum.looks;
  looks_ = report.look_work - sum.regions;
}

TestLoad ContactPair::load() const noexcept {
  TestLoad load;
  if (Gap() <= 0) {
    load = schedule_->Load();
    load.looks = looks_;
    return load;
  }
  load.bound = std::max(0.5 * voxmap_->voxel_size(), Gap());
  return load;
}

void ContactPair::LimitTravel(double metres) noexcept {
  // what is far is not scheduled: waiting_ has its travel
  schedule_->LimitTravel(Gap() > 0 ? 0.0 : metres);
}

void ContactPair::SetClearance(const Clearance& clearance) noexcept {
  const int layer = static_cast<int>(std::ceil(clearance.layers));
  TANDEM_CHECK(refined_ == nullptr || layer >= LeastForceLayer(ContactModel::kRefined));
  if (layer != schedule_->force_layer()) schedule_->SetForceLayer(layer);
  if (clearance.displacement != schedule_->displacement()) {
    schedule_->SetDisplacement(clearance.displacement);
  }
  clearance_ = clearance;
}

PoseReading ContactPair::Read(const BodyMotion& shell_body, const BodyMotion& map_body) noexcept {
  PoseReading reading;
  const Pose X_WV = map_body.X_WB * X_BV_;
  const Pose X_VS = X_WV.Inverse() * shell_body.X_WB;
  const double gap = GapBetween(map_extent_, shell_extent_, X_VS, 0);
  if (gap > std::abs(schedule_->displacement())) return reading;
  const int threshold = 2 + schedule_->force_layer();
  const VoxelTransform transform(X_VS, voxmap_->voxel_size(), schedule_->displacement());
  PairReport report;
  candidate_count_ = 0;
  for (std::size_t b = 0; b < blocks_->size(); ++b) {
    const PointBlocks::Block& block = blocks_->block(b);
    for (std::uint32_t lane = 0; lane < block.count; ++lane) {
      const GridIndex voxel = VoxelAt(transform(*blocks_, b, lane));
      const int surface = voxmap_->Value(Field::kSurface, voxel);
      if (surface < voxmap_->beyond()) {
        reading.nearest_voxels = std::min(reading.nearest_voxels, std::max(0, surface - 2));
      }
      reading.touching_points += surface <= threshold ? 1 : 0;
      const int mark = voxmap_->Value(FieldReadBy(block.label), voxel);
      if (mark <= threshold) AddCandidate(b, lane, report);
    }
  }
  FindContacts(X_VS, transform, nullptr);
  Load on_map;
  AddForces(X_VS, shell_body, map_body, X_WV, report, reading.on_shell, on_map);
  reading.contact_points = report.contact_points;
  return reading;
}

}  // namespace tandem
