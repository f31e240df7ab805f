#include "engine/contact/pair/contact_pair.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "engine/contact/pair/contact_forces.h"
#include "engine/paging/resident_voxels.h"

namespace tandem {

namespace {

/// No body may travel farther in a frame (paper fn. 3), so larger gaps are not needed exactly.
constexpr double kEnoughVoxels = 32;
/// The number of candidates whose data are prefetched while others are placed.
constexpr std::size_t kAhead = 4;
/// The costs of placing a candidate and finding its depth, and of adding up a contact. Unit: one
/// query, by which the frame's capacity is counted.
constexpr double kCandidateShare = 0.08;
constexpr double kPushShare = 0.1;

/// Prefetches the lines that hold a candidate's place and normal.
void Fetch(const PointBlocks& blocks, const Candidate& candidate) {
  const PointBlocks::Lanes& p = blocks.positions()[candidate.block];
  const PointBlocks::Lanes& n = blocks.normals()[candidate.block];
  for (const auto* line : {&p.x, &p.y, &p.z, &n.x, &n.y, &n.z}) __builtin_prefetch(line);
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
      reader_(options.reader),
      workers_(options.schedule.workers),
      shared_from_(options.schedule.shared_from / kBlocks),
      blocks_(std::make_unique<const PointBlocks>(shell)),
      schedule_(
          MakeSchedule(*blocks_, voxmap, options.force_layer, options.schedule, options.reader)),
      candidates_(std::min(shell.size(), kMostCandidates)),
      contacts_(candidates_.size()) {
  clearance_ = {static_cast<double>(options.force_layer), 0.0};
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
  const PointBlocks::Lanes& p = blocks_->positions()[candidate.block];
  const PointBlocks::Lanes& n = blocks_->normals()[candidate.block];
  candidate.voxel_V = VoxelAt(transform(*blocks_, candidate.block, lane));
  candidate.mark = voxmap_->Value(blocks_->fields()[candidate.block], candidate.voxel_V);
  candidate.nhat_V = R_VS * Vec3(n.x[lane], n.y[lane], n.z[lane]);
  candidate.p_V = R_VS * Vec3(p.x[lane], p.y[lane], p.z[lane]) + X_VS.p +
                  schedule_->displacement() * candidate.nhat_V;
}

void ContactPair::FindContacts(const Pose& X_VS, const VoxelTransform& transform) noexcept {
  const Mat3 R_VS = X_VS.q.toRotationMatrix();
  const std::span<Candidate> candidates(candidates_.data(), candidate_count_);
  const auto place = [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t i = begin; i < end; ++i) {
      if (i + kAhead < candidates.size()) Fetch(*blocks_, candidates[i + kAhead]);
      Place(X_VS, R_VS, transform, candidates[i]);
    }
  };
  if (workers_ != nullptr && candidate_count_ >= shared_from_) {
    workers_->WakeWorkers();
    workers_->ParallelFor(candidate_count_, kPiece, place);
  } else {
    // as many at a time as the first-level cache holds
    for (std::size_t begin = 0; begin < candidate_count_; begin += kPiece) {
      place(begin, std::min(begin + kPiece, candidate_count_), 0);
    }
  }
  contact_count_ = FindPlainContacts(candidates, *voxmap_, clearance_.layers, contacts_.data());
}

void ContactPair::AddForces(const Pose& X_VS, const BodyMotion& shell_body,
                            const BodyMotion& map_body, const Pose& X_WV, PairReport& report,
                            LinearizedForce& on_shell, LinearizedForce& on_map) noexcept {
  if (contact_count_ == 0) return;
  report.pushing_points = static_cast<int>(contact_count_);
  const ForceRule rule{gains_, voxmap_->voxel_size()};
  const CrossJacobian cross =
      AddContactForces(std::span(contacts_).first(contact_count_),
                       {X_VS, X_WV, shell_body, map_body}, rule, on_shell, on_map);
  if (both_move_) cross_ = cross;
}

PairReport ContactPair::Collide(const BodyMotion& shell_body, const BodyMotion& map_body,
                                LinearizedForce& on_shell, LinearizedForce& on_map) noexcept {
  PairReport report;
  const Pose X_WV = map_body.X_WB * X_BV_;
  const Pose X_VS = X_WV.Inverse() * shell_body.X_WB;
  const double travel =
      travel_.BoundApproach(shell_body.X_WB, shell_->radius + std::abs(schedule_->displacement()),
                            map_body.X_WB, map_radius_, X_BV_);
  waiting_ += travel;
  if (reader_ != nullptr) reader_->MoveTo(X_VS, travel / voxmap_->voxel_size());
  // a gap above `enough` shrinks by at most the travel
  const double enough = kEnoughVoxels * voxmap_->voxel_size();
  gap_ -= travel;
  if (!(gap_ > enough)) gap_ = GapBetween(map_extent_, shell_extent_, X_VS, 2.0 * enough);
  // broad phase: nothing can be in contact, so nothing is tested and the queues wait
  contact_count_ = 0;
  if (Gap() > 0) return report;
  schedule_->Test(X_VS, waiting_);
  waiting_ = 0;
  if (schedule_->waits()) {
    report.waits = true;
    return report;
  }
  report.tests = schedule_->counts();
  candidate_count_ = 0;
  for (const Schedule::ContactBlock& contact : schedule_->contacts()) {
    for (unsigned lanes = contact.lanes; lanes != 0; lanes &= lanes - 1) {
      AddCandidate(contact.block, static_cast<std::uint32_t>(std::countr_zero(lanes)), report);
    }
  }
  FindContacts(X_VS, schedule_->transform());
  AddForces(X_VS, shell_body, map_body, X_WV, report, on_shell, on_map);
  query_cost_ = kPushShare * static_cast<double>(contact_count_) +
                kCandidateShare * static_cast<double>(candidate_count_);
  report.query_cost = query_cost_;
  return report;
}

void ContactPair::Announce(const BodyMotion& shell_body, const BodyMotion& map_body) noexcept {
  schedule_->Announce((map_body.X_WB * X_BV_).Inverse() * shell_body.X_WB);
}

void ContactPair::Rest() noexcept {
  if (reader_ != nullptr && reader_->Leave()) schedule_->ForgetVoxels();
}

ClearanceBounds ContactPair::clearance_bounds() const noexcept {
  return ClearanceBounds::ForMarks(voxmap_->range(), voxmap_->voxel_size());
}

TestDemand ContactPair::test_demand() const noexcept {
  TestDemand demand;
  if (Gap() <= 0) {
    demand = schedule_->Demand();
    demand.exact_queries = query_cost_;
    return demand;
  }
  demand.bound = std::max(0.5 * voxmap_->voxel_size(), Gap());
  return demand;
}

void ContactPair::LimitTravel(double metres) noexcept {
  // a distant pair is not scheduled: waiting_ has its travel
  schedule_->LimitTravel(Gap() > 0 ? 0.0 : metres);
}

void ContactPair::SetClearance(const Clearance& clearance) noexcept {
  const int layer = static_cast<int>(std::ceil(clearance.layers));
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
  FindContacts(X_VS, transform);
  LinearizedForce on_map;
  AddForces(X_VS, shell_body, map_body, X_WV, report, reading.on_shell, on_map);
  reading.contact_points = report.contact_points;
  return reading;
}

}  // namespace tandem
