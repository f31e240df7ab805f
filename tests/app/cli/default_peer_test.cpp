// Tests `tandem peer` as users start it, without --capacity. The peer measures before its loop what
// fits into a frame, and follows that in the loop.
#include <fstream>

#include "app/capacity/capacity.h"
#include "collab/recording/recording.h"
#include "engine/world/world_model.h"
#include "tests/app/cli/peer_program.h"

namespace tandem {
namespace {

using nlohmann::json;
using testing::ProgramOutput;
using testing::RunTandem;

/// Runs a peer alone that turns the ball in its socket for two seconds, and reads its recording.
class DefaultPeer : public testing::PeerCommand {
 protected:
  static constexpr const char* kScene = TANDEM_SCENES "/ball_and_socket.json";
  static constexpr const char* kHand = TANDEM_SCENES "/ball_and_socket_ball.json";

  ProgramOutput RunBall(const std::string& more) const {
    return RunTandem("peer --interface lo --session " + session_ + " --scene " + kScene +
                         " --hold ball --seconds 2 --hand " + kHand + " --report " + In("report") +
                         " --record " + In("recording") + " " + more,
                     "timeout 60 ");
  }
  json Report() const { return json::parse(std::ifstream(In("report")), nullptr, false); }
  std::vector<double> Capacities() const {
    std::vector<double> capacities;
    Result<RecordingReader> reader = RecordingReader::Open(In("recording"));
    EXPECT_TRUE(reader);
    if (!reader) return capacities;
    while (const auto frame = reader->Next()) capacities.push_back(frame->capacity);
    return capacities;
  }
};

TEST_F(DefaultPeer, MeasuresAndAdaptsItsCapacity) {
  const ProgramOutput output = RunBall("");
  ASSERT_EQ(output.exit_code, kExitOk) << output.err;
  const json report = Report();
  ASSERT_TRUE(report.is_object());
  const auto measured = report.at("capacity").get<double>();

  // this program measures the same machine in the same seconds
  const Result<Scene> scene = LoadScene(kScene);
  ASSERT_TRUE(scene);
  const auto model = LoadWorld(*scene);
  ASSERT_TRUE(model);
  const FrameCapacity here = MeasureCapacity(**model, kFrameBudget);
  EXPECT_GT(measured, here.tests / 4);
  EXPECT_LT(measured, 4 * here.tests);
  EXPECT_NE(measured, kDefaultCapacity);
  const auto price = report.at("look_price").get<double>();
  EXPECT_GT(price, here.query_price / 4);
  EXPECT_LT(price, 4 * here.query_price);

  const std::vector<double> capacities = Capacities();
  ASSERT_GT(capacities.size(), 2000U);
  EXPECT_EQ(capacities.front(), measured);
  // frames of hundreds of looks tell what a look costs here: the capacity leaves the measured one,
  // but stays within a factor of four of it
  EXPECT_NE(capacities.back(), measured);
  const auto [least, most] = std::ranges::minmax(capacities);
  EXPECT_GE(least, 0.25 * measured);
  EXPECT_LE(most, 4 * measured);
  EXPECT_GT(report.at("contact_points").at("max").get<int>(), 100);
}

// The capacity of each frame is an input that is kept with the others, so the run is repeated bit
// for bit.
TEST_F(DefaultPeer, ReplaysWithEachFramesCapacity) {
  ASSERT_EQ(RunBall("").exit_code, kExitOk);
  const ProgramOutput output = RunTandem("replay --json " + In("recording"), "timeout 60 ");
  EXPECT_EQ(output.exit_code, kExitOk) << output.err;
  EXPECT_EQ(json::parse(output.out, nullptr, false).at("identical"), true);
}

// The peer names the full disk at once and with the right number, and still writes its report.
TEST_F(DefaultPeer, ReportsAFullRecordingDisk) {
  // a limit of 100 KiB a file, which the recording reaches within a second
  const ProgramOutput output =
      RunTandem("peer --interface lo --session " + session_ + " --scene " + kScene +
                    " --hold ball --seconds 2 --capacity 100000 --hand " + kHand + " --report " +
                    In("report") + " --record " + In("recording"),
                "trap '' XFSZ; ulimit -f 200; timeout 60 ");
  EXPECT_EQ(output.exit_code, kExitFile) << output.err;
  auto reader = *RecordingReader::Open(In("recording"));
  int there = 0;
  while (reader.Next()) ++there;
  EXPECT_FALSE(reader.torn() || reader.damaged());
  EXPECT_GT(there, 100);
  EXPECT_THAT(
      output.err,
      ::testing::HasSubstr(In("recording") + ": cannot be written: File too large; it ends after " +
                           std::to_string(there) + " frames"));
  EXPECT_TRUE(Report().is_object());
}

TEST_F(DefaultPeer, KeepsACapacityThatIsGiven) {
  ASSERT_EQ(RunBall("--capacity 23456").exit_code, kExitOk);
  EXPECT_EQ(Report().at("capacity"), 23456);
  EXPECT_THAT(Capacities(), ::testing::Each(23456));
}

// The time is the processor time of the peer's own thread, so that a loaded machine bears on it
// only by its caches. A small part's frames take a small share of the 800 us that a frame may.
TEST_F(DefaultPeer, FramesOfASmallPartFitTheirBudget) {
  const ProgramOutput output =
      RunTandem("peer --interface lo --session " + session_ +
                    " --scene peg_in_slot --hold peg --seconds 4 --hand " TANDEM_SCENES
                    "/peg_in_slot_left.json --report " +
                    In("report"),
                "timeout 60 ");
  ASSERT_EQ(output.exit_code, kExitOk) << output.err;
  const json report = Report();
  EXPECT_GT(report.at("contact_share").get<double>(), 0.1);
  EXPECT_EQ(report.at("judged_frames"), 4000);
  EXPECT_GT(report.at("frame_cpu_us").at("p50").get<double>(), 0.0);
  EXPECT_LT(report.at("frame_cpu_us").at("p99").get<double>(), 1e6 * kFrameBudget);
}

}  // namespace
}  // namespace tandem
