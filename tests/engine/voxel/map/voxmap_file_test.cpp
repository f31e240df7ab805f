#include "engine/voxel/map/voxmap_file.h"

#include <cstring>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <sys/stat.h>

#include "engine/voxel/build/voxelize.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/shapes.h"

namespace tandem {
namespace {

std::filesystem::path FileFor(const char* name) {
  return std::filesystem::path(::testing::TempDir()) / name;
}

std::vector<char> BytesOf(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

void Write(const std::filesystem::path& file, const std::vector<char>& bytes) {
  std::ofstream(file, std::ios::binary)
      .write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

void ExpectRefused(const std::vector<char>& bytes, const std::string& word) {
  const std::filesystem::path file = FileFor("refused.voxmap");
  Write(file, bytes);
  const Result<Voxmap> map = MapVoxmap(file);
  ASSERT_FALSE(map) << word;
  EXPECT_NE(map.error().what.find(word), std::string::npos) << map.error().what;
}

TEST(VoxmapFile, RoundTrips) {
  const Result<Voxmap> made = Voxelize(testing::Sphere(0.5, 3), {.voxel_size = 0.02});
  ASSERT_TRUE(made);
  const std::filesystem::path file = FileFor("saved.voxmap");
  ASSERT_FALSE(SaveVoxmap(*made, file));
  const Result<Voxmap> mapped = MapVoxmap(file);
  ASSERT_TRUE(mapped) << mapped.error().what;
  EXPECT_EQ(mapped->Digest(), made->Digest());
  EXPECT_EQ(mapped->Count().band, made->Count().band);
}

TEST(VoxmapFile, RefusesIncompleteFiles) {
  const Result<Voxmap> made = Voxelize(testing::Sphere(0.5, 3), {.voxel_size = 0.02});
  ASSERT_TRUE(made);
  const std::filesystem::path file = FileFor("whole.voxmap");
  ASSERT_FALSE(SaveVoxmap(*made, file));
  const std::vector<char> whole = BytesOf(file);

  EXPECT_FALSE(MapVoxmap(FileFor("there_is_none.voxmap")));
  ExpectRefused({}, "empty");
  ExpectRefused({whole.begin(), whole.begin() + 50}, "too short");
  ExpectRefused({whole.begin(), whole.end() - 1}, "cut short");
  std::vector<char> other = whole;
  other[0] = 'x';
  ExpectRefused(other, "not a voxmap");
  other = whole;
  other[8] = 99;
  ExpectRefused(other, "version");
  // an index or a record that points outside
  const VoxmapHeader& header = made->header();
  other = whole;
  std::memset(&other[header.index_offset], 0xff, 4);
  ExpectRefused(other, "damaged");
  other = whole;
  std::memset(&other[header.records_offset + 2 * sizeof(VoxmapRecord)], 0xff, 16);
  ExpectRefused(other, "damaged");
  other = whole;
  std::memset(&other[header.planes_offset + 2 * sizeof(VoxmapPlane)], 0xff, 4);
  ExpectRefused(other, "damaged");
  other = whole;
  std::memset(&other[offsetof(VoxmapHeader, size)], 0xff, 4);
  ExpectRefused(other, "damaged");
}

// Sums of such places wrap round to small ones, which the image would have.
TEST(VoxmapFile, RefusesOffsetsOutsideTheFile) {
  const Result<Voxmap> made = Voxelize(testing::Sphere(0.5, 3), {.voxel_size = 0.02});
  ASSERT_TRUE(made);
  const std::filesystem::path file = FileFor("places.voxmap");
  ASSERT_FALSE(SaveVoxmap(*made, file));
  const std::vector<char> whole = BytesOf(file);
  const auto with = [&](std::size_t field, std::uint64_t place) {
    std::vector<char> other = whole;
    std::memcpy(&other[field], &place, sizeof place);
    return other;
  };
  ExpectRefused(with(offsetof(VoxmapHeader, records_offset), -std::uint64_t{1024}), "damaged");
  const std::uint64_t behind = (whole.size() / 64 + 1) * 64;
  for (const std::size_t field :
       {offsetof(VoxmapHeader, index_offset), offsetof(VoxmapHeader, records_offset),
        offsetof(VoxmapHeader, quarters_offset), offsetof(VoxmapHeader, planes_offset)}) {
    ExpectRefused(with(field, behind), "damaged");
    ExpectRefused(with(field, -std::uint64_t{64}), "damaged");
  }
}

TEST(VoxmapFile, FollowsNoPlantedSymbolicLink) {
  const Result<Voxmap> made = Voxelize(testing::Sphere(0.5, 3), {.voxel_size = 0.02});
  ASSERT_TRUE(made);
  const ScratchFolder scratch;
  const std::filesystem::path victim = scratch.Write("victim", "precious");
  const std::filesystem::path file = scratch.path() / "out.voxmap";
  std::filesystem::create_symlink(victim, scratch.path() / "out.voxmap.unfinished");
  ASSERT_FALSE(SaveVoxmap(*made, file));
  EXPECT_EQ(std::filesystem::file_size(victim), 8U);
  EXPECT_TRUE(std::filesystem::is_regular_file(std::filesystem::symlink_status(file)));
  EXPECT_EQ(MapVoxmap(file)->Digest(), made->Digest());
}

TEST(VoxmapFile, ReplacesOnlyRegularFiles) {
  const Result<Voxmap> made = Voxelize(testing::Sphere(0.5, 3), {.voxel_size = 0.02});
  ASSERT_TRUE(made);
  const ScratchFolder scratch;
  const std::filesystem::path pipe = scratch.path() / "pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  const std::optional<Error> fault = SaveVoxmap(*made, pipe);
  ASSERT_TRUE(fault);
  EXPECT_EQ(fault->what, pipe.string() + ": is not a regular file: name another");
  EXPECT_TRUE(std::filesystem::is_fifo(pipe));
}

}  // namespace
}  // namespace tandem
