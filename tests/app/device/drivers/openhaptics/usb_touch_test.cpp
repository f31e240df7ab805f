// Tests what the kernel shows of a Touch at USB, in a folder like /sys and /dev.
#include "app/device/drivers/openhaptics/usb_touch.h"

#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/scratch_folder.h"

namespace tandem::driver {
namespace {

using ::testing::HasSubstr;

void WriteTo(const std::filesystem::path& file, const char* text) {
  std::filesystem::create_directories(file.parent_path());
  std::ofstream(file) << text;
}

TEST(UsbTouch, InaccessibleTouchIsReported) {
  const ScratchFolder root;
  EXPECT_FALSE(FindUsbTouch(root.path()).is_plugged);
  WriteTo(root.path() / "sys/class/tty/ttyACM0/idVendor", "1d6b\n");
  std::filesystem::create_directory(root.path() / "sys/class/tty/ttyACM0/device");
  EXPECT_FALSE(FindUsbTouch(root.path()).is_plugged);
  WriteTo(root.path() / "sys/class/tty/ttyACM1/idVendor", "2988\n");
  std::filesystem::create_directory(root.path() / "sys/class/tty/ttyACM1/device");
  const UsbTouch refused = FindUsbTouch(root.path());
  EXPECT_TRUE(refused.is_plugged);
  EXPECT_THAT(refused.refused, HasSubstr("dev/ttyACM1"));
  EXPECT_THAT(refused.mend, HasSubstr("dialout"));
  WriteTo(root.path() / "dev/ttyACM1", "");
  const UsbTouch allowed = FindUsbTouch(root.path());
  EXPECT_TRUE(allowed.is_plugged);
  EXPECT_EQ(allowed.refused, "");
  EXPECT_EQ(allowed.mend, "");
}

TEST(UsbTouch, TouchIsFoundAmongOtherHidDevices) {
  const ScratchFolder root;
  WriteTo(root.path() / "sys/class/hidraw/hidraw0/device/uevent",
          "DRIVER=hid-generic\nHID_ID=0003:0000046D:0000C52B\n");
  EXPECT_FALSE(FindUsbTouch(root.path()).is_plugged);
  WriteTo(root.path() / "sys/class/hidraw/hidraw3/device/uevent",
          "DRIVER=hid-generic\nHID_ID=0003:00002988:00000302\n");
  const UsbTouch refused = FindUsbTouch(root.path());
  EXPECT_TRUE(refused.is_plugged);
  EXPECT_THAT(refused.refused, HasSubstr("dev/hidraw3"));
  EXPECT_THAT(refused.mend, HasSubstr("udev"));
}

}  // namespace
}  // namespace tandem::driver
