// Tests that a surface's file with altered bytes is refused, or harms nobody.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <random>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <sys/mman.h>

#include "engine/base/check.h"
#include "engine/contact/features/feature_image.h"
#include "engine/field/query/field_image.h"
#include "tests/engine/contact/kept/surface_file_fixture.h"

namespace tandem {
namespace {

using testing::SurfaceFile;

TEST_F(SurfaceFile, AnyAlteredHeaderFieldIsRefused) {
  const Bytes whole = SavedBytes(box_);
  const std::string damaged = "a damaged surface; voxelize its mesh again";
  const auto with = [&whole](std::size_t at) {
    Bytes other = whole;
    other[at] ^= std::byte{1};
    return other;
  };
  EXPECT_EQ(FaultOf(with(offsetof(BlockFileHeader, magic))), "not a surface");
  EXPECT_NE(FaultOf(with(offsetof(BlockFileHeader, bytes))).find("cut short"), std::string::npos);
  for (const std::size_t field :
       {offsetof(BlockFileHeader, unused), offsetof(BlockFileHeader, checksum),
        offsetof(BlockFileHeader, mesh), offsetof(BlockFileHeader, settings),
        offsetof(BlockFileHeader, voxel_size), offsetof(BlockFileHeader, block_bytes),
        offsetof(BlockFileHeader, block_bytes) + 8}) {
    EXPECT_EQ(FaultOf(with(field)), damaged) << field;
  }
  // with a sound sum the fields are refused, too, that say how the file is divided
  for (const std::size_t field :
       {offsetof(BlockFileHeader, voxel_size), offsetof(BlockFileHeader, block_bytes),
        offsetof(BlockFileHeader, block_bytes) + 8}) {
    EXPECT_EQ(FaultOf(Signed(with(field))), damaged) << field;
    Bytes most = whole;
    Set(most, field, ~std::uint64_t{0});
    EXPECT_EQ(FaultOf(Signed(most)), damaged) << field;
  }
}

TEST_F(SurfaceFile, AnyFlippedBitIsRefused) {
  const Bytes whole = SavedBytes(box_);
  std::mt19937_64 random(1);
  for (int i = 0; i < 1000; ++i) {
    Bytes other = whole;
    other[random() % whole.size()] ^= static_cast<std::byte>(1U << random() % 8);
    ASSERT_NE(FaultOf(other), "");
  }
}

/// Bytes before a page that nobody may read, from a cache line on.
class GuardedBytes {
 public:
  explicit GuardedBytes(std::span<const std::byte> bytes) : size_(bytes.size()) {
    whole_ = (size_ + kPage - 1) / kPage * kPage;
    memory_ = static_cast<std::byte*>(
        mmap(nullptr, whole_ + kPage, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0));
    TANDEM_CHECK(memory_ != MAP_FAILED);
    TANDEM_CHECK(mprotect(memory_ + whole_, kPage, PROT_NONE) == 0);
    begin_ = memory_ + (whole_ - size_) / 64 * 64;
    std::memcpy(begin_, bytes.data(), size_);
  }
  ~GuardedBytes() { munmap(memory_, whole_ + kPage); }
  GuardedBytes(const GuardedBytes&) = delete;
  GuardedBytes& operator=(const GuardedBytes&) = delete;

  std::span<std::byte> bytes() const { return {begin_, size_}; }
  ImageBlock block() const { return {nullptr, {begin_, size_}}; }

 private:
  static constexpr std::size_t kPage = 4096;
  std::size_t size_;
  std::size_t whole_ = 0;
  std::byte* memory_ = nullptr;
  std::byte* begin_ = nullptr;
};

TEST_F(SurfaceFile, ReadersNeverLeaveAllocatedBlocks) {
  const BodySurface made = Made(box_);
  std::mt19937_64 random(3);
  int taken = 0;
  for (int i = 0; i < 600; ++i) {
    const GuardedBytes field(made.field.bytes());
    const GuardedBytes features(made.features.bytes());
    if (i > 0) {
      // the parts that point elsewhere are short beside the rest, so every other change is there
      const std::span<std::byte> bytes = (i % 4 < 2 ? field : features).bytes();
      const std::size_t within =
          i % 2 == 0 ? bytes.size() : std::min<std::size_t>(3000, bytes.size());
      bytes[random() % within] ^= static_cast<std::byte>(1U << random() % 8);
    }
    std::optional<DistanceField> read = FieldImage::Read(field.block());
    std::optional<BodyFeatures> read_features = FeatureImage::Read(features.block());
    if (i == 0) {
      ASSERT_TRUE(read && read_features);
    }
    if (!read || !read_features) continue;
    ++taken;
    const BodySurface surface =
        SurfaceInBody(std::move(*read), std::move(*read_features), box_, Pose{});
    EXPECT_FALSE(Readings(surface, box_, 400).empty());
  }
  EXPECT_GT(taken, 50);
}

// A sound sum says nothing: anybody who alters a file can work it out.
TEST_F(SurfaceFile, AlterationWithAValidChecksumIsRefusedOrHarmless) {
  const Bytes whole = SavedBytes(box_);
  std::mt19937_64 random(2);
  int taken = 0;
  for (int i = 0; i < 400; ++i) {
    Bytes other = whole;
    const std::size_t at = 128 + random() % (whole.size() - 128);
    // every other time in the parts that point elsewhere, which are short
    const std::size_t place = i % 2 == 0 ? at : 128 + random() % 3000;
    other[place] ^= static_cast<std::byte>(1U << random() % 8);
    const Result<BodySurface> surface = Mapped(Signed(other));
    if (!surface) continue;
    ++taken;
    EXPECT_FALSE(Readings(*surface, box_, 400).empty());
  }
  EXPECT_GT(taken, 20);
}

TEST_F(SurfaceFile, InconsistentCountsAreRefused) {
  const Bytes whole = SavedBytes(box_);
  const std::size_t features =
      (128 + Get<std::uint64_t>(whole, offsetof(BlockFileHeader, block_bytes)) + 63) / 64 * 64;
  std::vector<std::size_t> counts;
  for (std::size_t at = offsetof(FieldHeader, origin) + 12; at < sizeof(FieldHeader); at += 4) {
    counts.push_back(128 + at);
  }
  for (std::size_t at = offsetof(FeatureHeader, cell_count); at < sizeof(FeatureHeader); at += 4) {
    counts.push_back(features + at);
  }
  for (const std::size_t at : counts) {
    for (const std::uint32_t value : {0U, 1U, 0x7fffffffU, 0x80000000U, 0xffffffffU}) {
      Bytes other = whole;
      if (Get<std::uint32_t>(whole, at) == value) continue;
      Set(other, at, value);
      EXPECT_EQ(FaultOf(Signed(other)), "a damaged surface; voxelize its mesh again")
          << at << ": " << value;
    }
  }
}

TEST_F(SurfaceFile, IndicesOutOfRangeAreRefused) {
  const Bytes whole = SavedBytes(box_);
  const auto field = Get<FieldHeader>(whole, 128);
  const auto line = [](std::size_t at) {
    return (at + 63) / 64 * 64;
  };
  // places by the drawing in field_image.h
  const auto side = [](std::int32_t count) {
    return static_cast<std::size_t>(count);
  };
  const std::size_t hyperbricks = 128 + line(sizeof field);
  const std::size_t first_bricks =
      line(hyperbricks + 4 * side(field.size.x) * side(field.size.y) * side(field.size.z));
  const std::size_t tables = line(first_bricks + 4 * field.tables);
  const std::size_t bricks = line(tables + 2 * (512 * field.tables + 1));
  const std::size_t steps = line(bricks + 16 * field.bricks);
  const std::size_t list_faces = line(steps + field.step_bytes);
  ASSERT_EQ(line(list_faces + 4 * field.list_faces) + 36 * field.faces, 128 + field.bytes);
  std::vector<std::pair<std::size_t, std::uint32_t>> outside;
  for (std::size_t i = 0; i < side(field.size.x); ++i) {
    outside.emplace_back(hyperbricks + 4 * i, static_cast<std::uint32_t>(field.tables));
  }
  for (std::size_t i = 0; i < field.tables; ++i) {
    // a table that names no brick has no first one
    const std::size_t table = tables + 1024 * i;
    bool names = false;
    for (std::size_t k = 0; k < 512; ++k) {
      names = names || Get<std::int16_t>(whole, table + 2 * k) >= 0;
    }
    if (names) outside.emplace_back(first_bricks + 4 * i, static_cast<std::uint32_t>(field.bricks));
  }
  outside.emplace_back(bricks + 12, static_cast<std::uint32_t>(field.step_bytes));
  outside.emplace_back(bricks + 16 * (field.bricks - 1) + 12, 0xffffffffU);
  outside.emplace_back(list_faces, static_cast<std::uint32_t>(field.faces));
  outside.emplace_back(list_faces + 4 * (field.list_faces - 1), 0x7fffffffU);
  // and a corner that is no number
  outside.emplace_back(line(list_faces + 4 * field.list_faces), 0x7fc00000U);
  for (const auto& [at, value] : outside) {
    Bytes other = whole;
    Set(other, at, value);
    EXPECT_EQ(FaultOf(Signed(other)), "a damaged surface; voxelize its mesh again") << at;
  }
}

}  // namespace
}  // namespace tandem
