#include "collab/session/early_inbox.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "collab/session/viewer.h"

namespace tandem {
namespace {

PeerInfo InfoOf(PeerId peer) {
  PeerInfo info;
  info.peer = peer;
  return info;
}

SceneManifest OfferOf(PeerId by, double voxel_size) {
  SceneManifest manifest;
  manifest.offered_by = by;
  manifest.voxel_size = voxel_size;
  return manifest;
}

TEST(EarlyInbox, KnowsTheSessionsSceneBeforeLoading) {
  EarlyInbox early;
  EXPECT_FALSE(early.SessionScene());
  early.OnScene(OfferOf(5, 0.002));
  early.OnScene(OfferOf(4, 0.001));
  ASSERT_TRUE(early.SessionScene());
  EXPECT_EQ(early.SessionScene()->voxel_size, 0.001);
  early.OnPeerInfo(InfoOf(4), 0);
  early.OnPeerLeft(4);
  EXPECT_EQ(early.SessionScene()->voxel_size, 0.002);
}

TEST(EarlyInbox, HandsOverPresentPeersThenForwardsEverything) {
  EarlyInbox early;
  early.OnPeerInfo(InfoOf(4), 100);
  early.OnPeerInfo(InfoOf(5), 100);
  early.OnPeerInfo(InfoOf(6), 100);
  early.OnPeerLost(5);
  early.OnPeerLeft(6);
  early.OnScene(OfferOf(4, 0.001));
  ViewFrame frame;
  frame.peer = 4;
  early.OnView(frame, 150);  // nobody is there yet that it could be shown to

  Viewer viewer;
  early.HandOver(viewer);
  ASSERT_EQ(viewer.Picture().peers.size(), 1U);
  EXPECT_EQ(viewer.Picture().peers[0].info.peer, 4U);
  EXPECT_EQ(viewer.Picture().samples, 0U);
  ASSERT_TRUE(viewer.Picture().scene);
  EXPECT_EQ(viewer.Picture().scene->offered_by, 4U);

  early.OnView(frame, 200);
  early.OnPeerInfo(InfoOf(7), 200);
  early.OnPeerLeft(4);
  EXPECT_EQ(viewer.Picture().samples, 1U);
  ASSERT_EQ(viewer.Picture().peers.size(), 2U);
  EXPECT_EQ(viewer.Picture().peers[0].presence, ViewedPeer::Presence::kLeft);
}

TEST(EarlyInbox, TenThousandForgedParticipantsAreNotAllKept) {
  EarlyInbox early;
  for (PeerId id = 1; id <= 10'000; ++id) early.OnPeerInfo(InfoOf(id), 0);
  Viewer viewer;
  early.HandOver(viewer);
  EXPECT_EQ(viewer.Picture().peers.size(), EarlyInbox::kMost);
}

}  // namespace
}  // namespace tandem
