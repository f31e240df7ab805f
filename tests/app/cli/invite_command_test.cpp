#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <memory>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <nlohmann/json.hpp>
#include <sys/socket.h>
#include <unistd.h>

#include "app/common/exit_codes.h"
#include "app/invite/invitation.h"
#include "app/process/child_processes.h"
#include "collab/dds/security/keys.h"
#include "tests/app/cli/program_run.h"
#include "tests/network/running_program.h"
#include "tests/support/scratch_folder.h"

// Tests `tandem invite`, `tandem join LINE` and the way by files, as far as one machine shows them.
// tests/network/invite_test.cpp tests them in two networks.

namespace tandem {
namespace {

using nlohmann::json;
using testing::ExpectRefused;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::Program;
using testing::ProgramOutput;
using testing::RunTandem;

std::string RandomSession() {
  return "invite-" + std::to_string(std::random_device{}());
}

/// Returns a TCP port that nobody listens at. Tests that run beside one another must not meet at
/// the usual port.
std::string FreeTcpPort() {
  const int probe = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  socklen_t size = sizeof address;
  bind(probe, reinterpret_cast<sockaddr*>(&address), size);
  getsockname(probe, reinterpret_cast<sockaddr*>(&address), &size);
  close(probe);
  return std::to_string(ntohs(address.sin_port));
}

class InviteCommand : public ::testing::Test {
 protected:
  std::string In(const std::string& name) const { return (folder_.path() / name).string(); }
  /// Starts `tandem invite` of a secured session on loopback in the background, and fills in what
  /// it printed.
  std::unique_ptr<Program> Inviter(const std::string& session, json& printed,
                                   const std::vector<std::string>& further = {}) {
    if (!std::filesystem::exists(In("keys"))) {
      EXPECT_TRUE(MakeSessionKeys(In("keys")));
    }
    std::vector<std::string> command{TANDEM_PROGRAM, "invite", session,        "--keys",
                                     In("keys"),     "--name", "ben",          "--interface",
                                     "lo",           "--json", "--enrol-port", FreeTcpPort()};
    command.insert(command.end(), further.begin(), further.end());
    const std::string output = In("said-" + std::to_string(++inviters_));
    auto inviter = std::make_unique<Program>(command, output);
    EXPECT_TRUE(inviter->Says("Ctrl-C withdraws it")) << inviter->output();
    for (const std::string& line : testing::LinesOf(inviter->output())) {
      if (line.rfind('{', 0) == 0) printed = json::parse(line, nullptr, false);
    }
    return inviter;
  }
  ProgramOutput Join(const std::string& line, const std::string& home,
                     const std::string& further) const {
    return RunTandem("join '" + line + "' " + further,
                     "XDG_DATA_HOME=" + In(home) + " timeout 20 ");
  }

  ScratchFolder folder_;
  int inviters_ = 0;
};

TEST_F(InviteCommand, PrintsTheInvitationAsOneJsonObject) {
  const std::string session = RandomSession();
  ProgramOutput output = RunTandem("invite '" + session +
                                   " a' --json --scene peg_in_slot --external-address 192.0.2.7 "
                                   "--port 17000 --peers 192.0.2.8,site-b:4000");
  ASSERT_EQ(output.exit_code, 0) << output.err;
  const json printed = json::parse(output.out);
  EXPECT_EQ(printed.at("session"), session + " a");
  EXPECT_EQ(printed.at("secured"), false);
  EXPECT_EQ(printed.at("hosts"), json({"192.0.2.7:17000"}));
  EXPECT_EQ(printed.at("others"), json({"192.0.2.8", "site-b:4000"}));
  EXPECT_EQ(printed.at("until"), nullptr);
  const Result<Invitation> line = ReadInvitation(printed.at("line").get<std::string>());
  ASSERT_TRUE(line) << line.error().what;
  EXPECT_EQ(line->session, session + " a");
  EXPECT_EQ(line->scene.file, "peg_in_slot.json");
  EXPECT_EQ(line->scene.bodies, 2U);
  EXPECT_FALSE(line->secured);
  // without --json it prints the line alone, for a script that takes it
  output = RunTandem("invite " + session + " --scene peg_in_slot --interface lo");
  EXPECT_EQ(std::count(output.out.begin(), output.out.end(), '\n'), 1);
  EXPECT_TRUE(ReadInvitation(output.out));
}

TEST_F(InviteCommand, InvitedPeerGetsItsOwnKeysAndCanReturn) {
  json printed;
  const auto inviter = Inviter(RandomSession(), printed, {"--role", "viewer"});
  const std::string line = printed.at("line");
  const ProgramOutput output = Join(line, "home", "--only-keys --json");
  ASSERT_EQ(output.exit_code, 0) << output.err;
  const json way = json::parse(output.out);
  EXPECT_EQ(way.at("role"), "viewer");
  EXPECT_EQ(way.at("secured"), true);
  const Result<MemberKeys> keys = LoadMemberKeys(way.at("keys").get<std::string>());
  ASSERT_TRUE(keys) << keys.error().what;
  EXPECT_EQ(keys->name, "ben");
  EXPECT_EQ(keys->role, Role::kViewer);
  EXPECT_EQ(inviter->Wait(), 0) << inviter->output();
  EXPECT_THAT(inviter->output(), HasSubstr("ben is a member now"));

  const ProgramOutput again = Join(line, "home", "--only-keys");
  EXPECT_EQ(again.exit_code, 0) << again.err;
  ExpectRefused(Join(line, "other_home", "--only-keys"), kExitNetwork, "was used or withdrawn");
}

TEST_F(InviteCommand, AlteredInvitationIsRefusedWithoutKeys) {
  json printed;
  const auto inviter = Inviter(RandomSession(), printed);
  const Result<Invitation> given = ReadInvitation(printed.at("line").get<std::string>());
  ASSERT_TRUE(given);
  // altered by accident
  std::string line = LineOf(*given);
  line[line.size() / 2] ^= 1;
  ExpectRefused(Join(line, "home", "--only-keys"), kExitUsage, "copy the whole line");
  // altered on purpose, with a good CHECK
  Invitation altered = *given;
  altered.session += "x";
  ExpectRefused(Join(LineOf(altered), "home", "--only-keys"), kExitSecurity,
                "is not the invitation");
  altered = *given;
  altered.role = Role::kViewer;
  ExpectRefused(Join(LineOf(altered), "home", "--only-keys"), kExitSecurity,
                "is not the invitation");
  EXPECT_FALSE(std::filesystem::exists(In("home") + "/tandem/keys") &&
               !std::filesystem::is_empty(In("home") + "/tandem/keys"));
  inviter->process().Signal(SIGTERM);
  EXPECT_EQ(inviter->Wait(), 0);
  EXPECT_THAT(inviter->output(), HasSubstr("withdrawn"));
}

TEST_F(InviteCommand, InvitationOfAnotherSessionIsRefused) {
  json gear;
  json wing;
  const auto one = Inviter(RandomSession(), gear);
  const auto other = Inviter(RandomSession(), wing);
  Invitation astray = *ReadInvitation(gear.at("line").get<std::string>());
  astray.enrolment.port = ReadInvitation(wing.at("line").get<std::string>())->enrolment.port;
  ExpectRefused(Join(LineOf(astray), "home", "--only-keys"), kExitSecurity,
                "another invitation is open there");
  for (const auto& inviter : {&one, &other}) {
    (*inviter)->process().Signal(SIGTERM);
    EXPECT_EQ((*inviter)->Wait(), 0);
  }
}

TEST_F(InviteCommand, ReportsThatNoInviterListens) {
  Invitation plain;
  plain.session = RandomSession();
  plain.hosts = {"127.0.0.1"};
  const ProgramOutput output =
      Join(LineOf(plain), "home", "--scene peg_in_slot --json -- --seconds 6");
  EXPECT_EQ(output.exit_code, 0) << output.err;
  EXPECT_THAT(output.err, HasSubstr("no peer answers in session " + plain.session));
  EXPECT_EQ(json::parse(output.out).at("holding"), nullptr);
}

// The line's time is over, and nobody is there.
TEST_F(InviteCommand, ExpiredInvitationIsRefused) {
  Invitation ended;
  ended.session = RandomSession();
  ended.hosts = {"127.0.0.1"};
  ended.secured = true;
  ended.enrolment.port = 1024;
  ended.enrolment.until = 1'700'000'000;  // 2023-11-14 22:13:20 UTC
  ExpectRefused(Join(LineOf(ended), "home", "--only-keys"), kExitNetwork,
                "the invitation expired at 2023-11-14 22:13 UTC");
}

TEST_F(InviteCommand, ReportsErrorsInOneLine) {
  ExpectRefused(RunTandem("invite S --keys " + In("none") + " --name ben"), kExitFile,
                "has no identity_ca.pem");
  ExpectRefused(RunTandem("invite S --keys " + In("none")), kExitUsage,
                "give the name by which others will see the invited person");
  ExpectRefused(RunTandem("invite S --name ben"), kExitUsage, "--keys");
  ExpectRefused(RunTandem("invite S --keys x --name 'a b'"), kExitUsage, "is not a member's name");
  Invitation plain;
  plain.session = "S";
  plain.hosts = {"127.0.0.1"};
  const std::string line = "join '" + LineOf(plain) + "' ";
  ExpectRefused(RunTandem(line + "--keys-to x"), kExitUsage, "which has no keys");
  ExpectRefused(RunTandem(line + "--domain 3"), kExitUsage, "gives the domain");
  ExpectRefused(RunTandem(line + "-- --no-such"), kExitUsage, "unknown option '--no-such'");
  ExpectRefused(RunTandem(line + "-- --session T"), kExitUsage, "unknown option '--session'");
  ExpectRefused(RunTandem("join S --hold x"), kExitUsage, "applies to an invitation");
  plain.role = Role::kViewer;
  ExpectRefused(RunTandem("join '" + LineOf(plain) + "' --role active"), kExitUsage,
                "for a viewer");
}

TEST_F(InviteCommand, MemberIsMadeByTwoFilesWithoutAConnection) {
  ASSERT_TRUE(MakeSessionKeys(In("keys")));
  ProgramOutput output = RunTandem("keys request " + In("ben"));
  ASSERT_EQ(output.exit_code, 0) << output.err;
  const std::string request = In("ben.request/request.pem");
  EXPECT_THAT(testing::TextOf(request), Not(HasSubstr("PRIVATE")));
  ExpectRefused(RunTandem("keys take " + In("ben") + " " + request), kExitFile,
                "is not an answer file");
  output = RunTandem("keys answer " + In("keys") + " ben " + request + " --out " + In("answer"));
  ASSERT_EQ(output.exit_code, 0) << output.err;
  EXPECT_THAT(testing::TextOf(In("answer")), Not(HasSubstr("PRIVATE")));
  ExpectRefused(RunTandem("keys take " + In("eve") + " " + In("answer")), kExitFile,
                "holds no waiting request");
  output = RunTandem("keys take " + In("ben") + " " + In("answer"));
  ASSERT_EQ(output.exit_code, 0) << output.err;
  const Result<MemberKeys> keys = LoadMemberKeys(In("ben"));
  ASSERT_TRUE(keys) << keys.error().what;
  EXPECT_EQ(keys->name, "ben");
  EXPECT_FALSE(std::filesystem::exists(In("ben.request")));
}

TEST_F(InviteCommand, EmptySessionIsReported) {
  for (const std::string more : {"", " --scene peg_in_slot"}) {
    const std::string session = RandomSession();
    const ProgramOutput output = RunTandem("invite " + session + " --interface lo" + more);
    EXPECT_EQ(output.exit_code, 0);
    EXPECT_THAT(output.err, HasSubstr("nobody is in session " + session));
    EXPECT_TRUE(ReadInvitation(output.out));
  }
}

/// Returns the arguments of a process as all users of the machine see them.
std::string ArgumentsOf(pid_t pid) {
  return testing::TextOf("/proc/" + std::to_string(pid) + "/cmdline");
}

// The program waits for an inviter who never answers, so that its words can be read.
TEST_F(InviteCommand, SecretIsNotInTheListOfProcesses) {
  json printed;
  const auto inviter = Inviter(RandomSession(), printed);
  const std::string line = printed.at("line");
  const std::string secret = line.substr(line.find('#') + 1, 22);
  inviter->process().Signal(SIGSTOP);
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"join", line, "--only-keys", "--keys-to", In("stolen")},
        std::vector<std::string>{"doctor", "--invitation", line},
        std::vector<std::string>{"doctor", "--invitation=" + line}}) {
    std::vector<std::string> command{TANDEM_PROGRAM};
    command.insert(command.end(), words.begin(), words.end());
    Program asks(command, In("asks"));
    // the shell of the test names the program until it becomes it
    const std::string shown = "tandem://";
    std::string seen;
    for (int i = 0; i < 500; ++i) {
      seen = ArgumentsOf(asks.process().pid());
      if (seen.rfind(TANDEM_PROGRAM, 0) == 0 && seen.find("#xxxx") != std::string::npos) break;
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    EXPECT_THAT(seen, HasSubstr(shown));
    EXPECT_THAT(seen, Not(HasSubstr(secret)));
    asks.process().Signal(SIGKILL);
  }
  inviter->process().Signal(SIGCONT);
}

TEST_F(InviteCommand, LineIsReadFromStdinOrAFile) {
  json printed;
  const auto inviter = Inviter(RandomSession(), printed);
  const std::string line = printed.at("line");
  const std::string secret = line.substr(line.find('#') + 1, 22);
  const std::string file = folder_.Write("line", line + "\n").string();
  // the stdin of RunTandem() is empty
  ExpectRefused(RunTandem("join -"), kExitUsage, "no invitation came from stdin");
  ExpectRefused(RunTandem("join @" + In("none")), kExitUsage, "there is no such file");
  ExpectRefused(RunTandem("join @/dev/zero"), kExitUsage, "not a regular file");
  // the doctor needs no secret
  const std::string open = PublicLineOf(*ReadInvitation(line));
  const ProgramOutput looked = RunTandem("doctor --interface lo --invitation '" + open + "'");
  EXPECT_THAT(looked.out, HasSubstr("is the inviter's program"));
  EXPECT_THAT(looked.out + looked.err, Not(HasSubstr(secret)));
  ExpectRefused(RunTandem("join '" + open + "'"), kExitUsage, "public form");
  Program joins({TANDEM_PROGRAM, "join", "-", "--only-keys", "--keys-to", In("ben")}, In("joins"),
                file);
  EXPECT_EQ(joins.Wait(), 0) << joins.output();
  EXPECT_EQ(inviter->Wait(), 0) << inviter->output();
  // messages name the line without its secret
  const ProgramOutput again =
      RunTandem("join @" + file + " --only-keys", "XDG_DATA_HOME=" + In("other") + " timeout 20 ");
  EXPECT_THAT(again.err, HasSubstr("tandem doctor --invitation 'tandem://"));
  EXPECT_THAT(again.err, Not(HasSubstr(secret)));
}

}  // namespace
}  // namespace tandem
