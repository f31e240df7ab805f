// Tests what a program of the tests' own (tests/collab/dds/attacker.cpp) can do to users of the
// product who have a part in hand: as an outsider of a plain session, and with a viewer's and a
// member's keys in a secured one.
#include "tests/network/hostile/hostile_rights.h"

#include <algorithm>
#include <ctime>
#include <memory>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/common/exit_codes.h"
#include "tests/collab/dds/child_peer.h"
#include "tests/network/running_program.h"

namespace tandem::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

TEST_F(HostileRights, OutsidersCannotTakeBodiesOrBlockJoining) {
  BeginPlain();
  {
    ChildPeer tells_badly = Attacker("say_badly_slowly", "-", kMallory + 1);
    ASSERT_TRUE(tells_badly.Says("attacking"));
    AttackByAllMeans("-");
  }
  ExpectReadable("anna");

  // offers that change all the time, by programs that come first by their ids, and peers without
  // an end, of which one program is heard as four
  ChildPeer others = Attacker("offer_others_slowly", "-", 1);
  ChildPeer friction = Attacker("offer_friction_slowly", "-", 2);
  ChildPeer crowd = Attacker("crowd_slowly", "-", 1000);
  for (ChildPeer* attacker : {&others, &friction, &crowd}) {
    ASSERT_TRUE(attacker->Says("attacking"));
  }
  ASSERT_TRUE(programs_.at("anna")->Says("shown as mallory (6)")) << programs_.at("anna")->output();
  const std::unique_ptr<PeerWithOrders> dave = Peer("dave", {});
  EXPECT_TRUE(dave->Says("is in session")) << dave->output();
  // it is in the session before the others have heard of it, and nobody is told of one that leaves
  // as early as that
  EXPECT_TRUE(programs_.at("anna")->Says("dave joined")) << programs_.at("anna")->output();
  EXPECT_EQ(dave->QuitAndWait(), 0) << dave->output();
  EXPECT_THAT(dave->output(), Not(HasSubstr("this peer adopts them")));

  // more of them take all places, and none of those who have one: ben has the fifteenth beside anna
  ChildPeer second = Attacker("crowd_slowly", "-", 2000);
  ChildPeer third = Attacker("crowd_slowly", "-", 3000);
  ASSERT_TRUE(programs_.at("anna")->Says("mallory (14)")) << programs_.at("anna")->output();
  const std::unique_ptr<PeerWithOrders> carl = Peer("carl", {});
  EXPECT_EQ(carl->Wait(40), kExitNetwork) << carl->output();
  EXPECT_THAT(carl->output(), HasSubstr("active peers, the maximum: look on with"));
  ExpectNobodyLetGo("crowd");

  // anna is alone with one attacker
  for (ChildPeer* attacker : {&others, &crowd, &second, &third}) attacker->Command("end");
  EndAll();
  const std::unique_ptr<PeerWithOrders> eve = Peer("eve", {});
  EXPECT_TRUE(eve->Says("this peer adopts them")) << eve->output();
  EXPECT_TRUE(eve->Says("is in session")) << eve->output();
  EXPECT_EQ(eve->QuitAndWait(), 0) << eve->output();
}

TEST_F(HostileRights, ViewerCannotTakeAHeldBody) {
  BeginSecured();
  AttackByAllMeans("vic");
  // the plug-ins let nothing through of what its permissions do not name
  EXPECT_EQ(Told("anna", "vic"), 0) << programs_.at("anna")->output();
}

TEST_F(HostileRights, MemberCannotTakeAHeldBodyAndIsReportedOnce) {
  const std::time_t began = std::time(nullptr);
  BeginSecured();
  // keys that end meanwhile, of one that goes on to attack and of one that does not; where all
  // takes longer, they last longer
  const std::time_t lasts = std::max(kKeysLast, 5 * (std::time(nullptr) - began));
  MakeKeysFor("emil", lasts);
  const std::unique_ptr<PeerWithOrders> emil = Peer("emil", {});
  MakeKeysFor("dora", lasts);
  ChildPeer dora = Attacker("say_badly_slowly", "dora");
  ASSERT_TRUE(programs_.at("anna")->Says("emil joined")) << emil->output();
  ASSERT_TRUE(dora.Says("attacking"));
  ASSERT_TRUE(programs_.at("anna")->Says("dora uses other")) << programs_.at("anna")->output();

  AttackByAllMeans("carl");
  EXPECT_EQ(Told("anna", "carl claims bodies that others have and have not given away: refused"), 1)
      << programs_.at("anna")->output();
  EXPECT_EQ(Told("anna", "carl claims bodies with a greater epoch"), 1)
      << programs_.at("anna")->output();
  EXPECT_EQ(Told("anna", "carl sends in another's name"), 1) << programs_.at("anna")->output();

  for (const char* name : {"anna", "ben"}) {
    const PeerWithOrders& here = *programs_.at(name);
    EXPECT_TRUE(here.Says("emil left", 120)) << here.output();
    EXPECT_TRUE(here.Says("dora is lost", 120)) << here.output();
  }
  EXPECT_EQ(emil->Wait(), kExitSecurity) << emil->output();
  EXPECT_THAT(emil->output(),
              AllOf(HasSubstr("the keys of emil have ended"), Not(HasSubstr("anna is lost"))));
  const std::unique_ptr<PeerWithOrders> again = Peer("emil", {});
  EXPECT_EQ(again->Wait(), kExitSecurity) << again->output();
  EXPECT_THAT(again->output(), HasSubstr("these keys ended on"));
  // dora goes on to write all the time
  EXPECT_THAT(programs_.at("anna")->output(),
              AllOf(Not(HasSubstr("dora is back")), Not(HasSubstr("emil is back"))));

  ExpectReadable("anna");
  const nlohmann::json report = ReportOf("anna");
  for (const char* reason : {"seized", "epoch_leap", "impostor", "not_owner", "absurd_scene"}) {
    EXPECT_GT(report.at("drops").at(reason).get<int>(), 0) << reason;
  }
  for (const nlohmann::json& terms : report.at("force_terms")) {
    EXPECT_TRUE(terms.at("displacement_mm").is_number()) << terms;
  }
}

TEST_F(HostileRights, NewcomerJoinsTheMajoritysScene) {
  BeginSecured();
  ChildPeer carl = Attacker("offer_fine_slowly", "carl");
  ASSERT_TRUE(carl.Says("attacking"));
  ASSERT_TRUE(programs_.at("anna")->Says("carl joined")) << programs_.at("anna")->output();
  const std::unique_ptr<PeerWithOrders> dave = Peer("dave", {"--seconds", "1"});
  EXPECT_EQ(dave->Wait(40), 0) << dave->output();
  EXPECT_THAT(dave->output(), AllOf(HasSubstr("is in session"), Not(HasSubstr("0.03 mm"))));
  EXPECT_THAT(programs_.at("anna")->output(), HasSubstr("dave joined"));
  carl.Command("end");
  EXPECT_TRUE(programs_.at("anna")->Says("carl is lost")) << programs_.at("anna")->output();
}

TEST_F(HostileRights, SecondUserOfTheSameKeysLeavesAndTheFirstStays) {
  BeginSecured();
  Program second({TANDEM_PROGRAM, "peer", "--session", session_, "--interface", "lo", "--scene",
                  TANDEM_SCENES "/ball_and_socket.json", "--brief", "--hold", "ball", "--secure",
                  In("keys-anna").string()},
                 In("second"));
  EXPECT_EQ(second.Wait(40), kExitSecurity) << second.output();
  EXPECT_THAT(second.output(),
              HasSubstr("another program in this session already uses these keys"));
  ExpectNobodyLetGo("twin");
}

}  // namespace
}  // namespace tandem::testing
