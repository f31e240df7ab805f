#include <string>
#include <vector>

#include <gmock/gmock.h>

#include "tests/collab/dds/wire/sound_wire.h"

// Tests the messages of the control thread: who is here, what happens, what the session is about.

namespace tandem {
namespace {

using testing::kInfinity;
using testing::kNan;

TEST(Wire, PeerInfoRoundTrips) {
  const PeerInfo info{.peer = 3,
                      .protocol = kProtocol,
                      .beat = 9,
                      .role = Role::kActive,
                      .name = "Żaneta",
                      .scene_hash = 77,
                      .params_hash = 78,
                      .claims = {{1, 2, true}, {5, 0, false}},
                      .incarnation = 79,
                      .leaving = true,
                      .colour = 5,
                      .stopped = true,
                      .terms = {.law = "constant",
                                .gains = "stiffness=80",
                                .gate = false,
                                .contact = false,
                                .force_layer = 3,
                                .displacement = 0.5e-3},
                      .beliefs = {{7, 12}},
                      .scene_digest = {7, 8, 9}};
  tandem_PeerInfo wire{};
  InfoBuffers room;
  ASSERT_TRUE(ToWire(info, wire, room));
  PeerInfo back;
  ASSERT_TRUE(FromWire(wire, back));
  EXPECT_EQ(back.peer, 3U);
  EXPECT_EQ(back.protocol, kProtocol);
  EXPECT_EQ(back.beat, 9U);
  EXPECT_EQ(back.role, Role::kActive);
  EXPECT_EQ(back.name, "Żaneta");
  EXPECT_EQ(back.scene_hash, 77U);
  EXPECT_EQ(back.scene_digest, info.scene_digest);
  EXPECT_EQ(back.params_hash, 78U);
  EXPECT_EQ(back.claims, info.claims);
  EXPECT_EQ(back.incarnation, 79U);
  EXPECT_TRUE(back.leaving);
  EXPECT_EQ(back.colour, 5);
  EXPECT_TRUE(back.stopped);
  wire.colour = 200;  // no colour has that number
  ASSERT_TRUE(FromWire(wire, back));
  EXPECT_EQ(back.colour, 0);
  EXPECT_EQ(back.terms, info.terms);
  EXPECT_EQ(back.beliefs, info.beliefs);
}

TEST(Wire, ViewersClaimsAreIgnored) {
  PeerInfo info;
  info.peer = 3;
  info.role = Role::kViewer;
  info.claims = {{1, 2, true}};
  info.beliefs = {{1, 3}};
  tandem_PeerInfo wire{};
  InfoBuffers room;
  ASSERT_TRUE(ToWire(info, wire, room));
  PeerInfo back;
  ASSERT_TRUE(FromWire(wire, back));
  EXPECT_EQ(back.role, Role::kViewer);
  EXPECT_TRUE(back.claims.empty());
  EXPECT_TRUE(back.beliefs.empty());

  tandem_ViewerInfo viewer{};
  info.name = "vic";
  info.beat = 8;
  info.incarnation = 5;
  ToWire(info, viewer);
  ASSERT_TRUE(FromWire(viewer, back));
  EXPECT_EQ(back.role, Role::kViewer);
  EXPECT_EQ(back.name, "vic");
  EXPECT_EQ(back.beat, 8U);
  EXPECT_EQ(back.incarnation, 5U);
  EXPECT_TRUE(back.claims.empty());
}

TEST(Wire, LongNamesAreTruncatedBetweenCharacters) {
  PeerInfo info;
  info.peer = 1;
  info.name =
      std::string(63, 'a') + "Ż";  // 65 bytes; 64 fit, and would hold half of the last letter
  tandem_PeerInfo wire{};
  InfoBuffers room;
  ASSERT_TRUE(ToWire(info, wire, room));
  EXPECT_EQ(std::string(wire.name), std::string(63, 'a'));
}

TEST(Wire, NamesHaveNoTerminalControls) {
  PeerInfo info;
  info.peer = 1;
  info.name = "a\x1b[2Jb\n";
  tandem_PeerInfo wire{};
  InfoBuffers room;
  ASSERT_TRUE(ToWire(info, wire, room));
  PeerInfo back;
  ASSERT_TRUE(FromWire(wire, back));
  EXPECT_EQ(back.name, "a?[2Jb?");
}

TEST(Wire, InvalidDisplacementIsRefused) {
  PeerInfo info;
  info.peer = 3;
  tandem_PeerInfo wire{};
  InfoBuffers room;
  ASSERT_TRUE(ToWire(info, wire, room));
  PeerInfo back;
  for (const double bad : {kNan, kInfinity, 1e308, -1e308}) {
    wire.displacement = bad;
    EXPECT_FALSE(FromWire(wire, back)) << bad;
  }
  wire.displacement = -0.5e-3;
  EXPECT_TRUE(FromWire(wire, back));
}

TEST(Wire, OversizedPeerInfoIsNeitherSentNorAccepted) {
  PeerInfo info;
  info.peer = 1;
  info.claims.resize(65);
  tandem_PeerInfo wire{};
  InfoBuffers room;
  EXPECT_FALSE(ToWire(info, wire, room));
  info.claims.resize(64);
  ASSERT_TRUE(ToWire(info, wire, room));
  PeerInfo back;
  EXPECT_TRUE(FromWire(wire, back));
  wire.claims._length = 65;
  EXPECT_FALSE(FromWire(wire, back));
}

TEST(Wire, EventsRoundTrip) {
  Event event;
  event.peer = 3;
  event.seq = 4;
  event.kind = EventKind::kRelease;
  event.object = 5;
  event.epoch = 6;
  event.to = 7;
  event.X_WB = {Quat(0.5, 0.5, -0.5, 0.5), Vec3(1, 2, 3)};
  tandem_Event wire{};
  ToWire(event, wire);
  Event back;
  ASSERT_TRUE(FromWire(wire, back));
  EXPECT_EQ(back.peer, 3U);
  EXPECT_EQ(back.seq, 4U);
  EXPECT_EQ(back.kind, EventKind::kRelease);
  EXPECT_EQ(back.object, 5U);
  EXPECT_EQ(back.epoch, 6U);
  EXPECT_EQ(back.to, 7U);
  EXPECT_EQ(back.X_WB.p, Vec3(1, 2, 3));
  EXPECT_EQ(back.X_WB.q.coeffs(), event.X_WB.q.coeffs());
}

TEST(Wire, InvalidEventsAreRefused) {
  Event event;
  event.peer = 3;
  Event out;
  tandem_Event wire{};
  ToWire(event, wire);
  EXPECT_TRUE(FromWire(wire, out));
  wire.pose.p[1] = kNan;
  EXPECT_FALSE(FromWire(wire, out));
  ToWire(event, wire);
  wire.peer = 0;
  EXPECT_FALSE(FromWire(wire, out));
}

SceneManifest Bracket() {
  SceneManifest manifest;
  manifest.offered_by = 9;
  manifest.revision = 2;
  manifest.content_hash = 8;
  manifest.name = "bracket";
  manifest.file = "/tmp/b.json";
  manifest.voxel_size = 0.002;
  manifest.contact_stiffness = 750;
  manifest.force_layer = 2;
  manifest.contact_model = 1;
  manifest.friction = 0.25;
  manifest.bodies = {{"plate", 11, 13, Sha256Of(std::string("plate"))},
                     {"bracket", 12, 14, Sha256Of(std::string("bracket"))}};
  manifest.content_digest = Sha256Of(std::string("scene"));
  return manifest;
}

TEST(Wire, ManifestsRoundTrip) {
  tandem_SceneManifest wire{};
  ManifestBuffers room;
  ASSERT_TRUE(ToWire(Bracket(), wire, room));
  SceneManifest back;
  ASSERT_TRUE(FromWire(wire, back));
  EXPECT_EQ(back.offered_by, 9U);
  EXPECT_EQ(back.revision, 2U);
  EXPECT_EQ(back.content_hash, 8U);
  EXPECT_EQ(back.name, "bracket");
  EXPECT_EQ(back.file, "/tmp/b.json");
  EXPECT_EQ(back.voxel_size, 0.002);
  EXPECT_EQ(back.contact_stiffness, 750);
  EXPECT_EQ(back.force_layer, 2);
  EXPECT_EQ(back.contact_model, 1);
  EXPECT_EQ(back.friction, 0.25);
  EXPECT_EQ(back.bodies, Bracket().bodies);
  EXPECT_EQ(back.content_digest, Bracket().content_digest);
}

TEST(Wire, OverlongFileNameIsOmitted) {
  SceneManifest manifest = Bracket();
  manifest.file = std::string(2000, 'f');
  tandem_SceneManifest wire{};
  ManifestBuffers room;
  ASSERT_TRUE(ToWire(manifest, wire, room));
  EXPECT_EQ(std::string(wire.file), "");
}

TEST(Wire, InvalidManifestIsRefused) {
  SceneManifest out;
  ManifestBuffers room;
  for (const double size : {0.0, -1.0, kNan, kInfinity}) {
    SceneManifest manifest = Bracket();
    manifest.voxel_size = size;
    tandem_SceneManifest wire{};
    ASSERT_TRUE(ToWire(manifest, wire, room));
    EXPECT_FALSE(FromWire(wire, out)) << size;
  }
  for (const double friction : {-0.1, 1e300, kNan}) {
    SceneManifest manifest = Bracket();
    manifest.friction = friction;
    tandem_SceneManifest wire{};
    ASSERT_TRUE(ToWire(manifest, wire, room));
    EXPECT_FALSE(FromWire(wire, out)) << friction;
  }
  for (const auto& [layer, model] : {std::pair{-1, 1}, {1000, 1}, {1, 2}}) {
    SceneManifest manifest = Bracket();
    manifest.force_layer = layer;
    manifest.contact_model = static_cast<std::uint8_t>(model);
    tandem_SceneManifest wire{};
    ASSERT_TRUE(ToWire(manifest, wire, room));
    EXPECT_FALSE(FromWire(wire, out)) << layer << " " << model;
  }
  // digests of meshes that are not the bodies'
  for (const std::uint32_t digests : {1U, 3U}) {
    tandem_SceneManifest wire{};
    ASSERT_TRUE(ToWire(Bracket(), wire, room));
    room.digests.resize(3);
    wire.mesh_digests._buffer = room.digests.data();
    wire.mesh_digests._length = digests;
    EXPECT_FALSE(FromWire(wire, out)) << digests;
  }
  SceneManifest crowded = Bracket();
  crowded.bodies.resize(kMaxSceneBodies + 1);
  tandem_SceneManifest wire{};
  EXPECT_FALSE(ToWire(crowded, wire, room));
}

}  // namespace
}  // namespace tandem
