// Tests what the drivers `mouse` and `keyboard` list, with plain files in place of the kernel's.
#include "app/device/drivers/event_source.h"

#include <array>
#include <fstream>
#include <string>

#include <gtest/gtest.h>
#include <sys/stat.h>

#include "tests/support/scratch_folder.h"

namespace tandem::testing {
namespace {

using driver::EventSource;

/// Returns whether a file is of the kind: it is if it is not empty.
bool HasBytes(int file) {
  struct stat facts {};
  return fstat(file, &facts) == 0 && facts.st_size > 0;
}

class EventSourceList : public ::testing::Test {
 protected:
  void Put(const std::string& name, const std::string& text) const {
    std::ofstream(folder_.path() / name) << text;
  }
  std::int32_t List(std::int32_t room = 4) {
    found_ = {};
    return EventSource::List(found_.data(), room, HasBytes, "mouse", folder_.path().string());
  }
  std::string Path(const std::string& name) const {
    return "path=" + (folder_.path() / name).string();
  }

  const ScratchFolder folder_;
  std::array<TandemDeviceFound, 4> found_{};
};

TEST_F(EventSourceList, NamesSeveralDevicesByTheirOptions) {
  Put("event1", "mouse");
  Put("event2", "");
  Put("event3", "mouse");
  Put("js0", "mouse");
  ASSERT_EQ(List(), 2);
  EXPECT_EQ(found_[0].present, 1U);
  EXPECT_EQ(found_[1].present, 1U);
  EXPECT_EQ(found_[0].options, Path("event1"));
  EXPECT_EQ(found_[1].options, Path("event3"));
}

TEST_F(EventSourceList, SingleDeviceNeedsNoOption) {
  Put("event1", "");
  Put("event2", "mouse");
  ASSERT_EQ(List(), 1);
  EXPECT_EQ(found_[0].present, 1U);
  EXPECT_STREQ(found_[0].options, "");
}

TEST_F(EventSourceList, ReportsMissingDevicesInOneEntry) {
  Put("event1", "");
  ASSERT_EQ(List(), 1);
  EXPECT_EQ(found_[0].present, 0U);
  EXPECT_EQ(found_[0].missing, "there is no mouse at " + folder_.path().string());
}

TEST_F(EventSourceList, NeverExceedsItsCapacity) {
  for (const char* name : {"event1", "event2", "event3"}) Put(name, "mouse");
  ASSERT_EQ(List(2), 2);
  EXPECT_EQ(found_[0].options, Path("event1"));
  EXPECT_EQ(found_[2].present, 0U);
  EXPECT_EQ(List(0), 0);
}

}  // namespace
}  // namespace tandem::testing
