#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "engine/base/result.h"

namespace tandem {

/// A file that exists whole or not at all. It is written beside its place, as
/// NAME.unfinished-PID-N, and Commit() moves it there. An older file stays until then, and for good
/// where the disk is full or the program ends. Remainders of killed programs beside NAME are
/// removed when NAME is made the next time.
class WholeFile {
 public:
  /// Creates a file. `mode`: of the file, before the umask. A pipe or a device is written directly,
  /// because nothing can take its place.
  static Result<WholeFile> Create(const std::filesystem::path& file, unsigned mode = 0666);
  WholeFile(WholeFile&& other) noexcept;
  WholeFile& operator=(WholeFile&& other) noexcept;
  /// Removes what was not committed.
  ~WholeFile();

  /// Writes bytes; false: the disk takes no more. The first fault stays, and Commit() returns it.
  bool Write(std::string_view bytes);
  std::uint64_t written() const noexcept { return written_; }  // bytes
  /// Waits until the disk has all bytes, and moves the file to its place.
  std::optional<Error> Commit();

 private:
  WholeFile() = default;
  bool Flush();

  std::filesystem::path file_;
  std::filesystem::path beside_;  // empty: it is written in place
  int descriptor_ = -1;
  int fault_ = 0;  // errno
  std::uint64_t written_ = 0;
  std::string waiting_;
};

/// Writes a whole file in one call.
std::optional<Error> WriteWholeFile(const std::filesystem::path& file, std::string_view text,
                                    unsigned mode = 0666);

}  // namespace tandem
