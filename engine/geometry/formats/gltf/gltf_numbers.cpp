#include "engine/geometry/formats/gltf/gltf_numbers.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <utility>

#include "engine/base/files/regular_file.h"
#include "engine/geometry/formats/gltf_buffers.h"
#include "engine/geometry/formats/text_lines.h"

namespace tandem {

namespace {

constexpr std::uintmax_t kLargestBuffer = 4ULL << 30U;  // bytes; the process has less memory
constexpr std::uint64_t kMostElements = UINT32_MAX;
constexpr std::uint64_t kMostZeros = 1ULL << 22U;  // elements that no bytes stand for

enum ComponentType : std::uint64_t {
  kByte = 5120,
  kUnsignedByte = 5121,
  kShort = 5122,
  kUnsignedShort = 5123,
  kUnsignedInt = 5125,
  kFloat = 5126
};

std::size_t SizeOfComponent(std::uint64_t type) {
  switch (type) {
    case kByte:
    case kUnsignedByte:
      return 1;
    case kShort:
    case kUnsignedShort:
      return 2;
    case kUnsignedInt:
    case kFloat:
      return 4;
    default:
      return 0;
  }
}

std::size_t ComponentsOf(const std::string& type) {
  constexpr std::array<std::pair<std::string_view, std::size_t>, 5> kTypes{
      {{"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}, {"MAT4", 16}}};
  for (const auto& [name, count] : kTypes) {
    if (type == name) return count;
  }
  return 0;
}

template <typename T>
double Take(const char* bytes, bool normalized) {
  T number{};
  std::memcpy(&number, bytes, sizeof number);
  const auto value = static_cast<double>(number);
  if (!normalized) return value;
  return std::max(value / static_cast<double>(std::numeric_limits<T>::max()), -1.0);
}

double Component(const char* bytes, std::uint64_t type, bool normalized) {
  switch (type) {
    case kByte:
      return Take<std::int8_t>(bytes, normalized);
    case kUnsignedByte:
      return Take<std::uint8_t>(bytes, normalized);
    case kShort:
      return Take<std::int16_t>(bytes, normalized);
    case kUnsignedShort:
      return Take<std::uint16_t>(bytes, normalized);
    case kUnsignedInt:
      return Take<std::uint32_t>(bytes, normalized);
    default: {
      float number = 0;
      std::memcpy(&number, bytes, sizeof number);
      return static_cast<double>(number);
    }
  }
}

/// Decodes the bytes of a data URI; nothing: they are damaged.
std::optional<std::string> BytesOfDataUri(std::string_view uri) {
  const std::size_t comma = uri.find(',');
  if (comma == std::string_view::npos) return std::nullopt;
  const bool base64 = uri.substr(0, comma).ends_with(";base64");
  std::string_view data = uri.substr(comma + 1);
  std::string plain;
  if (data.find('%') != std::string_view::npos) {
    plain = WithoutPercents(data);
    data = plain;
  }
  if (!base64) return std::string(data);
  constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::array<int, 256> value{};
  value.fill(-1);
  for (std::size_t i = 0; i < kDigits.size(); ++i) {
    value[static_cast<unsigned char>(kDigits[i])] = static_cast<int>(i);
  }
  value['-'] = 62;
  value['_'] = 63;
  std::string bytes;
  bytes.reserve(data.size() / 4 * 3);
  std::uint32_t bits = 0;
  int held = 0;
  for (const char c : data) {
    if (c == '=') break;
    if (c == '\n' || c == '\r' || c == ' ') continue;
    const int digit = value[static_cast<unsigned char>(c)];
    if (digit < 0) return std::nullopt;
    bits = bits << 6U | static_cast<std::uint32_t>(digit);
    held += 6;
    if (held < 8) continue;
    held -= 8;
    bytes += static_cast<char>(bits >> static_cast<unsigned>(held) & 0xFFU);
  }
  return bytes;
}

}  // namespace

std::vector<JsonNode> ItemsOf(const JsonNode& node, std::string_view key) {
  return node.Has(key) ? node[key].Items() : std::vector<JsonNode>();
}

std::uint64_t UnsignedOf(const JsonNode& node, std::string_view key, std::uint64_t otherwise) {
  return node.Has(key) ? node[key].Unsigned() : otherwise;
}

GltfNumbers::GltfNumbers(const JsonNode& root, std::filesystem::path file, std::string_view chunk)
    : file_(std::move(file)),
      chunk_(chunk),
      accessors_(ItemsOf(root, "accessors")),
      views_(ItemsOf(root, "bufferViews")),
      buffers_(ItemsOf(root, "buffers")),
      loaded_(buffers_.size()) {}

std::nullopt_t GltfNumbers::Fault(std::string why) {
  if (fault_.empty()) fault_ = std::move(why);
  return std::nullopt;
}

bool GltfNumbers::HasNumbers(std::uint64_t accessor) const {
  return accessor < accessors_.size() &&
         (accessors_[accessor].Has("bufferView") || accessors_[accessor].Has("sparse"));
}

std::optional<std::string> GltfNumbers::Load(const JsonNode& buffer, std::uint64_t index) {
  const std::string which = "its buffer " + std::to_string(index);
  std::string uri = buffer["uri"].Compact();
  if (uri.starts_with("\"data:")) {
    std::optional<std::string> data =
        BytesOfDataUri(std::string_view(uri).substr(1, uri.size() - 2));
    if (!data) return Fault(which + " is damaged: its text is not base64");
    return data;
  }
  const Result<std::filesystem::path> named = GltfBufferFile(file_, buffer["uri"].Text());
  if (!named) return Fault(named.error().what);
  std::error_code unknown;
  if (!std::filesystem::exists(*named, unknown)) {
    return Fault(which + " is the file " + named->filename().string() +
                 ", which is not there: put it beside the mesh");
  }
  Result<std::string> read = ReadWholeFile(*named, kLargestBuffer);
  if (!read) return Fault(read.error().what);
  return *std::move(read);
}

std::optional<std::string_view> GltfNumbers::Buffer(std::uint64_t index) {
  if (index >= buffers_.size()) return Fault("there is no buffer " + std::to_string(index));
  const JsonNode& buffer = buffers_[index];
  const std::string which = "its buffer " + std::to_string(index);
  const bool in_file = !buffer.Has("uri");
  if (in_file && (index != 0 || chunk_.empty())) {
    return Fault(which +
                 " has no bytes: its numbers are packed, or the file is damaged; export "
                 "it without compression");
  }
  if (!in_file && !loaded_[index]) {
    loaded_[index] = Load(buffer, index);
    if (!loaded_[index]) return std::nullopt;
  }
  // the chunk may be large, and is not copied
  const std::string_view bytes = in_file ? chunk_ : std::string_view(*loaded_[index]);
  const std::uint64_t length = UnsignedOf(buffer, "byteLength", 0);
  if (bytes.size() < length) {
    return Fault(which + " has " + std::to_string(bytes.size()) + " bytes of " +
                 std::to_string(length) + ": it is cut short");
  }
  return bytes;
}

std::optional<GltfNumbers::Run> GltfNumbers::ReadRun(std::uint64_t view, std::uint64_t offset,
                                                     std::size_t count, std::size_t size) {
  if (view >= views_.size()) return Fault("there is no buffer view " + std::to_string(view));
  const JsonNode& node = views_[view];
  const auto buffer = Buffer(UnsignedOf(node, "buffer", 0));
  if (!buffer) return std::nullopt;
  const std::uint64_t begin = UnsignedOf(node, "byteOffset", 0);
  const std::uint64_t length = UnsignedOf(node, "byteLength", 0);
  const std::uint64_t said = UnsignedOf(node, "byteStride", 0);
  const std::uint64_t stride = said == 0 ? size : said;
  const std::string cut = "buffer view " + std::to_string(view) +
                          " goes beyond its buffer: the file is damaged or cut short";
  if (begin > buffer->size() || length > buffer->size() - begin) return Fault(cut);
  const std::string_view bytes = buffer->substr(begin, length);
  if (count == 0) return Run{bytes, size, size};
  if (stride < size || stride > 65536 || offset > length || length - offset < size ||
      (length - offset - size) / stride < count - 1) {
    return Fault("an accessor takes " + std::to_string(count) + " elements from buffer view " +
                 std::to_string(view) + ", which has fewer");
  }
  return Run{bytes.substr(offset), stride, size};
}

std::optional<GltfNumbers::Numbers> GltfNumbers::Read(std::uint64_t accessor) {
  if (accessor >= accessors_.size()) {
    return Fault("there is no accessor " + std::to_string(accessor));
  }
  const JsonNode& node = accessors_[accessor];
  Numbers numbers;
  numbers.count = UnsignedOf(node, "count", 0);
  numbers.type = UnsignedOf(node, "componentType", 0);
  numbers.components = ComponentsOf(node.Has("type") ? node["type"].PlainText(16) : "");
  numbers.normalized = node.Has("normalized") && node["normalized"].TrueOrFalse();
  const std::size_t size = SizeOfComponent(numbers.type);
  if (size == 0 || numbers.components == 0 || numbers.count > kMostElements) {
    return Fault("accessor " + std::to_string(accessor) + " has numbers of an unknown kind");
  }
  if (node.Has("bufferView")) {
    const auto run = ReadRun(node["bufferView"].Unsigned(), UnsignedOf(node, "byteOffset", 0),
                             numbers.count, size * numbers.components);
    if (!run) return std::nullopt;
    numbers.values.reserve(numbers.count * numbers.components);
    for (std::size_t i = 0; i < numbers.count; ++i) {
      const char* at = run->bytes.data() + i * run->stride;
      for (std::size_t k = 0; k < numbers.components; ++k, at += size) {
        numbers.values.push_back(Component(at, numbers.type, numbers.normalized));
      }
    }
  } else if (numbers.count <= kMostZeros) {
    numbers.values.assign(numbers.count * numbers.components, 0);
  } else {
    return Fault("accessor " + std::to_string(accessor) + " says that it has " +
                 std::to_string(numbers.count) + " elements, and takes them from nowhere");
  }
  if (node.Has("sparse") && !ReadSparse(node["sparse"], numbers)) return std::nullopt;
  return numbers;
}

bool GltfNumbers::ReadSparse(const JsonNode& sparse, Numbers& numbers) {
  const std::uint64_t count = UnsignedOf(sparse, "count", 0);
  const JsonNode indices = sparse["indices"];
  const JsonNode values = sparse["values"];
  const std::uint64_t type = UnsignedOf(indices, "componentType", 0);
  const std::size_t index_size = SizeOfComponent(type);
  const std::size_t size = SizeOfComponent(numbers.type);
  if (count > numbers.count || index_size == 0 || type == kFloat) {
    Fault("a sparse accessor has numbers of an unknown kind");
    return false;
  }
  const auto places = ReadRun(UnsignedOf(indices, "bufferView", UINT64_MAX),
                              UnsignedOf(indices, "byteOffset", 0), count, index_size);
  if (!places) return false;
  const auto run = ReadRun(UnsignedOf(values, "bufferView", UINT64_MAX),
                           UnsignedOf(values, "byteOffset", 0), count, size * numbers.components);
  if (!run) return false;
  for (std::size_t i = 0; i < count; ++i) {
    const double place = Component(places->bytes.data() + i * places->stride, type, false);
    if (place < 0 || place >= static_cast<double>(numbers.count)) {
      Fault("a sparse accessor changes an element that there is not");
      return false;
    }
    const char* at = run->bytes.data() + i * run->stride;
    for (std::size_t k = 0; k < numbers.components; ++k, at += size) {
      numbers.values[static_cast<std::size_t>(place) * numbers.components + k] =
          Component(at, numbers.type, numbers.normalized);
    }
  }
  return true;
}

}  // namespace tandem
