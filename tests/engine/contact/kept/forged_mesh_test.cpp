#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>

#include <gtest/gtest.h>

#include "engine/base/files/block_file.h"
#include "engine/contact/kept/voxel_cache.h"
#include "tests/support/scratch_folder.h"

namespace tandem {
namespace {

namespace fs = std::filesystem;

/// Returns a flat grid of triangles as a binary STL file of 2.5 MB.
std::string GridStl() {
  constexpr int kSide = 160;
  std::string file(80, '\0');
  const std::uint32_t count = 2 * kSide * kSide;
  file.append(reinterpret_cast<const char*>(&count), sizeof count);
  for (std::uint32_t i = 0; i < count; ++i) {
    const auto x = static_cast<float>(i / 2 % kSide);
    const auto y = static_cast<float>(i / 2 / kSide);
    const float upper = i % 2 == 0 ? 0.0F : 1.0F;
    const std::array<float, 12> numbers{0, 0, 0, x + upper, y + upper, 0, x + 1, y, 0, x, y + 1, 0};
    char bytes[50]{};
    std::memcpy(bytes, numbers.data(), sizeof numbers);
    file.append(bytes, sizeof bytes);
  }
  return file;
}

/// Moves a corner, and makes up for it in a normal, which readers compute: a file with the same
/// HashOfMany(), whose eight rows of words do not mix.
std::string ForgedGrid(std::string file) {
  const auto word_at = [&file](std::size_t at) {
    std::uint64_t word = 0;
    std::memcpy(&word, &file[at], sizeof word);
    return word;
  };
  const auto turned = [](std::uint64_t sum) {
    return std::rotl(sum * 0x9e3779b97f4a7c15ULL, 29);
  };
  // the first coordinate, of a triangle, that begins a word; then a normal with a word of its row
  std::size_t corner = 84 + 12;
  while (corner % 8 != 0) corner += 50;
  std::size_t normal = corner - 12 + 50;
  const auto has_word = [&](std::size_t from) {
    return (from + 7) / 8 * 8 + 8 <= from + 12 && (from + 7) / 8 * 8 % 64 == corner % 64;
  };
  while (!has_word(normal)) normal += 50;
  const std::size_t made_up = (normal + 7) / 8 * 8;
  const std::uint64_t moved = word_at(corner) ^ 0x00100000;
  std::uint64_t before = corner % 64 / 8 + 1;
  std::uint64_t after = before;
  for (std::size_t at = corner % 64; at < made_up; at += 64) {
    before = turned(before ^ word_at(at));
    after = turned(after ^ (at == corner ? moved : word_at(at)));
  }
  const std::uint64_t word = word_at(made_up) ^ before ^ after;
  std::memcpy(&file[corner], &moved, sizeof moved);
  std::memcpy(&file[made_up], &word, sizeof word);
  return file;
}

// A forged mesh in the cache must not change what an honest one becomes.
TEST(VoxelCache, ForgedMeshOfTheSameHashIsAnotherMesh) {
  const ScratchFolder scratch;
  const VoxelCache cache(scratch.path() / "cache");
  fs::create_directories(scratch.path() / "honest");
  fs::create_directories(scratch.path() / "forged");
  const std::string grid = GridStl();
  const std::string forged = ForgedGrid(grid);
  const auto hash_of = [](const std::string& text) {
    return HashOfMany(std::as_bytes(std::span(text)));
  };
  ASSERT_NE(forged, grid);
  ASSERT_EQ(hash_of(forged), hash_of(grid));
  const auto kept = cache.MeshOf(scratch.Write("forged/grid.stl", forged), {});
  ASSERT_TRUE(kept) << kept.error().what;
  ASSERT_EQ(cache.Files().size(), 1U);
  const auto honest = cache.MeshOf(scratch.Write("honest/grid.stl", grid), {});
  ASSERT_TRUE(honest) << honest.error().what;
  EXPECT_NE(honest->mesh.vertices, kept->mesh.vertices);
  EXPECT_EQ(cache.Files().size(), 2U);
}

}  // namespace
}  // namespace tandem
