#include "collab/session/viewer.h"

#include <limits>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "collab/session/viewer_report.h"
#include "engine/base/units.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/scratch_folder.h"

namespace tandem {
namespace {

using Presence = ViewedPeer::Presence;

ViewFrame FrameOf(PeerId peer, std::int64_t sample_ns) {
  ViewFrame frame;
  frame.peer = peer;
  frame.sample_ns = sample_ns;
  return frame;
}

PeerInfo InfoOf(PeerId peer, Role role = Role::kActive) {
  PeerInfo info;
  info.peer = peer;
  info.role = role;
  return info;
}

TEST(Viewer, LateFrameDoesNotRestoreADepartedPeer) {
  Viewer viewer;
  viewer.OnPeerInfo(InfoOf(4), 0);
  viewer.OnView(FrameOf(4, 0), 1);
  viewer.OnPeerLeft(4);
  viewer.OnView(FrameOf(4, 1), 2);
  EXPECT_EQ(viewer.Picture().peers.at(0).presence, Presence::kLeft);
  viewer.OnPeerInfo(InfoOf(4), 3);
  EXPECT_EQ(viewer.Picture().peers.at(0).presence, Presence::kHere);
}

PeerInfo Named(PeerId peer, const std::string& name, Role role = Role::kActive) {
  PeerInfo info = InfoOf(peer, role);
  info.name = name;
  return info;
}

TEST(Viewer, NumbersPersonsOfOneNameWhoAreHere) {
  Viewer viewer;
  viewer.OnPeerInfo(Named(9, "anna"), 1 * kMs);
  viewer.OnPeerInfo(Named(4, "anna"), 2 * kMs);
  viewer.OnPeerInfo(Named(5, "anna", Role::kViewer), 3 * kMs);  // one of them looks on, too
  ViewerPicture picture = viewer.Picture();
  EXPECT_EQ(picture.peers[0].info.name, "anna (2)");
  EXPECT_EQ(picture.peers[1].info.name, "anna");
  EXPECT_EQ(picture.peers[2].info.name, "anna");
  viewer.OnPeerLeft(9);
  picture = viewer.Picture();
  EXPECT_EQ(picture.peers[0].info.name, "anna");
}

TEST(Viewer, ChoosesAColourThatNobodyHereHas) {
  Viewer viewer;
  PeerInfo anna = Named(9, "anna");
  anna.colour = ColourOfName("dave");
  anna.beat = 40;
  viewer.OnPeerInfo(anna, 1 * kMs);
  EXPECT_NE(viewer.ColourFor(Named(4, "dave", Role::kViewer), 0), anna.colour);
  EXPECT_EQ(viewer.ColourFor(Named(4, "anna", Role::kViewer), 0), anna.colour);
}

TEST(Viewer, ReturningPeerWithANewIdIsListedOnce) {
  Viewer viewer;
  viewer.OnPeerInfo(Named(4, "anna"), 1 * kMs);
  viewer.OnPeerInfo(Named(6, "ben"), 1 * kMs);
  viewer.OnPeerLeft(4);
  viewer.OnView(FrameOf(9, 0), 2 * kMs);  // the picture may come before the name
  viewer.OnPeerInfo(Named(9, "anna"), 3 * kMs);
  viewer.OnView(FrameOf(4, 1), 4 * kMs);  // a straggler of the program that has ended
  const ViewerPicture picture = viewer.Picture();
  ASSERT_EQ(picture.peers.size(), 2U);
  EXPECT_EQ(picture.peers[1].info.peer, 9U);
  EXPECT_EQ(picture.peers[1].presence, Presence::kHere);
  EXPECT_TRUE(picture.peers[1].came_back);
  EXPECT_EQ(LastingId(picture.peers[1]), 4U);  // and so keeps its colour
  EXPECT_FALSE(picture.peers[0].came_back);
  EXPECT_EQ(LastingId(picture.peers[0]), 6U);
}

// The first program's end is noticed when its lease has run out, seconds after the second began.
TEST(Viewer, RestartedPeerIsListedOnceBeforeItsCrashIsNoticed) {
  Viewer viewer;
  viewer.OnPeerInfo(Named(4, "anna"), 1 * kMs);
  viewer.OnPeerInfo(Named(9, "anna"), 3 * kMs);
  EXPECT_EQ(viewer.Picture().peers.size(), 2U);
  viewer.OnPeerLost(4);
  ASSERT_EQ(viewer.Picture().peers.size(), 1U);
  EXPECT_EQ(viewer.Picture().peers[0].info.peer, 9U);
  EXPECT_EQ(LastingId(viewer.Picture().peers[0]), 4U);
}

TEST(Viewer, PeersOfEqualNamesAreDistinct) {
  Viewer viewer;
  viewer.OnPeerInfo(Named(4, "anna"), 1 * kMs);
  viewer.OnPeerInfo(Named(9, "anna"), 2 * kMs);
  viewer.OnPeerInfo(Named(4, "anna"), 3 * kMs);  // heard after the other came
  viewer.OnPeerLeft(4);
  ASSERT_EQ(viewer.Picture().peers.size(), 2U);
  EXPECT_EQ(viewer.Picture().peers[0].presence, Presence::kLeft);
  EXPECT_NE(LastingId(viewer.Picture().peers[1]), 4U);
  // nor does a viewer take the place of a peer that took part
  viewer.OnPeerInfo(Named(11, "anna", Role::kViewer), 4 * kMs);
  EXPECT_EQ(viewer.Picture().peers.size(), 3U);
}

TEST(Viewer, ReplayIsMarkedByANameThatFitsTheWire) {
  EXPECT_FALSE(IsReplay(Named(4, "anna")));
  EXPECT_EQ(ReplayName("anna"), "anna (replay)");
  EXPECT_TRUE(IsReplay(Named(4, ReplayName("anna"))));
  const std::string long_name = ReplayName(std::string(60, 'x') + "\u00e9");
  EXPECT_EQ(long_name.size(), kMaxPeerName);
  std::string accents;
  for (int i = 0; i < 40; ++i) accents += "\u00e9";  // two bytes each
  EXPECT_EQ(ReplayName(accents).size(), kMaxPeerName - 1);
  EXPECT_TRUE(IsReplay(Named(4, ReplayName(accents))));
}

TEST(Viewer, OtherProtocolNamesBothVersions) {
  PeerInfo info = Named(4, "anna");
  EXPECT_EQ(OtherProtocol(info), "");
  info.protocol = kProtocol + 1;
  EXPECT_EQ(OtherProtocol(info), "uses protocol " + std::to_string(kProtocol + 1) +
                                     ", this program " + std::to_string(kProtocol) +
                                     ": update both to one version");
}

TEST(Viewer, CombinesBodiesOfSeveralFrames) {
  Viewer viewer;
  ViewFrame frame = FrameOf(4, 0);
  frame.count = 1;
  frame.bodies[0].object = 1;
  viewer.OnView(frame, 1);
  frame.bodies[0].object = 2;
  viewer.OnView(frame, 2);
  frame.bodies[0].X_W.p.x() = 0.5;
  viewer.OnView(frame, 3);
  const ViewerPicture picture = viewer.Picture();
  ASSERT_EQ(picture.peers.at(0).bodies.size(), 2U);
  EXPECT_EQ(picture.peers[0].bodies[1].X_W.p.x(), 0.5);
}

TEST(Viewer, ImpossibleBodiesAreNotKept) {
  Viewer viewer;
  viewer.OnPeerInfo(InfoOf(4), 0);
  ViewFrame frame = FrameOf(4, 0);
  frame.count = kMaxViewBodies;
  for (ObjectId first = 0; first < 100'000; first += kMaxViewBodies) {
    for (ObjectId i = 0; i < kMaxViewBodies; ++i) frame.bodies[i].object = first + i;
    viewer.OnView(frame, 1);
  }
  EXPECT_LE(viewer.Picture().peers.at(0).bodies.size(), kMaxSceneBodies);
  EXPECT_GE(viewer.refused(), 100'000 - kMaxSceneBodies);
}

TEST(ViewerReport, ReportsSampleCountRateAndAge) {
  Viewer viewer;
  viewer.OnPeerInfo(InfoOf(4), 0);
  viewer.OnPeerInfo(InfoOf(9, Role::kViewer), 0);
  // 100 frames, one every 20 ms, of ages 1 to 100 ms: the 99th percentile is 99 ms
  for (std::int64_t i = 0; i < 100; ++i) {
    const std::int64_t arrival = 1'000 * kMs + i * 20 * kMs;
    viewer.OnView(FrameOf(4, arrival - (i + 1) * kMs), arrival);
  }
  const ViewerReport report = ReportOf(&viewer, 77, 12.5);
  EXPECT_EQ(report.samples, 100U);
  EXPECT_NEAR(report.samples_per_s, 50.0, 1e-9);
  ASSERT_TRUE(report.age_ms_p99.has_value());
  EXPECT_NEAR(*report.age_ms_p99, 99.0, 99.0 / 64);
  EXPECT_EQ(report.peers_seen, 1U);
  const nlohmann::json json = nlohmann::json::parse(AsJson(report));
  EXPECT_EQ(json.at("pid"), 77);
  EXPECT_EQ(json.at("seconds"), 12.5);
  EXPECT_EQ(json.at("samples"), 100);
  EXPECT_EQ(json.at("age_ms_p99").get<double>(), *report.age_ms_p99);
}

TEST(Viewer, SilentFloodDoesNotBlockNewcomers) {
  Viewer viewer;
  viewer.OnPeerInfo(InfoOf(4), 0);
  for (PeerId peer = 1000; peer < 1000 + 2 * Viewer::kMost; ++peer)
    viewer.OnView(FrameOf(peer, 0), 1);
  viewer.OnPeerInfo(InfoOf(999), 2);
  std::vector<PeerId> introduced;
  for (const ViewedPeer& peer : viewer.Picture().peers) {
    if (peer.introduced) introduced.push_back(peer.info.peer);
  }
  EXPECT_EQ(introduced, (std::vector<PeerId>{4, 999}));
}

TEST(ViewerReport, ForgedTimestampsGiveNoAge) {
  for (const std::int64_t stamp : {std::numeric_limits<std::int64_t>::min(),
                                   std::numeric_limits<std::int64_t>::max(), -1'000'000 * kMs}) {
    Viewer viewer;
    viewer.OnView(FrameOf(4, stamp), 1'000 * kMs);
    viewer.OnView(FrameOf(4, 999 * kMs), 1'000 * kMs);
    EXPECT_FALSE(ReportOf(&viewer, 1, 1).age_ms_p99.has_value()) << stamp;
  }
}

// A viewer that looks on for days keeps no more of frames than one that has just come.
TEST(Viewer, MemoryIsBoundedOverAMillionFrames) {
  Viewer viewer;
  viewer.OnPeerInfo(InfoOf(4), 0);
  const auto frames = [&viewer](int count) {
    for (int i = 0; i < count; ++i) viewer.OnView(FrameOf(4, 999 * kMs), 1'000 * kMs);
  };
  frames(10);
  const testing::AllocationCounter counter;
  frames(1'000'000);
  EXPECT_EQ(counter.count(), 0);
}

TEST(ViewerReport, TimestampsOfAnotherHostGiveNoAge) {
  Viewer viewer;
  viewer.OnView(FrameOf(4, 50'000 * kMs), 1'000 * kMs);  // sent after it arrived
  const ViewerReport report = ReportOf(&viewer, 1, 1);
  EXPECT_FALSE(report.age_ms_p99.has_value());
  EXPECT_TRUE(nlohmann::json::parse(AsJson(report)).at("age_ms_p99").is_null());
}

TEST(ViewerReport, ReportsZeroWithoutASession) {
  const ViewerReport report = ReportOf(nullptr, 1, 0);
  EXPECT_EQ(report.samples, 0U);
  EXPECT_EQ(report.samples_per_s, 0.0);
}

TEST(ViewerReport, NamesAnUnwritableFile) {
  const Result<bool> written = WriteReport({}, "/nowhere/report.json");
  ASSERT_FALSE(written);
  EXPECT_NE(written.error().what.find("/nowhere/report.json"), std::string::npos);
}

TEST(ViewerReport, FollowsNoPlantedSymbolicLink) {
  const ScratchFolder scratch;
  const std::filesystem::path victim = scratch.Write("victim", "precious");
  const std::filesystem::path file = scratch.path() / "report.json";
  std::filesystem::create_symlink(victim, scratch.path() / "report.json.unfinished");
  ASSERT_TRUE(WriteReport({}, file));
  EXPECT_EQ(std::filesystem::file_size(victim), 8U);
  EXPECT_TRUE(std::filesystem::is_regular_file(std::filesystem::symlink_status(file)));
  EXPECT_GT(std::filesystem::file_size(file), 8U);
}

}  // namespace
}  // namespace tandem
