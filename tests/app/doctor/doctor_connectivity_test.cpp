#include <csignal>
#include <filesystem>
#include <memory>
#include <random>
#include <string>

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sys/socket.h>
#include <unistd.h>

#include "app/invite/invitation.h"
#include "collab/dds/security/keys.h"
#include "tests/app/cli/program_run.h"
#include "tests/network/running_program.h"
#include "tests/support/scratch_folder.h"

// Tests what `tandem doctor` says of the way between two sites. docs/two-sites.md goes by it.

namespace tandem {
namespace {

using ::testing::HasSubstr;
using testing::ProgramOutput;
using testing::RunTandem;

class DoctorConnectivity : public ::testing::Test {
 protected:
  /// Returns the finding of that name, or null where there is none.
  nlohmann::json Finding(const std::string& arguments, const std::string& check) {
    const ProgramOutput output = RunTandem("doctor --json " + arguments, "timeout 30 ");
    exit_code_ = output.exit_code;
    const nlohmann::json findings = nlohmann::json::parse(output.out, nullptr, false);
    EXPECT_TRUE(findings.is_array()) << output.err;
    for (const nlohmann::json& finding : findings) {
      if (finding.at("check") == check) return finding;
    }
    return nullptr;
  }
  static std::string Lo(const std::string& more) { return "--interface lo " + more; }
  std::string In(const std::string& name) const { return (folder_.path() / name).string(); }

  ScratchFolder folder_;
  int exit_code_ = 0;
};

TEST_F(DoctorConnectivity, InvitationIsCheckedWithoutBeingUsed) {
  ASSERT_TRUE(MakeSessionKeys(In("keys")));
  const std::string session = "doctor-" + std::to_string(std::random_device{}());
  testing::Program inviter({TANDEM_PROGRAM, "invite", session, "--keys", In("keys"), "--name",
                            "ben", "--interface", "lo", "--scene", "peg_in_slot"},
                           In("said"));
  ASSERT_TRUE(inviter.Says("Ctrl-C withdraws it")) << inviter.output();
  std::string line;
  for (const std::string& one : testing::LinesOf(inviter.output())) {
    if (one.rfind("tandem://", 0) == 0) line = one;
  }
  EXPECT_EQ(Finding(Lo("--invitation " + line), "inviter").at("verdict"), "ok");
  EXPECT_THAT(Finding(Lo("--invitation " + line), "scene").at("found").get<std::string>(),
              HasSubstr("the invitation's scene"));
  const nlohmann::json other = Finding(Lo("--scene ball_and_socket --invitation " + line), "scene");
  EXPECT_EQ(other.at("verdict"), "bad");

  std::string cut = line.substr(0, line.size() - 3);
  EXPECT_EQ(Finding(Lo("--invitation " + cut), "invitation").at("verdict"), "bad");
  EXPECT_EQ(exit_code_, 5);
  Invitation astray = *ReadInvitation(line);
  astray.enrolment.certificate[0] ^= 1U;
  EXPECT_THAT(
      Finding(Lo("--invitation " + LineOf(astray)), "inviter").at("found").get<std::string>(),
      HasSubstr("another invitation is open there"));
  // the inviter has taken its port
  const std::string port = std::to_string(astray.enrolment.port);
  EXPECT_EQ(Finding(Lo("--enrol-port " + port), "port for invitations").at("verdict"), "warning");

  EXPECT_EQ(inviter.output().find("without the secret"), std::string::npos);
  inviter.process().Signal(SIGTERM);
  EXPECT_EQ(inviter.Wait(), 0);
  const nlohmann::json gone = Finding(Lo("--invitation " + line), "inviter");
  EXPECT_EQ(gone.at("verdict"), "bad");
  EXPECT_THAT(gone.at("mend").get<std::string>(), HasSubstr("TCP " + port));
}

TEST_F(DoctorConnectivity, UnreachableAddressIsNamed) {
  const auto of = [this](const std::string& options) {
    return Finding(Lo(options), "own address");
  };
  EXPECT_THAT(of("--external-address 192.168.3.4").at("found").get<std::string>(),
              HasSubstr("private network"));
  EXPECT_THAT(of("--external-address 198.51.100.7").at("mend").get<std::string>(),
              HasSubstr("--port"));
  EXPECT_EQ(of("--external-address 198.51.100.7 --port 17654").at("verdict"), "ok");
}

TEST_F(DoctorConnectivity, KeysAreCheckedWithoutBeingUsed) {
  ASSERT_TRUE(MakeSessionKeys(In("keys")));
  ASSERT_TRUE(MakeMemberKeys(In("keys"), "anna", Role::kActive, In("anna")));
  ASSERT_TRUE(MakeMemberKeys(In("keys"), "vic", Role::kViewer, In("vic"), 3));
  const nlohmann::json anna = Finding(Lo("--session S --secure " + In("anna")), "keys");
  EXPECT_EQ(anna.at("verdict"), "ok");
  EXPECT_THAT(anna.at("found").get<std::string>(), HasSubstr("anna, who takes part"));
  EXPECT_EQ(exit_code_, 0);
  const nlohmann::json vic = Finding(Lo("--secure " + In("vic")), "keys");
  EXPECT_EQ(vic.at("verdict"), "warning");
  std::filesystem::permissions(In("anna") + "/identity.key", std::filesystem::perms::all);
  EXPECT_EQ(Finding(Lo("--secure " + In("anna")), "keys").at("verdict"), "bad");
}

TEST_F(DoctorConnectivity, OwnPortIsFreeOrReported) {
  EXPECT_EQ(Finding(Lo("--port 17656"), "ports").at("verdict"), "ok");
  const int taken = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_in at{};
  at.sin_family = AF_INET;
  at.sin_addr.s_addr = htonl(INADDR_ANY);
  socklen_t size = sizeof at;
  ASSERT_EQ(bind(taken, reinterpret_cast<sockaddr*>(&at), sizeof at), 0);
  getsockname(taken, reinterpret_cast<sockaddr*>(&at), &size);
  const std::string port = std::to_string(ntohs(at.sin_port));
  EXPECT_THAT(Finding(Lo("--port " + port), "options").at("found").get<std::string>(),
              HasSubstr("is taken"));
  close(taken);
}

// Qt's platform "offscreen" opens windows without a display, and has no OpenGL
TEST_F(DoctorConnectivity, DisplayAndOpenGlAreLookedAt) {
  const auto display = [this](const std::string& environment, const std::string& check) {
    const ProgramOutput output =
        RunTandem("doctor --json --interface lo", "env -u WAYLAND_DISPLAY " + environment + " ");
    exit_code_ = output.exit_code;
    for (const nlohmann::json& finding : nlohmann::json::parse(output.out)) {
      if (finding.at("check") == check) return finding;
    }
    return nlohmann::json();
  };
  const nlohmann::json none = display("-u DISPLAY -u QT_QPA_PLATFORM", "display");
  EXPECT_EQ(none.at("verdict"), "warning");
  EXPECT_THAT(none.at("found").get<std::string>(), HasSubstr("no display"));
  EXPECT_EQ(exit_code_, 0) << "peers need no window";
  EXPECT_EQ(display("QT_QPA_PLATFORM=offscreen", "display").at("verdict"), "ok");
  EXPECT_EQ(display("QT_QPA_PLATFORM=offscreen", "OpenGL").at("verdict"), "warning");
  EXPECT_THAT(display("QT_QPA_PLATFORM=nosuch", "display").at("found").get<std::string>(),
              HasSubstr("platform plugin"));
}

}  // namespace
}  // namespace tandem
