#include "engine/base/files/regular_file.h"

#include <algorithm>
#include <cerrno>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace tandem {

namespace {

constexpr std::size_t kReadBlock = 1 << 16;

std::string WhyNotOpened(int error) {
  if (error == ENOENT) return "there is no such file";
  if (error == ENXIO) return "is not a regular file: name a file";
  return "cannot be opened: " + std::generic_category().message(error);
}

/// A symbol of a text: its bytes, and whether a person may see it. 0 bytes: no UTF-8.
struct Symbol {
  std::size_t bytes = 0;
  bool plain = false;
};

Symbol SymbolAt(std::string_view text, std::size_t at) {
  const auto byte = [&](std::size_t i) {
    return at + i < text.size() ? static_cast<unsigned char>(text[at + i]) : 0U;
  };
  const unsigned first = byte(0);
  if (first < 0x80) return {1, first >= 0x20 && first != 0x7F};
  const std::size_t bytes = first >= 0xF0 ? 4 : first >= 0xE0 ? 3 : 2;
  if (first < 0xC2 || first > 0xF4) return {};
  unsigned code = first & (0x7FU >> bytes);
  for (std::size_t i = 1; i < bytes; ++i) {
    if ((byte(i) & 0xC0U) != 0x80) return {};
    code = (code << 6U) | (byte(i) & 0x3FU);
  }
  constexpr unsigned kLeast[] = {0, 0, 0x80, 0x800, 0x10000};
  if (code < kLeast[bytes] || code > 0x10FFFF || (code >= 0xD800 && code < 0xE000)) return {};
  const bool control = code < 0xA0 || code == 0x2028 || code == 0x2029;
  const bool turns = code == 0x200E || code == 0x200F || code == 0x061C ||
                     (code >= 0x202A && code <= 0x202E) || (code >= 0x2066 && code <= 0x2069);
  return {bytes, !control && !turns};
}

}  // namespace

Result<RegularFile> RegularFile::Open(const std::filesystem::path& file) {
  const std::string name = PlainLine(file.native());
  const int descriptor = open(file.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC | O_NOCTTY);
  if (descriptor < 0) return Error{name + ": " + WhyNotOpened(errno)};
  struct stat status {};
  const bool known = fstat(descriptor, &status) == 0;
  RegularFile opened(descriptor, known ? static_cast<std::uintmax_t>(status.st_size) : 0);
  if (known && S_ISDIR(status.st_mode)) {
    return Error{name + ": cannot be read: it is a folder, name a file in it"};
  }
  if (!known || !S_ISREG(status.st_mode)) {
    return Error{name + ": cannot be read: it is not a regular file, name a file"};
  }
  return opened;
}

RegularFile::RegularFile(RegularFile&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)), size_(other.size_) {}

RegularFile& RegularFile::operator=(RegularFile&& other) noexcept {
  std::swap(descriptor_, other.descriptor_);
  std::swap(size_, other.size_);
  return *this;
}

RegularFile::~RegularFile() {
  if (descriptor_ >= 0) close(descriptor_);
}

std::size_t RegularFile::Read(std::uintmax_t at, std::span<char> bytes) const {
  std::size_t got = 0;
  while (got < bytes.size()) {
    const ssize_t size =
        pread(descriptor_, bytes.data() + got, bytes.size() - got, static_cast<off_t>(at + got));
    if (size < 0 && errno == EINTR) continue;
    if (size <= 0) break;
    got += static_cast<std::size_t>(size);
  }
  return got;
}

Result<std::string> ReadWholeFile(const std::filesystem::path& file, std::uintmax_t most) {
  const Result<RegularFile> opened = RegularFile::Open(file);
  if (!opened) return opened.error();
  const auto too_large = [&] {
    return Error{PlainLine(file.native()) + ": is larger than " + std::to_string(most >> 20U) +
                 " MiB, which no file of this kind is: name another file"};
  };
  if (opened->size() > most) return too_large();
  // the file may grow meanwhile, and files that the system generates have no size
  std::string text;
  while (text.size() <= most) {
    const std::size_t before = text.size();
    text.resize(before +
                std::max<std::size_t>(
                    kReadBlock, opened->size() - std::min<std::uintmax_t>(before, opened->size())));
    const std::size_t got =
        opened->Read(before, std::span(text.data() + before, text.size() - before));
    text.resize(before + got);
    if (got == 0) return text;
  }
  return too_large();
}

bool LineReader::Next(std::string& line) {
  line.clear();
  if (too_long_) return false;
  while (true) {
    const std::size_t end = block_.find('\n', begin_);
    const std::size_t stop = std::min(end, block_.size());
    line.append(block_, begin_, stop - begin_);
    if (line.size() > longest_) {
      too_long_ = true;
      return false;
    }
    begin_ = end == std::string::npos ? stop : end + 1;
    ended_ = end != std::string::npos;
    if (ended_) return true;
    block_.resize(kReadBlock);
    block_.resize(file_.Read(at_, std::span(block_.data(), block_.size())));
    at_ += block_.size();
    begin_ = 0;
    if (block_.empty()) return !line.empty();
  }
}

std::string PlainLine(std::string_view text, std::size_t most) {
  std::string line;
  for (std::size_t at = 0; at < text.size();) {
    const Symbol symbol = SymbolAt(text, at);
    const std::size_t bytes = std::max<std::size_t>(symbol.bytes, 1);
    if (line.size() + bytes > most) return line + "...";
    if (symbol.plain) {
      line.append(text, at, bytes);
    } else {
      line += symbol.bytes == 1 && (text[at] == '\n' || text[at] == '\t' || text[at] == '\r') ? ' '
                                                                                              : '?';
    }
    at += bytes;
  }
  return line;
}

bool IsPlainText(std::string_view text) {
  for (std::size_t at = 0; at < text.size();) {
    const Symbol symbol = SymbolAt(text, at);
    if (symbol.bytes == 0 || !symbol.plain) return false;
    at += symbol.bytes;
  }
  return true;
}

}  // namespace tandem
