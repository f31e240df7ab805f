#include "collab/dds/security/keys.h"

#include <fstream>

#include <gmock/gmock.h>

#include "collab/dds/security/openssl.h"
#include "collab/dds/security/signing.h"
#include "tests/collab/dds/security/member_folder.h"
#include "tests/support/scratch_folder.h"

namespace tandem::testing {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

TEST(Keys, SingleAuthorityForBothRolesIsRefused) {
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

TEST(Keys, MemberFolderIsPrivateAndHasNoAuthorityKey) {
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

// Each authority signs what is its alone. An authority that has issued the other could be reached
// from every member's certificate.
TEST(Keys, AuthorityThatIssuedTheOtherIsRefused) {
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

TEST_F(MemberFolder, IsLoadedAsWritten) {
  EXPECT_EQ(WhyNot(), "");
}

TEST_F(MemberFolder, WithAReadablePrivateKeyIsRefused) {
  fs::permissions(anna() / "identity.key", fs::perms::group_read, fs::perm_options::add);
  EXPECT_THAT(WhyNot(), HasSubstr("others can read or change this private key"));
}

TEST_F(MemberFolder, WritableByOthersIsRefused) {
  fs::permissions(anna(), fs::perms::others_write, fs::perm_options::add);
  EXPECT_THAT(WhyNot(), HasSubstr("others can change what is in this folder"));
}

TEST_F(MemberFolder, IsValidFromTheDayBeforeForClockSkew) {
  const std::time_t now = std::time(nullptr);
  EXPECT_EQ(WhyNot(now - kDay + 60), "");
  EXPECT_THAT(WhyNot(now - kDay - 60), HasSubstr("not valid yet"));
  EXPECT_THAT(WhyNot(now - kDay - 60), HasSubstr("set the clock"));
  EXPECT_THAT(WhyNot(now + 31 * kDay), HasSubstr("these keys ended on"));
}

TEST_F(MemberFolder, WarnsAWeekBeforeExpiry) {
  const std::time_t now = std::time(nullptr);
  const Result<MemberKeys> keys = LoadMemberKeys(anna());
  ASSERT_TRUE(keys.has_value()) << keys.error().what;
  EXPECT_EQ(ExpiryWarning(*keys, now + 22 * kDay), "");
  EXPECT_THAT(ExpiryWarning(*keys, now + 24 * kDay), HasSubstr("the keys of anna end on"));
}

TEST_F(MemberFolder, WarnsTwoSecondsBeforeExpiry) {
  const Result<MemberKeys> keys = LoadMemberKeys(anna());
  ASSERT_TRUE(keys.has_value()) << keys.error().what;
  EXPECT_EQ(EndOfKeys(*keys, keys->not_after - 3), "");
  EXPECT_THAT(EndOfKeys(*keys, keys->not_after - 2), HasSubstr("the keys of anna have ended"));
  EXPECT_EQ(EndOfKeys(MemberKeys{}, keys->not_after), "") << "a plain session has no keys";
}

// What protocol 6 adds needs no other permission.
TEST_F(MemberFolder, OfProtocolFiveStaysValid) {
  std::ofstream(anna() / "member.txt") << "anna 0123456789abcdef peer 5\n";
  const Result<MemberKeys> keys = LoadMemberKeys(anna());
  EXPECT_TRUE(keys.has_value()) << keys.error().what;
}

TEST_F(MemberFolder, OfAnOlderProtocolIsRefusedWithAReason) {
  const Result<MemberKeys> keys = LoadMemberKeys(anna());
  ASSERT_TRUE(keys.has_value()) << keys.error().what;
  std::ofstream(anna() / "member.txt") << "anna 0123456789abcdef peer\n";
  EXPECT_THAT(WhyNot(), HasSubstr("these keys are for protocol 4 or before"));
}

TEST(Keys, ExpireWithTheSessionsAuthorities) {
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
