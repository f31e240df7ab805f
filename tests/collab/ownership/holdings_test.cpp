#include "collab/ownership/holdings.h"

#include <gtest/gtest.h>

#include "tests/collab/ownership/company.h"

namespace tandem {
namespace {

using testing::Company;
using testing::kOwn;
using testing::kShared;
using Kind = MembershipChange::Kind;

TEST(Holdings, LowestPeerOwnsUntouchedBodies) {
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

TEST(Holdings, GrantOfAWithdrawnRequestIsNotHeld) {
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

TEST(Holdings, SupersededRequestIsNotGrantedIntoTheHand) {
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

TEST(Holdings, StoppedHandOwnsAGivenBodyWithoutHoldingIt) {
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

TEST(Holdings, RequestForAHeldBodyIsGrantedAfterRelease) {
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

TEST(Holdings, HolderIsToldOfARequestOnce) {
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

TEST(Holdings, HolderIsToldOfEachRequesterOnce) {
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

TEST(Holdings, SimultaneousRequestsAreGrantedToOnePeer) {
  Company company({3, 5, 9}, 40);
  company.Run(10);
  company[5].Ask(kOwn);
  company[9].Ask(kOwn);
  company.Run(6000);
  EXPECT_EQ(company.Holders(0).size(), 1U);
  EXPECT_NE(company.Authority(0), 0U);
  EXPECT_EQ(company.doubles(), 0);
}

TEST(Holdings, HandoverPutsTheBodyIntoTheOtherHand) {
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

TEST(Holdings, LeavingPeerPassesEverythingToTheLowestPeer) {
  Company company({3, 5, 9}, 20);
  company[5].Ask(kOwn);
  company.Run(100);
  company.Leave(5);
  company.Run(2);
  EXPECT_EQ(company.Authority(0), 3U);
  EXPECT_TRUE(company[3].Parks(0));
  EXPECT_EQ(company.doubles(), 0);
}

TEST(Holdings, LowestPeerTakesOverWithin300MillisecondsOfACrash) {
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

TEST(Holdings, ResumedHolderGetsItsBodyBackWithOneMessage) {
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

TEST(Holdings, SharedBodyIsHeldJointlyAndParkedByTheLastHolder) {
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

TEST(Holdings, LateJoinerLearnsTheOwners) {
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
TEST(Holdings, ResumedPeerListensBeforeItClaims) {
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
TEST(Holdings, LastHolderLeavesASharedBodyToItsOwner) {
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

// Its force parameters are not the others'. It answers for a body that it is given, but does not
// hold it.
TEST(Holdings, PeerWithOtherParametersCannotTakeSharedBodies) {
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

}  // namespace
}  // namespace tandem
