#include "engine/paging/voxel_arena.h"

#include <cstring>
#include <utility>

#include <sys/mman.h>

#include "engine/base/bits.h"
#include "engine/base/check.h"

namespace tandem {

namespace {

constexpr std::size_t kPlanesPerFrame = VoxelArena::kFrameBytes / sizeof(VoxmapPlane);
static_assert(kPlanesPerFrame >= 64);  // a slice's planes lie in one frame

std::uint64_t RecordsEnd(const Voxmap& outline) {
  const VoxmapHeader& h = outline.header();
  return h.records_offset + h.record_count * sizeof(VoxmapRecord);
}

std::uint64_t ArenaOffset(const Voxmap& outline) {
  constexpr std::uint64_t kFrame = VoxelArena::kFrameBytes;
  return (RecordsEnd(outline) + kFrame - 1) / kFrame * kFrame;
}

/// Returns the number of frames for slices, whose planes must not lie in two frames.
std::size_t PlaneFrames(const VoxelPage& page) {
  std::size_t frames = 0;
  std::size_t left = 0;
  for (const auto& layers : page.stored) {
    for (const std::uint64_t layer : layers) {
      const std::size_t planes = CountBits(layer);
      if (planes > left) {
        ++frames;
        left = kPlanesPerFrame;
      }
      left -= planes;
    }
  }
  return frames;
}

}  // namespace

std::uint64_t VoxelArena::FixedBytes(const Voxmap& outline) {
  return ArenaOffset(outline) + kFrameBytes;
}

VoxelArena::VoxelArena(const Voxmap& outline, std::size_t frames)
    : image_(std::make_shared<ImageBytes>(FixedBytes(outline) + frames * kFrameBytes)),
      quarter_bytes_(outline.quarter_bytes()),
      frames_(frames),
      frames_of_(outline.header().record_count) {
  TANDEM_CHECK(frames < (std::size_t{1} << 31U) / kPlanesPerFrame);
  std::memset(image_->data(), 0, image_->size());
  VoxmapHeader h = outline.header();
  h.quarters_offset = ArenaOffset(outline);
  h.planes_offset = h.quarters_offset + 2 * quarter_bytes_;
  h.quarter_count = (frames + 1) * kFrameBytes / quarter_bytes_;
  h.plane_count = ((frames + 1) * kFrameBytes - 2 * quarter_bytes_) / sizeof(VoxmapPlane);
  h.bytes = image_->size();
  std::memcpy(image_->data(), &h, sizeof h);
  const auto* from = reinterpret_cast<const std::byte*>(&outline.header());
  std::memcpy(image_->data() + h.index_offset, from + h.index_offset,
              RecordsEnd(outline) - h.index_offset);
  arena_ = image_->data() + h.quarters_offset;
  std::memcpy(arena_, outline.quarters(), 2 * quarter_bytes_);
  std::memcpy(image_->data() + h.planes_offset, outline.planes(), 2 * sizeof(VoxmapPlane));
  locked_ = mlock(image_->data(), image_->size()) == 0;  // succeeds where the limit allows it
  voxmap_ = Voxmap(ImageBlock{image_, {image_->data(), image_->size()}});
  free_.reserve(frames);
  for (std::size_t f = frames; f > 0; --f) free_.push_back(static_cast<std::uint32_t>(f));
}

VoxmapRecord& VoxelArena::RecordOf(std::uint32_t record) const {
  return reinterpret_cast<VoxmapRecord*>(image_->data() + voxmap_.header().records_offset)[record];
}

bool VoxelArena::Put(std::uint32_t record, const VoxelPage& page) {
  TANDEM_CHECK(frames_of_[record].empty());
  const std::size_t per_frame = kFrameBytes / quarter_bytes_;
  const std::size_t quarters = page.quarters.size() / quarter_bytes_;
  const std::size_t quarter_frames = (quarters + per_frame - 1) / per_frame;
  const std::size_t needed = quarter_frames + PlaneFrames(page);
  if (needed > free_.size()) return false;
  std::vector<std::uint32_t>& frames = frames_of_[record];
  frames.assign(free_.end() - static_cast<std::ptrdiff_t>(needed), free_.end());
  free_.resize(free_.size() - needed);

  std::vector<std::uint32_t> numbers(2 + quarters);
  numbers[kQuarterInterior] = kQuarterInterior;
  for (std::size_t q = 0; q < quarters; ++q) {
    const std::size_t frame = frames[q / per_frame];
    numbers[2 + q] = static_cast<std::uint32_t>(frame * per_frame + q % per_frame);
  }
  for (std::size_t f = 0; f < quarter_frames; ++f) {
    const std::size_t at = f * per_frame * quarter_bytes_;
    std::memcpy(arena_ + std::size_t{frames[f]} * kFrameBytes, &page.quarters[at],
                std::min(per_frame * quarter_bytes_, page.quarters.size() - at));
  }

  std::size_t frame = quarter_frames;
  std::size_t used = kPlanesPerFrame;  // planes in the last frame
  std::size_t next = 0;                // plane of the page
  VoxmapRecord& out = RecordOf(record);
  for (std::size_t field = 0; field < kFields; ++field) {
    for (std::size_t z = 0; z < 8; ++z) {
      const std::uint64_t stored = page.stored[field][z];
      const std::size_t planes = CountBits(stored);
      if (used + planes > kPlanesPerFrame) {
        ++frame;
        used = 0;
      }
      if (planes == 0) {
        out.slices[field][z] = {};
        continue;
      }
      const std::size_t at =
          std::size_t{frames[frame - 1]} * kFrameBytes + used * sizeof(VoxmapPlane);
      auto* to = reinterpret_cast<VoxmapPlane*>(arena_ + at);
      for (std::size_t p = 0; p < planes; ++p, ++next) {
        for (std::size_t q = 0; q < kQuarters; ++q)
          to[p].quarters[q] = numbers[page.planes[next][q]];
      }
      const std::size_t number = (at - 2 * quarter_bytes_) / sizeof(VoxmapPlane);
      out.slices[field][z] = {stored, static_cast<std::uint32_t>(number), 0};
      used += planes;
    }
  }
  return true;
}

void VoxelArena::Remove(std::uint32_t record) {
  std::vector<std::uint32_t>& frames = frames_of_[record];
  free_.insert(free_.end(), frames.begin(), frames.end());
  frames = {};
  RecordOf(record).slices = {};
}

}  // namespace tandem
