#include "engine/geometry/declared_unit.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdint>
#include <fstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <zlib.h>

namespace tandem {

namespace {

// A 3MF file is a ZIP archive: a directory at its end lists the files in it. One of them, the
// model, is XML whose first element has the unit.

constexpr std::size_t kLongestTail =
    66'000;  // the directory's end and the longest remark behind it
constexpr std::size_t kMostDirectory = 16 << 20;
constexpr std::size_t kHead = 1 << 16;  // of the model: its first element is in it
constexpr double kDefaultUnit = 1e-3;   // m; the format's, where the model says nothing

/// Little-endian; 0 beyond the end.
std::uint32_t NumberAt(std::string_view bytes, std::size_t at, std::size_t size) {
  if (at + size > bytes.size()) return 0;
  std::uint32_t number = 0;
  for (std::size_t i = 0; i < size; ++i) {
    number |= static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[at + i])) << (8 * i);
  }
  return number;
}

std::string Read(std::ifstream& stream, std::uint64_t from, std::size_t size) {
  std::string bytes(size, '\0');
  stream.clear();
  stream.seekg(static_cast<std::streamoff>(from));
  stream.read(bytes.data(), static_cast<std::streamsize>(size));
  bytes.resize(static_cast<std::size_t>(std::max<std::streamsize>(0, stream.gcount())));
  return bytes;
}

struct Entry {
  std::uint32_t method = 0;  // 0: stored, 8: deflated
  std::uint32_t packed = 0;  // bytes
  std::uint32_t header = 0;  // its place in the archive
};

/// The model: 3D/3dmodel.model, or else the first of that ending.
std::optional<Entry> FindModel(std::string_view directory) {
  constexpr std::uint32_t kEntry = 0x02014b50;
  std::optional<Entry> model;
  for (std::size_t at = 0; NumberAt(directory, at, 4) == kEntry;) {
    const std::size_t length = NumberAt(directory, at + 28, 2);
    if (at + 46 + length > directory.size()) break;
    const std::string_view name = directory.substr(at + 46, length);
    if (name.ends_with(".model") && (!model || name == "3D/3dmodel.model")) {
      model = Entry{NumberAt(directory, at + 10, 2), NumberAt(directory, at + 20, 4),
                    NumberAt(directory, at + 42, 4)};
    }
    at += 46 + length + NumberAt(directory, at + 30, 2) + NumberAt(directory, at + 32, 2);
  }
  return model;
}

/// The beginning of what was deflated.
std::string Inflated(const std::string& packed) {
  z_stream stream{};
  if (inflateInit2(&stream, -MAX_WBITS) != Z_OK) return {};
  std::string plain(kHead, '\0');
  std::string in = packed;
  stream.next_in = reinterpret_cast<Bytef*>(in.data());
  stream.avail_in = static_cast<uInt>(in.size());
  stream.next_out = reinterpret_cast<Bytef*>(plain.data());
  stream.avail_out = static_cast<uInt>(plain.size());
  inflate(&stream, Z_SYNC_FLUSH);
  plain.resize(plain.size() - stream.avail_out);
  inflateEnd(&stream);
  return plain;
}

std::string HeadOfModel(const std::filesystem::path& file) {
  constexpr std::string_view kEnd("PK\x05\x06", 4);
  std::error_code error;
  const std::uint64_t size = std::filesystem::file_size(file, error);
  std::ifstream stream(file, std::ios::binary);
  if (error || !stream) return {};
  const auto tail_size = static_cast<std::size_t>(std::min<std::uint64_t>(size, kLongestTail));
  const std::string tail = Read(stream, size - tail_size, tail_size);
  const std::size_t end = tail.rfind(kEnd);
  if (end == std::string::npos) return {};
  const std::size_t directory_size = NumberAt(tail, end + 12, 4);
  if (directory_size > kMostDirectory) return {};
  const auto model = FindModel(Read(stream, NumberAt(tail, end + 16, 4), directory_size));
  if (!model) return {};
  constexpr std::size_t kLocal = 30;
  const std::string local = Read(stream, model->header, kLocal);
  const std::size_t begin = kLocal + NumberAt(local, 26, 2) + NumberAt(local, 28, 2);
  const std::string packed = Read(stream, std::uint64_t{model->header} + begin,
                                  std::min<std::size_t>(model->packed, kHead));
  if (model->method == 0) return packed;
  return model->method == 8 ? Inflated(packed) : std::string();
}

/// Goes through the beginning of an XML file.
class XmlHead {
 public:
  explicit XmlHead(std::string_view text) : rest_(text) { Take("\xEF\xBB\xBF"); }

  bool Take(std::string_view words) {
    if (!rest_.starts_with(words)) return false;
    rest_.remove_prefix(words.size());
    return true;
  }
  /// What stands before these words, which are taken too; nothing: they do not come.
  std::optional<std::string_view> TakeUpTo(std::string_view words) {
    const std::size_t at = rest_.find(words);
    if (at == std::string_view::npos) return std::nullopt;
    const std::string_view before = rest_.substr(0, at);
    rest_.remove_prefix(at + words.size());
    return before;
  }
  /// Takes white space; whether there was any.
  bool TakeSpace() {
    const std::size_t end = std::min(rest_.find_first_not_of(" \t\r\n"), rest_.size());
    rest_.remove_prefix(end);
    return end > 0;
  }
  /// A name of an element or an attribute; empty: none stands here.
  std::string_view TakeName() {
    const std::size_t end = std::min(rest_.find_first_of(" \t\r\n=/<>\"'"), rest_.size());
    const std::string_view name = rest_.substr(0, end);
    rest_.remove_prefix(end);
    return name;
  }
  /// What comes before the first element: spaces, the declaration, comments.
  void TakeProlog() {
    while (TakeSpace() || (Take("<?") && TakeUpTo("?>")) || (Take("<!--") && TakeUpTo("-->"))) {
    }
  }
  /// A value in quotes, behind its equals sign.
  std::optional<std::string_view> TakeValue() {
    TakeSpace();
    if (!Take("=")) return std::nullopt;
    TakeSpace();
    for (const char* quote : {"\"", "'"}) {
      if (Take(quote)) return TakeUpTo(quote);
    }
    return std::nullopt;
  }

 private:
  std::string_view rest_;
};

std::optional<double> MetresOf(std::string_view unit) {
  constexpr std::array<std::pair<std::string_view, double>, 6> kUnits{{{"micron", 1e-6},
                                                                       {"millimeter", 1e-3},
                                                                       {"centimeter", 1e-2},
                                                                       {"inch", 0.0254},
                                                                       {"foot", 0.3048},
                                                                       {"meter", 1.0}}};
  for (const auto& [name, metres] : kUnits) {
    if (unit == name) return metres;
  }
  return std::nullopt;
}

/// Of the first element's attribute; nothing where the text is not what a model begins with.
std::optional<double> UnitIn(std::string_view text) {
  XmlHead head(text);
  head.TakeProlog();
  if (!head.Take("<")) return std::nullopt;
  const std::string_view element = head.TakeName();
  if (element != "model" && !element.ends_with(":model")) return std::nullopt;
  std::optional<double> unit;
  while (true) {
    const bool apart = head.TakeSpace();
    if (head.Take(">")) return unit.value_or(kDefaultUnit);
    const std::string_view name = head.TakeName();
    const std::optional<std::string_view> value = head.TakeValue();
    if (!apart || name.empty() || !value) return std::nullopt;
    if (name != "unit") continue;
    if (unit) return std::nullopt;
    unit = MetresOf(*value);
    if (!unit) return std::nullopt;
  }
}

}  // namespace

bool KindDeclaresUnit(const std::filesystem::path& file) {
  std::string ending = file.extension().string();
  std::ranges::transform(ending, ending.begin(), [](unsigned char c) {
    return static_cast<char>(std::tolower(c));
  });
  return ending == ".3mf";
}

std::optional<double> DeclaredUnit(const std::filesystem::path& file) {
  return KindDeclaresUnit(file) ? UnitIn(HeadOfModel(file)) : std::nullopt;
}

}  // namespace tandem
