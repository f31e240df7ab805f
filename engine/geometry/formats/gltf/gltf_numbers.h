#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/text/json_reader.h"

namespace tandem {

/// Reads the numbers of a glTF file: accessors into views of buffers, with strides, sparse values
/// and normalized integers. The first fault stays.
class GltfNumbers {
 public:
  /// `chunk`: the binary chunk of a GLB file, which must outlive the reader; empty: there is none.
  GltfNumbers(const JsonNode& root, std::filesystem::path file, std::string_view chunk);

  /// The numbers of an accessor.
  struct Numbers {
    std::size_t count = 0;
    std::size_t components = 0;  // number of each element's components
    std::uint64_t type = 0;      // component type as in the file
    bool normalized = false;
    std::vector<double> values;

    double At(std::size_t element, std::size_t component) const {
      return values[element * components + component];
    }
  };
  /// Returns an accessor's numbers; nothing: a fault is noted.
  std::optional<Numbers> Read(std::uint64_t accessor);

  /// Tells whether an accessor has numbers of its own, and not zeros only.
  bool HasNumbers(std::uint64_t accessor) const;
  const std::string& fault() const noexcept { return fault_; }

 private:
  struct Run {
    std::string_view bytes;  // from the first element on
    std::size_t stride = 0;
    std::size_t size = 0;  // bytes of an element
  };
  std::optional<Run> ReadRun(std::uint64_t view, std::uint64_t offset, std::size_t count,
                             std::size_t size);
  bool ReadSparse(const JsonNode& sparse, Numbers& numbers);
  std::optional<std::string_view> Buffer(std::uint64_t index);
  std::optional<std::string> Load(const JsonNode& buffer, std::uint64_t index);
  std::nullopt_t Fault(std::string why);

  std::filesystem::path file_;
  std::string_view chunk_;
  std::vector<JsonNode> accessors_;
  std::vector<JsonNode> views_;
  std::vector<JsonNode> buffers_;
  std::vector<std::optional<std::string>> loaded_;
  std::string fault_;
};

/// Returns the values of an array that may be missing.
std::vector<JsonNode> ItemsOf(const JsonNode& node, std::string_view key);
/// Returns a whole number that may be missing.
std::uint64_t UnsignedOf(const JsonNode& node, std::string_view key, std::uint64_t otherwise);

}  // namespace tandem
