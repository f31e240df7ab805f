#include "engine/geometry/import/mesh_file.h"

#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "engine/geometry/mesh/mesh_diagnosis.h"
#include "tests/engine/geometry/import/mesh_file_fixture.h"

namespace tandem {
namespace {

using ::testing::AllOf;
using testing::BinaryStlCube;
using testing::BinaryStlSphere;
using ::testing::HasSubstr;
using testing::kDaeTriangle;
using testing::kObjCube;
using testing::kOffCube;
using testing::kPlyCube;
using testing::MeshFile;
using ::testing::Not;
using testing::WhyNot;

bool HasChildren() {
  return waitpid(-1, nullptr, WNOHANG) != -1 || errno != ECHILD;
}

std::ptrdiff_t OpenFds() {
  std::filesystem::directory_iterator fds("/proc/self/fd");
  return std::distance(begin(fds), end(fds));
}

TEST_F(MeshFile, ReadsTheSameWeldedCubeFromEveryFormat) {
  const std::vector<std::pair<std::string, std::string>> files{{"cube.obj", kObjCube},
                                                               {"cube.off", kOffCube},
                                                               {"cube.ply", kPlyCube},
                                                               {"cube.stl", BinaryStlCube()}};
  for (const auto& [name, content] : files) {
    const Result<TriangleMesh> mesh = ImportMesh(Write(name, content));
    ASSERT_TRUE(mesh) << WhyNot(mesh);
    EXPECT_EQ(mesh->triangles.size(), 12U) << name;
    EXPECT_EQ(mesh->vertices.size(), 8U) << name;
    EXPECT_EQ(Describe(Diagnose(*mesh)), "closed, 1 body") << name;
    EXPECT_EQ(BoundsOf(*mesh).size(), Vec3(1, 1, 1)) << name;
  }
}

TEST_F(MeshFile, ScalesInDoublePrecisionAfterWelding) {
  const Result<TriangleMesh> mesh = ImportMesh(Write("cube.obj", kObjCube), {.scale = 0.001});
  ASSERT_TRUE(mesh) << WhyNot(mesh);
  EXPECT_EQ(BoundsOf(*mesh).max, Vec3::Constant(0.001));
}

// The node turns x to y, mirrors z and moves by 10; the file says Z up, so z stays z. A mirrored
// triangle keeps its outside.
TEST_F(MeshFile, AppliesNodeTransformsAndKeepsTheFilesAxes) {
  const Result<TriangleMesh> mesh = ImportMesh(Write("triangle.dae", kDaeTriangle));
  ASSERT_TRUE(mesh) << WhyNot(mesh);
  EXPECT_EQ(BoundsOf(*mesh).min, Vec3(9, 0, -3));
  EXPECT_EQ(BoundsOf(*mesh).max, Vec3(10, 2, -3));
  ASSERT_EQ(mesh->triangles.size(), 1U);
  const Vec3 normal =
      (mesh->corner(0, 1) - mesh->corner(0, 0)).cross(mesh->corner(0, 2) - mesh->corner(0, 0));
  EXPECT_LT(normal.z(), 0) << "facing +z before the mirror, -z after it";
}

TEST_F(MeshFile, WeldsWithinAToleranceOnlyWhenAsked) {
  // a lid that stands a thousandth off
  const std::string cracked =
      "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 1.001 0 0\nv 0 1.001 0\nv 0 0 1.001\n"
      "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 5 6 7\n";
  const auto file = Write("cracked.obj", cracked);
  const Result<TriangleMesh> exact = ImportMesh(file);
  ASSERT_TRUE(exact) << WhyNot(exact);
  EXPECT_EQ(Diagnose(*exact).bodies, 2U);
  const Result<TriangleMesh> welded = ImportMesh(file, {.weld_tolerance = 0.002});
  ASSERT_TRUE(welded) << WhyNot(welded);
  EXPECT_EQ(Describe(Diagnose(*welded)), "closed, 1 body");
}

TEST_F(MeshFile, KeepsFlatTrianglesForTheDiagnosis) {
  const Result<TriangleMesh> mesh = ImportMesh(Write("flat.obj", kObjCube + "f 1 1 2\n"));
  ASSERT_TRUE(mesh) << WhyNot(mesh);
  EXPECT_EQ(mesh->triangles.size(), 13U);
  EXPECT_EQ(Describe(Diagnose(*mesh)), "closed, 1 flat triangle; 1 body");
}

TEST_F(MeshFile, ErrorsAreOneLineThatNamesTheFileAndTheFault) {
  const std::string huge(2000, 'x');
  const std::vector<std::tuple<std::string, std::string, std::string>> cases{
      {"index.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", "out of range"},
      {"index.ply",
       "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
       "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
       "0 0 0\n1 0 0\n0 1 0\n3 0 1 5000\n",
       "uses vertex 5000, but there are only 3"},
      {"empty.stl", "", "cannot read"},
      {"nothing.stl", "solid nothing\nendsolid nothing\n", "holds no triangles"},
      {"points.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\np 1 2 3\n", "holds no triangles"},
      {"garbage.ply", "\x01\x02\xff\x03" + huge, "cannot read"},
      {"garbage.xyz", huge, "cannot read"},
      {"new\nline.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", "new line.obj"},
      {"point.obj", "v 1 1 1\nv 1 1 1\nv 1 1 1\nf 1 2 3\n", "none of its 1 triangles has any area"},
      {"infinite.obj", "v 0 0 0\nv 1e39 0 0\nv 0 1 0\nf 1 2 3\n", "infinite.obj"},
      {"far.obj", "v 0 0 0\nv 3e7 0 0\nv 0 1 0\nf 1 2 3\n", "reaches 3e+07 m"},
      {"count.off", "OFF\n2147483647 1 0\n", "count.off"},
  };
  for (const auto& [name, content, words] : cases) {
    const Result<TriangleMesh> mesh = ImportMesh(Write(name, content));
    ASSERT_FALSE(mesh) << name;
    EXPECT_THAT(mesh.error().what, AllOf(HasSubstr(words), Not(HasSubstr("\n")))) << name;
    EXPECT_LT(mesh.error().what.size(), 600U) << name;
  }
}

TEST_F(MeshFile, ExplainsWhatToDoWithCadSurfaces) {
  const std::string step =
      "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\n"
      "FILE_NAME('','',(''),(''),'','','');\n"
      "FILE_SCHEMA(('AUTOMOTIVE_DESIGN'));\nENDSEC;\nDATA;\nENDSEC;\n"
      "END-ISO-10303-21;\n";
  for (const char* name : {"part.step", "part.STP", "part.igs", "part.SLDPRT"}) {
    const Result<TriangleMesh> mesh = ImportMesh(Write(name, step));
    ASSERT_FALSE(mesh) << name;
    EXPECT_THAT(mesh.error().what,
                HasSubstr("holds CAD surfaces, which are not triangles: export"));
  }
}

TEST_F(MeshFile, RefusesInfiniteVerticesWithAReason) {
  std::string stl = BinaryStlCube();
  const float infinite = std::numeric_limits<float>::infinity();
  std::memcpy(stl.data() + 84 + 12, &infinite, 4);  // x of the first corner
  const Result<TriangleMesh> mesh = ImportMesh(Write("infinite.stl", stl));
  ASSERT_FALSE(mesh);
  EXPECT_THAT(mesh.error().what, HasSubstr("1 of its 36 vertices are infinite or not numbers"));
}

TEST_F(MeshFile, RefusesUnreadableFiles) {
  EXPECT_THAT(WhyNot(ImportMesh(folder_.path() / "no.stl")), HasSubstr("does not exist"));
  EXPECT_THAT(WhyNot(ImportMesh(folder_.path())), HasSubstr("is a directory"));
  EXPECT_THAT(WhyNot(ImportMesh("")), HasSubstr("does not exist"));
}

TEST_F(MeshFile, RefusesInvalidScalesAndTolerances) {
  const auto file = Write("cube.obj", kObjCube);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(WhyNot(ImportMesh(file, {.scale = 0})), HasSubstr("scale"));
  EXPECT_THAT(WhyNot(ImportMesh(file, {.scale = nan})), HasSubstr("scale"));
  EXPECT_THAT(WhyNot(ImportMesh(file, {.scale = 1e9})), HasSubstr("scale of 1e+09"));
  EXPECT_THAT(WhyNot(ImportMesh(file, {.weld_tolerance = -1})), HasSubstr("tolerance"));
  EXPECT_THAT(WhyNot(ImportMesh(file, {.weld_tolerance = 5})), HasSubstr("tolerance"));
}

TEST_F(MeshFile, KillsASlowReaderAtItsTimeLimit) {
  std::string lines;
  while (lines.size() < (64U << 20U)) lines += "v 0.125 0.25 0.5\nf -1 -1 -1\n";
  const auto file = Write("long.obj", lines);
  const auto start = std::chrono::steady_clock::now();
  const Result<TriangleMesh> mesh = ImportMesh(file, {.seconds_limit = 0.3});
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
  EXPECT_THAT(WhyNot(mesh), HasSubstr("took more than 0.3 s"));
  EXPECT_GE(took.count(), 0.29);
  EXPECT_LT(took.count(), 5);
  EXPECT_FALSE(HasChildren());
}

// Variables that the loader follows would be code in the reading process, or files that it writes.
TEST_F(MeshFile, ReaderDoesNotInheritTheEnvironment) {
  setenv("LD_DEBUG", "libs", 1);
  setenv("LD_DEBUG_OUTPUT", (folder_.path() / "told").c_str(), 1);
  const auto file = Write("cube.obj", kObjCube);
  const Result<TriangleMesh> mesh = ImportMesh(file);
  unsetenv("LD_DEBUG");
  unsetenv("LD_DEBUG_OUTPUT");
  EXPECT_TRUE(mesh) << WhyNot(mesh);
  std::filesystem::directory_iterator files(folder_.path());
  EXPECT_EQ(std::distance(begin(files), end(files)), 1);
}

// Opened for reading, a pipe without a writer waits for one.
TEST_F(MeshFile, OpensOnlyRegularFiles) {
  const auto fifo = folder_.path() / "never.stl";
  ASSERT_EQ(mkfifo(fifo.c_str(), 0600), 0);
  EXPECT_THAT(WhyNot(ImportMesh(fifo)), HasSubstr("is not a regular file: name a mesh file"));
  EXPECT_THAT(WhyNot(ImportMesh("/dev/zero")), HasSubstr("is not a regular file"));
}

TEST_F(MeshFile, ReportsAReaderOutOfMemory) {
  const Result<TriangleMesh> mesh =
      ImportMesh(Write("cube.obj", kObjCube), {.memory_limit_bytes = 1 << 16});
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  EXPECT_FALSE(mesh && mesh->triangles.size() != 12);  // a sanitizer has pools of its own
#else
  EXPECT_THAT(WhyNot(mesh),
              ::testing::AnyOf(HasSubstr("more than 0.0625 MiB"), HasSubstr("crash")));
#endif
}

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
// The room goes from too little to begin with to enough. Whichever step of reading fails for want
// of room, the message says so.
TEST_F(MeshFile, ReportsEveryLackOfMemoryAsSuch) {
  const auto file = Write("sphere.stl", BinaryStlSphere(6));
  int refused = 0;
  bool read = false;
  for (std::size_t limit = 16U << 20U; !read && limit < 2ULL << 30U; limit += limit / 16) {
    const Result<TriangleMesh> mesh = ImportMesh(file, {.memory_limit_bytes = limit});
    read = mesh.has_value();
    if (read) break;
    EXPECT_THAT(mesh.error().what, HasSubstr("needs more than ")) << limit;
    ++refused;
  }
  EXPECT_TRUE(read);
  EXPECT_GT(refused, 2);
}
#endif

TEST_F(MeshFile, LeavesNeitherProcessesNorOpenFilesBehind) {
  const auto good = Write("cube.obj", kObjCube);
  const auto bad = Write("bad.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n");
  const std::ptrdiff_t before = OpenFds();
  for (int i = 0; i < 5; ++i) {
    EXPECT_TRUE(ImportMesh(good));
    EXPECT_FALSE(ImportMesh(bad));
  }
  EXPECT_EQ(OpenFds(), before);
  EXPECT_FALSE(HasChildren());
}

TEST_F(MeshFile, ReadsFromManyThreadsAtOnce) {
  const auto cube = Write("cube.obj", kObjCube);
  const auto sphere = Write("sphere.stl", BinaryStlSphere(4));
  std::atomic<int> right{0};
  std::vector<std::thread> threads;
  threads.reserve(8);
  for (int n = 0; n < 8; ++n) {
    threads.emplace_back([&, n] {
      for (int i = 0; i < 4; ++i) {
        const Result<TriangleMesh> mesh = ImportMesh(n % 2 == 0 ? cube : sphere);
        const std::size_t expected = n % 2 == 0 ? 12 : 20 << 8;
        if (mesh && mesh->triangles.size() == expected) ++right;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(right, 32);
}

// 81920 triangles come as 245760 corners; V - E + F = 2 gives the vertices.
TEST_F(MeshFile, WeldsALargeStl) {
  const Result<TriangleMesh> mesh = ImportMesh(Write("sphere.stl", BinaryStlSphere(6)));
  ASSERT_TRUE(mesh) << WhyNot(mesh);
  EXPECT_EQ(mesh->triangles.size(), 81920U);
  EXPECT_EQ(mesh->vertices.size(), 40962U);
  EXPECT_EQ(Describe(Diagnose(*mesh)), "closed, 1 body");
}

// Whatever a file has become, there is a mesh whose indices and numbers are sound, or an error.
TEST_F(MeshFile, SurvivesThreeHundredDamagedFiles) {
  const std::vector<std::pair<std::string, std::string>> seeds{
      {"obj", kObjCube},     {"off", kOffCube},        {"ply", kPlyCube},
      {"dae", kDaeTriangle}, {"stl", BinaryStlCube()}, {"stl", testing::kAsciiStl}};
  constexpr unsigned kCases = 300;
  std::atomic<unsigned> next{0};
  std::atomic<unsigned> meshes{0};
  std::atomic<unsigned> errors{0};
  const auto work = [&] {
    for (unsigned n = next++; n < kCases; n = next++) {
      const auto& [extension, content] = seeds[n % seeds.size()];
      std::mt19937 random(n);
      const auto file =
          Write("damaged" + std::to_string(n) + "." + extension, testing::Damaged(content, random));
      const Result<TriangleMesh> mesh =
          ImportMesh(file, {.seconds_limit = 2, .memory_limit_bytes = 512U << 20U});
      if (!mesh) {
        EXPECT_THAT(mesh.error().what, AllOf(HasSubstr(file.filename()), Not(HasSubstr("\n"))));
        ++errors;
        continue;
      }
      ++meshes;
      EXPECT_FALSE(mesh->triangles.empty());
      for (std::size_t t = 0; t < mesh->triangles.size(); ++t) {
        for (const std::uint32_t i : mesh->triangles[t]) ASSERT_LT(i, mesh->vertices.size());
      }
      for (const Vec3& vertex : mesh->vertices) EXPECT_TRUE(vertex.allFinite());
      Diagnose(*mesh);
    }
  };
  std::vector<std::thread> threads;
  threads.reserve(8);
  for (int i = 0; i < 4; ++i) threads.emplace_back(work);
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(meshes + errors, kCases);
  EXPECT_GT(meshes, 20U) << "the damage must leave some readable";
  EXPECT_GT(errors, 20U) << "the damage must be felt";
  EXPECT_FALSE(HasChildren());
}

}  // namespace
}  // namespace tandem
