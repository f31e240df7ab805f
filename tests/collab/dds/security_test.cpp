#include <fstream>

#include <gmock/gmock.h>

#include "collab/dds/dds_transport.h"
#include "collab/dds/keys.h"
#include "collab/dds/partitions.h"
#include "collab/dds/permissions.h"
#include "tests/collab/dds/child_peer.h"
#include "tests/collab/dds/live_peer.h"
#include "tests/support/scratch_folder.h"

namespace tandem::testing {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

// Members meet within a quarter of a second; one who has not been let in after this is not.
constexpr std::chrono::milliseconds kLongEnough{1500};

// Keys of one session with three peers and a viewer, and of another session.
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
    vic = member(ours(), "vic", Role::kViewer);
    rogue = member(theirs(), "anna", Role::kActive);
  }
  fs::path ours() const { return scratch.path() / "ours"; }
  fs::path theirs() const { return scratch.path() / "theirs"; }
  // A copy of a member's folder, to be tampered with.
  fs::path Copy(const fs::path& folder, const std::string& name) const {
    const fs::path copy = scratch.path() / name;
    fs::copy(folder, copy);
    return copy;
  }

  ScratchFolder scratch;
  PeerId anna = 0, ben = 0, carl = 0, vic = 0, rogue = 0;
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
    auto joined = JoinOverDds(options, heard_);
    EXPECT_TRUE(joined.has_value()) << joined.error().what;
    if (joined) anna_ = std::make_unique<LivePeer>(*std::move(joined), options, options.peer);
  }
  void SetUp() override { ASSERT_TRUE(HearsBen()); }
  void TearDown() override { EXPECT_TRUE(HearsBen()) << "the session did not go on"; }

  // Whether states of Ben still come.
  bool HearsBen() {
    const Recorder::Heard now = heard_.Now();
    const PeerId ben = keys_->ben;
    const std::uint32_t seq = now.states.contains(ben) ? now.states.at(ben).seq : 0;
    return heard_.WaitFor([=](const Recorder::Heard& h) {
      return h.states.contains(ben) && h.states.at(ben).seq > seq + 100 && h.infos.contains(ben);
    });
  }

  // One that publishes states of `claimed` in its partition, with these keys ("-": none).
  ChildPeer Rogue(const fs::path& keys, PeerId claimed, bool lax) {
    std::vector<std::string> command{TANDEM_DDS_ROGUE_PEER, session_, keys.string(),
                                     PeerPartition(claimed), std::to_string(claimed)};
    if (lax) command.emplace_back(TANDEM_LAX_ACCESS_CONTROL);
    return ChildPeer(command);
  }
  bool Heard(PeerId peer) {
    return heard_.WaitFor(
        [peer](const Recorder::Heard& h) {
          return h.states.contains(peer);
        },
        kLongEnough);
  }
  void ExpectKeptOut(ChildPeer& rogue, PeerId claimed) {
    EXPECT_TRUE(rogue.Says("writing"));
    EXPECT_FALSE(Heard(claimed));
  }

  static std::unique_ptr<Keys> keys_;
  const std::string session_ = RandomSession();
  Recorder heard_;
  ChildPeer ben_;
  std::unique_ptr<LivePeer> anna_;
};
std::unique_ptr<Keys> Security::keys_;

TEST_F(Security, MembersHearOneAnother) {
  EXPECT_TRUE(ben_.Says("state " + std::to_string(keys_->anna)));
  EXPECT_TRUE(ben_.Says("scene 42"));
}

TEST_F(Security, AViewerHearsViewsAndIsSeen) {
  ChildPeer vic(session_, keys_->vic,
                {.role = Role::kViewer, .secure = (keys_->ours() / "vic").string()});
  EXPECT_TRUE(vic.Says("view " + std::to_string(keys_->anna)));
  EXPECT_TRUE(vic.Says("scene 42"));
  const PeerId id = keys_->vic;
  EXPECT_TRUE(heard_.WaitFor([id](const Recorder::Heard& h) {
    return h.infos.contains(id);
  }));
}

// The next tests' rogue is heard when it keeps to its place: what follows could fail.
TEST_F(Security, ALaxMemberIsHeardInItsOwnPlace) {
  ChildPeer carl = Rogue(keys_->ours() / "carl", keys_->carl, true);
  EXPECT_TRUE(carl.Says("writing"));
  EXPECT_TRUE(Heard(keys_->carl));
}

TEST_F(Security, APlainParticipantIsNeitherHeardNorHears) {
  ChildPeer rogue = Rogue("-", keys_->carl, false);
  ExpectKeptOut(rogue, keys_->carl);
  EXPECT_FALSE(rogue.Says("matched", std::chrono::milliseconds(1)));
  constexpr PeerId kPlain = 33;
  ChildPeer plain(session_, kPlain);
  EXPECT_TRUE(plain.Says("ready"));
  EXPECT_FALSE(plain.Says("state " + std::to_string(keys_->ben), kLongEnough));
  EXPECT_FALSE(heard_.Now().states.contains(kPlain));
  EXPECT_FALSE(heard_.Now().infos.contains(kPlain));
}

TEST_F(Security, ACertificateOfAnotherAuthorityIsRefused) {
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

TEST_F(Security, OnePeerCannotWriteAsAnother) {
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

TEST_F(Security, AViewersKeysDoNotLetItTakePart) {
  DdsOptions options = LoopbackOptions(session_, keys_->vic, Role::kActive);
  options.domain = 43;  // Anna is in 42
  options.secure = (keys_->ours() / "vic").string();
  Recorder heard;
  const auto joined = JoinOverDds(options, heard);
  ASSERT_FALSE(joined.has_value());
  EXPECT_THAT(joined.error().what, HasSubstr("the permissions of vic do not allow"));
}

TEST(Keys, OneAuthorityForBothIsRefused) {
  const ScratchFolder scratch;
  ASSERT_TRUE(MakeSessionKeys(scratch.path() / "a"));
  const Authority one{scratch.path() / "a" / "identity_ca.pem",
                      scratch.path() / "a" / "identity_ca.key"};
  const Result<bool> made = MakeSessionKeys(scratch.path() / "b", one, one);
  ASSERT_FALSE(made.has_value());
  EXPECT_THAT(made.error().what, HasSubstr("one authority for both"));
  EXPECT_FALSE(fs::exists(scratch.path() / "b"));

  // neither by a trick with files, when members are made …
  const fs::path session = scratch.path() / "a";
  Replace(session / "permissions_ca.pem", session / "identity_ca.pem");
  Replace(session / "permissions_ca.key", session / "identity_ca.key");
  EXPECT_FALSE(MakeMemberKeys(session, "eve", Role::kActive, scratch.path() / "eve"));
}

TEST(Keys, AMembersFolderHasNoAuthoritysKeyAndIsReadableByItsOwnerOnly) {
  const ScratchFolder scratch;
  ASSERT_TRUE(MakeSessionKeys(scratch.path() / "s"));
  const fs::path out = scratch.path() / "anna";
  const Result<PeerId> peer = MakeMemberKeys(scratch.path() / "s", "anna", Role::kActive, out);
  ASSERT_TRUE(peer.has_value()) << peer.error().what;
  EXPECT_FALSE(fs::exists(out / "identity_ca.key"));
  EXPECT_FALSE(fs::exists(out / "permissions_ca.key"));
  for (const fs::directory_entry& file : fs::directory_iterator(out)) {
    const fs::perms others = fs::perms::group_all | fs::perms::others_all;
    EXPECT_EQ(file.status().permissions() & others, fs::perms::none) << file.path();
  }
  const Result<MemberKeys> keys = LoadMemberKeys(out);
  ASSERT_TRUE(keys.has_value()) << keys.error().what;
  EXPECT_EQ(keys->peer, *peer);
  EXPECT_EQ(keys->name, "anna");
  EXPECT_FALSE(MakeMemberKeys(scratch.path() / "s", "anna", Role::kActive, out))
      << "keys are overwritten";
  fs::remove(out / "governance.p7s");
  EXPECT_THAT(LoadMemberKeys(out).error().what, HasSubstr("governance.p7s is missing"));
}

}  // namespace
}  // namespace tandem::testing
