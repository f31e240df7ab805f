#include "engine/contact/schedule/point_schedule.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "engine/paging/resident_voxels.h"

namespace tandem {

PointSchedule::PointSchedule(const PointBlocks& blocks, const Voxmap& voxmap, int force_layer,
                             const ScheduleOptions& options, VoxelReader* reader)
    : Schedule(blocks, voxmap, force_layer),
      options_(options),
      blocks_in_(blocks.size()),
      chunks_in_(blocks.chunks().size()),
      open_(blocks.chunks().size(), 0),
      lanes_(blocks.size(), 0),
      due_(std::max(blocks.size(), blocks.chunks().size())),
      drift_(blocks, options.workers != nullptr ? options.workers->threads() : 1),
      tallies_(options.workers != nullptr ? static_cast<std::size_t>(options.workers->threads())
                                          : 1),
      reader_(reader) {
  if (reader_ != nullptr) {
    there_.assign(blocks.chunks().size(), 0);
    hinted_.assign(blocks.chunks().size(), kNowhere);
    chunk_of_.resize(blocks.size());
    for (std::uint32_t c = 0; c < there_.size(); ++c) {
      const PointBlocks::Chunk& chunk = blocks.chunks()[c];
      std::fill_n(chunk_of_.begin() + chunk.first_block, chunk.block_count, c);
    }
  }
  // all places are still unknown: the first Test() finds them
  for (std::size_t c = 0; c < open_.size(); ++c) {
    if (options_.experiments.chunks) {
      chunks_in_.Put(c, 0);
      continue;
    }
    open_[c] = 1;
  }
  if (!options_.experiments.chunks) {
    for (std::size_t b = 0; b < blocks.size(); ++b) blocks_in_.Put(b, 0);
  }
}

void PointSchedule::SetForceLayer(int layer) noexcept {
  CheckForceLayer(layer);
  // a thicker layer comes nearer as a body would; a thinner one leaves more room than is known
  owed_ += std::max(0, layer - layer_) * s_;
  layer_ = layer;
}

void PointSchedule::SetDisplacement(double metres) noexcept {
  owed_ += std::abs(metres - displacement_);
  displacement_ = metres;
  drift_.ForgetAll();
}

double PointSchedule::Allowance(int queue) const noexcept {
  return std::max(0.0, queue - 1 - place_error_);
}

void PointSchedule::TestChunk(std::size_t c, const Pose& X_VS) noexcept {
  const PointBlocks::Chunk& chunk = blocks_->chunks()[c];
  const double radius = (chunk.radius + std::abs(displacement_)) / s_ + place_error_;
  const Vec3 p = X_VS * chunk.p_BC / (kChunkSide * s_);
  const GridIndex at{static_cast<std::int32_t>(std::floor(p.x())),
                     static_cast<std::int32_t>(std::floor(p.y())),
                     static_cast<std::int32_t>(std::floor(p.z()))};
  const int distance = voxmap_->ChunkValue(at) - 2;
  // certain for every point of the chunk, up to the force layer
  const double gap = kChunkSide * (distance - 1) + range_ - layer_ - radius;
  ++counts_.chunks;
  if (open_[c] == 0 && kChunkSide * (distance - 1) < radius) {
    open_[c] = 1;
    const int queue = std::clamp(static_cast<int>(std::floor(gap)) + 1, 0, highest_queue());
    for (std::uint32_t b = chunk.first_block; b < chunk.first_block + chunk.block_count; ++b) {
      blocks_in_.Put(b, queue);
      drift_.Forget(b);
    }
  } else if (open_[c] != 0 && kChunkSide * (distance - 2) >= radius) {
    open_[c] = 0;
    for (std::uint32_t b = chunk.first_block; b < chunk.first_block + chunk.block_count; ++b) {
      blocks_in_.Sleep(b);
    }
  }
  if (reader_ != nullptr) AnnounceChunk(c, kChunkSide * p, radius, gap);
  // an open chunk is looked at once per chunk of travel, to see it leave: a late look does no harm
  const double allowance = open_[c] != 0 ? kChunkSide : gap - 2.0;
  chunks_in_.Put(c, std::clamp(static_cast<int>(allowance / kChunkUnit), 0, 15));
}

void PointSchedule::AnnounceChunk(std::size_t c, const Vec3& p_voxels, double radius,
                                  double gap) noexcept {
  // at half a voxel a frame
  constexpr auto frames = [](double voxels) {
    return static_cast<std::uint32_t>(2.0 * std::max(0.0, voxels));
  };
  if (open_[c] != 0) {
    there_[c] = reader_->Announce(p_voxels, radius + kUntilTested, frames(gap)) ? 1 : 0;
  }
  constexpr double kHintCell = 16;   // voxels
  constexpr double kHintRange = 40;  // voxels beyond what is announced
  if (gap > kHintRange) return;
  const Vec3 cell = p_voxels / kHintCell;
  const GridIndex at{static_cast<std::int32_t>(std::floor(cell.x())),
                     static_cast<std::int32_t>(std::floor(cell.y())),
                     static_cast<std::int32_t>(std::floor(cell.z()))};
  if (at == hinted_[c]) return;
  const double range = radius + kUntilTested + kHintRange;
  if (reader_->Hint(p_voxels, range, frames(gap + kUntilTested))) hinted_[c] = at;
}

void PointSchedule::Announce(const Pose& X_VS) noexcept {
  if (reader_ == nullptr) return;
  reader_->MoveTo(X_VS, 0);
  for (const PointBlocks::Chunk& chunk : blocks_->chunks()) {
    const double radius = (chunk.radius + std::abs(displacement_)) / s_ + kUntilTested;
    reader_->Announce(X_VS * chunk.p_BC / s_, radius + place_error_, 0);
  }
}

void PointSchedule::ForgetVoxels() noexcept {
  std::fill(there_.begin(), there_.end(), 0);
  std::fill(hinted_.begin(), hinted_.end(), kNowhere);
}

bool PointSchedule::DuePagesAreResident() noexcept {
  bool all = true;
  const double margin = std::abs(displacement_) / s_ + 2.0 * place_error_;
  for (std::size_t k = 0; k < due_count_; ++k) {
    const std::uint32_t b = due_[k];
    if (there_[chunk_of_[b]] != 0) continue;
    if (options_.experiments.drift && blocks_in_.queue_of(b) > 1 && QueueByDrift(b, 0) >= 0)
      continue;
    const PointBlocks::Ball& ball = blocks_->balls()[b];
    const auto& a = transform_.a;
    Vec3 p;
    for (Eigen::Index row = 0; row < 3; ++row) {
      const auto r = static_cast<std::size_t>(row);
      p[row] = a[3 * r] * ball.x + a[3 * r + 1] * ball.y + a[3 * r + 2] * ball.z + transform_.b[r];
    }
    // asks for all of them at once
    all = reader_->Announce(p, ball.radius / s_ + margin, 0) && all;
  }
  return all;
}

void PointSchedule::TestChunks(const Pose& X_VS, double travel_voxels) noexcept {
  if (!options_.experiments.chunks) return;
  due_count_ = 0;
  const auto note = [this](std::size_t c) {
    due_[due_count_++] = static_cast<std::uint32_t>(c);
  };
  chunks_in_.VisitAll(0, note);
  for (int q = 1; q < DistanceQueues::kQueues; ++q) {
    chunks_in_.Sweep(q, travel_voxels / (kChunkUnit * q), note);
  }
  for (std::size_t k = 0; k < due_count_; ++k) TestChunk(due_[k], X_VS);
}

void PointSchedule::CollectStrip(std::size_t strip) noexcept {
  const std::size_t begin = blocks_in_.StripBegin(strip);
  std::size_t end = begin;
  const auto note = [this, &end](std::size_t b) {
    due_[end++] = static_cast<std::uint32_t>(b);
  };
  for (int q = 0; q < DistanceQueues::kQueues; ++q) {
    blocks_in_.VisitPassed(q, passed_[static_cast<std::size_t>(q)], strip, note);
  }
  due_in_[strip] = end - begin;
}

void PointSchedule::CollectDue(double travel_voxels) noexcept {
  const int mandatory = options_.experiments.coherence ? 1 : DistanceQueues::kQueues - 1;
  for (int q = 0; q < DistanceQueues::kQueues; ++q) {
    passed_[static_cast<std::size_t>(q)] =
        q <= mandatory ? DistanceQueues::kAll : blocks_in_.Advance(q, travel_voxels / Allowance(q));
  }
  const auto collect = [this](std::size_t begin, std::size_t end, int) {
    for (std::size_t strip = begin; strip < end; ++strip) CollectStrip(strip);
  };
  // about as much is due as in the last frame
  if (shared_) {
    options_.workers->ParallelFor(DistanceQueues::kStrips, 1, collect);
  } else {
    collect(0, DistanceQueues::kStrips, 0);
  }
  due_count_ = 0;
  for (std::size_t strip = 0; strip < DistanceQueues::kStrips; ++strip) {
    const auto from = due_.begin() + static_cast<std::ptrdiff_t>(blocks_in_.StripBegin(strip));
    std::copy_n(from, due_in_[strip], due_.begin() + static_cast<std::ptrdiff_t>(due_count_));
    due_count_ += due_in_[strip];
  }
}

int PointSchedule::QueueByDrift(std::uint32_t b, int thread) noexcept {
  const double drift = drift_.DriftSinceLookup(b, thread) + 4 * place_error_;
  const double gap = QueueOf(drift_.nearest(b)) - 1 - drift;
  if (!(gap >= 2.0)) return -1;  // queue 2 or nearer
  return std::min(static_cast<int>(gap) + 1, highest_queue());
}

void PointSchedule::TestDue(std::size_t begin, std::size_t end, int thread) noexcept {
  constexpr std::size_t kAhead = 12;  // blocks
  Tally& tally = tallies_[static_cast<std::size_t>(thread)];
  std::array<std::uint32_t, kPiece> list;
  std::array<BlockReading, kPiece> readings;
  while (begin < end) {
    const std::size_t stop = std::min(begin + kPiece, end);
    std::size_t count = 0;
    for (; begin < stop; ++begin) {
      if (options_.experiments.drift && begin + kAhead < end) drift_.Fetch(due_[begin + kAhead]);
      const std::uint32_t b = due_[begin];
      if (options_.experiments.drift && blocks_in_.queue_of(b) > 1) {
        const int queue = QueueByDrift(b, thread);
        if (queue >= 0) {
          PutDue(b, queue, tally);
          tally.counts.drifted += blocks_->counts()[b];
          continue;
        }
      }
      list[count++] = b;
    }
    TestBlocks(*blocks_, transform_, *voxmap_, 2 + layer_, {list.data(), count}, readings.data());
    for (std::size_t k = 0; k < count; ++k) {
      const std::uint32_t b = list[k];
      const BlockReading& reading = readings[k];
      PutDue(b, QueueOf(reading.nearest), tally);
      drift_.LookedUp(b, reading.nearest);
      tally.counts.looked_up += blocks_->counts()[b];
      lanes_[b] = reading.contacts;
    }
  }
}

void PointSchedule::TestDueInParallel() noexcept {
  shared_ = options_.workers != nullptr && due_count_ >= options_.shared_from;
  if (shared_) {
    options_.workers->WakeWorkers();
    options_.workers->ParallelFor(due_count_, kPiece,
                                  [this](std::size_t begin, std::size_t end, int thread) {
                                    TestDue(begin, end, thread);
                                  });
  } else {
    TestDue(0, due_count_, 0);
  }
  for (Tally& tally : tallies_) {
    counts_ += tally.counts;
    blocks_in_.Add(tally.moves);
    tally = {};
  }
  // every block in queue 0 was looked up in this frame
  blocks_in_.VisitAll(0, [this](std::size_t b) {
    contacts_[contact_count_++] = {static_cast<std::uint32_t>(b), lanes_[b]};
  });
}

void PointSchedule::Collect(const Pose& X_VS, double travel_voxels) noexcept {
  // a schedule that waited and moves all the same looks up what is due where it stands
  if (waits_) {
    for (std::size_t k = 0; k < due_count_; ++k) blocks_in_.Put(due_[k], 0);
  }
  counts_ = {};
  // as much as in the last frame: workers come while the list is made
  if (shared_) options_.workers->WakeWorkers();
  transform_ = VoxelTransform(X_VS, s_, displacement_);
  TestChunks(X_VS, travel_voxels);
  CollectDue(travel_voxels);
  // where nothing has moved the last frame goes on: a frame that waits ages no look-up
  if (travel_voxels > 0) drift_.Begin(transform_);
}

void PointSchedule::Test(const Pose& X_VS, double travel) noexcept {
  contact_count_ = 0;
  const double travel_voxels = (travel + owed_) / s_ * (1 + 1e-9);
  owed_ = 0;
  if (!waits_ || travel_voxels > 0) Collect(X_VS, travel_voxels);
  waits_ = reader_ != nullptr && !DuePagesAreResident();
  if (!waits_) TestDueInParallel();
}

TestDemand PointSchedule::Demand() const noexcept {
  TestDemand demand;
  demand.bound = 0.5 * s_;
  constexpr double kPerBlock = PointBlocks::kLanes;
  if (!options_.experiments.coherence) {
    demand.mandatory = kPerBlock * static_cast<double>(blocks_in_.awake());
  } else {
    demand.mandatory = kPerBlock * static_cast<double>(blocks_in_.count(0) + blocks_in_.count(1));
    for (int q = 2; q < DistanceQueues::kQueues; ++q) {
      demand.per_metre +=
          kPerBlock * static_cast<double>(blocks_in_.count(q)) / (Allowance(q) * s_);
    }
  }
  demand.mandatory += static_cast<double>(chunks_in_.count(0));
  for (int q = DistanceQueues::kQueues - 1; q >= 1; --q) {
    if (chunks_in_.count(q) == 0) continue;
    demand.per_metre += static_cast<double>(chunks_in_.count(q)) / (kChunkUnit * q * s_);
    // no block awake: as far as the nearest whole chunk allows (paper fn. 3)
    if (blocks_in_.awake() == 0) demand.bound = std::min(32.0, kChunkUnit * q) * s_;
  }
  if (chunks_in_.count(0) > 0) demand.bound = 0.5 * s_;
  return demand;
}

}  // namespace tandem
