#include "collab/holdings.h"

#include <gtest/gtest.h>

#include "tests/collab/company.h"

namespace tandem {
namespace {

using testing::Company;
using testing::kOwn;
using testing::kShared;
using testing::TwoBodies;
using Kind = MembershipChange::Kind;

TEST(Holdings, TheLowestPeerAnswersForWhatNobodyTouched) {
  Company company({3, 5, 9});
  company.Run(10);
  EXPECT_EQ(company.Authority(0), 3U);
  EXPECT_EQ(company[5].epoch(0), 0U);
  EXPECT_FALSE(company[3].Parks(0)) << "it stands where all know";
}

TEST(Holdings, AGrabIsGrantedWithinARoundTrip) {
  Company company({3, 5, 9}, 100);
  company.Run(10);
  company[5].Ask(kOwn);
  company.Run(199);
  EXPECT_EQ(company[5].held(), -1);
  company.Run(3);
  EXPECT_EQ(company[5].held(), 0);
  company.Run(200);
  EXPECT_EQ(company.Authority(0), 5U);
  EXPECT_EQ(company[9].epoch(0), 1U);
  EXPECT_TRUE(company[9].HeldBy(0, 5));
  EXPECT_EQ(company.doubles(), 0);
}

TEST(Holdings, WhatIsNotWantedAnyMoreDoesNotComeIntoTheHandWhenItIsGranted) {
  Company company({3, 5}, 100);
  company.Run(10);
  company[5].Ask(kOwn);
  company.Run(50);
  company[5].Release();
  company.Run(400);
  EXPECT_EQ(company[5].held(), -1);
  EXPECT_EQ(company.Authority(0), 5U) << "it was granted all the same";
  company[5].Ask(kOwn);
  company.Run(50);
  EXPECT_EQ(company[5].held(), 0) << "and may be taken anew";
}

TEST(Holdings, WishesThatOthersFollowedComeIntoTheHandNoMore) {
  Company company({3, 5}, 100);
  company.Run(10);
  company[5].Ask(kOwn);
  company.Run(20);
  company[5].Ask(kShared);
  company.Run(20);
  company[5].Release();
  company.Run(600);
  EXPECT_EQ(company[5].held(), -1);
  EXPECT_EQ(company.Authority(0), 5U) << "it was granted all the same";
}

TEST(Holdings, AStoppedHandAnswersForWhatItIsGivenAndDoesNotHoldIt) {
  Company company({3, 5}, 10);
  company[5].Ask(kOwn);
  company.Run(50);
  ASSERT_EQ(company[5].held(), 0);
  company[3].Stop();
  company[5].Give(3);
  company.Run(50);
  EXPECT_EQ(company[3].held(), -1);
  EXPECT_TRUE(company[3].Parks(0));
  company[3].Resume();
  company[5].Ask(kOwn);
  company.Run(50);
  company[5].Give(3);
  company.Run(50);
  EXPECT_EQ(company[3].held(), 0);
}

TEST(Holdings, WhatAnotherHoldsIsRefusedAndComesAfterTheRelease) {
  Company company({3, 5}, 10);
  company[5].Ask(kOwn);
  company.Run(50);
  ASSERT_EQ(company[5].held(), 0);
  company[3].Ask(kOwn);
  company.Run(50);
  EXPECT_EQ(company[3].held(), -1);
  EXPECT_EQ(company[3].wanted(), -1);
  HoldingNews news;
  ASSERT_TRUE(company[3].TakeNews(news));
  EXPECT_EQ(news.kind, HoldingNews::Kind::kAsking);
  ASSERT_TRUE(company[3].TakeNews(news));
  EXPECT_EQ(news.kind, HoldingNews::Kind::kRefused);
  EXPECT_EQ(news.peer, 5U);

  company[5].SeeAt(0, {Quat::Identity(), Vec3(1, 2, 3)});
  company[5].Release();
  company.Run(50);
  EXPECT_TRUE(company[5].Parks(0));
  ASSERT_NE(company[3].ParkedAt(0), nullptr);
  EXPECT_EQ(company[3].ParkedAt(0)->p, Vec3(1, 2, 3));
  company[3].Ask(kOwn);
  company.Run(50);
  EXPECT_EQ(company[3].held(), 0);
  EXPECT_EQ(company.Authority(0), 3U);
  EXPECT_EQ(company.doubles(), 0);
}

TEST(Holdings, WhoHoldsABodyIsToldOnceWhoAsksForIt) {
  Company company({3, 5}, 10);
  company[5].Ask(kOwn);
  company.Run(50);
  ASSERT_EQ(company[5].held(), 0);
  HoldingNews news;
  while (company[5].TakeNews(news)) {
  }
  for (int i = 0; i < 3; ++i) {
    company[3].Ask(kOwn);
    company.Run(50);
  }
  ASSERT_TRUE(company[5].TakeNews(news));
  EXPECT_EQ(news.kind, HoldingNews::Kind::kAsked);
  EXPECT_EQ(news.object, kOwn);
  EXPECT_EQ(news.peer, 3U);
  EXPECT_FALSE(company[5].TakeNews(news)) << "asked thrice in 150 ms";
  company.Run(2000);
  company[3].Ask(kOwn);
  company.Run(50);
  ASSERT_TRUE(company[5].TakeNews(news)) << "asked again later";
  EXPECT_EQ(news.kind, HoldingNews::Kind::kAsked);
}

TEST(Holdings, WhoHoldsABodyIsToldOnceOfEachWhoAsksForIt) {
  Company company({3, 5, 9}, 10);
  company[5].Ask(kOwn);
  company.Run(50);
  ASSERT_EQ(company[5].held(), 0);
  HoldingNews news;
  while (company[5].TakeNews(news)) {
  }
  for (int i = 0; i < 4; ++i) {
    company[i % 2 == 0 ? 3 : 9].Ask(kOwn);
    company.Run(50);
  }
  for (const PeerId asker : {3U, 9U}) {
    ASSERT_TRUE(company[5].TakeNews(news));
    EXPECT_EQ(news.kind, HoldingNews::Kind::kAsked);
    EXPECT_EQ(news.peer, asker);
  }
  EXPECT_FALSE(company[5].TakeNews(news)) << "each asked twice in 200 ms";
  company.Run(2000);
  company[9].Ask(kOwn);
  company.Run(50);
  ASSERT_TRUE(company[5].TakeNews(news)) << "asked again later";
  EXPECT_EQ(news.peer, 9U);
}

TEST(Holdings, OfTwoWhoAskAtOnceOneGetsIt) {
  Company company({3, 5, 9}, 40);
  company.Run(10);
  company[5].Ask(kOwn);
  company[9].Ask(kOwn);
  company.Run(6000);
  EXPECT_EQ(company.Holders(0).size(), 1U);
  EXPECT_NE(company.Authority(0), 0U);
  EXPECT_EQ(company.doubles(), 0);
}

TEST(Holdings, AHandOverPutsItIntoTheOthersHand) {
  Company company({3, 5, 9}, 20);
  company[9].Ask(kOwn);
  company.Run(100);
  ASSERT_EQ(company[9].held(), 0);
  company[9].Give(5);
  company.Run(100);
  EXPECT_EQ(company.Holders(0), std::vector<PeerId>{5});
  EXPECT_EQ(company.Authority(0), 5U);
  EXPECT_EQ(company.doubles(), 0);
}

TEST(Holdings, WhoLeavesHandsAllOnToTheLowest) {
  Company company({3, 5, 9}, 20);
  company[5].Ask(kOwn);
  company.Run(100);
  company.Leave(5);
  company.Run(2);
  EXPECT_EQ(company.Authority(0), 3U);
  EXPECT_TRUE(company[3].Parks(0));
  EXPECT_EQ(company.doubles(), 0);
}

TEST(Holdings, AfterACrashTheLowestAnswersWithin300Milliseconds) {
  Company company({3, 5, 9}, 20);
  company[3].Ask(kOwn);
  company.Run(100);
  ASSERT_EQ(company[3].held(), 0);
  company.Kill(3);
  company.Run(299);
  EXPECT_EQ(company.Authority(0), 3U);
  company.Run(30);
  EXPECT_EQ(company.Authority(0), 5U);
  EXPECT_EQ(company[9].epoch(0), 2U);
  company[9].Ask(kOwn);
  company.Run(100);
  EXPECT_EQ(company.Holders(0), std::vector<PeerId>{9});
  EXPECT_EQ(company.doubles(), 0);
}

TEST(Holdings, AStoppedHolderGetsItBackAndNobodySaysItTwice) {
  Company company({3, 5, 9}, 5);
  company[9].Ask(kOwn);
  company.Run(100);
  ASSERT_EQ(company[9].held(), 0);
  company.Stop(9, true);
  company.Run(600);  // the lease
  company.Sever(9);
  company.Run(2400);
  EXPECT_EQ(company[3].authority(0), 3U);
  EXPECT_TRUE(company[3].Parks(0));
  company.Stop(9, false);
  company.Run(100);
  company.Rejoin(9);
  company.Run(600);
  EXPECT_EQ(company.Holders(0), std::vector<PeerId>{9});
  EXPECT_EQ(company.Authority(0), 9U);
  EXPECT_EQ(company.doubles(), 0);
}

TEST(Holdings, ASharedBodyIsTakenBesideItsHoldersAndParkedByTheLast) {
  Company company({3, 5, 9}, 20);
  company[5].Ask(kShared);
  company.Run(100);
  EXPECT_EQ(company.Authority(1), 5U);
  company[9].Ask(kShared);
  company[3].Ask(kShared);
  company.Run(100);
  EXPECT_EQ(company.Holders(1), (std::vector<PeerId>{3, 5, 9}));
  EXPECT_EQ(company.Authority(1), 3U) << "the lowest holder";
  company[3].Release();
  company.Run(100);
  EXPECT_EQ(company.Authority(1), 5U);
  company[3].Ask(kShared);
  company[5].Release();
  company.Run(100);
  EXPECT_EQ(company.Holders(1), (std::vector<PeerId>{3, 9}));
  EXPECT_EQ(company.Authority(1), 9U) << "the lowest holder that it knew of";
  EXPECT_FALSE(company[9].Parks(1));
  company.Kill(9);
  company.Run(400);
  EXPECT_EQ(company.Authority(1), 3U) << "the holder that is left";
  company[3].Release();
  company.Run(100);
  EXPECT_EQ(company.Authority(1), 3U);
  EXPECT_TRUE(company[3].Parks(1));
}

TEST(Holdings, ALateJoinerHearsWhoAnswers) {
  Company company({5, 9}, 20);
  company[9].Ask(kOwn);
  company.Run(100);
  company.Add(3);
  company.Run(100);
  EXPECT_EQ(company.Authority(0), 9U);
  company[3].Ask(kOwn);
  company.Run(100);
  EXPECT_EQ(company[3].held(), -1);
  EXPECT_EQ(company.doubles(), 0);
}

// The others have decided without it what it missed. It knows that it was stopped before it judges,
// asks nobody to give way at once, and answers no question from before.
TEST(Holdings, AStoppedPeerListensBeforeItClaimsAnythingAnew) {
  Company company({3, 5, 9});
  company[3].Ask(kOwn);
  company.Run(6000);
  ASSERT_EQ(company[3].held(), 0);
  company.Stop(3, true);
  for (const PeerId peer : {5U, 9U}) company[peer].OnMembership({.kind = Kind::kLost, .peer = 3});
  company.Run(1000);
  ASSERT_EQ(company[5].authority(0), 5U);
  company.Stop(3, false);
  MembershipChange claims{.kind = Kind::kClaims, .peer = 5, .claim_count = 1};
  claims.claims[0] = {kOwn, company[5].epoch(0), false};
  company[3].Begin(8'000'000'000);
  company[3].OnMembership(claims);
  company[3].Settle();
  EXPECT_LT(company[3].epoch(0), 3U) << "not claimed anew";
  EXPECT_TRUE(company[3].listening());
}

// The peer that answers for the body is here and holds something else. It goes on to answer.
TEST(Holdings, TheLastHandOnASharedBodyLeavesItToItsAuthority) {
  Company company({3, 5, 9}, 10);
  company[9].Ask(kShared);
  company.Run(100);
  company[5].Ask(kShared);
  company.Run(100);
  company[5].Ask(kOwn);  // lets go of the shared one, which 9 has then
  company.Run(100);
  company[9].Give(5);
  company[3].Ask(kShared);
  company.Run(100);
  const PeerId authority = company.Authority(1);
  const std::uint32_t epoch = company[authority].epoch(1);
  ASSERT_NE(authority, 0U);
  for (const PeerId peer : {3U, 5U, 9U}) {
    if (peer != authority) company[peer].Release();
  }
  company.Run(100);
  EXPECT_EQ(company.Authority(1), authority);
  EXPECT_EQ(company[authority].epoch(1), epoch);
}

TEST(Holdings, AGrantThatIsLostIsGivenAgain) {
  Company company({3, 5}, 0);
  company.Run(5);
  // 3 has granted it to 5, which never heard of it
  Event ask;
  ask.peer = 5;
  ask.object = kOwn;
  ask.to = 3;
  company[3].OnEvent(ask);
  std::array<Event, 8> events;
  std::size_t count = 0;
  company[3].Tick(6'000'000, events, count);
  ASSERT_EQ(count, 1U);
  EXPECT_EQ(events[0].kind, EventKind::kGrant);
  company[5].Ask(kOwn);
  company.Run(20);
  EXPECT_EQ(company.Holders(0), std::vector<PeerId>{5});
  EXPECT_EQ(company.Authority(0), 5U);
}

// Its force parameters are not the others'. It answers for a body that it is given, but does not
// hold it.
TEST(Holdings, WhoInsistsOnOtherParametersTakesOwnBodiesAndNoSharedOnes) {
  Company company({1}, 3);
  company.Add(2, true);
  company[1].Ask(kShared);
  company.Run(50);
  ASSERT_EQ(company.Holders(1), std::vector<PeerId>{1});
  company[2].Ask(kShared);
  company.Run(50);
  EXPECT_EQ(company[2].wanted(), -1);
  EXPECT_EQ(company.Holders(1), std::vector<PeerId>{1});
  company[1].Give(2);
  company.Run(50);
  EXPECT_TRUE(company.Holders(1).empty());
  EXPECT_EQ(company.Authority(1), 2U);
  EXPECT_TRUE(company[2].Parks(1));
  company[2].Ask(kOwn);
  company.Run(50);
  EXPECT_EQ(company.Holders(0), std::vector<PeerId>{2});
}

/// Runs frames of 1 ms of one peer by itself, and returns the events of kind `kind` that it says.
std::vector<Event> Said(Holdings& holdings, std::int64_t& now_ns, int frames, EventKind kind) {
  std::vector<Event> said;
  for (int i = 0; i < frames; ++i) {
    std::array<Event, 8> out;
    std::size_t count = 0;
    holdings.Tick(now_ns += 1'000'000, out, count);
    for (std::size_t e = 0; e < count; ++e) {
      if (out[e].kind == kind) said.push_back(out[e]);
    }
  }
  return said;
}

// The peer is granted a body and killed before it can say so. It counts as gone when it is lost,
// and the lowest goes first.
TEST(Holdings, WhoNeverAnsweredIsGoneOnlyFromWhenItIsLost) {
  const WorldModel model = TwoBodies();
  Holdings nine(9, model);
  std::int64_t now_ns = 1'000'000'000;
  for (const PeerId peer : {3, 5, 7}) nine.OnMembership({.kind = Kind::kJoined, .peer = peer});
  Said(nine, now_ns, 10, EventKind::kGrant);
  nine.OnEvent(
      {.peer = 3, .kind = EventKind::kGrant, .object = kOwn, .epoch = 2, .to = 7, .X_WB = {}});
  Said(nine, now_ns, 3000, EventKind::kGrant);
  ASSERT_EQ(nine.authority(0), 7U);
  nine.OnMembership({.kind = Kind::kLost, .peer = 7});
  Said(nine, now_ns, 5000, EventKind::kGrant);
  EXPECT_EQ(nine.authority(0), 7U) << "3 and 5 are before us, two and a half seconds each";
  Said(nine, now_ns, 400, EventKind::kGrant);
  EXPECT_EQ(nine.authority(0), 9U);
}

TEST(Holdings, AHandOverThatIsLostIsSaidAgain) {
  const WorldModel model = TwoBodies();
  Holdings three(3, model);
  std::int64_t now_ns = 1'000'000'000;
  three.OnMembership({.kind = Kind::kJoined, .peer = 9});
  three.Ask(kOwn);
  Said(three, now_ns, 10, EventKind::kGrant);
  ASSERT_EQ(three.held(), 0);
  three.Give(9);
  const std::vector<Event> said = Said(three, now_ns, 600, EventKind::kGrant);
  ASSERT_EQ(said.size(), 3U);  // at once, and every 250 ms
  for (const Event& event : said) {
    EXPECT_EQ(event.to, 9U);
    EXPECT_EQ(event.epoch, said[0].epoch);
  }
  MembershipChange answer{.kind = Kind::kClaims, .peer = 9};
  answer.claim_count = 1;
  answer.claims[0] = {.object = kOwn, .epoch = said[0].epoch, .held = true};
  three.OnMembership(answer);
  EXPECT_TRUE(Said(three, now_ns, 1000, EventKind::kGrant).empty());
}

// Both ends of a grant crash, and the lowest peer left was cut off when it was made.
TEST(Holdings, AGrantThatTheNextInLineMissedIsPassedOnOnce) {
  const WorldModel model = TwoBodies();
  Holdings three(3, model);
  Holdings nine(9, model);
  std::int64_t now_ns = 1'000'000'000;
  const auto both = [&](Kind kind, PeerId peer) {
    if (peer != 3) three.OnMembership({.kind = kind, .peer = peer});
    if (peer != 9) nine.OnMembership({.kind = kind, .peer = peer});
  };
  for (const PeerId peer : {2, 3, 7, 9}) both(Kind::kJoined, peer);
  Said(nine, now_ns, 10, EventKind::kGrant);
  nine.OnEvent(
      {.peer = 2, .kind = EventKind::kGrant, .object = kOwn, .epoch = 1, .to = 7, .X_WB = {}});
  EXPECT_TRUE(Said(nine, now_ns, 100, EventKind::kGrant).empty());
  for (const PeerId peer : {2, 7}) both(Kind::kLost, peer);
  const std::vector<Event> said = Said(nine, now_ns, 100, EventKind::kGrant);
  ASSERT_EQ(said.size(), 1U);
  three.OnEvent(said[0]);
  EXPECT_TRUE(Said(three, now_ns, 290, EventKind::kGrant).empty()) << "nobody is before it in line";
  EXPECT_EQ(three.authority(0), 7U);
  Said(three, now_ns, 20, EventKind::kGrant);
  EXPECT_EQ(three.authority(0), 3U);
  EXPECT_EQ(three.epoch(0), 2U);
  EXPECT_TRUE(Said(nine, now_ns, 800, EventKind::kGrant).empty());
}

// It crashes with the body in hand and is back, its hand empty, before anybody took it for lost.
TEST(Holdings, AHandOverThatArrivedIsNotSaidAgainToOneWhoStartedAnew) {
  const WorldModel model = TwoBodies();
  Holdings three(3, model);
  std::int64_t now_ns = 1'000'000'000;
  three.OnMembership({.kind = Kind::kJoined, .peer = 9});
  three.Ask(kOwn);
  Said(three, now_ns, 10, EventKind::kGrant);
  three.Give(9);
  ASSERT_EQ(Said(three, now_ns, 10, EventKind::kGrant).size(), 1U);
  MembershipChange answer{.kind = Kind::kClaims, .peer = 9};
  answer.claim_count = 1;
  answer.claims[0] = {.object = kOwn, .epoch = three.epoch(0), .held = true};
  three.OnMembership(answer);
  Said(three, now_ns, 10, EventKind::kGrant);
  three.OnMembership({.kind = Kind::kClaims, .peer = 9});
  EXPECT_TRUE(Said(three, now_ns, 4000, EventKind::kGrant).empty());
  Said(three, now_ns, 2000, EventKind::kGrant);
  EXPECT_EQ(three.authority(0), 3U) << "nobody answered for it for five seconds";
}

// The peer came as the authority crashed, and would not take over: nobody waits for it.
TEST(Holdings, WhoCameTooLateToHearOfAClaimIsNotInLineForIt) {
  const WorldModel model = TwoBodies();
  Holdings nine(9, model);
  std::int64_t now_ns = 1'000'000'000;
  Said(nine, now_ns, 1, EventKind::kGrant);
  MembershipChange seven{.kind = Kind::kJoined, .peer = 7, .claim_count = 1};
  seven.claims[0] = {kOwn, 2, true};
  nine.OnMembership(seven);
  Said(nine, now_ns, 5500, EventKind::kGrant);
  ASSERT_EQ(nine.authority(0), 7U);
  nine.OnMembership({.kind = Kind::kJoined, .peer = 3});
  Said(nine, now_ns, 100, EventKind::kGrant);
  nine.OnMembership({.kind = Kind::kLost, .peer = 7});
  Said(nine, now_ns, 310, EventKind::kGrant);
  EXPECT_EQ(nine.authority(0), 9U);
}

}  // namespace
}  // namespace tandem
