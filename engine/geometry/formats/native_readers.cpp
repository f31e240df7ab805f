#include "engine/geometry/formats/native_readers.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdint>
#include <cstring>
#include <utility>

#include "engine/base/files/regular_file.h"
#include "engine/geometry/formats/package/model_3mf.h"
#include "engine/geometry/formats/package/zip_archive.h"
#include "engine/geometry/formats/text_lines.h"

namespace tandem {

namespace {

constexpr std::uintmax_t kLargestRead = 4ULL << 30U;  // bytes; the reading process has less memory
constexpr std::size_t kLargestUnpacked = std::size_t{1} << 30U;  // bytes

ReadAnswer RefusedFile(std::string words) {
  return {ReadAnswer::Kind::kRefused, std::move(words), {}, 0};
}

/// Returns the beginning of a file.
std::string HeadOf(const std::filesystem::path& file, std::size_t most) {
  const Result<RegularFile> opened = RegularFile::Open(file);
  if (!opened) return {};
  std::string head(most, '\0');
  head.resize(opened->Read(0, head));
  return head;
}

/// Removes a line of XML that declares another encoding than the text has here.
std::string WithoutXmlHead(std::string text) {
  if (!text.starts_with("<?xml")) return text;
  const std::size_t end = text.find("?>");
  return end == std::string::npos ? text : text.substr(end + 2);
}

/// Tells whether an STL file is binary by its length, whatever its words begin with. A text in
/// UTF-16 may have such a length, but hardly the count of its triangles where that stands.
bool IsWholeBinaryStl(std::string_view bytes) {
  if (bytes.size() < 84 || (bytes.size() - 84) % 50 != 0 || bytes.find('\0') >= 84 + 50) {
    return false;
  }
  std::uint32_t count = 0;
  std::memcpy(&count, bytes.data() + 80, sizeof count);
  const bool marked = bytes.starts_with("\xFE\xFF") || bytes.starts_with("\xFF\xFE");
  return !marked || count == (bytes.size() - 84) / 50;
}

ReadAnswer ReadAmfFile(std::string bytes, const std::filesystem::path& file,
                       const std::string& part) {
  if (bytes.starts_with("PK")) {
    const std::optional<ZipArchive> archive = ZipArchive::Open(file);
    const std::string name = archive ? archive->Ending(".amf") : std::string();
    if (name.empty()) return RefusedFile("AMF: it is no archive that holds an AMF file");
    Result<std::string> unpacked = archive->Read(name, kLargestUnpacked);
    if (!unpacked) return RefusedFile("AMF: its file " + name + " " + unpacked.error().what);
    bytes = *std::move(unpacked);
  }
  return ReadAmf(InUtf8(std::move(bytes)), part);
}

/// Tells whether a format has no names of parts.
bool HasNoParts(std::string_view ending) {
  constexpr std::array<std::string_view, 5> kNone{"ply", "off", "coff", "noff", "cnoff"};
  return std::ranges::count(kNone, ending) > 0;
}

}  // namespace

std::string EndingOf(const std::filesystem::path& file) {
  const std::string ending = InSmallLetters(file.extension().string());
  return ending.empty() ? ending : ending.substr(1);
}

std::optional<ReadAnswer> ReadNatively(const std::filesystem::path& file, const std::string& part) {
  constexpr std::array<std::string_view, 10> kRead{"stl",  "obj",   "ply", "off",  "coff",
                                                   "noff", "cnoff", "amf", "gltf", "glb"};
  const std::string ending = EndingOf(file);
  if (ending == "3mf") return Read3mf(file, part);
  if (ending != "dae" && std::ranges::count(kRead, ending) == 0) return std::nullopt;
  Result<std::string> bytes = ReadWholeFile(file, kLargestRead);
  if (!bytes) return RefusedFile(bytes.error().what);
  if (!part.empty() && HasNoParts(ending)) {
    return RefusedFile("it has no part '" + part +
                       "', for its format has none: leave \"part\" out");
  }
  if (ending == "stl") {
    return ReadStl(IsWholeBinaryStl(*bytes) ? *std::move(bytes) : InUtf8(*std::move(bytes)), part);
  }
  if (ending == "obj") return ReadObj(InUtf8(*std::move(bytes)), part);
  if (ending == "ply") {
    if (!bytes->starts_with("ply")) *bytes = InUtf8(*std::move(bytes));
    return ReadPly(*bytes);
  }
  if (ending == "amf") return ReadAmfFile(*std::move(bytes), file, part);
  if (ending == "dae") return ReadCollada(InUtf8(*std::move(bytes)), part);
  if (ending == "gltf" || ending == "glb") {
    if (!bytes->starts_with("glTF")) *bytes = InUtf8(*std::move(bytes));
    return ReadGltf(*std::move(bytes), file, part);
  }
  return ReadOff(InUtf8(*std::move(bytes)));
}

std::optional<std::string> TextInstead(const std::filesystem::path& file) {
  constexpr std::array<std::string_view, 4> kTexts{"dae", "gltf", "x3d", "wrl"};
  const std::string ending = EndingOf(file);
  if (std::ranges::count(kTexts, ending) == 0) return std::nullopt;
  const std::string head = HeadOf(file, 3);
  const bool utf16 = head.starts_with("\xFE\xFF") || head.starts_with("\xFF\xFE");
  if (!utf16 && head != "\xEF\xBB\xBF") return std::nullopt;
  Result<std::string> text = ReadWholeFile(file, kLargestRead);
  if (!text) return std::nullopt;
  std::string plain = InUtf8(*std::move(text));
  return utf16 ? WithoutXmlHead(std::move(plain)) : plain;
}

}  // namespace tandem
