#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <stop_token>
#include <vector>

#include "engine/base/result.h"
#include "engine/voxel/voxmap.h"

namespace tandem {

/// The marks of one hyperchunk by themselves: what is brought into memory, and given up again, as
/// one (paper §5.3).
struct VoxelPage {
  /// By field and z: the chunks with a plane, as in VoxmapSlice. Their planes follow one another.
  std::array<std::array<std::uint64_t, 8>, kFields> stored{};
  /// Numbers of quarters: kQuarterBeyond, kQuarterInterior, then those of `quarters`.
  std::vector<std::array<std::uint16_t, kQuarters>> planes;
  std::vector<std::uint8_t> quarters;  // no two alike, in no order
};

/// Where the marks of a voxmap come from that is not in memory as a whole: a file, or what computes
/// them. Any number of threads may read at once.
class PageSource {
 public:
  virtual ~PageSource() = default;
  PageSource(const PageSource&) = delete;
  PageSource& operator=(const PageSource&) = delete;

  /// The map without its planes: its index, the chunk-level field and what is solid, which chunks
  /// are tested by as long as they are far (paper §5.1). A chunk with a plane reads as one without.
  const Voxmap& outline() const noexcept { return outline_; }
  /// Counts what the whole map stores; of computed pages, planes, quarters and bytes as if no two
  /// quarters were alike.
  const VoxelCounts& counts() const noexcept { return counts_; }
  /// Tells whether a record has a page; the others are whole in the outline.
  virtual bool HasPage(std::uint32_t record) const noexcept = 0;
  /// What reading a page takes from where it is kept, bytes.
  virtual std::uint64_t BytesOf(std::uint32_t record) const noexcept = 0;
  /// Gives a record's page, or why it cannot be had. Asked to stop, a source that takes long soon
  /// ends with an error.
  virtual std::optional<Error> Read(std::uint32_t record, VoxelPage& page,
                                    const std::stop_token& stop = {}) const = 0;

 protected:
  PageSource() = default;
  Voxmap outline_;
  VoxelCounts counts_;
};

}  // namespace tandem
