#include "engine/geometry/formats/package/zip_archive.h"

#include <algorithm>
#include <utility>

#include <zlib.h>

#include "engine/geometry/formats/text_lines.h"
#include "engine/geometry/formats/xml_scanner.h"

namespace tandem {

namespace {

constexpr std::size_t kLongestTail =
    66'000;  // the directory's end and the longest remark behind it
constexpr std::size_t kMostDirectory = 16 << 20;

constexpr std::uint64_t kAllOnes = 0xffffffff;  // a number that stands elsewhere, as 64 bits

/// Reads a little-endian number; 0 beyond the end.
std::uint64_t NumberAt(std::string_view bytes, std::size_t at, std::size_t size) {
  if (at > bytes.size() || size > bytes.size() - at) return 0;
  std::uint64_t number = 0;
  for (std::size_t i = 0; i < size; ++i) {
    number |= static_cast<std::uint64_t>(static_cast<unsigned char>(bytes[at + i])) << (8 * i);
  }
  return number;
}

/// Returns the content of the extra field that holds numbers of 64 bits; empty: there is none.
std::string_view LongNumbersIn(std::string_view extra) {
  constexpr std::uint64_t kLongNumbers = 1;
  while (extra.size() >= 4) {
    const std::size_t size = NumberAt(extra, 2, 2);
    const std::string_view content = extra.substr(4, size);
    if (NumberAt(extra, 0, 2) == kLongNumbers) return content;
    extra.remove_prefix(std::min(extra.size(), 4 + size));
  }
  return {};
}

/// Returns a name of a package's part as it is compared: in small letters, without a slash before
/// it, with plain slashes, and percent codes resolved.
std::string Compared(std::string_view name) {
  const std::string plain = WithoutPercents(name);
  std::string compared = InSmallLetters(plain);
  std::ranges::replace(compared, '\\', '/');
  return compared.starts_with('/') ? compared.substr(1) : compared;
}

/// Returns the beginning of deflated data.
std::string Inflated(std::string packed, std::size_t most) {
  z_stream stream{};
  if (inflateInit2(&stream, -MAX_WBITS) != Z_OK) return {};
  stream.next_in = reinterpret_cast<Bytef*>(packed.data());
  stream.avail_in = static_cast<uInt>(packed.size());
  std::string plain;
  int state = Z_OK;
  while (state == Z_OK && plain.size() < most) {
    constexpr std::size_t kBlock = 1 << 16;
    const std::size_t before = plain.size();
    plain.resize(std::min(most, before + kBlock));
    stream.next_out = reinterpret_cast<Bytef*>(plain.data() + before);
    stream.avail_out = static_cast<uInt>(plain.size() - before);
    state = inflate(&stream, Z_SYNC_FLUSH);
    const bool stuck = stream.avail_out == plain.size() - before;
    plain.resize(plain.size() - stream.avail_out);
    if (stuck) break;
  }
  inflateEnd(&stream);
  return plain;
}

}  // namespace

std::string ZipArchive::Bytes(std::uint64_t from, std::size_t size) const {
  std::string bytes(std::min<std::uintmax_t>(size, file_.size()), '\0');
  bytes.resize(file_.Read(from, bytes));
  return bytes;
}

std::optional<ZipArchive> ZipArchive::Open(const std::filesystem::path& file) {
  constexpr std::string_view kEnd("PK\x05\x06", 4);
  constexpr std::uint32_t kEntry = 0x02014b50;
  Result<RegularFile> opened = RegularFile::Open(file);
  if (!opened) return std::nullopt;
  ZipArchive archive(*std::move(opened));
  const std::uint64_t size = archive.file_.size();
  const auto tail_size = static_cast<std::size_t>(std::min<std::uint64_t>(size, kLongestTail));
  const std::string tail = archive.Bytes(size - tail_size, tail_size);
  const std::size_t end = tail.rfind(kEnd);
  if (end == std::string::npos) return std::nullopt;
  const Place place = archive.DirectoryOf(tail, end);
  if (place.size > kMostDirectory) return std::nullopt;
  const std::string directory = archive.Bytes(place.begin, static_cast<std::size_t>(place.size));
  for (std::size_t at = 0; NumberAt(directory, at, 4) == kEntry;) {
    const std::size_t length = NumberAt(directory, at + 28, 2);
    const std::size_t extra = NumberAt(directory, at + 30, 2);
    if (at + 46 + length > directory.size()) break;
    Entry entry{.name = directory.substr(at + 46, length),
                .method = static_cast<std::uint32_t>(NumberAt(directory, at + 10, 2)),
                .sum = static_cast<std::uint32_t>(NumberAt(directory, at + 16, 4)),
                .packed = NumberAt(directory, at + 20, 4),
                .size = NumberAt(directory, at + 24, 4),
                .header = NumberAt(directory, at + 42, 4)};
    std::string_view numbers =
        LongNumbersIn(std::string_view(directory).substr(at + 46 + length, extra));
    for (std::uint64_t* number : {&entry.size, &entry.packed, &entry.header}) {
      if (*number != kAllOnes || numbers.size() < 8) continue;
      *number = NumberAt(numbers, 0, 8);
      numbers.remove_prefix(8);
    }
    archive.entries_.push_back(std::move(entry));
    at += 46 + length + extra + NumberAt(directory, at + 32, 2);
  }
  return archive;
}

ZipArchive::Place ZipArchive::DirectoryOf(std::string_view tail, std::size_t end) const {
  constexpr std::string_view kLocator("PK\x06\x07", 4);
  constexpr std::string_view kLongEnd("PK\x06\x06", 4);
  constexpr std::size_t kLocatorSize = 20;
  constexpr std::size_t kLongEndSize = 56;
  const Place place{NumberAt(tail, end + 16, 4), NumberAt(tail, end + 12, 4)};
  if (place.begin != kAllOnes && place.size != kAllOnes) return place;
  if (end < kLocatorSize) return place;
  const std::string_view locator = tail.substr(end - kLocatorSize, kLocatorSize);
  if (!locator.starts_with(kLocator)) return place;
  const std::string long_end = Bytes(NumberAt(locator, 8, 8), kLongEndSize);
  if (!long_end.starts_with(kLongEnd)) return place;
  return {NumberAt(long_end, 48, 8), NumberAt(long_end, 40, 8)};
}

std::string ZipArchive::StartOfRelations() const {
  constexpr std::size_t kMostRelations = 1 << 20;
  const Result<std::string> relations = Read("_rels/.rels", kMostRelations);
  if (!relations) return {};
  const std::string text = InUtf8(*relations);
  XmlScanner xml(text);
  for (auto piece = xml.Next();; piece = xml.Next()) {
    if (piece == XmlScanner::Piece::kEnd || piece == XmlScanner::Piece::kFault) return {};
    if (piece != XmlScanner::Piece::kOpen || xml.name() != "Relationship") continue;
    if (!xml.Attribute("Type").value_or("").ends_with("/3dmodel")) continue;
    std::string target = xml.Attribute("Target").value_or("");
    if (target.starts_with('/')) target.erase(0, 1);
    return target;
  }
}

const ZipArchive::Entry* ZipArchive::Find(std::string_view name) const {
  const auto exact = std::ranges::find(entries_, name, &Entry::name);
  if (exact != entries_.end()) return &*exact;
  const std::string wanted = Compared(name);
  const auto alike = std::ranges::find_if(entries_, [&](const Entry& entry) {
    return Compared(entry.name) == wanted;
  });
  return alike == entries_.end() ? nullptr : &*alike;
}

std::string ZipArchive::Model() const {
  const std::string start = StartOfRelations();
  for (const std::string& name : {start, std::string("3D/3dmodel.model")}) {
    if (const Entry* entry = name.empty() ? nullptr : Find(name)) return entry->name;
  }
  return Ending(".model");
}

std::string ZipArchive::Ending(std::string_view ending) const {
  for (const Entry& entry : entries_) {
    if (Compared(entry.name).ends_with(ending)) return entry.name;
  }
  return entries_.size() == 1 && ending != ".model" ? entries_[0].name : std::string();
}

Result<std::string> ZipArchive::Read(std::string_view name, std::size_t most) const {
  const Entry* entry = Find(name);
  if (entry == nullptr) return Error{"is missing"};
  if (entry->method != 0 && entry->method != 8) {
    return Error{"is packed in a way that is not known"};
  }
  constexpr std::size_t kLocal = 30;
  const std::string local = Bytes(entry->header, kLocal);
  const std::uint64_t begin =
      entry->header + kLocal + NumberAt(local, 26, 2) + NumberAt(local, 28, 2);
  // the beginning of the packed data unpacks to more than `most` bytes, or is all of it
  std::string content =
      entry->method == 0
          ? Bytes(begin, std::min<std::uint64_t>(entry->packed, most))
          : Inflated(Bytes(begin, std::min<std::uint64_t>(entry->packed, most + 1024)), most);
  if (entry->size > most && content.size() >= most) return content;
  const uLong sum = crc32_z(0, reinterpret_cast<const Bytef*>(content.data()), content.size());
  // all ones without a longer number: the size is not said
  if ((entry->size != kAllOnes && content.size() != entry->size) || sum != entry->sum) {
    return Error{"is damaged: its bytes are not those that were packed"};
  }
  return content;
}

}  // namespace tandem
