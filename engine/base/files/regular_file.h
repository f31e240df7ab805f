#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "engine/base/result.h"

namespace tandem {

/// A regular file, open for reading. A path from an untrusted source may be a pipe, which blocks,
/// or a device, which never ends. Any file that is not regular is refused before a byte is read,
/// and opening it does not block.
class RegularFile {
 public:
  /// Opens a file. An error is one line: which file, what is wrong, what to do.
  static Result<RegularFile> Open(const std::filesystem::path& file);
  RegularFile(RegularFile&& other) noexcept;
  RegularFile& operator=(RegularFile&& other) noexcept;
  ~RegularFile();

  std::uintmax_t size() const noexcept { return size_; }  // size when it was opened, bytes
  /// Returns the file's descriptor, which this object keeps.
  int descriptor() const noexcept { return descriptor_; }
  /// Reads the bytes from `at` on into `bytes`, as far as there are any; returns their number.
  std::size_t Read(std::uintmax_t at, std::span<char> bytes) const;

 private:
  RegularFile(int descriptor, std::uintmax_t size) : descriptor_(descriptor), size_(size) {}
  int descriptor_ = -1;
  std::uintmax_t size_ = 0;
};

/// Reads all bytes of a regular file of at most `most` bytes.
Result<std::string> ReadWholeFile(const std::filesystem::path& file, std::uintmax_t most);

/// Goes through the lines of a regular file, none of which may be longer than `longest` bytes.
class LineReader {
 public:
  LineReader(RegularFile file, std::size_t longest) : file_(std::move(file)), longest_(longest) {}

  /// Takes the next line, without its end; false: there is none, or it is too long.
  bool Next(std::string& line);
  /// Tells whether the last line taken had an end.
  bool ended() const noexcept { return ended_; }
  bool too_long() const noexcept { return too_long_; }

 private:
  RegularFile file_;
  std::size_t longest_;
  std::uintmax_t at_ = 0;  // place in the file behind block_
  std::string block_;      // read, and not yet taken
  std::size_t begin_ = 0;  // start of what is not yet taken
  bool ended_ = true;
  bool too_long_ = false;
};

/// Returns `text` as one line of plain text for a person: without control characters and line
/// breaks, and cut after `most` bytes. Bytes that are not UTF-8 become '?'.
std::string PlainLine(std::string_view text, std::size_t most = 400);
/// Tells whether `text` is valid UTF-8 without control characters and without marks that change the
/// direction of writing.
bool IsPlainText(std::string_view text);

}  // namespace tandem
