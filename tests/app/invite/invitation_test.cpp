#include "app/invite/invitation.h"

#include <algorithm>
#include <array>
#include <random>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace tandem {
namespace {

using ::testing::HasSubstr;
using ::testing::MatchesRegex;
using ::testing::Not;
using ::testing::StartsWith;

Secret128 Drawn(std::mt19937& random) {
  Secret128 bytes{};
  for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random());
  return bytes;
}

Invitation PlainOne() {
  Invitation invitation;
  invitation.session = "gear";
  invitation.hosts = {"192.0.2.1:17910", "10.0.0.5"};
  invitation.scene = {
      .digest = Sha256Of(std::string("bracket")), .bodies = 9, .file = "bracket.json"};
  return invitation;
}

Invitation SecuredOne() {
  std::mt19937 random(4);
  Invitation invitation = PlainOne();
  invitation.secured = true;
  invitation.role = Role::kViewer;
  invitation.domain = 7;
  invitation.others = {"site-b.example.org", "192.0.2.9:4000"};
  invitation.enrolment = {
      .port = 17910, .until = 1'790'000'000, .secret = Drawn(random), .certificate = Drawn(random)};
  return invitation;
}

std::string WhyNotRead(const std::string& line) {
  const Result<Invitation> read = ReadInvitation(line);
  return read ? "" : read.error().what;
}

TEST(Invitation, LineRoundTrips) {
  std::mt19937 random(1);
  for (int i = 0; i < 300; ++i) {
    Invitation invitation = i % 2 == 0 ? PlainOne() : SecuredOne();
    invitation.session.clear();
    // plain text of any script, with all that a line must encode: names of one to four bytes a
    // letter
    const std::size_t length = 1 + random() % (Invitation::kLongestSession / 4);
    for (std::size_t k = 0; k < length; ++k) {
      constexpr std::array kLetters{"é", "山", "😀"};
      const std::size_t letter = random() % 98;
      invitation.session += letter < 95 ? std::string(1, static_cast<char>(' ' + letter))
                                        : std::string(kLetters[letter - 95]);
    }
    if (random() % 2 == 0)
      invitation.scene = {
          .digest = Sha256Of(std::to_string(random())), .bodies = 3, .file = "a b.c"};
    if (random() % 3 == 0) invitation.scene = {};
    if (invitation.secured) invitation.enrolment.secret = Drawn(random);
    const Result<Invitation> read = ReadInvitation(LineOf(invitation));
    ASSERT_TRUE(read) << read.error().what;
    EXPECT_EQ(*read, invitation);
  }
}

// A line has what RFC 3986 leaves unreserved, and '/', ':', ',', '=', '%', '#'. No mail program
// breaks a line there, and no shell takes one of them for its own within a word.
TEST(Invitation, LineSurvivesMailAndShell) {
  Invitation invitation = SecuredOne();
  invitation.session = "Nose gear & \"bay\" $HOME `x` ä;|<>*?!";
  const std::string line = LineOf(invitation);
  EXPECT_THAT(line, MatchesRegex("tandem://[A-Za-z0-9._~/:,=%#-]*"));
  for (const std::string& copied : {" " + line + "\r\n", "<" + line + ">", "\"" + line + "\""}) {
    const Result<Invitation> read = ReadInvitation(copied);
    ASSERT_TRUE(read) << copied;
    EXPECT_EQ(*read, invitation);
  }
}

TEST(Invitation, AnyAlteredLineIsRefused) {
  for (const std::string& line : {LineOf(PlainOne()), LineOf(SecuredOne())}) {
    for (std::size_t at = 0; at < line.size(); ++at) {
      for (const char by : {'a', 'B', '0', '/', '%'}) {
        if (line[at] == by) continue;
        std::string altered = line;
        altered[at] = by;
        EXPECT_NE(WhyNotRead(altered), "") << altered;
      }
      std::string cut = line;
      cut.erase(at, 1);
      EXPECT_NE(WhyNotRead(cut), "") << cut;
      EXPECT_NE(WhyNotRead(line.substr(0, at)), "") << at;
    }
    EXPECT_NE(WhyNotRead(line + "a"), "");
    EXPECT_THAT(WhyNotRead(line.substr(0, 60)), HasSubstr("copy the whole line"));
  }
}

TEST(Invitation, MalformedLineIsRefusedInOneLine) {
  std::mt19937 random(2);
  std::vector<std::string> lines{"",
                                 "gear",
                                 "tandem://",
                                 "http://192.0.2.1/gear",
                                 "tandem:///#",
                                 "tandem://h/s#00000000",
                                 std::string(5000, 'a'),
                                 "tandem://" + std::string(5000, 'a')};
  for (int i = 0; i < 500; ++i) {
    std::string line = "tandem://";
    const std::size_t length = random() % 200;
    for (std::size_t k = 0; k < length; ++k) line += "az09/=,:#%.\n"[random() % 12];
    lines.push_back(line);
  }
  for (const std::string& line : lines) {
    const std::string why = WhyNotRead(line);
    EXPECT_NE(why, "") << line;
    EXPECT_THAT(why, Not(HasSubstr("\n")));
    EXPECT_LT(why.size(), 200U);
  }
}

// LineOf() spells whatever it is given, so that these lines have a good CHECK.
TEST(Invitation, WellFormedImpossibleLineIsRefused) {
  const auto with = [](const auto& change) {
    Invitation invitation = SecuredOne();
    change(invitation);
    return WhyNotRead(LineOf(invitation));
  };
  EXPECT_EQ(with([](Invitation&) {}), "");
  EXPECT_NE(with([](Invitation& i) {
              i.hosts.clear();
            }),
            "");
  EXPECT_NE(with([](Invitation& i) {
              i.hosts = {"a b"};
            }),
            "");
  EXPECT_NE(with([](Invitation& i) {
              i.hosts = {"a:0"};
            }),
            "");
  EXPECT_NE(with([](Invitation& i) {
              i.hosts = {"a:65536"};
            }),
            "");
  EXPECT_NE(with([](Invitation& i) {
              i.hosts.assign(Invitation::kMostHosts + 1, "a");
            }),
            "");
  EXPECT_NE(with([](Invitation& i) {
              i.others.assign(Invitation::kMostOthers + 1, "a");
            }),
            "");
  EXPECT_NE(with([](Invitation& i) {
              i.session.clear();
            }),
            "");
  EXPECT_NE(with([](Invitation& i) {
              i.session.assign(129, 'a');
            }),
            "");
  EXPECT_NE(with([](Invitation& i) {
              i.domain = 231;
            }),
            "");
  EXPECT_NE(with([](Invitation& i) {
              i.enrolment.port = 0;
            }),
            "");
  EXPECT_NE(with([](Invitation& i) {
              i.enrolment.until = 0;
            }),
            "");
}

TEST(Invitation, TimeOnAnotherDayIncludesTheDate) {
  constexpr std::time_t kNoon = 1'767'355'200;  // 2026-01-02 12:00 UTC
  EXPECT_EQ(TimeForAPerson(kNoon, kNoon - 60), "12:00 UTC");
  EXPECT_THAT(TimeForAPerson(kNoon, kNoon - 86'400), StartsWith("2026-01-02 12:00"));
}

TEST(Invitation, PublicFormHasNoSecretAndServesNoEnrolment) {
  Invitation whole = PlainOne();
  whole.secured = true;
  whole.enrolment.port = 7400;
  whole.enrolment.until = 1'900'000'000;
  whole.enrolment.secret.fill(0xA5);
  whole.enrolment.certificate.fill(0x5A);
  const std::string line = LineOf(whole);
  const std::string open = PublicLineOf(whole);
  // 22 letters of Base64 are the secret's 128 bits
  const std::string secret = line.substr(line.find('#') + 1, 22);
  EXPECT_EQ(open.find(secret), std::string::npos);
  const Result<Invitation> refused = ReadInvitation(open);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().what.find("public form"), std::string::npos);
  const Result<Invitation> read = ReadInvitation(open, LineForm::kWholeOrPublic);
  ASSERT_TRUE(read) << read.error().what;
  EXPECT_FALSE(read->enrolment.has_secret);
  EXPECT_EQ(read->enrolment.certificate, whole.enrolment.certificate);
  EXPECT_EQ(read->session, whole.session);
  EXPECT_TRUE(ReadInvitation(line, LineForm::kWholeOrPublic)->enrolment.has_secret);
}

// CHECK has no secret: anybody can make a line that is whole
TEST(Invitation, NamesWithControlCharactersAreRefused) {
  for (const char* name : {"a\x1b]0;PWNED\x07", "a\nb", "a\u202eb", "a\xff", "\x7f"}) {
    Invitation line = PlainOne();
    line.session = name;
    const Result<Invitation> session = ReadInvitation(LineOf(line));
    ASSERT_FALSE(session);
    EXPECT_NE(session.error().what.find("control characters"), std::string::npos);
    line = PlainOne();
    line.scene = {.digest = 1, .bodies = 2, .file = name};
    EXPECT_FALSE(ReadInvitation(LineOf(line)));
  }
}

}  // namespace
}  // namespace tandem
