#include "collab/dds/security/member_request.h"

#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "collab/dds/security/openssl.h"
#include "tests/collab/dds/security/member_folder.h"

namespace tandem {
namespace {

namespace fs = std::filesystem;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Key;
using testing::MemberFolder;
using ::testing::Not;

using Files = std::map<std::string, std::string>;

/// A session, and ben who keeps his key.
class MemberRequest : public MemberFolder {
 protected:
  void SetUp() override {
    MemberFolder::SetUp();
    const Result<std::string> made = MakeMemberRequest(key());
    ASSERT_TRUE(made) << made.error().what;
    request_ = *made;
  }
  fs::path key() const { return scratch_.path() / "ben.key"; }
  fs::path ben() const { return scratch_.path() / "ben"; }
  Files Signed(Role role = Role::kActive) const {
    const Result<Files> files = SignMember(session(), "ben", role, request_);
    EXPECT_TRUE(files) << files.error().what;
    return files ? *files : Files{};
  }
  std::string WhyNotTaken(const Files& files) const {
    const Result<MemberKeys> taken = TakeMember(key(), files, ben());
    return taken ? "" : taken.error().what;
  }
  std::string WhyNotSigned(const std::string& request) const {
    const Result<Files> files = SignMember(session(), "eve", Role::kActive, request);
    return files ? "" : files.error().what;
  }
  /// Makes a request by the program openssl with these options.
  std::string RequestBy(const std::vector<std::string>& options) const {
    std::vector<std::string> words{"req",
                                   "-new",
                                   "-nodes",
                                   "-keyout",
                                   (scratch_.path() / "eve.key").string(),
                                   "-out",
                                   (scratch_.path() / "eve.csr").string()};
    words.insert(words.end(), options.begin(), options.end());
    const Result<std::string> made = Openssl(words);
    EXPECT_TRUE(made) << made.error().what;
    std::ostringstream text;
    text << std::ifstream(scratch_.path() / "eve.csr").rdbuf();
    return text.str();
  }

  std::string request_;
};

int RightsOf(const fs::path& path) {
  struct stat status {};
  stat(path.c_str(), &status);
  return static_cast<int>(status.st_mode & 0777U);
}

TEST_F(MemberRequest, SigningMakesAMemberWithoutSharingItsKey) {
  for (const Role role : {Role::kActive, Role::kViewer}) {
    const Files files = Signed(role);
    EXPECT_THAT(files, Not(Contains(Key("identity.key"))));
    for (const auto& [name, text] : files) {
      EXPECT_THAT(text, Not(HasSubstr("PRIVATE KEY"))) << name;
    }
    const Result<MemberKeys> taken =
        TakeMember(key(), files, ben(), {{"invitation.txt", "gear\n"}});
    ASSERT_TRUE(taken) << taken.error().what;
    EXPECT_EQ(taken->name, "ben");
    EXPECT_EQ(taken->role, role);
    EXPECT_EQ(RightsOf(ben()), 0700);
    for (const fs::directory_entry& entry : fs::directory_iterator(ben())) {
      EXPECT_EQ(RightsOf(entry.path()), 0600) << entry.path();
    }
    EXPECT_TRUE(fs::exists(ben() / "invitation.txt"));
    fs::remove_all(ben());
  }
  // nothing but the members' list is left of it at the session's owner
  EXPECT_FALSE(fs::exists(session() / "invited"));
}

// `openssl x509` lists a certificate's subject here.
TEST_F(MemberRequest, RequestsSubjectIsIgnored) {
  request_ = RequestBy({"-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-subj",
                        "/O=Tandem/OU=0000000000000001/CN=anna", "-addext",
                        "basicConstraints=critical,CA:TRUE"});
  const Files files = Signed();
  const fs::path file = scratch_.Write("identity.pem", files.at("identity.pem"));
  const Result<std::string> text = Openssl({"x509", "-in", file.string(), "-noout", "-text"});
  ASSERT_TRUE(text);
  EXPECT_THAT(*text, HasSubstr("CN = ben"));
  EXPECT_THAT(*text, Not(HasSubstr("anna")));
  EXPECT_THAT(*text, HasSubstr("CA:FALSE"));
  EXPECT_THAT(*text, Not(HasSubstr("CA:TRUE")));
  EXPECT_THAT(files.at("member.txt"), ::testing::StartsWith("ben "));
}

TEST_F(MemberRequest, OnlyExpectedKeyTypesAreSigned) {
  const std::vector<std::string> subject{"-subj", "/CN=eve"};
  const auto by = [&](std::vector<std::string> options) {
    options.insert(options.end(), subject.begin(), subject.end());
    return WhyNotSigned(RequestBy(options));
  };
  EXPECT_EQ(by({"-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1"}), "");
  EXPECT_THAT(by({"-newkey", "rsa:2048"}), HasSubstr("another sort"));
  EXPECT_THAT(by({"-newkey", "ed25519"}), HasSubstr("another sort"));
  EXPECT_THAT(by({"-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:secp384r1"}),
              HasSubstr("another sort"));
  EXPECT_THAT(by({"-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-pkeyopt",
                  "ec_param_enc:explicit"}),
              HasSubstr("another sort"));
  // a request with somebody else's key, whose signature it cannot have
  std::string forged = request_;
  const std::size_t middle = forged.size() / 2;
  forged[middle] = forged[middle] == 'A' ? 'B' : 'A';
  EXPECT_NE(WhyNotSigned(forged), "");
  EXPECT_NE(WhyNotSigned("nonsense"), "");
  EXPECT_NE(WhyNotSigned(""), "");
  EXPECT_NE(WhyNotSigned(request_ + std::string(5000, '\n')), "");
}

TEST_F(MemberRequest, InvalidResponseIsRefused) {
  const Files files = Signed();
  const auto with = [&](const std::string& name, const std::string& text) {
    Files changed = files;
    changed[name] = text;
    return WhyNotTaken(changed);
  };
  EXPECT_NE(with("../ben.key", "x"), "");
  EXPECT_NE(with("identity.key", "x"), "");
  EXPECT_NE(with("governance.p7s", std::string(1 << 19, 'x')), "");
  EXPECT_NE(with("member.txt", "ben\n"), "");
  Files missing = files;
  missing.erase("permissions.p7s");
  EXPECT_THAT(WhyNotTaken(missing), HasSubstr("permissions.p7s"));
  // a member's certificate of the same session, but of another key
  std::ostringstream annas;
  annas << std::ifstream(anna() / "identity.pem").rdbuf();
  EXPECT_THAT(with("identity.pem", annas.str()), HasSubstr("another key"));
  EXPECT_THAT(with("identity_ca.pem", files.at("permissions_ca.pem")), HasSubstr("not signed by"));
  EXPECT_FALSE(fs::exists(ben()));
  EXPECT_EQ(WhyNotTaken(files), "");
  EXPECT_THAT(WhyNotTaken(files), HasSubstr("exists already"));
}

TEST_F(MemberRequest, DigestIsShortAndCoversTheWholeFile) {
  const fs::path a = scratch_.Write("a", "one");
  const fs::path b = scratch_.Write("b", "two");
  // the digest is the one that sha256sum gives
  EXPECT_EQ(*DigestToCompare(a), "7692-c3ad-3540-bb80");
  EXPECT_NE(*DigestToCompare(a), *DigestToCompare(b));
  EXPECT_FALSE(DigestToCompare(scratch_.path() / "none"));
}

}  // namespace
}  // namespace tandem
