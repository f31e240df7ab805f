#include <algorithm>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/common/exit_codes.h"
#include "app/process/child_processes.h"
#include "tests/app/cli/peer_program.h"
#include "tests/app/cli/program_run.h"

// Tests the commands of a session as a person uses them: keys, relay, watch, doctor.

namespace tandem {
namespace {

using nlohmann::json;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::ProgramOutput;
using testing::Running;
using testing::RunTandem;

std::string RandomName() {
  return "commands-" + std::to_string(std::random_device{}());
}

/// Expects that a run fails with this code and with one line that has these words.
void ExpectRefused(const std::string& arguments, int exit_code, const std::string& words) {
  const ProgramOutput output = RunTandem(arguments, "timeout 20 ");
  EXPECT_EQ(output.exit_code, exit_code) << arguments << "\n" << output.err;
  EXPECT_THAT(output.err, HasSubstr(words)) << arguments;
  EXPECT_EQ(std::count(output.err.begin(), output.err.end(), '\n'), 1) << output.err;
  EXPECT_EQ(output.out, "") << arguments;
}

/// Expects CLI11's own refusal: a line that says what is wrong, a blank line after it or not, and
/// where help is.
void ExpectUsage(const std::string& arguments, const std::string& words) {
  const ProgramOutput output = RunTandem(arguments, "timeout 20 ");
  EXPECT_EQ(output.exit_code, kExitUsage) << arguments << "\n" << output.err;
  EXPECT_THAT(output.err, HasSubstr(words)) << arguments;
  EXPECT_EQ(output.err.rfind("tandem: ", 0), 0U) << output.err;
  EXPECT_EQ(std::count(output.err.begin(), output.err.end(), '\n'), 1) << output.err;
}

/// Two secured sessions: one for peers, one for viewers behind the relay.
class SecuredSession : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = std::make_unique<ScratchFolder>();
    for (const char* arguments : {"session in", "peer in anna", "viewer in hall",
                                  "session out --audience", "relay out hall", "viewer out vic"}) {
      std::string line = "keys ";
      for (const std::string& word : Words(arguments)) {
        line += (word == "in" || word == "out" ? (folder_->path() / word).string() : word) + " ";
      }
      const ProgramOutput output = RunTandem(line);
      ASSERT_EQ(output.exit_code, 0) << output.err;
    }
  }
  static void TearDownTestSuite() { folder_.reset(); }
  static std::vector<std::string> Words(const std::string& text) {
    std::istringstream stream(text);
    return {std::istream_iterator<std::string>(stream), {}};
  }
  static std::string Keys(const char* of) { return (folder_->path() / of).string(); }

  static ChildProcess Start(const std::string& arguments) {
    std::vector<std::string> command = Words(arguments);
    command.insert(command.begin(), TANDEM_PROGRAM);
    Result<ChildProcess> started = ChildProcess::Start(command);
    EXPECT_TRUE(started);
    return *std::move(started);
  }
  /// Returns the report of a viewer that has looked on for a few seconds.
  static json Watched(const std::string& arguments, const char* seconds) {
    const ProgramOutput output = RunTandem("watch --interface lo --json --seconds " +
                                           std::string(seconds) + " " + arguments);
    EXPECT_EQ(output.exit_code, 0) << output.err;
    return json::parse(output.out, nullptr, false);
  }

  static std::unique_ptr<ScratchFolder> folder_;
};
std::unique_ptr<ScratchFolder> SecuredSession::folder_;

TEST_F(SecuredSession, RelayShowsItToKeyHoldersOnly) {
  const std::string session = RandomName();
  const std::string at = " --interface lo --session " + session;
  ChildProcess anna =
      Start("peer --capacity 20000 --hold peg --scene " TANDEM_SCENES
            "/peg_in_slot.json --hand " TANDEM_SCENES "/peg_in_slot_left.json --secure " +
            Keys("in/anna") + at);
  ChildProcess relay =
      Start("relay --secure " + Keys("in/hall") + " --audience-secure " + Keys("out/hall") + at);
  const std::string behind = "--from-relay --session " + session;

  const json watched = Watched(behind + " --secure " + Keys("out/vic"), "6");
  EXPECT_GT(watched.at("samples").get<int>(), 60);
  EXPECT_EQ(watched.at("peers_seen"), 1);
  const json plain = Watched(behind, "2");
  EXPECT_EQ(plain.at("samples"), 0);
  EXPECT_EQ(plain.at("peers_seen"), 0);
  const json of_the_session = Watched(behind + " --secure " + Keys("in/hall"), "2");
  EXPECT_EQ(of_the_session.at("samples"), 0);

  relay.Signal(SIGTERM);
  anna.Signal(SIGTERM);
  EXPECT_EQ(relay.Wait(std::chrono::seconds(10)), 0);
  EXPECT_EQ(anna.Wait(std::chrono::seconds(10)), 0);
}

TEST_F(SecuredSession, KeysServeOnlyTheirPurpose) {
  const std::string in = " --interface lo --session " + RandomName();
  ExpectRefused("watch --secure " + Keys("in/anna") + in, kExitSecurity, "use keys of a viewer");
  ExpectRefused("watch --secure " + Keys("out/hall") + in, kExitSecurity,
                "the other side of a relay");
  ExpectRefused("relay --secure " + Keys("in/hall") + in, kExitUsage, "--audience-secure");
  ExpectRefused("relay --audience-secure " + Keys("out/vic") + in, kExitSecurity,
                "no keys of a relay");
  ExpectRefused("relay --secure " + Keys("in/anna") + " --audience-secure " + Keys("out/hall") + in,
                kExitSecurity, "use keys of a viewer");
  ExpectRefused("watch --secure " + folder_->path().string() + in, kExitSecurity, "is missing");
}

TEST_F(SecuredSession, KeysAreNotOverwrittenAndNeedTwoAuthorities) {
  ExpectRefused("keys session " + Keys("in"), kExitFile, "never overwritten");
  ExpectRefused("keys session /proc/x", kExitFile, "/proc/x: cannot be made: ");
  ExpectRefused("keys peer " + Keys("in") + " anna", kExitFile, "never overwritten");
  ExpectUsage("keys viewer " + Keys("in") + " ../eve", "is not a member's name");
  ExpectRefused("keys relay " + Keys("nowhere") + " eve", kExitFile, "nowhere: no such folder");
  const std::string one = Keys("in/identity_ca.pem") + " " + Keys("in/identity_ca.key");
  ExpectRefused("keys session " + Keys("both") + " --identity-authority " + one +
                    " --permissions-authority " + one,
                kExitSecurity, "one authority for both");
  EXPECT_FALSE(std::filesystem::exists(Keys("both")));
  ExpectUsage("keys", "subcommand");
  ExpectUsage("keys viewer " + Keys("in"), "NAME");
  ExpectUsage("keys session " + Keys("new") + " --days -1", "--days");
}

// A relay with such keys of the members' own authorities could speak as each member.
TEST_F(SecuredSession, RelayKeysAreMadeInTheAudiencesSessionOnly) {
  ExpectRefused("keys relay " + Keys("in") + " eve", kExitSecurity,
                "'tandem keys session FOLDER --audience'");
  EXPECT_FALSE(std::filesystem::exists(Keys("in/eve")));
  ExpectRefused("keys peer " + Keys("out") + " eve", kExitSecurity, "nobody takes part");
  EXPECT_FALSE(std::filesystem::exists(Keys("out/eve")));
  // the mark does not help either where the authorities are the members'
  const auto authority = [](const char* of) {
    const std::string file = Keys("in/") + of + "_ca";
    return " --" + std::string(of) + "-authority " + file + ".pem " + file + ".key";
  };
  const ProgramOutput session = RunTandem("keys session " + Keys("one") + " --audience" +
                                          authority("identity") + authority("permissions"));
  ASSERT_EQ(session.exit_code, 0) << session.err;
  const ProgramOutput hall = RunTandem("keys relay " + Keys("one") + " hall");
  ASSERT_EQ(hall.exit_code, 0) << hall.err;
  ExpectRefused("relay --secure " + Keys("in/hall") + " --audience-secure " + Keys("one/hall") +
                    " --interface lo --session " + RandomName(),
                kExitSecurity, "of the same authority as");
}

TEST(Watch, ReportsInOneLineWhyItCannotJoin) {
  const std::string session = " --session " + RandomName();
  ExpectUsage("watch", "--session");
  ExpectUsage("watch --domain 231" + session, "--domain");
  ExpectUsage("watch --port 80" + session, "--port");
  ExpectRefused("watch --interface nosuch0" + session, kExitNetwork, "nosuch0");
  ExpectRefused("watch --peers no-such-host.invalid" + session, kExitNetwork,
                "no-such-host.invalid");
  ExpectUsage("watch --peers 127.0.0.1:port" + session, "HOST:PORT");
  ExpectUsage("watch --external-address here" + session, "not an IPv4 address");
  ExpectRefused("watch --scene /nowhere.json" + session, kExitFile, "/nowhere.json");
}

TEST(Watch, EmptySessionSuggestsCausesWithoutCallingItPlain) {
  const std::string there = RandomName();
  const std::string wrong = RandomName();
  const TemporaryFolder folder;
  Running peer("--interface lo --capacity 20000 --hold peg --scene " TANDEM_SCENES
               "/peg_in_slot.json --session " +
                   there,
               folder.path() / "said");
  ASSERT_TRUE(peer.WaitFor("is in session", 60)) << peer.output();
  Running astray("--interface lo --session " + wrong, folder.path() / "astray", "watch");
  EXPECT_TRUE(astray.WaitFor("announced here: ", 60)) << astray.output();
  EXPECT_TRUE(astray.WaitFor(there, 60)) << astray.output();
  EXPECT_EQ(astray.End(), 0);
  EXPECT_THAT(astray.output(),
              AllOf(HasSubstr("no peer answers in session " + wrong), Not(HasSubstr("is plain"))));
  Running viewer("--interface lo --session " + there, folder.path() / "viewer", "watch");
  EXPECT_TRUE(viewer.WaitFor("session " + there + " is plain", 60)) << viewer.output();
  EXPECT_TRUE(viewer.WaitFor("this machine has it: " TANDEM_SCENES "/peg_in_slot.json", 60))
      << viewer.output();
  EXPECT_EQ(viewer.End(), 0);
  // it may say that nobody is heard before it heard the peer, but not afterwards
  EXPECT_THAT(viewer.output().substr(viewer.output().find(" is plain")),
              Not(HasSubstr("no peer answers")));
  EXPECT_EQ(peer.End(), 0);
}

TEST_F(SecuredSession, LooksSecuredToPeersWithoutKeys) {
  const std::string session = RandomName();
  const std::string at = " --interface lo --session " + session;
  const ScratchFolder folder;
  Running anna("--capacity 20000 --hold peg --scene " TANDEM_SCENES "/peg_in_slot.json --secure " +
                   Keys("in/anna") + at,
               folder.path() / "anna");
  ASSERT_TRUE(anna.WaitFor("is in session", 60)) << anna.output();
  Running viewer(at, folder.path() / "viewer", "watch");
  EXPECT_TRUE(viewer.WaitFor("it is secured, and needs a viewer's keys (--secure)", 60))
      << viewer.output();
  EXPECT_EQ(viewer.End(), 0);
  EXPECT_THAT(viewer.output(), Not(HasSubstr("is plain")));
  EXPECT_EQ(anna.End(), 0);
}

TEST(Relay, ReportsInOneLineWhyItCannotJoin) {
  const std::string session = " --session " + RandomName();
  ExpectUsage("relay", "--session");
  ExpectRefused("relay --interface nosuch0" + session, kExitNetwork, "nosuch0");
  ExpectRefused("relay --interface lo --domain 230" + session, kExitNetwork, "domain 231");
  ExpectUsage("relay --interface lo --peers a:b" + session, "HOST:PORT");
}

// The peers meet over loopback: each has a port of its own and names the others, without multicast.
TEST(Relay, ShowsASessionReachableOnlyByNamedAddresses) {
  const std::string session = RandomName();
  const auto start = [&](const std::string& arguments) {
    std::istringstream stream(arguments + " --interface lo --session " + session);
    std::vector<std::string> command{TANDEM_PROGRAM};
    command.insert(command.end(), std::istream_iterator<std::string>(stream), {});
    return *ChildProcess::Start(command);
  };
  // ports of this test: two for the peer, two for the relay, two for those behind it
  const int base = 20000 + 6 * static_cast<int>(std::random_device{}() % 1000);
  const auto port = [base](int i) {
    return std::to_string(base + 2 * i);
  };
  ChildProcess peer =
      start("peer --capacity 20000 --hold peg --scene " TANDEM_SCENES
            "/peg_in_slot.json --hand " TANDEM_SCENES "/peg_in_slot_left.json --port " +
            port(0));
  ChildProcess relay = start("relay --port " + port(1) + " --peers 127.0.0.1:" + port(0) +
                             " --audience-port " + port(2));
  const ProgramOutput output =
      RunTandem("watch --from-relay --json --seconds 6 --interface lo --session " + session +
                " --peers 127.0.0.1:" + port(2));
  ASSERT_EQ(output.exit_code, 0) << output.err;
  EXPECT_GT(json::parse(output.out).at("samples").get<int>(), 60) << output.err;
  relay.Signal(SIGTERM);
  peer.Signal(SIGTERM);
  EXPECT_EQ(relay.Wait(std::chrono::seconds(10)), 0);
  EXPECT_EQ(peer.Wait(std::chrono::seconds(10)), 0);
}

TEST(Peer, ReadsItsNetworkPlanBeforeItJoins) {
  const ScratchFolder folder;
  const std::string plan = folder.Write("plan.json", R"({"links": [{"form": "ben"}]})").string();
  const std::string peer =
      "peer --interface lo --scene " TANDEM_SCENES "/peg_in_slot.json --session " + RandomName();
  ExpectRefused(peer + " --network " + plan, kExitFile, "did you mean from?");
  ExpectRefused(peer + " --network /nowhere.json", kExitFile, "/nowhere.json");
  ExpectUsage(peer + " --delay-ms 5 --network " + plan, "--network");
}

TEST(Doctor, FindsFaultsAndNamesRemedies) {
  const ProgramOutput good = RunTandem("doctor --interface lo --json", "timeout 60 ");
  EXPECT_EQ(good.exit_code, 0) << good.out << good.err;
  EXPECT_TRUE(json::parse(good.out, nullptr, false).is_object() ||
              json::parse(good.out, nullptr, false).is_array());

  const ProgramOutput bad = RunTandem("doctor --interface nosuch0", "timeout 60 ");
  EXPECT_EQ(bad.exit_code, kExitNetwork);
  EXPECT_THAT(bad.out, AllOf(HasSubstr("nosuch0"), HasSubstr("usable: ")));

  // the machine is there, but nobody answers: the program tries the path and says what to do
  const ProgramOutput deaf = RunTandem("doctor --interface lo --peers 127.0.0.1", "timeout 60 ");
  EXPECT_THAT(deaf.out, AllOf(HasSubstr("127.0.0.1"), HasSubstr("doctor --answer")));
  ExpectUsage("doctor --port 80", "--port");
  ExpectUsage("doctor --trace /tmp/none.csv", "--peers with exactly one machine");
  ExpectUsage("doctor --peers a,b --trace /tmp/none.csv", "--peers with exactly one machine");
  ExpectUsage("doctor --hz 500", "--trace");
}

// The law that knows of no delay is not for ordinary use.
TEST(PeerGain, ConstantLawIsReservedForTheLab) {
  const std::string arguments = "peer --session s --scene nowhere.json --law constant";
  ExpectRefused(arguments, kExitUsage, "it is for the lab, with --lab");
  ExpectRefused(arguments + " --lab", kExitFile, "nowhere.json");
}

}  // namespace
}  // namespace tandem
