// What a program of the tests' own (tests/collab/dds/attacker.cpp) can do to users of the product
// who have a part in hand: as an outsider of a plain session, and with a viewer's and a member's
// keys in a secured one.
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/exit_codes.h"
#include "collab/dds/keys.h"
#include "tests/collab/dds/child_peer.h"
#include "tests/collab/dds/live_peer.h"
#include "tests/network/said_program.h"

namespace tandem::testing {
namespace {

using std::chrono::milliseconds;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr PeerId kLooker = 44;
constexpr PeerId kMallory = 0x999;
// 1,200 attacks, or 48 that an honest peer's pace hides; a peer is lost after a second.
constexpr milliseconds kAttack{1200};

/// Anna holds the ball and Ben the socket, in two processes of the product; a viewer looks on from
/// here.
class HostileRights : public ::testing::Test {
 protected:
  void TearDown() override {
    for (auto& [name, program] : programs_) {
      program->process().Signal(SIGTERM);
      EXPECT_EQ(program->Wait(), 0) << program->said();
    }
  }

  void BeginPlain() { Begin(LoopbackOptions(session_, kLooker, Role::kViewer)); }
  void BeginSecured() {
    ASSERT_TRUE(MakeSessionKeys(In("keys")));
    for (const auto& [name, role] : std::map<std::string, Role>{{"anna", Role::kActive},
                                                                {"ben", Role::kActive},
                                                                {"dave", Role::kActive},
                                                                {"carl", Role::kActive},
                                                                {"vic", Role::kViewer},
                                                                {"wes", Role::kViewer}}) {
      const Result<PeerId> made = MakeMemberKeys(In("keys"), name, role, In("keys-" + name));
      ASSERT_TRUE(made) << made.error().what;
      ids_[name] = *made;
    }
    secured_ = true;
    DdsOptions options = LoopbackOptions(session_, ids_.at("wes"), Role::kViewer);
    options.secure = In("keys-wes").string();
    Begin(options);
  }

  ChildPeer Attacker(const std::string& mode, const std::string& keys) const {
    const bool plain = keys == "-";
    return ChildPeer({TANDEM_DDS_ATTACKER, session_, plain ? "-" : In("keys-" + keys).string(),
                      plain ? "-" : TANDEM_LAX_ACCESS_CONTROL, mode,
                      std::to_string(plain ? kMallory : ids_.at(keys)), keys,
                      std::to_string(ids_.at("anna"))});
  }
  /// Attacks whoever holds the ball, with those keys and no check of the attacker's own ("-":
  /// none).
  void Attack(const std::string& mode, const std::string& keys) {
    const Recorder::Heard before = heard_.Now();
    ChildPeer attacker = Attacker(mode, keys);
    EXPECT_TRUE(attacker.Says("attacking")) << mode;
    const auto ends_of = [this](const Recorder::Heard& h) {
      int ends = 0;
      for (const char* name : {"anna", "ben"}) {
        if (const auto left = h.left.find(ids_.at(name)); left != h.left.end())
          ends += left->second;
        if (const auto lost = h.lost.find(ids_.at(name)); lost != h.lost.end())
          ends += lost->second;
      }
      return ends;
    };
    EXPECT_FALSE(heard_.WaitFor(
        [&](const Recorder::Heard& h) {
          return ends_of(h) != ends_of(before);
        },
        kAttack))
        << mode << ": a peer seems to be gone";
    attacker.Command("end");
    ExpectNobodyLetGo(mode);
  }

  /// All that one can try, the ones that an honest peer's pace hides slowly, too.
  void AttackByAllMeans(const std::string& keys) {
    for (const char* mode :
         {"claim", "claim_slowly", "claim_next_slowly", "claim_as_victim_slowly", "sit_down_slowly",
          "dispose", "dispose_slowly", "grant", "grant_here_slowly", "grant_as_victim",
          "look_on_as_victim", "offer_as_first", "offer_absurd", "state_as_victim"}) {
      Attack(mode, keys);
      if (HasFailure()) return;
    }
  }

  /// How often a user was told such words of the attacker.
  int Told(const std::string& name, const std::string& words) const {
    int told = 0;
    for (const std::string& line : LinesOf(programs_.at(name)->said())) {
      told += line.find(words) != std::string::npos ? 1 : 0;
    }
    return told;
  }
  nlohmann::json DropsOf(const std::string& name) {
    programs_.at(name)->process().Signal(SIGTERM);
    EXPECT_EQ(programs_.at(name)->Wait(), 0);
    programs_.erase(name);
    std::ifstream stream(In(name + ".report"));
    return nlohmann::json::parse(stream, nullptr, false).at("drops");
  }

  std::unique_ptr<Program> Peer(const std::string& name,
                                const std::vector<std::string>& more) const {
    std::vector<std::string> words{TANDEM_PROGRAM,
                                   "peer",
                                   "--session",
                                   session_,
                                   "--interface",
                                   "lo",
                                   "--scene",
                                   TANDEM_SCENES "/ball_and_socket.json",
                                   "--name",
                                   name,
                                   "--capacity",
                                   "20000",
                                   "--brief",
                                   "--report",
                                   In(name + ".report").string()};
    if (secured_) words.insert(words.end(), {"--secure", In("keys-" + name).string()});
    words.insert(words.end(), more.begin(), more.end());
    return std::make_unique<Program>(words, In(name));
  }
  std::filesystem::path In(const std::string& file) const { return folder_.path() / file; }

  void ExpectNobodyLetGo(const std::string& mode) {
    const Recorder::Heard now = heard_.Now();
    for (const char* name : {"anna", "ben"}) {
      const PeerId id = ids_.at(name);
      EXPECT_TRUE(heard_.WaitFor([&](const Recorder::Heard& h) {
        return h.views.at(id).seq > now.views.at(id).seq && Holds(h, id);
      })) << mode
          << ": " << name << " holds nothing any more";
      EXPECT_THAT(programs_.at(name)->said(),
                  AllOf(Not(HasSubstr("let go of it")), Not(HasSubstr("anna left")),
                        Not(HasSubstr("anna is lost")), Not(HasSubstr("ben left")),
                        Not(HasSubstr("ben is lost"))))
          << mode;
    }
  }

 private:
  void Begin(const DdsOptions& looks_on) {
    auto joined = JoinOverDds(looks_on, heard_);
    ASSERT_TRUE(joined.has_value()) << joined.error().what;
    looker_ = *std::move(joined);
    programs_["anna"] = Peer("anna", {"--hold", "ball"});
    ASSERT_TRUE(programs_.at("anna")->Says("you hold ball")) << programs_.at("anna")->said();
    programs_["ben"] = Peer("ben", {"--hold", "socket"});
    ASSERT_TRUE(programs_.at("ben")->Says("you hold socket")) << programs_.at("ben")->said();
    for (const char* name : {"anna", "ben"}) {
      EXPECT_TRUE(heard_.WaitFor([&](const Recorder::Heard& h) {
        for (const auto& [id, info] : h.infos) {
          if (info.name == name) ids_[name] = id;
        }
        return ids_.contains(name) && Holds(h, ids_[name]);
      }));
    }
  }

  static bool Holds(const Recorder::Heard& heard, PeerId peer) {
    if (!heard.views.contains(peer)) return false;
    const ViewFrame& view = heard.views.at(peer);
    for (std::uint32_t i = 0; i < view.count; ++i) {
      if ((view.bodies[i].flags & ViewBody::kHeld) != 0) return true;
    }
    return false;
  }

  const TemporaryFolder folder_;
  bool secured_ = false;
  std::map<std::string, PeerId> ids_;
  Recorder heard_;
  std::unique_ptr<Transport> looker_;

 protected:
  const std::string session_ = RandomSession();
  std::map<std::string, std::unique_ptr<Program>> programs_;
};

TEST_F(HostileRights, AnOutsiderOfAPlainSessionTakesNothingOutOfAHand) {
  BeginPlain();
  AttackByAllMeans("-");
}

TEST_F(HostileRights, AViewerTakesNothingOutOfAHand) {
  BeginSecured();
  AttackByAllMeans("vic");
  // the plug-ins let nothing through of what its permissions do not name
  EXPECT_EQ(Told("anna", "vic"), 0) << programs_.at("anna")->said();
}

TEST_F(HostileRights, AMemberTakesNothingOutOfAHandAndIsToldOfOnce) {
  BeginSecured();
  AttackByAllMeans("carl");
  EXPECT_EQ(Told("anna", "carl claims what others have and have not given away: refused"), 1)
      << programs_.at("anna")->said();
  EXPECT_EQ(Told("anna", "carl claims bodies further ahead"), 1) << programs_.at("anna")->said();
  EXPECT_EQ(Told("anna", "carl speaks in another's name"), 1) << programs_.at("anna")->said();
  const nlohmann::json drops = DropsOf("anna");
  for (const char* reason : {"seized", "epoch_leap", "impostor", "not_owner", "absurd_scene"}) {
    EXPECT_GT(drops.at(reason).get<int>(), 0) << reason;
  }
}

TEST_F(HostileRights, ANewcomerJoinsTheSceneThatMostGoByWhateverAMemberOffers) {
  BeginSecured();
  ChildPeer carl = Attacker("offer_fine_slowly", "carl");
  ASSERT_TRUE(carl.Says("attacking"));
  ASSERT_TRUE(programs_.at("anna")->Says("carl joined")) << programs_.at("anna")->said();
  std::unique_ptr<Program> dave = Peer("dave", {"--seconds", "1"});
  EXPECT_EQ(dave->Wait(40), 0) << dave->said();
  EXPECT_THAT(dave->said(), AllOf(HasSubstr("is in session"), Not(HasSubstr("0.03 mm"))));
  EXPECT_THAT(programs_.at("anna")->said(), HasSubstr("dave joined"));
  carl.Command("end");
  EXPECT_TRUE(programs_.at("anna")->Says("carl is lost")) << programs_.at("anna")->said();
}

TEST_F(HostileRights, WhoComesWithAnothersKeysGoesAndTheFirstKeepsItsPart) {
  BeginSecured();
  Program second({TANDEM_PROGRAM, "peer", "--session", session_, "--interface", "lo", "--scene",
                  TANDEM_SCENES "/ball_and_socket.json", "--brief", "--hold", "ball", "--secure",
                  In("keys-anna").string()},
                 In("second"));
  EXPECT_EQ(second.Wait(40), kExitSecurity) << second.said();
  EXPECT_THAT(second.said(), HasSubstr("these keys are in use in this session already"));
  ExpectNobodyLetGo("twin");
}

}  // namespace
}  // namespace tandem::testing
