#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/common/exit_codes.h"
#include "app/judgement/demo_judgement.h"
#include "app/recording/recording_trace.h"
#include "app/recording/trace_file.h"
#include "tests/app/cli/program_run.h"

// Tests `tandem study` with real peers over DDS, in real time.

namespace tandem {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::ProgramOutput;
using testing::RunTandem;

/// Returns a study of one participant. Sites of equally named studies meet in one session, and
/// tests run at the same time, so each names its own.
std::string StudyText(const std::string& name, const std::string& conditions) {
  return R"({"name": ")" + name + R"(", "seed": 3, "participants": 1,
    "tasks": [{"name": "move", "scene": "free", "time_limit_s": 4, "hands": ["relaxed"],
               "success": {"moved_mm": 100}}],
    "conditions": [{"name": "near"}, {"name": "secretly_late", "delay_ms": 150}],
    "blocks": [{"name": "main", "task": "move", "conditions": )" +
         conditions + R"(, "order": "as_written"}],
    "questions": [{"key": "effort", "text": "How hard was it?", "kind": "scale"},
                  {"key": "remark", "text": "Anything else?", "kind": "text"}]})";
}

std::string ContentOf(const fs::path& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  return text.str();
}

fs::path FirstTrial(const fs::path& folder) {
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (fs::exists(entry.path() / "trial-001")) return entry.path() / "trial-001";
  }
  return {};
}

/// Returns the number in the column of that name of a row; -1: the cell is empty.
double ColumnOf(const std::string& header, const std::string& row, const std::string& name) {
  std::istringstream names(header);
  std::istringstream cells(row);
  std::string cell;
  for (std::string column; std::getline(names, column, ',');) {
    std::getline(cells, cell, ',');
    if (column == name) return cell.empty() ? -1 : std::stod(cell);
  }
  ADD_FAILURE() << "no column " << name;
  return -1;
}

TEST(StudyLive, RealPeersWithModelledHandsRunUnattendedAndAreRecorded) {
  const ScratchFolder scratch;
  const fs::path file =
      scratch.Write("live.json", StudyText("live-modelled", R"(["near", "secretly_late"])"));
  const fs::path folder = scratch.path() / "results";
  const ProgramOutput output = RunTandem("study --dry-run --real-time --json --into " +
                                         folder.string() + " " + file.string());
  ASSERT_EQ(output.exit_code, kExitOk) << output.err;
  const json out = json::parse(output.out);
  EXPECT_EQ(out.at("done"), 2);
  for (const json& effect : out.at("effect")) {
    const double near = effect.at("conditions").at(0).at("mean").get<double>();
    const double late = effect.at("conditions").at(1).at("mean").get<double>();
    // a busy machine makes a delay longer, not shorter
    if (effect.at("measure") == "delay_ms") {
      EXPECT_GT(late, 149);
    }
    if (effect.at("measure") == "divergence_mm") {
      EXPECT_GT(late, near);
    }
    // the hand moves from 2 s to 3 s, times its pace
    if (effect.at("measure") == "completion_s") {
      EXPECT_NEAR(near, 2.5, 0.8);
    }
  }
  const fs::path trial = FirstTrial(folder);
  ASSERT_FALSE(trial.empty());
  for (const char* kept : {"case.json", "user-0.recording", "user-0.report.json", "trial.mcap",
                           "answers.json", "user-1.recording", "user-0.plan.json"}) {
    EXPECT_TRUE(fs::exists(trial / kept)) << kept;
  }
  EXPECT_EQ(ContentOf(trial / "trial.mcap").substr(1, 4), "MCAP");
  // the hand moves from 2 s to 3 s times its pace, and is half way at the goal; a second more is
  // kept
  const json report = json::parse(ContentOf(trial / "user-0.report.json"));
  EXPECT_LT(report.at("traced_frames").get<double>(), 5000)
      << "it ran on to its limit of 4 s and more";
  // the motion that was heard of the partner, dated by the echoes, is the motion that the partner
  // traced itself
  const fs::path late = trial.parent_path() / "trial-002";
  const auto own = ReadTrace(late / "user-0.report.json.trace");
  const auto partner = ReadTrace(late / "user-1.report.json.trace");
  const auto received = TraceOfRecording(late / "user-0.recording", 0);
  ASSERT_TRUE(own && partner && received);
  const double apart = DivergenceOf(*own, *partner).peak;
  EXPECT_GT(apart, 0.01);
  EXPECT_NEAR(DivergenceOf(*own, *received).peak, apart, 0.05 * apart);
  const ProgramOutput replayed = RunTandem("replay " + (trial / "user-0.recording").string());
  EXPECT_EQ(replayed.exit_code, kExitOk) << replayed.err;
}

// A person without a motor consents, begins, ends the trial by Enter once the hand has the body,
// and answers. No line names the condition.
TEST(StudyLive, ParticipantDoesNotLearnTheCondition) {
  const ScratchFolder scratch;
  const fs::path file = scratch.Write("live.json", StudyText("live-asked", R"(["secretly_late"])"));
  const fs::path folder = scratch.path() / "results";
  const std::string out = (scratch.path() / "out").string();
  const std::string begun = "until [ -s " + folder.string() +
                            "/*/trial-001.unfinished/user-0.report.json.trace ]; do sleep "
                            "0.1; done";
  const std::string typed =
      "{ printf 'yes\\n\\n'; " + begun + "; printf '\\n9\\n6\\nit was sticky\\n'; }";
  const std::string command = typed +
                              " | timeout 100 " TANDEM_PROGRAM " study --device none --into " +
                              folder.string() + " " + file.string() + " >" + out + " 2>&1";
  EXPECT_EQ(std::system(command.c_str()), 0) << ContentOf(out);
  const std::string shown = ContentOf(out);
  EXPECT_THAT(shown, HasSubstr("Your pseudonym is P"));
  EXPECT_THAT(shown, HasSubstr("Trial 1."));
  EXPECT_THAT(shown, HasSubstr("'9' is not an answer"));
  EXPECT_THAT(shown, HasSubstr("That was the last trial."));
  EXPECT_THAT(shown, Not(HasSubstr("late")));
  EXPECT_THAT(shown, Not(HasSubstr("150")));
  EXPECT_THAT(shown, Not(HasSubstr("delay")));
  const std::string results = ContentOf(folder / "results.csv");
  EXPECT_THAT(results, HasSubstr(",done,1,20"));
  EXPECT_THAT(results, HasSubstr(",6,it was sticky"));
}

// No Enter ends the trial: the hand is where its goal is from the beginning.
TEST(StudyLive, TrialEndsAtItsGoal) {
  const ScratchFolder scratch;
  std::string text = StudyText("live-goal", R"(["near"])");
  text.replace(text.find("\"moved_mm\": 100"), 15, "\"moved_mm\": 60, \"hold_s\": 0.5");
  text.replace(text.find("\"time_limit_s\": 4"), 17, "\"time_limit_s\": 90");
  text.replace(text.find(",\n    \"questions\""), std::string::npos, "}");
  const fs::path file = scratch.Write("live.json", text);
  const fs::path folder = scratch.path() / "results";
  const ProgramOutput output = RunTandem("study --dry-run --real-time --json --into " +
                                         folder.string() + " " + file.string());
  ASSERT_EQ(output.exit_code, kExitOk) << output.err;
  const json report = json::parse(ContentOf(FirstTrial(folder) / "user-0.report.json"));
  EXPECT_LT(report.at("traced_frames").get<double>(), 20000);
}

// The participant presses Enter, the partner does nothing. Neither waits for the limit.
TEST(StudyLive, TwoSiteTrialEndsAtBothSites) {
  const ScratchFolder scratch;
  std::string text = StudyText("live-both-end", R"(["near"])");
  text.replace(text.find("\"participants\": 1"), 17,
               "\"participants\": 1, \"partner\": \"person\"");
  text.replace(text.find("\"time_limit_s\": 4"), 17, "\"time_limit_s\": 300");
  text.replace(text.find(",\n    \"questions\""), std::string::npos, "}");
  const fs::path file = scratch.Write("live.json", text);
  const std::string begun = "until [ -s " + (scratch.path() / "participant").string() +
                            "/*/trial-001.unfinished/user-0.report.json.trace ]; do sleep 0.1; "
                            "done; sleep 1; echo";
  const auto site = [&](const std::string& name, const std::string& typed) {
    const std::string folder = (scratch.path() / name).string();
    return "{ printf 'yes\n\n'; " + typed +
           "; } | timeout 100 " TANDEM_PROGRAM " study --device none --interface lo --site " +
           name + " --into " + folder + " " + file.string() + " >" + folder + ".out 2>&1";
  };
  const std::string command =
      "( " + site("partner", "true") + " ) & " + site("participant", begun) + "; wait";
  EXPECT_EQ(std::system(command.c_str()), 0);
  for (const char* name : {"participant", "partner"}) {
    EXPECT_THAT(ContentOf(scratch.path() / name / "results.csv"), HasSubstr(",done,1,20"))
        << ContentOf(scratch.path() / (std::string(name) + ".out"));
  }
}

// the partner's site has its own consent, its own answers and its own trace of what it heard
TEST(StudyLive, TwoSitesRunTheSameTrialTogether) {
  const ScratchFolder scratch;
  std::string text = StudyText("live-both-run", R"(["secretly_late"])");
  text.replace(text.find("\"participants\": 1"), 17,
               "\"participants\": 1, \"partner\": \"person\"");
  const fs::path file = scratch.Write("live.json", text);
  const auto site = [&](const std::string& name) {
    const std::string folder = (scratch.path() / name).string();
    // the answers to questions are typed once the trial has run
    return "{ printf 'yes\\n\\n'; until ls " + folder +
           "/*/trial-001/case.json; do sleep 0.1; done; printf '4\\nfine\\n'; } 2>/dev/null | "
           "timeout 100 " TANDEM_PROGRAM " study --device none --interface lo --site " +
           name + " --into " + folder + " " + file.string() + " >" + folder + ".out 2>&1";
  };
  const std::string command = "( " + site("partner") + " ) & " + site("participant") + "; wait";
  EXPECT_EQ(std::system(command.c_str()), 0);
  for (const char* name : {"participant", "partner"}) {
    const std::string results = ContentOf(scratch.path() / name / "results.csv");
    EXPECT_THAT(results, HasSubstr(",done,1,20"))
        << ContentOf(scratch.path() / (std::string(name) + ".out"));
    EXPECT_THAT(results, HasSubstr(",4,fine"));
    const fs::path trial = FirstTrial(scratch.path() / name);
    const char* own = name == std::string("partner") ? "user-1" : "user-0";
    EXPECT_TRUE(fs::exists(trial / (std::string(own) + ".recording"))) << name;
    const json report = json::parse(ContentOf(trial / (std::string(own) + ".report.json")));
    EXPECT_GT(report.at("delay_ms").get<double>(), 149);
    std::istringstream rows(results);
    std::string header;
    std::string row;
    std::getline(rows, header);
    std::getline(rows, row);
    EXPECT_GE(ColumnOf(header, row, "divergence_mm"), 0) << row;
  }
}

}  // namespace
}  // namespace tandem
