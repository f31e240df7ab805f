#include "collab/session/scene_agreement.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "engine/contact/pair/tangent_plane.h"

namespace tandem {
namespace {

using ::testing::HasSubstr;

/// A scene of a plate and a peg, and its hashes as if from files.
struct Parts {
  Parts() {
    scene.name = "parts";
    scene.file = "parts.json";
    for (const char* name : {"plate", "peg"}) {
      SceneBody& body = scene.bodies.emplace_back();
      body.name = name;
      body.mesh = std::string(name) + ".stl";
    }
    hash = {.content = 7, .digest = {7}, .parameters = 8, .bodies = {{1, 2, {2}}, {3, 4, {4}}}};
  }
  Scene scene;
  SceneHash hash;
};

SceneManifest OfferOf(PeerId by, std::uint32_t revision) {
  SceneManifest manifest;
  manifest.offered_by = by;
  manifest.revision = revision;
  return manifest;
}

TEST(SceneAgreement, ManifestDescribesTheScene) {
  const Parts parts;
  const SceneManifest manifest = ManifestOf(parts.scene, parts.hash, 5);
  EXPECT_EQ(manifest.offered_by, 5U);
  EXPECT_EQ(manifest.revision, SceneManifest::kSession);
  EXPECT_EQ(manifest.content_hash, 7U);
  EXPECT_THAT(manifest.bodies,
              ::testing::ElementsAre(BodyDecl{"plate", 1, 2, {2}}, BodyDecl{"peg", 3, 4, {4}}));
  EXPECT_EQ(manifest.content_digest, Sha256{7});
  EXPECT_EQ(ParametersOf(manifest), ParametersOf(parts.scene));
  EXPECT_EQ(ContentDifference(parts.scene, parts.hash, manifest), "");
}

TEST(SceneAgreement, ForgedMeshOfTheSameHashIsNamed) {
  const Parts parts;
  const SceneManifest session = ManifestOf(parts.scene, parts.hash, 5);
  Parts forged;
  forged.hash.digest = {8};
  forged.hash.bodies[1].mesh_digest = {5};
  ASSERT_EQ(forged.hash.content, parts.hash.content);
  EXPECT_EQ(ContentDifference(forged.scene, forged.hash, session),
            "parts.json: body \"peg\": its file peg.stl is not the one of the session's scene "
            "\"parts\"");
}

TEST(SceneAgreement, DifferenceNamesBodyAndFile) {
  const Parts parts;
  const SceneManifest session = ManifestOf(parts.scene, parts.hash, 5);
  Parts other;
  other.hash.digest = {9};
  EXPECT_EQ(ContentDifference(other.scene, other.hash, session),
            "parts.json differs from the session's scene \"parts\" in gravity or pairs");
  other.hash.bodies[1].values = 99;
  EXPECT_THAT(ContentDifference(other.scene, other.hash, session),
              HasSubstr("parts.json: body \"peg\" differs from that of the session's scene"));
  other.hash.bodies[1].mesh_digest = {99};
  EXPECT_EQ(ContentDifference(other.scene, other.hash, session),
            "parts.json: body \"peg\": its file peg.stl is not the one of the session's scene "
            "\"parts\"");
}

TEST(SceneAgreement, MissingAndExtraBodiesAreNamed) {
  Parts more;
  more.scene.bodies.emplace_back().name = "hose";
  more.hash.digest = {9};
  more.hash.bodies.push_back({5, 6, {}});
  const Parts parts;
  EXPECT_THAT(ContentDifference(more.scene, more.hash, ManifestOf(parts.scene, parts.hash, 5)),
              HasSubstr("body \"hose\" is not in the session's scene \"parts\""));
  EXPECT_THAT(ContentDifference(parts.scene, parts.hash, ManifestOf(more.scene, more.hash, 5)),
              HasSubstr("body \"hose\" of the session's scene \"parts\" is missing"));
}

TEST(SceneAgreement, WarningNamesTheStrongerSideOnsetAndRatio) {
  ForceParameters fine{.voxel_size = 0.001, .stiffness = LeastContactStiffness(0.001)};
  ForceParameters coarse{.voxel_size = 0.002, .stiffness = LeastContactStiffness(0.002)};
  // 0.45 voxels; 10 N as of ForceParameters.SmallerVoxelsPushHarder
  const std::string of_fine = PushWarning(fine, coarse, 0.1, "anna");
  EXPECT_THAT(of_fine, HasSubstr("anna uses other force parameters (voxels of 2 mm"));
  EXPECT_THAT(of_fine, HasSubstr("you push harder; where parts press one another, theirs is "
                                 "pushed back from a gap of 0.90 mm on, yours from 0.45 mm, and "
                                 "up to 10 N a point of contact they feel all of it"));
  EXPECT_THAT(PushWarning(coarse, fine, 0.1, "anna"),
              HasSubstr("anna pushes harder; where parts press one another, yours is pushed back"));
}

TEST(SceneOffers, HighestRevisionThenLowestPeerWins) {
  SceneOffers offers;
  EXPECT_EQ(offers.session(), nullptr);
  offers.OnScene(OfferOf(4, SceneManifest::kOwnOnly));
  EXPECT_EQ(offers.session()->offered_by, 4U);
  offers.OnScene(OfferOf(9, SceneManifest::kSession));
  EXPECT_EQ(offers.session()->offered_by, 9U);
  offers.OnScene(OfferOf(6, SceneManifest::kSession));
  EXPECT_EQ(offers.session()->offered_by, 6U);
}

TEST(SceneOffers, AdoptedManifestOutlivesItsAuthor) {
  SceneOffers offers;
  offers.OnScene(OfferOf(1, SceneManifest::kSession));
  offers.OnScene(OfferOf(2, SceneManifest::kSession));
  offers.OnScene(OfferOf(3, SceneManifest::kOwnOnly));
  offers.OnPresence(1, false);
  EXPECT_EQ(offers.session()->offered_by, 2U);
  offers.OnPresence(2, false);
  // only one of those here is left, who insisted
  EXPECT_EQ(offers.session()->offered_by, 3U);
  offers.OnPresence(1, true);
  EXPECT_EQ(offers.session()->offered_by, 1U);
}

TEST(SceneOffers, AbandonedOfferDoesNotCount) {
  SceneOffers offers;
  SceneOffers of_a_viewer(true);
  for (SceneOffers* one : {&offers, &of_a_viewer}) {
    one->OnScene(OfferOf(3, SceneManifest::kSession));
    one->OnWithdrawn(3);
  }
  EXPECT_EQ(offers.session(), nullptr);
  ASSERT_NE(of_a_viewer.session(), nullptr) << "a viewer goes on to show what was";
}

// A peer that takes no part, or has come alone, does not decide for those under way.
TEST(SceneOffers, WithdrawnOfferDoesNotReturn) {
  SceneOffers offers;
  offers.OnPresence(3, true);
  offers.OnScene(OfferOf(3, 1));
  offers.OnWithdrawn(3);
  offers.OnPresence(3, true);
  EXPECT_EQ(offers.session(), nullptr);
  EXPECT_TRUE(offers.All().empty());
}

TEST(SceneOffers, MajoritysRunningManifestCounts) {
  SceneOffers offers;
  SceneManifest forged = OfferOf(1, SceneManifest::kUnderWay);
  forged.voxel_size = 3e-5;
  offers.OnScene(forged);
  for (const PeerId honest : {5, 6}) {
    offers.OnPresence(honest, true);
    offers.OnScene(OfferOf(honest, SceneManifest::kUnderWay));
  }
  EXPECT_EQ(offers.session()->offered_by, 5U) << "1 has no presence";
  offers.OnPresence(1, true);
  EXPECT_EQ(offers.session()->offered_by, 5U) << "two against one";
}

TEST(SceneAgreement, VoxelSizesWithinAFactorOfFourAreAdopted) {
  const ForceParameters ours{.voxel_size = 1e-3};
  EXPECT_TRUE(MayBeAdopted({.voxel_size = 0.25e-3}, ours));
  EXPECT_TRUE(MayBeAdopted({.voxel_size = 4e-3}, ours));
  EXPECT_FALSE(MayBeAdopted({.voxel_size = 0.2e-3}, ours));
  EXPECT_FALSE(MayBeAdopted({.voxel_size = 5e-3}, ours));
}

TEST(SceneOffers, ForgedOffersDoNotDisplaceTheSessions) {
  SceneOffers offers;
  offers.OnScene(OfferOf(2, SceneManifest::kSession));
  for (PeerId id = 3; id < 10'003; ++id) offers.OnScene(OfferOf(id, SceneManifest::kOwnOnly));
  EXPECT_EQ(offers.size(), SceneOffers::kMost);
  EXPECT_EQ(offers.session()->offered_by, 2U);
  offers.OnScene(OfferOf(1, SceneManifest::kSession));
  EXPECT_EQ(offers.session()->offered_by, 1U);
}

}  // namespace
}  // namespace tandem
