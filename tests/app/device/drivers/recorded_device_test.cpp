#include "app/device/drivers/recorded/recorded_device.h"

#include <fstream>
#include <memory>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/device/open_driver.h"
#include "app/process/child_processes.h"
#include "collab/recording/recorder.h"

namespace tandem {
namespace {

/// Records a hand that goes a millimetre a frame along x.
void RecordHand(const std::filesystem::path& file, int frames) {
  RecordingHeader header;
  header.program = "test";
  header.name = "anna";
  header.scene = "none";
  header.parameters = {.voxel_size = 0.002, .contact = ContactModel::kPlain, .force_layer = 3};
  header.law = "p+d";
  header.peer.id = 1;
  Result<std::unique_ptr<Recorder>> recorder = Recorder::Create(file, header);
  ASSERT_TRUE(recorder) << recorder.error().what;
  for (int i = 0; i < frames; ++i) {
    Anchor handle;
    handle.X_WA.p.x() = 0.001 * i;
    handle.V_WA.v.x() = 1;
    (*recorder)->Begin(1'000'000 * i, 1000);
    (*recorder)->OnDevice(handle);
    (*recorder)->End(7);
  }
  ASSERT_TRUE((*recorder)->Close());
}

TEST(RecordedDevice, PlaysEachFrameOnceTheUserBeginsAndRestsAtTheEnd) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "run";
  RecordHand(file, 20);
  const auto hand = OpenDriver("recorded:" + file.string(), Pose{});
  ASSERT_TRUE(hand) << hand.error().what;
  EXPECT_EQ((*hand)->capabilities().freedoms_out, 0);
  const auto frame = [&] {
    const Anchor handle = (*hand)->Read();
    (*hand)->Render({});
    return handle;
  };
  for (int i = 0; i < 3; ++i) EXPECT_EQ(frame().X_WA.p.x(), 0);
  EXPECT_EQ(frame().V_WA.v.x(), 0);
  (*hand)->Start();
  for (int i = 0; i < 19; ++i) EXPECT_DOUBLE_EQ(frame().X_WA.p.x(), 0.001 * i);
  for (int i = 0; i < 3; ++i) {
    const Anchor handle = frame();
    EXPECT_DOUBLE_EQ(handle.X_WA.p.x(), 0.019);
    EXPECT_EQ(handle.V_WA.v.x(), 0);
  }
}

TEST(RecordedDevice, ReportsInvalidRecordings) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "text";
  std::ofstream(file) << "no recording";
  for (const std::string& requested : {std::string("recorded"), "recorded:" + file.string(),
                                       "recorded:" + (folder.path() / "none").string()}) {
    const auto hand = OpenDriver(requested, Pose{});
    ASSERT_FALSE(hand) << requested;
    EXPECT_THAT(hand.error().what, ::testing::StartsWith("recorded: "));
  }
  RecordHand(folder.path() / "empty", 0);
  const auto empty = OpenDriver("recorded:" + (folder.path() / "empty").string(), Pose{});
  ASSERT_FALSE(empty);
  EXPECT_THAT(empty.error().what, ::testing::HasSubstr("has no frame"));
}

}  // namespace
}  // namespace tandem
