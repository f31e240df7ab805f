#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/regular_file.h"

namespace tandem {

/// The files in a ZIP archive, as 3MF files are. Reads what strangers wrote: called in the reading
/// process.
class ZipArchive {
 public:
  /// Nothing: it is no such archive, or its directory is damaged.
  static std::optional<ZipArchive> Open(const std::filesystem::path& file);

  /// The name of the first file that ends in `.model`, or 3D/3dmodel.model; empty: there is none.
  std::string Model() const;
  /// The beginning of a file in it, of at most `most` bytes; nothing: there is none of that name,
  /// or it is packed in a way that is not known.
  std::optional<std::string> Read(std::string_view name, std::size_t most) const;

 private:
  struct Entry {
    std::string name;
    std::uint32_t method = 0;  // 0: stored, 8: deflated
    std::uint32_t packed = 0;  // bytes
    std::uint32_t header = 0;  // its place in the archive
  };
  explicit ZipArchive(RegularFile file) : file_(std::move(file)) {}
  std::string Bytes(std::uint64_t from, std::size_t size) const;

  RegularFile file_;
  std::vector<Entry> entries_;
};

}  // namespace tandem
