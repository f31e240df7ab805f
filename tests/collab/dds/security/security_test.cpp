#include <csignal>
#include <fstream>

#include <gmock/gmock.h>

#include "collab/dds/cyclone/partitions.h"
#include "collab/dds/security/keys.h"
#include "collab/dds/security/permissions.h"
#include "collab/dds/security/revocation.h"
#include "collab/dds/transport/dds_transport.h"
#include "tests/collab/dds/child_peer.h"
#include "tests/collab/dds/live_peer.h"
#include "tests/support/scratch_folder.h"

namespace tandem::testing {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

// Members meet within a quarter of a second; one who has not been let in after this is not.
constexpr std::chrono::milliseconds kLongEnough{1500};

// Makes keys of one session with four peers and a viewer, and of another session.
struct Keys {
  Keys() {
    EXPECT_TRUE(MakeSessionKeys(ours()).has_value());
    EXPECT_TRUE(MakeSessionKeys(theirs()).has_value());
    const auto member = [](const fs::path& session, const char* name, Role role) {
      const Result<PeerId> made = MakeMemberKeys(session, name, role, session / name);
      EXPECT_TRUE(made.has_value()) << made.error().what;
      return made ? *made : PeerId{0};
    };
    anna = member(ours(), "anna", Role::kActive);
    ben = member(ours(), "ben", Role::kActive);
    carl = member(ours(), "carl", Role::kActive);
    dave = member(ours(), "dave", Role::kActive);
    vic = member(ours(), "vic", Role::kViewer);
    rogue = member(theirs(), "anna", Role::kActive);
  }
  fs::path ours() const { return scratch.path() / "ours"; }
  fs::path theirs() const { return scratch.path() / "theirs"; }
  // Copies a member's folder, to be tampered with.
  fs::path Copy(const fs::path& folder, const std::string& name) const {
    const fs::path copy = scratch.path() / name;
    fs::copy(folder, copy, fs::copy_options::recursive);
    return copy;
  }

  ScratchFolder scratch;
  PeerId anna = 0, ben = 0, carl = 0, dave = 0, vic = 0, rogue = 0;
};

void Replace(const fs::path& file, const fs::path& by) {
  fs::copy_file(by, file, fs::copy_options::overwrite_existing);
}

// Anna is here and Ben in another process, both in a secured session.
class Security : public ::testing::Test {
 protected:
  static void SetUpTestSuite() { keys_ = std::make_unique<Keys>(); }
  static void TearDownTestSuite() { keys_.reset(); }

  Security() : ben_(session_, keys_->ben, {.secure = (keys_->ours() / "ben").string()}) {
    DdsOptions options = LoopbackOptions(session_, keys_->anna, Role::kActive);
    options.secure = (keys_->ours() / "anna").string();
    auto joined = JoinOverDds(options, received_);
    EXPECT_TRUE(joined.has_value()) << joined.error().what;
    if (joined) anna_ = std::make_unique<LivePeer>(*std::move(joined), options, options.peer);
  }
  void SetUp() override { ASSERT_TRUE(HearsBen()); }
  void TearDown() override { EXPECT_TRUE(HearsBen()) << "the session did not go on"; }

  // Returns whether states of Ben still come.
  bool HearsBen() {
    const Recorder::Heard now = received_.Now();
    const PeerId ben = keys_->ben;
    const std::uint32_t seq = now.states.contains(ben) ? now.states.at(ben).seq : 0;
    return received_.WaitFor([=](const Recorder::Heard& h) {
      return h.states.contains(ben) && h.states.at(ben).seq > seq + 100 && h.infos.contains(ben);
    });
  }

  // Starts a peer that publishes states of `claimed` in its partition, with these keys ("-": none).
  ChildPeer Rogue(const fs::path& keys, PeerId claimed, bool lax) {
    std::vector<std::string> command{TANDEM_DDS_ROGUE_PEER, session_, keys.string(),
                                     PeerPartition(claimed), std::to_string(claimed)};
    if (lax) command.emplace_back(TANDEM_LAX_ACCESS_CONTROL);
    return ChildPeer(command);
  }
  bool Heard(PeerId peer) {
    return received_.WaitFor(
        [peer](const Recorder::Heard& h) {
          return h.states.contains(peer);
        },
        kLongEnough);
  }
  // Starts an attacker with the keys of that member.
  ChildPeer Attacker(const std::string& member, const std::string& plugin, const std::string& mode,
                     PeerId id, PeerId victim) {
    return ChildPeer({TANDEM_DDS_ATTACKER, session_, (keys_->ours() / member).string(), plugin,
                      mode, std::to_string(id), member, std::to_string(victim)});
  }
  bool HearsInfoOf(PeerId peer, std::chrono::milliseconds deadline = std::chrono::seconds(20)) {
    return received_.WaitFor(
        [peer](const Recorder::Heard& h) {
          return h.infos.contains(peer);
        },
        deadline);
  }
  void ExpectKeptOut(ChildPeer& rogue, PeerId claimed) {
    EXPECT_TRUE(rogue.Says("writing"));
    EXPECT_FALSE(Heard(claimed));
  }

  static std::unique_ptr<Keys> keys_;
  const std::string session_ = RandomSession();
  Recorder received_;
  ChildPeer ben_;
  std::unique_ptr<LivePeer> anna_;
};
std::unique_ptr<Keys> Security::keys_;

TEST_F(Security, MembersHearOneAnother) {
  EXPECT_TRUE(ben_.Says("state " + std::to_string(keys_->anna)));
  EXPECT_TRUE(ben_.Says("scene 42"));
}

TEST_F(Security, ViewerReceivesViewsAndIsListed) {
  ChildPeer vic(session_, keys_->vic,
                {.role = Role::kViewer, .secure = (keys_->ours() / "vic").string()});
  EXPECT_TRUE(vic.Says("view " + std::to_string(keys_->anna)));
  EXPECT_TRUE(vic.Says("scene 42"));
  const PeerId id = keys_->vic;
  EXPECT_TRUE(received_.WaitFor([id](const Recorder::Heard& h) {
    return h.infos.contains(id);
  }));
}

// The rogue of the next tests is heard when it keeps to its place, so that those tests could fail.
TEST_F(Security, LaxMemberIsHeardInItsOwnPartition) {
  ChildPeer carl = Rogue(keys_->ours() / "carl", keys_->carl, true);
  EXPECT_TRUE(carl.Says("writing"));
  EXPECT_TRUE(Heard(keys_->carl));
}

TEST_F(Security, PlainParticipantIsIsolated) {
  ChildPeer rogue = Rogue("-", keys_->carl, false);
  ExpectKeptOut(rogue, keys_->carl);
  EXPECT_FALSE(rogue.Says("matched", std::chrono::milliseconds(1)));
  constexpr PeerId kPlain = 33;
  ChildPeer plain(session_, kPlain);
  EXPECT_TRUE(plain.Says("ready"));
  EXPECT_FALSE(plain.Says("state " + std::to_string(keys_->ben), kLongEnough));
  EXPECT_FALSE(received_.Now().states.contains(kPlain));
  EXPECT_FALSE(received_.Now().infos.contains(kPlain));
}

TEST_F(Security, CertificateOfAnotherAuthorityIsRefused) {
  // its own people trust it, ours do not
  ChildPeer stranger = Rogue(keys_->theirs() / "anna", keys_->rogue, false);
  ExpectKeptOut(stranger, keys_->rogue);

  // with our authorities' certificates beside it, its own plug-in finds it out
  const fs::path claims = keys_->Copy(keys_->theirs() / "anna", "claims");
  for (const char* file : {"identity_ca.pem", "permissions_ca.pem", "governance.p7s"}) {
    Replace(claims / file, keys_->ours() / file);
  }
  ChildPeer liar = Rogue(claims, keys_->rogue, true);
  EXPECT_TRUE(liar.Says("refused"));
}

TEST_F(Security, AViewerCannotWriteStates) {
  ChildPeer honest = Rogue(keys_->ours() / "vic", keys_->vic, false);
  EXPECT_TRUE(honest.Says("refused"));
  ChildPeer lax = Rogue(keys_->ours() / "vic", keys_->vic, true);
  ExpectKeptOut(lax, keys_->vic);
}

TEST_F(Security, PeerCannotWriteAsAnother) {
  const fs::path keys = keys_->ours() / "ben";
  ChildPeer honest = Rogue(keys, keys_->carl, false);
  EXPECT_TRUE(honest.Says("refused"));
  ChildPeer lax = Rogue(keys, keys_->carl, true);
  ExpectKeptOut(lax, keys_->carl);
}

TEST_F(Security, ForgedPermissionsAreRefused) {
  const std::time_t now = std::time(nullptr);
  const std::string wanted =
      PermissionsXml("vic", keys_->vic, Role::kActive, now - 3600, now + 3600);
  const fs::path vic = keys_->ours() / "vic";

  // signed by the viewer's own certificate, which the identity authority did sign
  const fs::path self = keys_->Copy(vic, "self");
  ASSERT_TRUE(
      SignDocument(wanted, {vic / "identity.pem", vic / "identity.key"}, self / "permissions.p7s"));
  ChildPeer by_itself = Rogue(self, keys_->vic, true);
  EXPECT_TRUE(by_itself.Says("refused"));

  // signed by an authority of its own, which it trusts and nobody else does
  const fs::path other = keys_->Copy(vic, "other");
  const fs::path theirs = keys_->theirs();
  const Authority authority{theirs / "permissions_ca.pem", theirs / "permissions_ca.key"};
  ASSERT_TRUE(SignDocument(wanted, authority, other / "permissions.p7s"));
  ASSERT_TRUE(SignDocument(GovernanceXml(), authority, other / "governance.p7s"));
  Replace(other / "permissions_ca.pem", authority.certificate);
  ChildPeer by_other = Rogue(other, keys_->vic, true);
  ExpectKeptOut(by_other, keys_->vic);
}

TEST_F(Security, ViewerKeysDoNotAllowActivity) {
  DdsOptions options = LoopbackOptions(session_, keys_->vic, Role::kActive);
  options.domain = 43;  // Anna is in 42
  options.secure = (keys_->ours() / "vic").string();
  Recorder received;
  const auto joined = JoinOverDds(options, received);
  ASSERT_FALSE(joined.has_value());
  EXPECT_THAT(joined.error().what, HasSubstr("the permissions of vic do not allow"));
}

TEST_F(Security, MembersNameIsThatOfItsKeys) {
  EXPECT_EQ(received_.Now().infos.at(keys_->ben).name, "ben") << "it says that it is Ada";
}

TEST_F(Security, ViewerCannotBecomeActive) {
  ChildPeer honest = Attacker("vic", "-", "claim", keys_->vic, keys_->ben);
  EXPECT_TRUE(honest.Says("refused"));
  ChildPeer lax = Attacker("vic", TANDEM_LAX_ACCESS_CONTROL, "claim", keys_->vic, keys_->ben);
  EXPECT_TRUE(lax.Says("attacking"));
  EXPECT_FALSE(HearsInfoOf(keys_->vic, kLongEnough));
}

TEST_F(Security, ForgingViewerRemainsAViewerOfItsName) {
  ChildPeer vic = Attacker("vic", "-", "look_on", keys_->vic, keys_->ben);
  EXPECT_TRUE(vic.Says("attacking"));
  ASSERT_TRUE(HearsInfoOf(keys_->vic));
  const PeerInfo info = received_.Now().infos.at(keys_->vic);
  EXPECT_EQ(info.role, Role::kViewer);
  EXPECT_TRUE(info.claims.empty());
  EXPECT_EQ(info.name, "vic") << "it says that it is mallory";
}

TEST_F(Security, OthersCannotMakeAPeerLeave) {
  ChildPeer vic =
      Attacker("vic", TANDEM_LAX_ACCESS_CONTROL, "look_on_as_victim", keys_->vic, keys_->ben);
  ChildPeer carl = Attacker("carl", TANDEM_LAX_ACCESS_CONTROL, "dispose", keys_->carl, keys_->ben);
  EXPECT_TRUE(vic.Says("attacking"));
  EXPECT_TRUE(carl.Says("attacking"));
  const PeerId ben = keys_->ben;
  EXPECT_FALSE(received_.WaitFor(
      [ben](const Recorder::Heard& h) {
        return h.left.contains(ben) || h.lost.contains(ben);
      },
      kLongEnough));
  EXPECT_TRUE(received_.Now().dropped.contains({keys_->carl, Drop::kImpostor}));
}

TEST_F(Security, OthersCannotKeepADeadPeerAlive) {
  const PeerId dave = keys_->dave;
  ChildPeer victim(session_, dave, {.secure = (keys_->ours() / "dave").string()});
  ASSERT_TRUE(HearsInfoOf(dave));
  ChildPeer vic = Attacker("vic", TANDEM_LAX_ACCESS_CONTROL, "look_on_as_victim", keys_->vic, dave);
  ChildPeer carl = Attacker("carl", TANDEM_LAX_ACCESS_CONTROL, "dispose", keys_->carl, dave);
  EXPECT_TRUE(vic.Says("attacking"));
  EXPECT_TRUE(carl.Says("attacking"));
  const PeerId member = keys_->carl;
  EXPECT_TRUE(received_.WaitFor([member](const Recorder::Heard& h) {
    return h.dropped.contains({member, Drop::kImpostor});
  }));
  victim.Signal(SIGKILL);
  EXPECT_TRUE(received_.WaitFor([dave](const Recorder::Heard& h) {
    return h.lost.contains(dave);
  }));
}

TEST_F(Security, MemberCannotForgeGrantsOrOffers) {
  ChildPeer carl =
      Attacker("carl", TANDEM_LAX_ACCESS_CONTROL, "offer_as_first", keys_->carl, keys_->ben);
  const PeerId id = keys_->carl;
  EXPECT_TRUE(received_.WaitFor([id](const Recorder::Heard& h) {
    return h.dropped.contains({id, Drop::kImpostor});
  }));
  for (const SceneManifest& manifest : received_.Now().scenes) EXPECT_NE(manifest.offered_by, 1U);
}

// Ben's keys a second time: the first goes on, the second is not heard, both are told.
TEST_F(Security, DuplicateKeysAreDetected) {
  ChildPeer second(session_, keys_->ben, {.secure = (keys_->ours() / "ben").string()});
  EXPECT_TRUE(second.Says("twin " + std::to_string(keys_->ben)));
  EXPECT_TRUE(ben_.Says("twin " + std::to_string(keys_->ben)));
  const PeerId ben = keys_->ben;
  EXPECT_TRUE(received_.WaitFor([ben](const Recorder::Heard& h) {
    return h.dropped.contains({ben, Drop::kTwin});
  }));
  EXPECT_FALSE(received_.Now().left.contains(ben));
  EXPECT_FALSE(received_.Now().lost.contains(ben));
}

TEST_F(Security, DuplicateViewerKeysAreDetected) {
  const auto look_on = [this] {
    return std::make_unique<ChildPeer>(
        session_, keys_->vic,
        ChildPeer::Options{.role = Role::kViewer, .secure = (keys_->ours() / "vic").string()});
  };
  const auto first = look_on();
  ASSERT_TRUE(HearsInfoOf(keys_->vic));
  const auto second = look_on();
  const PeerId vic = keys_->vic;
  EXPECT_TRUE(received_.WaitFor([vic](const Recorder::Heard& h) {
    return h.dropped.contains({vic, Drop::kTwin});
  }));
  EXPECT_FALSE(received_.Now().left.contains(vic));
  EXPECT_FALSE(received_.Now().lost.contains(vic));
}

TEST_F(Security, RevokedMemberIsRefused) {
  const fs::path session = keys_->Copy(keys_->ours(), "with_list");
  ASSERT_TRUE(RevokeMember(session, session / "carl").has_value());
  const fs::path dave = keys_->scratch.path() / "dave";
  const Result<PeerId> made = MakeMemberKeys(session, "dave", Role::kActive, dave);
  ASSERT_TRUE(made.has_value()) << made.error().what;
  // Dave has the list: he hears Ben and Anna, and nothing of Carl
  ChildPeer daves(session_, *made, {.secure = dave.string()});
  ChildPeer carl(session_, keys_->carl, {.secure = (keys_->ours() / "carl").string()});
  ASSERT_TRUE(HearsInfoOf(keys_->carl)) << "without the list he is a member";
  EXPECT_TRUE(daves.Says("state " + std::to_string(keys_->ben)));
  EXPECT_FALSE(daves.Says("info " + std::to_string(keys_->carl), kLongEnough));
  EXPECT_FALSE(carl.Says("info " + std::to_string(*made), kLongEnough));
}

}  // namespace
}  // namespace tandem::testing
