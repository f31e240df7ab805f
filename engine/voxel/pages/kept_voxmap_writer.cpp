#include <algorithm>
#include <cstring>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <tbb/parallel_for.h>
#include <zstd.h>

#include "engine/base/check.h"
#include "engine/base/files/whole_file.h"
#include "engine/voxel/build/voxmap_builder.h"
#include "engine/voxel/pages/kept_voxmap.h"
#include "engine/voxel/pages/kept_voxmap_format.h"

namespace tandem {

using namespace kept_voxmap;

namespace {

constexpr int kLevel =
    1;  // level of compression: a higher one saves a tenth and takes five times as long
constexpr std::size_t kWrittenAtOnce = 256;  // pages, so that few are in memory twice

template <typename T>
std::span<const std::byte> BytesOf(const std::vector<T>& values) {
  return std::as_bytes(std::span(values));
}

std::string Compressed(std::span<const std::byte> bytes) {
  std::string out(ZSTD_compressBound(bytes.size()), '\0');
  const std::size_t size =
      ZSTD_compress(out.data(), out.size(), bytes.data(), bytes.size(), kLevel);
  TANDEM_CHECK(ZSTD_isError(size) == 0U);
  out.resize(size);
  return out;
}

/// A page as written.
struct WrittenPage {
  PageEntry entry;  // numbers of planes and quarters are those of the part of the map
  std::string bytes;
};

std::uint32_t PlanesOf(const VoxmapRecord& record) {
  std::uint32_t planes = 0;
  for (const auto& slices : record.slices) {
    for (const VoxmapSlice& slice : slices) planes += CountBits(slice.stored);
  }
  return planes;
}

/// Begins a page: everything but its bytes. `next_quarter`: the first quarter that no page before
/// has.
PageEntry EntryOf(const Voxmap& voxmap, std::uint32_t record, std::uint32_t next_quarter) {
  PageEntry entry;
  entry.record = record;
  entry.plane_count = PlanesOf(voxmap.records()[record]);
  entry.first_plane = voxmap.records()[record].slices[0][0].first_plane;
  entry.first_quarter = next_quarter;
  std::uint32_t end = next_quarter;
  for (std::uint32_t p = entry.first_plane; p < entry.first_plane + entry.plane_count; ++p) {
    for (const std::uint32_t quarter : voxmap.planes()[p].quarters) {
      end = std::max(end, quarter + 1);
    }
  }
  entry.new_quarters = end - next_quarter;
  return entry;
}

/// Fills a page. `quarter_base`: offset from a quarter's number to that in the whole map.
void FillPage(const Voxmap& voxmap, std::uint32_t quarter_base, WrittenPage& page) {
  PageEntry& entry = page.entry;
  const std::size_t quarter_bytes = voxmap.quarter_bytes();
  std::vector<std::uint32_t> known;
  const std::span planes(voxmap.planes() + entry.first_plane, entry.plane_count);
  for (const VoxmapPlane& plane : planes) {
    for (const std::uint32_t quarter : plane.quarters) {
      if (quarter > kQuarterInterior && quarter < entry.first_quarter) known.push_back(quarter);
    }
  }
  std::sort(known.begin(), known.end());
  known.erase(std::unique(known.begin(), known.end()), known.end());
  entry.known_quarters = static_cast<std::uint32_t>(known.size());

  const FirstPiece piece(entry, quarter_bytes);
  std::vector<std::byte> first(piece.bytes());
  std::size_t at = 0;
  for (const auto& slices : voxmap.records()[entry.record].slices) {
    for (const VoxmapSlice& slice : slices) {
      std::memcpy(&first[at], &slice.stored, sizeof slice.stored);
      at += sizeof slice.stored;
    }
  }
  for (const VoxmapPlane& plane : planes) {
    for (const std::uint32_t quarter : plane.quarters) {
      std::size_t number = quarter;
      if (quarter >= entry.first_quarter) {
        number = 2 + known.size() + (quarter - entry.first_quarter);
      } else if (quarter > kQuarterInterior) {
        number = 2 + static_cast<std::size_t>(
                         std::lower_bound(known.begin(), known.end(), quarter) - known.begin());
      }
      const auto narrow = static_cast<std::uint16_t>(number);
      std::memcpy(&first[at], &narrow, sizeof narrow);
      at += sizeof narrow;
    }
  }
  for (std::size_t k = 0; k < known.size(); ++k) {
    const std::uint32_t number = known[k] + quarter_base;
    std::memcpy(&first[piece.numbers() + k * sizeof number], &number, sizeof number);
  }
  if (entry.new_quarters > 0) {
    std::memcpy(&first[piece.quarters()],
                voxmap.quarters() + std::size_t{entry.first_quarter} * quarter_bytes,
                std::size_t{entry.new_quarters} * quarter_bytes);
  }
  std::vector<std::byte> second(known.size() * quarter_bytes);
  for (std::size_t k = 0; k < known.size(); ++k) {
    std::memcpy(&second[k * quarter_bytes],
                voxmap.quarters() + std::size_t{known[k]} * quarter_bytes, quarter_bytes);
  }
  page.bytes = Compressed(first);
  entry.first_bytes = static_cast<std::uint32_t>(page.bytes.size());
  if (!known.empty()) page.bytes += Compressed(second);
  entry.known_bytes = static_cast<std::uint32_t>(page.bytes.size()) - entry.first_bytes;
  entry.checksum = HashOfMany(std::as_bytes(std::span(page.bytes)));
}

/// Returns the records that have planes, in the order of these.
std::vector<std::uint32_t> RecordsWithPlanes(const Voxmap& voxmap) {
  std::vector<std::uint32_t> records;
  for (std::uint32_t r = 2; r < voxmap.header().record_count; ++r) {
    if (PlanesOf(voxmap.records()[r]) > 0) records.push_back(r);
  }
  std::sort(records.begin(), records.end(), [&](std::uint32_t a, std::uint32_t b) {
    return voxmap.records()[a].slices[0][0].first_plane <
           voxmap.records()[b].slices[0][0].first_plane;
  });
  return records;
}

/// Writes a file part by part.
class KeptVoxmapWriter {
 public:
  static Result<KeptVoxmapWriter> Create(const std::filesystem::path& file) {
    Result<WholeFile> out = WholeFile::Create(file);
    if (!out) return out.error();
    return KeptVoxmapWriter(std::move(*out));
  }

  /// Adds a part. All parts have the same box, and no hyperchunk has marks in two of them.
  std::optional<Error> Add(const Voxmap& part) {
    const std::vector<std::uint32_t> records = RecordsWithPlanes(part);
    std::vector<std::uint32_t> cell_of(part.header().record_count);
    const auto& size = part.header().size;
    for (std::uint32_t c = 0; c < size[0] * size[1] * size[2]; ++c) cell_of[part.index()[c]] = c;
    std::uint32_t next_quarter = 2;
    std::vector<WrittenPage> pages;
    for (std::size_t begin = 0; begin < records.size(); begin += kWrittenAtOnce) {
      pages.assign(std::min(kWrittenAtOnce, records.size() - begin), {});
      for (std::size_t k = 0; k < pages.size(); ++k) {
        pages[k].entry = EntryOf(part, records[begin + k], next_quarter);
        next_quarter += pages[k].entry.new_quarters;
      }
      tbb::parallel_for(std::size_t{0}, pages.size(), [&](std::size_t k) {
        FillPage(part, quarters_ - 2, pages[k]);
      });
      for (WrittenPage& page : pages) {
        PageEntry& entry = page.entry;
        entry.offset = out_.written();
        entry.first_plane += planes_ - 2;
        entry.first_quarter += quarters_ - 2;
        entries_.push_back(entry);
        cells_.push_back(cell_of[entry.record]);
        if (!out_.Write(page.bytes)) return out_.Commit();
      }
    }
    planes_ += static_cast<std::uint32_t>(part.header().plane_count - 2);
    quarters_ += static_cast<std::uint32_t>(part.header().quarter_count - 2);
    AddOutline(part);
    only_ = parts_++ == 0 ? part : Voxmap();
    return std::nullopt;
  }

  std::optional<Error> Finish(const BlockFileSources& made_of) {
    const Voxmap outline = only_.empty() ? OutlineOfParts() : only_;
    for (std::size_t e = 0; e < entries_.size(); ++e) {
      entries_[e].record = outline.index()[cells_[e]];
    }

    Tail tail{.map = outline.header(), .made_of = made_of};
    tail.map.plane_count = planes_;
    tail.map.quarter_count = quarters_;
    const std::uint64_t quarter_bytes = kVoxelsPerQuarter / 8 * tail.map.bits;
    tail.map.planes_offset = tail.map.quarters_offset + quarters_ * quarter_bytes;
    tail.map.bytes = tail.map.planes_offset + planes_ * sizeof(VoxmapPlane);
    tail.magic = kMagic;
    tail.version = kKeptVoxmapVersion;
    tail.pages = entries_.size();
    tail.surface_voxels = counts_.surface;
    tail.interior_voxels = counts_.interior;
    tail.free_voxels = counts_.free;
    const auto& size = tail.map.size;
    const std::span index(outline.index(), std::size_t{size[0]} * size[1] * size[2]);
    std::vector<RecordOutline> outlines(tail.map.record_count);
    for (std::size_t r = 0; r < outlines.size(); ++r) {
      outlines[r] = {outline.records()[r].solid, outline.records()[r].chunk_marks};
    }
    std::string bytes = Compressed(std::as_bytes(index));
    tail.index_bytes = bytes.size();
    bytes += Compressed(BytesOf(entries_));
    tail.entries_bytes = bytes.size() - tail.index_bytes;
    bytes += Compressed(BytesOf(outlines));
    tail.records_bytes = bytes.size() - tail.index_bytes - tail.entries_bytes;
    tail.outline_offset = out_.written();
    tail.outline_checksum = HashOfMany(std::as_bytes(std::span(bytes)));
    tail.checksum = ChecksumOf(tail);
    if (out_.Write(bytes)) out_.Write({reinterpret_cast<const char*>(&tail), sizeof tail});
    return out_.Commit();
  }

 private:
  explicit KeptVoxmapWriter(WholeFile out) : out_(std::move(out)) {}

  /// Returns the map's index, what is solid and the chunk-level field.
  Voxmap OutlineOfParts() {
    const GridIndex size{static_cast<std::int32_t>(map_.size[0]),
                         static_cast<std::int32_t>(map_.size[1]),
                         static_cast<std::int32_t>(map_.size[2])};
    const HyperchunkBox box{GridIndex{map_.origin[0], map_.origin[1], map_.origin[2]} >> 6, size};
    VoxmapBuilder builder(map_.voxel_size, static_cast<int>(map_.range),
                          static_cast<int>(map_.bits), box, kinds_);
    for (const auto& [cell, record] : records_) builder.Add(box.PlaceOf(cell), record, {});
    records_ = {};
    return builder.Finish(counts_.band);
  }

  void AddOutline(const Voxmap& part) {
    map_ = part.header();
    const auto& size = map_.size;
    const std::size_t cells = std::size_t{size[0]} * size[1] * size[2];
    kinds_.resize(cells, VoxmapBuilder::Kind::kFar);
    for (std::size_t c = 0; c < cells; ++c) {
      const std::uint32_t number = part.index()[c];
      const VoxmapRecord& record = part.records()[number];
      const bool marked = PlanesOf(record) > 0 || record.solid != decltype(record.solid){};
      if (number == kRecordSolid) {
        kinds_[c] = VoxmapBuilder::Kind::kSolid;
      } else if (marked) {
        kinds_[c] = VoxmapBuilder::Kind::kMarked;
        records_.emplace_back(c, record);
        records_.back().second.chunk_marks = {};
      }
    }
    const VoxelCounts counts = part.Count();
    counts_.interior += counts.interior;
    counts_.surface += counts.surface;
    counts_.free += counts.free;
    counts_.band += counts.band;
  }

  WholeFile out_;
  VoxmapHeader map_;
  int parts_ = 0;
  Voxmap only_;  // the part, while there is only one
  std::uint32_t planes_ = 2;
  std::uint32_t quarters_ = 2;
  std::vector<PageEntry> entries_;
  std::vector<std::uint32_t> cells_;  // cells of the entries
  std::vector<VoxmapBuilder::Kind> kinds_;
  std::vector<std::pair<std::size_t, VoxmapRecord>> records_;  // records of the parts, by cell
  VoxelCounts counts_;
};

}  // namespace

std::optional<Error> KeepVoxmap(const TriangleMesh& mesh_W, const VoxelizeOptions& options,
                                const std::filesystem::path& file) {
  Result<KeptVoxmapWriter> writer = KeptVoxmapWriter::Create(file);
  if (!writer) return writer.error();
  auto fault = VoxelizeInParts(mesh_W, options, [&](const Voxmap& part) {
    return writer->Add(part);
  });
  if (fault) return fault;
  return writer->Finish(KeyOf(mesh_W, options));
}

std::optional<Error> KeepVoxmap(const Voxmap& voxmap, const BlockFileSources& made_of,
                                const std::filesystem::path& file) {
  if (voxmap.empty()) return Error{file.string() + ": there is no map to save"};
  Result<KeptVoxmapWriter> writer = KeptVoxmapWriter::Create(file);
  if (!writer) return writer.error();
  if (auto fault = writer->Add(voxmap)) return fault;
  return writer->Finish(made_of);
}

}  // namespace tandem
