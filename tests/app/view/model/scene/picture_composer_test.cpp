#include "app/view/model/scene/picture_composer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace tandem {
namespace {

using Presence = ViewedPeer::Presence;

constexpr double kX = 0.25;

ViewedPeer PeerAt(PeerId id, const std::string& name, double x, double delay_ms = 0) {
  ViewedPeer peer;
  peer.info.peer = id;
  peer.info.name = name;
  peer.delay_ms = delay_ms;
  ViewBody body;
  body.object = 1;
  body.X_W.p = Vec3(x, 0, 0);
  peer.bodies = {body};
  return peer;
}

const std::vector<BodyLook> kFixtureAndPart{{true, {0.5F, 0.5F, 0.5F}},
                                            {false, {1.0F, 0.0F, 0.0F}}};

class Composed : public ::testing::Test {
 protected:
  DrawList At(double now_s) { return composer_.Compose(picture_, kFixtureAndPart, now_s); }
  ViewerPicture picture_;
  PictureComposer composer_;
};

TEST_F(Composed, UnsentBodiesKeepTheirInitialPose) {
  const DrawList list = At(0);
  ASSERT_EQ(list.solids.size(), 2U);
  EXPECT_EQ(list.solids[1].X_W.p, Vec3::Zero());
  EXPECT_EQ(list.solids[1].colour, kFixtureAndPart[1].colour);
  EXPECT_TRUE(list.ghosts.empty());
  EXPECT_TRUE(list.labels.empty());
}

TEST_F(Composed, TheFirstActivePeersInstanceIsSolidAndTheOthersAreGhostsInTheirColours) {
  picture_.peers = {PeerAt(3, "Anna", kX, 103.7), PeerAt(8, "Ben", 2 * kX)};
  const DrawList list = At(0);
  EXPECT_EQ(list.solids[1].X_W.p.x(), kX);
  ASSERT_EQ(list.ghosts.size(), 1U);
  EXPECT_EQ(list.ghosts[0].X_W.p.x(), 2 * kX);
  EXPECT_EQ(list.ghosts[0].colour, ColourOfPerson(picture_.peers[1].info));
  EXPECT_NE(ColourOfPerson(picture_.peers[1].info), ColourOfPerson(picture_.peers[0].info));
  picture_.peers[1].info.colour = 7;
  picture_.peers[1].info.stopped = true;
  const DrawList chosen = At(0);
  EXPECT_EQ(chosen.ghosts[0].colour, PaletteColour(7));
  EXPECT_EQ(chosen.labels[1].text, "Ben \u00b7 ghost \u00b7 stopped");
  ASSERT_EQ(list.labels.size(), 2U);
  EXPECT_EQ(list.labels[0].text, "Anna \u00b7 solid \u00b7 104 ms");
  EXPECT_EQ(list.labels[1].text, "Ben \u00b7 ghost");
}

// Anybody may send a picture of any body, and a low id costs nothing.
TEST_F(Composed, ClaimantsInstanceIsSolidWhateverOthersSend) {
  picture_.peers = {PeerAt(2, "Mallory", -kX), PeerAt(3, "Anna", kX), PeerAt(8, "Ben", 2 * kX)};
  picture_.peers[2].info.claims = {{1, 5, false}};
  DrawList list = At(0);
  EXPECT_EQ(list.solids[1].X_W.p.x(), 2 * kX);
  EXPECT_EQ(list.reported[1].p.x(), 2 * kX) << "distances are measured elsewhere";
  EXPECT_EQ(list.ghosts.size(), 2U);
  EXPECT_EQ(list.labels[0].text, "Mallory \u00b7 ghost");
  EXPECT_EQ(list.labels[2].text, "Ben \u00b7 solid");
  // the later of two claims counts; if both have one epoch, that of the lower id does
  picture_.peers[1].info.claims = {{1, 6, true}};
  EXPECT_EQ(At(1).solids[1].X_W.p.x(), kX);
  picture_.peers[2].info.claims = {{1, 6, true}};
  EXPECT_EQ(At(2).solids[1].X_W.p.x(), kX);
  picture_.peers[2].info.claims = {{1, 7, true}};
  EXPECT_EQ(At(3).solids[1].X_W.p.x(), 2 * kX);
  // neither a claim on another body counts, nor that of a peer that is gone, nor one without a
  // picture
  picture_.peers[0].info.claims = {{0, 9, true}, {7, 9, true}};
  EXPECT_EQ(At(4).solids[1].X_W.p.x(), 2 * kX);
  picture_.peers[2].presence = Presence::kLost;
  EXPECT_EQ(At(5).solids[1].X_W.p.x(), kX);
  picture_.peers[1].bodies.clear();
  EXPECT_EQ(At(6).solids[1].X_W.p.x(), -kX);
}

// An epoch costs nothing either, so the beliefs of the others decide first.
TEST_F(Composed, UnacceptedClaimIsNotDrawnSolid) {
  picture_.peers = {PeerAt(2, "Mallory", -kX), PeerAt(3, "Anna", kX), PeerAt(8, "Ben", 2 * kX)};
  picture_.peers[0].info.claims = {{1, 0xFFFFFFFF, true}};
  picture_.peers[1].info.claims = {{1, 6, true}};
  picture_.peers[2].info.beliefs = {{1, 3, 6}};
  EXPECT_EQ(At(0).solids[1].X_W.p.x(), kX);
  // a belief in oneself does not count, and each peer counts once
  picture_.peers[0].info.beliefs = {{1, 2, 9}, {1, 2, 9}, {1, 2, 9}};
  EXPECT_EQ(At(1).solids[1].X_W.p.x(), kX);
  ViewedPeer vera = PeerAt(9, "Vera", 3 * kX);
  vera.bodies.clear();
  vera.info.beliefs = {{1, 3, 6}, {1, 2, 9}, {1, 2, 9}};
  picture_.peers.push_back(vera);
  EXPECT_EQ(At(2).solids[1].X_W.p.x(), kX);
}

TEST_F(Composed, SoleInstanceIsNeitherSolidNorGhost) {
  picture_.peers = {PeerAt(3, "Anna", kX, 103.7)};
  EXPECT_EQ(At(0).labels[0].text, "Anna \u00b7 104 ms");
}

TEST_F(Composed, OwnLeaveFadesOthersWithoutMarkingThemAsLeft) {
  picture_.peers = {PeerAt(3, "Anna", kX), PeerAt(8, "Ben", 2 * kX)};
  At(0);
  for (ViewedPeer& peer : picture_.peers) peer.presence = Presence::kUnknown;
  const DrawList list = At(0.1);
  ASSERT_EQ(list.labels.size(), 2U);
  EXPECT_EQ(list.labels[0].text, "Anna");
  EXPECT_TRUE(At(5).labels.empty());
}

TEST_F(Composed, ReturningPeerKeepsItsColour) {
  picture_.peers = {PeerAt(3, "Anna", kX), PeerAt(8, "Ben", 2 * kX)};
  const Colour colour = At(0).labels[1].colour;
  picture_.peers[1].info.peer = 12;
  picture_.peers[1].first_id = 8;
  EXPECT_EQ(At(1).labels[1].colour, colour);
}

TEST_F(Composed, ReportsHeldBodies) {
  picture_.peers = {PeerAt(3, "Anna", kX)};
  EXPECT_TRUE(At(0).held.empty());
  picture_.peers[0].bodies[0].flags = ViewBody::kHeld;
  EXPECT_EQ(At(1).held, std::vector<std::size_t>{1});
  picture_.peers[0].presence = Presence::kLost;
  EXPECT_TRUE(At(2).held.empty());
}

// A body in hand is drawn ahead of its frame. Measured values stay at the pose that was told.
TEST_F(Composed, FreelyMovedBodyIsPredicted) {
  picture_.peers = {PeerAt(3, "Anna", kX), PeerAt(8, "Ben", 2 * kX)};
  for (ViewedPeer& peer : picture_.peers) {
    peer.bodies[0].flags = ViewBody::kHeld;
    peer.V_W.v.x() = 0.2;
  }
  At(0);
  DrawList list = At(0.05);
  EXPECT_NEAR(list.solids[1].X_W.p.x(), kX + 0.01, 1e-12);
  EXPECT_NEAR(list.ghosts[0].X_W.p.x(), 2 * kX + 0.01, 1e-12);
  EXPECT_NEAR(list.labels[0].X_W.p.x(), kX + 0.01, 1e-12);
  EXPECT_EQ(list.reported[1].p.x(), kX);
  EXPECT_EQ(list.reported[0].p, Vec3::Zero());
  // a body is not drawn ahead where it touches something, nor where its peer is silent
  picture_.peers[0].bodies[0].flags |= ViewBody::kInContact;
  picture_.peers[0].seq = 1;
  picture_.peers[1].presence = Presence::kLost;
  picture_.peers[1].seq = 1;
  At(0.05);
  list = At(0.6);
  EXPECT_EQ(list.solids[1].X_W.p.x(), kX);
  EXPECT_EQ(list.ghosts[0].X_W.p.x(), 2 * kX);
}

TEST_F(Composed, WallBetweenInstancesIsLabelled) {
  picture_.peers = {PeerAt(3, "Anna", kX, 20)};
  picture_.peers[0].bodies[0].flags = ViewBody::kHeld | ViewBody::kTrapped;
  EXPECT_EQ(At(0).labels[0].text, "Anna \u00b7 20 ms \u00b7 trapped");
}

TEST_F(Composed, LeavingPeerFadesAndTheNextInstanceIsSolid) {
  picture_.peers = {PeerAt(3, "Anna", kX), PeerAt(8, "Ben", 2 * kX)};
  At(10);
  picture_.peers[0].presence = Presence::kLeft;
  DrawList list = At(11);
  EXPECT_EQ(list.solids[1].X_W.p.x(), 2 * kX);
  ASSERT_EQ(list.ghosts.size(), 1U);
  EXPECT_FLOAT_EQ(list.ghosts[0].opacity, PictureComposer::kGhostOpacity);
  EXPECT_EQ(list.labels[0].text, "Anna \u00b7 left");
  list = At(11 + 0.5 * PictureComposer::kFadeSeconds);
  ASSERT_EQ(list.ghosts.size(), 1U);
  EXPECT_NEAR(list.ghosts[0].opacity, 0.5 * PictureComposer::kGhostOpacity, 1e-5);
  list = At(11 + PictureComposer::kFadeSeconds);
  EXPECT_TRUE(list.ghosts.empty());
  ASSERT_EQ(list.labels.size(), 1U);
  EXPECT_EQ(list.labels[0].text, "Ben");
}

TEST_F(Composed, ReturningPeerIsShownAtOnce) {
  picture_.peers = {PeerAt(3, "Anna", kX), PeerAt(8, "Ben", 2 * kX)};
  At(0);
  picture_.peers[1].presence = Presence::kLost;
  At(1);
  EXPECT_TRUE(At(5).ghosts.empty());
  picture_.peers[1].presence = Presence::kHere;
  const DrawList list = At(6);
  ASSERT_EQ(list.ghosts.size(), 1U);
  EXPECT_FLOAT_EQ(list.ghosts[0].opacity, PictureComposer::kGhostOpacity);
}

// A viewer keeps a limited number of peers. Nothing is kept here either of a peer that it has
// forgotten.
TEST_F(Composed, ForgottenPeerReturnsAsNew) {
  picture_.peers = {PeerAt(3, "Anna", kX)};
  picture_.peers[0].presence = Presence::kLost;
  At(0);
  EXPECT_TRUE(At(2).labels.empty());
  picture_.peers.clear();
  At(3);
  picture_.peers = {PeerAt(3, "Anna", kX + 0.05)};
  picture_.peers[0].presence = Presence::kLost;
  picture_.peers[0].seq = 9;
  const DrawList list = At(3.001);
  EXPECT_EQ(list.solids[1].X_W.p.x(), kX + 0.05) << "drawn over from where it once was";
  ASSERT_EQ(list.labels.size(), 1U) << "faded long ago";
  EXPECT_FLOAT_EQ(list.labels[0].opacity, 1.0F);
}

TEST_F(Composed, BodyKeepsItsLastPoseWhenAllPeersLeave) {
  picture_.peers = {PeerAt(3, "Anna", kX), PeerAt(8, "Ben", 2 * kX)};
  picture_.peers[0].received_ns = 5;
  picture_.peers[1].received_ns = 9;
  picture_.peers[0].presence = picture_.peers[1].presence = Presence::kLost;
  At(0);
  EXPECT_EQ(At(9).solids[1].X_W.p.x(), 2 * kX);
}

TEST_F(Composed, HoldersNameIsDrawnBesideTheBody) {
  ViewedPeer peer = PeerAt(3, "Anna", kX);
  ViewBody held;
  held.object = 2;
  held.flags = ViewBody::kHeld;
  peer.bodies.push_back(held);
  picture_.peers = {peer};
  const DrawList list = composer_.Compose(picture_, {{true, {}}, {false, {}}, {false, {}}}, 0);
  ASSERT_EQ(list.labels.size(), 1U);
  EXPECT_EQ(list.labels[0].body, 2U);
}

TEST_F(Composed, PosesOfUnknownBodiesAreIgnored) {
  ViewedPeer peer = PeerAt(3, "Anna", kX);
  peer.bodies[0].object = 17;
  picture_.peers = {peer};
  const DrawList list = At(0);
  EXPECT_TRUE(list.ghosts.empty());
  EXPECT_TRUE(list.labels.empty());
}

// Body 2 is merged with body 1, which is what peers send.
TEST_F(Composed, MergedPartMovesWithItsBodyInItsOwnColour) {
  const Colour blue{0.0F, 0.0F, 1.0F};
  std::vector<BodyLook> exact_queries = kFixtureAndPart;
  exact_queries.push_back({false, blue, 1});
  picture_.peers = {PeerAt(3, "Anna", kX), PeerAt(8, "Ben", 2 * kX)};
  const DrawList list = composer_.Compose(picture_, exact_queries, 0);
  ASSERT_EQ(list.solids.size(), 3U);
  EXPECT_EQ(list.solids[2].X_W.p.x(), kX);
  EXPECT_EQ(list.solids[2].colour, blue);
  ASSERT_EQ(list.ghosts.size(), 2U);
  EXPECT_EQ(list.ghosts[1].body, 2U);
  EXPECT_EQ(list.ghosts[1].X_W.p.x(), 2 * kX);
  EXPECT_EQ(list.ghosts[1].colour, ColourOfPerson(picture_.peers[1].info));
}

TEST_F(Composed, EqualPicturesGiveEqualDrawLists) {
  picture_.peers = {PeerAt(3, "Anna", kX), PeerAt(8, "Ben", 2 * kX)};
  const DrawList first = At(0);
  EXPECT_TRUE(first == At(1));
  picture_.peers[1].bodies[0].X_W.p.y() += 1e-6;
  EXPECT_FALSE(first == At(2));
}

}  // namespace
}  // namespace tandem
