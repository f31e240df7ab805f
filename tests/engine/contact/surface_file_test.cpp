#include "engine/contact/surface_file.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>
#include <fstream>
#include <functional>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <tbb/global_control.h>

#include "engine/base/check.h"
#include "engine/contact/feature_image.h"
#include "engine/field/field_image.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/shapes.h"

namespace tandem {
namespace {

using testing::Box;
using testing::HollowBlock;
using testing::Sheet;
using testing::Sphere;
using testing::Uniform;

using Bytes = std::vector<std::byte>;

constexpr double kVoxel = 0.001;
const SurfaceOptions kOptions{.voxel_size = kVoxel};

struct Shape {
  std::string name;
  TriangleMesh mesh_W;
};

std::vector<Shape> Shapes() {
  const Quat turn = Quat(0.9, 0.1, 0.3, -0.2).normalized();
  const Vec3 place(0.003, -0.02, 0.011);
  TriangleMesh crossed = Box(kVoxel * Vec3(14, 5, 5));
  Append(crossed, testing::At(Box(kVoxel * Vec3(5, 14, 5)), kVoxel * Vec3(1, 0, 1)));
  return {{"box", testing::At(Box(kVoxel * Vec3(11, 7.3, 9)), place, turn)},
          {"thin plate", testing::At(Box(kVoxel * Vec3(12, 10, 0.3)), place, turn)},
          {"ball without edges", Sphere(9 * kVoxel, 4)},
          {"coarse ball", Sphere(9 * kVoxel, 1)},
          {"hollow block", HollowBlock(26 * kVoxel, 9 * kVoxel)},
          {"sheet", testing::At(Sheet(12 * kVoxel), place, turn)},
          {"boxes that cross", crossed}};
}

class SurfaceFile : public ::testing::Test {
 protected:
  BodySurface Made(const TriangleMesh& mesh_W, const Pose& X_WB = {}) const {
    Result<BodySurface> made = BuildSurface(mesh_W, X_WB, kOptions);
    EXPECT_TRUE(made);
    return std::move(*made);
  }
  std::filesystem::path Saved(const TriangleMesh& mesh_W) const {
    EXPECT_FALSE(SaveSurface(Made(mesh_W), mesh_W, kOptions, file_));
    return file_;
  }
  Bytes SavedBytes(const TriangleMesh& mesh_W) const {
    std::ifstream in(Saved(mesh_W), std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    const auto* begin = reinterpret_cast<const std::byte*>(text.data());
    return {begin, begin + text.size()};
  }
  Result<BodySurface> Mapped(const Bytes& bytes) const {
    std::ofstream(file_, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
    return MapSurface(file_, box_, Pose{}, kOptions);
  }
  /// Returns the refusal's line without the file's name; empty if the file is taken.
  std::string FaultOf(const Bytes& bytes) const {
    const Result<BodySurface> surface = Mapped(bytes);
    if (surface) return {};
    const std::string& line = surface.error().what;
    EXPECT_EQ(line.find('\n'), std::string::npos);
    EXPECT_EQ(line.find(file_.string() + ": "), 0U) << line;
    return line.substr(file_.string().size() + 2);
  }

  ScratchFolder folder_;
  std::filesystem::path file_ = folder_.path() / "body.surface";
  TriangleMesh box_ = Box(kVoxel * Vec3(6, 4, 3));
};

/// Returns the bytes with the checksum of what they are now.
Bytes Signed(Bytes bytes) {
  BlockFileHeader header;
  std::memcpy(&header, bytes.data(), sizeof header);
  header.checksum = BlockFileChecksum(bytes);
  std::memcpy(bytes.data(), &header, sizeof header);
  return bytes;
}

template <typename T>
void Set(Bytes& bytes, std::size_t at, T value) {
  std::memcpy(&bytes[at], &value, sizeof value);
}

template <typename T>
T Get(const Bytes& bytes, std::size_t at) {
  T value;
  std::memcpy(&value, &bytes[at], sizeof value);
  return value;
}

/// Calls all that reads a surface, at places in and round it, and returns what they told, bit by
/// bit.
std::vector<double> Readings(const BodySurface& surface, const TriangleMesh& mesh_W,
                             int places = 4000) {
  std::mt19937_64 random(5);
  const DistanceField& field = surface.field;
  const Bounds box = BoundsOf(mesh_W);
  std::vector<double> told;
  FieldPushes pushes;
  FieldGradient gradient;
  FieldReadings readings;
  std::array<std::array<float, kBlockPlaces>, 3> lanes;
  std::array<float, kBlockPlaces> values;
  std::array<float, kBlockPlaces> over;
  std::array<std::int32_t, kBlockPlaces> kinds;
  for (int i = 0; i < places; ++i) {
    Vec3 place_V;
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      place_V[axis] = (Uniform(random, box.min[axis] - 4 * kVoxel, box.max[axis] + 4 * kVoxel) -
                       field.p_WVo()[axis]) /
                      kVoxel;
      lanes[static_cast<std::size_t>(axis)].fill(static_cast<float>(place_V[axis]));
    }
    field.WithGradients({&place_V, 1}, &gradient);
    told.insert(told.end(), {gradient.reading.value, gradient.gradient.x(), gradient.gradient.y(),
                             gradient.gradient.z(), field.At(place_V).value});
    field.Values({}, {lanes[0].data(), lanes[1].data(), lanes[2].data()}, kBlockPlaces,
                 values.data(), kinds.data(), over.data());
    told.insert(told.end(), {values[0], static_cast<double>(kinds[0]), over[0]});
    const PlacedBlock block{.places_F = {lanes[0].data(), lanes[1].data(), lanes[2].data()}};
    field.ReadBlocks({1, 0, 0, 0, 1, 0, 0, 0, 1}, 0.6F, {&block, 1}, values.data(), &readings);
    told.insert(told.end(), {values[0], readings.least, static_cast<double>(readings.within)});
    field.Pushes({&place_V, 1}, 0.6, pushes);
    for (const FieldPush& push : pushes.Of(0)) {
      told.insert(told.end(), {push.distance, push.away_V.x(), push.share});
    }
    told.push_back(surface.features.EdgesBeyond(place_V));
    surface.features.VisitEdgesIn(place_V - Vec3::Constant(1), place_V + Vec3::Constant(1),
                                  [&told](const BodyFeatures::Edge& edge) {
                                    told.push_back(edge.middle.x());
                                  });
  }
  for (std::size_t b = 0; b < surface.features.blocks().size(); ++b) {
    for (std::size_t lane = 0; lane < BodyFeatures::kLanes; ++lane) {
      told.push_back(surface.features.place(b, lane).y());
      told.push_back(surface.features.point(b, lane).inward.z());
    }
  }
  return told;
}

bool AreTheSameBits(const std::vector<double>& a, const std::vector<double>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), 8 * a.size()) == 0;
}

TEST_F(SurfaceFile, IsReadBackBitForBit) {
  const Pose X_WB{Quat(0.8, -0.3, 0.2, 0.4).normalized(), Vec3(0.01, 0.02, -0.005)};
  for (const Shape& shape : Shapes()) {
    const BodySurface made = Made(shape.mesh_W, X_WB);
    ASSERT_FALSE(SaveSurface(made, shape.mesh_W, kOptions, file_));
    const Result<BodySurface> mapped = MapSurface(file_, shape.mesh_W, X_WB, kOptions);
    ASSERT_TRUE(mapped) << shape.name << ": " << mapped.error().what;
    EXPECT_EQ(mapped->field.Digest(), made.field.Digest()) << shape.name;
    EXPECT_TRUE(std::ranges::equal(mapped->field.bytes(), made.field.bytes())) << shape.name;
    EXPECT_TRUE(std::ranges::equal(mapped->features.bytes(), made.features.bytes())) << shape.name;
    EXPECT_EQ(mapped->features.point_count(), made.features.point_count()) << shape.name;
    EXPECT_EQ(mapped->radius, made.radius) << shape.name;
    EXPECT_EQ(mapped->X_BV.p, made.X_BV.p) << shape.name;
    EXPECT_EQ(mapped->X_BV.q.coeffs(), made.X_BV.q.coeffs()) << shape.name;
    EXPECT_TRUE(AreTheSameBits(Readings(*mapped, shape.mesh_W), Readings(made, shape.mesh_W)))
        << shape.name;
  }
}

// Bytes between arrays and in records are 0, whatever memory held before.
TEST_F(SurfaceFile, HasTheSameBytesForAnyNumberOfThreads) {
  const TriangleMesh mesh = HollowBlock(26 * kVoxel, 9 * kVoxel);
  Bytes one;
  for (const std::size_t threads : {1, 2, 5}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    const Bytes bytes = SavedBytes(mesh);
    if (one.empty()) one = bytes;
    EXPECT_EQ(bytes, one) << threads;
  }
}

TEST_F(SurfaceFile, IsRefusedWhereItEndsTooEarlyOrTooLate) {
  const Bytes whole = SavedBytes(box_);
  ASSERT_EQ(FaultOf(whole), "");
  EXPECT_EQ(FaultOf({}), "empty");
  EXPECT_EQ(FaultOf({whole.begin(), whole.begin() + 71}), "too short for a surface");
  std::vector<std::size_t> lengths{72, 73, 127, 128, 129, whole.size() - 1};
  for (std::size_t length = 64; length < whole.size(); length += 999) lengths.push_back(length);
  for (const std::size_t length : lengths) {
    if (length < 72) continue;
    Bytes cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(length));
    EXPECT_NE(FaultOf(cut).find("it was cut short"), std::string::npos) << length;
    // the header lies about its length and its sum
    Set(cut, offsetof(BlockFileHeader, bytes), std::uint64_t{length});
    EXPECT_NE(FaultOf(Signed(cut)), "") << length;
  }
  Bytes longer = whole;
  longer.resize(whole.size() + 64);
  EXPECT_NE(FaultOf(longer).find("it was cut short"), std::string::npos);
  Set(longer, offsetof(BlockFileHeader, bytes), std::uint64_t{longer.size()});
  EXPECT_NE(FaultOf(Signed(longer)), "");
}

TEST_F(SurfaceFile, IsRefusedWithAnyFieldOfItsHeaderAltered) {
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

TEST_F(SurfaceFile, OfAnOlderVersionSaysThatItShallBeMadeAgain) {
  Bytes older = SavedBytes(box_);
  Set(older, offsetof(BlockFileHeader, version), kSurfaceFile.version - 1);
  EXPECT_EQ(FaultOf(Signed(older)),
            "a surface of version " + std::to_string(kSurfaceFile.version - 1) + ", not " +
                std::to_string(kSurfaceFile.version) + "; voxelize its mesh again");
}

TEST_F(SurfaceFile, OfAnotherMeshOrWithOtherOptionsIsRefused) {
  const std::filesystem::path file = Saved(box_);
  ASSERT_TRUE(MapSurface(file, box_, Pose{}, kOptions));
  TriangleMesh moved = box_;
  moved.vertices[3].x() += 1e-12;
  TriangleMesh turned = box_;
  std::swap(turned.triangles[0][1], turned.triangles[0][2]);
  for (const TriangleMesh& mesh : {moved, turned}) {
    const Result<BodySurface> surface = MapSurface(file, mesh, Pose{}, kOptions);
    ASSERT_FALSE(surface);
    EXPECT_NE(surface.error().what.find("a surface of another mesh"), std::string::npos);
  }
  for (const SurfaceOptions& options :
       {SurfaceOptions{.voxel_size = 0.0011}, SurfaceOptions{.flatness_voxels = 0.5},
        SurfaceOptions{.spacing_voxels = 0.5}}) {
    EXPECT_FALSE(MapSurface(file, box_, Pose{}, options));
  }
}

TEST_F(SurfaceFile, IsRefusedWithAnyBitFlipped) {
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

TEST_F(SurfaceFile, NoReadingLeavesABlockThatIsTaken) {
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
TEST_F(SurfaceFile, WithASoundSumButAlteredIsRefusedOrHarmless) {
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

TEST_F(SurfaceFile, IsRefusedWhereItsCountsAreNotItsOwn) {
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

TEST_F(SurfaceFile, IsRefusedWhereNumbersPointOutside) {
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

TEST_F(SurfaceFile, TakesThePlaceOfNothingThatIsNoFile) {
  const std::filesystem::path pipe = folder_.path() / "pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  const std::optional<Error> fault = SaveSurface(Made(box_), box_, kOptions, pipe);
  ASSERT_TRUE(fault);
  EXPECT_EQ(fault->what, pipe.string() + ": is not a regular file: name another");
  EXPECT_FALSE(MapSurface(pipe, box_, Pose{}, kOptions));
}

}  // namespace
}  // namespace tandem
