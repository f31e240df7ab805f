#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/files/regular_file.h"
#include "engine/base/result.h"

namespace tandem {

/// The files in a ZIP archive, also with ZIP64's numbers, such as a 3MF file. The file may come
/// from an untrusted source: called in the reading process.
class ZipArchive {
 public:
  /// Opens an archive; nothing: it is no such archive, or its directory is damaged.
  static std::optional<ZipArchive> Open(const std::filesystem::path& file);

  /// Returns the name of the archive's declared first model. If it declares none, returns
  /// 3D/3dmodel.model, or the first file that ends in `.model`; empty: there is none.
  std::string Model() const;
  /// Returns the name of the only file in it, or of the first that ends so; empty: there is none.
  std::string Ending(std::string_view ending) const;
  bool Has(std::string_view name) const { return Find(name) != nullptr; }
  /// Tells whether two names are those of the same file in it.
  bool IsSame(std::string_view a, std::string_view b) const {
    const Entry* entry = Find(a);
    return entry != nullptr && entry == Find(b);
  }
  /// Returns the beginning of a file in it, of at most `most` bytes.
  /// Names are compared without regard to case, as packages demand. An error's words continue the
  /// name: there is no such file, its compression is unknown, or all of it was read and differs
  /// from what was packed.
  Result<std::string> Read(std::string_view name, std::size_t most) const;

 private:
  struct Entry {
    std::string name;
    std::uint32_t method = 0;  // 0: stored, 8: deflated
    std::uint32_t sum = 0;     // CRC-32 of its content
    std::uint64_t packed = 0;  // bytes
    std::uint64_t size = 0;    // bytes, unpacked
    std::uint64_t header = 0;  // its place in the archive
  };
  struct Place {
    std::uint64_t begin = 0;
    std::uint64_t size = 0;  // bytes
  };
  const Entry* Find(std::string_view name) const;
  explicit ZipArchive(RegularFile file) : file_(std::move(file)) {}
  /// Returns the start by the package's relations; empty: they do not declare one.
  std::string StartOfRelations() const;
  /// Returns where the directory lies, by the end record at `end` of the archive's last bytes, or
  /// by the longer one of ZIP64.
  Place DirectoryOf(std::string_view tail, std::size_t end) const;
  std::string Bytes(std::uint64_t from, std::size_t size) const;

  RegularFile file_;
  std::vector<Entry> entries_;
};

}  // namespace tandem
