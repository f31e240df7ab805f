#include "collab/dds/wire/control_wire.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace tandem {
namespace {

ControlRequest ThereAndBack(const ControlRequest& request) {
  tandem_control_Request wire{};
  EXPECT_TRUE(ToWire(request, wire));
  const std::optional<ControlRequest> back = FromWire(wire);
  EXPECT_TRUE(back.has_value());
  return back.value_or(QuitRequest{});
}

TEST(ControlWire, RequestsRoundTrip) {
  const auto grab = std::get<GrabRequest>(
      ThereAndBack(GrabRequest{.body = "peg", .grasp_W = {{0.1, -0.2, 0.3}}}));
  EXPECT_EQ(grab.body, "peg");
  ASSERT_TRUE(grab.grasp_W);
  EXPECT_EQ((*grab.grasp_W)[1], -0.2);
  EXPECT_FALSE(std::get<GrabRequest>(ThereAndBack(GrabRequest{.body = "peg"})).grasp_W);
  const auto mesh = std::get<LoadMeshRequest>(ThereAndBack(LoadMeshRequest{
      .file = "/a.stl", .body = "a", .fixed = true, .shared = false, .mass_kg = 2.5}));
  EXPECT_EQ(mesh.file, "/a.stl");
  EXPECT_EQ(mesh.body, "a");
  EXPECT_TRUE(mesh.fixed);
  EXPECT_FALSE(mesh.shared);
  EXPECT_EQ(mesh.mass_kg, 2.5);
  const auto clearance =
      std::get<SetClearanceRequest>(ThereAndBack(SetClearanceRequest{3, -0.0005}));
  EXPECT_EQ(clearance.force_layer, 3);
  EXPECT_EQ(clearance.displacement_m, -0.0005);
  const auto back =
      std::get<RetraceRequest>(ThereAndBack(RetraceRequest{RetraceRequest::To::kReset}));
  EXPECT_EQ(back.to, RetraceRequest::To::kReset);
  const auto parameter =
      std::get<SetParameterRequest>(ThereAndBack(SetParameterRequest{"hand_force_N", 7}));
  EXPECT_EQ(parameter.name, "hand_force_N");
  EXPECT_EQ(parameter.value, 7);
  const auto view = std::get<SetViewRequest>(ThereAndBack(SetViewRequest{{0.1, 0.2, 0.3, 0.9}}));
  EXPECT_EQ(view.q_WV, (std::array{0.1, 0.2, 0.3, 0.9}));
}

TEST(ControlWire, RequestKindsAreDistinct) {
  const std::vector<ControlRequest> all{
      LoadSceneRequest{},       LoadMeshRequest{}, VoxelizeRequest{}, GrabRequest{},
      ReleaseRequest{},         GiveRequest{},     AskForRequest{},   SetParameterRequest{},
      SetClearanceRequest{},    SaveRequest{},     RetraceRequest{},  SnapshotRateRequest{},
      EmergencyStopRequest{},   ResumeRequest{},   QuitRequest{},     SetViewRequest{},
      MeasureDistancesRequest{}};
  ASSERT_EQ(all.size(), std::variant_size_v<ControlRequest>);
  for (const ControlRequest& request : all) {
    EXPECT_EQ(ThereAndBack(request).index(), request.index());
  }
}

TEST(ControlWire, RefusesInvalidRequests) {
  tandem_control_Request wire{};
  ASSERT_TRUE(ToWire(RetraceRequest{}, wire));
  wire.whole = 3;
  EXPECT_FALSE(FromWire(wire));
  ASSERT_TRUE(ToWire(GrabRequest{.body = "peg", .grasp_W = {{0, 0, 0}}}, wire));
  wire.point[2] = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(FromWire(wire));
  EXPECT_FALSE(ToWire(LoadSceneRequest{std::string(2000, 'a')}, wire)) << "half a name is none";

  tandem_control_Goal goal{};
  HostGoal read;
  HostGoal output{.kind = HostGoal::Kind::kPose, .seq = 4};
  output.X_WG.p = Vec3(1, 2, 3);
  ToWire(output, goal);
  ASSERT_TRUE(FromWire(goal, read));
  EXPECT_EQ(read.X_WG.p, output.X_WG.p);
  EXPECT_EQ(read.seq, 4U);
  goal.pose.q[3] = 0.5;
  EXPECT_FALSE(FromWire(goal, read)) << "no rotation";
  ToWire(output, goal);
  goal.linear[0] = std::nan("");
  EXPECT_FALSE(FromWire(goal, read));
}

TEST(ControlWire, NamesOfASnapshotAreThoseOfItsScene) {
  ControlScene scene;
  scene.number = 3;
  scene.file = "/s.json";
  scene.bodies = {{.name = "block", .fixed = true}, {.name = "peg\n", .shared = true, .moving = 0}};
  tandem_control_Scene scene_wire{};
  std::vector<tandem_control_SceneBody> scene_room;
  ToWire(scene, false, scene_wire, scene_room);

  ControllerSnapshot output;
  output.scene_number = 3;
  output.bodies.resize(2);
  output.bodies[1].in_hand = true;
  output.bodies[1].holders = {7, 9};
  output.bodies[1].X_W.p_W = {0.1, 0.2, 0.3};
  output.hand.body = 1;
  output.peers = {{.id = 9, .name = "ben", .colour = 4, .stopped = true}};
  output.colour = 2;
  output.asked = {9, 1};
  output.warnings = {"block and peg overlap", std::string(600, 'x'), "the peg is open\x1b"};
  output.contacts = {{.depth_m = 1e-4, .force_N = 2}};
  output.safety.stops = 5;
  output.news = "hello";
  tandem_control_Snapshot wire{};
  SnapshotBuffers room;
  ToWire(output, 7, wire, room);
  ControllerSnapshot read;
  ASSERT_TRUE(FromWire(wire, scene_wire, read));
  EXPECT_EQ(read.bodies[1].name, "peg?") << "nothing a terminal acts on";
  EXPECT_TRUE(read.bodies[0].fixed);
  EXPECT_TRUE(read.bodies[1].shared);
  EXPECT_EQ(read.bodies[1].holders, output.bodies[1].holders);
  EXPECT_EQ(read.bodies[1].X_W.p_W, output.bodies[1].X_W.p_W);
  ASSERT_EQ(read.peers.size(), 1U);
  EXPECT_EQ(read.peers[0].held, std::vector<std::size_t>{1});
  EXPECT_EQ(read.contacts[0].force_N, 2);
  EXPECT_EQ(read.safety.stops, 5U);
  EXPECT_EQ(read.news, "hello");
  EXPECT_EQ(read.peers[0].colour, 4);
  EXPECT_TRUE(read.peers[0].stopped);
  EXPECT_EQ(read.colour, 2);
  ASSERT_TRUE(read.asked.has_value());
  EXPECT_EQ(read.asked->peer, 9U);
  EXPECT_EQ(read.asked->body, 1U);
  // a line that is too long is cut
  EXPECT_EQ(read.warnings, (std::vector<std::string>{"block and peg overlap", std::string(512, 'x'),
                                                     "the peg is open?"}));
  EXPECT_EQ(read.self, 7U);
  wire.scene_number = 4;
  EXPECT_FALSE(FromWire(wire, scene_wire, read)) << "the names of that scene have not come yet";
}

TEST(ControlWire, TextHasNoTerminalControls) {
  // a control of C1, a mark of direction, a byte that is no UTF-8
  EXPECT_EQ(TextFromWire("\xC2\x9B"
                         "31m\xE2\x80\xAE\xff"),
            "?31m??");
  EXPECT_EQ(TextFromWire("m\xC3\xBCller\n"), "m\xC3\xBCller?");
}

}  // namespace
}  // namespace tandem
