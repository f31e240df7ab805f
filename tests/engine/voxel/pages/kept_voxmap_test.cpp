#include "engine/voxel/pages/kept_voxmap.h"

#include <cstring>
#include <fstream>
#include <functional>
#include <iterator>
#include <span>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <zstd.h>

#include "engine/base/files/block_file.h"
#include "engine/base/hash.h"
#include "engine/voxel/pages/computed_pages.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/shapes.h"

namespace tandem {
namespace {

namespace fs = std::filesystem;

constexpr BlockFileSources kKey{{1}, {2}};

/// Returns two balls, whose voxels touch, in several hyperchunks.
TriangleMesh Balls() {
  TriangleMesh mesh = testing::Sphere(0.5, 4);
  Append(mesh, testing::At(testing::Sphere(0.3, 3), Vec3(0.85, 0.1, 0)));
  return mesh;
}

std::string TextOf(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

void Overwrite(const fs::path& file, const std::string& text) {
  std::ofstream(file, std::ios::binary) << text;
}

class KeptVoxmapTest : public ::testing::Test {
 protected:
  Voxmap Kept(const VoxelizeOptions& options) {
    Result<Voxmap> made = Voxelize(Balls(), options);
    EXPECT_TRUE(made);
    EXPECT_FALSE(KeepVoxmap(*made, kKey, file_));
    return std::move(*made);
  }

  ScratchFolder scratch_;
  const fs::path file_ = scratch_.path() / "kept";
};

TEST_F(KeptVoxmapTest, LoadsTheSameBytesForMarksOfAnySize) {
  for (const auto& [range, bits] : {std::pair{1, 2}, {8, 4}, {20, 8}}) {
    const Voxmap made = Kept({.voxel_size = 0.006, .range = range, .bits = bits});
    const Result<Voxmap> loaded = LoadKeptVoxmap(file_, kKey);
    ASSERT_TRUE(loaded) << loaded.error().what;
    ASSERT_EQ(loaded->header().bytes, made.header().bytes);
    EXPECT_EQ(std::memcmp(&loaded->header(), &made.header(), made.header().bytes), 0) << bits;
  }
}

TEST_F(KeptVoxmapTest, PagesComposeTheMap) {
  const Voxmap made = Kept({.voxel_size = 0.006});
  const auto pages = OpenKeptVoxmap(file_, kKey);
  ASSERT_TRUE(pages) << pages.error().what;
  const Voxmap& outline = (*pages)->outline();
  ASSERT_EQ(outline.header().record_count, made.header().record_count);
  EXPECT_EQ((*pages)->counts().total(), made.Count().total());
  const auto& size = made.header().size;
  std::size_t compared = 0;
  for (std::uint32_t c = 0; c < size[0] * size[1] * size[2]; ++c) {
    const std::uint32_t record = made.index()[c];
    ASSERT_EQ(outline.index()[c], record);
    EXPECT_EQ(outline.records()[record].chunk_marks, made.records()[record].chunk_marks);
    EXPECT_EQ(outline.records()[record].solid, made.records()[record].solid);
    if (!(*pages)->HasPage(record)) continue;
    VoxelPage page;
    ASSERT_FALSE((*pages)->Read(record, page));
    std::size_t next = 0;
    for (std::size_t f = 0; f < kFields; ++f) {
      for (std::size_t z = 0; z < 8; ++z) {
        const VoxmapSlice& slice = made.records()[record].slices[f][z];
        ASSERT_EQ(page.stored[f][z], slice.stored);
        for (std::uint32_t p = 0; p < CountBits(slice.stored); ++p, ++next) {
          for (std::size_t q = 0; q < kQuarters; ++q) {
            const std::uint16_t number = page.planes[next][q];
            const std::uint32_t whole = made.planes()[slice.first_plane + p].quarters[q];
            if (number < 2 || whole < 2) {
              ASSERT_EQ(number, whole);
              continue;
            }
            ASSERT_EQ(
                std::memcmp(&page.quarters[(number - 2U) * made.quarter_bytes()],
                            made.quarters() + whole * made.quarter_bytes(), made.quarter_bytes()),
                0);
            ++compared;
          }
        }
      }
    }
    EXPECT_EQ(next, page.planes.size());
  }
  EXPECT_GT(compared, 10000U);
}

TEST_F(KeptVoxmapTest, PartsGiveTheSameVoxels) {
  const TriangleMesh mesh = Balls();
  VoxelizeOptions options{.voxel_size = 0.003};
  const Result<Voxmap> whole = Voxelize(mesh, options);
  ASSERT_TRUE(whole);
  options.max_memory_bytes = EstimateVoxelizeBytes(mesh, options) / 2;
  int parts = 0;
  ASSERT_FALSE(VoxelizeInParts(mesh, options, [&](const Voxmap&) {
    ++parts;
    return std::optional<Error>();
  }));
  EXPECT_GT(parts, 2);
  ASSERT_FALSE(KeepVoxmap(mesh, options, file_));
  const Result<Voxmap> loaded = LoadKeptVoxmap(file_, KeyOf(mesh, options));
  ASSERT_TRUE(loaded) << loaded.error().what;
  EXPECT_EQ(loaded->Digest(), whole->Digest());
  EXPECT_EQ(loaded->Count().band, whole->Count().band);
  EXPECT_EQ(loaded->Count().total(), whole->Count().total());
  const auto& size = whole->header().size;
  const auto chunks = [&size](std::size_t axis) {
    return static_cast<std::int32_t>(8 * size[axis]);
  };
  for (std::int32_t z = 0; z < chunks(2); ++z) {
    for (std::int32_t y = 0; y < chunks(1); ++y) {
      for (std::int32_t x = 0; x < chunks(0); ++x) {
        ASSERT_EQ(loaded->ChunkValue({x, y, z}), whole->ChunkValue({x, y, z}));
      }
    }
  }
}

/// Returns the marks of a page, quarter by quarter.
std::string MarksOf(const VoxelPage& page, const Voxmap& outline) {
  const std::size_t bytes = outline.quarter_bytes();
  std::string marks;
  for (const auto& plane : page.planes) {
    for (const std::uint16_t number : plane) {
      const auto* from = number < 2 ? outline.quarters() + number * bytes
                                    : page.quarters.data() + (number - 2U) * bytes;
      marks.append(reinterpret_cast<const char*>(from), bytes);
    }
  }
  return marks;
}

TEST_F(KeptVoxmapTest, ComputedPagesEqualStoredPages) {
  const TriangleMesh mesh = Balls();
  for (const auto& [range, bits] : {std::pair{1, 2}, {8, 4}, {20, 8}}) {
    const VoxelizeOptions options{.voxel_size = 0.006, .range = range, .bits = bits};
    ASSERT_FALSE(KeepVoxmap(mesh, options, file_));
    const auto kept = OpenKeptVoxmap(file_, KeyOf(mesh, options));
    const auto computed = ComputePages(mesh, options);
    ASSERT_TRUE(kept && computed);
    const Voxmap& outline = (*kept)->outline();
    ASSERT_EQ((*computed)->outline().header().record_count, outline.header().record_count);
    EXPECT_EQ((*computed)->outline().Digest(), outline.Digest());
    EXPECT_EQ((*computed)->counts().band, (*kept)->counts().band);
    EXPECT_EQ((*computed)->counts().total(), (*kept)->counts().total());
    int pages = 0;
    for (std::uint32_t r = 0; r < outline.header().record_count; ++r) {
      EXPECT_EQ((*computed)->outline().records()[r].chunk_marks, outline.records()[r].chunk_marks);
      ASSERT_EQ((*computed)->HasPage(r), (*kept)->HasPage(r));
      if (!(*kept)->HasPage(r)) continue;
      VoxelPage a;
      VoxelPage b;
      ASSERT_FALSE((*kept)->Read(r, a));
      ASSERT_FALSE((*computed)->Read(r, b));
      ASSERT_EQ(a.stored, b.stored);
      ASSERT_TRUE(MarksOf(a, outline) == MarksOf(b, outline)) << r;
      ++pages;
    }
    EXPECT_GT(pages, 20);
  }
}

TEST_F(KeptVoxmapTest, RefusesOtherFiles) {
  Kept({.voxel_size = 0.01});
  const std::string whole = TextOf(file_);
  const auto refused = [&](const std::string& text, const std::string& word) {
    Overwrite(file_, text);
    const auto loaded = LoadKeptVoxmap(file_, kKey);
    ASSERT_FALSE(loaded);
    EXPECT_NE(loaded.error().what.find(word), std::string::npos) << loaded.error().what;
    EXPECT_TRUE(KeptVoxmapFault(file_));
  };
  refused(whole.substr(0, 100), "too short");
  refused(whole.substr(0, whole.size() - 1), "cut short");
  refused(whole.substr(1), "damaged");
  Overwrite(file_, whole);
  EXPECT_FALSE(LoadKeptVoxmap(file_, {1, 3}));
  EXPECT_FALSE(OpenKeptVoxmap(file_, {7, 2}));
  EXPECT_FALSE(LoadKeptVoxmap(scratch_.path() / "none", kKey));
  EXPECT_FALSE(KeptVoxmapFault(file_));
}

// places of the parts of a tail
constexpr std::size_t kTail = 288;
constexpr std::size_t kOutlineAt = 216;
constexpr std::size_t kIndexBytes = 224;
constexpr std::size_t kOutlineSum = 272;

std::uint64_t WordAt(const std::string& text, std::size_t at) {
  std::uint64_t word = 0;
  std::memcpy(&word, &text[at], sizeof word);
  return word;
}

/// Changes the index of a sound file and signs it as if it were sound.
std::string WithIndex(const std::string& whole,
                      const std::function<void(std::vector<std::uint32_t>&)>& change) {
  std::string tail = whole.substr(whole.size() - kTail);
  const std::uint64_t outline = WordAt(tail, kOutlineAt);
  const std::string packed = whole.substr(outline, WordAt(tail, kIndexBytes));
  std::vector<std::uint32_t> index(ZSTD_getFrameContentSize(packed.data(), packed.size()) / 4);
  ZSTD_decompress(index.data(), 4 * index.size(), packed.data(), packed.size());
  change(index);
  std::string anew(ZSTD_compressBound(4 * index.size()), '\0');
  anew.resize(ZSTD_compress(anew.data(), anew.size(), index.data(), 4 * index.size(), 1));
  const std::string rest =
      whole.substr(outline + packed.size(), whole.size() - kTail - outline - packed.size());
  const std::string all = anew + rest;
  const std::uint64_t bytes = anew.size();
  std::memcpy(&tail[kIndexBytes], &bytes, sizeof bytes);
  const std::uint64_t outline_sum = HashOfMany(std::as_bytes(std::span(all)));
  std::memcpy(&tail[kOutlineSum], &outline_sum, sizeof outline_sum);
  Hash64 hash;
  hash.AddBytes(tail.data(), kTail - sizeof(std::uint64_t));
  const std::uint64_t sum = hash.value();
  std::memcpy(&tail[kTail - sizeof sum], &sum, sizeof sum);
  return whole.substr(0, outline) + all + tail;
}

TEST_F(KeptVoxmapTest, SignedFilesAreStillValidated) {
  Kept({.voxel_size = 0.01});
  const std::string whole = TextOf(file_);
  Overwrite(file_, WithIndex(whole, [](std::vector<std::uint32_t>&) {}));
  ASSERT_TRUE(LoadKeptVoxmap(file_, kKey));
  Overwrite(file_, WithIndex(whole, [](std::vector<std::uint32_t>& index) {
              index[0] = 0x7FFFFFFF;  // outside of the map
            }));
  const auto loaded = LoadKeptVoxmap(file_, kKey);
  ASSERT_FALSE(loaded);
  EXPECT_NE(loaded.error().what.find("damaged"), std::string::npos) << loaded.error().what;
}

TEST_F(KeptVoxmapTest, DamagedPageIsRefusedOnReading) {
  Kept({.voxel_size = 0.01});
  std::string text = TextOf(file_);
  text[20] = static_cast<char>(text[20] ^ 4);  // in the first page
  Overwrite(file_, text);
  const auto pages = OpenKeptVoxmap(file_, kKey);
  ASSERT_TRUE(pages);
  int refused = 0;
  for (std::uint32_t r = 2; r < (*pages)->outline().header().record_count; ++r) {
    VoxelPage page;
    if ((*pages)->HasPage(r) && (*pages)->Read(r, page)) ++refused;
  }
  EXPECT_EQ(refused, 1);
  EXPECT_FALSE(LoadKeptVoxmap(file_, kKey));
}

}  // namespace
}  // namespace tandem
