#include "collab/trace/trace_file.h"

#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>

#include "collab/trace/trace_models.h"
#include "collab/trace/trace_store.h"
#include "tests/support/scratch_folder.h"

namespace tandem {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr const char* kHeader = "# {\"tandem_trace\": 1, \"rate_hz\": 500}\n";

TEST(NetworkTraceFile, RoundTrips) {
  const ScratchFolder folder;
  const NetworkTrace trace{.rate_hz = 250,
                           .there_ms = {AsInFile(1.25), NetworkTrace::kLost, AsInFile(0)},
                           .back_ms = {AsInFile(3.001), AsInFile(2), NetworkTrace::kLost},
                           .source = "by hand",
                           .clock_bound_ms = 0.125};
  const std::filesystem::path file = folder.path() / "trace.csv";
  ASSERT_FALSE(WriteNetworkTrace(file, trace));
  const Result<NetworkTrace> read = ReadNetworkTrace(file);
  ASSERT_TRUE(read) << read.error().what;
  EXPECT_EQ(read->rate_hz, 250);
  EXPECT_EQ(read->there_ms, trace.there_ms);
  EXPECT_EQ(read->back_ms, trace.back_ms);
  EXPECT_EQ(read->source, "by hand");
  EXPECT_EQ(read->clock_bound_ms, 0.125);
}

TEST(NetworkTraceFile, SingleDirectionServesBoth) {
  const ScratchFolder folder;
  const Result<NetworkTrace> read = ReadNetworkTrace(
      folder.Write("one.csv", std::string(kHeader) + "seq,there_ms\n0,5\n1,\n2,7.5\n"));
  ASSERT_TRUE(read) << read.error().what;
  EXPECT_THAT(read->there_ms, ElementsAre(5, NetworkTrace::kLost, 7.5));
  EXPECT_EQ(read->back_ms, read->there_ms);
  EXPECT_LT(read->clock_bound_ms, 0);
}

TEST(NetworkTraceFile, ErrorsNameTheLine) {
  const ScratchFolder folder;
  const auto fault = [&folder](const std::string& text) {
    const Result<NetworkTrace> read = ReadNetworkTrace(folder.Write("bad.csv", text));
    return read ? std::string("none") : read.error().what;
  };
  const std::string columns = "seq,there_ms,back_ms\n";
  EXPECT_THAT(fault(""), HasSubstr("bad.csv:1: is no trace"));
  EXPECT_THAT(fault("seq,there_ms\n0,1\n"), HasSubstr("bad.csv:1: is no trace"));
  EXPECT_THAT(fault("# {\"tandem_trace\": 2, \"rate_hz\": 500}\n"), HasSubstr("tandem_trace"));
  EXPECT_THAT(fault("# {\"tandem_trace\": 1, \"rate_hz\": 0}\n"), HasSubstr("rate_hz"));
  EXPECT_THAT(fault(kHeader + std::string("seq,delay\n0,1\n")), HasSubstr("bad.csv:2"));
  EXPECT_THAT(fault(kHeader + columns), HasSubstr("no sample"));
  for (const char* row : {"1,2,3", "0,2", "0,2,3,4", "0,-1,3", "0,x,3", "0,nan,3", "0,2,10001",
                          "0, 2,3", "-0,2,3", ""}) {
    SCOPED_TRACE(row);
    EXPECT_THAT(fault(kHeader + columns + row + "\n"), HasSubstr("bad.csv:3: expected 0"));
  }
  EXPECT_THAT(fault(kHeader + columns + "0,1,1\n" + std::string(5000, '1') + "\n"),
              HasSubstr("too long"));
}

TEST(NetworkTraceFile, AbsurdFilesAreRefusedInOneLine) {
  const ScratchFolder folder;
  const auto expect_refused = [&folder](const std::string& text, const std::string& why) {
    const Result<NetworkTrace> read = ReadNetworkTrace(folder.Write("bad.csv", text));
    ASSERT_FALSE(read) << text.substr(0, 100);
    EXPECT_THAT(read.error().what, HasSubstr(why));
    for (const char c : read.error().what) {
      ASSERT_GE(static_cast<unsigned char>(c), 0x20) << read.error().what;
    }
  };
  const std::string columns = std::string(kHeader) + "seq,there_ms,back_ms\n";
  for (const std::string cell : {"nan", "inf", "-1", "-0.001", "1e308", "1e309", "1e-400", "10001",
                                 "0x1", "+1", " 1", "=1+1", "\x1b[2J", "1\t"}) {
    expect_refused(columns + "0," + cell + ",1\n", "bad.csv:3: expected 0 and delays");
    expect_refused(columns + "0,1," + cell + "\n", "bad.csv:3: expected 0 and delays");
  }
  for (const std::string seq : {"-1", "1", "18446744073709551616", "", "0.0", "00x"}) {
    expect_refused(columns + seq + ",1,1\n", "bad.csv:3: expected 0 and delays");
  }
  expect_refused(columns + "0,1,1\n0,1,1\n", "bad.csv:4: expected 1 and delays");
  expect_refused(columns + "0,1,1,1\n", "bad.csv:3");
  const auto header = [](const std::string& keys) {
    return "# {\"tandem_trace\": 1" + keys + "}\nseq,there_ms\n0,1\n";
  };
  expect_refused(header(R"(, "rate_hz": 1e308)"), "rate_hz");
  expect_refused(header(R"(, "rate_hz": -500)"), "rate_hz");
  expect_refused(header(R"(, "rate_hz": 1e999)"), "bad.csv:1");
  expect_refused(header(R"(, "rate_hz": 500, "rate_hz": 1)"), "rate_hz");
  expect_refused(header(R"(, "rate_hz": 500, "clock_bound_ms": -1)"), "clock_bound_ms");
  expect_refused(header(R"(, "rate_hz": 500, "source": "\u001b]0;owned\u0007")"),
                 "control character");
  expect_refused(
      header(R"(, "rate_hz": 500, "x": )" + std::string(2000, '[') + std::string(2000, ']')),
      "bad.csv:1");
  expect_refused("# {" + std::string(10'000, ' ') + "\n", "bad.csv:1: is no trace");
}

TEST(TraceStore, RereadsAFileOnlyAfterAChange) {
  const ScratchFolder folder;
  const auto file = folder.Write("t.csv", std::string(kHeader) + "seq,there_ms,back_ms\n0,5,6\n");
  const auto keep = [&](TraceDirection way, double stretch) {
    const Result<const LinkTrace*> kept = KeepTrace(file, way, stretch);
    EXPECT_TRUE(kept);
    return *kept;
  };
  const LinkTrace* const there = keep(TraceDirection::kThere, 1);
  EXPECT_EQ(keep(TraceDirection::kThere, 1), there);
  EXPECT_EQ(there->samples()[0].delay_ms, 5);
  EXPECT_EQ(keep(TraceDirection::kBack, 1)->samples()[0].delay_ms, 6);
  EXPECT_EQ(keep(TraceDirection::kThere, 3)->samples()[0].delay_ms, 15);
  EXPECT_EQ(keep(TraceDirection::kThere, 3)->source.stretch, 3);
  // the file gets another length, as clocks of files may be coarse
  folder.Write("t.csv", std::string(kHeader) + "seq,there_ms,back_ms\n0,15,6\n");
  EXPECT_EQ(keep(TraceDirection::kThere, 1)->samples()[0].delay_ms, 15);
  EXPECT_EQ(there->samples()[0].delay_ms, 5);  // whoever has it keeps it
}

TEST(TraceStore, SlightlyDifferentScalesAreDistinct) {
  const Result<const LinkTrace*> one = KeepModel("wifi", TraceDirection::kThere, 1);
  const Result<const LinkTrace*> other = KeepModel("wifi", TraceDirection::kThere, 1 + 1e-9);
  ASSERT_TRUE(one && other);
  EXPECT_NE(*one, *other);
}

TEST(TraceStore, SeedChoosesTheStart) {
  const Result<const LinkTrace*> kept = KeepModel("leo", TraceDirection::kThere, 1);
  ASSERT_TRUE(kept);
  const TraceChoice fixed{.there = *kept, .back = *kept, .start_s = 3};
  EXPECT_EQ(fixed.StartFor(1), 3);
  EXPECT_EQ(fixed.StartFor(2), 3);
  TraceChoice mixed = fixed;
  mixed.mix = true;
  EXPECT_EQ(mixed.StartFor(1), mixed.StartFor(1));
  EXPECT_NE(mixed.StartFor(1), mixed.StartFor(2));
  // over many seeds it is anywhere
  double sum = 0;
  for (std::uint64_t seed = 0; seed < 1000; ++seed) {
    const double at = mixed.StartFor(seed) - 3;
    EXPECT_GE(at, 0);
    EXPECT_LT(at, (*kept)->seconds());
    sum += at;
  }
  EXPECT_NEAR(sum / 1000, 0.5 * (*kept)->seconds(), 0.05 * (*kept)->seconds());
}

}  // namespace
}  // namespace tandem
