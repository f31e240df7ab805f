#include "engine/voxel/kept_voxmap.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include <tbb/parallel_for.h>
#include <zstd.h>

#include "engine/base/hash.h"
#include "engine/base/regular_file.h"
#include "engine/base/whole_file.h"
#include "engine/geometry/mesh_hash.h"
#include "engine/voxel/voxmap_builder.h"

namespace tandem {

namespace {

constexpr int kLevel =
    1;  // of compression: a higher one saves a tenth and takes five times as long
constexpr std::size_t kWrittenAtOnce = 256;  // pages, so that few are in memory twice
constexpr std::array<char, 8> kMagic{'t', 'a', 'n', 'd', 'e', 'm', 'K', 'V'};

/// Where a record's page is, and which planes and quarters of the whole map are its own.
struct PageEntry {
  std::uint64_t offset = 0;  // in the file
  std::uint64_t checksum = 0;
  std::uint32_t record = 0;
  std::uint32_t first_bytes = 0;  // of the first piece, compressed
  std::uint32_t known_bytes = 0;  // of the second one
  std::uint32_t first_plane = 0;
  std::uint32_t plane_count = 0;
  std::uint32_t first_quarter = 0;  // of those that are new
  std::uint32_t new_quarters = 0;
  std::uint32_t known_quarters = 0;  // of pages before it
};
static_assert(sizeof(PageEntry) == 48);

/// What the outline keeps of a record.
struct RecordOutline {
  std::array<std::uint64_t, 8> solid{};
  std::array<std::uint8_t, kChunksPerHyperchunk / 2> chunk_marks{};
};
static_assert(sizeof(RecordOutline) == 320);

struct Tail {
  VoxmapHeader map;  // of the whole map
  std::array<char, 8> magic{};
  std::uint32_t version = 0;
  std::uint32_t unused = 0;
  MadeOf made_of;
  std::uint64_t pages = 0;  // how many
  std::uint64_t outline_offset = 0;
  std::uint64_t index_bytes = 0;     // compressed; the entries follow it, then the records
  std::uint64_t entries_bytes = 0;   // compressed
  std::uint64_t records_bytes = 0;   // compressed
  std::uint64_t surface_voxels = 0;  // VoxelCounts
  std::uint64_t interior_voxels = 0;
  std::uint64_t free_voxels = 0;
  std::uint64_t outline_checksum = 0;
  std::uint64_t checksum = 0;  // of all of the tail before it
};
static_assert(sizeof(Tail) == 240);

Error Damaged(const std::string& file) {
  return Error{file + ": a damaged voxmap of a cache; voxelize its mesh again"};
}

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

/// False: these are not the bytes that were compressed.
bool Decompress(std::span<const std::byte> from, std::span<std::byte> to) {
  return ZSTD_decompress(to.data(), to.size(), from.data(), from.size()) == to.size();
}

std::uint64_t ChecksumOf(const Tail& tail) {
  Hash64 hash;
  hash.AddBytes(&tail, offsetof(Tail, checksum));
  return hash.value();
}

/// A page as written.
struct WrittenPage {
  PageEntry entry;  // planes and quarters as the part of the map numbers them
  std::string bytes;
};

std::uint32_t PlanesOf(const VoxmapRecord& record) {
  std::uint32_t planes = 0;
  for (const auto& slices : record.slices) {
    for (const VoxmapSlice& slice : slices) planes += CountBits(slice.stored);
  }
  return planes;
}

/// The first piece of a page, before it is compressed: stored chunks; planes, by numbers of its
/// own; the numbers of known quarters in the whole map; new quarters.
class FirstPiece {
 public:
  FirstPiece(const PageEntry& entry, std::size_t quarter_bytes)
      : planes_(kFields * 8 * sizeof(std::uint64_t)),
        numbers_(planes_ + entry.plane_count * sizeof(VoxelPage::planes[0])),
        quarters_(numbers_ + entry.known_quarters * sizeof(std::uint32_t)),
        bytes_(quarters_ + entry.new_quarters * quarter_bytes) {}
  std::size_t planes() const noexcept { return planes_; }
  std::size_t numbers() const noexcept { return numbers_; }
  std::size_t quarters() const noexcept { return quarters_; }
  std::size_t bytes() const noexcept { return bytes_; }

 private:
  std::size_t planes_;
  std::size_t numbers_;
  std::size_t quarters_;
  std::size_t bytes_;
};

/// Begins a page: everything but its bytes. `next_quarter`: the first that no page before has.
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

/// `quarter_base`: what is added to a quarter's number for that in the whole map.
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

/// The records that have planes, in the order of these.
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

/// A file whose tail and outline are sound, open.
struct OpenFile {
  RegularFile file;
  Tail tail;
  std::vector<std::uint32_t> index;
  std::vector<PageEntry> entries;
  std::vector<RecordOutline> records;
};

bool IsSound(const VoxmapHeader& h) {
  constexpr std::uint64_t kMost = std::uint64_t{1} << 32U;  // so that no product overflows
  if ((h.bits != 2 && h.bits != 4 && h.bits != 8) || h.range < 1 ||
      h.range > static_cast<unsigned>(WidestRange(static_cast<int>(h.bits))) ||
      !(h.voxel_size > 0) || !std::isfinite(h.voxel_size)) {
    return false;
  }
  for (const std::uint32_t size : h.size) {
    if (size == 0 || size > (1U << 20U)) return false;
  }
  const std::uint64_t cells = std::uint64_t{h.size[0]} * h.size[1] * h.size[2];
  const std::uint64_t quarter_bytes = kVoxelsPerQuarter / 8 * h.bits;
  if (h.record_count > cells + 2 || h.record_count < 2 || h.plane_count < 2 ||
      h.quarter_count < 2 || h.record_count > kMost || h.plane_count > kMost ||
      h.quarter_count > kMost || cells > kMost) {
    return false;
  }
  ArrayPlaces places(sizeof(VoxmapHeader));
  return h.index_offset == places.Add(cells, sizeof(std::uint32_t)) &&
         h.records_offset == places.Add(h.record_count, sizeof(VoxmapRecord)) &&
         h.quarters_offset == places.Add(h.quarter_count, quarter_bytes) &&
         h.planes_offset == h.quarters_offset + h.quarter_count * quarter_bytes &&
         h.bytes == h.planes_offset + h.plane_count * sizeof(VoxmapPlane);
}

bool IsSound(const Tail& tail, const std::vector<PageEntry>& entries) {
  std::uint64_t plane = 2;
  std::uint64_t quarter = 2;
  std::vector<bool> seen(tail.map.record_count);
  for (const PageEntry& entry : entries) {
    if (entry.record < 2 || entry.record >= tail.map.record_count || seen[entry.record] ||
        entry.first_plane != plane || entry.first_quarter != quarter ||
        entry.plane_count > kFields * kChunksPerHyperchunk ||
        entry.new_quarters > kQuarters * entry.plane_count ||
        entry.known_quarters > kQuarters * entry.plane_count ||
        entry.offset > tail.outline_offset ||
        std::uint64_t{entry.first_bytes} + entry.known_bytes > tail.outline_offset - entry.offset) {
      return false;
    }
    seen[entry.record] = true;
    plane += entry.plane_count;
    quarter += entry.new_quarters;
  }
  return plane == tail.map.plane_count && quarter == tail.map.quarter_count;
}

bool ReadAt(const RegularFile& file, std::uint64_t at, std::span<std::byte> bytes) {
  return file.Read(at, {reinterpret_cast<char*>(bytes.data()), bytes.size()}) == bytes.size();
}

Result<OpenFile> Open(const std::filesystem::path& path) {
  const std::string name = path.string();
  Result<RegularFile> file = RegularFile::Open(path);
  if (!file) return file.error();
  OpenFile open{std::move(*file), {}, {}, {}, {}};
  Tail& tail = open.tail;
  if (open.file.size() < sizeof tail) return Error{name + ": too short for a voxmap of a cache"};
  const std::uint64_t end = open.file.size() - sizeof tail;
  if (!ReadAt(open.file, end, std::as_writable_bytes(std::span(&tail, 1)))) return Damaged(name);
  if (tail.magic != kMagic) return Error{name + ": not a voxmap of a cache, or cut short"};
  if (tail.version != kKeptVoxmapVersion) {
    return Error{name + ": a voxmap of a cache of version " + std::to_string(tail.version) +
                 ", not " + std::to_string(kKeptVoxmapVersion) + "; voxelize its mesh again"};
  }
  constexpr std::uint64_t kMost = std::uint64_t{1} << 40U;
  const bool fits =
      tail.index_bytes < kMost && tail.entries_bytes < kMost && tail.records_bytes < kMost &&
      tail.outline_offset < kMost &&
      tail.outline_offset + tail.index_bytes + tail.entries_bytes + tail.records_bytes == end;
  if (tail.checksum != ChecksumOf(tail) || !fits || !IsSound(tail.map) ||
      tail.pages > tail.map.record_count) {
    return Damaged(name);
  }
  std::vector<std::byte> outline(end - tail.outline_offset);
  if (!ReadAt(open.file, tail.outline_offset, outline) ||
      HashOfMany(outline) != tail.outline_checksum) {
    return Damaged(name);
  }
  const std::span<const std::byte> bytes(outline);
  const auto& size = tail.map.size;
  const std::uint64_t cells = std::uint64_t{size[0]} * size[1] * size[2];
  const auto unpacks_to = [](std::span<const std::byte> packed, std::uint64_t count,
                             std::uint64_t each) {
    return ZSTD_getFrameContentSize(packed.data(), packed.size()) == count * each;
  };
  if (!unpacks_to(bytes.first(tail.index_bytes), cells, sizeof(std::uint32_t)) ||
      !unpacks_to(bytes.subspan(tail.index_bytes, tail.entries_bytes), tail.pages,
                  sizeof(PageEntry)) ||
      !unpacks_to(bytes.last(tail.records_bytes), tail.map.record_count, sizeof(RecordOutline))) {
    return Damaged(name);
  }
  open.index.resize(cells);
  open.entries.resize(tail.pages);
  open.records.resize(tail.map.record_count);
  if (!Decompress(bytes.first(tail.index_bytes), std::as_writable_bytes(std::span(open.index))) ||
      !Decompress(bytes.subspan(tail.index_bytes, tail.entries_bytes),
                  std::as_writable_bytes(std::span(open.entries))) ||
      !Decompress(bytes.last(tail.records_bytes),
                  std::as_writable_bytes(std::span(open.records))) ||
      !IsSound(tail, open.entries) ||
      std::any_of(open.index.begin(), open.index.end(), [&tail](std::uint32_t record) {
        return record >= tail.map.record_count;
      })) {
    return Damaged(name);
  }
  return open;
}

Result<OpenFile> Open(const std::filesystem::path& path, const MadeOf& made_of) {
  Result<OpenFile> open = Open(path);
  if (open && open->tail.made_of != made_of) {
    return Error{path.string() +
                 ": a voxmap of another mesh, or made with other options; voxelize this one"};
  }
  return open;
}

/// Reads the pieces of pages; one for each thread.
class PageReader {
 public:
  PageReader(const RegularFile& file, const VoxmapHeader& map)
      : file_(&file), quarter_bytes_(kVoxelsPerQuarter / 8 * map.bits) {}

  /// False: it is not what was written. The first piece has all places that FirstPiece says.
  bool Read(const PageEntry& entry) {
    written_.resize(std::size_t{entry.first_bytes} + entry.known_bytes);
    if (!ReadAt(*file_, entry.offset, written_) || HashOfMany(written_) != entry.checksum) {
      return false;
    }
    const FirstPiece piece(entry, quarter_bytes_);
    first_.resize(piece.bytes());
    if (!Decompress(std::span<const std::byte>(written_).first(entry.first_bytes), first_)) {
      return false;
    }
    std::memcpy(&stored_, first_.data(), sizeof stored_);
    std::uint32_t planes = 0;
    for (const auto& layers : stored_) {
      for (const std::uint64_t layer : layers) planes += CountBits(layer);
    }
    if (planes != entry.plane_count) return false;
    numbers_.resize(entry.plane_count);
    if (!numbers_.empty()) {
      std::memcpy(numbers_.data(), &first_[piece.planes()], piece.numbers() - piece.planes());
    }
    const std::size_t quarters = std::size_t{2} + entry.known_quarters + entry.new_quarters;
    for (const auto& plane : numbers_) {
      for (const std::uint16_t number : plane) {
        if (number >= quarters) return false;
      }
    }
    return true;
  }
  /// False, as well. The quarters that pages before have, from `to` on.
  bool ReadKnown(const PageEntry& entry, std::span<std::byte> to) {
    return entry.known_quarters == 0 ||
           Decompress(std::span<const std::byte>(written_).subspan(entry.first_bytes), to);
  }

  std::size_t quarter_bytes() const noexcept { return quarter_bytes_; }
  const std::vector<std::byte>& first() const noexcept { return first_; }
  const auto& stored() const noexcept { return stored_; }
  const auto& numbers() const noexcept { return numbers_; }

 private:
  const RegularFile* file_;
  std::size_t quarter_bytes_;
  std::vector<std::byte> written_;
  std::vector<std::byte> first_;
  decltype(VoxelPage::stored) stored_{};
  decltype(VoxelPage::planes) numbers_;
};

/// Begins an image with all but its planes and quarters.
void WriteOutline(const OpenFile& open, ImageBytes& image) {
  const VoxmapHeader& h = open.tail.map;
  std::memcpy(image.data() + h.index_offset, open.index.data(),
              open.index.size() * sizeof open.index[0]);
  auto* records = reinterpret_cast<VoxmapRecord*>(image.data() + h.records_offset);
  for (std::size_t r = 0; r < open.records.size(); ++r) {
    records[r].solid = open.records[r].solid;
    records[r].chunk_marks = open.records[r].chunk_marks;
  }
}

/// Writes what every map has: quarters and planes without marks, and all inside.
void WriteUniform(const VoxmapHeader& h, ImageBytes& image) {
  const std::size_t quarter_bytes = kVoxelsPerQuarter / 8 * h.bits;
  const int ones = h.bits == 2 ? 0x55 : (h.bits == 4 ? 0x11 : 0x01);
  std::memset(image.data() + h.quarters_offset + kQuarterInterior * quarter_bytes, ones,
              quarter_bytes);
  auto* planes = reinterpret_cast<VoxmapPlane*>(image.data() + h.planes_offset);
  planes[kPlaneInterior].quarters.fill(kQuarterInterior);
}

/// Puts a page that was read where it is in the whole map's image.
bool PlacePage(const PageReader& page, const PageEntry& entry, const VoxmapHeader& h,
               ImageBytes& image) {
  VoxmapRecord& record =
      reinterpret_cast<VoxmapRecord*>(image.data() + h.records_offset)[entry.record];
  std::uint32_t next_plane = entry.first_plane;
  for (std::size_t field = 0; field < kFields; ++field) {
    for (std::size_t z = 0; z < 8; ++z) {
      record.slices[field][z] = {page.stored()[field][z], next_plane, 0};
      next_plane += CountBits(page.stored()[field][z]);
    }
  }
  const FirstPiece piece(entry, page.quarter_bytes());
  std::vector<std::uint32_t> number(std::size_t{2} + entry.known_quarters);
  number[kQuarterInterior] = kQuarterInterior;
  if (entry.known_quarters > 0) {
    std::memcpy(&number[2], &page.first()[piece.numbers()], piece.quarters() - piece.numbers());
  }
  for (std::size_t k = 2; k < number.size(); ++k) {
    if (number[k] >= entry.first_quarter) return false;
  }
  for (std::uint32_t k = 0; k < entry.new_quarters; ++k) number.push_back(entry.first_quarter + k);
  auto* planes = reinterpret_cast<VoxmapPlane*>(image.data() + h.planes_offset);
  for (std::size_t p = 0; p < page.numbers().size(); ++p) {
    for (std::size_t q = 0; q < kQuarters; ++q) {
      planes[entry.first_plane + p].quarters[q] = number[page.numbers()[p][q]];
    }
  }
  if (entry.new_quarters > 0) {
    std::memcpy(image.data() + h.quarters_offset + entry.first_quarter * page.quarter_bytes(),
                &page.first()[piece.quarters()], piece.bytes() - piece.quarters());
  }
  return true;
}

/// Writes a file part by part.
class KeptVoxmapWriter {
 public:
  static Result<KeptVoxmapWriter> Create(const std::filesystem::path& file) {
    Result<WholeFile> out = WholeFile::Create(file);
    if (!out) return out.error();
    return KeptVoxmapWriter(std::move(*out));
  }

  /// All parts are of one box, and no hyperchunk has marks in two of them.
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

  std::optional<Error> Finish(const MadeOf& made_of) {
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

  /// The map's index, what is solid and the chunk-level field.
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
  Voxmap only_;  // the part, as long as there is one alone
  std::uint32_t planes_ = 2;
  std::uint32_t quarters_ = 2;
  std::vector<PageEntry> entries_;
  std::vector<std::uint32_t> cells_;  // of the entries
  std::vector<VoxmapBuilder::Kind> kinds_;
  std::vector<std::pair<std::size_t, VoxmapRecord>> records_;  // of the parts, by cell
  VoxelCounts counts_;
};

class KeptPages final : public PageSource {
 public:
  KeptPages(OpenFile open, std::string name) : open_(std::move(open)), name_(std::move(name)) {
    VoxmapHeader h = open_.tail.map;
    h.quarter_count = 2;
    h.plane_count = 2;
    h.planes_offset = h.quarters_offset + h.quarter_count * (kVoxelsPerQuarter / 8 * h.bits);
    h.bytes = h.planes_offset + h.plane_count * sizeof(VoxmapPlane);
    ImageBytes image(h.bytes);
    std::memcpy(image.data(), &h, sizeof h);
    WriteOutline(open_, image);
    WriteUniform(h, image);
    outline_ = Voxmap(std::move(image));
    const Tail& tail = open_.tail;
    counts_.interior = tail.interior_voxels;
    counts_.surface = tail.surface_voxels;
    counts_.free = tail.free_voxels;
    counts_.band = tail.map.band_voxels;
    counts_.planes = tail.map.plane_count - 2;
    counts_.quarters = tail.map.quarter_count - 2;
    counts_.hyperchunks = tail.map.record_count - 2;
    counts_.bytes = tail.map.bytes;
    open_.index = {};
    open_.records = {};
    entry_of_.assign(tail.map.record_count, kNone);
    for (std::uint32_t e = 0; e < open_.entries.size(); ++e) entry_of_[open_.entries[e].record] = e;
  }

  bool HasPage(std::uint32_t record) const noexcept override { return entry_of_[record] != kNone; }
  std::uint64_t BytesOf(std::uint32_t record) const noexcept override {
    const PageEntry& entry = open_.entries[entry_of_[record]];
    return std::uint64_t{entry.first_bytes} + entry.known_bytes;
  }
  std::optional<Error> Read(std::uint32_t record, VoxelPage& page,
                            const std::stop_token& /*stop*/) const override {
    TANDEM_CHECK(HasPage(record));
    const PageEntry& entry = open_.entries[entry_of_[record]];
    PageReader reader(open_.file, open_.tail.map);
    if (!reader.Read(entry)) {
      return Error{name_ +
                   ": a page cannot be read or is damaged; 'tandem cache verify' tells more"};
    }
    const FirstPiece piece(entry, reader.quarter_bytes());
    page.stored = reader.stored();
    page.planes = reader.numbers();
    const std::size_t known = entry.known_quarters * reader.quarter_bytes();
    page.quarters.resize(known + (piece.bytes() - piece.quarters()));
    if (!reader.ReadKnown(entry, std::as_writable_bytes(std::span(page.quarters)).first(known))) {
      return Damaged(name_);
    }
    if (piece.bytes() > piece.quarters()) {
      std::memcpy(&page.quarters[known], &reader.first()[piece.quarters()],
                  piece.bytes() - piece.quarters());
    }
    return std::nullopt;
  }

 private:
  static constexpr std::uint32_t kNone = 0xffffffffU;
  OpenFile open_;
  std::string name_;
  std::vector<std::uint32_t> entry_of_;  // by record
};

}  // namespace

MadeOf KeyOf(const TriangleMesh& mesh_W, const VoxelizeOptions& options) {
  Hash64 settings;
  settings.Add(options.voxel_size);
  settings.Add(std::int64_t{options.range});
  settings.Add(std::int64_t{options.bits});
  settings.Add(options.flatness_voxels);
  return {HashOf(mesh_W), settings.value()};
}

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

std::optional<Error> KeepVoxmap(const Voxmap& voxmap, const MadeOf& made_of,
                                const std::filesystem::path& file) {
  if (voxmap.empty()) return Error{file.string() + ": there is no map to save"};
  Result<KeptVoxmapWriter> writer = KeptVoxmapWriter::Create(file);
  if (!writer) return writer.error();
  if (auto fault = writer->Add(voxmap)) return fault;
  return writer->Finish(made_of);
}

Result<Voxmap> LoadKeptVoxmap(const std::filesystem::path& file, const MadeOf& made_of) {
  Result<OpenFile> open = Open(file, made_of);
  if (!open) return open.error();
  const VoxmapHeader& h = open->tail.map;
  ImageBytes image(h.bytes);
  std::memcpy(image.data(), &h, sizeof h);
  WriteOutline(*open, image);
  WriteUniform(h, image);
  std::atomic<bool> sound = true;
  constexpr std::size_t kAtOnce = 64;
  const std::size_t groups = (open->entries.size() + kAtOnce - 1) / kAtOnce;
  tbb::parallel_for(std::size_t{0}, groups, [&](std::size_t group) {
    PageReader reader(open->file, h);
    const std::size_t end = std::min((group + 1) * kAtOnce, open->entries.size());
    for (std::size_t e = group * kAtOnce; e < end && sound; ++e) {
      const PageEntry& entry = open->entries[e];
      if (!reader.Read(entry) || !PlacePage(reader, entry, h, image)) sound = false;
    }
  });
  if (!sound) return Damaged(file.string());
  return Voxmap(std::move(image));
}

Result<std::shared_ptr<const PageSource>> OpenKeptVoxmap(const std::filesystem::path& file,
                                                         const MadeOf& made_of) {
  Result<OpenFile> open = Open(file, made_of);
  if (!open) return open.error();
  return std::shared_ptr<const PageSource>(
      std::make_shared<const KeptPages>(std::move(*open), file.string()));
}

std::optional<Error> KeptVoxmapFault(const std::filesystem::path& file) {
  const Result<OpenFile> open = Open(file);
  if (!open) return open.error();
  std::atomic<bool> sound = true;
  tbb::parallel_for(std::size_t{0}, open->entries.size(), [&](std::size_t e) {
    const PageEntry& entry = open->entries[e];
    PageReader reader(open->file, open->tail.map);
    std::vector<std::byte> known(entry.known_quarters * reader.quarter_bytes());
    if (!reader.Read(entry) || !reader.ReadKnown(entry, known)) sound = false;
  });
  if (!sound) return Damaged(file.string());
  return std::nullopt;
}

}  // namespace tandem
