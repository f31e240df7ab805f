#include "app/bench/reference/printed_schedule.h"

#include <algorithm>
#include <cmath>

#include "app/bench/reference/gathered_lookup.h"

namespace tandem {

namespace {
constexpr std::size_t kLanes = PointBlocks::kLanes;

/// Returns Eqn. 3's number, with MaxTravel and the allowance in one unit.
std::size_t RoundRobin(std::size_t members, double most, double allowance) {
  const double share = std::min(1.0, most / allowance);
  return static_cast<std::size_t>(std::ceil(share * static_cast<double>(members)));
}
}  // namespace

PrintedSchedule::PrintedSchedule(const PointBlocks& blocks, const Voxmap& voxmap, int force_layer,
                                 const ScheduleOptions& options)
    : Schedule(blocks, voxmap, force_layer),
      options_(options),
      points_in_(kLanes * blocks.size()),
      chunks_in_(blocks.chunks().size()),
      open_(blocks.chunks().size(), options.experiments.chunks ? 0 : 1),
      due_(std::max(kLanes * blocks.size(), blocks.chunks().size())),
      marks_(kLanes * blocks.size()),
      lanes_(blocks.size(), 0),
      lookups_(kLanes * blocks.size()) {
  std::array<std::size_t, kFields> points{};
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    points[static_cast<std::size_t>(blocks.fields()[b])] += blocks.counts()[b];
  }
  for (std::size_t f = 0; f < kFields; ++f) {
    lists_[f].addresses.resize(points[f]);
    for (std::vector<float>* axis : {&lists_[f].x, &lists_[f].y, &lists_[f].z}) {
      axis->resize(points[f]);
    }
  }
  // all places are still unknown: the first Test() finds them
  if (options.experiments.chunks) {
    for (std::size_t c = 0; c < open_.size(); ++c) chunks_in_.Put(c, 0);
    return;
  }
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    for (std::size_t k = 0; k < blocks.counts()[b]; ++k) points_in_.Put(kLanes * b + k, 0);
  }
}

void PrintedSchedule::TestAnew() noexcept {
  for (std::size_t a = 0; a < points_in_.addresses(); ++a) {
    if (points_in_.queue_of(a) != DistanceQueues::kAsleep) points_in_.Put(a, 0);
    lookups_[a].queue = 0;
  }
  if (!options_.experiments.chunks) return;
  for (std::size_t c = 0; c < open_.size(); ++c) chunks_in_.Put(c, 0);
}

void PrintedSchedule::SetForceLayer(int layer) noexcept {
  CheckForceLayer(layer);
  layer_ = layer;
  TestAnew();
}

void PrintedSchedule::SetDisplacement(double metres) noexcept {
  displacement_ = metres;
  TestAnew();
}

void PrintedSchedule::CollectDue(DistanceQueues& queues, bool coherence, double most) noexcept {
  due_count_ = 0;
  const auto note = [this](std::size_t address) {
    due_[due_count_++] = static_cast<std::uint32_t>(address);
  };
  queues.VisitAll(0, note);
  for (int q = 1; q < DistanceQueues::kQueues; ++q) {
    const std::size_t members = queues.count(q);
    queues.VisitNext(q, coherence ? RoundRobin(members, most, kShare * q) : members, note);
  }
}

void PrintedSchedule::TestChunk(std::size_t c, const Pose& X_VS) noexcept {
  const PointBlocks::Chunk& chunk = blocks_->chunks()[c];
  const Vec3 p = X_VS * chunk.p_BC / (kChunkSide * s_);
  const GridIndex at{static_cast<std::int32_t>(std::floor(p.x())),
                     static_cast<std::int32_t>(std::floor(p.y())),
                     static_cast<std::int32_t>(std::floor(p.z()))};
  // distance to the nearest chunk beside those with voxels
  const int queue = std::clamp(voxmap_->ChunkValue(at) - 3, 0, kFarthestChunk);
  ++counts_.chunks;
  chunks_in_.Put(c, queue);
  const std::uint8_t open = queue == 0 ? 1 : 0;
  if (open == open_[c]) return;
  open_[c] = open;
  for (std::size_t b = chunk.first_block; b < chunk.first_block + chunk.block_count; ++b) {
    for (std::size_t a = kLanes * b; a < kLanes * b + blocks_->counts()[b]; ++a) {
      if (open != 0) {
        points_in_.Put(a, 0);
        lookups_[a].queue = 0;
      } else {
        points_in_.Sleep(a);
      }
    }
  }
}

void PrintedSchedule::TestChunks(const Pose& X_VS, double most) noexcept {
  if (!options_.experiments.chunks) return;
  CollectDue(chunks_in_, true, most / kChunkSide);
  for (std::size_t k = 0; k < due_count_; ++k) TestChunk(due_[k], X_VS);
}

bool PrintedSchedule::StillFar(std::uint32_t address, const std::array<float, 3>& p_V) noexcept {
  const Lookup& lookup = lookups_[address];
  float square = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    square += (p_V[k] - lookup.p_V[k]) * (p_V[k] - lookup.p_V[k]);
  }
  const float drift = std::min(std::sqrt(square), 16.0F);
  const int queue = lookup.queue - static_cast<int>(drift);
  if (queue <= 2) return false;
  points_in_.Put(address, queue);
  ++counts_.drifted;
  return true;
}

void PrintedSchedule::LookUpAll(Field field) noexcept {
  const List& list = lists_[static_cast<std::size_t>(field)];
  TestScattered(
      {{list.x.data(), list.count}, {list.y.data(), list.count}, {list.z.data(), list.count}},
      *voxmap_, field, marks_.data());
  counts_.looked_up += list.count;
  for (std::size_t k = 0; k < list.count; ++k) {
    const std::uint32_t address = list.addresses[k];
    const int queue = QueueOf(marks_[k]);
    points_in_.Put(address, queue);
    lookups_[address] = {{list.x[k], list.y[k], list.z[k]}, static_cast<std::uint8_t>(queue)};
    if (queue > 0) continue;
    const std::size_t b = address / kLanes;
    if (lanes_[b] == 0) contacts_[contact_count_++].block = static_cast<std::uint32_t>(b);
    lanes_[b] = static_cast<std::uint16_t>(lanes_[b] | 1U << address % kLanes);
  }
}

void PrintedSchedule::Test(const Pose& X_VS, double travel) noexcept {
  counts_ = {};
  contact_count_ = 0;
  // travel exceeds the limit only where nothing was near enough to be tested
  const double most = std::max(limit_, travel) / s_;
  transform_ = VoxelTransform(X_VS, s_, displacement_);
  TestChunks(X_VS, most);
  CollectDue(points_in_, options_.experiments.coherence, most);
  for (List& list : lists_) list.count = 0;
  for (std::size_t k = 0; k < due_count_; ++k) {
    const std::uint32_t address = due_[k];
    const std::size_t b = address / kLanes;
    const std::array<float, 3> p_V = transform_(*blocks_, b, address % kLanes);
    if (options_.experiments.drift && StillFar(address, p_V)) continue;
    List& list = lists_[static_cast<std::size_t>(blocks_->fields()[b])];
    list.addresses[list.count] = address;
    list.x[list.count] = p_V[0];
    list.y[list.count] = p_V[1];
    list.z[list.count] = p_V[2];
    ++list.count;
  }
  for (const Field field : kAllFields) LookUpAll(field);
  for (std::size_t k = 0; k < contact_count_; ++k) {
    std::uint16_t& lanes = lanes_[contacts_[k].block];
    contacts_[k].lanes = lanes;
    lanes = 0;
  }
  SortContacts();
}

TestDemand PrintedSchedule::Demand() const noexcept {
  TestDemand demand;
  demand.bound = 0.5 * s_;
  if (!options_.experiments.coherence) {
    demand.mandatory = static_cast<double>(points_in_.awake());
  } else {
    demand.mandatory = static_cast<double>(points_in_.count(0));
    for (int q = 1; q < DistanceQueues::kQueues; ++q) {
      demand.per_metre += static_cast<double>(points_in_.count(q)) / (kShare * q * s_);
    }
  }
  if (!options_.experiments.chunks) return demand;
  demand.mandatory += static_cast<double>(chunks_in_.count(0));
  for (int q = 1; q <= kFarthestChunk; ++q) {
    demand.per_metre += static_cast<double>(chunks_in_.count(q)) / (kShare * kChunkSide * q * s_);
  }
  // footnote 3
  if (chunks_in_.count(kFarthestChunk) == open_.size()) demand.bound = 0.5 * kHyperchunkSide * s_;
  return demand;
}

std::unique_ptr<Schedule> MakePrintedSchedule(const PointBlocks& blocks, const Voxmap& voxmap,
                                              int force_layer, const ScheduleOptions& options) {
  return std::make_unique<PrintedSchedule>(blocks, voxmap, force_layer, options);
}

}  // namespace tandem
