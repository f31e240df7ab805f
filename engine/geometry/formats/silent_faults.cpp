#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "engine/base/files/regular_file.h"
#include "engine/base/text/json_reader.h"
#include "engine/geometry/formats/native_readers.h"
#include "engine/geometry/formats/xml_scanner.h"

namespace tandem {

namespace {

constexpr std::uintmax_t kLargestSearched = 1ULL << 30U;

std::size_t WordsIn(std::string_view text) {
  std::size_t words = 0;
  bool in_word = false;
  for (const char c : text) {
    const bool space = c == ' ' || c == '\t' || c == '\r' || c == '\n';
    if (!space && !in_word) ++words;
    in_word = !space;
  }
  return words;
}

std::optional<std::uint64_t> NumberIn(const std::optional<std::string>& word) {
  std::uint64_t number = 0;
  if (!word) return std::nullopt;
  const auto [end, error] = std::from_chars(word->data(), word->data() + word->size(), number);
  if (error != std::errc() || end != word->data() + word->size()) return std::nullopt;
  return number;
}

// The library takes the digits before a point as one integer of 64 bits, whatever their number.
constexpr std::size_t kTooManyDigits = 20;
const char* const kTooManyDigitsWords = "has a number of 20 digits and more before its point";

bool HasTooManyDigits(std::string_view text) {
  std::size_t digits = 0;
  bool behind_point = false;
  for (const char c : text) {
    const bool digit = c >= '0' && c <= '9';
    digits = digit ? digits + 1 : 0;
    if (digits >= kTooManyDigits && !behind_point) return true;
    if (!digit) behind_point = c == '.';
  }
  return false;
}

/// Tells by its beginning whether a file is binary: a binary STL has zeros there in its numbers or
/// its count.
bool IsBinary(const std::filesystem::path& file) {
  const Result<RegularFile> opened = RegularFile::Open(file);
  std::array<char, 1024> head{};
  if (!opened) return false;
  const std::size_t size = opened->Read(0, head);
  return std::string_view(head.data(), size).find('\0') != std::string_view::npos;
}

/// Returns what is wrong with the lines of numbers of an OBJ or a text STL file. Names and remarks
/// may have any number of digits.
std::string LinesFault(std::string_view text, bool obj) {
  while (!text.empty()) {
    const std::size_t end = std::min(text.find_first_of("\r\n"), text.size());
    std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    line.remove_prefix(std::min(line.find_first_not_of(" \t"), line.size()));
    const bool numbers =
        obj ? line.starts_with('v') : !line.starts_with("solid") && !line.starts_with("endsolid");
    if (numbers && HasTooManyDigits(line)) return kTooManyDigitsWords;
  }
  return {};
}

/// Checks the arrays of a COLLADA file, whose declared lengths accessors trust.
class ColladaArrays {
 public:
  explicit ColladaArrays(std::string_view text) : xml_(text) {}

  std::string Fault() {
    for (auto piece = xml_.Next();; piece = xml_.Next()) {
      if (piece == XmlScanner::Piece::kEnd || piece == XmlScanner::Piece::kFault) return {};
      if (piece == XmlScanner::Piece::kText && in_array_) words_ += WordsIn(xml_.text());
      if (piece == XmlScanner::Piece::kText && HoldsNumbers(xml_.name()) &&
          HasTooManyDigits(xml_.text())) {
        return kTooManyDigitsWords;
      }
      if (piece == XmlScanner::Piece::kOpen) {
        if (std::string fault = Open(); !fault.empty()) return fault;
      }
      if (piece == XmlScanner::Piece::kClose && xml_.name() == "float_array" && in_array_) {
        if (std::string fault = Close(); !fault.empty()) return fault;
      }
    }
  }

 private:
  static bool HoldsNumbers(std::string_view element) {
    constexpr std::array<std::string_view, 7> kElements{
        "float_array", "matrix", "translate", "rotate", "scale", "lookat", "skew"};
    return std::ranges::count(kElements, element) > 0;
  }

  std::string Open() {
    if (xml_.name() == "float_array") {
      id_ = xml_.Attribute("id").value_or("");
      const auto count = NumberIn(xml_.Attribute("count"));
      if (!count) return "its array '" + id_ + "' does not say how many numbers it has";
      said_ = *count;
      words_ = 0;
      in_array_ = true;
      if (xml_.empty()) return Close();
    }
    if (xml_.name() != "accessor") return {};
    const std::string source = xml_.Attribute("source").value_or("");
    const auto array = source.starts_with('#') ? lengths_.find(source.substr(1)) : lengths_.end();
    const auto count = NumberIn(xml_.Attribute("count"));
    const std::uint64_t stride = NumberIn(xml_.Attribute("stride")).value_or(1);
    const std::uint64_t offset = NumberIn(xml_.Attribute("offset")).value_or(0);
    if (array == lengths_.end() || !count) return {};
    if (stride == 0 || offset > array->second || *count > (array->second - offset) / stride) {
      return "takes " + std::to_string(*count) + " times " + std::to_string(stride) +
             " numbers from its array '" + array->first + "' of " + std::to_string(array->second);
    }
    return {};
  }

  std::string Close() {
    in_array_ = false;
    lengths_[id_] = words_;
    if (said_ == words_) return {};
    return "its array '" + id_ + "' says that it has " + std::to_string(said_) +
           " numbers, and has " + std::to_string(words_);
  }

  XmlScanner xml_;
  std::map<std::string, std::uint64_t> lengths_;
  std::string id_;
  std::uint64_t said_ = 0;
  std::uint64_t words_ = 0;
  bool in_array_ = false;
};

/// Returns the JSON of a glTF file, text or binary.
std::string GltfText(const std::string& bytes) {
  constexpr std::size_t kGlbHead = 20;  // bytes of the head of the file, and of its first chunk
  if (!bytes.starts_with("glTF") || bytes.size() < kGlbHead) return bytes;
  std::uint32_t length = 0;
  std::memcpy(&length, bytes.data() + 12, sizeof length);
  return bytes.substr(kGlbHead, length);
}

/// Returns the number of the primitive's triangles by its accessors.
std::size_t TrianglesOf(const JsonNode& primitive, const std::vector<JsonNode>& accessors) {
  constexpr int kTriangles = 4;
  const int mode = primitive.Has("mode") ? primitive["mode"].WholeNumber(0, 6) : kTriangles;
  if (mode < kTriangles) return 0;
  const JsonNode index =
      primitive.Has("indices") ? primitive["indices"] : primitive["attributes"]["POSITION"];
  const auto accessor = index.Unsigned();
  if (accessor >= accessors.size()) return 0;
  const auto count = accessors[accessor]["count"].Unsigned(UINT32_MAX);
  if (mode == kTriangles) return count / 3;
  return count < 3 ? 0 : count - 2;
}

/// Tells whether the library reads the extension, or it affects only what surfaces look like.
bool IsReadOrOfLooks(std::string_view extension) {
  constexpr std::array<std::string_view, 4> kLooks{"KHR_materials_", "KHR_texture_", "EXT_texture_",
                                                   "MSFT_texture_"};
  // the library refuses compressed data in words if it was built without support
  return extension == "KHR_draco_mesh_compression" || extension == "KHR_lights_punctual" ||
         std::ranges::any_of(kLooks, [&](std::string_view begin) {
           return extension.starts_with(begin);
         });
}

/// Tells whether a primitive's positions are not VEC3 floats. The library reads them as such in any
/// case.
bool HasOtherPlaces(const JsonNode& primitive, const std::vector<JsonNode>& accessors) {
  constexpr std::uint64_t kFloat = 5126;
  if (!primitive["attributes"].Has("POSITION")) return false;
  const auto accessor = primitive["attributes"]["POSITION"].Unsigned();
  if (accessor >= accessors.size()) return false;
  const JsonNode& places = accessors[accessor];
  return !places.Has("componentType") || !places.Has("type") ||
         places["componentType"].Unsigned() != kFloat || places["type"].PlainText(16) != "VEC3";
}

std::string GltfFault(const std::string& text, std::size_t triangles) {
  const std::string unread = "what it needs cannot be read: the file is damaged";
  constexpr std::string_view kNeeds = "extensionsRequired";
  const Result<JsonFile> json = JsonFile::Parse(text, "glTF");
  if (!json) return text.find(kNeeds) == std::string::npos ? "" : unread;
  const JsonNode root = json->root();
  if (root.Has(kNeeds)) {
    for (const JsonNode& extension : root[kNeeds].Items()) {
      const std::string name = extension.PlainText(80);
      if (!json->fault() && !IsReadOrOfLooks(name)) {
        return "it needs " + name + ", which is not read: export it without";
      }
    }
    if (json->fault()) return unread;
  }
  if (!root.Has("meshes") || !root.Has("accessors")) return {};
  const std::vector<JsonNode> accessors = root["accessors"].Items();
  std::size_t stated = 0;
  bool other = false;
  for (const JsonNode& mesh : root["meshes"].Items()) {
    for (const JsonNode& primitive : mesh["primitives"].Items()) {
      stated += TrianglesOf(primitive, accessors);
      other = other || HasOtherPlaces(primitive, accessors);
    }
  }
  if (json->fault()) return root.Has(kNeeds) ? unread : "";
  if (other) return "the places of its vertices are not three floats each: export it so";
  if (triangles >= stated) return {};
  return std::to_string(stated - triangles) + " of its " + std::to_string(stated) +
         " triangles cannot be had: they use vertices that there are not, or are packed";
}

}  // namespace

std::string SilentFault(const std::filesystem::path& file, std::string_view text,
                        std::size_t triangles) {
  const std::string ending = EndingOf(file);
  const bool gltf = ending == "gltf" || ending == "glb";
  const bool lines = ending == "obj" || ending == "stl";
  if (!gltf && !lines && ending != "dae") return {};
  if (ending == "stl" && IsBinary(file)) return {};
  std::string whole;
  if (text.empty()) {
    Result<std::string> read = ReadWholeFile(file, kLargestSearched);
    if (!read) return {};
    whole = *std::move(read);
    text = whole;
  }
  if (gltf) return GltfFault(GltfText(std::string(text)), triangles);
  if (lines) return LinesFault(text, ending == "obj");
  return ColladaArrays(text).Fault();
}

}  // namespace tandem
