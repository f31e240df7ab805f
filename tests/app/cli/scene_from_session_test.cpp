#include <cstdlib>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/exit_codes.h"
#include "tests/app/cli/peer_program.h"

// `tandem peer --scene-from-session`: a joiner who names no scene goes by the session's.

namespace tandem {
namespace {

using testing::ExpectRefused;
using ::testing::HasSubstr;
using testing::Running;
using testing::RunTandem;
using testing::Said;

/// Programs of two people on one machine, each with folders of its own.
class SceneFromSession : public testing::PeerCommand {
 protected:
  /// From here on programs are started as that person.
  void As(const std::string& person) const {
    setenv("XDG_STATE_HOME", In(person + ".state").c_str(), 1);
    setenv("TANDEM_CACHE", In(person + ".cache").c_str(), 1);
  }
  std::string Joining(const std::string& more) const {
    return "--interface lo --capacity 20000 --session " + session_ + " --scene-from-session " +
           more;
  }
};

TEST_F(SceneFromSession, FindsTheSceneOnThisMachineByItsContent) {
  As("anna");
  Running anna = Start("one", "--name anna --hold left");
  ASSERT_TRUE(anna.WaitFor("you hold left"));
  As("ben");
  // ben opened a scene in that folder before
  const Said once = RunTandem("peer --interface lo --capacity 20000 --session " + session_ +
                                  "-before --seconds 0.1 --hold left --scene " + In("one.json"),
                              "timeout 40 ");
  ASSERT_EQ(once.exit_code, kExitOk) << once.err;
  const Said ben =
      RunTandem("peer " + Joining("--name ben --hold right --seconds 0.2"), "timeout 40 ");
  EXPECT_EQ(ben.exit_code, kExitOk) << ben.err;
  EXPECT_THAT(ben.err,
              HasSubstr("the session's scene boxes is on this machine: " + In("one.json")));
  EXPECT_THAT(ben.err, HasSubstr("you hold right"));
  EXPECT_EQ(anna.End(), kExitOk);
}

TEST_F(SceneFromSession, SaysInALineWhyThereIsNone) {
  As("ben");
  ExpectRefused(RunTandem("peer --interface lo --session " + session_), kExitUsage,
                "--scene is required, or --scene-from-session");
  ExpectRefused(RunTandem("peer " + Joining("--scene " + In("one.json"))), kExitUsage,
                "--scene excludes --scene-from-session");
  ExpectRefused(RunTandem("peer --interface lo --accept-scene --session " + session_ + " --scene " +
                          In("one.json")),
                kExitUsage, "--scene-from-session");
  ExpectRefused(RunTandem("peer " + Joining(""), "timeout 40 "), kExitNetwork,
                "nobody in session " + session_ + " tells of a scene");
}

}  // namespace
}  // namespace tandem
