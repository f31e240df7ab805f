#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sys/wait.h>
#include <unistd.h>

#include "app/common/exit_codes.h"
#include "tests/app/cli/program_run.h"

// Tests `tandem study --dry-run` as a program, in virtual time.

namespace tandem {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::ExpectRefused;
using ::testing::HasSubstr;
using testing::ProgramOutput;
using testing::RunTandem;

// 5 participants, 4 conditions, 2 repetitions: 40 trials. The modelled hand moves 200 mm from 2 s
// to 3 s by minimum jerk, and so is 100 mm away after 2.5 s; in "slow" all times are 1.2 times as
// long.
constexpr const char* kFortyTrials = R"({
  "name": "forty", "seed": 3, "participants": 5,
  "tasks": [{"name": "move", "scene": "free", "time_limit_s": 5, "hands": ["relaxed"],
             "success": {"moved_mm": 100}}],
  "conditions": [{"name": "near"}, {"name": "slow", "planted_slower": 1.2},
                 {"name": "far", "delay_ms": 300},
                 {"name": "lossy", "jitter_ms": 20, "loss": 0.05}],
  "blocks": [{"name": "main", "task": "move", "conditions": ["near", "slow", "far", "lossy"],
              "repetitions": 2}],
  "questions": [{"key": "effort", "text": "How hard was it?", "kind": "scale"}]})";

/// Returns the same study with two participants and one repetition: 8 trials.
std::string EightTrials() {
  std::string text = kFortyTrials;
  text.replace(text.find("\"participants\": 5"), 17, "\"participants\": 2");
  text.replace(text.find("\"repetitions\": 2"), 16, "\"repetitions\": 1");
  return text;
}

std::string TextOf(const fs::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

std::vector<std::string> LinesOf(const fs::path& file) {
  std::istringstream text(TextOf(file));
  std::vector<std::string> lines;
  for (std::string line; std::getline(text, line);) lines.push_back(line);
  return lines;
}

std::size_t CountOf(const fs::path& log, const std::string& event) {
  const std::vector<std::string> lines = LinesOf(log);
  return static_cast<std::size_t>(std::ranges::count_if(lines, [&event](const std::string& line) {
    return line.find("\"event\":\"" + event + "\"") != std::string::npos;
  }));
}

/// Returns results.csv without the two columns that tell when and how often a trial was begun. No
/// cell of a dry run has a comma.
std::string ResultsWithoutTimes(const fs::path& folder) {
  std::string out;
  std::vector<std::size_t> left_out;
  for (const std::string& line : LinesOf(folder / "results.csv")) {
    std::istringstream cells(line);
    std::string cell;
    for (std::size_t i = 0; std::getline(cells, cell, ','); ++i) {
      if (cell == "attempts" || cell == "begun_at") left_out.push_back(i);
      if (std::ranges::count(left_out, i) == 0) out += cell + ",";
    }
    out += "\n";
  }
  return out;
}

json EffectOn(const json& out, const std::string& measure) {
  for (const json& effect : out.at("effect")) {
    if (effect.at("measure") == measure) return effect;
  }
  return nullptr;
}

class StudyCommand : public ::testing::Test {
 protected:
  ProgramOutput Run(const fs::path& folder, const std::string& more = "--dry-run --json") {
    return RunTandem("study " + file_.string() + " --into " + folder.string() + " " + more);
  }
  /// Gives the study fewer trials from here on.
  void TakeEightTrials() { scratch_.Write("forty.json", EightTrials()); }

  /// Starts the study, and kills it as soon as the log has so many of these events.
  void KillAt(const fs::path& folder, const std::string& event, std::size_t count) {
    const pid_t pid = fork();
    if (pid == 0) {
      const std::string into = folder.string();
      const std::string file = file_.string();
      if (std::freopen("/dev/null", "w", stderr) == nullptr) _exit(126);
      execl(TANDEM_PROGRAM, TANDEM_PROGRAM, "study", file.c_str(), "--into", into.c_str(),
            "--dry-run", nullptr);
      _exit(127);
    }
    bool ended = false;
    while (!ended && CountOf(folder / "trials.jsonl", event) < count) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      ended = waitpid(pid, nullptr, WNOHANG) != 0;
    }
    if (ended) return;
    kill(pid, SIGKILL);
    waitpid(pid, nullptr, 0);
  }

  ScratchFolder scratch_;
  const fs::path file_ = scratch_.Write("forty.json", kFortyTrials);
};

TEST_F(StudyCommand, FortyUnattendedTrialsShowThePlantedEffect) {
  const fs::path folder = scratch_.path() / "results";
  const ProgramOutput output = Run(folder);
  ASSERT_EQ(output.exit_code, kExitOk) << output.err;
  const json out = json::parse(output.out);
  EXPECT_EQ(out.at("trials"), 40);
  EXPECT_EQ(out.at("done"), 40);
  EXPECT_EQ(out.at("lost"), 0);
  EXPECT_EQ(out.at("conditions").at(1).at("done"), 10);

  // slow adds a fifth of the time without it, which is 2.5 s and the spring's lag; the paces of
  // trials differ by 3 %
  const json completion = EffectOn(out, "completion_s").at("conditions");
  const double near_s = completion.at(0).at("mean");
  EXPECT_NEAR(near_s, 2.5, 0.3);
  const json& slow = completion.at(1).at("difference");
  EXPECT_EQ(slow.at("participants"), 5);
  EXPECT_NEAR(slow.at("mean").get<double>(), 0.2 * near_s, 0.1);
  EXPECT_GT(slow.at("low").get<double>(), 0.3);
  EXPECT_GT(slow.at("effect_size").get<double>(), 3);
  // the body goes at most 375 mm/s, and the other instance learns it 0.3 s later: 112 mm
  const json apart = EffectOn(out, "divergence_mm").at("conditions");
  const json& far = apart.at(2).at("difference");
  EXPECT_NEAR(far.at("mean").get<double>(), 112, 30);
  EXPECT_GT(far.at("low").get<double>(), 60);
  // answers are drawn at random
  const json effort = EffectOn(out, "answer_effort");
  EXPECT_EQ(effort.at("conditions").at(0).at("participants"), 5);

  EXPECT_EQ(LinesOf(folder / "results.csv").size(), 41U);
  for (const char* file : {"codebook.md", "codebook.json", "report.html", "effect.json",
                           "study.json", "pictures/move-completion_s.svg"}) {
    EXPECT_TRUE(fs::exists(folder / file)) << file;
  }
}

TEST_F(StudyCommand, KillsDoNotChangeTheResult) {
  const fs::path whole = scratch_.path() / "whole";
  const fs::path killed = scratch_.path() / "killed";
  ASSERT_EQ(Run(whole).exit_code, kExitOk);
  // the kills are more than a trial apart, so that none is cut twice
  KillAt(killed, "begun", 1);
  KillAt(killed, "begun", 3);
  KillAt(killed, "answered", 6);
  KillAt(killed, "begun", 15);
  KillAt(killed, "answered", 22);
  KillAt(killed, "begun", 35);
  const ProgramOutput output = Run(killed);
  ASSERT_EQ(output.exit_code, kExitOk) << output.err;
  EXPECT_EQ(json::parse(output.out).at("done"), 40);
  EXPECT_EQ(ResultsWithoutTimes(killed), ResultsWithoutTimes(whole));
  // at least one kill was within a trial, and no trial was measured twice
  EXPECT_GT(CountOf(killed / "trials.jsonl", "begun"), 40U);
  EXPECT_EQ(CountOf(killed / "trials.jsonl", "ran"), 40U);
}

// The log ends there where the program is killed between two of its lines.
TEST_F(StudyCommand, ResumesFromAnyLineOfItsLog) {
  TakeEightTrials();
  const fs::path whole = scratch_.path() / "whole";
  ASSERT_EQ(Run(whole).exit_code, kExitOk);
  const std::vector<std::string> log = LinesOf(whole / "trials.jsonl");
  const fs::path cut = scratch_.path() / "cut";
  // header, consent, then begun, ran, answered for each trial
  for (const std::size_t lines : {1, 2, 3, 4, 5, 12, 13, 14}) {
    fs::remove_all(cut);
    fs::copy(whole, cut, fs::copy_options::recursive);
    std::ofstream out(cut / "trials.jsonl", std::ios::trunc);
    for (std::size_t i = 0; i < lines; ++i) out << log[i] << "\n";
    out << log[lines].substr(0, log[lines].size() / 2);
    out.close();
    const ProgramOutput output = Run(cut);
    ASSERT_EQ(output.exit_code, kExitOk) << lines << ": " << output.err;
    EXPECT_EQ(ResultsWithoutTimes(cut), ResultsWithoutTimes(whole)) << lines;
  }
}

TEST_F(StudyCommand, TrialsCaseReproducesIt) {
  TakeEightTrials();
  const fs::path folder = scratch_.path() / "results";
  ASSERT_EQ(Run(folder).exit_code, kExitOk);
  for (const auto& participant : fs::directory_iterator(folder)) {
    const fs::path trial = participant.path() / "trial-002";
    if (!fs::exists(trial)) continue;
    const fs::path series = scratch_.path() / "again.csv";
    RunTandem("stability run --every-ms 10 --series " + series.string() + " " +
              (trial / "case.json").string());
    EXPECT_EQ(TextOf(series), TextOf(trial / "series.csv"));
    EXPECT_THAT(TextOf(trial / "answers.json"), HasSubstr("effort"));
    return;
  }
  FAIL() << "no trial was kept";
}

TEST_F(StudyCommand, WithdrawalErasesTheParticipant) {
  TakeEightTrials();
  const fs::path folder = scratch_.path() / "results";
  ASSERT_EQ(Run(folder).exit_code, kExitOk);
  const std::string row = LinesOf(folder / "results.csv").at(1);
  const std::string who = row.substr(0, row.find(','));
  EXPECT_TRUE(fs::exists(folder / who));
  const ProgramOutput output = Run(folder, "--json --withdraw " + who);
  ASSERT_EQ(output.exit_code, kExitOk) << output.err;
  EXPECT_EQ(json::parse(output.out).at("done"), 4);
  EXPECT_FALSE(fs::exists(folder / who));
  EXPECT_EQ(TextOf(folder / "results.csv").find(who), std::string::npos);
}

TEST_F(StudyCommand, ResultsAreReadableInThreeLinesOfPython) {
  TakeEightTrials();
  const fs::path folder = scratch_.path() / "results";
  ASSERT_EQ(Run(folder).exit_code, kExitOk);
  // the three lines of docs/studies.md
  const std::string guide = TextOf(TANDEM_SOURCE_DIR "/docs/studies.md");
  const std::size_t begin = guide.find("import csv\n");
  ASSERT_NE(begin, std::string::npos);
  const fs::path script =
      scratch_.Write("three.py", guide.substr(begin, guide.find("```", begin) - begin));
  const std::string command =
      "cd " + scratch_.path().string() + " && python3 " + script.string() + " > read.txt 2>&1";
  ASSERT_EQ(std::system(command.c_str()), 0) << TextOf(scratch_.path() / "read.txt");
  const std::string read = TextOf(scratch_.path() / "read.txt");
  EXPECT_THAT(read, HasSubstr("'near': ["));
  EXPECT_EQ(std::ranges::count(read, ','), 7);  // 8 values in four lists
}

TEST_F(StudyCommand, DataOfParticipantsIsForItsUserAlone) {
  TakeEightTrials();
  const fs::path folder = scratch_.path() / "private";
  ASSERT_EQ(Run(folder).exit_code, kExitOk);
  std::size_t seen = 0;
  const auto others = fs::perms::group_all | fs::perms::others_all;
  EXPECT_EQ(fs::status(folder).permissions() & others, fs::perms::none);
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    ++seen;
    EXPECT_EQ(entry.status().permissions() & others, fs::perms::none) << entry.path();
  }
  EXPECT_GT(seen, 10U);
  // a file of before becomes private, too
  fs::permissions(folder / "results.csv", fs::perms::others_read, fs::perm_options::add);
  fs::permissions(folder / "trials.jsonl", fs::perms::others_read, fs::perm_options::add);
  ASSERT_EQ(Run(folder).exit_code, kExitOk);
  for (const char* file : {"results.csv", "trials.jsonl"}) {
    EXPECT_EQ(fs::status(folder / file).permissions() & others, fs::perms::none) << file;
  }
}

TEST_F(StudyCommand, RefusesNamesWithoutStoringThem) {
  const fs::path folder = scratch_.path() / "results";
  const ProgramOutput output = Run(folder, "--dry-run --participant Gwendolyn");
  ExpectRefused(output, kExitUsage,
                "this is not a pseudonym of this study; the study keeps no names");
  EXPECT_EQ(output.err.find("Gwendolyn"), std::string::npos);
  const std::string found = "grep -r Gwendolyn " + folder.string() + " >/dev/null 2>&1";
  EXPECT_NE(std::system(found.c_str()), 0);
}

TEST_F(StudyCommand, RefusedConsentStoresNothing) {
  const fs::path folder = scratch_.path() / "results";
  const std::string out = (scratch_.path() / "out").string();
  const std::string command = "echo no | " TANDEM_PROGRAM " study --device none " + file_.string() +
                              " --into " + folder.string() + " >" + out + " 2>&1";
  EXPECT_EQ(std::system(command.c_str()), 0) << TextOf(out);
  EXPECT_THAT(TextOf(out), HasSubstr("Nothing was recorded."));
  EXPECT_EQ(LinesOf(folder / "trials.jsonl").size(), 1U);
}

TEST_F(StudyCommand, RefusesADifferentStudyInTheSameFolder) {
  const fs::path folder = scratch_.path() / "results";
  ASSERT_EQ(Run(folder, "--results").exit_code, kExitOk);
  std::ofstream(file_, std::ios::app) << "\n";
  ExpectRefused(Run(folder, "--results"), kExitFile, "belongs to another study file");
}

TEST_F(StudyCommand, ReportsErrorsBeforeConsent) {
  std::string text = kFortyTrials;
  text.replace(text.find("\"moved_mm\": 100"), 15, "\"out\": true");
  const fs::path file = scratch_.Write("out.json", text);
  ExpectRefused(RunTandem("study --dry-run " + file.string() + " --into " +
                          (scratch_.path() / "none").string()),
                kExitFile, "the scene free has no fixed body");
}

// The repository's example can be run.
TEST_F(StudyCommand, ExampleIsAValidStudy) {
  const fs::path folder = scratch_.path() / "example";
  const ProgramOutput output = RunTandem("study " TANDEM_SOURCE_DIR
                                         "/scenes/studies/peg_removal.json --results "
                                         "--json --into " +
                                         folder.string());
  ASSERT_EQ(output.exit_code, kExitOk) << output.err;
  EXPECT_EQ(json::parse(output.out).at("trials"), 42);
  // the results that the repository shows have the same columns
  const fs::path shown = TANDEM_SOURCE_DIR "/docs/results/peg-removal";
  EXPECT_EQ(TextOf(folder / "codebook.md"), TextOf(shown / "codebook.md"));
  EXPECT_EQ(LinesOf(folder / "results.csv").front(), LinesOf(shown / "results.csv").front());
}

}  // namespace
}  // namespace tandem
