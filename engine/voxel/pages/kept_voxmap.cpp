#include "engine/voxel/pages/kept_voxmap.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <tbb/parallel_for.h>
#include <zstd.h>

#include "engine/base/check.h"
#include "engine/base/files/regular_file.h"
#include "engine/geometry/mesh/mesh_hash.h"
#include "engine/voxel/pages/kept_voxmap_format.h"

namespace tandem {

using namespace kept_voxmap;

namespace {

Error Damaged(const std::string& file) {
  return Error{file + ": a damaged voxmap of a cache; voxelize its mesh again"};
}

/// Returns false if these are not the bytes that were compressed.
bool Decompress(std::span<const std::byte> from, std::span<std::byte> to) {
  return ZSTD_decompress(to.data(), to.size(), from.data(), from.size()) == to.size();
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
  constexpr std::uint64_t kMost = std::uint64_t{1} << 32U;  // prevents overflow of products
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
  ArrayLayout places(sizeof(VoxmapHeader));
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

Result<OpenFile> Open(const std::filesystem::path& path, const BlockFileSources& made_of) {
  Result<OpenFile> open = Open(path);
  if (open && open->tail.made_of != made_of) {
    return Error{path.string() +
                 ": a voxmap of another mesh, or made with other options; voxelize this one"};
  }
  return open;
}

/// Reads the pieces of pages; one object for each thread.
class PageReader {
 public:
  PageReader(const RegularFile& file, const VoxmapHeader& map)
      : file_(&file), quarter_bytes_(kVoxelsPerQuarter / 8 * map.bits) {}

  /// Reads a page; returns false if it is not what was written. The first piece has all places of
  /// FirstPiece.
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
  /// Reads the quarters that pages before have to `to`; returns false likewise.
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

/// Writes the parts that every map has: quarters and planes without marks, and all inside.
void WriteUniform(const VoxmapHeader& h, ImageBytes& image) {
  const std::size_t quarter_bytes = kVoxelsPerQuarter / 8 * h.bits;
  const int ones = h.bits == 2 ? 0x55 : (h.bits == 4 ? 0x11 : 0x01);
  std::memset(image.data() + h.quarters_offset + kQuarterInterior * quarter_bytes, ones,
              quarter_bytes);
  auto* planes = reinterpret_cast<VoxmapPlane*>(image.data() + h.planes_offset);
  planes[kPlaneInterior].quarters.fill(kQuarterInterior);
}

/// Puts a page that was read to its place in the whole map's image.
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
  std::vector<std::uint32_t> entry_of_;  // per record
};

}  // namespace

BlockFileSources KeyOf(const TriangleMesh& mesh_W, const VoxelizeOptions& options) {
  RunningSha256 settings;
  settings.Add(options.voxel_size);
  settings.Add(std::int64_t{options.range});
  settings.Add(std::int64_t{options.bits});
  settings.Add(options.flatness_voxels);
  return {DigestOf(mesh_W), settings.Value()};
}

Result<Voxmap> LoadKeptVoxmap(const std::filesystem::path& file, const BlockFileSources& made_of) {
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
                                                         const BlockFileSources& made_of) {
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
