#include "collab/dds/keys.h"

#include <fstream>
#include <sstream>

#include <gmock/gmock.h>
#include <sys/stat.h>

#include "collab/dds/openssl.h"
#include "collab/dds/signing.h"
#include "tests/support/scratch_folder.h"

namespace tandem::testing {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

constexpr std::time_t kDay = 86'400;

void Replace(const fs::path& file, const fs::path& by) {
  fs::copy_file(by, file, fs::copy_options::overwrite_existing);
}

std::string TextOf(const fs::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

/// A session with a member anna.
class MemberFolder : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(MakeSessionKeys(session()).has_value());
    const Result<PeerId> made = MakeMemberKeys(session(), "anna", Role::kActive, anna(), 30);
    ASSERT_TRUE(made.has_value()) << made.error().what;
  }
  fs::path session() const { return scratch_.path() / "s"; }
  fs::path anna() const { return session() / "anna"; }
  std::string WhyNot(std::time_t now = std::time(nullptr)) const {
    const Result<MemberKeys> keys = LoadMemberKeys(anna(), now);
    return keys ? "" : keys.error().what;
  }

  ScratchFolder scratch_;
};

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

// Authorities that sign what is theirs alone: one that has issued the other could be reached from
// every member's certificate.
TEST(Keys, AnAuthorityThatIssuedTheOtherIsRefused) {
  const ScratchFolder scratch;
  const fs::path at = scratch.path();
  ASSERT_TRUE(MakeSessionKeys(at / "root"));
  const Authority root{at / "root" / "identity_ca.pem", at / "root" / "identity_ca.key"};
  // an authority of identities below it
  std::ofstream(at / "ca.ext") << "basicConstraints=critical,CA:TRUE\n";
  ASSERT_TRUE(Openssl({"req", "-new", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1",
                       "-nodes", "-subj", "/O=Corp/CN=below", "-keyout",
                       (at / "below.key").string(), "-out", (at / "below.csr").string()}));
  ASSERT_TRUE(Openssl({"x509", "-req", "-in", (at / "below.csr").string(), "-CA",
                       root.certificate.string(), "-CAkey", root.key.string(), "-CAcreateserial",
                       "-extfile", (at / "ca.ext").string(), "-out", (at / "below.pem").string()}));
  const Authority below{at / "below.pem", at / "below.key"};
  const Result<bool> made = MakeSessionKeys(at / "session", below, root);
  ASSERT_FALSE(made.has_value());
  EXPECT_THAT(made.error().what, HasSubstr("issued"));
  EXPECT_FALSE(MakeSessionKeys(at / "session", root, below).has_value());
}

TEST_F(MemberFolder, IsTakenAsItWasMade) {
  EXPECT_EQ(WhyNot(), "");
}

TEST_F(MemberFolder, WithAPrivateKeyThatOthersReadIsRefused) {
  fs::permissions(anna() / "identity.key", fs::perms::group_read, fs::perm_options::add);
  EXPECT_THAT(WhyNot(), HasSubstr("others can read or change this private key"));
}

TEST_F(MemberFolder, ThatOthersMayWriteToIsRefused) {
  fs::permissions(anna(), fs::perms::others_write, fs::perm_options::add);
  EXPECT_THAT(WhyNot(), HasSubstr("others can change what is in this folder"));
}

TEST_F(MemberFolder, IsValidFromADayBackForClocksDiffer) {
  const std::time_t now = std::time(nullptr);
  EXPECT_EQ(WhyNot(now - kDay + 60), "");
  EXPECT_THAT(WhyNot(now - kDay - 60), HasSubstr("not valid yet"));
  EXPECT_THAT(WhyNot(now - kDay - 60), HasSubstr("set the clock"));
  EXPECT_THAT(WhyNot(now + 31 * kDay), HasSubstr("these keys ended on"));
}

TEST_F(MemberFolder, SaysAWeekAheadThatItEnds) {
  const std::time_t now = std::time(nullptr);
  const Result<MemberKeys> keys = LoadMemberKeys(anna());
  ASSERT_TRUE(keys.has_value()) << keys.error().what;
  EXPECT_EQ(ExpiryWarning(*keys, now + 22 * kDay), "");
  EXPECT_THAT(ExpiryWarning(*keys, now + 24 * kDay), HasSubstr("the keys of anna end on"));
}

TEST_F(MemberFolder, OfAnOlderProtocolIsRefusedInWords) {
  const Result<MemberKeys> keys = LoadMemberKeys(anna());
  ASSERT_TRUE(keys.has_value()) << keys.error().what;
  std::ofstream(anna() / "member.txt") << "anna 0123456789abcdef peer\n";
  EXPECT_THAT(WhyNot(), HasSubstr("these keys are for protocol 4 or before"));
}

TEST_F(MemberFolder, OfARevokedMemberIsRefused) {
  const Result<RevokedMember> done = RevokeMember(session(), anna());
  ASSERT_TRUE(done.has_value()) << done.error().what;
  Replace(anna() / "revoked.p7s", session() / "revoked.p7s");
  EXPECT_THAT(WhyNot(), HasSubstr("the keys of anna have been revoked"));
}

// What else is in the folder anybody may have written who had it.
TEST_F(MemberFolder, IsRevokedByItsCertificateAndNotByItsWords) {
  const fs::path ben = session() / "ben";
  const Result<PeerId> id = MakeMemberKeys(session(), "ben", Role::kActive, ben);
  ASSERT_TRUE(id.has_value()) << id.error().what;
  Replace(ben / "member.txt", anna() / "member.txt");
  const Result<RevokedMember> done = RevokeMember(session(), ben);
  ASSERT_TRUE(done.has_value()) << done.error().what;
  EXPECT_EQ(done->name, "ben");
  EXPECT_EQ(done->peer, *id);
  Replace(anna() / "revoked.p7s", session() / "revoked.p7s");
  EXPECT_EQ(WhyNot(), "");
  const Result<MemberKeys> keys = LoadMemberKeys(anna());
  ASSERT_TRUE(keys.has_value());
  EXPECT_EQ(keys->revoked, std::set<PeerId>{*id});
}

TEST_F(MemberFolder, WhoseCertificateIsOfAnotherAuthorityRevokesNobody) {
  const fs::path other = scratch_.path() / "other";
  ASSERT_TRUE(MakeSessionKeys(other));
  ASSERT_TRUE(MakeMemberKeys(other, "anna", Role::kActive, other / "anna"));
  const Result<RevokedMember> done = RevokeMember(session(), other / "anna");
  ASSERT_FALSE(done.has_value());
  EXPECT_THAT(done.error().what, HasSubstr("has not signed it"));
  // nor is the authority itself a member
  Replace(anna() / "identity.pem", session() / "identity_ca.pem");
  EXPECT_FALSE(RevokeMember(session(), anna()));
  EXPECT_FALSE(fs::exists(session() / "revoked.p7s"));
}

TEST_F(MemberFolder, ThatIsGoneIsRevokedByTheMembersName) {
  const Result<MemberKeys> keys = LoadMemberKeys(anna());
  ASSERT_TRUE(keys.has_value());
  const fs::path away = scratch_.path() / "away";
  fs::rename(anna(), away);
  EXPECT_THAT(RevokeMember(session(), "ben").error().what, HasSubstr("nobody of that name"));
  EXPECT_THAT(RevokeMember(session(), anna()).error().what, HasSubstr("no such folder"));
  const Result<RevokedMember> done = RevokeMember(session(), "anna");
  ASSERT_TRUE(done.has_value()) << done.error().what;
  EXPECT_EQ(done->peer, keys->peer);
  Replace(away / "revoked.p7s", session() / "revoked.p7s");
  EXPECT_THAT(LoadMemberKeys(away).error().what, HasSubstr("the keys of anna have been revoked"));
}

TEST_F(MemberFolder, OfANameThatSeveralHaveIsRevokedByTheId) {
  const Result<PeerId> second =
      MakeMemberKeys(session(), "anna", Role::kViewer, scratch_.path() / "second");
  ASSERT_TRUE(second.has_value()) << second.error().what;
  const Result<RevokedMember> both = RevokeMember(session(), "anna");
  ASSERT_FALSE(both.has_value());
  EXPECT_THAT(both.error().what, HasSubstr("2 of that name have keys"));
  EXPECT_THAT(both.error().what, HasSubstr(SerialOf(*second)));
  Result<RevokedMember> done = RevokeMember(session(), SerialOf(*second));
  ASSERT_TRUE(done.has_value()) << done.error().what;
  EXPECT_EQ(done->peer, *second);
  // one is left
  done = RevokeMember(session(), "anna");
  ASSERT_TRUE(done.has_value()) << done.error().what;
  EXPECT_NE(done->peer, *second);
}

TEST_F(MemberFolder, IsInTheSessionsListThoughALineOfItWasCutOff) {
  const fs::path list = session() / "members.txt";
  const std::string before = TextOf(list);
  EXPECT_EQ(before, "anna " + SerialOf(LoadMemberKeys(anna())->peer) + " peer\n");
  std::ofstream(list, std::ios::app) << "carl 0123";
  const Result<PeerId> ben =
      MakeMemberKeys(session(), "ben", Role::kViewer, scratch_.path() / "ben");
  ASSERT_TRUE(ben.has_value()) << ben.error().what;
  EXPECT_EQ(TextOf(list), before + "carl 0123\nben " + SerialOf(*ben) + " viewer\n");
  EXPECT_TRUE(RevokeMember(session(), "ben"));
  EXPECT_FALSE(RevokeMember(session(), "carl"));
}

TEST_F(MemberFolder, IsKeptByBothListsWhereARevocationFailsHalfway) {
  ASSERT_TRUE(RevokeMember(session(), anna()));
  const std::string before = TextOf(session() / "revoked.p7s");
  const std::string certificates = TextOf(session() / "identity.crl");
  ASSERT_TRUE(MakeMemberKeys(session(), "ben", Role::kActive, session() / "ben"));
  // the members' list can be signed, that of certificates cannot
  fs::rename(session() / "identity_ca.key", session() / "away.key");
  EXPECT_FALSE(RevokeMember(session(), session() / "ben"));
  EXPECT_EQ(TextOf(session() / "revoked.p7s"), before);
  EXPECT_EQ(TextOf(session() / "identity.crl"), certificates);
  for (const fs::directory_entry& left : fs::directory_iterator(session())) {
    EXPECT_EQ(left.path().string().find("unfinished"), std::string::npos) << left.path();
  }
  fs::rename(session() / "away.key", session() / "identity_ca.key");
  EXPECT_TRUE(RevokeMember(session(), session() / "ben"));
  EXPECT_NE(TextOf(session() / "revoked.p7s"), before);
}

TEST_F(MemberFolder, WithAListThatNobodySignedIsRefused) {
  std::ofstream(anna() / "revoked.p7s") << "revoked\n";
  EXPECT_THAT(WhyNot(), HasSubstr("is not signed by the permissions authority"));
}

// A corporate authority may have issued certificates to others, each of which would lead to it.
TEST_F(MemberFolder, WithAListThatAnotherSignedWhomTheAuthorityIssuedIsRefused) {
  const fs::path at = scratch_.path();
  const Authority authority{session() / "permissions_ca.pem", session() / "permissions_ca.key"};
  const Authority other{at / "other.pem", at / "other.key"};
  ASSERT_TRUE(MakeRequest("/O=Corp/CN=other", other.key, at / "other.csr"));
  ASSERT_TRUE(SignRequest(at / "other.csr", authority, false, 7, std::time(nullptr) + 30 * kDay,
                          other.certificate));
  ASSERT_TRUE(SignDocument("revoked\n0123456789ABCDEF\n", other, anna() / "revoked.p7s"));
  EXPECT_THAT(WhyNot(), HasSubstr("is not signed by the permissions authority"));
  ASSERT_TRUE(SignDocument("revoked\n0123456789ABCDEF\n", authority, anna() / "revoked.p7s"));
  EXPECT_EQ(WhyNot(), "");
  const Result<MemberKeys> keys = LoadMemberKeys(anna());
  ASSERT_TRUE(keys.has_value());
  EXPECT_EQ(keys->revoked, std::set<PeerId>{0x0123456789ABCDEF});
}

TEST_F(MemberFolder, WithAnotherDocumentOfTheAuthorityInPlaceOfTheListIsRefused) {
  Replace(anna() / "revoked.p7s", anna() / "permissions.p7s");
  EXPECT_THAT(WhyNot(), HasSubstr("revoked.p7s: is no list of revoked members"));
}

TEST_F(MemberFolder, WithAPipeInPlaceOfAListIsRefusedAtOnce) {
  for (const char* list : {"identity.crl", "revoked.p7s"}) {
    const fs::path pipe = anna() / list;
    ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
    EXPECT_THAT(WhyNot(), HasSubstr("it is not a regular file"));
    fs::remove(pipe);
  }
}

TEST_F(MemberFolder, HasAListOfCertificatesFromADayBackForClocksDiffer) {
  ASSERT_TRUE(RevokeMember(session(), anna()));
  const Result<std::string> said =
      Openssl({"crl", "-in", (session() / "identity.crl").string(), "-noout", "-lastupdate",
               "-nextupdate", "-dateopt", "iso_8601"});
  ASSERT_TRUE(said.has_value()) << said.error().what;
  const auto day = [&said](const std::string& word) {
    std::tm utc{};
    const std::size_t at = said->find(word);
    EXPECT_NE(at, std::string::npos) << *said;
    EXPECT_NE(strptime(said->c_str() + at + word.size(), "%Y-%m-%d %H:%M:%S", &utc), nullptr);
    return timegm(&utc);
  };
  // a minute for a slow machine
  const std::time_t now = std::time(nullptr);
  EXPECT_LE(day("lastUpdate="), now - kDay);
  EXPECT_GE(day("lastUpdate="), now - kDay - 60);
  EXPECT_NEAR(static_cast<double>(day("nextUpdate=")), static_cast<double>(now + 3650 * kDay), 60);
}

TEST(Keys, EndWithTheSessionsAuthorities) {
  const ScratchFolder scratch;
  const fs::path session = scratch.path() / "s";
  const fs::path anna = session / "anna";
  ASSERT_TRUE(MakeSessionKeys(session, {}, {}, 3));
  ASSERT_TRUE(MakeMemberKeys(session, "anna", Role::kActive, anna, 365));
  const std::time_t now = std::time(nullptr);
  const auto expect_end = [&] {
    const Result<MemberKeys> keys = LoadMemberKeys(anna, now);
    ASSERT_TRUE(keys.has_value()) << keys.error().what;
    EXPECT_THAT(ExpiryWarning(*keys, now), HasSubstr("the keys of anna end on"));
    const Result<MemberKeys> later = LoadMemberKeys(anna, now + 4 * kDay);
    ASSERT_FALSE(later.has_value());
    EXPECT_THAT(later.error().what, HasSubstr("these keys ended on"));
  };
  expect_end();
  // a member's certificate is not valid for longer than its authority
  const Result<std::string> certificate =
      Openssl({"x509", "-in", (anna / "identity.pem").string(), "-noout", "-checkend", "345600"});
  EXPECT_FALSE(certificate.has_value()) << "valid in four days";

  // nor do keys count for longer whose certificate says so
  const Authority authority{session / "identity_ca.pem", session / "identity_ca.key"};
  ASSERT_TRUE(MakeRequest("/CN=anna", anna / "identity.key", anna / "identity.csr"));
  ASSERT_TRUE(SignRequest(anna / "identity.csr", authority, false, 7, now + 365 * kDay,
                          anna / "identity.pem"));
  fs::permissions(anna / "identity.key", fs::perms::owner_read | fs::perms::owner_write);
  expect_end();
}

}  // namespace
}  // namespace tandem::testing
