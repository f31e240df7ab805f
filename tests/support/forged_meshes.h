#pragma once

#include <array>
#include <cstring>
#include <string>
#include <string_view>

namespace tandem::testing {

/// Returns a tetrahedron with three edges of length `side` as a binary STL file.
inline std::string TetrahedronStl(float side, std::string_view header) {
  const std::array<std::array<float, 3>, 4> corners{
      {{0, 0, 0}, {side, 0, 0}, {0, side, 0}, {0, 0, side}}};
  const std::array<std::array<std::size_t, 3>, 4> faces{
      {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}};
  std::string file(header);
  file.resize(80, '\0');
  file += std::string("\x04\0\0\0", 4);
  for (const auto& face : faces) {
    std::array<float, 12> numbers{};  // a normal, which readers compute, and three corners
    for (std::size_t k = 0; k < 9; ++k) numbers[3 + k] = corners[face[k / 3]][k % 3];
    char bytes[50]{};
    std::memcpy(bytes, numbers.data(), sizeof numbers);
    file.append(bytes, sizeof bytes);
  }
  return file;
}

/// A mesh, and another of twice its size whose bytes have the same FNV-1a hash.
///
/// A hash (h ^ b) * P is one of h + d for a small d that the lowest byte of h bounds. So the last
/// 26 bytes of the header solve a linear equation modulo 2^64 by small numbers, which the reduced
/// basis of a lattice of dimension 26 gives (LLL, then the nearest plane). It took a second.
inline std::string HonestStl() {
  return TetrahedronStl(0.1F, "");
}
inline std::string ForgedStl() {
  constexpr std::array<unsigned char, 26> kFound{4, 2, 15, 1, 63, 6, 3, 1, 0, 1, 6, 1,  7,
                                                 0, 0, 1,  2, 1,  7, 0, 7, 7, 0, 0, 14, 1};
  std::string header(80, '\0');
  header[0] = 1;
  for (std::size_t i = 0; i < kFound.size(); ++i) {
    header[54 + i] = static_cast<char>(kFound[i]);
  }
  return TetrahedronStl(0.2F, header);
}

}  // namespace tandem::testing
