#include "tests/fuzz/mutator.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <string_view>
#include <utility>

namespace tandem {

namespace {

constexpr std::size_t kLargest = 1 << 16;
constexpr std::array<std::string_view, 34> kWords{"null",
                                                  "true",
                                                  "-1",
                                                  "0",
                                                  "1e308",
                                                  "-1e308",
                                                  "1e-308",
                                                  "1e999",
                                                  "4294967295",
                                                  "2147483648",
                                                  "9223372036854775807",
                                                  "18446744073709551616",
                                                  "0.5",
                                                  "[]",
                                                  "{}",
                                                  "[[[[[[[[",
                                                  "{\"a\":",
                                                  "\"\"",
                                                  "\\u0000",
                                                  "\\ud800",
                                                  "\xff",
                                                  "\x1b[31m",
                                                  "\xc2\x9b",
                                                  "\n",
                                                  ",",
                                                  ":",
                                                  "nan",
                                                  "inf",
                                                  "/dev/zero",
                                                  "../../..",
                                                  "\"json\"",
                                                  "<a>",
                                                  "&amp;",
                                                  "#"};
constexpr std::array<std::uint64_t, 12> kNumbers{
    0,
    1,
    0x7F,
    0xFF,
    0x7FFF,
    0xFFFF,
    0x7FFFFFFF,
    0x80000000,
    0xFFFFFFFF,
    0x7FFFFFFFFFFFFFFF,
    0x7FF8000000000000,
    0x7FEFFFFFFFFFFFFF};  // the last two: no number, the largest double

}  // namespace

Mutator::Mutator(std::vector<std::string> seeds, std::uint64_t seed)
    : seeds_(std::move(seeds)), random_(seed) {
  seeds_.emplace_back();
}

std::size_t Mutator::Below(std::size_t n) {
  return n == 0 ? 0 : static_cast<std::size_t>(random_() % n);
}

void Mutator::PutNumber(std::string& bytes) {
  // a number of a text becomes another one; without a number, bytes do
  const std::size_t digit = bytes.find_first_of("0123456789", Below(bytes.size()));
  if (Below(2) == 0 && digit != std::string::npos) {
    std::size_t end = bytes.find_first_not_of("0123456789.eE+-", digit);
    end = std::min(end, bytes.size());
    bytes.replace(digit, end - digit, kWords[1 + Below(12)]);
    return;
  }
  const std::uint64_t number = kNumbers[Below(kNumbers.size())];
  const std::size_t size = std::size_t{1} << Below(4);
  if (bytes.size() < size) return;
  std::memcpy(&bytes[Below(bytes.size() - size + 1)], &number, size);
}

void Mutator::Change(std::string& bytes) {
  const std::size_t at = Below(bytes.size() + 1);
  const std::size_t length = std::min(Below(1 + Below(64)), bytes.size() - at);
  switch (Below(8)) {
    case 0:
      if (at < bytes.size()) bytes[at] = static_cast<char>(bytes[at] ^ (1 << Below(8)));
      return;
    case 1:
      if (at < bytes.size()) bytes[at] = static_cast<char>(random_());
      return;
    case 2:
      bytes.erase(at, length);
      return;
    case 3:
      bytes.insert(at, bytes.substr(at, length));
      return;
    case 4:
      bytes.insert(at, kWords[Below(kWords.size())]);
      return;
    case 5:
      PutNumber(bytes);
      return;
    case 6: {
      const std::string& other = seeds_[Below(seeds_.size())];
      const std::size_t from = Below(other.size());
      bytes.replace(at, length, other.substr(from, Below(256)));
      return;
    }
    default:
      if (Below(8) == 0) {
        bytes.resize(at);
      } else if (length > 0 && bytes.size() < kLargest / 2) {
        const std::string piece = bytes.substr(at, length);
        for (std::size_t i = Below(64); i > 0; --i) bytes.insert(at, piece);
      }
  }
}

std::string Mutator::Next() {
  std::string bytes = seeds_[Below(seeds_.size())];
  for (std::size_t changes = 1 + Below(8); changes > 0; --changes) Change(bytes);
  if (bytes.size() > kLargest) bytes.resize(kLargest);
  return bytes;
}

}  // namespace tandem
