#include "collab/dds/security/revocation.h"

#include <fstream>
#include <set>
#include <sstream>

#include <gmock/gmock.h>
#include <sys/stat.h>

#include "collab/dds/security/openssl.h"
#include "collab/dds/security/signing.h"
#include "tests/collab/dds/security/member_folder.h"

namespace tandem::testing {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

std::string TextOf(const fs::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

using Revocation = MemberFolder;

TEST_F(Revocation, KeepsTheMemberOut) {
  const Result<RevokedMember> done = RevokeMember(session(), anna());
  ASSERT_TRUE(done.has_value()) << done.error().what;
  Replace(anna() / "revoked.p7s", session() / "revoked.p7s");
  EXPECT_THAT(WhyNot(), HasSubstr("the keys of anna have been revoked"));
}

// Anybody who had the folder may have written what else is in it.
TEST_F(Revocation, UsesTheFoldersCertificateRatherThanItsText) {
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

TEST_F(Revocation, CertificateOfAnotherAuthorityRevokesNobody) {
  const fs::path other = scratch_.path() / "other";
  ASSERT_TRUE(MakeSessionKeys(other));
  ASSERT_TRUE(MakeMemberKeys(other, "anna", Role::kActive, other / "anna"));
  const Result<RevokedMember> done = RevokeMember(session(), other / "anna");
  ASSERT_FALSE(done.has_value());
  EXPECT_THAT(done.error().what, HasSubstr("has not signed it"));
  // the authority itself is no member either
  Replace(anna() / "identity.pem", session() / "identity_ca.pem");
  EXPECT_FALSE(RevokeMember(session(), anna()));
  EXPECT_FALSE(fs::exists(session() / "revoked.p7s"));
}

TEST_F(Revocation, FindsAMemberByNameWithoutItsFolder) {
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

TEST_F(Revocation, AmbiguousNameNeedsTheId) {
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

TEST_F(Revocation, ToleratesATruncatedListEntry) {
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

TEST_F(Revocation, FailureLeavesBothListsUnchanged) {
  ASSERT_TRUE(RevokeMember(session(), anna()));
  const std::string before = TextOf(session() / "revoked.p7s");
  const std::string certificates = TextOf(session() / "identity.crl");
  ASSERT_TRUE(MakeMemberKeys(session(), "ben", Role::kActive, session() / "ben"));
  // the members' list can be signed, but not the list of certificates
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

TEST_F(Revocation, UnsignedListIsRefused) {
  std::ofstream(anna() / "revoked.p7s") << "revoked\n";
  EXPECT_THAT(WhyNot(), HasSubstr("is not signed by the permissions authority"));
}

// A corporate authority may have issued certificates to others, each of which would lead to it.
TEST_F(Revocation, ListSignedByAnIssuedCertificateIsRefused) {
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

TEST_F(Revocation, OtherSignedDocumentInPlaceOfTheListIsRefused) {
  Replace(anna() / "revoked.p7s", anna() / "permissions.p7s");
  EXPECT_THAT(WhyNot(), HasSubstr("revoked.p7s: is no list of revoked members"));
}

TEST_F(Revocation, PipeInPlaceOfAListIsRefusedAtOnce) {
  for (const char* list : {"identity.crl", "revoked.p7s"}) {
    const fs::path pipe = anna() / list;
    ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
    EXPECT_THAT(WhyNot(), HasSubstr("it is not a regular file"));
    fs::remove(pipe);
  }
}

TEST_F(Revocation, ListIsValidFromTheDayBeforeForClockSkew) {
  ASSERT_TRUE(RevokeMember(session(), anna()));
  const Result<std::string> output =
      Openssl({"crl", "-in", (session() / "identity.crl").string(), "-noout", "-lastupdate",
               "-nextupdate", "-dateopt", "iso_8601"});
  ASSERT_TRUE(output.has_value()) << output.error().what;
  const auto day = [&output](const std::string& word) {
    std::tm utc{};
    const std::size_t at = output->find(word);
    EXPECT_NE(at, std::string::npos) << *output;
    EXPECT_NE(strptime(output->c_str() + at + word.size(), "%Y-%m-%d %H:%M:%S", &utc), nullptr);
    return timegm(&utc);
  };
  // a minute for a slow machine
  const std::time_t now = std::time(nullptr);
  EXPECT_LE(day("lastUpdate="), now - kDay);
  EXPECT_GE(day("lastUpdate="), now - kDay - 60);
  EXPECT_NEAR(static_cast<double>(day("nextUpdate=")), static_cast<double>(now + 3650 * kDay), 60);
}

}  // namespace
}  // namespace tandem::testing
