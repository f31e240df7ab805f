#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/regular_file.h"
#include "engine/base/result.h"

namespace tandem {

/// The files in a ZIP archive, as 3MF files are. Reads what strangers wrote: called in the reading
/// process.
class ZipArchive {
 public:
  /// Nothing: it is no such archive, or its directory is damaged.
  static std::optional<ZipArchive> Open(const std::filesystem::path& file);

  /// The name of the model that the archive says it begins with; of 3D/3dmodel.model, or of the
  /// first file that ends in `.model`, where it does not say so; empty: there is none.
  std::string Model() const;
  /// The beginning of a file in it, of at most `most` bytes. An error's words go on behind the
  /// name: there is none of that name, it is packed in a way that is not known, or all of it was
  /// read and is not what was packed.
  Result<std::string> Read(std::string_view name, std::size_t most) const;

 private:
  struct Entry {
    std::string name;
    std::uint32_t method = 0;  // 0: stored, 8: deflated
    std::uint32_t sum = 0;     // CRC-32 of its content
    std::uint32_t packed = 0;  // bytes
    std::uint32_t size = 0;    // bytes, unpacked
    std::uint32_t header = 0;  // its place in the archive
  };
  explicit ZipArchive(RegularFile file) : file_(std::move(file)) {}
  /// By the package's relations; empty: they do not say.
  std::string StartOfRelations() const;
  std::string Bytes(std::uint64_t from, std::size_t size) const;

  RegularFile file_;
  std::vector<Entry> entries_;
};

}  // namespace tandem
