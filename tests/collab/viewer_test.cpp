#include "collab/viewer.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "collab/viewer_report.h"
#include "engine/base/units.h"

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

TEST(Viewer, AStragglingFrameDoesNotBringBackAPeerThatLeft) {
  Viewer viewer;
  viewer.OnPeerInfo(InfoOf(4), 0);
  viewer.OnView(FrameOf(4, 0), 1);
  viewer.OnPeerLeft(4);
  viewer.OnView(FrameOf(4, 1), 2);
  EXPECT_EQ(viewer.Picture().peers.at(0).presence, Presence::kLeft);
  viewer.OnPeerInfo(InfoOf(4), 3);
  EXPECT_EQ(viewer.Picture().peers.at(0).presence, Presence::kHere);
}

TEST(Viewer, BringsTogetherTheBodiesOfSeveralFrames) {
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

TEST(ViewerReport, CountsSamplesAndTellsTheirRateAndTheirAge) {
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
  EXPECT_NEAR(*report.age_ms_p99, 99.0, 1e-3);
  EXPECT_EQ(report.peers_seen, 1U);
  const nlohmann::json json = nlohmann::json::parse(AsJson(report));
  EXPECT_EQ(json.at("pid"), 77);
  EXPECT_EQ(json.at("seconds"), 12.5);
  EXPECT_EQ(json.at("samples"), 100);
  EXPECT_NEAR(json.at("age_ms_p99").get<double>(), 99.0, 1e-3);
}

TEST(ViewerReport, GivesNoAgeWhenTheStampsAreAnotherHosts) {
  Viewer viewer;
  viewer.OnView(FrameOf(4, 50'000 * kMs), 1'000 * kMs);  // sent after it arrived
  const ViewerReport report = ReportOf(&viewer, 1, 1);
  EXPECT_FALSE(report.age_ms_p99.has_value());
  EXPECT_TRUE(nlohmann::json::parse(AsJson(report)).at("age_ms_p99").is_null());
}

TEST(ViewerReport, SaysZeroWhenThereWasNoSession) {
  const ViewerReport report = ReportOf(nullptr, 1, 0);
  EXPECT_EQ(report.samples, 0U);
  EXPECT_EQ(report.samples_per_s, 0.0);
}

TEST(ViewerReport, NamesTheFileThatCannotBeWritten) {
  const Result<bool> written = WriteReport({}, "/nowhere/report.json");
  ASSERT_FALSE(written);
  EXPECT_NE(written.error().what.find("/nowhere/report.json"), std::string::npos);
}

}  // namespace
}  // namespace tandem
