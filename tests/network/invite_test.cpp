#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "collab/dds/security/keys.h"
#include "tests/network/running_program.h"
#include "tests/network/two_networks.h"
#include "tests/support/scratch_folder.h"

// A person in one network invites a person in another one, who has nothing but the line.

namespace tandem::testing {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using Clock = std::chrono::steady_clock;

// longest time from `tandem join` to the part in hand
constexpr double kJoinedWithin = 15;  // s

class Invite : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!networks_.why_not().empty()) GTEST_SKIP() << networks_.why_not();
  }
  std::filesystem::path In(const std::string& name) const { return folder_.path() / name; }

  /// Starts Anna, who has the peg in hand, in her network.
  std::unique_ptr<Program> Anna(const std::vector<std::string>& further = {}) const {
    std::vector<std::string> command{TANDEM_PROGRAM, "peer",   "--session", kSession, "--scene",
                                     "peg_in_slot",  "--hold", "peg",       "--name", "anna"};
    command.insert(command.end(), further.begin(), further.end());
    auto anna = std::make_unique<Program>(networks_.Here(command), In("anna"));
    EXPECT_TRUE(anna->Says("you hold peg")) << anna->output();
    return anna;
  }
  /// Starts `tandem invite` and reads its line.
  std::unique_ptr<Program> Inviter(const std::vector<std::string>& further, std::string& line) {
    std::vector<std::string> command{TANDEM_PROGRAM, "invite", kSession};
    command.insert(command.end(), further.begin(), further.end());
    auto inviter = std::make_unique<Program>(networks_.Here(command), In("invite"));
    EXPECT_TRUE(inviter->Says("tandem://")) << inviter->output();
    EXPECT_TRUE(inviter->Says("this line"));
    for (const std::string& one : LinesOf(inviter->output())) {
      if (one.rfind("tandem://", 0) == 0) line = one;
    }
    return inviter;
  }
  /// Starts `tandem join` in the other network, as somebody with a home of their own.
  std::unique_ptr<Program> Joiner(const std::string& line, const std::string& home,
                                  const std::vector<std::string>& further = {}) {
    std::vector<std::string> command{"env",          "XDG_DATA_HOME=" + In(home).string(),
                                     TANDEM_PROGRAM, "join",
                                     line,           "--hold",
                                     "peg",          "--name",
                                     "ben",          "--json"};
    command.insert(command.end(), further.begin(), further.end());
    return std::make_unique<Program>(networks_.There(command),
                                     In("joiner-" + std::to_string(++joiners_)));
  }
  /// Returns what the joiner prints once it holds the peg, and expects that it does in time.
  json Entered(const Program& joiner, Clock::time_point begin) {
    EXPECT_TRUE(joiner.Says("\"holding\"", kJoinedWithin)) << joiner.output();
    const double took = std::chrono::duration<double>(Clock::now() - begin).count();
    EXPECT_LT(took, kJoinedWithin);
    RecordProperty("seconds_to_join", std::to_string(took));
    for (const std::string& one : LinesOf(joiner.output())) {
      if (one.rfind('{', 0) == 0) return json::parse(one, nullptr, false);
    }
    return {};
  }
  static void End(Program& program) {
    program.process().Signal(SIGTERM);
    EXPECT_EQ(program.Wait(), 0) << program.output();
  }

  static constexpr const char* kSession = "Nose gear";
  ScratchFolder folder_;
  int joiners_ = 0;
  TwoNetworks networks_;
};

TEST_F(Invite, RemoteUserJoinsAndGrabsWithOnlyTheInvitation) {
  const auto anna = Anna();
  std::string line;
  const auto inviter = Inviter({}, line);
  EXPECT_EQ(inviter->Wait(), 0);
  EXPECT_THAT(line, HasSubstr(TwoNetworks::kHere));
  const Clock::time_point begin = Clock::now();
  const auto ben = Joiner(line, "ben");
  const json entered = Entered(*ben, begin);
  EXPECT_EQ(entered.at("session"), kSession);
  EXPECT_EQ(entered.at("secured"), false);
  EXPECT_EQ(entered.at("holding"), "peg");
  EXPECT_TRUE(anna->Says("ben joined"));
  // here the session is heard of, there it is not
  const Program received(networks_.Here({TANDEM_PROGRAM, "sessions", "--json"}), In("heard"));
  const Program unheard(networks_.There({TANDEM_PROGRAM, "sessions", "--json"}), In("unheard"));
  EXPECT_TRUE(received.Says(R"([{"session":"Nose gear","secured":false,"relay":false}])"));
  EXPECT_TRUE(unheard.Says(R"("sessions":[])")) << unheard.output();
  End(*ben);
  End(*anna);
}

TEST_F(Invite, FirstInvitationHolderAloneBecomesAMember) {
  ASSERT_TRUE(MakeSessionKeys(In("keys")));
  ASSERT_TRUE(MakeMemberKeys(In("keys"), "anna", Role::kActive, In("keys-anna")));
  // as docs/two-sites.md says it, with ports for a router to map
  const std::vector<std::string> mapped{"--external-address", TwoNetworks::kHere, "--port",
                                        "17910"};
  std::vector<std::string> annas = mapped;
  annas.insert(annas.end(), {"--secure", In("keys-anna").string()});
  const auto anna = Anna(annas);
  std::vector<std::string> inviting = mapped;
  inviting.insert(inviting.end(), {"--keys", In("keys").string(), "--name", "ben"});
  std::string line;
  const auto inviter = Inviter(inviting, line);
  const Clock::time_point begin = Clock::now();
  const auto ben =
      Joiner(line, "ben", {"--external-address", TwoNetworks::kThere, "--port", "17910"});
  const json entered = Entered(*ben, begin);
  EXPECT_EQ(entered.at("secured"), true);
  EXPECT_EQ(entered.at("name"), "ben");
  EXPECT_EQ(entered.at("holding"), "peg");
  EXPECT_TRUE(anna->Says("ben joined"));
  EXPECT_EQ(inviter->Wait(), 0) << inviter->output();

  // somebody else has read the mail
  const auto eve = Joiner(line, "eve");
  EXPECT_EQ(eve->Wait(), 5) << eve->output();
  EXPECT_THAT(eve->output(), HasSubstr("was used or withdrawn"));
  EXPECT_EQ(LinesOf(eve->output()).size(), 1U) << eve->output();
  EXPECT_FALSE(std::filesystem::exists(In("eve") / "tandem" / "keys" / "identity.key"));
  End(*ben);
  // a person who has become a member by the line can come back by it
  const auto back = Joiner(line, "ben");
  EXPECT_EQ(Entered(*back, Clock::now()).at("name"), "ben");
  EXPECT_THAT(back->output(), HasSubstr("using them"));
  End(*back);
  End(*anna);
}

}  // namespace
}  // namespace tandem::testing
