#include "engine/geometry/formats/gltf_buffers.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>

#include "engine/base/files/regular_file.h"
#include "engine/base/text/json_texts.h"
#include "engine/geometry/formats/native_readers.h"
#include "engine/geometry/formats/text_lines.h"

namespace tandem {

namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t kLargestText = 1ULL << 30U;  // bytes; numbers may stand in it as text
constexpr std::size_t kMostBuffers = 256;
constexpr std::size_t kGlbTop = 20;  // bytes of the head of the file and of its first chunk
constexpr std::size_t kTop = 4096;   // bytes, of which some are not blank

/// Returns the JSON of a glTF file, text or binary; empty: it is another file.
Result<std::string> JsonOf(const fs::path& file) {
  const Result<RegularFile> opened = RegularFile::Open(file);
  if (!opened) return opened.error();
  const Error too_large{
      PlainLine(file.native()) +
      ": is larger than any glTF file that is read: export it with a buffer file"};
  std::array<char, kTop> top{};
  const std::string_view begin(top.data(), opened->Read(0, top));
  if (begin.starts_with("glTF") && begin.size() >= kGlbTop) {
    std::uint32_t length = 0;
    std::memcpy(&length, begin.data() + 12, sizeof length);
    if (length > kLargestText) return too_large;
    std::string text(std::min<std::uintmax_t>(length, opened->size()), '\0');
    text.resize(opened->Read(kGlbTop, text));
    return text;
  }
  if (const std::optional<std::string> text = TextInstead(file)) {
    return text->find_first_not_of(" \t\r\n") == text->find('{') ? *text : std::string();
  }
  if (begin.find_first_not_of(" \t\r\n") != begin.find('{')) return std::string();
  if (opened->size() > kLargestText) return too_large;
  return ReadWholeFile(file, kLargestText);
}

/// Tells whether the library takes the numbers from the name itself.
bool HoldsNumbers(std::string_view uri) {
  return uri.starts_with("data:") && uri.find(',') != std::string_view::npos;
}

}  // namespace

Result<fs::path> GltfBufferFile(const fs::path& file, const std::string& uri) {
  std::vector<fs::path> found;
  for (const std::string& name : {WithoutPercents(uri), uri}) {
    const fs::path inside = fs::path(name).lexically_normal();
    const bool leads_out = inside.is_absolute() || inside.empty() || *inside.begin() == "..";
    if (leads_out || !IsPlainText(name)) {
      return Error{PlainLine(file.native()) + ": its buffer \"" + PlainLine(uri, 80) +
                   "\" is no file in its folder: export it with its buffers beside it"};
    }
    found.push_back(file.parent_path() / inside);
  }
  // some programs write the name as it is, with a percent sign of its own
  std::error_code unknown;
  const bool as_written = !fs::exists(found[0], unknown) && fs::exists(found[1], unknown);
  return as_written ? found[1] : found[0];
}

Result<std::vector<fs::path>> GltfBuffers(const fs::path& file) {
  const std::string name = PlainLine(file.native());
  const Result<std::string> json = JsonOf(file);
  if (!json) return json.error();
  std::vector<fs::path> buffers;
  if (json->empty()) return buffers;
  const Result<std::vector<std::string>> uris = TextsWithin(*json, "buffers", "uri", kMostBuffers);
  if (!uris) return Error{name + ": its buffers cannot be found: it " + uris.error().what};
  for (const std::string& uri : *uris) {
    if (HoldsNumbers(uri)) continue;
    const Result<fs::path> named = GltfBufferFile(file, uri);
    if (!named) return named.error();
    const fs::path& buffer = *named;
    if (std::ranges::count(buffers, buffer) == 0) buffers.push_back(buffer);
  }
  return buffers;
}

}  // namespace tandem
