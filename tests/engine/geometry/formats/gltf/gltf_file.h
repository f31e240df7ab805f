#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tests/engine/geometry/import/mesh_file_samples.h"

namespace tandem::testing {

/// Makes glTF files: numbers first, then the JSON that uses their accessors.
class GltfFile {
 public:
  /// Adds an accessor, and returns its number. `more` follows in its JSON.
  template <typename T>
  std::string Add(const std::vector<T>& numbers, const std::string& type, std::uint64_t kind,
                  const std::string& more = "") {
    const std::size_t components = type == "SCALAR" ? 1
                                   : type == "MAT4" ? 16
                                                    : static_cast<std::size_t>(type[3] - '0');
    AddView(numbers);
    return AddAccessor("\"bufferView\":" + std::to_string(views_ - 1) + ",",
                       numbers.size() / components, type, kind, more);
  }
  std::string Floats(const std::vector<float>& numbers, const std::string& type = "VEC3",
                     const std::string& more = "") {
    return Add(numbers, type, 5126, more);
  }
  std::string Corners(const std::vector<std::uint16_t>& numbers) {
    return Add(numbers, "SCALAR", 5123);
  }
  std::string AddAccessor(const std::string& view, std::size_t count, const std::string& type,
                          std::uint64_t kind, const std::string& more) {
    accessors_text_ += (accessors_ == 0 ? "" : ",") + std::string("{") + view +
                       "\"componentType\":" + std::to_string(kind) +
                       ",\"count\":" + std::to_string(count) + ",\"type\":\"" + type + "\"" + more +
                       "}";
    return std::to_string(accessors_++);
  }
  template <typename T>
  std::string AddView(const std::vector<T>& numbers) {
    const std::size_t begin = data_.size();
    data_.append(reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(T));
    views_text_ += (views_ == 0 ? "" : ",") + std::string("{\"buffer\":0,\"byteOffset\":") +
                   std::to_string(begin) +
                   ",\"byteLength\":" + std::to_string(data_.size() - begin) + "}";
    while (data_.size() % 4 != 0) data_ += '\0';
    return std::to_string(views_++);
  }

  const std::string& data() const { return data_; }
  /// Returns the JSON; `buffer` is that of its only buffer, besides its length.
  std::string Json(const std::string& rest, const std::string& buffer = "") const {
    return "{\"asset\":{\"version\":\"2.0\"}," + rest + ",\"accessors\":[" + accessors_text_ +
           "],\"bufferViews\":[" + views_text_ + "],\"buffers\":[{" + buffer +
           "\"byteLength\":" + std::to_string(data_.size()) + "}]}";
  }
  /// Returns a binary file.
  std::string Glb(const std::string& rest) const {
    std::string json = Json(rest);
    while (json.size() % 4 != 0) json += ' ';
    return "glTF" + Bytes(2, 4) + Bytes(28 + json.size() + data_.size(), 4) +
           Bytes(json.size(), 4) + "JSON" + json + Bytes(data_.size(), 4) +
           std::string("BIN\0", 4) + data_;
  }

 private:
  std::string data_;
  std::string accessors_text_, views_text_;
  int accessors_ = 0;
  int views_ = 0;
};

/// The corners and triangles of a tetrahedron of volume 1/6.
inline const std::vector<float> kTetraPoints{0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
inline const std::vector<std::uint16_t> kTetraCorners{0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2};

}  // namespace tandem::testing
