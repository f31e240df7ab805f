#include "engine/contact/field/field_schedule.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

#include "engine/contact/features/edge_contact.h"
#include "engine/contact/features/edge_parts.h"

namespace tandem {

namespace {

/// Voxels of gap up to which a sharp edge's part counts as one that may cross another, if some part
/// of its block may. The schedule looks again only when other parts may have come so far.
constexpr double kCrossingMargin = 0.1;
/// Voxels a frame from which on a body is fast, and the number of its frames to look ahead.
constexpr double kFast = 0.25;
constexpr double kFramesAhead = 3;
/// Returns a number from 0.5 to 1, scattered over the blocks.
constexpr double ShareOfMargin(std::uint32_t block) noexcept {
  return 0.5 + 0.5 / 65536 * (block * 0x9e3779b1U >> 16U);
}
/// The tests of a block that is looked up at its middle and at its points.
constexpr std::uint32_t kWholeBlock = 1 + BodyFeatures::kLanes;

}  // namespace

FieldSchedule::FieldSchedule(const BodyFeatures& features, const DistanceField& field,
                             const BodyFeatures* other, const Centre& centre,
                             const ScheduleOptions& options)
    : features_(&features),
      field_(&field),
      other_(other),
      options_(options),
      centre_(centre),
      calendar_(features.blocks().size(), centre.radius),
      chunks_(features.chunks().size(), centre.radius),
      is_far_(features.blocks().size(), 1),
      edges_due_(other != nullptr ? features.blocks().size() : 0),
      is_due_(features.blocks().size() / 64 + 1),
      due_words_(is_due_.size() / 64 + 1),
      due_(features.blocks().size()),
      due_chunks_(features.chunks().size()),
      results_(features.blocks().size()),
      near_(features.blocks().size()) {
  for (const BodyFeatures::Chunk& chunk : features.chunks()) far_in_.push_back(chunk.count);
  // all places are still unknown: the first Test() finds them
  for (std::size_t c = 0; c < far_in_.size(); ++c) {
    chunks_.Put(static_cast<std::uint32_t>(c), 0, 0, kWholeBlock * far_in_[c]);
  }
}

void FieldSchedule::Place(const Pose& X_VF) noexcept {
  R_VF_ = X_VF.q.toRotationMatrix();
  p_VF_ = X_VF.p;
  for (std::size_t i = 0; i < 9; ++i) {
    rows_[i] = static_cast<float>(
        R_VF_(static_cast<Eigen::Index>(i / 3), static_cast<Eigen::Index>(i % 3)));
  }
}

void FieldSchedule::Test(const Pose& X_VF, const PairMotion& motion, double reach,
                         double inner) noexcept {
  Place(X_VF);
  counts_ = {};
  // a wider reach comes nearer as a body would, and beyond the fine band force may begin early
  const double fine = field_->fine_band();
  const double early = reach > fine && reach_ <= fine ? field_->most_early() : 0.0;
  const double wider = std::max(0.0, reach - reach_) + early;
  reach_ = reach;
  inner_ = inner;
  const double more =
      options_.experiments.coherence ? wider : std::numeric_limits<double>::infinity();
  // edges' gaps count by the odometer, which does not run over a jump
  if (!std::isfinite(motion.way + more))
    std::fill(edges_due_.begin(), edges_due_.end(), EdgesDue{});
  std::size_t chunk_count = 0;
  const auto take = [this](std::uint32_t block) {
    AddDue(block);
  };
  const auto take_chunk = [&](std::uint32_t chunk) {
    due_chunks_[chunk_count++] = chunk;
  };
  calendar_.Advance(motion, more, take);
  chunks_.Advance(motion, more, take_chunk);
  // where nothing is near, what comes due soon must not slow a fast body before its distance is
  // known
  motion_ = motion;
  pace_ = motion.way + motion.angle * centre_.radius;
  if (near_count_ == 0 && pace_ > kFast && std::isfinite(pace_)) {
    calendar_.TakeWithin(kFramesAhead * pace_, take);
    chunks_.TakeWithin(kFramesAhead * pace_, take_chunk);
  }
  for (std::size_t c = 0; c < chunk_count; ++c) {
    if (PutIfFar(due_chunks_[c])) continue;
    const BodyFeatures::Chunk& chunk = features_->chunks()[due_chunks_[c]];
    for (std::uint32_t b = chunk.first; b < chunk.first + chunk.count; ++b) AddDue(b);
  }
  TestAll();
  PutDue();
}

bool FieldSchedule::PutIfFar(std::uint32_t number) noexcept {
  if (!options_.experiments.chunks || !options_.experiments.coherence) return false;
  const BodyFeatures::Chunk& chunk = features_->chunks()[number];
  ++counts_.chunks;
  const Vec3 place = R_VF_ * chunk.middle + p_VF_;
  const FieldReading reading = field_->At(place);
  const double error = reading.near ? DistanceField::kMostOver : 0.0;
  const double gap = reading.value - error - chunk.radius - reach_;
  if (gap <= kFar) return false;
  chunks_.Put(number, RadiusOf(chunk.middle, place) + chunk.radius, gap, 1);
  return true;
}

void FieldSchedule::TestAll() noexcept {
  // the calendar's order reflects the past; blocks in order read memory in order
  due_count_ = 0;
  const auto visit = [](std::vector<std::uint64_t>& words, std::size_t k, const auto& what) {
    for (std::uint64_t bits = std::exchange(words[k], 0); bits != 0; bits &= bits - 1) {
      what(64 * k + static_cast<std::size_t>(std::countr_zero(bits)));
    }
  };
  for (std::size_t k = 0; k < due_words_.size(); ++k) {
    visit(due_words_, k, [&](std::size_t word) {
      visit(is_due_, word, [&](std::size_t block) {
        due_[due_count_++] = static_cast<std::uint32_t>(block);
      });
    });
  }
  const auto test = [this](std::size_t begin, std::size_t end, int) {
    TestDue(begin, end);
  };
  if (options_.workers != nullptr && due_count_ >= options_.shared_from) {
    options_.workers->WakeWorkers();
    options_.workers->ParallelFor(due_count_, kPiece, test);
  } else {
    for (std::size_t begin = 0; begin < due_count_; begin += kPiece) {
      test(begin, std::min(begin + kPiece, due_count_), 0);
    }
  }
}

void FieldSchedule::TestDue(std::size_t begin, std::size_t end) noexcept {
  std::array<float, kPiece> x{};
  std::array<float, kPiece> y{};
  std::array<float, kPiece> z{};
  std::array<float, kPiece> values;
  std::array<std::int32_t, kPiece> kinds;
  std::array<float, kPiece> over;
  std::array<std::uint32_t, kPiece> near;
  std::size_t count = 0;
  for (std::size_t k = begin; k < end; ++k) {
    const GridIndex& middle = features_->blocks()[due_[k]].middle;
    const Vec3 place = R_VF_ * Vec3(middle.x, middle.y, middle.z) + p_VF_;
    x[k - begin] = static_cast<float>(place.x());
    y[k - begin] = static_cast<float>(place.y());
    z[k - begin] = static_cast<float>(place.z());
    results_[k].out = static_cast<float>(RadiusOf(Vec3(middle.x, middle.y, middle.z), place));
  }
  const std::size_t padded = (end - begin + 15) / 16 * 16;
  field_->Values({0, 0, 0}, {x.data(), y.data(), z.data()}, padded, values.data(), kinds.data(),
                 over.data());
  for (std::size_t k = begin; k < end; ++k) {
    const std::size_t i = k - begin;
    const BodyFeatures::Block& block = features_->blocks()[due_[k]];
    const double seam = block.sharp != 0 ? kSeam : 0.0;
    const double gap = values[i] - over[i] - block.radius - seam - reach_ - kPlaceError;
    results_[k] = {.gap = static_cast<float>(gap), .out = results_[k].out};
    if (gap < middle_enough_) near[count++] = static_cast<std::uint32_t>(k);
  }
  for (std::size_t at = 0; at < count; at += kBlockPlaces) {
    QueryPoints(std::span(near).subspan(at, std::min(kBlockPlaces, count - at)));
  }
}

void FieldSchedule::QueryPoints(std::span<const std::uint32_t> which) noexcept {
  std::array<PlacedBlock, kBlockPlaces> blocks;
  std::array<float, kBlockPlaces * kBlockPlaces> bounds;
  std::array<FieldReadings, kBlockPlaces> readings;
  for (std::size_t i = 0; i < which.size(); ++i) {
    const std::uint32_t b = due_[which[i]];
    const GridIndex& middle = features_->blocks()[b].middle;
    const BodyFeatures::Lanes& lanes = features_->lanes(b);
    const Vec3 place = R_VF_ * Vec3(middle.x, middle.y, middle.z) + p_VF_;
    const GridIndex base{static_cast<std::int32_t>(place.x()), static_cast<std::int32_t>(place.y()),
                         static_cast<std::int32_t>(place.z())};
    blocks[i] = {.places_F = {lanes.x.data(), lanes.y.data(), lanes.z.data()},
                 .lanes = features_->blocks()[b].lanes,
                 .base = base,
                 .from_base = {static_cast<float>(place.x() - base.x),
                               static_cast<float>(place.y() - base.y),
                               static_cast<float>(place.z() - base.z)}};
  }
  field_->ReadBlocks(rows_, static_cast<float>(reach_), std::span(blocks).first(which.size()),
                     bounds.data(), readings.data());
  for (std::size_t i = 0; i < which.size(); ++i) {
    BlockResults& results = results_[which[i]];
    results.touching = readings[i].within;
    results.gap = static_cast<float>(readings[i].least - reach_ - kPlaceError);
    results.points = true;
    SortByReach(&bounds[kBlockPlaces * i], results);
    const std::uint32_t b = due_[which[i]];
    if (other_ != nullptr && features_->blocks()[b].sharp != 0) {
      QueryEdges(b, &bounds[kBlockPlaces * i], results);
    }
  }
}

void FieldSchedule::SortByReach(const float* bounds, BlockResults& results) const noexcept {
  results.nearer = results.touching;
  if (!(inner_ < reach_)) return;
  constexpr double kJustWithin = 0.01;  // voxels
  for (unsigned rest = results.touching; rest != 0; rest &= rest - 1) {
    const int lane = std::countr_zero(rest);
    if (bounds[lane] - kPlaceError > inner_) {
      results.nearer = static_cast<std::uint16_t>(results.nearer & ~(1U << lane));
    }
    results.count +=
        static_cast<float>(std::clamp((reach_ - bounds[lane]) / kJustWithin, 0.0, 1.0));
  }
}

void FieldSchedule::QueryEdges(std::uint32_t b, const float* bounds,
                               BlockResults& results) noexcept {
  EdgesDue& due = edges_due_[b];
  const double known = due.at - calendar_.odometer(due.ring);
  if (known > 0) {
    results.crossing = due.crossing;
    results.gap = std::min(results.gap, due.crossing != 0 ? 0 : static_cast<float>(known));
    return;
  }
  const BodyFeatures::Block& block = features_->blocks()[b];
  const double edge_reach = EdgeReach(reach_);
  const Vec3 middle = R_VF_ * Vec3(block.middle.x, block.middle.y, block.middle.z) + p_VF_;
  const double most_half = features_->longest_half() + other_->longest_half() + kSeam;
  const double beyond = other_->EdgesBeyond(middle) - block.radius - edge_reach - most_half;
  double least = beyond;
  if (beyond <= kEdgesEnough) {
    least = std::numeric_limits<double>::infinity();
    std::array<EdgePart, kBlockPlaces> parts;
    std::size_t count = 0;
    for (unsigned rest = block.sharp; rest != 0; rest &= rest - 1) {
      const auto lane = static_cast<std::size_t>(std::countr_zero(rest));
      const BodyFeatures::Edge& edge = features_->edge(features_->point(b, lane).edge);
      const double reach = edge_reach + edge.half_length + kSeam + kPlaceError;
      // neither the surface nor an edge is nearer to the edge's part
      const Vec3 place = R_VF_ * features_->place(b, lane) + p_VF_;
      ++results.compared;
      const double gap = std::max<double>(
          bounds[lane] - reach, other_->EdgesBeyond(place) - reach - other_->longest_half());
      if (gap > kEdgesEnough) {
        least = std::min(least, gap);
      } else {
        parts[count++] = {.lane = lane,
                          .middle_V = place,
                          .tangent_V = R_VF_ * edge.tangent.cast<double>(),
                          .half_length = edge.half_length,
                          .middle_bound = bounds[lane],
                          .gap = gap};
      }
    }
    const std::span<EdgePart> near = std::span(parts).first(count);
    results.compared +=
        static_cast<std::uint32_t>(QueryAlong(*field_, edge_reach, near) +
                                   QueryOtherEdges(*other_, edge_reach, kCrossingMargin, near));
    const bool any = std::ranges::any_of(near, [](const EdgePart& part) {
      return part.gap < 0;
    });
    const double crossing_below = any ? kCrossingMargin : 0.0;
    for (const EdgePart& part : near) {
      if (part.gap < crossing_below) {
        results.crossing = static_cast<std::uint16_t>(results.crossing | 1U << part.lane);
      } else {
        least = std::min(least, part.gap);
      }
    }
  }
  // lanes that may cross do not stay so for long; not all blocks are looked at again in one frame
  if (results.crossing != 0) least = std::min(least, kCrossingMargin * ShareOfMargin(b));
  due.crossing = results.crossing;
  due.compared = results.compared;
  due.ring = static_cast<std::uint32_t>(
      calendar_.RingOf(results.out + block.radius, std::max(least, 0.0)));
  due.at = calendar_.odometer(due.ring) + least;
  results.gap = std::min(results.gap, due.crossing != 0 ? 0 : static_cast<float>(least));
}

void FieldSchedule::PutDue() noexcept {
  near_count_ = 0;
  edges_ahead_ = 0;
  for (std::size_t k = 0; k < due_count_; ++k) {
    const std::uint32_t b = due_[k];
    const BlockResults& results = results_[k];
    const BodyFeatures::Block& block = features_->blocks()[b];
    const int looked_up = results.points ? 1 + std::popcount(block.lanes) : 1;
    counts_.looked_up += static_cast<std::size_t>(looked_up);
    counts_.compared += results.compared;
    if (results.touching != 0 || results.crossing != 0) {
      near_[near_count_++] = {b, results.touching, results.crossing, results.nearer, results.count};
    }
    const bool far = results.gap > kFar;
    std::uint32_t& far_in = far_in_[block.chunk];
    far_in += (far ? 1U : 0U) - is_far_[b];
    is_far_[b] = far ? 1 : 0;
    calendar_.Put(b, results.out + block.radius, results.gap,
                  static_cast<std::uint32_t>(looked_up) + EdgeCost(b, results));
  }
  // chunks whose blocks are all far stand whole from here on
  for (std::size_t k = 0; k < due_count_; ++k) {
    const std::uint32_t number = features_->blocks()[due_[k]].chunk;
    if (k + 1 < due_count_ && features_->blocks()[due_[k + 1]].chunk == number) continue;
    const BodyFeatures::Chunk& chunk = features_->chunks()[number];
    if (far_in_[number] < chunk.count || !PutIfFar(number)) continue;
    for (std::uint32_t b = chunk.first; b < chunk.first + chunk.count; ++b) calendar_.Remove(b);
  }
}

std::uint32_t FieldSchedule::EdgeCost(std::uint32_t block, const BlockResults& results) noexcept {
  if (other_ == nullptr || !results.points || features_->blocks()[block].sharp == 0) return 0;
  const EdgesDue& due = edges_due_[block];
  const double known = due.at - calendar_.odometer(due.ring);
  if (results.crossing == 0) return results.gap >= known ? due.compared : 0;
  if (known <= pace_) return due.compared;
  edges_ahead_ += due.compared;
  return 0;
}

double FieldSchedule::due_tests() const noexcept {
  return static_cast<double>(calendar_.CostWithin(0, motion_) + chunks_.CostWithin(0, motion_));
}

double FieldSchedule::due_tests_per_voxel() const noexcept {
  const auto per_voxel = [this](const auto& calendar) {
    const double buckets = std::ceil(kMostTravel * calendar.kPerVoxel);
    const std::uint64_t more = calendar.CostWithin(static_cast<std::size_t>(buckets), motion_) -
                               calendar.CostWithin(0, motion_);
    return static_cast<double>(more) * calendar.kPerVoxel / buckets;
  };
  return per_voxel(calendar_) + per_voxel(chunks_) + edges_ahead_ / kMostTravel;
}

std::size_t FieldSchedule::CountUnfound(const Pose& X_VF) const {
  std::vector<std::uint16_t> found(is_far_.size());
  for (const NearBlock& near : near()) found[near.block] = near.touching;
  // the vectors' readings may be off by the field's error, and by single precision
  const double surely = reach_ - field_->error_bound() - kPlaceError;
  std::size_t unfound = 0;
  for (std::size_t b = 0; b < found.size(); ++b) {
    const unsigned own = features_->blocks()[b].lanes;
    for (unsigned rest = own & ~unsigned{found[b]}; rest != 0; rest &= rest - 1) {
      const auto lane = static_cast<std::size_t>(std::countr_zero(rest));
      if (field_->At(X_VF * features_->place(b, lane)).value < surely) ++unfound;
    }
  }
  return unfound;
}

double FieldSchedule::Read(const Pose& X_VF, double reach, double inner) noexcept {
  Place(X_VF);
  reach_ = reach;
  inner_ = inner;
  counts_ = {};
  std::fill(edges_due_.begin(), edges_due_.end(), EdgesDue{});
  for (std::uint32_t b = 0; b < is_far_.size(); ++b) AddDue(b);
  middle_enough_ = std::numeric_limits<double>::infinity();  // every point counts
  TestAll();
  middle_enough_ = kMiddleEnough;
  PutDue();
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < due_count_; ++k) least = std::min<double>(least, results_[k].gap);
  return least + reach_;
}

}  // namespace tandem
