#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <stop_token>
#include <vector>

#include "engine/base/result.h"
#include "engine/voxel/map/voxmap.h"

namespace tandem {

/// The marks of one hyperchunk alone: the unit that comes into memory and leaves it (paper §5.3).
struct VoxelPage {
  /// Per field and z: the chunks with a plane, as in VoxmapSlice. Their planes follow one another.
  std::array<std::array<std::uint64_t, 8>, kFields> stored{};
  /// Numbers of quarters: kQuarterBeyond, kQuarterInterior, then those of `quarters`.
  std::vector<std::array<std::uint16_t, kQuarters>> planes;
  std::vector<std::uint8_t> quarters;  // all different, in no order
};

/// A source of the marks of a voxmap that is not in memory as a whole: a file, or a computation.
/// Any number of threads may read at once.
class PageSource {
 public:
  virtual ~PageSource() = default;
  PageSource(const PageSource&) = delete;
  PageSource& operator=(const PageSource&) = delete;

  /// Returns the map without its planes: its index, the chunk-level field, by which chunks are
  /// tested while they are far (paper §5.1), and what is solid. A chunk with a plane reads as a
  /// chunk without one.
  const Voxmap& outline() const noexcept { return outline_; }
  /// Returns the counts of what the whole map stores. For computed pages, planes, quarters and
  /// bytes count as if all quarters differed.
  const VoxelCounts& counts() const noexcept { return counts_; }
  /// Tells whether a record has a page; the outline has all of any other record.
  virtual bool HasPage(std::uint32_t record) const noexcept = 0;
  /// Returns the bytes that reading a page takes from storage.
  virtual std::uint64_t BytesOf(std::uint32_t record) const noexcept = 0;
  /// Reads a record's page; returns an error if it cannot. When it is asked to stop, a slow source
  /// soon ends with an error.
  virtual std::optional<Error> Read(std::uint32_t record, VoxelPage& page,
                                    const std::stop_token& stop = {}) const = 0;

 protected:
  PageSource() = default;
  Voxmap outline_;
  VoxelCounts counts_;
};

}  // namespace tandem
