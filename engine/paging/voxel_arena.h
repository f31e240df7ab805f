#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "engine/base/files/image_bytes.h"
#include "engine/voxel/map/page_source.h"
#include "engine/voxel/map/voxmap.h"

namespace tandem {

/// The image of a voxmap with room for some of its pages. The outline is always in memory. Planes
/// and quarters lie in frames of 4 KB, each of which holds planes or quarters of one page. The
/// constructor touches all memory, and locks it if that is allowed.
///
///   header | index | records | frame 0: what every map has | frame 1 | frame 2 | ...
class VoxelArena {
 public:
  static constexpr std::size_t kFrameBytes = 4096;

  /// `frames`: the number of frames that pages share.
  VoxelArena(const Voxmap& outline, std::size_t frames);
  /// Returns the bytes without frames.
  static std::uint64_t FixedBytes(const Voxmap& outline);

  const Voxmap& voxmap() const noexcept { return voxmap_; }
  std::size_t frames() const noexcept { return frames_; }
  std::size_t free_frames() const noexcept { return free_.size(); }
  std::uint64_t bytes() const noexcept { return image_->size(); }
  /// Tells whether the memory is locked.
  bool locked() const noexcept { return locked_; }

  /// Puts a page to its place; false: there are too few frames. No thread may read the record's
  /// marks meanwhile.
  bool Put(std::uint32_t record, const VoxelPage& page);
  /// Gives up a page's frames. No thread may read the record's marks any more.
  void Remove(std::uint32_t record);

 private:
  VoxmapRecord& RecordOf(std::uint32_t record) const;

  std::shared_ptr<ImageBytes> image_;
  Voxmap voxmap_;
  std::byte* arena_ = nullptr;
  std::size_t quarter_bytes_;
  std::size_t frames_;
  bool locked_ = false;
  std::vector<std::uint32_t> free_;
  std::vector<std::vector<std::uint32_t>> frames_of_;  // per record
};

}  // namespace tandem
