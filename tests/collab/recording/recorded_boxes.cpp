#include "tests/collab/recording/recorded_boxes.h"

#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "collab/simulated/network/simulated_session.h"
#include "engine/haptics/scripted_device.h"
#include "tests/support/shapes.h"
#include "tests/support/test_world.h"

namespace tandem::testing {

namespace fs = std::filesystem;

namespace {

// Returns a hand that goes to and fro, down into the plate and turned, for ever.
HandScript Kneading(double phase) {
  HandScript script;
  for (int i = 0; i <= 1200; ++i) {
    const double t = 0.25 * i;
    script.waypoints.push_back({t, Vec3(0.03 * std::sin(t + phase), 0.01 * std::cos(2 * t), -0.02),
                                RotationBy(Vec3(0, 0, 0.3 * std::sin(3 * t + phase)))});
  }
  return script;
}

}  // namespace

std::shared_ptr<const WorldModel> Boxes() {
  const auto box_at = [](double x) {
    return Transformed(Box(Vec3(0.03, 0.02, 0.02)), {Quat::Identity(), Vec3(x, 0, 0)});
  };
  const TriangleMesh plate =
      Transformed(Box(Vec3(0.2, 0.2, 0.01)), {Quat::Identity(), Vec3(0, 0, -0.03)});
  auto model = std::make_shared<WorldModel>(
      *MakeWorldModel({{plate, true}, {box_at(0)}, {box_at(0.07)}}, 0.002));
  model->scene.bodies[1].shared = true;
  return model;
}

RecordingHeader HeaderOf(PeerId id, int object) {
  RecordingHeader header;
  header.program = "test";
  header.name = "peer " + std::to_string(id);
  header.scene = "none";
  header.scene_hash = 42;
  header.parameters = {
      .voxel_size = 0.002, .contact = ContactModel::kPlain, .force_layer = 3, .friction = 0.25};
  header.law = "p+d";
  header.peer.id = id;
  header.peer.held_object = object;
  header.peer.settle_ns = 123'456'789;
  header.peer.wait_for = 1;
  header.peer.capacity = 12345.678901234567;
  header.peer.query_price = 98.765432109876543;
  header.peer.X_BD = {RotationBy(Vec3(0.1, 0.2, 0.3)), Vec3(0.001, -0.002, 1.0 / 3.0 * 0.01)};
  return header;
}

std::unique_ptr<PeerNode> NodeOf(const std::shared_ptr<const WorldModel>& model,
                                 const RecordingHeader& header, FrameObserver* observer,
                                 double phase) {
  NodeOptions options;
  options.peer = header.peer;
  options.peer.law = *MakeLaw(header.law, header.limits, true);
  options.peer.observer = observer;
  options.name = header.name;
  options.conditions = {.delay_ms = 40, .jitter_ms = 20, .loss = 0.05};
  HandScript script = Kneading(phase);
  script.X_BD = header.peer.X_BD;
  const auto body = static_cast<std::size_t>(
      model->body_index[static_cast<std::size_t>(header.peer.held_object)]);
  return std::make_unique<PeerNode>(
      model, std::make_unique<ScriptedDevice>(script, model->bodies[body].X_WB0), 42, options);
}

std::unique_ptr<Recorder> Record(const fs::path& file, const RecordingHeader& header) {
  Result<std::unique_ptr<Recorder>> recorder = Recorder::Create(file, header);
  EXPECT_TRUE(recorder.has_value()) << recorder.error().what;
  return *std::move(recorder);
}

ReplayResult ReplayFile(const fs::path& file, const std::shared_ptr<const WorldModel>& model) {
  Result<RecordingReader> reader = RecordingReader::Open(file);
  EXPECT_TRUE(reader.has_value()) << reader.error().what;
  Result<std::unique_ptr<Replay>> replay = Replay::Create(reader->header(), model);
  EXPECT_TRUE(replay.has_value()) << replay.error().what;
  return RunAll(*reader, **replay);
}

void RecordAlone(const fs::path& file, const std::shared_ptr<const WorldModel>& model, int frames,
                 const std::function<void(Peer&, int)>& before) {
  const RecordingHeader header = HeaderOf(1, 1);
  const std::unique_ptr<Recorder> recorder = Record(file, header);
  SimulatedSession session;
  session.Add(NodeOf(model, header, recorder.get(), 0), 1);
  session.Add(NodeOf(model, HeaderOf(2, 1), nullptr, 1), 2);
  for (int i = 0; i < frames; ++i) {
    if (before) before(session.node(0).peer(), i);
    session.Step();
  }
  ASSERT_TRUE(recorder->Close().has_value());
}

bool DiffersWith(const fs::path& file, const std::shared_ptr<const WorldModel>& model,
                 const std::function<void(RecordedFrame&, int)>& alter) {
  Result<RecordingReader> reader = RecordingReader::Open(file);
  EXPECT_TRUE(reader.has_value());
  Result<std::unique_ptr<Replay>> replay = Replay::Create(reader->header(), model);
  EXPECT_TRUE(replay.has_value());
  bool differs = false;
  for (int i = 0; std::optional<RecordedFrame> frame = reader->Next(); ++i) {
    alter(*frame, i);
    differs = (*replay)->Run(*frame) != frame->state_hash || differs;
  }
  return differs;
}

}  // namespace tandem::testing
