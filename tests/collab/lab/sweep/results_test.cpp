#include <csignal>
#include <cstring>
#include <set>
#include <string_view>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sys/wait.h>
#include <unistd.h>

#include "collab/lab/metrics/metrics_table.h"
#include "collab/lab/sweep/results_file.h"
#include "tests/collab/lab/sweep/fake_cells.h"

namespace tandem {
namespace {

using testing::ContentOf;
using testing::FakeOutcome;
using testing::HeaderFor;
using testing::RunRest;
using testing::SmallSweep;
using testing::Timeless;

std::uint64_t BitsOf(double value) {
  std::uint64_t bits = 0;
  std::memcpy(&bits, &value, sizeof bits);
  return bits;
}

TEST(Results, AreReadBackBitForBit) {
  const ScratchFolder folder;
  const Sweep sweep = SmallSweep(folder);
  const auto file = folder.path() / "cells.jsonl";
  RunRest(sweep, {}, file, 1);
  const Result<Results> read = ReadResults(file);
  ASSERT_TRUE(read) << read.error().what;
  EXPECT_EQ(read->header, HeaderFor(sweep));
  ASSERT_EQ(read->records.size(), 12U);
  for (const SweepCell& cell : sweep.cells) {
    const CellOutcome made = FakeOutcome(cell);
    const CellRecord& record = read->records.at(cell.number);
    EXPECT_EQ(record.cell.key, cell.key);
    EXPECT_EQ(record.cell.case_json, cell.case_json);
    EXPECT_EQ(record.outcome.result.verdict, Verdict::kStable);
    EXPECT_EQ(record.outcome.result.digest, made.result.digest);
    EXPECT_EQ(BitsOf(record.outcome.predicted->stiffness), BitsOf(made.predicted->stiffness));
    const Metrics& a = record.outcome.result.metrics;
    const Metrics& b = made.result.metrics;
    EXPECT_EQ(BitsOf(a.growth), BitsOf(b.growth));
    EXPECT_EQ(BitsOf(a.generated_J), BitsOf(b.generated_J));
    EXPECT_TRUE(std::isnan(a.settle_s));
    EXPECT_EQ(a.frames, 12000);
  }
}

// each field takes 8 bytes with its padding, so that a field added to the struct is missed here
TEST(MetricFields, CoverEveryMetric) {
  std::set<std::string_view> names;
  for (const MetricField& field : MetricFields()) names.insert(field.name);
  EXPECT_EQ(names.size(), MetricFields().size());
  EXPECT_EQ(8 * names.size(), sizeof(Metrics));
}

TEST(Results, ResumeAfterTheProgramIsKilled) {
  const ScratchFolder folder;
  const Sweep sweep = SmallSweep(folder);
  const auto whole = folder.path() / "whole.jsonl";
  const auto killed = folder.path() / "killed.jsonl";
  RunRest(sweep, {}, whole, 2);

  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    int runs = 0;
    RunRest(sweep, {}, killed, 1, [&runs](const SweepCell& cell) {
      if (++runs == 6) raise(SIGKILL);
      return FakeOutcome(cell);
    });
    _exit(0);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL);
  ASSERT_EQ(ReadResults(killed)->records.size(), 5U);

  int runs = 0;
  RunRest(sweep, {}, killed, 1, [&runs](const SweepCell& cell) {
    ++runs;
    return FakeOutcome(cell);
  });
  EXPECT_EQ(runs, 7);
  EXPECT_EQ(Timeless(ContentOf(killed)), Timeless(ContentOf(whole)));
}

TEST(Results, ResumeFromATruncatedFile) {
  const ScratchFolder folder;
  const Sweep sweep = SmallSweep(folder);
  const auto file = folder.path() / "cells.jsonl";
  RunRest(sweep, {}, file, 1);
  const std::string whole = ContentOf(file);
  for (std::size_t bytes = 0; bytes <= whole.size(); bytes += 97) {
    std::ofstream(file, std::ios::binary) << whole.substr(0, bytes);
    RunRest(sweep, {}, file, 1);
    ASSERT_EQ(Timeless(ContentOf(file)), Timeless(whole)) << bytes;
  }
}

TEST(Results, ResultsOfAnotherSweepShardOrBuildAreRefused) {
  const ScratchFolder folder;
  const Sweep sweep = SmallSweep(folder);
  const auto file = folder.path() / "cells.jsonl";
  RunRest(sweep, {}, file, 1);
  const std::string whole = ContentOf(file);
  ResultsHeader others[4];
  for (ResultsHeader& header : others) header = HeaderFor(sweep);
  others[0].sweep_hash = "0";
  others[1].shard = "1/2";
  others[2].version = "1.3";
  others[3].program = "0";
  for (const ResultsHeader& header : others) {
    const Result<ResultsLog> log = ResultsLog::Open(file, header);
    ASSERT_FALSE(log);
    EXPECT_NE(log.error().what.find("give another --out, or remove it"), std::string::npos);
  }
  EXPECT_EQ(ContentOf(file), whole);
  std::ofstream(file) << "not\nresults\n";
  EXPECT_FALSE(ResultsLog::Open(file, HeaderFor(sweep)));
}

// A count that no integer holds must not be converted to one.
TEST(Results, FractionalCountsAreRefused) {
  const ScratchFolder folder;
  const auto file = folder.path() / "cells.jsonl";
  RunRest(SmallSweep(folder), {}, file, 1);
  const std::string whole = ContentOf(file);
  ASSERT_TRUE(ReadResults(file));
  for (const char* count : {"\"windows\":", "\"trapped_frames\":"}) {
    for (const char* value : {"1e30", "-1", "0.5", "null", "4294967296e9"}) {
      std::string text = whole;
      const std::size_t at = text.find(count) + std::string(count).size();
      ASSERT_LT(at, text.size()) << count;
      text.replace(at, text.find_first_of(",}", at) - at, value);
      std::ofstream(file, std::ios::binary) << text;
      const Result<Results> read = ReadResults(file);
      ASSERT_FALSE(read) << count << value;
      EXPECT_THAT(read.error().what, ::testing::HasSubstr("expected a whole number")) << value;
    }
  }
}

TEST(Results, MergedShardsEqualOneRun) {
  const ScratchFolder folder;
  const Sweep sweep = SmallSweep(folder);
  const auto whole = folder.path() / "whole.jsonl";
  RunRest(sweep, {}, whole, 3);
  std::vector<std::filesystem::path> files;
  for (const std::size_t i : {3U, 1U, 2U}) {
    files.push_back(folder.path() / ("shard-" + std::to_string(i) + ".jsonl"));
    RunRest(sweep, {i, 3}, files.back(), 2);
  }
  Result<Results> merged = Merge(files);
  ASSERT_TRUE(merged) << merged.error().what;
  const auto out = folder.path() / "merged.jsonl";
  ASSERT_FALSE(WriteResults(out, *merged));
  EXPECT_EQ(Timeless(ContentOf(out)), Timeless(ContentOf(whole)));
  EXPECT_EQ(DigestOf(*merged), DigestOf(*ReadResults(whole)));
}

TEST(Results, ResultsOfDifferentSweepsAreNotMerged) {
  const ScratchFolder folder;
  const Sweep sweep = SmallSweep(folder);
  const auto path = [&](const char* name) {
    return folder.path() / name;
  };
  RunRest(sweep, {1, 2}, path("a"), 1);
  RunRest(sweep, {2, 2}, path("b"), 1);
  RunRest(SmallSweep(folder, "8"), {2, 2}, path("c"), 1);
  const auto wrong = [&](std::vector<std::filesystem::path> files) {
    const Result<Results> merged = Merge(files);
    return merged ? "nothing" : merged.error().what;
  };
  EXPECT_EQ(wrong({path("a"), path("b")}), "nothing");
  std::string missing;
  for (const SweepCell& cell : sweep.cells) {
    if (!Shard{1, 2}.Has(cell)) continue;
    missing.append(missing.empty() ? "" : ", ").append(std::to_string(cell.number));
  }
  const std::string first = missing.substr(0, missing.find(','));
  EXPECT_EQ(wrong({path("b")}), "6 of 12 cells are missing: " + missing);
  EXPECT_EQ(wrong({path("a"), path("c")}),
            path("c").string() + ": of another sweep than " + path("a").string());
  EXPECT_EQ(wrong({path("a"), path("b"), path("a")}),
            path("a").string() + ": cell " + first + " is in another file too");
  EXPECT_EQ(wrong({path("a"), path("none")}), path("none").string() + ": there is no such file");
  std::string other = ContentOf(path("b"));
  other.replace(other.find("0123456789abcdef"), 16, "0123456789abcdee");
  std::ofstream(path("b")) << other;
  EXPECT_EQ(wrong({path("a"), path("b")}),
            path("b").string() + ": of another build of tandem than " + path("a").string());
}

/// Reads a results file whose first record is changed, and returns the fault; empty: none.
std::string FaultAfter(const std::string& from, const std::string& to) {
  const ScratchFolder folder;
  const Sweep sweep = SmallSweep(folder);
  const auto file = folder.path() / "cells.jsonl";
  RunRest(sweep, {}, file, 1);
  std::string text = ContentOf(file);
  const std::size_t at = text.find(from, text.find('\n'));
  EXPECT_NE(at, std::string::npos) << from;
  text.replace(at, from.size(), to);
  const Result<Results> read = ReadResults(folder.Write("changed.jsonl", text));
  const std::string what = read ? "" : read.error().what;
  for (const char c : what) EXPECT_GE(static_cast<unsigned char>(c), 0x20) << what;
  return what;
}

TEST(Results, AbsurdRecordsAreRefusedInOneLine) {
  const std::string number = "\"cell\":";
  for (const std::string value : {"-1,\"x\":", "1e308,\"x\":", "0.5,\"x\":", "\"0\",\"x\":",
                                  "null,\"x\":", "99999999999,\"x\":"}) {
    EXPECT_NE(FaultAfter(number, number + value), "") << value;
  }
  EXPECT_NE(FaultAfter(number, number + "0,\"cell\":").find("cell"), std::string::npos);
  EXPECT_NE(FaultAfter("\"verdict\":\"stable\"", "\"verdict\":\"\\u001b[2Jstable\""), "");
  EXPECT_NE(FaultAfter("\"key\":\"", "\"key\":\"\\u001b]0;owned\\u0007"), "");
  EXPECT_NE(FaultAfter("\"key\":\"", "\"key\":\"\x1b]0;owned\x07"), "");
  EXPECT_NE(FaultAfter("\"wall_s\":", "\"wall_s\":1e999,\"x\":"), "");
  EXPECT_NE(FaultAfter("\"wall_s\":", "\"wall_s\":NaN,\"x\":"), "");
  EXPECT_NE(FaultAfter("\"frames\":", "\"frames\":-1,\"x\":"), "");
  EXPECT_NE(FaultAfter("\"frames\":", "\"frames\":1e308,\"x\":"), "");
  EXPECT_NE(FaultAfter("\"case\":", "\"case\":" + std::string(200'000, '[') + ",\"x\":"), "");
  EXPECT_NE(FaultAfter("\"case\":", "\"case\":\"" + std::string(2'000'000, 'x') + "\",\"x\":"), "");
  EXPECT_NE(FaultAfter("\"fault\":null", "\"fault\":\"\\u009b2J\""), "");
}

}  // namespace
}  // namespace tandem
