#include "app/invite/enrolment.h"

#include <array>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include "tests/app/invite/inviter.h"

namespace tandem {
namespace {

using testing::Caller;
using ::testing::HasSubstr;
using testing::Inviter;
using testing::kRequest;
using testing::WhyNot;
using End = EnrolmentListener::End;
using Kind = EnrolmentFault::Kind;

TEST(Enrolment, InvitationHolderGetsASignedCertificate) {
  Inviter inviter;
  const EnrolmentOutcome outcome = Enrol(inviter.invitation, kRequest);
  ASSERT_FALSE(outcome.fault) << outcome.fault->what;
  EXPECT_EQ(outcome.answer.name, "ben");
  EXPECT_EQ(outcome.answer.session, "gear");
  EXPECT_EQ(outcome.answer.role, Role::kActive);
  EXPECT_EQ(outcome.answer.files, (MemberFiles{{"identity.pem", "signed: a request"}}));
  EXPECT_EQ(inviter.Wait(), End::kUsed);
  EXPECT_EQ(inviter.reported(), "");
}

TEST(Enrolment, InvitationIsUsedOnce) {
  Inviter inviter;
  // the first stays on the line after its answer, so that the port stays open
  const Caller first(inviter.invitation.enrolment.port);
  TlsEndpoint tls = first.Greet();
  ASSERT_TRUE(tls.open());
  EnrolmentRequest request;
  request.proof = ProofOf(inviter.invitation, tls.Binding());
  request.certificate_request = kRequest;
  tls.Say(TextOf(request));
  first.Send(tls.TakeToSend());
  std::string received;
  while (received.find('\n') == std::string::npos) {
    const auto bytes = first.Receive(2000);
    ASSERT_TRUE(bytes && !bytes->empty());
    tls.Receive(*bytes);
    received += tls.Hear();
  }
  EXPECT_THAT(received, HasSubstr("signed: a request"));

  EXPECT_THAT(WhyNot(inviter.invitation, Kind::kRefused),
              HasSubstr("has used the invitation already"));
  EXPECT_EQ(inviter.Wait(), End::kUsed);
  EXPECT_EQ(inviter.times_signed(), 1);
  EXPECT_THAT(inviter.reported(), HasSubstr("a second time"));
  // and afterwards there is nobody to ask
  EXPECT_THAT(WhyNot(inviter.invitation, Kind::kUnreachable), HasSubstr("was used or withdrawn"));
}

// each of these lines has a good CHECK: somebody has altered it on purpose
TEST(Enrolment, AlteredInvitationIsRefusedWithoutBeingUsed) {
  Inviter inviter;
  const auto altered = [&](const auto& change) {
    Invitation invitation = inviter.invitation;
    change(invitation);
    EXPECT_TRUE(ReadInvitation(LineOf(invitation)));
    return invitation;
  };
  for (const Invitation& invitation : {altered([](Invitation& i) {
                                         i.session = "wing";
                                       }),
                                       altered([](Invitation& i) {
                                         i.role = Role::kViewer;
                                       }),
                                       altered([](Invitation& i) {
                                         i.domain = 43;
                                       }),
                                       altered([](Invitation& i) {
                                         i.scene.digest = Sha256{7};
                                       }),
                                       altered([](Invitation& i) {
                                         i.others = {"evil.example.org"};
                                       }),
                                       altered([](Invitation& i) {
                                         i.enrolment.until += 3600;
                                       }),
                                       altered([](Invitation& i) {
                                         i.enrolment.secret[3] ^= 1U;
                                       })}) {
    EXPECT_THAT(WhyNot(invitation, Kind::kRefused), HasSubstr("is not the invitation"));
  }
  EXPECT_EQ(inviter.times_signed(), 0);
  EXPECT_EQ(WhyNot(inviter.invitation), "");
  EXPECT_EQ(inviter.Wait(), End::kUsed);
  EXPECT_THAT(inviter.reported(), HasSubstr("without the secret"));
}

TEST(Enrolment, InvitationExpires) {
  Inviter inviter("gear", 1);
  const Caller idle(inviter.invitation.enrolment.port);
  EXPECT_EQ(inviter.Wait(), End::kExpired);
  EXPECT_THAT(WhyNot(inviter.invitation, Kind::kUnreachable),
              HasSubstr("the invitation expired at"));
}

TEST(Enrolment, InviterOfAnotherSessionIsDetected) {
  Inviter gear("gear");
  Inviter wing("wing");
  Invitation astray = gear.invitation;
  astray.enrolment.port = wing.invitation.enrolment.port;
  EXPECT_THAT(WhyNot(astray, Kind::kStranger), HasSubstr("another invitation is open there"));
  EXPECT_EQ(wing.Stop(), End::kStopped);
  EXPECT_EQ(wing.reported(), "");  // nothing was said to it
}

// A program at the port without the certificate's key hears nothing of the secret.
TEST(Enrolment, StrangersGetNoInformation) {
  Inviter gear;
  const Result<TlsIdentity> own = TlsIdentity::Make();
  ASSERT_TRUE(own);
  const int listener = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in at{};
  at.sin_family = AF_INET;
  at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  ASSERT_EQ(bind(listener, reinterpret_cast<sockaddr*>(&at), sizeof at), 0);
  ASSERT_EQ(listen(listener, 1), 0);
  socklen_t size = sizeof at;
  getsockname(listener, reinterpret_cast<sockaddr*>(&at), &size);
  std::string received;
  bool open = false;
  std::thread stranger([&] {
    const int socket = accept(listener, nullptr, nullptr);
    TlsEndpoint tls = TlsEndpoint::Server(*own);
    std::array<char, 16384> buffer;
    for (ssize_t got = 1; got > 0;) {
      got = recv(socket, buffer.data(), buffer.size(), 0);
      if (got > 0) tls.Receive({buffer.data(), static_cast<std::size_t>(got)});
      received += tls.Hear();
      open = open || tls.open();
      const std::string bytes = tls.TakeToSend();
      static_cast<void>(send(socket, bytes.data(), bytes.size(), MSG_NOSIGNAL));
    }
    close(socket);
  });
  Invitation astray = gear.invitation;
  astray.enrolment.port = ntohs(at.sin_port);
  EXPECT_NE(WhyNot(astray, Kind::kStranger), "");
  stranger.join();
  close(listener);
  EXPECT_TRUE(open);
  EXPECT_EQ(received, "");
}

TEST(Enrolment, WrongSecretsCloseTheInvitation) {
  Inviter inviter;
  Invitation guess = inviter.invitation;
  for (int i = 0; i < EnrolmentListener::kMostWrong; ++i) {
    guess.enrolment.secret[0] =
        static_cast<std::uint8_t>(inviter.invitation.enrolment.secret[0] + 1 + i);
    EXPECT_NE(WhyNot(guess), "");
  }
  EXPECT_EQ(inviter.Wait(), End::kGuessed);
  EXPECT_NE(WhyNot(inviter.invitation), "");
  EXPECT_EQ(inviter.times_signed(), 0);
}

TEST(Enrolment, ProofsAreBoundToOneConnection) {
  Inviter inviter;
  const Caller first(inviter.invitation.enrolment.port);
  const Caller second(inviter.invitation.enrolment.port);
  const TlsEndpoint one = first.Greet();
  const TlsEndpoint other = second.Greet();
  EXPECT_NE(ProofOf(inviter.invitation, one.Binding()),
            ProofOf(inviter.invitation, other.Binding()));
}

TEST(Enrolment, SilentOrInvalidCallersDoNotBlockOthers) {
  Inviter inviter;
  std::vector<std::unique_ptr<Caller>> callers;
  for (std::size_t i = 0; i < EnrolmentListener::kMostConnections + 6; ++i) {
    callers.push_back(std::make_unique<Caller>(inviter.invitation.enrolment.port));
    if (i == 1 || i == 3) callers.back()->Send("GET / HTTP/1.1\r\n\r\n");
    if (i == 2 || i == 4) callers.back()->Send(std::string(100'000, '\x16'));
  }
  EXPECT_EQ(WhyNot(inviter.invitation), "");
  EXPECT_EQ(inviter.Wait(), End::kUsed);
}

TEST(Enrolment, TextThatIsNoRequestIsNoWrongProof) {
  Inviter inviter;
  for (int i = 0; i < 3 * EnrolmentListener::kMostWrong; ++i) {
    const Caller caller(inviter.invitation.enrolment.port);
    TlsEndpoint tls = caller.Greet();
    ASSERT_TRUE(tls.open());
    tls.Say("GET / HTTP/1.1\r\n\r\n");
    caller.Send(tls.TakeToSend());
    static_cast<void>(caller.Receive(2000));
  }
  EXPECT_EQ(WhyNot(inviter.invitation), "");
  EXPECT_EQ(inviter.Wait(), End::kUsed);
  EXPECT_EQ(inviter.times_signed(), 1);
}

TEST(Enrolment, LongOrMalformedRequestIsRefused) {
  Inviter inviter;
  for (const std::string& text : {std::string("{}\n"), std::string("[[[[[[\n"), std::string("\n"),
                                  std::string("{\"tandem_enrolment\":2}\n"),
                                  std::string(20'000, 'a'), std::string(7000, '[') + "\n"}) {
    const Caller caller(inviter.invitation.enrolment.port);
    TlsEndpoint tls = caller.Greet();
    ASSERT_TRUE(tls.open());
    tls.Say(text);
    caller.Send(tls.TakeToSend());
    std::string received;
    for (auto bytes = caller.Receive(2000); bytes && !bytes->empty(); bytes = caller.Receive(200)) {
      tls.Receive(*bytes);
      received += tls.Hear();
    }
    EXPECT_EQ(received.find("signed"), std::string::npos);
  }
  EXPECT_EQ(inviter.times_signed(), 0);
  EXPECT_EQ(WhyNot(inviter.invitation), "");
}

// The program openssl, which knows nothing of ours, judges the listener.
TEST(Enrolment, ListenerAcceptsOnlyTls13) {
  Inviter inviter;
  const std::string at = "127.0.0.1:" + std::to_string(inviter.invitation.enrolment.port);
  const auto greets = [&at](const std::string& version) {
    const std::string command = "timeout 5 openssl s_client -connect " + at + " -" + version +
                                " </dev/null >/dev/null 2>&1";
    return std::system(command.c_str()) == 0;
  };
  EXPECT_TRUE(greets("tls1_3"));
  EXPECT_FALSE(greets("tls1_2"));
}

TEST(Enrolment, ProbeConfirmsTheInviterWithoutUsingTheInvitation) {
  Inviter gear;
  Inviter wing("wing");
  const InviterFacts facts = ProbeInviter(gear.invitation);
  EXPECT_TRUE(facts.is_the_inviter) << facts.what;
  EXPECT_EQ(facts.host, "127.0.0.1");
  Invitation astray = gear.invitation;
  astray.enrolment.port = wing.invitation.enrolment.port;
  EXPECT_FALSE(ProbeInviter(astray).is_the_inviter);
  EXPECT_EQ(WhyNot(gear.invitation), "");
}

TEST(Enrolment, InvalidAnswerIsRefused) {
  EnrolmentAnswer answer;
  answer.session = "gear";
  answer.name = "ben";
  answer.files = {{"identity.pem", "x"}};
  const std::string good = TextOf(answer);
  EXPECT_TRUE(ReadEnrolmentAnswer(good));
  for (std::string text :
       {std::string("{}"), std::string("null"), std::string("[1]"), good.substr(0, good.size() / 2),
        std::string(EnrolmentAnswer::kLongest + 1, ' ')}) {
    EXPECT_FALSE(ReadEnrolmentAnswer(text)) << text.substr(0, 80);
  }
  EnrolmentAnswer refusal;
  refusal.refused = "no\n\x1b[31mred";
  const Result<EnrolmentAnswer> read = ReadEnrolmentAnswer(TextOf(refusal));
  ASSERT_TRUE(read);
  EXPECT_EQ(read->refused.find_first_of("\n\x1b"), std::string::npos);
}

}  // namespace
}  // namespace tandem
