#include "collab/recording/recording_export.h"

#include <cstdlib>

#include <gmock/gmock.h>

#include "collab/recording/recorder.h"
#include "collab/recording/replay.h"
#include "collab/simulated/network/simulated_session.h"
#include "engine/haptics/scripted_device.h"
#include "tests/collab/recording/mcap_reader.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/shapes.h"
#include "tests/support/test_world.h"

namespace tandem {
namespace {

using ::testing::HasSubstr;
using testing::McapReader;

constexpr int kFrames = 2000;

/// Reads a number in a message's data, which begins with four bytes that do not count for its
/// place.
double DoubleAt(const std::string& data, std::size_t place) {
  double value = 0;
  if (4 + place + sizeof value <= data.size()) {
    std::memcpy(&value, data.data() + 4 + place, sizeof value);
  } else {
    ADD_FAILURE() << "a message of " << data.size() << " bytes";
  }
  return value;
}

// sec 4, nanosec 4, length 4, "world" and its end 6, up to the next multiple of eight
constexpr std::size_t kBehindHeader = 24;

Vec3 VectorAt(const std::string& data, int number) {
  const std::size_t at = kBehindHeader + 24 * static_cast<std::size_t>(number);
  return {DoubleAt(data, at), DoubleAt(data, at + 8), DoubleAt(data, at + 16)};
}

/// Records a shared box on a plate held by two peers, exports the recording of one, and keeps what
/// that one really did.
class RecordingExportTest : public ::testing::Test {
 protected:
  RecordingExportTest() {
    const TriangleMesh plate =
        Transformed(testing::Box(Vec3(0.2, 0.2, 0.01)), {Quat::Identity(), Vec3(0, 0, -0.03)});
    auto model = std::make_shared<WorldModel>(
        *testing::MakeWorldModel({{plate, true}, {testing::Box(Vec3(0.03, 0.02, 0.02))}}, 0.002));
    model->scene.bodies[1].shared = true;
    model->scene.bodies[1].name = "the box";
    model_ = model;
    Record();
    Export();
  }

  static std::unique_ptr<PeerNode> Node(const std::shared_ptr<const WorldModel>& model, PeerId id,
                                        FrameObserver* observer) {
    NodeOptions options;
    options.peer = Header(id).peer;
    options.peer.law = *MakeLaw("p+d");
    options.peer.observer = observer;
    HandScript script;
    for (int i = 0; i <= 8; ++i) {
      script.waypoints.push_back(
          {0.25 * i, Vec3(0.01 * (id == 1 ? i % 2 : 0), 0, -0.02), Quat::Identity()});
    }
    return std::make_unique<PeerNode>(
        model, std::make_unique<ScriptedDevice>(script, model->bodies[0].X_WB0), 42, options);
  }
  static RecordingHeader Header(PeerId id) {
    RecordingHeader header;
    header.law = "p+d";
    header.peer.id = id;
    header.peer.held_object = 1;
    return header;
  }

  void Record() {
    auto recorder = *Recorder::Create(folder_.path() / "r", Header(1));
    recorder->Named(2, "ben b.");
    SimulatedSession session;
    session.Add(Node(model_, 1, recorder.get()), 1);
    session.Add(Node(model_, 2, nullptr), 2);
    for (int i = 0; i < kFrames; ++i) {
      session.Step();
      poses_.push_back(session.node(0).world().state(0).X_WB);
      reports_.push_back(session.node(0).peer().report());
    }
    ASSERT_TRUE(recorder->Close());
  }
  void Export() {
    Result<RecordingReader> reader = RecordingReader::Open(folder_.path() / "r");
    ASSERT_TRUE(reader);
    auto replay = *Replay::Create(reader->header(), model_);
    auto exported =
        *RecordingExport::Create(file(), reader->header(), *model_, NamesIn(folder_.path() / "r"));
    const ReplayResult result =
        RunAll(*reader, *replay, [&](std::int64_t, const RecordedFrame& frame) {
          exported->Add(frame, replay->node());
          return true;
        });
    ASSERT_EQ(result.frames, kFrames);
    const Result<std::uint64_t> count = exported->Close();
    ASSERT_TRUE(count);
    count_ = *count;
  }
  std::filesystem::path file() const { return folder_.path() / "out.mcap"; }

  ScratchFolder folder_;
  std::shared_ptr<const WorldModel> model_;
  std::vector<Pose> poses_;  // one for each frame
  std::vector<StepReport> reports_;
  std::uint64_t count_ = 0;
};

TEST_F(RecordingExportTest, IsAnMcapFileByTheSpecification) {
  const McapReader read(file());
  ASSERT_TRUE(read.whole);
  EXPECT_EQ(read.profile, "ros2");
  EXPECT_EQ(read.messages.size(), count_);
  EXPECT_GE(read.chunks, 2);
  std::uint64_t before = 0;
  std::map<std::uint16_t, std::uint32_t> next;
  for (const McapReader::Message& message : read.messages) {
    EXPECT_LE(before, message.log_ns);
    before = message.log_ns;
    EXPECT_EQ(message.publish_ns, message.log_ns);
    EXPECT_EQ(message.sequence, next[message.channel]++);
  }
  for (const auto& [id, channel] : read.channels) EXPECT_EQ(channel.encoding, "cdr");
  for (const auto& [id, schema] : read.schemas) EXPECT_EQ(schema.encoding, "ros2msg");
  EXPECT_THAT(read.schemas.at(1).text, HasSubstr("geometry_msgs/Pose pose"));
}

TEST_F(RecordingExportTest, HasEachFramesPosesAndForcesToTheLastBit) {
  const McapReader read(file());
  ASSERT_TRUE(read.whole);
  const auto poses = read.MessagesOf("/bodies/the_box/pose");
  const auto hand = read.MessagesOf("/hand/wrench");
  const auto contact = read.MessagesOf("/contact/wrench");
  ASSERT_EQ(poses.size(), std::size_t{kFrames});
  EXPECT_EQ(read.TypeOf("/bodies/the_box/pose"), "geometry_msgs/msg/PoseStamped");
  EXPECT_EQ(read.TypeOf("/hand/wrench"), "geometry_msgs/msg/WrenchStamped");
  EXPECT_EQ(read.MessagesOf("/bodies/the_box/twist").size(), std::size_t{kFrames});
  EXPECT_EQ(read.MessagesOf("/hand/pose").size(), std::size_t{kFrames});
  ASSERT_EQ(hand.size(), contact.size());
  ASSERT_GT(hand.size(), std::size_t{kFrames / 2});
  for (std::size_t i = 0; i < poses.size(); ++i) {
    ASSERT_EQ(VectorAt(poses[i].data, 0), poses_[i].p) << "frame " << i;
    const std::size_t q = kBehindHeader + 24;
    ASSERT_EQ(DoubleAt(poses[i].data, q + 24), poses_[i].q.w());
    ASSERT_EQ(poses[i].data.size(), 4 + q + 32);
  }
  double largest = 0;
  const std::size_t first = poses.size() - hand.size();  // the body is in hand from there on
  for (std::size_t i = 0; i < hand.size(); ++i) {
    ASSERT_EQ(hand[i].log_ns, poses[first + i].log_ns);
    ASSERT_EQ(VectorAt(hand[i].data, 0), reports_[first + i].hand_B_W.f);
    ASSERT_EQ(VectorAt(hand[i].data, 1), reports_[first + i].hand_B_W.tau);
    ASSERT_EQ(VectorAt(contact[i].data, 0), reports_[first + i].contact_B_W.f);
    largest = std::max(largest, VectorAt(contact[i].data, 0).norm());
  }
  EXPECT_GT(largest, 0.5) << "there was contact";
}

TEST_F(RecordingExportTest, ContainsLinksAndReceivedStates) {
  const McapReader read(file());
  ASSERT_TRUE(read.whole);
  const std::string other = "ben_b_";  // an underscore stands for what a topic may not have
  EXPECT_GT(read.MessagesOf("/peers/" + other + "/the_box/pose").size(), std::size_t{kFrames / 2});
  const auto links = read.MessagesOf("/links/" + other + "/wrench");
  const auto stiffness = read.MessagesOf("/links/" + other + "/stiffness");
  ASSERT_GT(links.size(), std::size_t{kFrames / 2});
  ASSERT_EQ(stiffness.size(), links.size());
  EXPECT_EQ(VectorAt(links.back().data, 0), reports_.back().links_B_W[0].f);
  EXPECT_GT(VectorAt(links.back().data, 0).norm(), 0.0);
  EXPECT_GT(DoubleAt(stiffness.back().data, 0), 1.0);
  const auto events = read.MessagesOf("/events");
  ASSERT_FALSE(events.empty());
  EXPECT_EQ(read.TypeOf("/events"), "std_msgs/msg/String");
  EXPECT_THAT(events.front().data, HasSubstr(other + " joined"));
}

TEST_F(RecordingExportTest, IsReadableByThePythonPackage) {
  if (std::system("python3 -c 'import mcap.reader' 2>/dev/null") != 0) {
    GTEST_SKIP() << "the Python package mcap is not here";
  }
  const std::string script =
      "import sys, mcap.reader\n"
      "r = mcap.reader.make_reader(open(sys.argv[1], 'rb'), validate_crcs=True)\n"
      "n = sum(1 for _ in r.iter_messages())\n"
      "sys.exit(0 if n == r.get_summary().statistics.message_count == int(sys.argv[2]) else 1)\n";
  const std::string command = "python3 " + folder_.Write("read.py", script).string() + " " +
                              file().string() + " " + std::to_string(count_);
  EXPECT_EQ(std::system(command.c_str()), 0);
}

TEST(RecordingExport, NamesTheFileThatItCannotWrite) {
  const auto exported = RecordingExport::Create("/nowhere/out.mcap", {}, WorldModel{});
  ASSERT_FALSE(exported);
  EXPECT_THAT(exported.error().what, HasSubstr("/nowhere/out.mcap"));
}

}  // namespace
}  // namespace tandem
