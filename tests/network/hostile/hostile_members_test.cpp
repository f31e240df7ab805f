// Programs with keys flood: a viewer and a member with a program of the tests' own (attacker.cpp)
// and a plug-in that lets it write what its permissions do not name. Both flood at once, against a
// peer, a relay and a viewer of one secured session.
#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <fstream>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/process/child_processes.h"
#include "collab/dds/security/keys.h"
#include "tests/network/hostile/flood_growth.h"
#include "tests/network/running_program.h"

namespace tandem {
namespace {

using ::testing::HasSubstr;
using testing::kGivenBackSeconds;
using testing::kMostKept;
using testing::LinesOf;
using testing::MemoryAtRest;
using ::testing::Not;
using testing::Program;
using ::testing::SizeIs;

constexpr const char* kEachSeconds = "0.6";            // duration of each flood
constexpr std::int64_t kMostOfEach = 2 * 1024 * 1024;  // bytes that a flood may take at once

std::vector<std::string> LinesWith(const std::string& output, const std::string& words) {
  std::vector<std::string> lines = LinesOf(output);
  std::erase_if(lines, [&words](const std::string& line) {
    return line.find(words) == std::string::npos;
  });
  return lines;
}

/// Anna holds the peg; a relay and a viewer hear her. Vic has a viewer's keys and carl a peer's.
class HostileMembers : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(MakeSessionKeys(In("keys")));
    for (const auto& [name, role] : std::map<std::string, Role>{{"anna", Role::kActive},
                                                                {"carl", Role::kActive},
                                                                {"vic", Role::kViewer},
                                                                {"wes", Role::kViewer},
                                                                {"rita", Role::kViewer}}) {
      ASSERT_TRUE(MakeMemberKeys(In("keys"), name, role, In("keys-" + name)));
    }
    ASSERT_TRUE(MakeSessionKeys(In("audience"), {}, {}, 30, SessionKind::kAudience));
    ASSERT_TRUE(MakeRelayKeys(In("audience"), "rita", In("keys-audience"), 30));
    Start("anna", {"peer", "--scene", TANDEM_SCENES "/peg_in_slot.json", "--hold", "peg",
                   "--capacity", "20000", "--brief", "--report", In("report").string()});
    Start("rita", {"relay", "--audience-secure", In("keys-audience").string()});
    Start("wes", {"watch"});
    // a peer that is here before her would be asked for it
    ASSERT_TRUE(victims_.at("anna")->Says("you hold peg")) << victims_.at("anna")->output();
  }
  void Start(const std::string& name, const std::vector<std::string>& what) {
    std::vector<std::string> words{TANDEM_PROGRAM};
    words.insert(words.end(), what.begin(), what.end());
    words.insert(words.end(), {"--session", session_, "--interface", "lo", "--secure",
                               In("keys-" + name).string()});
    victims_[name] = std::make_unique<Program>(words, In(name));
  }
  std::unique_ptr<Program> Attack(const std::string& name, const std::string& modes) const {
    return std::make_unique<Program>(
        std::vector<std::string>{TANDEM_ATTACKER, session_, In("keys-" + name).string(), "1", modes,
                                 kEachSeconds, "0", "lo", TANDEM_LAX_ACCESS_CONTROL},
        In("attacker-" + name));
  }
  std::filesystem::path In(const std::string& file) const { return folder_.path() / file; }

  const TemporaryFolder folder_;
  const std::string session_ = "members-" + std::to_string(std::random_device{}());
  std::map<std::string, std::unique_ptr<Program>> victims_;
};

TEST_F(HostileMembers, TakeNoMemoryAndFewLinesWhateverTheyFloodWith) {
  const std::vector<std::string> modes{"ends", "events", "flap", "scenes", "views"};
  std::map<std::string, std::unique_ptr<Program>> attackers;
  for (const char* name : {"vic", "carl"})
    attackers[name] = Attack(name, "ends+events+flap+scenes+views");
  Program& anna = *victims_.at("anna");
  for (const auto& [name, attacker] : attackers) {
    ASSERT_TRUE(attacker->Says("joined")) << attacker->output();
  }
  ASSERT_TRUE(anna.Says("vic (viewer) joined")) << anna.output();
  ASSERT_TRUE(anna.Says("carl joined")) << anna.output();
  std::map<std::string, std::int64_t> before;
  MemoryAtRest(anna);
  for (const auto& [name, victim] : victims_) before[name] = victim->Memory();

  std::map<std::string, std::map<std::string, long>> sent_by;
  for (std::size_t flood = 0; flood < modes.size(); ++flood) {
    SCOPED_TRACE(modes[flood]);
    const auto lines_of = [&](const std::string& words) {
      std::map<std::string, std::size_t> lines;
      for (const auto& [name, victim] : victims_) {
        lines[name] = LinesWith(victim->output(), words).size();
      }
      return lines;
    };
    const auto lines = lines_of("");
    const auto of_carl = lines_of(": carl ");
    const auto of_vic = lines_of(": vic ");
    std::map<std::string, std::int64_t> at_first;
    for (const auto& [name, victim] : victims_) at_first[name] = victim->Memory();
    std::map<std::string, std::int64_t> most;
    const auto begun = std::chrono::steady_clock::now();
    for (const auto& [name, attacker] : attackers) attacker->process().Signal(SIGUSR1);
    const auto goes_on = [&] {
      return std::ranges::any_of(attackers, [&](const auto& one) {
        return LinesWith(one.second->output(), "sent ").size() <= flood;
      });
    };
    std::chrono::duration<double> lasted{};
    while (goes_on() && lasted.count() < 20) {
      for (const auto& [name, victim] : victims_) {
        most[name] = std::max(most[name], victim->Memory() - at_first[name]);
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
      lasted = std::chrono::steady_clock::now() - begun;
    }
    for (const auto& [name, attacker] : attackers) {
      const std::vector<std::string> sent = LinesWith(attacker->output(), "sent ");
      ASSERT_THAT(sent, SizeIs(flood + 1)) << name << ": " << attacker->output();
      sent_by[name][modes[flood]] = std::stol(sent.back().substr(sent.back().find("sent ") + 5));
      EXPECT_GT(sent_by[name][modes[flood]], 20) << name;
    }
    for (const auto& [name, victim] : victims_) {
      RecordProperty(name + "_" + modes[flood] + "_kb", static_cast<int>(most[name] / 1024));
      EXPECT_LE(most[name], kMostOfEach) << name;
      const auto lines_more = [&](const auto& before_it, const std::string& words) {
        return static_cast<double>(lines_of(words).at(name) - before_it.at(name));
      };
      EXPECT_LE(lines_more(lines, ""), 10 * (lasted.count() + 1)) << name;
      EXPECT_LE(lines_more(of_carl, ": carl "), lasted.count() + 2) << name;
      EXPECT_LE(lines_more(of_vic, ": vic "), lasted.count() + 2) << name;
    }
  }
  // the thread that hears them all goes on
  attackers.clear();
  EXPECT_TRUE(anna.Says("carl is lost")) << anna.output();
  for (const auto& [name, victim] : victims_) {
    std::int64_t kept = victim->Memory() - before[name];
    for (double waited = 0; kept > kMostKept && waited < kGivenBackSeconds; waited += 0.1) {
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
      kept = std::min(kept, victim->Memory() - before[name]);
    }
    RecordProperty(name + "_kept_kb", static_cast<int>(kept / 1024));
    EXPECT_LE(kept, kMostKept) << name;
    victim->process().Signal(SIGTERM);
  }
  for (const auto& [name, victim] : victims_) {
    EXPECT_EQ(victim->Wait(), 0) << name;
    for (const std::string& line : LinesOf(victim->output())) EXPECT_LT(line.size(), 2000U) << name;
  }
  EXPECT_THAT(anna.output(), Not(HasSubstr("let go of it")));
  std::ifstream stream(In("report"));
  const nlohmann::json drops = nlohmann::json::parse(stream, nullptr, false).at("drops");
  EXPECT_GT(drops.at("flood").get<long>(), sent_by["carl"]["events"] / 2);
  EXPECT_GT(drops.at("many_keys").get<long>(), 200);
}

}  // namespace
}  // namespace tandem
