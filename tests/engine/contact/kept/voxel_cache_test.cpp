#include "engine/contact/kept/voxel_cache.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <random>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "engine/voxel/build/voxelize.h"
#include "engine/voxel/points/kept_points.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/shapes.h"

namespace tandem {
namespace {

namespace fs = std::filesystem;
using testing::Sphere;

constexpr double kBallVoxel = 0.001;

/// Returns options that are asked to stop before a surface is built: building gives an error,
/// mapping gives the surface.
SurfaceOptions OnlyMapped() {
  std::stop_source stop;
  stop.request_stop();
  return {.voxel_size = kBallVoxel, .stop = stop.get_token()};
}

std::string TextOf(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

void Overwrite(const fs::path& file, const std::string& text) {
  std::ofstream(file, std::ios::binary) << text;
}

/// Cuts a file short at a drawn place, or turns a bit there, and returns the place.
std::size_t Spoil(const fs::path& file, std::string text, bool cut, std::mt19937_64& random) {
  const std::size_t at = random() % text.size();
  if (cut) {
    text.resize(at);
  } else {
    text[at] = static_cast<char>(text[at] ^ 1 << random() % 8);
  }
  fs::remove(file);
  Overwrite(file, text);
  return at;
}

class VoxelCacheTest : public ::testing::Test {
 protected:
  bool IsMapped(const TriangleMesh& mesh) const {
    return cache_.SurfaceOf(mesh, Pose{}, OnlyMapped()).has_value();
  }
  void Make(const TriangleMesh& mesh) const {
    ASSERT_TRUE(cache_.SurfaceOf(mesh, Pose{}, kOptions));
  }

  const SurfaceOptions kOptions{.voxel_size = kBallVoxel};
  ScratchFolder scratch_;
  VoxelCache cache_{scratch_.path() / "not yet" / "cache"};
  TriangleMesh ball_ = Sphere(24 * kBallVoxel, 4);
};

TEST_F(VoxelCacheTest, ReusesAnEarlierResult) {
  EXPECT_FALSE(IsMapped(ball_));
  const Result<BodySurface> made = cache_.SurfaceOf(ball_, Pose{}, kOptions);
  ASSERT_TRUE(made);
  const Pose elsewhere{Quat(0.8, 0, 0.6, 0), Vec3(1, 2, 3)};
  const Result<BodySurface> mapped = cache_.SurfaceOf(ball_, elsewhere, OnlyMapped());
  ASSERT_TRUE(mapped);
  EXPECT_EQ(mapped->field.Digest(), made->field.Digest());
  EXPECT_TRUE(std::ranges::equal(mapped->features.bytes(), made->features.bytes()));
  EXPECT_EQ(mapped->X_BV.p, (elsewhere.Inverse() * made->X_BV).p);
  ASSERT_EQ(cache_.Files().size(), 1U);
  EXPECT_EQ(fs::status(cache_.folder()).permissions(), fs::perms::owner_all);
}

TEST_F(VoxelCacheTest, MeshAndSettingsDetermineTheFile) {
  Make(ball_);
  EXPECT_FALSE(IsMapped(Sphere(24.01 * kBallVoxel, 4)));
  SurfaceOptions finer = OnlyMapped();
  finer.voxel_size *= 0.99;
  EXPECT_FALSE(cache_.SurfaceOf(ball_, Pose{}, finer));
}

TEST_F(VoxelCacheTest, DamagedFilesAreRebuilt) {
  Make(ball_);
  const fs::path file = cache_.Files().at(0).file;
  const std::string whole = TextOf(file);
  std::mt19937_64 random(3);
  for (int i = 0; i < 12; ++i) {
    const std::size_t at = Spoil(file, whole, i % 3 == 0, random);
    ASSERT_FALSE(IsMapped(ball_)) << "byte " << at;
    Make(ball_);
    ASSERT_TRUE(IsMapped(ball_));
    ASSERT_TRUE(TextOf(file) == whole);
  }
}

TEST_F(VoxelCacheTest, FileWritableByOthersIsNotTrusted) {
  Make(ball_);
  const fs::path file = cache_.Files().at(0).file;
  fs::permissions(file, fs::perms::others_write, fs::perm_options::add);
  EXPECT_FALSE(IsMapped(ball_));
  fs::permissions(file, fs::perms::others_write, fs::perm_options::remove);
  EXPECT_TRUE(IsMapped(ball_));
  fs::rename(file, scratch_.path() / "elsewhere");
  fs::create_symlink(scratch_.path() / "elsewhere", file);
  EXPECT_FALSE(IsMapped(ball_));
  Make(ball_);
  EXPECT_TRUE(IsMapped(ball_));
}

TEST_F(VoxelCacheTest, FolderWritableByOthersIsNotUsed) {
  Make(ball_);
  fs::permissions(cache_.folder(), fs::perms::group_write, fs::perm_options::add);
  EXPECT_FALSE(IsMapped(ball_));
  const fs::path file = cache_.Files().at(0).file;
  fs::remove(file);
  Make(ball_);
  EXPECT_FALSE(fs::exists(file));
}

TEST_F(VoxelCacheTest, QuickResultsAreNotCached) {
  Make(testing::Box(kBallVoxel * Vec3(6, 4, 3)));
  EXPECT_TRUE(cache_.Files().empty());
}

TEST_F(VoxelCacheTest, LeastRecentlyUsedFileIsEvictedFirst) {
  std::vector<TriangleMesh> balls;
  for (int i = 0; i < 3; ++i) balls.push_back(Sphere((24 + i) * kBallVoxel, 4));
  Make(balls[0]);
  const std::uint64_t bytes = cache_.Files().at(0).bytes;
  const VoxelCache small(cache_.folder(), 5 * bytes / 2);
  const auto make = [&](std::size_t i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));  // a file's time has a grain
    ASSERT_TRUE(small.SurfaceOf(balls[i], Pose{}, kOptions));
  };
  make(1);
  make(0);  // is used again
  make(2);
  EXPECT_TRUE(IsMapped(balls[0]));
  EXPECT_FALSE(IsMapped(balls[1]));
  EXPECT_TRUE(IsMapped(balls[2]));
}

TEST_F(VoxelCacheTest, WorksWithoutAFolder) {
  const VoxelCache none(scratch_.Write("file", "") / "cache");
  EXPECT_TRUE(none.SurfaceOf(ball_, Pose{}, kOptions));
  EXPECT_TRUE(none.Files().empty());
  EXPECT_EQ(none.Clear(), 0U);
}

TEST_F(VoxelCacheTest, SupportsConcurrentUse) {
  std::vector<std::thread> users;
  std::vector<std::uint64_t> digests(4);
  for (std::uint64_t& digest : digests) {
    users.emplace_back([&] {
      for (int i = 0; i < 3; ++i) {
        const auto surface = cache_.SurfaceOf(ball_, Pose{}, kOptions);
        if (surface) digest = surface->field.Digest();
      }
    });
  }
  for (std::thread& user : users) user.join();
  for (const std::uint64_t digest : digests) EXPECT_EQ(digest, digests[0]);
  EXPECT_TRUE(IsMapped(ball_));
}

TEST_F(VoxelCacheTest, KeepsVoxmapsToo) {
  std::stop_source stop;
  stop.request_stop();
  VoxelizeOptions options{.voxel_size = 0.2 * kBallVoxel};
  VoxelizeOptions only_mapped = options;
  only_mapped.stop = stop.get_token();
  EXPECT_FALSE(cache_.VoxmapOf(ball_, only_mapped));
  const Result<Voxmap> made = cache_.VoxmapOf(ball_, options);
  ASSERT_TRUE(made);
  const Result<Voxmap> mapped = cache_.VoxmapOf(ball_, only_mapped);
  ASSERT_TRUE(mapped) << mapped.error().what;
  EXPECT_EQ(mapped->Digest(), made->Digest());
  ASSERT_EQ(cache_.Files().size(), 1U);

  // other meshes and settings are other files
  EXPECT_FALSE(cache_.VoxmapOf(Sphere(24.01 * kBallVoxel, 4), only_mapped));
  for (VoxelizeOptions other :
       {VoxelizeOptions{.voxel_size = 0.21 * kBallVoxel},
        VoxelizeOptions{.voxel_size = 0.2 * kBallVoxel, .range = 7},
        VoxelizeOptions{.voxel_size = 0.2 * kBallVoxel, .bits = 8},
        VoxelizeOptions{.voxel_size = 0.2 * kBallVoxel, .flatness_voxels = 0}}) {
    other.stop = stop.get_token();
    EXPECT_FALSE(cache_.VoxmapOf(ball_, other));
  }

  // a file that is damaged or cut short is made anew
  const fs::path file = cache_.Files().at(0).file;
  const std::string whole = TextOf(file);
  std::mt19937_64 random(5);
  for (int i = 0; i < 9; ++i) {
    const std::size_t at = Spoil(file, whole, i % 3 == 0, random);
    EXPECT_TRUE(VoxelCache::FaultOf(file)) << "byte " << at;
    ASSERT_FALSE(cache_.VoxmapOf(ball_, only_mapped)) << "byte " << at;
    ASSERT_TRUE(cache_.VoxmapOf(ball_, options));
    ASSERT_TRUE(TextOf(file) == whole);
  }
  EXPECT_FALSE(VoxelCache::FaultOf(file));
}

TEST_F(VoxelCacheTest, PagesComeFromTheSameFile) {
  const VoxelizeOptions options{.voxel_size = 0.2 * kBallVoxel};
  const Result<std::shared_ptr<const PageSource>> pages = cache_.PagesOf(ball_, options);
  ASSERT_TRUE(pages) << pages.error().what;
  std::stop_source stop;
  stop.request_stop();
  VoxelizeOptions only_loaded = options;
  only_loaded.stop = stop.get_token();
  const Result<Voxmap> whole = cache_.VoxmapOf(ball_, only_loaded);
  ASSERT_TRUE(whole) << whole.error().what;
  EXPECT_EQ((*pages)->counts().total(), whole->Count().total());
  ASSERT_EQ(cache_.Files().size(), 1U);
}

TEST_F(VoxelCacheTest, ReadsAMeshFileOnce) {
  const TriangleMesh mesh = Sphere(24 * kBallVoxel, 6);
  const fs::path file = scratch_.path() / "ball.off";
  std::string text = "OFF\n" + std::to_string(mesh.vertices.size()) + " " +
                     std::to_string(mesh.triangles.size()) + " 0\n";
  for (const Vec3& v : mesh.vertices) {
    char line[80];
    std::snprintf(line, sizeof line, "%.9g %.9g %.9g\n", v.x(), v.y(), v.z());
    text += line;
  }
  for (const auto& t : mesh.triangles) {
    text += "3 " + std::to_string(t[0]) + " " + std::to_string(t[1]) + " " + std::to_string(t[2]) +
            "\n";
  }
  Overwrite(file, text);
  const Result<ImportedMesh> first = cache_.MeshOf(file, {});
  ASSERT_TRUE(first) << first.error().what;
  EXPECT_TRUE(first->closed);
  EXPECT_EQ(first->diagnosis, "closed, 1 body");
  ASSERT_EQ(cache_.Files().size(), 1U);

  // a program without time to read the file takes what is kept, and nothing else
  const ImportOptions no_time{.seconds_limit = 1e-9};
  const Result<ImportedMesh> again = cache_.MeshOf(file, no_time);
  ASSERT_TRUE(again) << again.error().what;
  EXPECT_EQ(again->mesh.vertices, first->mesh.vertices);
  EXPECT_EQ(again->mesh.triangles, first->mesh.triangles);
  EXPECT_EQ(again->diagnosis, first->diagnosis);
  EXPECT_FALSE(VoxelCache::FaultOf(cache_.Files().at(0).file));

  ImportOptions scaled = no_time;
  scaled.scale = 2.0;
  EXPECT_FALSE(cache_.MeshOf(file, scaled));
  text[text.size() - 2] = text[text.size() - 2] == '1' ? '2' : '1';
  Overwrite(file, text);
  EXPECT_FALSE(cache_.MeshOf(file, no_time)) << "the file is another one now";

  Overwrite(file, text.substr(0, 100));
  const fs::path kept = cache_.Files().at(0).file;
  const std::string whole = TextOf(kept);
  std::mt19937_64 random(11);
  for (int i = 0; i < 6; ++i) {
    Spoil(kept, whole, i % 2 == 0, random);
    EXPECT_TRUE(VoxelCache::FaultOf(kept));
  }
}

TEST_F(VoxelCacheTest, KeepsPointsToo) {
  const PointshellOptions options{.spacing = 0.3 * kBallVoxel, .place = PointPlace::kOnFeature};
  const Pose X_WB{Quat(0.8, 0, 0.6, 0), Vec3(1, 2, 3)};
  const Result<Pointshell> made = cache_.PointsOf(ball_, X_WB, options);
  ASSERT_TRUE(made);
  ASSERT_EQ(cache_.Files().size(), 1U);
  const fs::path file = cache_.Files().at(0).file;
  const Result<Pointshell> loaded = LoadKeptPoints(file, KeyOf(ball_, X_WB, options));
  ASSERT_TRUE(loaded) << loaded.error().what;
  EXPECT_EQ(Digest(*loaded), Digest(*made));
  EXPECT_EQ(loaded->labels, made->labels);
  EXPECT_EQ(loaded->chunks.size(), made->chunks.size());
  EXPECT_EQ(loaded->edges.size(), made->edges.size());
  EXPECT_EQ(loaded->gaps, made->gaps);
  EXPECT_EQ(loaded->radius, made->radius);
  PointshellOptions other = options;
  other.inward_shift = 1e-5;
  EXPECT_FALSE(LoadKeptPoints(file, KeyOf(ball_, X_WB, other)));
  EXPECT_FALSE(LoadKeptPoints(file, KeyOf(ball_, Pose{}, options)));

  const std::string whole = TextOf(file);
  std::mt19937_64 random(13);
  for (int i = 0; i < 9; ++i) {
    const std::size_t at = Spoil(file, whole, i % 3 == 0, random);
    EXPECT_TRUE(VoxelCache::FaultOf(file)) << "byte " << at;
    ASSERT_TRUE(cache_.PointsOf(ball_, X_WB, options));
    ASSERT_TRUE(TextOf(file) == whole);
  }
}

TEST_F(VoxelCacheTest, ClearRemovesItsFilesAndNoOthers) {
  Make(ball_);
  const fs::path note = cache_.folder() / "note.txt";
  Overwrite(note, "mine");
  const fs::path remainder = cache_.Files().at(0).file.string() + ".unfinished-4194200-1";
  Overwrite(remainder, "half of it");
  EXPECT_EQ(cache_.Clear(), 1U);
  EXPECT_TRUE(fs::exists(note));
  EXPECT_FALSE(fs::exists(remainder));
  EXPECT_FALSE(IsMapped(ball_));
}

}  // namespace
}  // namespace tandem
