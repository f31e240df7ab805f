#include "app/recording/trace_file.h"

#include <atomic>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include "app/process/child_processes.h"

namespace tandem {
namespace {

using ::testing::HasSubstr;

/// Returns a trace with another number in each place.
std::vector<TraceSample> DrawnTrace(std::size_t frames) {
  std::vector<TraceSample> trace(frames);
  for (std::size_t i = 0; i < frames; ++i) {
    const auto x = static_cast<double>(i);
    trace[i] = {.time_ns = 1'700'000'000'123'456'789 + 1'000'000 * static_cast<std::int64_t>(i),
                .X_WB = {.q = Quat(0.5, -0.5, 0.5, -0.5), .p = Vec3(x, x + 0.25, -x)},
                .V_WB = {.w = Vec3(0.1 * x, 2, 3), .v = Vec3(4, 5 * x, 6)},
                .hand_force = 0.5F * static_cast<float>(i),
                .contact_points = static_cast<int>(i % 7),
                .pushing = i % 2 == 1};
  }
  return trace;
}

TEST(TraceFile, RoundTripsBitForBit) {
  const TemporaryFolder folder;
  const std::vector<TraceSample> trace = DrawnTrace(100);
  TraceFile file(folder.path() / "trace", [&trace] {
    return std::span<const TraceSample>(trace);
  });
  ASSERT_TRUE(file.Close());
  const auto read = ReadTrace(folder.path() / "trace");
  ASSERT_TRUE(read);
  ASSERT_EQ(read->size(), trace.size());
  for (std::size_t i = 0; i < trace.size(); ++i) {
    const TraceSample& was = trace[i];
    const TraceSample& is = (*read)[i];
    EXPECT_EQ(is.time_ns, was.time_ns);
    EXPECT_EQ(is.X_WB.p, was.X_WB.p);
    EXPECT_EQ(is.X_WB.q.coeffs(), was.X_WB.q.coeffs());
    EXPECT_EQ(is.V_WB.w, was.V_WB.w);
    EXPECT_EQ(is.V_WB.v, was.V_WB.v);
    EXPECT_EQ(is.hand_force, was.hand_force);
    EXPECT_EQ(is.contact_points, was.contact_points);
    EXPECT_EQ(is.pushing, was.pushing);
  }
}

TEST(TraceFile, IsWrittenWhileTheTraceGrows) {
  const TemporaryFolder folder;
  const std::vector<TraceSample> trace = DrawnTrace(200'000);
  std::atomic<std::size_t> traced = 0;
  TraceFile file(folder.path() / "trace", [&] {
    return std::span(trace.data(), traced.load());
  });
  const auto frames_on_disk = [&] {
    return std::filesystem::file_size(folder.path() / "trace") / (kTraceColumns * sizeof(double));
  };
  traced = 150'000;
  // all frames but those that the stream still holds
  for (int exact_queries = 0; exact_queries < 1000 && frames_on_disk() < 149'000; ++exact_queries) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  EXPECT_GE(frames_on_disk(), 149'000U);
  EXPECT_LE(frames_on_disk(), 150'000U);
  traced = 200'000;
  ASSERT_TRUE(file.Close());
  EXPECT_EQ(frames_on_disk(), 200'000U);
}

TEST(TraceFile, FullDiskIsReportedAtTheEnd) {
  const std::vector<TraceSample> trace = DrawnTrace(1000);
  TraceFile file("/dev/full", [&trace] {
    return std::span<const TraceSample>(trace);
  });
  const Result<bool> closed = file.Close();
  ASSERT_FALSE(closed);
  EXPECT_THAT(closed.error().what, HasSubstr("/dev/full: cannot be written"));
}

// To open a pipe would be to wait for a reader, and a peer would not begin.
TEST(TraceFile, PipeIsRefused) {
  const TemporaryFolder folder;
  const std::filesystem::path pipe = folder.path() / "report.trace";
  EXPECT_EQ(WhyNoTrace(pipe), "");
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_THAT(WhyNoTrace(pipe), HasSubstr("is a pipe"));
}

TEST(TraceFile, EndWithinAFrameIsAnError) {
  const TemporaryFolder folder;
  {
    const std::vector<TraceSample> trace = DrawnTrace(3);
    const TraceFile file(folder.path() / "trace", [&trace] {
      return std::span<const TraceSample>(trace);
    });
  }
  std::filesystem::resize_file(folder.path() / "trace", 2 * 17 * 8 + 5);
  const auto read = ReadTrace(folder.path() / "trace");
  ASSERT_FALSE(read);
  EXPECT_THAT(read.error().what, HasSubstr("ends within a frame"));
}

/// Writes traces where no file may have a byte, as on a full disk. Ends this process with code 0 if
/// none of them stays.
[[noreturn]] void EndOnAFullDisk(const std::filesystem::path& file) {
  const std::vector<TraceSample> trace = DrawnTrace(100);
  std::signal(SIGXFSZ, SIG_IGN);
  const rlimit none{};
  setrlimit(RLIMIT_FSIZE, &none);
  TraceFile written(file, [&trace] {
    return std::span<const TraceSample>(trace);
  });
  const bool failed = !written.Close();
  const bool gone = !std::filesystem::exists(file);
  TraceFile discarded(file, [] {
    return std::span<const TraceSample>();
  });
  discarded.Discard();
  _exit(failed && gone && !std::filesystem::exists(file) ? 0 : 1);
}

TEST(TraceFileDeathTest, UnwritableTraceLeavesNoFile) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const TemporaryFolder folder;
  EXPECT_EXIT(EndOnAFullDisk(folder.path() / "trace"), ::testing::ExitedWithCode(0), "");
}

}  // namespace
}  // namespace tandem
